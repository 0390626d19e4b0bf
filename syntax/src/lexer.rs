//! Text to raw tokens: total and lossless.
//!
//! Every byte of the text belongs to exactly one token, for any text. A character that does not start a token
//! is [`SyntaxKind::STRAY`]; a literal or comment without an end is one token of its own kind. Errors are
//! reported later, when it is known whether the text is active.
//!
//! Contextual keywords are identifiers here. A backslash that ends a line joins it with the next one, even
//! inside a token (language reference, 2.1): texts with such splices are lexed without them, and the splices
//! are put back afterwards.

use std::borrow::Cow;
use std::ops::Range;

use logos::Logos;

use crate::kind::SyntaxKind::{self, *};

/// The tokens of one text, as parallel arrays.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RawTokens {
    kinds: Vec<SyntaxKind>,
    ends: Vec<u32>,
    /// Indexes of the tokens with a splice inside, ascending.
    spliced: Vec<u32>,
}

impl RawTokens {
    /// Number of tokens.
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    /// No token at all, that is, an empty text.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Kind of the token `i`; [`SyntaxKind::EOF`] beyond the end.
    #[inline]
    pub fn kind(&self, i: usize) -> SyntaxKind {
        self.kinds.get(i).copied().unwrap_or(EOF)
    }

    /// Byte offset where the token `i` starts; beyond the last token, the length of the text.
    #[inline]
    pub fn start(&self, i: usize) -> usize {
        match i.min(self.ends.len()) {
            0 => 0,
            i => self.ends[i - 1] as usize,
        }
    }

    /// Byte range of the token `i`; empty, at the end of the text, beyond the last token.
    #[inline]
    pub fn range(&self, i: usize) -> Range<usize> {
        self.start(i)..self.start(i + 1)
    }

    /// Spelling of the token `i`, splices included; empty if `text` is not the text that was lexed.
    #[inline]
    pub fn text<'t>(&self, text: &'t str, i: usize) -> &'t str {
        text.get(self.range(i)).unwrap_or("")
    }

    /// Spelling of the token `i` as the language sees it, without splices.
    #[inline]
    pub fn clean_text<'t>(&self, text: &'t str, i: usize) -> Cow<'t, str> {
        let spelled = self.text(text, i);
        if self.has_splice(i) { Cow::Owned(unsplice(spelled).0) } else { Cow::Borrowed(spelled) }
    }

    /// Returns true if the token `i` is broken by a backslash at the end of a line.
    #[inline]
    pub(crate) fn has_splice(&self, i: usize) -> bool {
        !self.spliced.is_empty() && self.spliced.binary_search(&(i as u32)).is_ok()
    }

    /// All kinds, in order.
    pub fn kinds(&self) -> &[SyntaxKind] {
        &self.kinds
    }

    /// Index of the token that holds the byte `offset` (the last one at the end of the text).
    pub fn token_at(&self, offset: usize) -> usize {
        let index = self.ends.partition_point(|&end| end as usize <= offset);
        index.min(self.len().saturating_sub(1))
    }

    fn push(&mut self, kind: SyntaxKind, end: usize) {
        self.kinds.push(kind);
        self.ends.push(end as u32);
    }
}

/// Splits `text` into tokens. Total: any text gives tokens that cover it.
pub fn lex(text: &str) -> RawTokens {
    if text.match_indices('\\').any(|(at, _)| splice_len(&text.as_bytes()[at..]) > 0) {
        lex_spliced(text)
    } else {
        lex_plain(text)
    }
}

/// Returns true if the token is a word for the preprocessor: an identifier, a reserved word or an operator
/// word. Macro names are words.
#[inline]
pub fn is_word(kind: SyntaxKind, text: &str) -> bool {
    match kind {
        IDENT => true,
        CARET | AMP | PIPE | TILDE | BANG => text.len() > 1,
        _ => kind.is_reserved_word(),
    }
}

/// White space, line ends, splices and comments.
#[inline]
pub(crate) fn is_trivia(kind: SyntaxKind) -> bool {
    kind <= OPEN_COMMENT
}

fn lex_plain(text: &str) -> RawTokens {
    let mut tokens = RawTokens {
        kinds: Vec::with_capacity(text.len() / 4),
        ends: Vec::with_capacity(text.len() / 4),
        spliced: Vec::new(),
    };
    // After a string without an end, the ends of the following strings are unknown: these strings then end
    // with their line. This also keeps lexing linear.
    let mut strings_span_lines = true;
    let mut line = Line::Start;
    let mut lexer = SyntaxKind::lexer(text);
    while let Some(token) = lexer.next() {
        let kind = match token {
            Ok(BLOCK_COMMENT) => {
                if let Some(at) = lexer.remainder().find("*/") {
                    lexer.bump(at + 2);
                    BLOCK_COMMENT
                } else {
                    lexer.bump(lexer.remainder().len());
                    OPEN_COMMENT
                }
            }
            Ok(STRING) => {
                let spans_lines = strings_span_lines && line != Line::Include;
                let (len, closed) = literal(lexer.remainder(), b'"', spans_lines);
                lexer.bump(len);
                strings_span_lines &= closed || line == Line::Include;
                if closed { STRING } else { OPEN_STRING }
            }
            Ok(CHAR) => {
                let (len, closed) = literal(lexer.remainder(), b'\'', false);
                lexer.bump(len);
                if closed { CHAR } else { OPEN_STRING }
            }
            token => token.unwrap_or(STRAY),
        };
        let end = lexer.span().end;
        if kind == STRAY && tokens.kinds.last() == Some(&STRAY) {
            tokens.ends.pop();
            tokens.ends.push(end as u32);
            continue;
        }
        tokens.push(kind, end);
        line = match (line, kind) {
            (_, NEWLINE) => Line::Start,
            (_, WHITESPACE | BLOCK_COMMENT | LINE_COMMENT) => line,
            (Line::Start, HASH) => Line::Hash,
            (Line::Hash, IDENT) if lexer.slice() == "include" => Line::Include,
            (Line::Include, _) => line,
            _ => Line::Other,
        };
    }
    tokens
}

/// The position in an `#include` line. The name of a file does not span lines, other strings may.
#[derive(Clone, Copy, PartialEq)]
enum Line {
    Start,
    Hash,
    Include,
    Other,
}

/// Length of a literal after its opening quote in bytes, and true if it is closed. A literal that is not
/// closed ends with its line.
fn literal(rest: &str, quote: u8, spans_lines: bool) -> (usize, bool) {
    let bytes = rest.as_bytes();
    let mut line_end = None;
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            _ if byte == quote => return (at + 1, true),
            b'\\' if bytes.get(at + 1).is_some_and(|&next| spans_lines || !is_line_end(next)) => {
                at += 1;
                if is_line_end(bytes[at]) {
                    line_end.get_or_insert(at);
                }
            }
            _ if is_line_end(byte) => {
                line_end.get_or_insert(at);
                if !spans_lines {
                    break;
                }
            }
            _ => {}
        }
        at += 1;
    }
    (line_end.unwrap_or(bytes.len()), false)
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Length in bytes of the splice that `bytes` starts with; 0 without a splice.
fn splice_len(bytes: &[u8]) -> usize {
    match bytes {
        [b'\\', b'\r', b'\n', ..] => 3,
        [b'\\', b'\n' | b'\r', ..] => 2,
        _ => 0,
    }
}

/// The text without its splices, and the splices as pairs of offset in the result and length, in bytes.
fn unsplice(text: &str) -> (String, Vec<(usize, usize)>) {
    let mut clean = String::with_capacity(text.len());
    let mut splices = Vec::new();
    let mut copied = 0;
    for (at, _) in text.match_indices('\\') {
        let len = splice_len(&text.as_bytes()[at..]);
        if len > 0 {
            clean.push_str(&text[copied..at]);
            splices.push((clean.len(), len));
            copied = at + len;
        }
    }
    clean.push_str(&text[copied..]);
    (clean, splices)
}

fn lex_spliced(text: &str) -> RawTokens {
    let (clean, splices) = unsplice(text);
    let plain = lex_plain(&clean);
    let mut splices = splices.into_iter().peekable();
    let mut tokens = RawTokens::default();
    let mut removed = 0;
    for i in 0..plain.len() {
        let Range { start, end } = plain.range(i);
        let kind = plain.kind(i);
        let mut broken = false;
        while let Some((at, len)) = splices.next_if(|&(at, _)| at < end) {
            if at == start {
                removed += len;
                tokens.push(SPLICE, at + removed);
            } else if kind == WHITESPACE {
                if tokens.ends.last().is_none_or(|&end| (end as usize) < at + removed) {
                    tokens.push(kind, at + removed);
                }
                removed += len;
                tokens.push(SPLICE, at + removed);
            } else {
                removed += len;
                broken = true;
            }
        }
        if broken {
            tokens.spliced.push(tokens.len() as u32);
        }
        tokens.push(kind, end + removed);
    }
    for (at, len) in splices {
        removed += len;
        tokens.push(SPLICE, at + removed);
    }
    tokens
}

#[cfg(test)]
mod tests;
