//! The white space between two pieces.

use crate::SyntaxKind::*;
use crate::lexer::lex;

use super::chunks::{Chunk, ChunkKind, starts_line};

/// White space before a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gap {
    /// As it is.
    Keep,
    /// Nothing.
    None,
    /// One blank.
    Space,
    /// A blank if the text has one.
    Author,
    /// One blank, or a new line where the line would be too long.
    Break,
    /// A new line at the level of the piece.
    Line {
        /// True to keep the empty lines before it.
        blank: bool,
    },
    /// A new line inside a list or statement.
    Continue,
    /// Before a trailing comment.
    Comment,
}

/// The white space between two neighbouring pieces.
pub(super) fn gap(text: &str, before: Option<&Chunk>, chunk: &Chunk) -> Gap {
    let Some(before) = before else {
        return if is_unchanged(chunk) { Gap::Keep } else { Gap::Line { blank: false } };
    };
    if (before.frozen && (chunk.frozen || !chunk.first_of_item))
        || is_unchanged(before)
        || is_unchanged(chunk)
    {
        return Gap::Keep;
    }
    let line = Gap::Line { blank: chunk.newlines > 1 && !before.is(L_CURLY) && !chunk.is(R_CURLY) };
    match chunk.kind {
        ChunkKind::TrailingComment => return Gap::Comment,
        ChunkKind::Comment if chunk.list_depth > 0 => return Gap::Continue,
        ChunkKind::Comment => return line,
        // The piece stays on the line of the comment that it follows.
        ChunkKind::InlineComment if before.kind == ChunkKind::Comment => return Gap::Space,
        _ => {}
    }
    if before.ends_line || matches!(before.kind, ChunkKind::Comment | ChunkKind::TrailingComment) {
        return if starts_line(chunk) { line } else { Gap::Continue };
    }
    if starts_line(chunk)
        && (!chunk.listed || chunk.newlines > 0 || before.is(L_CURLY) || chunk.is(R_CURLY))
    {
        return line;
    }
    let wanted = within_line(before, chunk);
    match wanted {
        Gap::None if would_merge(text, before, chunk) => Gap::Space,
        other => other,
    }
}

/// Returns true for pieces around which nothing is changed.
fn is_unchanged(chunk: &Chunk) -> bool {
    chunk.kind == ChunkKind::Opaque
}

fn within_line(before: &Chunk, chunk: &Chunk) -> Gap {
    let ChunkKind::Token(kind) = chunk.kind else {
        return Gap::Space;
    };
    let ChunkKind::Token(last) = before.kind else {
        return if matches!(kind, SEMICOLON | COMMA | R_PAREN) { Gap::None } else { Gap::Space };
    };
    // Line breaks in the text stay where a list or statement may be broken.
    let breakable = match () {
        () if chunk.flat => Gap::Space,
        () if chunk.newlines > 0 => Gap::Continue,
        () => Gap::Break,
    };
    match (last, kind) {
        (_, R_PAREN) if chunk.newlines > 0 && chunk.parent == PARAM_LIST => Gap::Continue,
        (_, SEMICOLON | COMMA | R_PAREN | R_BRACK) => Gap::None,
        (L_PAREN | L_BRACK, _) if chunk.newlines > 0 && before.parent == PARAM_LIST => {
            Gap::Continue
        }
        (L_PAREN | L_BRACK, _) => Gap::None,
        // A number and its unit: the distance can change the meaning (`500us`).
        (_, S_KW | MS_KW | US_KW | K_KW | M_KW) if chunk.parent == QUANTITY => {
            if chunk.spaced {
                Gap::Space
            } else {
                Gap::None
            }
        }
        (_, L_PAREN) if chunk.parent == PARAM_LIST => Gap::None,
        (_, L_BRACK) if matches!(chunk.parent, DIMENSION | INDEX_STEP) => Gap::None,
        (COLON2, _) => Gap::None,
        (_, COLON2) if before.parent == NAME_REF && chunk.parent == PATH => Gap::None,
        (_, COLON2)
            if chunk.parent == STATE || (chunk.parent == RENAME && !is_direction(before)) =>
        {
            Gap::None
        }
        (DOT, _) => Gap::None,
        (_, DOT) if chunk.parent == MEMBER_STEP => Gap::None,
        (_, L_ANGLE) if chunk.parent != BINARY_EXPR => Gap::None,
        (L_ANGLE, _) => Gap::None,
        (R_ANGLE, R_ANGLE) => Gap::Space,
        (_, R_ANGLE) => Gap::None,
        (MINUS | PLUS | TILDE, _) if before.parent == PREFIX_EXPR => Gap::None,
        (_, COLON) if chunk.parent == CASE_LABEL => Gap::None,
        (L_CURLY, R_CURLY) => Gap::Space,
        (_, L_CURLY) if chunk.parent == INITIALIZER_LIST => breakable,
        // A brace on a line of its own stays there.
        (_, L_CURLY) if chunk.newlines > 0 && !chunk.flat => Gap::Line { blank: false },
        (_, L_CURLY) => Gap::Space,
        // The colon before a documentation: `=: "x"`, `= : "x"`, `1: "x"`.
        (_, COLON) | (COLON, _) if is_documentation(before, chunk) => match breakable {
            Gap::Continue => Gap::Continue,
            _ => Gap::Author,
        },
        (_, YIELDS_KW | WCET_KW) => breakable,
        (COMMA | EQ, _) | (_, EQ) | (STRING, STRING) => breakable,
        (L_CURLY, _) | (_, R_CURLY) => breakable,
        _ => Gap::Space,
    }
}

/// Returns true if a colon between two pieces begins the documentation of a parameter or value.
fn is_documentation(before: &Chunk, chunk: &Chunk) -> bool {
    let colon = if chunk.is(COLON) { chunk } else { before };
    !matches!(colon.parent, CASE_LABEL)
}

/// Returns true if a line may be broken before a piece, by the author or because it is too long.
pub(super) fn may_break(text: &str, before: &Chunk, chunk: &Chunk) -> bool {
    matches!(gap(text, Some(before), chunk), Gap::Break | Gap::Continue | Gap::Line { .. })
}

/// Returns true if the author may have padded the white space before a piece to put it in a column.
pub(super) fn may_pad(text: &str, before: &Chunk, chunk: &Chunk) -> bool {
    matches!(gap(text, Some(before), chunk), Gap::Space | Gap::Break | Gap::Comment)
}

fn is_direction(chunk: &Chunk) -> bool {
    matches!(chunk.kind, ChunkKind::Token(IN_KW | OUT_KW | INOUT_KW))
}

/// Returns true if two tokens without white space between them would be read as other tokens.
fn would_merge(text: &str, before: &Chunk, chunk: &Chunk) -> bool {
    let (a, b) = (&text[before.span()], &text[chunk.span()]);
    let joined = format!("{a}{b}");
    let tokens = lex(&joined);
    tokens.len() != 2 || tokens.range(0).end != a.len()
}
