//! Findings that a comment in a source allows: `// dotgen: allow(code, …) because …`, as in specifications.
//! The comment applies to the function that begins below it, or to the one around it.

use std::ops::Range;

use super::files::IndexedFile;
use super::source::Function;

const MARK: &str = "dotgen:";

/// A code that a comment allows.
pub(super) struct Allowance<'a> {
    pub(super) code: &'a str,
    /// The place of the code in the comment.
    pub(super) range: Range<usize>,
    pub(super) function: &'a Function,
    /// The range in which findings are allowed.
    pub(super) scope: Range<usize>,
}

/// The codes that the comments of a file allow.
pub(super) fn allowances(file: &IndexedFile) -> Vec<Allowance<'_>> {
    let mut out = Vec::new();
    // Most files have no such comment.
    if !file.text.contains(MARK) {
        return out;
    }
    for function in &file.index().functions {
        let comments = function.comments.iter().map(|comment| comment.span.start);
        let scope = comments.min().unwrap_or(function.span.start)..function.span.end;
        let text = file.text.get(scope.clone()).unwrap_or_default();
        for (at, mark) in text.match_indices(MARK) {
            let rest = text[at + mark.len()..].trim_start();
            let list = rest.strip_prefix("allow(");
            let Some((list, _)) = list.and_then(|rest| rest.split_once(')')) else {
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

/// True if a comment of a source allows a code at an offset.
pub(super) fn is_allowed(file: &IndexedFile, offset: usize, code: &str) -> bool {
    let all = allowances(file);
    let mut here = all.iter().filter(|allowance| allowance.scope.contains(&offset));
    here.any(|allowance| allowance.code == code)
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
