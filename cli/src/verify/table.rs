//! The table of checks. It fits the terminal: a long text stands below its row.

use std::io::Write;

use clap::builder::styling::{AnsiColor, Style};
use dotgen_timing::report::Verdict;
use dotgen_views::verification::view::CheckView;

use crate::width::{columns, wrapped};

const FAINT: Style = Style::new().dimmed();

/// Minimum width of the column `of` in which texts stay.
const MIN_OF: usize = 16;

/// Indentation of a text below its row.
const BELOW: usize = 6;

/// A row of the table.
struct Row {
    verdict: &'static str,
    style: Style,
    check: String,
    of: String,
    value: String,
    limit: String,
    slack: String,
    remark: String,
    /// The number of a remark that is shown once, below the table.
    shared: Option<usize>,
}

impl Row {
    fn new(view: &CheckView) -> Row {
        let check = view.report;
        let note = check.note.as_deref();
        let remarks: Vec<&str> = note.into_iter().chain(view.worth).collect();
        Row {
            verdict: view.verdict.word(),
            style: style(view.verdict),
            check: match &check.name {
                Some(name) => format!("{name}: {}", check.kind),
                None => check.kind.to_string(),
            },
            of: check.of.clone(),
            value: view.value.clone().unwrap_or_default(),
            limit: view.limit.clone().unwrap_or_default(),
            slack: view.slack.clone().unwrap_or_default(),
            remark: remarks.join("; "),
            shared: None,
        }
    }
}

/// Moves the remarks of several rows below the table. The rows refer to them by number.
fn shared_remarks(rows: &mut [Row]) -> Vec<String> {
    let mut shared: Vec<String> = Vec::new();
    for at in 0..rows.len() {
        let remark = rows[at].remark.clone();
        let is_repeated = rows[at + 1..].iter().any(|row| row.remark == remark);
        if is_repeated && !remark.is_empty() && !shared.contains(&remark) {
            shared.push(remark);
        }
    }
    for row in rows {
        row.shared = shared.iter().position(|remark| *remark == row.remark).map(|place| place + 1);
    }
    shared
}

pub(super) fn style(outcome: Verdict) -> Style {
    match outcome {
        Verdict::Proved => AnsiColor::Green.on_default(),
        Verdict::Refuted | Verdict::Exceeds => AnsiColor::Red.on_default().bold(),
        _ => AnsiColor::Yellow.on_default().bold(),
    }
}

/// Prints the checks, and below them the remarks that several rows share.
pub(super) fn table(out: &mut impl Write, checks: &[CheckView<'_>]) -> std::io::Result<()> {
    let mut rows: Vec<Row> = checks.iter().map(Row::new).collect();
    if rows.is_empty() {
        return Ok(());
    }
    let shared = shared_remarks(&mut rows);
    let layout = Layout::of(&rows, columns());
    writeln!(out, "\n{FAINT}{}{FAINT:#}", layout.head().trim_end())?;
    for row in &rows {
        layout.row(out, row)?;
    }
    for (number, remark) in (1..).zip(shared) {
        let remark = wrapped(&remark, 6, 6);
        writeln!(out, "{}  [{number}] {remark}", if number == 1 { "\n" } else { "" })?;
    }
    Ok(())
}

/// Widths of the columns. Empty columns have the width 0 and are left out.
struct Layout {
    columns: usize,
    verdict: usize,
    check: usize,
    of: usize,
    value: usize,
    limit: usize,
    slack: usize,
}

impl Layout {
    fn of(rows: &[Row], columns: usize) -> Layout {
        let widths = |cell: fn(&Row) -> &String| rows.iter().map(move |row| length(cell(row)));
        let width = |head: &str, cell: fn(&Row) -> &String| match widths(cell).max() {
            None | Some(0) => 0,
            Some(cell) => cell.max(head.len()),
        };
        let mut layout = Layout {
            columns,
            verdict: rows.iter().map(|row| row.verdict.len()).max().unwrap_or_default().max(8),
            check: width("check", |row| &row.check),
            of: 0,
            value: width("value", |row| &row.value),
            limit: width("limit", |row| &row.limit),
            slack: width("slack", |row| &row.slack),
        };
        let room = columns.saturating_sub(layout.width() + 2);
        let fitting = widths(|row| &row.of).filter(|width| *width <= room.max(MIN_OF)).max();
        layout.of = fitting.map_or(0, |cell| if cell == 0 { 0 } else { cell.max("of".len()) });
        layout
    }

    /// Number of columns of a row.
    fn width(&self) -> usize {
        let others = [self.check, self.of, self.value, self.limit, self.slack];
        let others = others.into_iter().filter(|width| *width > 0).map(|width| width + 2);
        2 + self.verdict + others.sum::<usize>()
    }

    /// The cells between the verdict and the values.
    fn names(&self, texts: [&str; 2]) -> String {
        let cells = texts.into_iter().zip([self.check, self.of]).filter(|cell| cell.1 > 0);
        cells.map(|(text, width)| format!("  {text:<width$}")).collect()
    }

    fn values(&self, texts: [&str; 3]) -> String {
        let widths = [self.value, self.limit, self.slack];
        let cells = texts.into_iter().zip(widths).filter(|cell| cell.1 > 0);
        cells.map(|(text, width)| format!("  {text:>width$}")).collect()
    }

    fn head(&self) -> String {
        let (verdict, names) = (self.verdict, self.names(["check", "of"]));
        format!("  {:<verdict$}{names}{}", "verdict", self.values(["value", "limit", "slack"]))
    }

    fn row(&self, out: &mut impl Write, row: &Row) -> std::io::Result<()> {
        let (style, verdict) = (row.style, self.verdict);
        let is_below = length(&row.of) > self.of;
        let of = if is_below { "" } else { &row.of };
        let values = self.values([&row.value, &row.limit, &row.slack]);
        // Remarks of rows without values are in one column.
        let mut line = self.names([&row.check, of]) + values.trim_end();
        let remark = match (row.shared, row.remark.as_str()) {
            (Some(number), _) => format!("[{number}]"),
            (None, "") => String::new(),
            (None, remark) => format!("({remark})"),
        };
        let fits = !is_below && 4 + verdict + length(&line) + length(&remark) <= self.columns;
        if fits {
            line += &format!("  {remark}");
        }
        writeln!(out, "  {style}{:<verdict$}{style:#}{}", row.verdict, line.trim_end())?;
        let below = [(is_below, &row.of), (!fits && !remark.is_empty(), &remark)];
        for (_, text) in below.into_iter().filter(|(is_below, _)| *is_below) {
            let blanks = " ".repeat(BELOW);
            writeln!(out, "{blanks}{}", wrapped(text, BELOW, BELOW + 2))?;
        }
        Ok(())
    }
}

fn length(text: &str) -> usize {
    text.chars().count()
}
