//! Places of nodes in the text: their lines, indentation, ends and commas.

use dotgen_syntax::{SyntaxKind, SyntaxNode, SyntaxToken, TextRange, TextSize, ast::support};

/// Returns true if a node begins its line.
pub(super) fn starts_line(node: &SyntaxNode) -> bool {
    let mut before = support::first_text_token(node).and_then(|token| token.prev_token());
    while let Some(token) = before {
        if token.text().contains(['\n', '\r']) {
            return true;
        }
        if !token.kind().is_trivia() {
            return false;
        }
        before = token.prev_token();
    }
    true
}

/// The blanks before the first real token of a node on its line.
pub(super) fn indent_of(node: &SyntaxNode) -> String {
    let before = support::first_text_token(node).and_then(|token| token.prev_token());
    before
        .filter(|token| token.kind() == SyntaxKind::WHITESPACE)
        .map(|token| token.text().rsplit('\n').next().unwrap_or_default().to_owned())
        .unwrap_or_default()
}

/// The end of the last real token of a node.
pub(super) fn end_of(node: &SyntaxNode) -> TextSize {
    let last = support::last_text_token(node);
    last.map_or(node.text_range().end(), |token| token.text_range().end())
}

/// A declaration with the blanks and the line end before it.
pub(super) fn whole_lines(node: &SyntaxNode) -> TextRange {
    let range = TextRange::new(node.text_range().start(), end_of(node));
    with_line_before(range, node.first_token())
}

/// A range that begins with a token, with the blanks and the line end before it.
pub(super) fn with_line_before(mut range: TextRange, first: Option<SyntaxToken>) -> TextRange {
    let mut before = first.and_then(|token| token.prev_token());
    while let Some(token) =
        before.filter(|token| matches!(token.kind(), SyntaxKind::WHITESPACE | SyntaxKind::NEWLINE))
    {
        range = range.cover(token.text_range());
        if token.text().contains(['\n', '\r']) {
            break;
        }
        before = token.prev_token();
    }
    range
}

/// A part of a list with its comma.
pub(super) fn with_comma(part: &SyntaxNode) -> TextRange {
    let range = TextRange::new(part.text_range().start(), end_of(part));
    let mut next = part.last_token().and_then(|token| token.next_token());
    while let Some(token) = next {
        if token.kind() == SyntaxKind::COMMA {
            let after = token.next_token().filter(|token| token.kind() == SyntaxKind::WHITESPACE);
            let end = after.map_or(token.text_range().end(), |token| token.text_range().end());
            return TextRange::new(range.start(), end);
        }
        if !token.kind().is_trivia() {
            break;
        }
        next = token.next_token();
    }
    let mut before = part.first_token().and_then(|token| token.prev_token());
    while let Some(token) = before {
        if token.kind() == SyntaxKind::COMMA {
            return TextRange::new(token.text_range().start(), range.end());
        }
        if !token.kind().is_trivia() {
            break;
        }
        before = token.prev_token();
    }
    range
}
