//! The output of an import, as text and as JSON.

use std::io::Write;
use std::ops::Range;

use camino::Utf8Path;
use clap::builder::styling::{AnsiColor, Style};
use dotgen_analysis::model::Seconds;
use dotgen_analysis::terminal;
use dotgen_recording::edits::Refusal;
use dotgen_recording::matching::Mismatch;
use dotgen_recording::proposal::{Decision, seconds, written};
use dotgen_syntax::line_index::{LineIndex, PositionEncoding};
use num_rational::Ratio;
use serde_json::{Value, json};

use super::super::stats::{nanos, table, told};
use super::{Answer, Row};
use crate::outputs;
use crate::session::display;

const TITLE: Style = Style::new().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();

/// A greatest time of this many times the mean is reported.
const OUTLIER_FACTOR: i64 = 100;

/// Minimum number of executions for a meaningful mean.
const MANY: u64 = 10;

/// Maximum number of listed lines without a codel. Further ones are only counted.
const MAX_UNMATCHED_LINES: usize = 10;

pub(super) fn print(answer: &Answer, only_shown: bool) -> anyhow::Result<()> {
    // Standard output contains only the diff.
    let mut out: Box<dyn Write> = if only_shown {
        Box::new(anstream::AutoStream::auto(std::io::stderr().lock()))
    } else {
        Box::new(anstream::AutoStream::auto(std::io::stdout().lock()))
    };
    table(&mut out, &rows(answer))?;
    let simulated: Vec<&str> = answer.simulated.keys().map(String::as_str).collect();
    if !simulated.is_empty() {
        writeln!(
            out,
            "{TITLE}left out{TITLE:#}: simulated, not measured: {}",
            terminal::text(&simulated.join(", "))
        )?;
    }
    let never = unobserved_codels(answer);
    let never: Vec<&str> = never.map(|codel| codel.path.as_str()).collect();
    if !never.is_empty() {
        let title = if answer.given.is_some() { "without a time" } else { "never seen" };
        writeln!(out, "{TITLE}{title}{TITLE:#}: {}", never.join(", "))?;
    }
    for row in answer.rows.iter().filter(|row| is_outlier(row)) {
        let (file, line) = row.measure.at;
        let log = answer.logs.get(file).map_or("", |log| log.as_str());
        writeln!(
            out,
            "{TITLE}note{TITLE:#}: the greatest time of {} is {} times the mean: see {log}:{line}. \
             A clock that was set forward looks like that",
            row.path,
            row.measure.greatest / row.measure.mean().max(1)
        )?;
    }
    strays(&mut out, answer)?;
    if let Some(given) = &answer.given {
        for text in given.told() {
            writeln!(out, "{TITLE}note{TITLE:#}: {text}")?;
        }
    }
    for text in told(&answer.left) {
        writeln!(out, "{TITLE}left out{TITLE:#}: {text}")?;
    }
    for (function, why) in &answer.refused {
        let why = match why {
            Refusal::Macro => "its declaration, or the time it has, comes from a macro",
            Refusal::Comment => "a comment stands within the time it has",
        };
        writeln!(
            out,
            "{BAD}not written{BAD:#}: the time of {function}: {why}; write it there by hand"
        )?;
    }
    if keeps_longer(answer) {
        writeln!(out, "{TITLE}note{TITLE:#}: longer times were kept; `--replace` lowers them")?;
    }
    for path in answer.changed.keys() {
        let done = if only_shown { "would change" } else { "changed" };
        writeln!(out, "{done} {}", terminal::name(&display(path)))?;
    }
    if answer.changed.is_empty() {
        writeln!(out, "nothing to change")?;
    }
    Ok(())
}

/// Returns true if `--replace` would lower a time.
fn keeps_longer(answer: &Answer) -> bool {
    answer.rows.iter().any(|row| {
        let is_longer = |proposed| row.declared.is_none_or(|declared| seconds(proposed) < declared);
        row.decision == Decision::Kept && row.proposed.is_some_and(is_longer)
    })
}

/// Returns the table of the measured codels.
fn rows(answer: &Answer) -> Vec<[String; 7]> {
    let head = ["codel", "runs", "mean", "greatest", "declared", "proposed", ""];
    let mut rows = vec![head.map(str::to_owned)];
    let is_given = answer.given.is_some();
    for row in answer.rows.iter().filter(|row| row.measure.runs > 0) {
        rows.push([
            terminal::text(&row.path).into_owned(),
            if is_given { "given".to_owned() } else { row.measure.runs.to_string() },
            if is_given { "-".to_owned() } else { nanos(row.measure.mean()) },
            nanos(row.measure.greatest),
            row.declared.map_or("-".to_owned(), |ratio| nanos(in_nanos(ratio))),
            row.proposed.map_or("-".to_owned(), written),
            in_words(row, is_given).to_owned(),
        ]);
    }
    rows
}

/// Prints the runs without a codel of the specification.
fn strays(out: &mut impl Write, answer: &Answer) -> std::io::Result<()> {
    for (kind, stray, count) in answer.strays.iter().take(MAX_UNMATCHED_LINES) {
        let place = format!(
            "{} {} {} {} {}",
            kind.instance, kind.task, kind.service, kind.function, kind.from
        );
        let runs = if *count == 1 { "run" } else { "runs" };
        writeln!(
            out,
            "{TITLE}note{TITLE:#}: {count} {runs} of `{}` left out: {}",
            terminal::text(&place),
            why(*stray)
        )?;
    }
    if answer.strays.len() > MAX_UNMATCHED_LINES {
        let more = answer.strays.len() - MAX_UNMATCHED_LINES;
        writeln!(out, "{TITLE}note{TITLE:#}: {more} more of such kinds")?;
    }
    Ok(())
}

/// Returns the codels without an execution, measured or simulated.
fn unobserved_codels(answer: &Answer) -> impl Iterator<Item = &Row> {
    let is_seen = |row: &Row| row.measure.runs > 0 || answer.simulated.contains_key(&row.path);
    answer.rows.iter().filter(move |row| !is_seen(row))
}

fn is_outlier(row: &Row) -> bool {
    let measure = &row.measure;
    measure.runs >= MANY && measure.greatest / OUTLIER_FACTOR > measure.mean()
}

fn in_words(row: &Row, is_given: bool) -> &'static str {
    let measured = Ratio::new(i128::from(row.measure.greatest), 1_000_000_000);
    match row.decision {
        Decision::New => "new",
        Decision::Raised if is_given => "raised",
        Decision::Raised if row.declared.is_some_and(|ratio| ratio < measured) => {
            "raised: was exceeded"
        }
        Decision::Raised => "raised: less than the margin",
        Decision::Kept => "kept",
        Decision::Lowered => "lowered",
        Decision::NeverSeen => "never seen",
    }
}

fn why(stray: Mismatch) -> &'static str {
    match stray {
        Mismatch::Component => "no component of that name is given",
        Mismatch::Task => "the component has no such task",
        Mismatch::State => "there is no such state or codel",
        Mismatch::Function => "the specification has another function there",
        Mismatch::WrongTask => "the activity belongs to another task",
        Mismatch::NoCodel => "the attribute is handled without a codel",
    }
}

fn in_nanos(time: Seconds) -> i64 {
    let nanos = (time * Ratio::from_integer(1_000_000_000)).round();
    i64::try_from(nanos.to_integer()).unwrap_or(i64::MAX)
}

/// Returns a range of a file, in the form of the Language Server Protocol.
fn place(path: &Utf8Path, range: &Range<usize>) -> Value {
    let text = super::text(path).unwrap_or_default();
    let lines = LineIndex::new(&text);
    let position = |offset: usize| {
        let offset = u32::try_from(offset).unwrap_or(u32::MAX).min(lines.text_len().into());
        let at = lines.line_col(offset.into(), PositionEncoding::Utf16);
        json!({"line": at.line, "character": at.col})
    };
    json!({"file": path, "range": {"start": position(range.start), "end": position(range.end)}})
}

pub(super) fn print_json(answer: &Answer) -> anyhow::Result<()> {
    let codels = answer.rows.iter().filter(|row| row.measure.runs > 0);
    let codels = codels.map(|codel| {
        let (file, line) = codel.measure.at;
        json!({
            "codel": codel.path,
            "function": codel.function,
            "runs": codel.measure.runs,
            "least": codel.measure.least,
            "mean": codel.measure.mean(),
            "greatest": codel.measure.greatest,
            "log": answer.logs.get(file).map(|codel| codel.as_str()),
            "line": line,
            "declared": codel.declared.map(in_nanos),
            "proposed": codel.proposed.map(|codel| codel.saturating_mul(1_000)),
            "decision": codel.decision,
            "place": codel.place.as_ref().map(|codel| place(&codel.path, &codel.range)),
        })
    });
    let never = unobserved_codels(answer);
    let strays = answer.strays.iter().map(|(kind, stray, runs)| {
        json!({
            "instance": kind.instance,
            "task": kind.task,
            "service": kind.service,
            "function": kind.function,
            "from": kind.from,
            "to": kind.to,
            "why": stray,
            "runs": runs,
        })
    });
    let refused = answer.refused.iter();
    let refused = refused.map(|(function, why)| json!({ "function": function, "why": why }));
    let edits = answer.edits.iter().map(|other| {
        let mut edit = place(&other.path, &other.range);
        edit["text"] = other.new_text.as_str().into();
        edit
    });
    let document = json!({
        "format": 1,
        "codels": codels.collect::<Vec<Value>>(),
        "never-seen": never.map(|codel| codel.path.as_str()).collect::<Vec<_>>(),
        "simulated": answer.simulated.keys().collect::<Vec<_>>(),
        "given": answer.given,
        "unknown": strays.collect::<Vec<Value>>(),
        "left": answer.left,
        "refused": refused.collect::<Vec<Value>>(),
        "edits": edits.collect::<Vec<_>>(),
        "changed": answer.changed.keys().map(|key| display(key)).collect::<Vec<_>>(),
    });
    outputs::print_json(&document)
}
