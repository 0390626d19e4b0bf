//! Errors with their place in the text.

use std::fmt;

/// An error of a model or of its queries, with the place that causes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// The problem, and what was expected.
    pub message: String,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)
    }
}

impl std::error::Error for Error {}

/// An error at a byte offset, before the text is known.
#[derive(Debug, Clone)]
pub(crate) struct Fault {
    at: u32,
    message: String,
}

pub(crate) type Res<T> = Result<T, Fault>;

impl Fault {
    pub(crate) fn new(at: u32, message: impl Into<String>) -> Fault {
        Fault { at, message: message.into() }
    }

    /// The error with line and column in the text that the offset belongs to.
    pub(crate) fn locate(self, text: &str) -> Error {
        let mut end = (self.at as usize).min(text.len());
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &text[..end];
        let line = before.bytes().filter(|byte| *byte == b'\n').count() as u32 + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = before[start..].chars().count() as u32 + 1;
        Error { line, column, message: self.message }
    }
}

/// `Err` with a message at a byte offset.
pub(crate) fn fail<T>(at: u32, message: impl Into<String>) -> Res<T> {
    Err(Fault::new(at, message))
}
