//! Increasing ranges around an offset, along the syntax tree.

use std::ops::Range;

use dotgen_syntax::{SyntaxElement, TokenAtOffset};

use super::FileView;
use crate::source_map::{bytes, offset};

/// The ranges around an offset, innermost first, each larger than the one before; never empty.
pub(crate) fn selection_ranges(view: &FileView<'_>, at: usize) -> Vec<Range<usize>> {
    let root = view.root();
    let at = offset(at).min(root.text_range().end());
    let token = match root.token_at_offset(at) {
        TokenAtOffset::None => return vec![bytes(root.text_range())],
        TokenAtOffset::Single(token) => token,
        // Prefer a word to the token next to it.
        TokenAtOffset::Between(left, right) if right.kind().is_trivia() => left,
        TokenAtOffset::Between(left, right) if is_word(left.kind()) && !is_word(right.kind()) => {
            left
        }
        TokenAtOffset::Between(_, right) => right,
    };
    let mut out: Vec<Range<usize>> = Vec::new();
    let mut push = |range: Range<usize>| {
        let grows = out.last().is_none_or(|last| {
            range.start <= last.start && last.end <= range.end && range != *last
        });
        if grows && !range.is_empty() {
            out.push(range);
        }
    };
    if !token.kind().is_trivia() || token.kind().is_comment() {
        push(bytes(token.text_range()));
    }
    for node in token.parent_ancestors() {
        // The inside of brackets first, then with the brackets.
        let open = node.first_child_or_token_by_kind(&|kind| opens(kind));
        let close = node.last_child_or_token();
        if let (Some(SyntaxElement::Token(open)), Some(SyntaxElement::Token(close))) = (open, close)
            && closes(close.kind())
            && open.text_range().end() <= token.text_range().start()
            && token.text_range().end() <= close.text_range().start()
        {
            let inside =
                usize::from(open.text_range().end())..usize::from(close.text_range().start());
            let text = view.text().get(inside.clone()).unwrap_or_default();
            let start = inside.start + (text.len() - text.trim_start().len());
            push(start..start + text.trim().len());
        }
        let trimmed = view.node_range(&node);
        if trimmed.contains_range(token.text_range()) {
            push(bytes(trimmed));
        }
        push(bytes(node.text_range()));
    }
    if out.is_empty() {
        out.push(bytes(root.text_range()));
    }
    out
}

fn opens(kind: dotgen_syntax::SyntaxKind) -> bool {
    use dotgen_syntax::SyntaxKind::{L_BRACK, L_CURLY, L_PAREN};
    matches!(kind, L_BRACK | L_CURLY | L_PAREN)
}

fn closes(kind: dotgen_syntax::SyntaxKind) -> bool {
    use dotgen_syntax::SyntaxKind::{R_BRACK, R_CURLY, R_PAREN};
    matches!(kind, R_BRACK | R_CURLY | R_PAREN)
}

fn is_word(kind: dotgen_syntax::SyntaxKind) -> bool {
    kind == dotgen_syntax::SyntaxKind::IDENT || kind.is_keyword() || kind.is_literal()
}

#[cfg(test)]
mod tests {
    use crate::test_support::Fixture;

    #[track_caller]
    fn check(text: &str, expected: &[&str]) {
        let fixture = Fixture::new(text);
        let at = fixture.at();
        let ranges = fixture.analysis().selection_ranges(&at.path, &[at.offset]).unwrap();
        let text = fixture.text("/main.gen");
        let found: Vec<&str> = ranges[0].iter().map(|range| &text[range.clone()]).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn grows_along_the_tree() {
        check(
            "typedef sequence<m::t$0, 4> u;",
            &["t", "m::t", "sequence<m::t, 4>", "typedef sequence<m::t, 4> u;"],
        );
        check(
            "component c { ids { lo$0ng v; }; };",
            &[
                "long",
                "long v;",
                "{ long v; }",
                "ids { long v; };",
                "{ ids { long v; }; }",
                "component c { ids { long v; }; };",
            ],
        );
        check(
            "component c { attribute a(in x$0, out y); };",
            &[
                "x",
                "in x",
                "in x, out y",
                "(in x, out y)",
                "attribute a(in x, out y);",
                "{ attribute a(in x, out y); }",
                "component c { attribute a(in x, out y); };",
            ],
        );
    }

    #[test]
    fn comments_and_ends() {
        check(
            "/* a$0 b */\n\nconst long n = 1;\n",
            &["/* a b */", "/* a b */\n\nconst long n = 1;\n"],
        );
        check("$0", &[""]);
    }
}
