//! Tcl values: lists, glob patterns, abbreviated words, UTF-8 as Tcl reads it.

/// Formats a list so that Tcl reads the same elements back, quoted as Tcl itself does.
pub(crate) fn list<I, S>(elements: I) -> String
where
    I: IntoIterator<Item = S>,
    S: AsRef<str>,
{
    let mut out = String::new();
    for (index, element) in elements.into_iter().enumerate() {
        if index > 0 {
            out.push(' ');
        }
        push_element(&mut out, element.as_ref(), index == 0);
    }
    out
}

fn push_element(out: &mut String, text: &str, first: bool) {
    match quoting(text, first) {
        Quoting::None => out.push_str(text),
        Quoting::Braces => {
            out.push('{');
            out.push_str(text);
            out.push('}');
        }
        Quoting::Escapes => {
            for (index, c) in text.chars().enumerate() {
                match c {
                    '\n' => out.push_str("\\n"),
                    '\t' => out.push_str("\\t"),
                    '\r' => out.push_str("\\r"),
                    '\u{b}' => out.push_str("\\v"),
                    '\u{c}' => out.push_str("\\f"),
                    ']' | '[' | '$' | ';' | ' ' | '\\' | '"' | '{' | '}' => {
                        out.push('\\');
                        out.push(c);
                    }
                    '#' if index == 0 && first => out.push_str("\\#"),
                    _ => out.push(c),
                }
            }
        }
    }
}

#[derive(PartialEq)]
enum Quoting {
    None,
    Braces,
    Escapes,
}

fn quoting(text: &str, first: bool) -> Quoting {
    if text.is_empty() {
        return Quoting::Braces;
    }
    let start = text.as_bytes()[0];
    let mut braces = matches!(start, b'{' | b'"') || (start == b'#' && first);
    let mut escapes = false;
    let mut depth = 0i32;
    let mut bytes = text.bytes().enumerate().peekable();
    while let Some((index, byte)) = bytes.next() {
        match byte {
            b'{' => depth += 1,
            b'}' => {
                depth -= 1;
                if depth < 0 {
                    return Quoting::Escapes;
                }
            }
            b'"' if index == 0 => {}
            b']' | b'"' => escapes = true,
            b'[' | b'$' | b';' | b' ' | b'\n' | b'\t' | b'\r' | 0x0b | 0x0c => braces = true,
            b'\\' => {
                braces = true;
                match bytes.peek() {
                    None | Some((_, b'\n')) => return Quoting::Escapes,
                    Some((_, b'{' | b'}' | b'\\')) => {
                        bytes.next();
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }
    if depth != 0 {
        Quoting::Escapes
    } else if braces {
        Quoting::Braces
    } else if escapes {
        Quoting::Escapes
    } else {
        Quoting::None
    }
}

/// Reads a list.
///
/// # Errors
/// Returns Tcl's message for an unbalanced list.
pub(crate) fn parse_list(text: &str) -> Result<Vec<String>, String> {
    let chars: Vec<char> = text.chars().collect();
    let mut out = Vec::new();
    let mut at = 0;
    let blank = |c: char| matches!(c, ' ' | '\n' | '\t' | '\r' | '\u{b}' | '\u{c}');
    while at < chars.len() {
        if blank(chars[at]) {
            at += 1;
            continue;
        }
        let mut element = String::new();
        match chars[at] {
            '{' => {
                let mut depth = 1;
                at += 1;
                loop {
                    match chars.get(at) {
                        None => return Err("unmatched open brace in list".into()),
                        Some('\\') if at + 1 < chars.len() => {
                            element.push('\\');
                            at += 1;
                        }
                        Some('{') => depth += 1,
                        Some('}') => {
                            depth -= 1;
                            if depth == 0 {
                                break;
                            }
                        }
                        _ => {}
                    }
                    element.push(chars[at]);
                    at += 1;
                }
                at += 1;
                if chars.get(at).is_some_and(|c| !blank(*c)) {
                    return Err(trailing("braces", &chars[at..]));
                }
            }
            '"' => {
                at += 1;
                loop {
                    match chars.get(at) {
                        None => return Err("unmatched open quote in list".into()),
                        Some('"') => break,
                        Some('\\') => at += escape(&chars[at..], &mut element),
                        Some(c) => {
                            element.push(*c);
                            at += 1;
                        }
                    }
                }
                at += 1;
                if chars.get(at).is_some_and(|c| !blank(*c)) {
                    return Err(trailing("quotes", &chars[at..]));
                }
            }
            _ => {
                while let Some(&c) = chars.get(at) {
                    match c {
                        '\\' => at += escape(&chars[at..], &mut element),
                        _ if blank(c) => break,
                        _ => {
                            element.push(c);
                            at += 1;
                        }
                    }
                }
            }
        }
        out.push(element);
    }
    Ok(out)
}

fn trailing(what: &str, rest: &[char]) -> String {
    let word: String = rest.iter().take_while(|c| !c.is_whitespace()).collect();
    format!("list element in {what} followed by \"{word}\" instead of space")
}

/// Appends the characters of a backslash sequence; returns its length.
fn escape(text: &[char], out: &mut String) -> usize {
    let number = |digits: &[char], radix: u32, max: usize| {
        let taken: String = digits.iter().take(max).take_while(|c| c.is_digit(radix)).collect();
        let value = u32::from_str_radix(&taken, radix).ok();
        (taken.len(), value.and_then(char::from_u32))
    };
    let Some(&c) = text.get(1) else {
        out.push('\\');
        return 1;
    };
    match c {
        'a' => out.push('\u{7}'),
        'b' => out.push('\u{8}'),
        'f' => out.push('\u{c}'),
        'n' => out.push('\n'),
        'r' => out.push('\r'),
        't' => out.push('\t'),
        'v' => out.push('\u{b}'),
        'x' | 'u' | 'U' => {
            let max = match c {
                'x' => 2,
                'u' => 4,
                _ => 8,
            };
            let (length, value) = number(&text[2..], 16, max);
            if length == 0 {
                out.push(c);
            } else {
                out.push(value.unwrap_or(char::REPLACEMENT_CHARACTER));
                return 2 + length;
            }
        }
        '0'..='7' => {
            let (length, value) = number(&text[1..], 8, 3);
            out.push(value.unwrap_or(char::REPLACEMENT_CHARACTER));
            return 1 + length;
        }
        '\n' => {
            out.push(' ');
            let blanks = text[2..].iter().take_while(|c| matches!(c, ' ' | '\t'));
            return 2 + blanks.count();
        }
        c => out.push(c),
    }
    2
}

/// `string match PATTERN TEXT`.
pub(crate) fn glob_match(pattern: &str, text: &str) -> bool {
    let pattern: Vec<char> = pattern.chars().collect();
    let text: Vec<char> = text.chars().collect();
    // The position to resume at when the last `*` matches one more character.
    let mut retry: Option<(usize, usize)> = None;
    let (mut p, mut t) = (0, 0);
    while t < text.len() {
        let step = match pattern.get(p) {
            Some('*') => {
                retry = Some((p + 1, t));
                p += 1;
                continue;
            }
            Some('?') => Some(1),
            Some('[') => match_set(&pattern[p..], text[t]),
            Some('\\') if p + 1 < pattern.len() => (pattern[p + 1] == text[t]).then_some(2),
            Some(c) if *c == text[t] => Some(1),
            _ => None,
        };
        match (step, retry) {
            (Some(length), _) => {
                p += length;
                t += 1;
            }
            (None, Some((after, from))) => {
                retry = Some((after, from + 1));
                (p, t) = (after, from + 1);
            }
            (None, None) => return false,
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

/// Length of the `[set]` at the start of the pattern if it contains the character.
fn match_set(pattern: &[char], c: char) -> Option<usize> {
    let mut at = 1;
    let mut found = false;
    while at < pattern.len() && pattern[at] != ']' {
        let low = pattern[at];
        if pattern.get(at + 1) == Some(&'-') && at + 2 < pattern.len() {
            let high = pattern[at + 2];
            found |= (low.min(high)..=low.max(high)).contains(&c);
            at += 3;
        } else {
            found |= low == c;
            at += 1;
        }
    }
    found.then_some((at + 1).min(pattern.len()))
}

/// Finds a word by exact name or unambiguous prefix.
///
/// # Errors
/// Returns `bad WHAT "X": must be A, B, or C`, or the same starting with `ambiguous`.
pub(crate) fn find_word(words: &[&str], wanted: &str, what: &str) -> Result<usize, String> {
    if let Some(exact) = words.iter().position(|word| *word == wanted) {
        return Ok(exact);
    }
    let mut matches = words.iter().enumerate().filter(|(_, word)| word.starts_with(wanted));
    match (matches.next(), matches.next()) {
        (Some((index, _)), None) if !wanted.is_empty() => Ok(index),
        (first, second) => {
            let many = first.is_some() && second.is_some();
            let adjective = if many { "ambiguous" } else { "bad" };
            Err(format!("{adjective} {what} \"{wanted}\": must be {}", alternatives(words)))
        }
    }
}

/// `a`, `a or b`, `a, b, or c`.
fn alternatives(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [one, two] => format!("{one} or {two}"),
        [most @ .., last] => format!("{}, or {last}", most.join(", ")),
    }
}

/// Reads UTF-8 as Tcl 8.6 does: a byte that is not part of a character stands for itself; all line ends
/// become newlines.
pub(crate) fn decode(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        out.push_str(chunk.valid());
        out.extend(chunk.invalid().iter().map(|byte| char::from(*byte)));
    }
    if out.contains('\r') {
        out = out.replace("\r\n", "\n").replace('\r', "\n");
    }
    out
}

/// The text after an 8-bit channel: the low byte of every character.
pub(crate) fn low_bytes(text: &str) -> String {
    text.chars().map(|c| char::from(c as u32 as u8)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_quoted_as_tcl_does() {
        for (element, quoted) in [
            ("", "{}"),
            ("a", "a"),
            ("a b", "{a b}"),
            ("a\"b", "a\\\"b"),
            ("\"ab", "{\"ab}"),
            ("a]b", "a\\]b"),
            ("a b]", "{a b]}"),
            ("a[b", "{a[b}"),
            ("a\\b", "{a\\b}"),
            ("ab\\", "ab\\\\"),
            ("a{b", "a\\{b"),
            ("a{}b", "a{}b"),
            ("{}", "{{}}"),
            ("a{ b", "a\\{\\ b"),
            ("a\\\nb", "a\\\\\\nb"),
            ("a}{b", "a\\}\\{b"),
            ("a\\{", "{a\\{}"),
            ("é ∈", "{é ∈}"),
            ("#", "#"),
        ] {
            assert_eq!(list(["z", element]), format!("z {quoted}"));
            assert_eq!(parse_list(&list(["z", element])).unwrap()[1], element);
        }
        assert_eq!(list(["#a"]), "{#a}");
    }

    #[test]
    fn lists_are_read_as_tcl_does() {
        let read = |text: &str| parse_list(text).unwrap().join("|");
        assert_eq!(read("a {b c} \"d e\"  f\\ g\n\\x41\\u00e9"), "a|b c|d e|f g|Aé");
        assert_eq!(read("{a {b c}} {\\}}"), "a {b c}|\\}");
        assert!(parse_list("{a").is_err());
        assert!(parse_list("{a}b").is_err());
    }

    #[test]
    fn globs() {
        assert!(glob_match("*::s*", "::order::start"));
        assert!(glob_match("a[b-d]?\\*", "acx*"));
        assert!(!glob_match("a[b-d]", "ae"));
        assert!(!glob_match("n*", "order"));
        assert!(glob_match("", ""));
    }

    #[test]
    fn words_may_be_abbreviated() {
        let words = ["name", "doc", "throws", "task", "tasks"];
        assert_eq!(find_word(&words, "thr", "subcommand"), Ok(2));
        assert_eq!(find_word(&words, "task", "subcommand"), Ok(3));
        assert_eq!(
            find_word(&words, "t", "subcommand").unwrap_err(),
            "ambiguous subcommand \"t\": must be name, doc, throws, task, or tasks"
        );
        assert_eq!(
            find_word(&["file", "string"], "x", "subcommand").unwrap_err(),
            "bad subcommand \"x\": must be file or string"
        );
    }

    #[test]
    fn bytes_that_are_not_characters_survive() {
        assert_eq!(decode(b"caf\xc3\xa9 \xe9\r\nx"), "caf\u{e9} \u{e9}\nx");
        assert_eq!(low_bytes("\u{2208}é"), "\u{8}é");
    }
}
