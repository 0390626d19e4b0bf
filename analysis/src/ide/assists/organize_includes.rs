//! Sorts includes and removes duplicates.

use dotgen_syntax::directive::{DirectiveKind, IncludeForm};

use super::{Assist, AssistKind, Cx};
use crate::{ide::speculate::compare, source_map::bytes};

/// Sorts each run of include lines: the search path first, then by name; duplicates are removed. If the order
/// matters, because a declaration must come before its use, it stays.
pub(super) fn organize_includes(cx: &Cx<'_, '_>, anywhere: bool) -> Option<Assist> {
    let mut edits = Vec::new();
    for run in runs(cx) {
        let (first, last) = (run.first()?, run.last()?);
        let range = first.start..last.end;
        if !anywhere && (range.start > cx.range.end || cx.range.start > range.end) {
            continue;
        }
        let mut sorted: Vec<&Include> = run.iter().collect();
        sorted.sort_by_key(|run| (!run.angled, &run.path));
        sorted.dedup_by_key(|run| (run.angled, run.path.clone()));
        let lines = sorted.iter().map(|run| cx.slice(run.start..run.end));
        let new = lines.collect::<Vec<_>>().join("\n");
        if new == cx.slice(range.clone()) {
            continue;
        }
        let edit = cx.edit(range, new);
        let differs = compare(cx.view.db, std::slice::from_ref(&edit), |_, comparison| {
            let same = comparison.new_errors.is_empty()
                && comparison.before.definitions.len() == comparison.after.definitions.len();
            (!same).then_some(())
        });
        if differs.is_empty() {
            edits.push(edit);
        }
    }
    (!edits.is_empty()).then(|| Assist {
        id: "organize-includes",
        title: "Organize includes".to_owned(),
        kind: AssistKind::OrganizeIncludes,
        edits,
    })
}

/// An include line, its comment included.
struct Include {
    start: usize,
    end: usize,
    angled: bool,
    path: String,
}

/// Runs of includes on consecutive lines.
fn runs(cx: &Cx<'_, '_>) -> Vec<Vec<Include>> {
    let text = cx.view.text();
    let mut out: Vec<Vec<Include>> = Vec::new();
    for directive in cx.view.pre().directives.iter().filter(|directive| directive.active) {
        let DirectiveKind::Include(operand) = &directive.kind else {
            continue;
        };
        let (angled, path) = match &operand.form {
            IncludeForm::Quoted(path) => (false, path.to_string()),
            IncludeForm::Angled(path) => (true, path.to_string()),
            IncludeForm::Macro(_) => continue,
        };
        let range = bytes(directive.range);
        let line_end = text[range.end..].find('\n').map_or(text.len(), |rest| range.end + rest);
        let rest = text[range.end..line_end].trim_end_matches('\r').trim_end();
        // A comment that continues on the next line cannot be moved.
        if rest.contains("/*") && !rest.contains("*/") {
            continue;
        }
        let include = Include { start: range.start, end: range.end + rest.len(), angled, path };
        match out.last_mut() {
            Some(run)
                if run.last().is_some_and(|run| {
                    let between = text.get(run.end..include.start).unwrap_or("x");
                    between.trim().is_empty() && between.matches('\n').count() == 1
                }) =>
            {
                run.push(include);
            }
            _ => out.push(vec![include]),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use crate::test_support::Fixture;

    #[track_caller]
    fn organized(text: &str) -> Option<String> {
        let fixture = Fixture::new(text);
        let path = camino::Utf8Path::new("/main.gen");
        let found = fixture.analysis().organize_includes(path).unwrap()?;
        Some(crate::ide::speculate::apply(&fixture.text("/main.gen"), &found.edits))
    }

    #[test]
    fn sorted_and_once() {
        let files = "//- /b.idl\n#ifndef B\n#define B\ntypedef long b;\n#endif\n//- /a.idl\ntypedef long a;\n";
        let main = "//- /main.gen\n#include \"b.idl\"  // of b\n#include \"b.idl\"\n#include \"a.idl\"\ncomponent c;\n";
        assert_eq!(
            organized(&format!("{main}{files}")).as_deref(),
            Some("#include \"a.idl\"\n#include \"b.idl\"  // of b\ncomponent c;\n")
        );
    }

    #[test]
    fn not_where_the_order_matters() {
        let files = "//- /b.idl\ntypedef long b;\n//- /a.idl\ntypedef b a;\n";
        let main = "//- /main.gen\n#include \"b.idl\"\n#include \"a.idl\"\n";
        assert_eq!(organized(&format!("{main}{files}")), None);
    }
}
