//! Places of a unit in its files, as GenoM3 reports them.

use std::ops::Range;
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::UnitResult;
use dotgen_analysis::model::Src;
use dotgen_analysis::source_map::{Locations, MacroCall};
use rustc_hash::FxHashMap;

use super::INLINE;
use crate::lang::{Anchor, Place, Places};

/// Places of a compiled unit, as GenoM3 reports them: the end of a token.
pub(super) struct UnitPlaces {
    pub(super) unit: UnitResult,
    pub(super) texts: FxHashMap<Utf8PathBuf, Arc<str>>,
    /// The names of files in templates.
    pub(super) names: FxHashMap<Utf8PathBuf, String>,
}

impl Places for UnitPlaces {
    fn place(&self, src: Src, anchor: Anchor<'_>) -> Option<Place> {
        let location = self.unit.locations.locate(src)?;
        let text = self.texts.get(&location.path).map_or("", |text| text);
        let start = location.range.start.min(text.len());
        let end = match anchor {
            Anchor::First => start + first_token(text.get(start..).unwrap_or_default()),
            Anchor::Named(name) => {
                let range = text.get(start..location.range.end).unwrap_or_default();
                start + declared_name(range, name).unwrap_or_else(|| first_token(range))
            }
            Anchor::Path => {
                let range = text.get(start..location.range.end).unwrap_or_default();
                start + path_start(range).unwrap_or_else(|| first_token(range))
            }
            Anchor::Keyword(word) => {
                keyword_before(text, start, word).unwrap_or(location.range.end).min(text.len())
            }
        };
        let before = text.as_bytes().get(..end).unwrap_or_default();
        let lines = before.iter().filter(|byte| **byte == b'\n').count();
        let line_start = before.iter().rposition(|byte| *byte == b'\n');
        let line_start = line_start.map_or(0, |at| at + 1);
        // The preprocessor's mark before a file's first line moves its columns by one.
        let column =
            end - line_start + usize::from(line_start == 0) - commented(text, line_start..end);
        let calls = self.unit.locations.macro_calls(src);
        let column = expanded(text, calls, line_start..end, column);
        let inline = location.path.file_name() == Some(INLINE);
        Some(Place {
            file: if inline {
                INLINE.to_owned()
            } else {
                let name = self.names.get(&location.path);
                name.map_or_else(|| location.path.to_string(), String::clone)
            },
            line: u32::try_from(lines + 1).unwrap_or(u32::MAX),
            column: u32::try_from(column).unwrap_or(u32::MAX),
        })
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// The number of characters by which the preprocessor shortens a line: it writes one blank for each comment.
fn commented(text: &str, line: Range<usize>) -> usize {
    let mut less = 0;
    let before = text.get(..line.start).unwrap_or_default();
    let mut line = text.get(line).unwrap_or_default();
    // A comment that began on an earlier line may end in this line.
    if before.rfind("/*") > before.rfind("*/")
        && let Some(end) = line.find("*/")
    {
        less += end + 1;
        line = &line[end + 2..];
    }
    while let Some((_, comment)) = line.split_once("/*") {
        let Some((inside, rest)) = comment.split_once("*/") else {
            break;
        };
        less += inside.len() + 3;
        line = rest;
    }
    less
}

/// The column of the end of a part of a line, after expansion of the macros in that part.
fn expanded(text: &str, calls: &[MacroCall], part: Range<usize>, column: usize) -> usize {
    let from = calls.partition_point(|call| call.range.start < part.start);
    let mut column = column;
    for call in &calls[from..] {
        if call.range.end >= part.end {
            break;
        }
        // The preprocessor inserts a blank before punctuation.
        let before = text[..call.range.start].bytes().next_back();
        let apart = call.punctuation && before.is_some_and(|byte| !byte.is_ascii_whitespace());
        column += call.expanded + usize::from(apart);
        column = column.saturating_sub(call.range.len());
    }
    column
}

/// Length of the token at the start of a text.
fn first_token(text: &str) -> usize {
    if let Some(quote) = text.chars().next().filter(|c| matches!(c, '"' | '\'')) {
        let mut escaped = false;
        for (at, c) in text.char_indices().skip(1) {
            match c {
                _ if escaped => escaped = false,
                '\\' => escaped = true,
                c if c == quote => return at + 1,
                _ => {}
            }
        }
        return text.len();
    }
    let digit = |at: usize| text.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    if digit(0) || (text.starts_with('.') && digit(1)) {
        return number(text);
    }
    let word = text.bytes().take_while(|byte| is_word(*byte)).count();
    match word {
        0 if text.starts_with("::") => 2,
        0 => text.chars().next().map_or(0, char::len_utf8),
        word => {
            // The only words with a dash (language reference, lexical elements).
            let dashed = ["clock-rate", "codels-requires", "codels-require", "real-time"];
            let dashed = dashed.iter().find(|option| text.starts_with(**option));
            dashed.map_or(word, |text| text.len())
        }
    }
}

/// Length of the number at the start of a text, with its unit.
fn number(text: &str) -> usize {
    let bytes = text.as_bytes();
    let is = |at: usize, set: &[u8]| bytes.get(at).is_some_and(|byte| set.contains(byte));
    let digits = |from: usize, radix: u32| {
        let rest = bytes.iter().skip(from);
        rest.take_while(|byte| char::from(**byte).is_digit(radix)).count()
    };
    let hex = match bytes {
        [b'0', b'x' | b'X', ..] => digits(2, 16),
        _ => 0,
    };
    let whole = digits(0, 10);
    let mut end = if hex > 0 { 2 + hex } else { whole };
    let mut real = false;
    if hex == 0 && is(end, b".") {
        end += 1 + digits(end + 1, 10);
        real = true;
    }
    if hex == 0 && is(end, b"eE") {
        let sign = usize::from(is(end + 1, b"+-"));
        let exponent = digits(end + 1 + sign, 10);
        if exponent > 0 {
            end += 1 + sign + exponent;
            real = true;
        }
    }
    if real {
        end + usize::from(is(end, b"fFlLdD"))
    } else if is(end, b"uU") {
        end + 1 + usize::from(is(end + 1, b"lL"))
    } else if is(end, b"lL") {
        end + 1 + usize::from(is(end + 1, b"uU"))
    } else {
        end
    }
}

/// The ends of the tokens of a text, with the tokens.
fn tokens(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = text.get(at..)?;
        let skipped = rest.len() - rest.trim_start().len();
        let rest = rest.trim_start();
        let length = first_token(rest);
        if length == 0 {
            return None;
        }
        at += skipped + length;
        Some((at, rest.get(..length)?))
    })
}

/// End of the name in the declaration of a parameter: the last name before its value or its end.
fn declared_name(text: &str, name: &str) -> Option<usize> {
    let tokens: Vec<(usize, &str)> = tokens(text).collect();
    tokens
        .iter()
        .enumerate()
        .find(|(index, (_, token))| {
            let next = tokens.get(index + 1).map(|(_, token)| *token);
            *token == name && matches!(next, None | Some("=" | ":" | "[" | "," | ")" | ";"))
        })
        .map(|(_, (end, _))| *end)
}

/// End of the first token after the source and the direction of a parameter.
fn path_start(text: &str) -> Option<usize> {
    let mut direction = false;
    for (end, token) in tokens(text) {
        match token {
            "ids" | "local" | "port" | "remote" if !direction => {}
            "in" | "out" | "inout" if !direction => direction = true,
            _ => return Some(end),
        }
    }
    None
}

/// End of the last occurrence of a keyword before an offset. The keyword of a declaration in a macro is in
/// the macro's definition, which does not count.
fn keyword_before(text: &str, start: usize, word: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut until = start;
    loop {
        let at = text.get(..until)?.rfind(word)?;
        let end = at + word.len();
        let before = at > 0 && is_word(bytes[at - 1]);
        let after = bytes.get(end).is_some_and(|byte| is_word(*byte));
        let alone = !before && !after;
        if alone {
            // Only ports have a type before their name; the type may contain punctuation.
            let another = |characters| word != "port" && text[end..start].contains(characters);
            let elsewhere = another([';', '{', '}']) || is_in_directive(text, at);
            return (!elsewhere).then_some(end);
        }
        until = at;
    }
}

/// True if the line of an offset is a directive, or the continuation of one.
fn is_in_directive(text: &str, at: usize) -> bool {
    let mut start = at;
    loop {
        start = text[..start].rfind('\n').map_or(0, |end| end + 1);
        let before = text[..start].trim_end_matches(['\n', '\r']);
        if start == 0 || !before.ends_with('\\') {
            break;
        }
        start = before.len();
    }
    text[start..at].trim_start().starts_with('#')
}
