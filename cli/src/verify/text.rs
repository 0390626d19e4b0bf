//! `--format text`: a table of checks, the runs that refute them, the assumptions.

use std::collections::BTreeSet;
use std::io::Write;

use clap::builder::styling::{AnsiColor, Style};
use dotgen_timing::derive::{Extreme, MinimumCores, Sensitivity};
use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::{Event, TimeUnit};

use super::{Answer, explain};
use crate::width::wrapped;
use dotgen_timing::report::Verdict;
use dotgen_views::verification::advice;
use dotgen_views::verification::blocking;
use dotgen_views::verification::changes::{Repair, Repairs};
use dotgen_views::verification::first::FirstAnswer;
use dotgen_views::verification::fold_repetitions::{Part, fold_repetitions, words as again};
use dotgen_views::verification::summary;
use dotgen_views::verification::view::CheckView;

const TITLE: Style = Style::new().bold();
const FAINT: Style = Style::new().dimmed();

/// Prints the answers of the checks, and their runs, after a blank line unless it is the first.
pub(super) fn head(answer: &Answer, is_first: bool, explained: bool) -> anyhow::Result<()> {
    let out = &mut anstream::AutoStream::auto(std::io::stdout().lock());
    if !is_first {
        writeln!(out)?;
    }
    let settings = answer.settings();
    let unit = TimeUnit::of(&settings);
    let report = &answer.report;
    writeln!(
        out,
        "{TITLE}{}{TITLE:#}: {} {FAINT}({}){FAINT:#}",
        report.scenario,
        summary::platform(&settings),
        answer.file(),
    )?;
    // Without any execution time, the table is sufficient.
    let is_nothing = |answer: &FirstAnswer| answer.outcome == Verdict::Nothing;
    if !answer.first.iter().all(is_nothing) {
        first_answers(out, &answer.first)?;
    }
    let view = answer.view();
    let mut rows: Vec<Row> = view.checks.iter().map(Row::new).collect();
    let shared = shared_remarks(&mut rows);
    table(out, &rows)?;
    for (number, remark) in (1..).zip(shared) {
        let remark = wrapped(&remark, 6, 6);
        writeln!(out, "{}  [{number}] {remark}", if number == 1 { "\n" } else { "" })?;
    }
    let conditions: BTreeSet<&str> =
        view.checks.iter().filter_map(|check| check.condition.as_deref()).collect();
    for condition in conditions {
        writeln!(out)?;
        labelled(out, "conditional:", condition)?;
    }
    for seen in &view.checks {
        shown_run(out, seen, unit, explained)?;
    }
    Ok(())
}

/// Prints the answers that hold for fewer clients than any client at any time.
fn first_answers(out: &mut impl Write, answers: &[FirstAnswer]) -> std::io::Result<()> {
    writeln!(out)?;
    let width = answers.iter().map(|answer| answer.assuming.len()).max();
    let width = width.unwrap_or_default();
    for answer in answers {
        let open = if answer.open.is_empty() {
            String::new()
        } else {
            format!(": {}", answer.open.join(", "))
        };
        let (assuming, counted) = (&answer.assuming, answer.outcome.counted());
        writeln!(out, "  {assuming:<width$}  {counted}{open}")?;
    }
    writeln!(out, "  any client:")
}

/// Prints the run of a check, with its cause and its help.
fn shown_run(
    out: &mut impl Write,
    seen: &CheckView<'_>,
    unit: TimeUnit,
    explained: bool,
) -> anyhow::Result<()> {
    let check = seen.report;
    let events = &check.counterexample;
    if events.is_empty() {
        return Ok(());
    }
    let style = style(seen.verdict);
    let word = seen.verdict.word();
    writeln!(out, "\n{style}{word}{style:#} {}", seen.title())?;
    run(out, events, check.cycle, unit, explained)?;
    let requests = events.iter().filter(|event| event.kind == MomentKind::Request);
    let requests: Vec<&str> = requests.map(|request| request.what.as_str()).collect();
    if !requests.is_empty() {
        labelled(out, "requests", &requests.join(", then "))?;
    }
    if let Some(cause) = &seen.cause {
        labelled(out, "cause", cause)?;
    }
    if let Some(remedy) = &seen.remedy {
        labelled(out, "help", remedy)?;
    }
    for reason in &seen.reason {
        labelled(out, "because", reason)?;
    }
    Ok(())
}

/// Prints a paragraph below a run, after its label.
fn labelled(out: &mut impl Write, label: &str, text: &str) -> std::io::Result<()> {
    let text = wrapped(text, label.len() + 3, 4);
    writeln!(out, "  {TITLE}{label}{TITLE:#} {text}")
}

/// Prints the assumptions and the summary.
pub(super) fn tail(answer: &Answer, explained: bool) -> anyhow::Result<()> {
    let out = &mut anstream::AutoStream::auto(std::io::stdout().lock());
    let (report, view) = (&answer.report, answer.view());
    if !report.assumptions.is_empty() {
        writeln!(out, "\n{TITLE}assuming{TITLE:#}")?;
        for assumption in &report.assumptions {
            writeln!(out, "  - {assumption}")?;
        }
    }
    for note in &report.notes {
        writeln!(out, "{TITLE}note{TITLE:#}: {note}")?;
    }
    if let Some(report) = advice::of_report(report, &answer.problem, advice::Names::Options) {
        writeln!(out, "\n{TITLE}help{TITLE:#}: {report}")?;
    }
    let count = |outcome| view.checks.iter().filter(|check| check.verdict == outcome).count();
    let counts: Vec<String> = Verdict::ALL
        .into_iter()
        .filter(|&outcome| count(outcome) > 0)
        .map(|outcome| format!("{} {}", count(outcome), outcome.counted()))
        .collect();
    let counts = if counts.is_empty() { "nothing checked".to_owned() } else { counts.join(", ") };
    let by_analysis = report.checks.iter().any(|check| check.by.is_some());
    let how = match report.states {
        0 if by_analysis && !report.unknown() => "by analysis".to_owned(),
        states => format!("{states} states"),
    };
    writeln!(
        out,
        "\n{TITLE}{counts}{TITLE:#} {FAINT}({how} in {:.3} s, {:.1} MB){FAINT:#}",
        report.seconds,
        report.memory as f64 / 1e6
    )?;
    if explained { explain::print(out, &report.reductions) } else { Ok(()) }
}

/// Prints the lines of `--sensitivity`, each when it is found.
pub(super) struct Limits {
    unit: TimeUnit,
    width: usize,
}

impl Limits {
    pub(super) fn of(answer: &Answer) -> Limits {
        let table = blocking::table(&answer.problem, &answer.options);
        let width = table.iter().map(|row| row.codel.path.len()).max();
        Limits { unit: TimeUnit::of(&answer.settings()), width: width.unwrap_or_default() }
    }

    /// Prints a change that repairs the system.
    pub(super) fn repair(&self, out: &mut dyn Write, repair: &Repair) -> std::io::Result<()> {
        writeln!(out, "  {TITLE}repair{TITLE:#} {}", repair.words)
    }

    /// Prints the smallest of several changes, and a note if not all were tried.
    pub(super) fn repaired(&self, out: &mut dyn Write, all: &Repairs) -> std::io::Result<()> {
        if let [smallest, _, ..] = &all.all[..] {
            writeln!(out, "  {TITLE}smallest{TITLE:#} {}", smallest.words)?;
        }
        if all.incomplete {
            writeln!(out, "  {FAINT}not every change was tried{FAINT:#}")
        } else {
            Ok(())
        }
    }

    pub(super) fn heading(&self, out: &mut dyn Write) -> std::io::Result<()> {
        writeln!(out, "\n{TITLE}with every deadline met{TITLE:#}")
    }

    pub(super) fn cores(&self, out: &mut dyn Write, minimum: &MinimumCores) -> std::io::Result<()> {
        match minimum.cores {
            Some(cores) => writeln!(out, "  smallest number of cores: {cores}"),
            None => writeln!(out, "  smallest number of cores: none was found"),
        }
    }

    /// Prints the limit of a value.
    pub(super) fn extreme(
        &self,
        out: &mut dyn Write,
        what: &str,
        limit: &Extreme,
    ) -> std::io::Result<()> {
        let (extreme, mut remark) = summary::extreme(limit, self.unit);
        if !remark.is_empty() {
            remark.insert_str(0, ", ");
        }
        let now = self.unit.show_value(limit.now);
        let (of, width) = (&limit.of, self.width);
        writeln!(out, "  {what:<15} {of:<width$}  {extreme} {FAINT}(now {now}{remark}){FAINT:#}")
    }

    /// Prints the most critical value, and a note if something is missing.
    pub(super) fn ending(
        &self,
        out: &mut dyn Write,
        sensitivity: &Sensitivity,
    ) -> std::io::Result<()> {
        if let Some(next) = &sensitivity.next_to_break {
            let next = summary::next_to_break(next, self.unit);
            writeln!(out, "  next to break: {next}")?;
        }
        if sensitivity.incomplete {
            writeln!(out, "  {FAINT}given up here: time is up, or it was interrupted{FAINT:#}")
        } else {
            Ok(())
        }
    }
}

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

/// Moves long remarks of several rows below the table. The rows refer to them by number.
fn shared_remarks(rows: &mut [Row]) -> Vec<String> {
    const LONG: usize = 100;
    let mut shared: Vec<String> = Vec::new();
    for at in 0..rows.len() {
        let remark = rows[at].remark.clone();
        if remark.len() <= LONG || shared.contains(&remark) {
            continue;
        }
        if rows[at + 1..].iter().any(|row| row.remark == remark) {
            shared.push(remark);
        }
    }
    for row in rows {
        row.shared = shared.iter().position(|remark| *remark == row.remark).map(|index| index + 1);
    }
    shared
}

fn style(outcome: Verdict) -> Style {
    match outcome {
        Verdict::Proved => AnsiColor::Green.on_default(),
        Verdict::Refuted | Verdict::Exceeds => AnsiColor::Red.on_default().bold(),
        _ => AnsiColor::Yellow.on_default().bold(),
    }
}

fn table(out: &mut impl Write, rows: &[Row]) -> std::io::Result<()> {
    if rows.is_empty() {
        return Ok(());
    }
    let width = |head: &str, cell: fn(&Row) -> &String| {
        let cells = rows.iter().map(|row| cell(row).chars().count());
        cells.max().map_or(0, |cell| if cell == 0 { 0 } else { cell.max(head.len()) })
    };
    let verdict = rows.iter().map(|row| row.verdict.len()).max().unwrap_or_default().max(8);
    let (check, of) = (width("check", |row| &row.check), width("of", |row| &row.of));
    let (value, limit) = (width("value", |row| &row.value), width("limit", |row| &row.limit));
    let slack = width("slack", |row| &row.slack);
    // Empty columns are left out.
    let right = |text: &str, width: usize| match width {
        0 => String::new(),
        _ => format!("  {text:>width$}"),
    };
    let head = |text: &'static str, width| if width == 0 { "" } else { text };
    let line = format!(
        "  {:<verdict$}  {:<check$}  {:<of$}{}{}{}",
        "verdict",
        "check",
        "of",
        right(head("value", value), value),
        right(head("limit", limit), limit),
        right(head("slack", slack), slack),
    );
    writeln!(out, "\n{FAINT}{}{FAINT:#}", line.trim_end())?;
    for row in rows {
        let style = row.style;
        let mut rest = format!(
            "  {:<check$}  {:<of$}{}{}{}",
            row.check,
            row.of,
            right(&row.value, value),
            right(&row.limit, limit),
            right(&row.slack, slack),
        );
        match (row.shared, row.remark.as_str()) {
            (Some(number), _) => rest.push_str(&format!("  [{number}]")),
            (None, "") => {}
            (None, remark) => rest.push_str(&format!("  ({remark})")),
        }
        writeln!(out, "  {style}{:<verdict$}{style:#}{}", row.verdict, rest.trim_end())?;
    }
    Ok(())
}

/// Maximum number of lines of a run. Of longer runs the beginning and the end are shown.
const MAX_LINES: usize = 100;
const HEAD_LINES: usize = 20;
const TAIL_LINES: usize = 50;

/// A line of a run.
enum Line {
    Step(usize),
    /// The repeated part, with the index of its last step.
    Again(String, usize),
}

impl Line {
    fn last(&self) -> usize {
        match *self {
            Line::Step(step) | Line::Again(_, step) => step,
        }
    }
}

fn lines(events: &[Event], cycle: Option<usize>) -> Vec<Line> {
    let parts = fold_repetitions(events, cycle).into_iter();
    let lines = parts.flat_map(|part| match part {
        Part::Steps(range) => range.map(Line::Step).collect(),
        Part::Again { steps, times, last } => vec![Line::Again(again(steps, times), last)],
    });
    lines.collect()
}

/// Returns a run as a list. Equal times are shown once, and so is a repeated part.
fn run(
    out: &mut impl Write,
    events: &[Event],
    cycle: Option<usize>,
    unit: TimeUnit,
    explained: bool,
) -> std::io::Result<()> {
    let time = |step: usize| unit.show(events[step].time);
    let lines = lines(events, cycle);
    let left_out =
        if lines.len() > MAX_LINES { HEAD_LINES..lines.len() - TAIL_LINES } else { 0..0 };
    let shown = lines.iter().enumerate().filter(|pair| !left_out.contains(&pair.0));
    let steps = shown.filter_map(|pair| match pair.1 {
        Line::Step(step) => Some(*step),
        Line::Again(..) => None,
    });
    let widths = steps.map(|step| (time(step).len(), events[step].thread.to_string().len()));
    let (time_width, who_width) = widths.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let mut before = None;
    for (i, line) in lines.iter().enumerate() {
        if i == left_out.start && !left_out.is_empty() {
            let (from, to) = (lines[i - 1].last(), lines[left_out.end - 1].last());
            let cycle = cycle.filter(|cycle| (from + 1..=to).contains(cycle));
            let cycle = cycle.map_or(String::new(), |cycle| {
                format!("; what goes on for ever begins at {}", time(cycle))
            });
            writeln!(
                out,
                "  {FAINT}… {} steps until {}{cycle}; `--format json` has all of them …{FAINT:#}",
                to - from,
                time(to)
            )?;
            before = None;
        }
        if left_out.contains(&i) {
            continue;
        }
        let step = match line {
            Line::Step(step) => *step,
            Line::Again(what, last) => {
                writeln!(out, "  {FAINT}… {what}, until {} …{FAINT:#}", time(*last))?;
                before = None;
                continue;
            }
        };
        let event = &events[step];
        if cycle == Some(step) {
            writeln!(out, "  {FAINT}from here on for ever:{FAINT:#}")?;
        }
        let at = if before == Some(event.time) { String::new() } else { time(step) };
        before = Some(event.time);
        let style = match event.kind {
            MomentKind::Wait => AnsiColor::Yellow.on_default(),
            MomentKind::Excess => AnsiColor::Red.on_default(),
            MomentKind::Tick | MomentKind::Release | MomentKind::Grant => FAINT,
            _ => Style::new(),
        };
        let rule = if explained {
            format!("  {FAINT}[{}]{FAINT:#}", rule(event.kind))
        } else {
            String::new()
        };
        writeln!(
            out,
            "  {at:>time_width$}  {:<who_width$}  {style}{}{style:#}{rule}",
            event.thread, event.what
        )?;
    }
    Ok(())
}

/// Returns the name of the rule of a step, as in JSON and `docs/verification.md`.
fn rule(kind: MomentKind) -> String {
    let word = serde_json::to_value(kind).ok();
    let word = word.as_ref().and_then(|word| word.as_str());
    word.unwrap_or_default().to_owned()
}
