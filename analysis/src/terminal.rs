//! Text for terminals. Foreign names and texts are data: a file name may contain control characters of a
//! terminal.

use std::borrow::Cow;
use std::fmt::Write;

/// A text that is safe for a terminal: line ends and tabs stay. Other control characters, and characters
/// that change the direction of the text, are shown as `\u{1b}`.
pub fn text(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_harmful) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_harmful(c) {
            // Writing to a string cannot fail.
            let _ = write!(out, "\\u{{{:x}}}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    out.into()
}

/// A name on one line.
pub fn name(name: &str) -> Cow<'_, str> {
    match text(name) {
        shown if shown.contains(['\n', '\t']) => {
            shown.replace('\n', "\\n").replace('\t', "\\t").into()
        }
        shown => shown,
    }
}

/// A text with colours of this program that is safe for a terminal: as [`text`], but colours stay.
pub fn styled(styled: &str) -> String {
    let mut out = String::with_capacity(styled.len() + 8);
    let mut rest = styled;
    while let Some(start) = rest.find("\u{1b}[") {
        let after = &rest[start + 2..];
        let end = after.find(|c: char| !c.is_ascii_digit() && c != ';').unwrap_or(after.len());
        out += &text(&rest[..start]);
        if after[end..].starts_with('m') {
            out += &rest[start..=(start + 2 + end)];
        } else {
            out += &text(&rest[start..start + 2 + end]);
        }
        rest = &after[end + usize::from(after[end..].starts_with('m'))..];
    }
    out += &text(rest);
    out
}

fn is_harmful(c: char) -> bool {
    let direction = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    direction || c.is_control() && !matches!(c, '\n' | '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_reaches_the_terminal_that_it_obeys() {
        assert!(matches!(text("plain é 😀\n\tx"), Cow::Borrowed(_)));
        assert_eq!(text("a\u{1b}]0;x\u{7}b\r\u{9b}31m"), "a\\u{1b}]0;x\\u{7}b\\u{d}\\u{9b}31m");
        assert_eq!(text("\u{202e}neg."), "\\u{202e}neg.");
        assert_eq!(styled("\u{1b}[1;31ma\u{202e}\u{1b}[0m"), "\u{1b}[1;31ma\\u{202e}\u{1b}[0m");
        assert_eq!(styled("\u{1b}[2Jé\u{1b}"), "\\u{1b}[2Jé\\u{1b}");
        assert_eq!(name("a\nb\u{8}"), "a\\nb\\u{8}");
    }
}
