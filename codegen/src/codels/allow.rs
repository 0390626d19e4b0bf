//! Findings allowed by a comment in a source: `// dotgen: allow(code, …) because …`, as in
//! specifications. It speaks of the function that begins below it, or of the one around it.

use std::ops::Range;

use dotgen_analysis::codes::CODEL;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::{Analysis, Cancellable};

use super::command::{Side, diagnostics};
use super::drift::{Drift, DriftCode};
use super::expected::Expected;
use super::files::IndexedFile;
use super::folder::Folder;
use super::source::Function;

const MARK: &str = "dotgen:";

/// A code that a comment allows.
struct Allowance<'a> {
    code: &'a str,
    /// Where the code stands.
    range: Range<usize>,
    function: &'a Function,
    /// Where findings are allowed.
    scope: Range<usize>,
}

fn allowances(file: &IndexedFile) -> Vec<Allowance<'_>> {
    let mut out = Vec::new();
    // Most files have none.
    if !file.text.contains(MARK) {
        return out;
    }
    for function in &file.index.functions {
        let comments = function.comments.iter().map(|it| it.span.start);
        let scope = comments.min().unwrap_or(function.span.start)..function.span.end;
        let text = file.text.get(scope.clone()).unwrap_or_default();
        for (at, mark) in text.match_indices(MARK) {
            let rest = text[at + mark.len()..].trim_start();
            let list = rest.strip_prefix("allow(");
            let Some((list, _)) = list.and_then(|it| it.split_once(')')) else {
                continue;
            };
            let mut start = scope.end - rest.len() + "allow(".len();
            for piece in list.split(',') {
                let code = piece.trim();
                let from = start + (piece.len() - piece.trim_start().len());
                out.push(Allowance {
                    code,
                    range: from..from + code.len(),
                    function,
                    scope: scope.clone(),
                });
                start += piece.len() + 1;
            }
        }
    }
    out
}

/// Whether a comment of a source allows a code at an offset.
pub fn is_allowed(file: &IndexedFile, offset: usize, code: &str) -> bool {
    let all = allowances(file);
    let mut here = all.iter().filter(|it| it.scope.contains(&offset));
    here.any(|it| it.code == code)
}

/// Comments that allow what no finding is, in specifications and sources. `compared` are folders with
/// all they differ in, allowed or not.
///
/// # Errors
/// When the answer is not wanted any more.
pub fn unused(
    compared: &[(&Folder, &[Drift])],
    analysis: &Analysis,
) -> Cancellable<Vec<Diagnostic>> {
    let mut out: Vec<Diagnostic> = Vec::new();
    let known = DriftCode::ALL.map(DriftCode::as_str);
    // What is not seen completely may have what a comment allows.
    let seen = |it: &Folder| it.sources.exists && !it.sources.incomplete;
    let compared = || compared.iter().filter(|it| seen(it.0));
    for (folder, findings) in compared() {
        let found = diagnostics(findings, &*folder.unit.locations, Side::Both);
        let specification = &folder.specification;
        let unused = analysis.unused_allowances(specification, CODEL, &known, &found)?;
        out.extend(unused);
        let expected = folder.expected();
        for file in folder.sources.all() {
            for it in allowances(file) {
                let has = |found: &&Drift| {
                    let place = found.source.as_ref().filter(|at| at.path == file.path);
                    found.code.as_str() == it.code
                        && place.is_some_and(|at| it.scope.contains(&at.range.start))
                };
                // A function that no specification here names may be the business of another.
                let speaks = it.code.starts_with(CODEL) && names(&expected, &it.function.name);
                if !speaks
                    || analysis.is_off(it.code)?
                    || compared().flat_map(|it| it.1).any(|it| has(&it))
                {
                    continue;
                }
                let known = known.contains(&it.code);
                out.push(Analysis::unused_allowance(
                    it.code, known, &file.path, it.range,
                ));
            }
        }
    }
    analysis.adjusted(out)
}

fn names(expected: &[Expected<'_>], function: &str) -> bool {
    let mut functions = expected.iter().flat_map(|it| &it.functions);
    functions.any(|it| it.name == function)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_speaks_of_one_function() {
        let text = "// dotgen: allow(codel/orphan, a) kept for old scripts\nint f(void) { return 1; }\n\
                    int g(void) { /* dotgen: allow(b) sure */ return 2; }\nint h(void) { return 3; }\n";
        let file = IndexedFile::new("a.c".into(), text.into(), false);
        let allowed =
            |name: &str, code| is_allowed(&file, text.find(name).expect("it is there"), code);
        assert!(allowed("f(", "codel/orphan"));
        assert!(allowed("f(", "a"));
        assert!(!allowed("f(", "b"));
        assert!(allowed("g(", "b"));
        assert!(!allowed("g(", "a"));
        assert!(!allowed("h(", "b"));
    }
}
