//! Splits a state: the second part of a codel gets a state of its own.

use dotgen_syntax::ast::{self, AstNode};

use super::{Assist, AssistKind, Cx};

/// `codel<a> f() yield b;` → `codel<a> f() yield a_next; codel<a_next> f_next() yield b;`
pub(super) fn split_codel(cx: &Cx<'_, '_>) -> Option<Assist> {
    let codel: ast::Codel = cx.ancestor()?;
    let property = ast::CodelProperty::cast(codel.syntax().parent()?)?;
    let (triggers, yields) = (codel.triggers()?, codel.yields()?);
    let (name, params) = (codel.name()?, codel.param_list()?);
    if !cx.is_plain(property.syntax()) {
        return None;
    }
    let map = cx.view.map();
    let first = triggers.states().next()?.name_ref()?.text(map);
    let state = cx.unused_name(&format!("{first}_next"));
    let function = cx.unused_name(&format!("{}_next", name.text(map)));
    let states: Vec<_> = yields.states().collect();
    let (from, to) = (states.first()?, states.last()?);
    let targets = cx.node_range(from.syntax()).start..cx.node_range(to.syntax()).end;
    let whole = cx.node_range(property.syntax());
    let params_range = cx.node_range(params.syntax());
    // The text from the parameters on stays unchanged: line ends, targets, execution time.
    let rest = cx.slice(params_range.start..whole.end);
    let word = if property.is_async() {
        "async codel"
    } else {
        "codel"
    };
    let indent = cx.indent(whole.start).to_owned();
    let second = format!("\n{indent}{word}<{state}> {function}{rest}");
    Some(Assist {
        id: "split-codel",
        title: format!("Split state `{first}` in two"),
        kind: AssistKind::Rewrite,
        edits: vec![
            cx.edit(targets, state.as_str()),
            cx.edit(whole.end..whole.end, second),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{check, refused};

    #[test]
    fn the_second_part_leads_where_the_first_did() {
        check(
            "split-codel",
            "component c {
  ids { long x; };
  task t {
    codel<start> f$0(out x)
      yield pause::start, ether;
  };
};
",
            "component c {
  ids { long x; };
  task t {
    codel<start> f(out x)
      yield start_next;
    codel<start_next> f_next(out x)
      yield pause::start, ether;
  };
};
",
        );
    }

    #[test]
    fn simple_codels_have_no_state() {
        refused(
            "split-codel",
            "component c { function f() { codel g$0(); }; };\n",
        );
    }
}
