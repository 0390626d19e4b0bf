//! What goes between two pieces.

use crate::SyntaxKind::*;
use crate::lexer::lex;

use super::VALUE_GAP;
use super::chunks::{Chunk, ChunkKind, is_valued_property};

/// White space before a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gap {
    /// As it is.
    Keep,
    /// Nothing.
    None,
    /// One blank.
    Space,
    /// Blanks that align the values of properties.
    Value,
    /// A new line at the level of the piece, after a blank line if there was one.
    Line {
        /// With a blank line before it.
        blank: bool,
    },
    /// A new line inside a list or statement, aligned.
    Continue,
    /// Before a trailing comment.
    Comment,
}

/// The white space between two neighbouring pieces.
pub(super) fn gap(text: &str, before: Option<&Chunk>, chunk: &Chunk) -> Gap {
    let Some(before) = before else {
        return if keeps(chunk) {
            Gap::Keep
        } else {
            Gap::Line { blank: false }
        };
    };
    if (before.frozen && (chunk.frozen || !chunk.first_of_item)) || keeps(before) || keeps(chunk) {
        return Gap::Keep;
    }
    let line = Gap::Line {
        blank: chunk.newlines > 1 && !before.is(L_CURLY) && !chunk.is(R_CURLY),
    };
    match chunk.kind {
        ChunkKind::TrailingComment => return Gap::Comment,
        ChunkKind::Comment if chunk.list_depth > 0 => return Gap::Continue,
        ChunkKind::Comment => return line,
        // It stays beside a comment that it follows.
        ChunkKind::InlineComment if before.kind == ChunkKind::Comment => return Gap::Space,
        _ => {}
    }
    if before.ends_line || matches!(before.kind, ChunkKind::Comment | ChunkKind::TrailingComment) {
        return if starts_line(chunk) {
            line
        } else {
            Gap::Continue
        };
    }
    if starts_line(chunk)
        && (!chunk.listed || chunk.newlines > 0 || before.is(L_CURLY) || chunk.is(R_CURLY))
    {
        return line;
    }
    let wanted = within_line(before, chunk);
    match wanted {
        Gap::None if glues(text, before, chunk) => Gap::Space,
        other => other,
    }
}

/// Pieces around which nothing is changed.
fn keeps(chunk: &Chunk) -> bool {
    chunk.kind == ChunkKind::Opaque
}

/// What begins a line: items of blocks that are not written on one line, and closing braces.
pub(super) fn starts_line(chunk: &Chunk) -> bool {
    if chunk.flat {
        return false;
    }
    chunk.first_of_item || (chunk.is(R_CURLY) && matches!(chunk.parent, BODY | ENUMERATOR_LIST))
}

fn within_line(before: &Chunk, chunk: &Chunk) -> Gap {
    let ChunkKind::Token(kind) = chunk.kind else {
        return Gap::Space;
    };
    let ChunkKind::Token(last) = before.kind else {
        return if matches!(kind, SEMICOLON | COMMA | R_PAREN) {
            Gap::None
        } else {
            Gap::Space
        };
    };
    // The author's line breaks stay where a list or statement may be broken.
    let breakable = if chunk.newlines > 0 && !chunk.flat {
        Gap::Continue
    } else {
        Gap::Space
    };
    match (last, kind) {
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
        (_, L_CURLY) => Gap::Space,
        (_, YIELDS_KW | WCET_KW) => breakable,
        (COMMA, _) | (_, EQ) | (EQ, _) | (STRING, STRING) => breakable,
        (L_CURLY, _) | (_, R_CURLY) => breakable,
        (_, _) if chunk.opens_hang.is_some() && is_valued_property(before.parent) => Gap::Value,
        _ => Gap::Space,
    }
}

fn is_direction(chunk: &Chunk) -> bool {
    matches!(chunk.kind, ChunkKind::Token(IN_KW | OUT_KW | INOUT_KW))
}

/// Whether two tokens without white space between them would be read as something else.
fn glues(text: &str, before: &Chunk, chunk: &Chunk) -> bool {
    let (a, b) = (&text[before.span()], &text[chunk.span()]);
    let joined = format!("{a}{b}");
    let tokens = lex(&joined);
    tokens.len() != 2 || tokens.range(0).end != a.len()
}

/// Blanks before the values of properties, aligned in runs of lines: by chunk.
pub(super) fn value_columns(chunks: &[Chunk]) -> Vec<Option<usize>> {
    let mut out = vec![None; chunks.len()];
    let mut run: Vec<(usize, usize)> = Vec::new();
    let mut flush = |run: &mut Vec<(usize, usize)>| {
        let widest = run.iter().map(|&(_, width)| width).max().unwrap_or(0);
        for &(value, width) in run.iter() {
            out[value] = Some(widest - width + VALUE_GAP);
        }
        run.clear();
    };
    for (i, chunk) in chunks.iter().enumerate() {
        let is_value = chunk.opens_hang.is_some() && i > 0 && !chunk.frozen && !chunk.flat;
        if is_value {
            let keyword = &chunks[i - 1];
            // Runs join properties of one body on consecutive lines.
            let same_level = run
                .last()
                .is_none_or(|&(last, _)| chunks[last].indent == chunk.indent);
            if !same_level || keyword.newlines > 1 {
                flush(&mut run);
            }
            run.push((i, keyword.span().len()));
        } else if chunk.is(R_CURLY) || (chunk.first_of_item && !is_keyword_of_property(chunks, i)) {
            flush(&mut run);
        }
    }
    flush(&mut run);
    out
}

/// Whether a chunk is the keyword of a property whose value is aligned.
fn is_keyword_of_property(chunks: &[Chunk], i: usize) -> bool {
    is_valued_property(chunks[i].parent)
        && chunks
            .get(i + 1)
            .is_some_and(|next| next.opens_hang.is_some())
}
