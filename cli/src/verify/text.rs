//! `--format text`: a table of checks, the runs that refute them, the assumptions.

use std::collections::BTreeSet;
use std::io::Write;

use clap::builder::styling::{AnsiColor, Style};
use dotgen_timing::derive::{Extreme, MinimumCores, Sensitivity};
use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::{Event, TimeUnit};

use super::table::{style, table};
use super::{Answer, explain};
use crate::width::{heading, wrapped};
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
    let rest = heading(&report.scenario, &summary::platform(&settings), &answer.file());
    writeln!(out, "{TITLE}{}{TITLE:#}: {rest}", report.scenario)?;
    // Without any execution time, the table is sufficient.
    let is_nothing = |answer: &FirstAnswer| answer.outcome == Verdict::Nothing;
    if !answer.first.iter().all(is_nothing) {
        first_answers(out, &answer.first)?;
    }
    let view = answer.view();
    table(out, &view.checks)?;
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
        let text = wrapped(&format!("{counted}{open}"), width + 4, 6);
        writeln!(out, "  {assuming:<width$}  {text}")?;
    }
    writeln!(out, "  any client:")
}

/// Prints the cause and the help of a check, and then its run.
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
    if let Some(cause) = &seen.cause {
        labelled(out, "cause", cause)?;
    }
    if let Some(remedy) = &seen.remedy {
        labelled(out, "help", remedy)?;
    }
    for reason in &seen.reason {
        labelled(out, "because", reason)?;
    }
    let requests = events.iter().filter(|event| event.kind == MomentKind::Request);
    let requests: Vec<&str> = requests.map(|request| request.what.as_str()).collect();
    if !requests.is_empty() {
        labelled(out, "requests", &requests.join(", then "))?;
    }
    run(out, events, check.cycle, unit, explained)?;
    Ok(())
}

/// Prints a paragraph below a run, after its label.
fn labelled(out: &mut impl Write, label: &str, text: &str) -> std::io::Result<()> {
    let text = wrapped(text, label.len() + 3, 4);
    writeln!(out, "  {TITLE}{label}{TITLE:#} {text}")
}

/// Prints the assumptions and the notes of a report.
pub(crate) fn ground(
    out: &mut impl Write,
    assumptions: &[String],
    notes: &[String],
) -> std::io::Result<()> {
    if !assumptions.is_empty() {
        writeln!(out, "\n{TITLE}assuming{TITLE:#}")?;
        for assumption in assumptions {
            writeln!(out, "  - {}", wrapped(assumption, 4, 4))?;
        }
    }
    for note in notes {
        writeln!(out, "{TITLE}note{TITLE:#}: {}", wrapped(note, 6, 2))?;
    }
    Ok(())
}

/// Prints the assumptions and the summary.
pub(super) fn tail(answer: &Answer, explained: bool) -> anyhow::Result<()> {
    let out = &mut anstream::AutoStream::auto(std::io::stdout().lock());
    let (report, view) = (&answer.report, answer.view());
    ground(out, &report.assumptions, &report.notes)?;
    if let Some(report) = advice::of_report(report, &answer.problem, advice::LimitNames::Options) {
        writeln!(out, "\n{TITLE}help{TITLE:#}: {}", wrapped(&report, 6, 2))?;
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
    /// The deadlines that the limits concern.
    deadlines: String,
}

impl Limits {
    pub(super) fn of(answer: &Answer) -> Limits {
        let table = blocking::table(&answer.problem, &answer.options);
        let width = table.iter().map(|row| row.codel.path.len()).max();
        let settings = answer.settings();
        Limits {
            unit: TimeUnit::of(&settings),
            width: width.unwrap_or_default(),
            deadlines: summary::deadlines(&settings),
        }
    }

    /// Prints a change that repairs the system.
    pub(super) fn repair(&self, out: &mut dyn Write, repair: &Repair) -> std::io::Result<()> {
        let line = format!("  {TITLE}repair{TITLE:#} {}", repair.words);
        writeln!(out, "{}", wrapped(&line, 0, 4))
    }

    /// Prints the smallest of several changes, and a note if not all were tried.
    pub(super) fn repaired(&self, out: &mut dyn Write, all: &Repairs) -> std::io::Result<()> {
        if let [smallest, _, ..] = &all.all[..] {
            let line = format!("  {TITLE}smallest{TITLE:#} {}", smallest.words);
            writeln!(out, "{}", wrapped(&line, 0, 4))?;
        }
        if all.incomplete {
            writeln!(out, "  {FAINT}not every change was tried{FAINT:#}")
        } else {
            Ok(())
        }
    }

    pub(super) fn heading(&self, out: &mut dyn Write) -> std::io::Result<()> {
        let heading = format!("with {} met", self.deadlines);
        writeln!(out, "\n{TITLE}{}{TITLE:#}", wrapped(&heading, 0, 2))
    }

    pub(super) fn cores(&self, out: &mut dyn Write, minimum: &MinimumCores) -> std::io::Result<()> {
        let (cores, remark) = summary::cores(minimum);
        let remark =
            if remark.is_empty() { remark } else { format!(" {FAINT}({remark}){FAINT:#}") };
        writeln!(out, "{}", wrapped(&format!("  smallest number of cores: {cores}{remark}"), 0, 6))
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
        let line =
            format!("  {what:<15} {of:<width$}  {extreme} {FAINT}(now {now}{remark}){FAINT:#}");
        writeln!(out, "{}", wrapped(&line, 0, 6))
    }

    /// Prints the most critical value, and a note if something is missing.
    pub(super) fn ending(
        &self,
        out: &mut dyn Write,
        sensitivity: &Sensitivity,
    ) -> std::io::Result<()> {
        if let Some(next) = &sensitivity.next_to_break {
            let next = summary::next_to_break(next, self.unit);
            writeln!(out, "{}", wrapped(&format!("  next to break: {next}"), 0, 4))?;
        }
        if sensitivity.incomplete {
            writeln!(out, "  {FAINT}given up here: time is up, or it was interrupted{FAINT:#}")
        } else {
            Ok(())
        }
    }
}

/// Maximum number of lines of a whole run. Of a longer run, the part that matters is shown: from the release
/// of the last job of the task at its end.
const MAX_LINES: usize = 40;

/// Number of lines if that part is unknown, or longer than `MAX_PART`.
const TAIL_LINES: usize = 30;
const MAX_PART: usize = 100;

/// Number of lines before the repeated part of a run.
const HEAD_LINES: usize = 20;

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

/// The lines of a run that are not shown.
fn left_out(lines: &[Line], events: &[Event], cycle: Option<usize>) -> std::ops::Range<usize> {
    if lines.len() <= MAX_LINES {
        return 0..0;
    }
    let tail = lines.len() - TAIL_LINES;
    if cycle.is_some() {
        return HEAD_LINES.min(tail)..tail;
    }
    let released = events.split_last().and_then(|(last, before)| {
        before.iter().rposition(|event| {
            let kind = matches!(event.kind, MomentKind::Tick | MomentKind::Release);
            kind && event.time < last.time && event.thread == last.thread
        })
    });
    let first = released.and_then(|step| lines.iter().position(|line| line.last() >= step));
    match first {
        Some(first) if lines.len() - first <= MAX_PART => 0..first,
        _ => 0..tail,
    }
}

/// Prints a run as a list. Equal times are shown once, and so is a repeated part.
pub(crate) fn run(
    out: &mut impl Write,
    events: &[Event],
    cycle: Option<usize>,
    unit: TimeUnit,
    explained: bool,
) -> std::io::Result<()> {
    let time = |step: usize| unit.show(events[step].time);
    let lines = lines(events, cycle);
    let left_out = left_out(&lines, events, cycle);
    let shown = lines.iter().enumerate().filter(|(at, _)| !left_out.contains(at));
    let steps = shown.filter_map(|(_, line)| match line {
        Line::Step(step) => Some(*step),
        Line::Again(..) => None,
    });
    let widths = steps.map(|step| (time(step).len(), events[step].thread.to_string().len()));
    let (time_width, who_width) = widths.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let mut before = None;
    for (i, line) in lines.iter().enumerate() {
        if i == left_out.start && !left_out.is_empty() {
            let from = i.checked_sub(1).map_or(0, |before| lines[before].last() + 1);
            let to = lines[left_out.end - 1].last();
            let cycle = cycle.filter(|cycle| (from..=to).contains(cycle));
            let cycle = cycle.map_or(String::new(), |cycle| {
                format!("; what goes on for ever begins at {}", time(cycle))
            });
            let count = to + 1 - from;
            let text = format!(
                "… {count} steps until {}{cycle}; `--format json` has the whole run …",
                time(to)
            );
            writeln!(out, "  {FAINT}{}{FAINT:#}", wrapped(&text, 2, 4))?;
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
        let indent = time_width + who_width + 6;
        let what = wrapped(&event.what, indent, indent + 2);
        writeln!(
            out,
            "  {at:>time_width$}  {:<who_width$}  {style}{what}{style:#}{rule}",
            event.thread
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
