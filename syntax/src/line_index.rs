//! Byte offsets to lines and columns, and back, in the three encodings of LSP.
//!
//! Lines end with `\n`, `\r\n` or a lone `\r`, as LSP requires. Lines and columns count from 0.
//!
//! The bytes that an encoding saves are kept as running sums at each character that is not ASCII, so a
//! conversion is two binary searches for any length of line.

use rowan::TextSize;

/// The unit of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PositionEncoding {
    /// Bytes.
    Utf8,
    /// UTF-16 code units.
    Utf16,
    /// Characters.
    Utf32,
}

/// A position as line and column, both from zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LineCol {
    pub line: u32,
    /// Column, in units of some [`PositionEncoding`].
    pub col: u32,
}

/// The lines of one text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineIndex {
    /// Offset and length (without terminator) of each line.
    lines: Vec<(u32, u32)>,
    /// The characters that are not ASCII, in order.
    wide: Vec<WideChar>,
    len: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct WideChar {
    start: u32,
    end: u32,
    /// Bytes saved by UTF-16 up to the end of this character.
    saved16: u32,
    /// Bytes saved by UTF-32 up to the end of this character.
    saved32: u32,
}

impl LineIndex {
    pub fn new(text: &str) -> LineIndex {
        let bytes = text.as_bytes();
        let mut lines = Vec::new();
        let mut wide: Vec<WideChar> = Vec::new();
        let mut start = 0;
        let mut at = 0;
        while let Some(&byte) = bytes.get(at) {
            match byte {
                b'\n' | b'\r' => {
                    lines.push((start as u32, (at - start) as u32));
                    let crlf = byte == b'\r' && bytes.get(at + 1) == Some(&b'\n');
                    at += 1 + usize::from(crlf);
                    start = at;
                }
                0..=127 => at += 1,
                _ => {
                    let len = utf8_len(byte);
                    let (saved16, saved32) = wide
                        .last()
                        .map_or((0, 0), |character| (character.saved16, character.saved32));
                    wide.push(WideChar {
                        start: at as u32,
                        end: (at + len) as u32,
                        saved16: saved16 + if len == 4 { 2 } else { len as u32 - 1 },
                        saved32: saved32 + len as u32 - 1,
                    });
                    at += len;
                }
            }
        }
        lines.push((start as u32, (bytes.len() - start) as u32));
        LineIndex { lines, wide, len: bytes.len() as u32 }
    }

    /// Number of lines; a text that ends with a line end has an empty last line.
    pub fn line_count(&self) -> u32 {
        self.lines.len() as u32
    }

    /// Length of the text in bytes.
    pub fn text_len(&self) -> TextSize {
        self.len.into()
    }

    /// Bytes of a line, without its terminator.
    pub fn line_range(&self, line: u32) -> Option<rowan::TextRange> {
        let &(start, len) = self.lines.get(line as usize)?;
        Some(rowan::TextRange::at(start.into(), len.into()))
    }

    /// The line that holds a byte; a terminator belongs to the line it ends.
    pub fn line(&self, offset: TextSize) -> u32 {
        let offset = u32::from(offset);
        (self.lines.partition_point(|&(start, _)| start <= offset).max(1) - 1) as u32
    }

    /// Position of a byte. Offsets beyond the text count as its end, those inside a character as its
    /// start, those inside a terminator as the end of the line.
    pub fn line_col(&self, offset: TextSize, encoding: PositionEncoding) -> LineCol {
        let mut offset = u32::from(offset).min(self.len);
        let line = self.line(offset.into());
        let (start, len) = self.lines[line as usize];
        offset = offset.min(start + len);
        let before = self.wide.partition_point(|character| character.end <= offset);
        if let Some(character) = self.wide.get(before) {
            offset = if character.start < offset { character.start } else { offset };
        }
        let saved = self.saved(before, encoding)
            - self.saved(self.wide.partition_point(|character| character.end <= start), encoding);
        LineCol { line, col: offset - start - saved }
    }

    /// Byte of a position; `None` if there is no such line. Columns beyond the line count as its end,
    /// those inside a character as its start.
    pub fn offset(&self, position: LineCol, encoding: PositionEncoding) -> Option<TextSize> {
        let &(start, len) = self.lines.get(position.line as usize)?;
        let first = self.wide.partition_point(|character| character.end <= start);
        let saved_before = self.saved(first, encoding);
        // The ends of the characters of this line, in columns.
        let column_end = |i: usize| {
            self.wide.get(first + i).map(|character| {
                character.end - start - (self.saved(first + i + 1, encoding) - saved_before)
            })
        };
        let (mut low, mut high) = (0, self.wide.len() - first);
        while low < high {
            let middle = low + (high - low) / 2;
            if column_end(middle).is_some_and(|end| end <= position.col) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        let saved = self.saved(first + low, encoding) - saved_before;
        let mut offset = start.saturating_add(position.col).saturating_add(saved);
        if let Some(character) = self.wide.get(first + low) {
            offset = if character.start < offset { character.start } else { offset };
        }
        Some(offset.min(start + len).into())
    }

    /// Bytes saved by the first `count` characters that are not ASCII.
    fn saved(&self, count: usize, encoding: PositionEncoding) -> u32 {
        let Some(last) = count.checked_sub(1).and_then(|i| self.wide.get(i)) else {
            return 0;
        };
        match encoding {
            PositionEncoding::Utf8 => 0,
            PositionEncoding::Utf16 => last.saved16,
            PositionEncoding::Utf32 => last.saved32,
        }
    }
}

fn utf8_len(first: u8) -> usize {
    match first {
        0xF0.. => 4,
        0xE0.. => 3,
        _ => 2,
    }
}

/// The offset at which the line of an offset begins.
pub fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |end| end + 1)
}

#[cfg(test)]
mod tests;
