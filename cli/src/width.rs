//! The width of output lines.

use terminal_size::{Height, Width, terminal_size_of};

/// Number of columns without a terminal, and maximum number with one.
const MAX_COLUMNS: usize = 100;

/// Returns the number of columns for output: those of the terminal, or else `$COLUMNS`.
pub(super) fn columns() -> usize {
    let variable = || {
        let columns = std::env::var("COLUMNS").ok()?.parse().ok()?;
        Some((Width(columns), Height(0)))
    };
    terminal_size_of(std::io::stdout()).or_else(variable).map_or(MAX_COLUMNS, limited)
}

fn limited((Width(columns), _): (Width, Height)) -> usize {
    usize::from(columns).clamp(40, MAX_COLUMNS)
}

/// Like [`wrapped`], for standard error. Without a terminal the text stays: programs read whole lines.
pub(super) fn wrapped_for_errors(text: &str, first: usize, indent: usize) -> String {
    match terminal_size_of(std::io::stderr()) {
        Some(size) => lines_broken(text, limited(size), first, indent),
        None => text.to_owned(),
    }
}

fn lines_broken(text: &str, columns: usize, first: usize, indent: usize) -> String {
    let mut before = first;
    let line = |line: &str| broken(line, columns, std::mem::take(&mut before), indent);
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// Breaks a text between words. The first line has `first` columns before the text. All other lines begin
/// with `indent` blanks.
pub(super) fn wrapped(text: &str, first: usize, indent: usize) -> String {
    broken(text, columns(), first, indent)
}

/// Breaks the titles of diagnostics on standard output, for a terminal. The rest shows sources: it stays.
pub(super) fn with_titles_broken(text: &str) -> String {
    titles_broken(text, terminal_size_of(std::io::stdout()))
}

/// Like [`with_titles_broken`], on standard error.
pub(super) fn with_titles_broken_for_errors(text: &str) -> String {
    titles_broken(text, terminal_size_of(std::io::stderr()))
}

/// A title begins with a word at the start of its line: `hint[fsm/busy-loop]: …`, `help: …`.
fn titles_broken(text: &str, terminal: Option<(Width, Height)>) -> String {
    let Some(size) = terminal else {
        return text.to_owned();
    };
    let line = |line: &str| match visible(line).next() {
        Some(c) if c.is_alphabetic() => broken(line, limited(size), 0, 2),
        _ => line.to_owned(),
    };
    text.split_inclusive('\n').map(line).collect()
}

/// Returns the text of a heading after its title, and a file in parentheses, which is faint.
pub(super) fn heading(title: &str, text: &str, file: &str) -> String {
    let faint = clap::builder::styling::Style::new().dimmed();
    let title = title.chars().count() + 2;
    let text = wrapped(text, title, 2);
    let last = text.lines().next_back().unwrap_or_default().chars().count();
    let before = if text.contains('\n') { last } else { title + last };
    let fits = before + file.chars().count() + 3 <= columns();
    let gap = if fits { " " } else { "\n  " };
    format!("{text}{gap}{faint}({file}){faint:#}")
}

/// The columns of a table.
pub(super) struct Table {
    /// Number of columns on the left whose cells are left-aligned. All others are right-aligned.
    pub(super) texts: usize,
    /// The column whose texts may be long. If a row does not fit, its text has lines of its own.
    pub(super) long: usize,
    /// Number of blanks before each row.
    pub(super) indent: usize,
}

impl Table {
    /// Minimum width of the long column.
    const MIN_LONG: usize = 16;

    /// Returns the rows as lines. The first row is the head. Columns that are empty below it are left out.
    pub(super) fn lines<'r>(&self, rows: &[impl AsRef<[&'r str]>]) -> Vec<String> {
        self.lines_in(rows, columns())
    }

    fn lines_in<'r>(&self, rows: &[impl AsRef<[&'r str]>], columns: usize) -> Vec<String> {
        let length = |text: &str| text.chars().count();
        let cells = |column: usize| rows.iter().map(move |row| length(row.as_ref()[column]));
        let count = rows.first().map_or(0, |row| row.as_ref().len());
        let width = |column: usize| match cells(column).skip(1).max() {
            Some(0) => 0,
            _ => cells(column).max().unwrap_or_default(),
        };
        let mut widths: Vec<usize> = (0..count).map(width).collect();
        let shown = widths.iter().filter(|width| **width > 0);
        let total = shown.map(|width| width + 2).sum::<usize>() + self.indent;
        if let Some(long) = widths.get_mut(self.long)
            && total > columns + 2
        {
            let room = (columns + 2 + *long).saturating_sub(total).max(Self::MIN_LONG);
            *long = cells(self.long).filter(|width| *width <= room).max().unwrap_or_default();
        }
        let row = |row: &[&str]| {
            let mut texts = row.to_vec();
            let own = length(row[self.long]) > widths[self.long];
            let long = if own { std::mem::take(&mut texts[self.long]) } else { "" };
            let cells = texts.iter().zip(&widths).enumerate().filter(|(_, cell)| *cell.1 > 0);
            let cells = cells.map(|(column, (text, &width))| {
                if column < self.texts {
                    format!("{text:<width$}")
                } else {
                    format!("{text:>width$}")
                }
            });
            let line = cells.collect::<Vec<_>>().join("  ");
            let line = format!("{:1$}{2}", "", self.indent, line.trim_end());
            match (own, self.long) {
                (false, _) => line,
                // A name is above its values.
                (true, 0) => format!("{:1$}{long}\n{line}", "", self.indent),
                (true, _) => {
                    let indent = self.indent + 4;
                    let long = broken(long, columns, indent, indent + 2);
                    format!("{line}\n{:indent$}{long}", "")
                }
            }
        };
        rows.iter().map(|cells| row(cells.as_ref())).collect()
    }
}

fn broken(text: &str, columns: usize, first: usize, indent: usize) -> String {
    let words = text.trim_start_matches(' ');
    let mut out = " ".repeat(text.len() - words.len());
    let mut at = first + out.len();
    for (number, word) in unbroken(words, columns * 3 / 4).into_iter().enumerate() {
        let length = visible(word).count();
        if number == 0 {
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

/// The characters of a text that take a column: all but those of styles (`ESC [ … m`) and line ends.
fn visible(text: &str) -> impl Iterator<Item = char> {
    let mut in_style = false;
    text.chars().filter(move |c| {
        let is_shown = !in_style && !['\u{1b}', '\r', '\n'].contains(c);
        in_style = *c == '\u{1b}' || (in_style && *c != 'm');
        is_shown
    })
}

/// The parts of a text between which lines break: words, numbers with their units (`1 / ms`, `5 ms`), and
/// commands and names in backquotes of at most so many columns, which users copy.
fn unbroken(text: &str, columns: usize) -> Vec<&str> {
    const UNITS: [&str; 12] =
        ["/", "ns", "us", "µs", "ms", "s", "min", "h", "%", "Hz", "MiB", "GiB"];
    let mut out = Vec::new();
    let (mut start, mut last) = (0, "");
    let quotes: Vec<usize> = text.match_indices('`').map(|(at, _)| at).collect();
    let quoted = |at: usize| {
        let pairs = quotes.as_chunks::<2>().0.iter();
        let mut pairs = pairs.filter(|[from, to]| (*from..*to).contains(&at));
        pairs.any(|[from, to]| text[*from..=*to].chars().count() <= columns)
    };
    for (at, _) in text.match_indices(' ').chain([(text.len(), "")]) {
        let next = text[at..].trim_start_matches(' ').split(' ').next().unwrap_or_default();
        last = text[start..at].rsplit(' ').next().unwrap_or(last);
        let unit = next.trim_end_matches(|c: char| !c.is_alphanumeric() && !"%/".contains(c));
        let is_number = last.ends_with(|c: char| c.is_ascii_digit());
        let stays = (is_number && UNITS.contains(&unit)) || (last == "/" && UNITS.contains(&unit));
        if at == text.len() || !(stays || quoted(at)) {
            out.push(&text[start..at]);
            start = (at + 1).min(text.len());
        }
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
        assert_eq!(super::broken("at most 12 ms, 5 / s", 11, 0, 0), "at most\n12 ms,\n5 / s");
        assert_eq!(super::broken("  - one two", 8, 0, 0), "  - one\ntwo");
        let command = "call it `dotgen check` here";
        assert_eq!(super::broken(command, 20, 0, 2), "call it\n  `dotgen check`\n  here");
        assert_eq!(super::broken(command, 18, 0, 2), "call it `dotgen\n  check` here");
        let lines = "one two\nthree four";
        assert_eq!(super::lines_broken(lines, 10, 7, 2), "one\n  two\nthree four");
    }

    #[test]
    fn a_long_text_of_a_table_has_lines_of_its_own() {
        let table = super::Table { texts: 1, long: 0, indent: 0 };
        let rows =
            [["codel", "", "runs"], ["a.start", "", "1"], ["a.long.name.of.a.codel", "", "12"]];
        let wide = ["codel                   runs", "a.start                    1"];
        let lines = table.lines_in(&rows, 28);
        assert_eq!(lines[..2], wide);
        assert_eq!(lines[2], "a.long.name.of.a.codel    12");
        let narrow = ["codel    runs", "a.start     1", "a.long.name.of.a.codel\n           12"];
        assert_eq!(table.lines_in(&rows, 27), narrow);

        let table = super::Table { texts: 2, long: 1, indent: 2 };
        let rows = [["verdict", "check", "limit"], ["proved", "within one => two three", "9 ms"]];
        let narrow = [
            "  verdict  check  limit",
            "  proved           9 ms\n      within one => two\n        three",
        ];
        assert_eq!(table.lines_in(&rows, 24), narrow);
    }

    #[test]
    fn styles_take_no_columns() {
        let text = "\u{1b}[1m\u{1b}[31mone\u{1b}[0m two three";
        assert_eq!(super::broken(text, 7, 0, 2), "\u{1b}[1m\u{1b}[31mone\u{1b}[0m two\n  three");
    }

    #[test]
    fn of_a_diagnostic_the_titles_break_on_a_terminal() {
        let title = "hint[a/b]: a long title of a diagnostic that is here";
        let source = " 1 | codel<start> a_long_source_line() yield ether;";
        let text = format!("{title}\n{source}\n\u{1b}[1mhelp\u{1b}[0m: remove it\n\n");
        let terminal = Some((terminal_size::Width(40), terminal_size::Height(9)));
        let broken = text.replace(" that", "\n  that");
        assert_eq!(super::titles_broken(&text, terminal), broken);
        assert_eq!(super::titles_broken(&text, None), text);
    }
}
