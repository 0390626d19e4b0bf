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
        match is_harmful(c) {
            true => {
                // Writing to a string cannot fail.
                let _ = write!(out, "\\u{{{:x}}}", u32::from(c));
            }
            false => out.push(c),
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
        assert_eq!(name("a\nb\u{8}"), "a\\nb\\u{8}");
    }
}
