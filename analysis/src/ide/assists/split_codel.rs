//! One state in two: a new codel comes first, and leads to the one that was there, in a state of its own.

use dotgen_syntax::ast::{self, AstNode};

use super::{Assist, AssistKind, Cx};

/// `codel<a> f() yield b;` → `codel<a> f_first() yield a_next; codel<a_next> f() yield b;`
///
/// The function that was there keeps its name and what it returns, so that sources only need a function for
/// the new codel.
pub(super) fn split_codel(cx: &Cx<'_, '_>) -> Option<Assist> {
    let codel: ast::Codel = cx.ancestor()?;
    let property = ast::CodelProperty::cast(codel.syntax().parent()?)?;
    let (triggers, yields) = (codel.triggers()?, codel.yields()?);
    let name = codel.name()?;
    if !cx.is_plain(property.syntax()) {
        return None;
    }
    let map = cx.view.map();
    let first = triggers.states().next()?.name_ref()?.text(map);
    let state = cx.unused_name(&format!("{first}_next"));
    let function = cx.unused_name(&format!("{}_first", name.text(map)));
    let states: Vec<_> = triggers.states().collect();
    let (from, to) = (states.first()?, states.last()?);
    let bound = cx.node_range(from.syntax()).start..cx.node_range(to.syntax()).end;
    let targets: Vec<_> = yields.states().collect();
    let (from, to) = (targets.first()?, targets.last()?);
    let targets = cx.node_range(from.syntax()).start..cx.node_range(to.syntax()).end;
    let whole = cx.node_range(property.syntax());
    let name = cx.node_range(name.syntax());
    // Everything else is as it was: line ends, parameters, execution time.
    let head = cx.slice(whole.start..name.start);
    let middle = cx.slice(name.end..targets.start);
    let tail = cx.slice(targets.end..whole.end);
    let indent = cx.indent(whole.start).to_owned();
    let new = format!("{head}{function}{middle}{state}{tail}\n{indent}");
    Some(Assist {
        id: "split-codel",
        title: format!("Split state `{first}` in two"),
        kind: AssistKind::Rewrite,
        edits: vec![cx.edit(whole.start..whole.start, new), cx.edit(bound, state.as_str())],
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    #[test]
    fn the_codel_that_was_there_comes_second() {
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
    codel<start> f_first(out x)
      yield start_next;
    codel<start_next> f(out x)
      yield pause::start, ether;
  };
};
",
        );
    }

    #[test]
    fn simple_codels_have_no_state() {
        assert_not_offered("split-codel", "component c { function f() { codel g$0(); }; };\n");
    }
}
