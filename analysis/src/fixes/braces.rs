//! Missing braces, inserted at their usual places.

use dotgen_syntax::{
    SyntaxError, SyntaxKind, SyntaxNode, SyntaxToken, TextRange, TextSize, ast::support,
};

use super::{TextFix, indent_of};

/// The fix of a syntax error with a missing brace.
pub(crate) fn missing_brace(root: &SyntaxNode, error: &SyntaxError) -> Option<TextFix> {
    let brace = error.missing?;
    // At the end of the file the last token is reported.
    let here = if error.at_end { root.text_range().end() } else { error.range.start() };
    let before = token_before(root, here)?;
    let (at, text) = match brace {
        "{" => (before.text_range().end(), " {".to_owned()),
        "};" => end_of_body(root, error, &before, here)?,
        // The text after it is there: `;`, or a name.
        _ if starts_name(root, here) => (here, format!("{brace} ")),
        _ => (here, brace.to_owned()),
    };
    Some(TextFix::guess(format!("Insert `{brace}`"), TextRange::empty(at), text))
}

/// The last token before a place that is not a blank or comment.
pub(super) fn token_before(root: &SyntaxNode, at: TextSize) -> Option<SyntaxToken> {
    let mut token = root.token_at_offset(at).left_biased();
    while let Some(before) = token {
        let range = before.text_range();
        if support::is_text(&before) && range.end() <= at {
            return Some(before);
        }
        token = before.prev_token();
    }
    None
}

fn starts_name(root: &SyntaxNode, at: TextSize) -> bool {
    let token = root.token_at_offset(at).right_biased();
    token.is_some_and(|token| token.kind() == SyntaxKind::IDENT)
}

/// `};` on a line of its own, at the indentation of the declaration, behind the comment of the line before;
/// or on that line, if the body is on one line.
fn end_of_body(
    root: &SyntaxNode,
    error: &SyntaxError,
    before: &SyntaxToken,
    here: TextSize,
) -> Option<(TextSize, String)> {
    let (opening, _) = error.related?;
    let opening = root.token_at_offset(opening.start()).right_biased()?;
    let indent = indent_of(&opening.parent()?.parent()?);
    let behind = std::iter::successors(before.next_token(), SyntaxToken::next_token);
    let mut behind = behind.take_while(|token| token.text_range().start() < here);
    match behind.find(|token| token.kind() == SyntaxKind::NEWLINE) {
        Some(end) => Some((end.text_range().start(), format!("{}{indent}}};", end.text()))),
        None => Some((before.text_range().end(), " };".to_owned())),
    }
}
