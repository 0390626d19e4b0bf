//! A text with what of it is laid out so far.

use std::ops::Range;

use super::chunks::{Chunk, gap_span};
use super::unit::{Unit, advance};

/// The white space chosen before a piece.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Printed {
    pub(super) space: String,
    /// Column of the first character of the piece.
    pub(super) column: usize,
}

/// The pieces of a text, with where they were and where they are.
pub(super) struct Page<'a> {
    pub(super) text: &'a str,
    pub(super) chunks: &'a [Chunk],
    /// Columns of a line, at most.
    pub(super) width: usize,
    /// By which lines are indented.
    pub(super) unit: Unit,
    /// Column of each piece in the text.
    pub(super) old_columns: Vec<usize>,
    /// The pieces that are laid out.
    pub(super) printed: Vec<Printed>,
}

impl<'a> Page<'a> {
    /// The white space before a piece as it is in the text.
    pub(super) fn original(&self, i: usize) -> &'a str {
        &self.text[gap_span(self.chunks, i)]
    }

    /// Pieces of one line, as printed: from a piece to the last before the next line break.
    pub(super) fn line_from(&self, i: usize) -> Range<usize> {
        let breaks = |it: &Printed| it.space.contains('\n');
        let end = self.printed[i + 1..].iter().position(breaks);
        i..end.map_or(self.printed.len(), |it| i + 1 + it)
    }

    /// Column after the piece before.
    pub(super) fn end_before(&self, i: usize) -> usize {
        let Some(before) = i.checked_sub(1) else {
            return 0;
        };
        let text = &self.text[self.chunks[before].span()];
        advance(self.printed[before].column, text, self.unit.tab())
    }
}
