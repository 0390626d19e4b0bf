//! Markdown around foreign text: names, file names, comments, `doc` texts. Foreign text is data, and is shown
//! unchanged, even if it contains Markdown syntax.

use std::borrow::Cow;

/// A text without Markdown meaning. Its line ends and blank lines remain, but not its indentation: four
/// blanks would make it code.
pub fn text(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 8);
    for (index, line) in text.lines().enumerate() {
        if index > 0 {
            out.push('\n');
        }
        escape_line(line.trim(), &mut out);
    }
    out
}

fn escape_line(line: &str, out: &mut String) {
    let digits = line.bytes().take_while(u8::is_ascii_digit).count();
    let mut before = ' ';
    for (at, c) in line.char_indices() {
        let special = match c {
            '\\' | '`' | '*' | '[' | ']' | '<' | '>' | '&' | '|' | '~' => true,
            // Within a word it has no meaning.
            '_' => !(before.is_alphanumeric() && line[at + 1..].starts_with(char::is_alphanumeric)),
            // Characters that begin a heading, a list, a rule or a table, at the beginning of a line.
            '#' | '+' | '-' | '=' => at == 0,
            '.' | ')' => at == digits && digits > 0,
            // Editors make links of addresses.
            ':' => line[at..].starts_with("://"),
            _ => false,
        };
        before = c;
        if special {
            out.push('\\');
        }
        out.push(visible(c));
    }
}

/// A text as code within a line.
pub fn code(text: &str) -> String {
    let text: String = text
        .chars()
        .map(
            |character| {
                if character == '\n' || character == '\r' { ' ' } else { visible(character) }
            },
        )
        .collect();
    let ticks = ticks(&text, 1);
    // Markdown removes one blank at both ends.
    let padded = text.starts_with('`')
        || text.ends_with('`')
        || text.starts_with(' ') && text.ends_with(' ');
    let blank = if padded { " " } else { "" };
    format!("{ticks}{blank}{text}{blank}{ticks}")
}

/// A text as a block of code in a language.
pub fn block(language: &str, text: &str) -> String {
    let ticks = ticks(text, 3);
    let text: Cow<'_, str> =
        if text.chars().all(|character| character == '\n' || visible(character) == character) {
            text.into()
        } else {
            text.chars()
                .map(|character| if character == '\n' { character } else { visible(character) })
                .collect()
        };
    format!("{ticks}{language}\n{text}\n{ticks}")
}

/// Backquotes: more than in any run in the text, and at least `least`.
fn ticks(text: &str, least: usize) -> String {
    let longest = text.split(|character| character != '`').map(str::len).max().unwrap_or(0);
    let count = if longest == 0 { least } else { (longest + 1).max(least) };
    "`".repeat(count)
}

/// Replaces control characters by U+FFFD: a viewer hides them or executes them. The same applies to
/// characters that change the direction of the text, which could make it look like another text.
fn visible(c: char) -> char {
    match c {
        '\t' => ' ',
        '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => char::REPLACEMENT_CHARACTER,
        c if c.is_control() => char::REPLACEMENT_CHARACTER,
        c => c,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_stands_for_itself() {
        for (given, expected) in [
            ("plain words, 1.5 m/s (max)", "plain words, 1.5 m/s (max)"),
            ("# no heading", "\\# no heading"),
            ("1. no list\n- nor this", "1\\. no list\n\\- nor this"),
            ("    no code", "no code"),
            ("a\n\nb", "a\n\nb"),
            ("[x](command:evil)", "\\[x\\](command:evil)"),
            ("![x](http://e.org/a.png)", "!\\[x\\](http\\://e.org/a.png)"),
            ("<script>&amp;</script>", "\\<script\\>\\&amp;\\</script\\>"),
            ("```\n`x`", "\\`\\`\\`\n\\`x\\`"),
            ("a | b\n---", "a \\| b\n\\---"),
            ("a\u{1b}[31mb\u{202e}", "a\u{fffd}\\[31mb\u{fffd}"),
            ("*a* __b__ ~~c~~ d_e", "\\*a\\* \\_\\_b\\_\\_ \\~\\~c\\~\\~ d_e"),
        ] {
            assert_eq!(text(given), expected);
        }
    }

    #[test]
    fn code_ends_where_it_ends() {
        for (given, expected) in [
            ("a.gen", "`a.gen`"),
            ("", "``"),
            ("a`b", "``a`b``"),
            ("`a``", "``` `a`` ```"),
            ("a\nb\u{7}", "`a b\u{fffd}`"),
        ] {
            assert_eq!(code(given), expected);
        }
        assert_eq!(block("genom", "a\n```\nb"), "````genom\na\n```\nb\n````");
        assert_eq!(block("c", "a"), "```c\na\n```");
    }
}
