//! Files as text, without loss: bytes that are not UTF-8 are kept through every edit.
//!
//! A byte that is not part of valid UTF-8 becomes one scalar of a private-use plane, its *escape* (after
//! Python's `surrogateescape`, PEP 383). Text that already holds such scalars is escaped byte by byte, so
//! every byte string has exactly one text, and [`encode`] restores the bytes. Escapes are for edits only:
//! text for display or for other programs goes through [`shown`].

#[cfg(test)]
mod tests;

use std::borrow::Cow;

/// The escape of byte 0, which needs none. Those in use are U+10F780 to U+10F7FF.
const BASE: u32 = 0x10_F700;

/// The escape of a byte that is not ASCII.
fn escape_of(byte: u8) -> char {
    char::from_u32(BASE + u32::from(byte)).unwrap_or(char::REPLACEMENT_CHARACTER)
}

/// The byte that a scalar stands for, if it is an escape.
pub(crate) fn escaped_byte(c: char) -> Option<u8> {
    let byte = u32::from(c).checked_sub(BASE)?;
    u8::try_from(byte).ok().filter(|byte| !byte.is_ascii())
}

/// Returns the offset of the first escape in a text, in bytes; `None` if the text holds none.
pub fn first_escape(text: &str) -> Option<usize> {
    // All escapes begin with this byte, which is rare in other text.
    if !text.as_bytes().contains(&0xf4) {
        return None;
    }
    text.find(|c| escaped_byte(c).is_some())
}

/// The text of a file, with escapes for the bytes that are not UTF-8.
pub fn decode(bytes: Vec<u8>) -> String {
    let bytes = match String::from_utf8(bytes) {
        Ok(text) if first_escape(&text).is_none() => return text,
        Ok(text) => return escape(&text).into_owned(),
        Err(error) => error.into_bytes(),
    };
    let mut out = String::with_capacity(bytes.len() + bytes.len() / 8);
    for chunk in bytes.utf8_chunks() {
        out += &escape(chunk.valid());
        out.extend(chunk.invalid().iter().copied().map(escape_of));
    }
    out
}

/// Number of bytes that [`other_unicode`] examines.
const EXAMINED: usize = 4096;

/// The name of the encoding, if a file is in one of two or four bytes a character. Such a file has no text as
/// UTF-8: every ASCII character has a zero next to it.
pub fn other_unicode(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => return Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return Some("UTF-16"),
        _ => {}
    }
    // Without a byte order mark: most characters of a specification are ASCII.
    let start = &bytes[..bytes.len().min(EXAMINED)];
    let (mut even, mut odd) = (0, 0);
    for pair in start.chunks_exact(2) {
        even += usize::from(pair[0] == 0);
        odd += usize::from(pair[1] == 0);
    }
    let most = start.len() / 2;
    let (few, many) = (even.min(odd), even.max(odd));
    (bytes.len().is_multiple_of(2) && few == 0 && many > 1 && many * 2 > most).then_some("UTF-16")
}

/// Escapes a text that does not come from a file (typed by a user or sent by a client), so that it can be
/// inserted into the text of a file.
pub fn escape(text: &str) -> Cow<'_, str> {
    if first_escape(text).is_none() {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match escaped_byte(c) {
            Some(_) => {
                let mut buffer = [0; 4];
                let bytes = c.encode_utf8(&mut buffer).bytes();
                out.extend(bytes.map(escape_of));
            }
            None => out.push(c),
        }
    }
    out.into()
}

/// The bytes of a text: the inverse of [`decode`].
pub fn encode(text: &str) -> Cow<'_, [u8]> {
    if first_escape(text).is_none() {
        return text.as_bytes().into();
    }
    let mut out = Vec::with_capacity(text.len());
    let mut buffer = [0; 4];
    for c in text.chars() {
        match escaped_byte(c) {
            Some(byte) => out.push(byte),
            None => out.extend_from_slice(c.encode_utf8(&mut buffer).as_bytes()),
        }
    }
    out.into()
}

/// The text for display and for other programs: without escapes, with U+FFFD for bytes that are not UTF-8.
/// Must never be written to a file.
pub fn shown(text: &str) -> Cow<'_, str> {
    match encode(text) {
        Cow::Borrowed(_) => text.into(),
        Cow::Owned(bytes) => String::from_utf8_lossy(&bytes).into_owned().into(),
    }
}

/// The text as Tcl reads the file: bytes that are not UTF-8 are Latin-1.
pub fn latin1(text: &str) -> Cow<'_, str> {
    if first_escape(text).is_none() {
        return text.into();
    }
    let chars = text.chars().map(|c| escaped_byte(c).map_or(c, char::from));
    chars.collect::<String>().into()
}

/// The kinds of line end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LineEnd {
    /// `\n`
    #[default]
    Lf,
    /// `\r\n`
    CrLf,
}

impl LineEnd {
    /// The line end of most lines of a text; `\n` for a text of one line.
    pub fn of(text: &str) -> LineEnd {
        let all = text.bytes().filter(|byte| *byte == b'\n').count();
        let crlf = text.matches("\r\n").count();
        if crlf * 2 > all { LineEnd::CrLf } else { LineEnd::Lf }
    }

    /// The characters of the line end.
    pub fn as_str(self) -> &'static str {
        match self {
            LineEnd::Lf => "\n",
            LineEnd::CrLf => "\r\n",
        }
    }

    /// A new text with these line ends.
    pub fn fit(self, text: &str) -> Cow<'_, str> {
        match self {
            _ if !text.contains('\n') => text.into(),
            LineEnd::Lf if !text.contains("\r\n") => text.into(),
            LineEnd::Lf => text.replace("\r\n", "\n").into(),
            LineEnd::CrLf => text.replace("\r\n", "\n").replace('\n', "\r\n").into(),
        }
    }
}
