//! Converts an execution time between its three forms: the `wcet` clause, the bare duration of the GenoM3
//! paper, and the pragma that the reference compiler ignores (language reference, section 17.4).

use dotgen_syntax::ast::{self, AstNode};
use dotgen_syntax::line_index::line_start;

use super::{Assist, AssistKind, Cx};
use crate::ide::speculate::compare;

/// `codel<a> f() yield b wcet 4 us;` ↔ `… yield b 4 us;` ↔ `#pragma wcet f 4 us`
pub(super) fn convert_wcet(cx: &Cx<'_, '_>) -> Vec<Assist> {
    let mut out = Vec::new();
    if let Some(directive) = cx.ancestor::<ast::Directive>() {
        out.extend(into_clause(cx, &directive));
        return out;
    }
    let Some(codel) = cx.ancestor::<ast::Codel>() else {
        return out;
    };
    let mut clauses = codel.wcets();
    let (Some(clause), None) = (clauses.next(), clauses.next()) else {
        return out;
    };
    let Some(quantity) = clause.quantity() else {
        return out;
    };
    if !cx.is_plain(codel.syntax()) {
        return out;
    }
    let range = cx.node_range(clause.syntax());
    let duration = cx.text(quantity.syntax()).to_owned();
    let rewrite = |id, title: &str, edits| Assist {
        id,
        title: title.to_owned(),
        kind: AssistKind::Rewrite,
        edits,
    };
    if clause.is_bare() {
        let edits = vec![cx.edit(range.clone(), format!("wcet {duration}"))];
        out.push(rewrite("wcet-clause", "Write as a `wcet` clause", edits));
    } else if codel.yields().is_some_and(|yields| {
        // A duration without the word must follow the states and have a unit.
        cx.node_range(yields.syntax()).end <= range.start
    }) && quantity.unit_token().is_some()
    {
        let edits = vec![cx.edit(range.clone(), duration.clone())];
        out.push(rewrite("wcet-bare", "Write as a bare duration", edits));
    }
    out.extend(into_pragma(cx, &codel, range, &duration, &quantity).map(|edits| {
        rewrite("wcet-pragma", "Write as `#pragma wcet`, which other tools ignore", edits)
    }));
    out
}

/// The pragma goes above the declaration, at the start of a line.
fn into_pragma(
    cx: &Cx<'_, '_>,
    codel: &ast::Codel,
    clause: std::ops::Range<usize>,
    duration: &str,
    quantity: &ast::Quantity,
) -> Option<Vec<crate::diagnostic::FileEdit>> {
    quantity.unit_token()?;
    let map = cx.view.map();
    let name = codel.name()?.text(map);
    let item = cx.node_range(&codel.syntax().parent()?);
    let text = cx.view.text();
    let line = line_start(text, item.start);
    if !text[line..item.start].trim().is_empty() {
        return None;
    }
    // One line: a pragma ends with its line.
    let duration = duration.split_whitespace().collect::<Vec<_>>().join(" ");
    let pragma = format!("#pragma wcet {name} {duration}\n");
    let without = |clause: std::ops::Range<usize>| {
        let blanks = text[..clause.start].len() - text[..clause.start].trim_end().len();
        cx.edit(clause.start - blanks..clause.end, "")
    };
    let mut edits = vec![cx.edit(line..line, pragma), without(clause.clone())];
    // The pragma is about the function: no other use of the function may have a clause.
    for other in cx.view.root().descendants().filter_map(ast::Codel::cast) {
        let clauses = other.wcets().map(|wcet| cx.node_range(wcet.syntax()));
        if other.name().is_some_and(|other| other.text(map) == name) {
            let others: Vec<_> = clauses.filter(|range| *range != clause).collect();
            // Different times cannot be merged into one.
            if others.iter().any(|range| cx.slice(range.clone()) != cx.slice(clause.clone())) {
                return None;
            }
            edits.extend(others.into_iter().map(without));
        }
    }
    let wrong = compare(cx.view.db, &edits, |_, comparison| {
        (!comparison.new_errors.is_empty()).then_some(())
    });
    wrong.is_empty().then_some(edits)
}

/// Moves the time into a clause at the end of the codel, and removes the line of the pragma.
fn into_clause(cx: &Cx<'_, '_>, pragma: &ast::Directive) -> Option<Assist> {
    let map = cx.view.map();
    let mut words = pragma.syntax().children().filter_map(ast::NameRef::cast);
    words.next().filter(|word| word.text(map) == "wcet")?;
    let name = words.next()?.text(map);
    let duration = cx.text(pragma.quantity()?.syntax()).to_owned();
    let root = cx.view.root();
    let codels = root.descendants().filter_map(ast::Codel::cast);
    let mut named =
        codels.filter(|codel| codel.name().is_some_and(|other| other.text(map) == name));
    // If a codel has several declarations, the choice is ambiguous.
    let (Some(codel), None) = (named.next(), named.next()) else {
        return None;
    };
    if codel.wcets().next().is_some() || !cx.is_plain(codel.syntax()) {
        return None;
    }
    let end = cx.node_range(codel.syntax()).end;
    Some(Assist {
        id: "wcet-clause",
        title: "Write as a `wcet` clause".to_owned(),
        kind: AssistKind::Rewrite,
        edits: vec![
            cx.edit(cx.whole_lines(cx.node_range(pragma.syntax())), ""),
            cx.edit(end..end, format!(" wcet {duration}")),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    fn codel(before: &str, clause: &str) -> String {
        format!(
            "component c {{\n  task t {{\n    period 5 ms;\n{before}    codel<start> f() yield ether{clause};\n  }};\n}};\n"
        )
    }

    #[test]
    fn each_form_becomes_each_other() {
        let clause = codel("", " wcet 4 us");
        let bare = codel("", " 4 us");
        let pragma = codel("#pragma wcet f 4 us\n", "");
        let at = |text: &str, what: &str| text.replacen(what, &format!("{what}$0"), 1);
        check("wcet-bare", &at(&clause, "wcet 4"), &bare);
        check("wcet-pragma", &at(&clause, "codel"), &pragma);
        check("wcet-clause", &at(&bare, "ether"), &clause);
        check("wcet-pragma", &at(&bare, "ether"), &pragma);
        check("wcet-clause", &at(&pragma, "wcet f"), &clause);
    }

    #[test]
    fn a_simple_codel_has_no_bare_form() {
        let text = "component c {\n  function f() {\n    codel g() $0wcet 4 us;\n  };\n};\n";
        assert_not_offered("wcet-bare", text);
        let pragma =
            "component c {\n  function f() {\n#pragma wcet g 4 us\n    codel g();\n  };\n};\n";
        check("wcet-pragma", text, pragma);
    }

    #[test]
    fn a_pragma_replaces_the_clauses_of_all_uses() {
        let two = |before: &str, clause: &str| {
            let task = |name: &str| {
                format!(
                    "  task {name} {{\n{before}    codel<start> f() yield ether{clause};\n  }};\n"
                )
            };
            let second = task("u").replace(before, "");
            format!("component c {{\n{}{second}}};\n", task("t"))
        };
        let clauses = two("", " wcet 4 us").replacen("wcet 4", "wcet$0 4", 1);
        check("wcet-pragma", &clauses, &two("#pragma wcet f 4 us\n", ""));
    }

    #[test]
    fn a_pragma_for_nobody_or_for_two_stays() {
        assert_not_offered("wcet-clause", "#pragma wcet$0 nobody 4 us\n");
        assert_not_offered(
            "wcet-clause",
            "component c {\n  task t { codel<start> f() yield ether; };\n  task u { codel<start> f() yield ether; };\n};\n#pragma wcet$0 f 4 us\n",
        );
    }
}
