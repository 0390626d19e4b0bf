//! Findings allowed by a comment in a source: `// dotgen: allow(code, …) because …`, as in
//! specifications. It speaks of the function that begins below it, or of the one around it.

use super::files::IndexedFile;

const MARK: &str = "dotgen:";

/// Whether a comment of a source allows a code at an offset.
pub fn is_allowed(file: &IndexedFile, offset: usize, code: &str) -> bool {
    // Most files have none.
    if !file.text.contains(MARK) {
        return false;
    }
    let functions = &file.index.functions;
    let of = |function: &super::source::Function| {
        let comments = function.comments.iter().map(|it| it.span.start);
        comments.min().unwrap_or(function.span.start)..function.span.end
    };
    let Some(scope) = functions.iter().map(of).find(|it| it.contains(&offset)) else {
        return false;
    };
    let text = file.text.get(scope).unwrap_or_default();
    text.match_indices(MARK).any(|(at, mark)| {
        let rest = text[at + mark.len()..].trim_start();
        let list = rest.strip_prefix("allow(");
        let list = list.and_then(|it| it.split_once(')'));
        list.is_some_and(|(list, _)| list.split(',').any(|it| it.trim() == code))
    })
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
