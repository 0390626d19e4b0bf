//! A text and the part of it that is laid out so far.

use super::chunks::{Chunk, gap_span};
use super::unit::{Unit, advance};

/// The white space chosen before a piece.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ChunkLayout {
    pub(super) space: String,
    /// Column of the first character of the piece.
    pub(super) column: usize,
}

/// The pieces of a text, with their old and new positions.
pub(super) struct Page<'a> {
    pub(super) text: &'a str,
    pub(super) chunks: &'a [Chunk],
    /// Maximum length of a line, in columns.
    pub(super) width: usize,
    /// The unit of indentation.
    pub(super) unit: Unit,
    /// Column of each piece in the text.
    pub(super) old_columns: Vec<usize>,
    /// The pieces that are laid out.
    pub(super) printed: Vec<ChunkLayout>,
}

impl<'a> Page<'a> {
    /// The white space before a piece as it is in the text.
    pub(super) fn original(&self, i: usize) -> &'a str {
        &self.text[gap_span(self.chunks, i)]
    }

    /// Column after the last piece of the line of each piece, as printed.
    pub(super) fn line_ends(&self) -> Vec<usize> {
        let mut end = 0;
        let mut out: Vec<usize> = (0..self.printed.len())
            .rev()
            .map(|i| {
                let next = self.printed.get(i + 1);
                if next.is_none_or(|layout| layout.space.contains('\n')) {
                    end = self.end_before(i + 1);
                }
                end
            })
            .collect();
        out.reverse();
        out
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
