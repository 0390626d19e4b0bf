//! Ranges to report for tokens and nodes.

use dotgen_syntax::{
    ExpansionMap, GreenNodeData, NodeOrToken, SyntaxKind, SyntaxNode, SyntaxToken, TextRange,
    TextSize, lexer::RawTokens, preproc::Origin,
};

/// The range to report for a token: its own, the range of the argument of the macro call it comes from, or of
/// the call.
pub(crate) fn token_range(token: &SyntaxToken, map: &ExpansionMap, raw: &RawTokens) -> TextRange {
    match map.origin(token) {
        Some(&Origin::Argument(i)) if (i as usize) < raw.len() => text_range(raw.range(i as usize)),
        _ => map.range(token),
    }
}

/// The range to report for a node: from its first token to its last, without trivia and directives.
pub(crate) fn node_range(node: &SyntaxNode, map: &ExpansionMap, raw: &RawTokens) -> TextRange {
    if map.is_empty() {
        let green = node.green();
        let start = node.text_range().start();
        let (Some(skip), Some(length)) = (text_start(&green), text_end(&green)) else {
            return TextRange::empty(start);
        };
        return TextRange::new(start + skip, start + length);
    }
    let inside = |token: &SyntaxToken| node.text_range().contains_range(token.text_range());
    let is_text = |token: &SyntaxToken| {
        let parent = token.parent().map(|parent| parent.kind());
        !token.kind().is_trivia() && !parent.is_some_and(is_aside)
    };
    let first = std::iter::successors(node.first_token(), SyntaxToken::next_token)
        .take_while(inside)
        .find(is_text);
    let last = std::iter::successors(node.last_token(), SyntaxToken::prev_token)
        .take_while(inside)
        .find(is_text);
    match (first, last) {
        (Some(first), Some(last)) => {
            token_range(&first, map, raw).cover(token_range(&last, map, raw))
        }
        _ => TextRange::empty(node.text_range().start()),
    }
}

/// Returns true for nodes that are not part of the declaration around them.
fn is_aside(kind: SyntaxKind) -> bool {
    matches!(kind, SyntaxKind::DIRECTIVE | SyntaxKind::INACTIVE)
}

/// Offset of the first token of a node that is neither trivia nor in a directive. Green trees are read
/// without allocation, since this runs for every node of a file.
fn text_start(node: &GreenNodeData) -> Option<TextSize> {
    let mut offset = TextSize::new(0);
    for child in node.children() {
        let found = match child {
            NodeOrToken::Token(token) if SyntaxKind::from_raw(token.kind().0).is_trivia() => None,
            NodeOrToken::Token(_) => Some(TextSize::new(0)),
            NodeOrToken::Node(node) if is_aside(SyntaxKind::from_raw(node.kind().0)) => None,
            NodeOrToken::Node(node) => text_start(node),
        };
        if let Some(found) = found {
            return Some(offset + found);
        }
        offset += match child {
            NodeOrToken::Token(token) => token.text_len(),
            NodeOrToken::Node(node) => node.text_len(),
        };
    }
    None
}

/// Offset of the end of the last such token.
fn text_end(node: &GreenNodeData) -> Option<TextSize> {
    let mut offset = node.text_len();
    for child in node.children().rev() {
        let (found, length) = match child {
            NodeOrToken::Token(token) if SyntaxKind::from_raw(token.kind().0).is_trivia() => {
                (None, token.text_len())
            }
            NodeOrToken::Token(token) => (Some(token.text_len()), token.text_len()),
            NodeOrToken::Node(node) if is_aside(SyntaxKind::from_raw(node.kind().0)) => {
                (None, node.text_len())
            }
            NodeOrToken::Node(node) => (text_end(node), node.text_len()),
        };
        offset -= length;
        if let Some(found) = found {
            return Some(offset + found);
        }
    }
    None
}

fn text_range(range: std::ops::Range<usize>) -> TextRange {
    TextRange::new(text_size(range.start), text_size(range.end))
}

pub(super) fn text_size(offset: usize) -> TextSize {
    TextSize::new(offset as u32)
}
