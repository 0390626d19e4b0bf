//! Positions: byte offsets to and from line and character, in the unit that the client chose.

use std::ops::Range as ByteRange;
use std::sync::Arc;

use dotgen_syntax::line_index::{LineCol, LineIndex, PositionEncoding};

use crate::protocol::types::{Position, PositionEncodingKind, Range};

/// True if two ranges of bytes overlap or touch.
pub(crate) fn touches(a: &ByteRange<usize>, b: &ByteRange<usize>) -> bool {
    a.start <= b.end && b.start <= a.end
}

/// Unit of `character` in a position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Encoding {
    /// Bytes.
    Utf8,
    /// UTF-16 code units, the default of the protocol.
    #[default]
    Utf16,
    /// Characters.
    Utf32,
}

impl Encoding {
    /// UTF-8 if offered, because offsets are bytes here; else UTF-32; else UTF-16.
    pub(crate) fn negotiate(offered: Option<&[PositionEncodingKind]>) -> Encoding {
        let offered = offered.unwrap_or_default();
        if offered.contains(&PositionEncodingKind::UTF8) {
            Encoding::Utf8
        } else if offered.contains(&PositionEncodingKind::UTF32) {
            Encoding::Utf32
        } else {
            Encoding::Utf16
        }
    }

    /// Its name in the protocol.
    pub fn kind(self) -> PositionEncodingKind {
        match self {
            Encoding::Utf8 => PositionEncodingKind::UTF8,
            Encoding::Utf16 => PositionEncodingKind::UTF16,
            Encoding::Utf32 => PositionEncodingKind::UTF32,
        }
    }

    fn unit(self) -> PositionEncoding {
        match self {
            Encoding::Utf8 => PositionEncoding::Utf8,
            Encoding::Utf16 => PositionEncoding::Utf16,
            Encoding::Utf32 => PositionEncoding::Utf32,
        }
    }
}

/// A text with its lines, for conversions.
#[derive(Debug, Clone)]
pub struct Lines {
    text: Arc<str>,
    index: Arc<LineIndex>,
    encoding: Encoding,
}

impl Lines {
    /// Finds the lines of a text.
    pub fn new(text: Arc<str>, encoding: Encoding) -> Lines {
        let index = Arc::new(LineIndex::new(&text));
        Lines::with_index(text, index, encoding)
    }

    /// A text whose lines are already known.
    pub(crate) fn with_index(text: Arc<str>, index: Arc<LineIndex>, encoding: Encoding) -> Lines {
        Lines { text, index, encoding }
    }

    pub fn text(&self) -> &Arc<str> {
        &self.text
    }

    /// Position of an offset. An offset after the end gives the end; an offset inside a character gives its
    /// start.
    pub fn position(&self, offset: usize) -> Position {
        let offset = u32::try_from(offset).unwrap_or(u32::MAX);
        let at = self.index.line_col(offset.into(), self.encoding.unit());
        Position::new(at.line, at.col)
    }

    /// Range of byte offsets.
    pub fn range(&self, range: &ByteRange<usize>) -> Range {
        Range::new(self.position(range.start), self.position(range.end))
    }

    /// Offset of a position; `None` for a line that does not exist. A character beyond the end of
    /// its line is the end of the line (LSP 3.17, Position).
    pub fn offset(&self, position: Position) -> Option<usize> {
        // Some clients use the line after the last one for "end of the document".
        if position.line == self.index.line_count() && position.character == 0 {
            return Some(self.text.len());
        }
        let at = LineCol { line: position.line, col: position.character };
        let offset = self.index.offset(at, self.encoding.unit())?;
        Some(offset.into())
    }

    /// Offsets of the range of a request. Positions after the end of the text give the end.
    pub(crate) fn clamped(&self, range: Range) -> Option<ByteRange<usize>> {
        let end = self.offset(range.end).unwrap_or(self.text.len());
        let range = self.offset(range.start)?..end;
        (range.start <= range.end).then_some(range)
    }

    /// Offsets of a range; `None` also if its start is after its end.
    pub fn bytes(&self, range: Range) -> Option<ByteRange<usize>> {
        let range = self.offset(range.start)?..self.offset(range.end)?;
        (range.start <= range.end).then_some(range)
    }

    /// Byte range of a line, without its end.
    pub fn line(&self, line: u32) -> Option<ByteRange<usize>> {
        let range = self.index.line_range(line)?;
        Some(range.start().into()..range.end().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a😀é\r\nb\rc\n";

    fn lines(encoding: Encoding) -> Lines {
        Lines::new(TEXT.into(), encoding)
    }

    #[test]
    fn every_line_end_counts_and_units_differ() {
        for (encoding, character) in
            [(Encoding::Utf8, 7), (Encoding::Utf16, 4), (Encoding::Utf32, 3)]
        {
            let lines = lines(encoding);
            assert_eq!(lines.position(7), Position::new(0, character));
            assert_eq!(lines.offset(Position::new(0, character)), Some(7));
            assert_eq!(lines.position(9), Position::new(1, 0), "after CRLF");
            assert_eq!(lines.position(11), Position::new(2, 0), "after CR");
            assert_eq!(lines.position(13), Position::new(3, 0), "after LF");
        }
    }

    #[test]
    fn odd_positions_are_clamped_or_refused() {
        let lines = lines(Encoding::Utf16);
        let offset = |line, character| lines.offset(Position::new(line, character));
        assert_eq!(offset(0, 99), Some(7), "beyond the end of the line");
        assert_eq!(offset(0, 2), Some(1), "between two surrogates");
        assert_eq!(offset(4, 0), Some(TEXT.len()), "the line after the last");
        assert_eq!(offset(5, 0), None);
        assert_eq!(lines.position(3), Position::new(0, 1), "inside of a character");
        let backwards = Range::new(Position::new(2, 0), Position::new(1, 0));
        assert_eq!(lines.bytes(backwards), None);
        let long = Range::new(Position::new(1, 0), Position::new(99, 0));
        assert_eq!(lines.bytes(long), None, "an edit must fit");
        assert_eq!(lines.clamped(long), Some(9..TEXT.len()));
        assert_eq!(lines.clamped(backwards), None);
    }

    #[test]
    fn offsets_and_positions_are_inverse() {
        for encoding in [Encoding::Utf8, Encoding::Utf16, Encoding::Utf32] {
            let lines = lines(encoding);
            for (offset, _) in TEXT.char_indices().filter(|(offset, _)| *offset != 8) {
                assert_eq!(lines.offset(lines.position(offset)), Some(offset));
            }
        }
    }
}
