//! A body as JSON, and the answers to bodies that are not valid messages.

use serde_json::{Value, json};
use tower_lsp::jsonrpc::{Request, Response};

/// Codes of errors, by JSON-RPC and the protocol.
pub(super) mod code {
    pub(in crate::session::transport) const PARSE_ERROR: i64 = -32700;
    pub(in crate::session::transport) const INVALID_REQUEST: i64 = -32600;
    pub(in crate::session::transport) const METHOD_NOT_FOUND: i64 = -32601;
    pub(in crate::session::transport) const INTERNAL_ERROR: i64 = -32603;
    pub(in crate::session::transport) const NOT_INITIALIZED: i64 = -32002;
}

/// The content of a body.
#[derive(Debug)]
pub(super) struct Parsed {
    pub(super) value: Value,
    /// True if half of a surrogate pair was replaced by U+FFFD.
    pub(super) mended: bool,
    /// Bytes after the value, which belong to the next message.
    pub(super) rest: Vec<u8>,
}

/// Reads a body.
///
/// Half of a surrogate pair (`\ud800`) is not valid text. Editors send it if an edit splits a character. It
/// becomes U+FFFD, which also is one UTF-16 unit, so that all positions remain valid.
///
/// # Errors
/// The error in the JSON, as text.
pub(super) fn parse(body: &[u8]) -> Result<Parsed, String> {
    let first = match parse_one(body) {
        Ok((value, end)) => {
            return Ok(Parsed {
                value,
                mended: false,
                rest: body[end..].trim_ascii_start().to_vec(),
            });
        }
        Err(error) => error,
    };
    let mut text = String::from_utf8_lossy(body).into_owned().into_bytes();
    let halves = replace_halves(&mut text);
    if halves || text != body {
        let (value, end) = parse_one(&text)?;
        return Ok(Parsed { value, mended: true, rest: text[end..].trim_ascii_start().to_vec() });
    }
    Err(first)
}

fn parse_one(body: &[u8]) -> Result<(Value, usize), String> {
    let mut stream = serde_json::Deserializer::from_slice(body).into_iter::<Value>();
    match stream.next() {
        Some(Ok(value)) => Ok((value, stream.byte_offset())),
        Some(Err(error)) => Err(error.to_string()),
        None => Err("the message is empty".to_owned()),
    }
}

/// Replaces each `\uXXXX` that is half of a surrogate pair by `\ufffd`. Returns true if there was one.
fn replace_halves(text: &mut [u8]) -> bool {
    let unit = |text: &[u8], at: usize| -> Option<u32> {
        let digits = text.get(at..at + 6)?.strip_prefix(b"\\u")?;
        let digits = str::from_utf8(digits).ok()?;
        u32::from_str_radix(digits, 16).ok()
    };
    let mut found = false;
    let mut at = 0;
    while at < text.len() {
        if text[at] != b'\\' {
            at += 1;
            continue;
        }
        at += match unit(text, at) {
            Some(0xd800..=0xdbff) if matches!(unit(text, at + 6), Some(0xdc00..=0xdfff)) => 12,
            Some(0xd800..=0xdfff) => {
                text[at + 2..at + 6].copy_from_slice(b"fffd");
                found = true;
                6
            }
            // Another escape: the character after the backslash does not begin an escape.
            _ => 2,
        };
    }
    found
}

/// A message by its kind.
#[derive(Debug)]
pub(super) enum Incoming {
    /// A request, or without `id` a notification.
    Request(Request),
    /// The answer to a request of the server.
    Response(Response),
    /// Neither, with the `id` if there is one, and the error.
    Invalid(Value, String),
}

/// Determines the kind of a message.
pub(super) fn classify(mut value: Value) -> Incoming {
    let id = value.get("id").cloned().unwrap_or_default();
    let Some(fields) = value.as_object_mut() else {
        let message = "a message is an object with a `method`, or with a `result` or an `error`";
        return Incoming::Invalid(Value::Null, message.to_owned());
    };
    // The version of JSON-RPC may be missing.
    fields.insert("jsonrpc".to_owned(), json!("2.0"));
    if fields.get("method").is_some_and(Value::is_string) {
        return match serde_json::from_value(value) {
            Ok(request) => Incoming::Request(request),
            Err(error) => Incoming::Invalid(id, format!("this is no request: {error}")),
        };
    }
    if fields.contains_key("method") {
        return Incoming::Invalid(id, "the `method` of a message is a text".to_owned());
    }
    let answers = fields.contains_key("result") || fields.contains_key("error");
    match answers.then(|| serde_json::from_value(value)) {
        Some(Ok(response)) => Incoming::Response(response),
        // An invalid response gets no answer.
        Some(Err(error)) => Incoming::Invalid(Value::Null, format!("this is no answer: {error}")),
        None => Incoming::Invalid(id, "a message has a `method`".to_owned()),
    }
}

/// The error response to an invalid message.
pub(super) fn failure(id: &Value, code: i64, message: &str) -> Value {
    json!({ "jsonrpc": "2.0", "id": id, "error": { "code": code, "message": message } })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(body: &str) -> (Value, bool) {
        let parsed = parse(body.as_bytes()).expect("JSON");
        (parsed.value, parsed.mended)
    }

    #[test]
    fn half_a_character_is_replaced_and_nothing_else() {
        let mended = |body: &str| text(body);
        assert_eq!(mended(r#""a\ud83db""#), (json!("a\u{fffd}b"), true));
        assert_eq!(mended(r#""\uDE00""#), (json!("\u{fffd}"), true));
        assert_eq!(mended(r#""\ud83d\ud83d\ude00""#), (json!("\u{fffd}😀"), true));
        assert_eq!(mended(r#""\ud83d\ude00""#), (json!("😀"), false));
        assert_eq!(mended(r#""\\ud83d""#), (json!(r"\ud83d"), false));
        assert_eq!(mended(r#"["\\\ud83d"]"#), (json!(["\\\u{fffd}"]), true));
    }

    #[test]
    fn bytes_that_are_no_characters_are_replaced() {
        let parsed = parse(b"\"caf\xe9\"").expect("JSON");
        assert_eq!(parsed.value, json!("caf\u{fffd}"));
        assert!(parsed.mended);
    }

    #[test]
    fn what_is_no_json_is_told() {
        for body in ["", "{", "{\"a\":}", "nope", "\"\\u12\""] {
            assert!(parse(body.as_bytes()).is_err(), "{body}");
        }
        let deep = "[".repeat(100_000);
        assert!(parse(deep.as_bytes()).is_err());
    }

    #[test]
    fn what_follows_a_value_is_kept() {
        let parsed = parse(b"{} \n Content-").expect("JSON");
        assert_eq!(parsed.rest, b"Content-");
    }

    #[test]
    fn messages_that_are_none_keep_their_id() {
        let id = |value: Value| match classify(value) {
            Incoming::Invalid(id, _) => id,
            other => panic!("{other:?}"),
        };
        assert_eq!(id(json!([])), Value::Null);
        assert_eq!(id(json!({ "id": 4 })), json!(4));
        assert_eq!(id(json!({ "id": 4, "method": 5 })), json!(4));
        assert_eq!(id(json!({ "id": 1.5, "method": "x" })), json!(1.5));
    }
}
