//! The width of output lines.

use terminal_size::{Width, terminal_size_of};

/// Number of columns without a terminal, and maximum number with one.
const MAX_COLUMNS: usize = 100;

/// Returns the number of columns for output.
fn columns() -> usize {
    let terminal =
        terminal_size_of(std::io::stdout()).map(|(Width(columns), _)| usize::from(columns));
    terminal.map_or(MAX_COLUMNS, |terminal| terminal.clamp(40, MAX_COLUMNS))
}

/// Breaks a text between words. The first line has `first` columns before the text. All other lines begin
/// with `indent` blanks.
pub(super) fn wrapped(text: &str, first: usize, indent: usize) -> String {
    broken(text, columns(), first, indent)
}

fn broken(text: &str, columns: usize, first: usize, indent: usize) -> String {
    let mut out = String::new();
    let mut at = first;
    for word in text.split(' ') {
        let length = word.chars().count();
        if out.is_empty() {
            at += length;
        } else if at + 1 + length <= columns {
            out.push(' ');
            at += 1 + length;
        } else {
            out.push('\n');
            out.push_str(&" ".repeat(indent));
            at = indent + length;
        }
        out.push_str(word);
    }
    out
}

#[cfg(test)]
mod tests {
    #[test]
    fn lines_break_between_words() {
        let text = "one two three four";
        assert_eq!(super::broken(text, 40, 10, 2), text);
        assert_eq!(super::broken(text, 12, 4, 2), "one two\n  three four");
        assert_eq!(super::broken("long", 2, 1, 1), "long");
    }
}
