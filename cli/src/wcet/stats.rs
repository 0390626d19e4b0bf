//! `dotgen wcet stats`

use std::io::{IsTerminal, Write};

use anyhow::bail;
use camino::Utf8PathBuf;
use clap::{Args, ValueEnum};
use dotgen_analysis::terminal;
use dotgen_recording::log::SkippedLines;
use dotgen_recording::statistics::{
    Collector, Group, Times, lines, transition_counts, worst_cases,
};
use serde::Serialize;

use super::read_log;
use crate::width::Table;
use crate::{CommandExit, outputs, report};

/// Print statistics of logs: execution times, cycles, transitions
///
/// The numbers match `profundis -s`, which counts every line, including the recorder's lines about itself.
/// Lines that do not belong to a log are skipped.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Logs; `-` is standard input
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<Utf8PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Format {
    /// For people
    Text,
    /// For programs; times in nanoseconds
    Json,
    /// The machine-readable lines of `profundis -s`
    Sum,
    /// The longest time of each function, in seconds (NAME.wcet of templates of formal models)
    Wcet,
    /// The counts of transitions (all.proba of the template of UPPAAL-SMC)
    Proba,
}

#[derive(Serialize)]
struct Document<'d> {
    format: u32,
    groups: &'d [Group],
    left: &'d SkippedLines,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<CommandExit> {
    let mut collector = Collector::default();
    for log in &arguments.logs {
        read_log(log, |_, line, ended| collector.line(line, ended))?;
        collector.file_ended();
    }
    let groups = collector.groups_in_order();
    if groups.is_empty() {
        let why = told(&collector.left).join("; ");
        let why = if why.is_empty() { "it is empty" } else { &why };
        bail!("there is no run of a codel in what was read: {why}");
    }
    let text = match arguments.format {
        Format::Sum | Format::Wcet | Format::Proba => {
            for text in told(&collector.left) {
                report::note(&text);
            }
            let text = match arguments.format {
                Format::Wcet => worst_cases(&groups),
                Format::Proba => transition_counts(&groups),
                _ => lines(&groups),
            };
            // In a pipe, names are not escaped.
            if std::io::stdout().is_terminal() { terminal::text(&text).into_owned() } else { text }
        }
        Format::Json => {
            let document = Document { format: 1, groups: &groups, left: &collector.left };
            outputs::print_json(&document)?;
            return Ok(CommandExit::Fine);
        }
        Format::Text => return print(&groups, &collector.left),
    };
    std::io::stdout().write_all(text.as_bytes())?;
    Ok(CommandExit::Fine)
}

fn print(groups: &[Group], left: &SkippedLines) -> anyhow::Result<CommandExit> {
    let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
    let mut rows = vec![["", "runs", "least", "greatest", "mean", "deviation"].map(str::to_owned)];
    for group in groups {
        let depth = group.key.len();
        let name = match depth {
            2 => group.key.join(" "),
            _ => group.key.last().cloned().unwrap_or_default(),
        };
        let name = if name.is_empty() { "(missing)".to_owned() } else { name };
        let function = group.function.as_ref().filter(|function| !function.is_empty());
        let function = function.map_or(String::new(), |function| format!(" ({function})"));
        let indent = "  ".repeat(depth.saturating_sub(2));
        let name = terminal::text(&format!("{name}{function}")).into_owned();
        rows.push(row(format!("{indent}{name}"), &group.execution));
        if let Some(cycle) = group.cycle.as_ref().filter(|_| depth == 3) {
            rows.push(row(format!("{indent}  cycles"), cycle));
        }
    }
    table(&mut out, &rows)?;
    for text in told(left) {
        writeln!(out, "{text}")?;
    }
    Ok(CommandExit::Fine)
}

fn row(name: String, times: &Times) -> [String; 6] {
    let [least, greatest, mean, deviation] =
        [times.least, times.greatest, times.mean, times.deviation].map(nanos);
    [name, times.count.to_string(), least, greatest, mean, deviation]
}

/// Prints a table. The first column is left-aligned, the others are right-aligned.
pub(crate) fn table<const N: usize>(
    out: &mut impl Write,
    rows: &[[String; N]],
) -> std::io::Result<()> {
    let rows: Vec<[&str; N]> = rows.iter().map(|row| row.each_ref().map(String::as_str)).collect();
    for line in (Table { texts: 1, long: 0, indent: 0 }).lines(&rows) {
        writeln!(out, "{line}")?;
    }
    Ok(())
}

/// Formats nanoseconds in a suitable unit.
pub(crate) fn nanos(time: i64) -> String {
    let (sign, time) = (if time < 0 { "-" } else { "" }, time.unsigned_abs());
    let in_unit = |unit: u64, name: &str| {
        let fraction = format!("{:03}", time % unit * 1_000 / unit);
        let fraction = fraction.trim_end_matches('0');
        let point = if fraction.is_empty() { "" } else { "." };
        format!("{sign}{}{point}{fraction} {name}", time / unit)
    };
    match time {
        0..1_000 => format!("{sign}{time} ns"),
        1_000..1_000_000 => in_unit(1_000, "µs"),
        1_000_000..1_000_000_000 => in_unit(1_000_000, "ms"),
        _ => in_unit(1_000_000_000, "s"),
    }
}

/// Describes the lines that were skipped.
pub(crate) fn told(left: &SkippedLines) -> Vec<String> {
    let one = |count: u64, what: &str| {
        let lines = if count == 1 { "line" } else { "lines" };
        (count > 0).then(|| format!("{count} {lines} {what}"))
    };
    let all = [
        one(left.recorder, "of the recorder about itself"),
        one(left.overloads, "of threads that waited for the recorder: times near them may be late"),
        one(left.clock_steps, "with times that go backwards: the clock was set meanwhile"),
        one(left.cut, "cut: columns or their end are missing"),
        one(left.garbage, "not of a log"),
    ];
    all.into_iter().flatten().collect()
}
