//! Messages from a stream of bytes: `Content-Length` headers, and recovery from wrong ones.
//!
//! A client that sends a wrong length, or other bytes between two messages, must not end the session. A JSON
//! string contains no line end. The bytes `Content-Length: N` followed by a line end are therefore never part
//! of a body: the next message begins there.

use std::ops::Range;

use memchr::memmem;

/// Maximum size of a body in bytes; longer bodies are skipped. No client needs more: the longest document
/// that analysis reads has a few megabytes.
const BODY_LIMIT: u64 = 256 << 20;
/// Maximum length of a header line in bytes; longer lines are not headers.
const LINE_LIMIT: usize = 8 << 10;

const NAME: &[u8] = b"content-length:";

/// A part of the stream.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Frame {
    /// The body of a message.
    Body(Vec<u8>),
    /// Bytes that are not a message; the error. Reported once for each stretch.
    Malformed(&'static str),
}

/// Splits a stream into messages. Stores only bytes that have arrived.
#[derive(Debug, Default)]
pub(super) struct Frames {
    bytes: Vec<u8>,
    /// End of the bytes that were returned.
    start: usize,
    state: State,
    /// True if the present stretch of malformed bytes was reported.
    told: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// In headers; the length, if its header was read.
    Headers(Option<u64>),
    /// In a body of `length` bytes. The first `searched` bytes contain no header.
    Body { length: usize, searched: usize },
    /// In a body that is too long: bytes are skipped up to the next header.
    Skipping,
}

impl Default for State {
    fn default() -> State {
        State::Headers(None)
    }
}

impl Frames {
    /// Adds bytes.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        if self.start > 0 {
            self.bytes.drain(..self.start);
            self.start = 0;
        }
        self.bytes.extend_from_slice(bytes);
    }

    /// Puts the end of the last body back into the stream: the bytes belong to the next message.
    pub(super) fn unread(&mut self, rest: &[u8]) {
        self.bytes.splice(..self.start, rest.iter().copied());
        self.start = 0;
    }

    /// The next message; `None` until more has been read.
    pub(super) fn next(&mut self) -> Option<Frame> {
        loop {
            let found = match self.state {
                State::Headers(length) => self.header(length)?,
                State::Body { length, searched } => self.body(length, searched)?,
                State::Skipping => self.skip()?,
            };
            match found {
                Some(Frame::Malformed(_)) if std::mem::replace(&mut self.told, true) => {}
                Some(frame) => {
                    self.told &= matches!(frame, Frame::Malformed(_));
                    return Some(frame);
                }
                None => {}
            }
        }
    }

    fn rest(&self) -> &[u8] {
        &self.bytes[self.start..]
    }

    /// Reads a header line. The outer `None`: more bytes are needed.
    fn header(&mut self, length: Option<u64>) -> Option<Option<Frame>> {
        const GARBAGE: Frame = Frame::Malformed("something between two messages is no header");
        let Some(end) = memchr::memchr(b'\n', self.rest()) else {
            if self.rest().len() <= LINE_LIMIT {
                return None;
            }
            // A header may begin in the last bytes.
            self.start = self.bytes.len() - NAME.len();
            return Some(Some(GARBAGE));
        };
        let line = self.rest()[..end].trim_ascii();
        let next = self.start + end + 1;
        let found = find_name(line);
        let mut frame = None;
        if let Some(at) = found {
            // The text before the header is the end of a message that was longer than its length.
            frame = (!line[..at].trim_ascii().is_empty()).then_some(GARBAGE);
            if let Some(length) = number(line[at + NAME.len()..].trim_ascii()) {
                self.state = State::Headers(Some(length));
            } else {
                self.state = State::Headers(None);
                frame = Some(Frame::Malformed("a `Content-Length` is no number"));
            }
        } else if line.is_empty() {
            match length {
                Some(length) if length <= BODY_LIMIT => {
                    let length = length as usize;
                    let searched = 0;
                    self.state = State::Body { length, searched };
                }
                Some(_) => {
                    self.state = State::Skipping;
                    frame = Some(Frame::Malformed("a message is too long to be one"));
                }
                None => {}
            }
        } else if !is_header(line) {
            frame = Some(GARBAGE);
        }
        self.start = next;
        Some(frame)
    }

    fn body(&mut self, length: usize, searched: usize) -> Option<Option<Frame>> {
        let rest = self.rest();
        let there = rest.len().min(length);
        // A length that is too large would skip the following messages.
        let end = match find_header(&rest[searched..there]) {
            Some(at) => searched + at.start,
            None if there == length => length,
            None => {
                // These bytes may be the beginning of a header.
                let searched = there.saturating_sub(NAME.len() + 24).max(searched);
                self.state = State::Body { length, searched };
                return None;
            }
        };
        let body = rest[..end].to_vec();
        self.start += end;
        self.state = State::Headers(None);
        Some(Some(Frame::Body(body)))
    }

    fn skip(&mut self) -> Option<Option<Frame>> {
        if let Some(at) = find_header(self.rest()) {
            self.start += at.start;
            self.state = State::Headers(None);
            Some(None)
        } else {
            let keep = self.rest().len().min(NAME.len() + 24);
            self.start = self.bytes.len() - keep;
            None
        }
    }
}

/// The range of a complete `Content-Length: N` with its line end, inside other bytes.
fn find_header(bytes: &[u8]) -> Option<Range<usize>> {
    let mut from = 0;
    while let Some(at) = memmem::find(&bytes[from..], b"-Length:") {
        let name = from + at;
        from = name + 1;
        let Some(start) = name.checked_sub(b"Content".len()) else {
            continue;
        };
        if !bytes[start..].get(..NAME.len())?.eq_ignore_ascii_case(NAME) {
            continue;
        }
        let value = start + NAME.len();
        let Some(end) = memchr::memchr(b'\n', &bytes[value..]) else {
            continue;
        };
        if number(bytes[value..value + end].trim_ascii()).is_some() {
            return Some(start..value + end + 1);
        }
    }
    None
}

/// The start of a header at the end of an invalid body: the length was too large, and the next message begins
/// inside the body.
pub(super) fn header_at_end(body: &[u8]) -> Option<usize> {
    let from = body.len().saturating_sub(NAME.len() + 24);
    (from..body.len()).find(|at| {
        let tail = &body[*at..];
        let (name, value) = tail.split_at(tail.len().min(NAME.len()));
        let value = value.trim_ascii();
        name.eq_ignore_ascii_case(&NAME[..name.len()]) && value.iter().all(u8::is_ascii_digit)
    })
}

/// The start of the last `Content-Length:` of a line, in upper or lower case.
fn find_name(line: &[u8]) -> Option<usize> {
    let mut windows = line.windows(NAME.len());
    windows.rposition(|window| window.eq_ignore_ascii_case(NAME))
}

/// A length, with any number of digits.
fn number(text: &[u8]) -> Option<u64> {
    let digits = !text.is_empty() && text.iter().all(u8::is_ascii_digit);
    digits.then(|| {
        let text = str::from_utf8(text).unwrap_or_default();
        text.parse().unwrap_or(u64::MAX)
    })
}

/// True for `Name: value`. Headers other than the length are ignored.
fn is_header(line: &[u8]) -> bool {
    let name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'-';
    let colon = memchr::memchr(b':', line);
    colon.is_some_and(|colon| colon > 0 && line[..colon].iter().all(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All frames of a stream, which are equal for every size of the pieces in which it arrives.
    fn frames(stream: &str) -> Vec<String> {
        let cut = |size: usize| {
            let mut frames = Frames::default();
            let mut out = Vec::new();
            for piece in stream.as_bytes().chunks(size) {
                frames.push(piece);
                while let Some(frame) = frames.next() {
                    out.push(match frame {
                        Frame::Body(body) => String::from_utf8(body).expect("UTF-8"),
                        Frame::Malformed(what) => {
                            format!("!{}", what.split(' ').next().unwrap_or(""))
                        }
                    });
                }
            }
            out
        };
        let whole = cut(stream.len());
        for size in 1..stream.len().min(40) {
            assert_eq!(cut(size), whole, "in pieces of {size}");
        }
        whole
    }

    #[test]
    fn headers_come_in_any_case_and_order() {
        let both = "content-LENGTH:2\r\nContent-Type: x; charset=latin1\r\n\r\n{}\
                    X-Any: 1\nContent-Length:  3  \n\n[1]";
        assert_eq!(frames(both), ["{}", "[1]"]);
    }

    #[test]
    fn what_stands_between_messages_is_told_once() {
        let stream = "hello\nthere {}\n\nContent-Length: 2\r\n\r\n{}xyzContent-Length: 2\r\n\r\n[]";
        assert_eq!(frames(stream), ["!something", "{}", "!something", "[]"]);
    }

    #[test]
    fn a_wrong_length_costs_its_own_message_only() {
        let small = "Content-Length: 4\r\n\r\n[1,2]Content-Length: 2\r\n\r\n{}";
        assert_eq!(frames(small), ["[1,2", "!something", "{}"]);
        let large = "Content-Length: 400\r\n\r\n[1]Content-Length: 2\r\n\r\n{}";
        assert_eq!(frames(large), ["[1]", "{}"]);
        let no_number = "Content-Length: -4\r\n\r\n[1]\nContent-Length: 2\r\n\r\n{}";
        assert_eq!(frames(no_number), ["!a", "{}"]);
    }

    #[test]
    fn a_huge_length_needs_no_memory() {
        for length in ["99999999999", "99999999999999999999999999"] {
            let stream =
                format!("Content-Length: {length}\r\n\r\n[1]Content-Length: 2\r\n\r\n{{}}");
            assert_eq!(frames(&stream), ["!a", "{}"]);
        }
        let mut frames = Frames::default();
        frames.push(b"Content-Length: 200000000\r\n\r\n{");
        assert_eq!(frames.next(), None);
        assert!(frames.bytes.capacity() < 1 << 20);
    }

    #[test]
    fn a_body_that_speaks_of_headers_is_whole() {
        let body = r#"{"text":"Content-Length: 12\r\n\r\n"}"#;
        let stream = format!("Content-Length: {}\r\n\r\n{body}", body.len());
        assert_eq!(frames(&stream), [body]);
    }

    #[test]
    fn a_header_that_begins_in_a_body_is_found() {
        for (body, at) in [
            ("{}Cont", Some(2)),
            ("{c", Some(1)),
            ("{\ncontent-length: 4\r", Some(2)),
            ("{}", None),
        ] {
            assert_eq!(header_at_end(body.as_bytes()), at, "{body}");
        }
    }

    #[test]
    fn the_end_of_a_body_can_be_given_back() {
        let mut frames = Frames::default();
        frames.push(b"Content-Length: 6\r\n\r\n{}Content-Length: 2\r\n\r\n[]");
        assert_eq!(frames.next(), Some(Frame::Body(b"{}Cont".to_vec())));
        frames.unread(b"Cont");
        assert_eq!(frames.next(), Some(Frame::Body(b"[]".to_vec())));
    }
}
