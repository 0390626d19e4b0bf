//! `--format text` of `dotgen monitor`.

use std::io::Write;

use clap::builder::styling::{AnsiColor, Style};
use dotgen_analysis::terminal;
use dotgen_recording::matching::Mismatch;
use dotgen_recording::monitor::{Deviation, DeviationKind, MonitorReport};
use dotgen_timing::report::TimeUnit;

use super::LogReport;
use super::checks::CheckResults;
use crate::run;
use crate::wcet::stats::{nanos, table, told};
use crate::width::wrapped;

const TITLE: Style = Style::new().bold();
const GOOD: Style = AnsiColor::Green.on_default();
const BAD: Style = AnsiColor::Red.on_default().bold();

/// Maximum number of listed items. Further ones are only counted.
const MAX_LISTED: usize = 20;

pub(super) fn print(title: &str, reports: &[LogReport], unit: TimeUnit) -> anyhow::Result<()> {
    let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
    for (i, LogReport { log, report, results }) in reports.iter().enumerate() {
        if i > 0 {
            writeln!(out)?;
        }
        let (title, log) = (terminal::text(title), terminal::name(log.as_str()));
        writeln!(out, "{TITLE}{title}{TITLE:#}: {} runs of codels in {log}", report.runs)?;
        one(&mut out, report, results, unit)?;
    }
    Ok(())
}

fn one(
    out: &mut impl Write,
    report: &MonitorReport,
    results: &CheckResults,
    unit: TimeUnit,
) -> anyhow::Result<()> {
    let or_none = |time: Option<i64>| time.map_or("-".to_owned(), nanos);
    let head = ["task", "chains", "greatest response", "bound", "period"];
    let mut rows = vec![head.map(str::to_owned)];
    for task in &report.tasks {
        rows.push([
            task.task.clone(),
            task.chains.to_string(),
            nanos(task.greatest),
            or_none(task.bound),
            or_none(task.period),
        ]);
    }
    table(out, &rows)?;
    let head = ["codel", "runs", "greatest", "declared", "waited"];
    let mut rows = vec![head.map(str::to_owned)];
    for codel in &report.codels {
        rows.push([
            codel.codel.clone(),
            codel.runs.to_string(),
            nanos(codel.greatest),
            or_none(codel.declared),
            nanos(codel.waited),
        ]);
    }
    writeln!(out)?;
    table(out, &rows)?;
    let never = report.never_taken.iter();
    let never = never.map(|transition| {
        format!("{}: {} -> {}", transition.machine, transition.from, transition.to)
    });
    list(out, "transitions never taken", &never.collect::<Vec<_>>())?;
    list(out, "codels never executed", &report.never_executed)?;
    for (instance, lines) in &report.foreign {
        let instance = terminal::text(instance);
        writeln!(
            out,
            "{TITLE}note{TITLE:#}: {lines} lines of `{instance}`, which the scenario does not have, \
             were not compared"
        )?;
    }
    for text in told(&report.left) {
        writeln!(out, "{TITLE}left out{TITLE:#}: {text}")?;
    }
    run::text::checks(out, &results.checks, unit)?;
    for (why, titles) in &results.unshown {
        let line = format!("{TITLE}note{TITLE:#}: not checked: {}; {why}", titles.join(", "));
        writeln!(out, "{}", wrapped(&line, 0, 2))?;
    }
    if report.deviation_count == 0 {
        writeln!(out, "{GOOD}nothing deviates{GOOD:#}")?;
        return Ok(());
    }
    let deviations: Vec<String> = report.deviations.iter().map(deviation).collect();
    let many = if report.deviation_count == 1 { "deviation" } else { "deviations" };
    writeln!(out, "\n{BAD}{} {many}{BAD:#}", report.deviation_count)?;
    for found in deviations.iter().take(MAX_LISTED) {
        writeln!(out, "  {}", wrapped(found, 2, 4))?;
    }
    let more = report.deviation_count.saturating_sub(deviations.len().min(MAX_LISTED) as u64);
    if more > 0 {
        let counts = report.counts.iter().map(|(kind, count)| format!("{count} {kind}"));
        let counts: Vec<String> = counts.collect();
        writeln!(out, "  and {more} more; all together: {}", counts.join(", "))?;
    }
    Ok(())
}

fn list(out: &mut impl Write, title: &str, all: &[String]) -> anyhow::Result<()> {
    if all.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n{TITLE}{title}{TITLE:#}")?;
    for text in all.iter().take(MAX_LISTED) {
        writeln!(out, "  {text}")?;
    }
    if all.len() > MAX_LISTED {
        writeln!(out, "  and {} more", all.len() - MAX_LISTED)?;
    }
    Ok(())
}

/// Prints deviations of a log that is followed.
pub(super) fn as_they_come(deviations: &[Deviation]) -> anyhow::Result<()> {
    if deviations.is_empty() {
        return Ok(());
    }
    let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
    for found in deviations {
        writeln!(out, "{}", deviation(found))?;
    }
    out.flush()?;
    Ok(())
}

fn deviation(deviation: &Deviation) -> String {
    let line = deviation.line;
    let what = words(&deviation.what);
    let rule = deviation.what.rule();
    let text =
        format!("line {line}, at {}: {} {what} (rule: {rule})", nanos(deviation.at), deviation.of);
    terminal::text(&text).into_owned()
}

fn words(what: &DeviationKind) -> String {
    match what {
        DeviationKind::Unknown { task, service, function, from, why } => {
            let why = match why {
                Mismatch::Component => "has no such component",
                Mismatch::Task => "has no such task",
                Mismatch::State => "has no such state or codel",
                Mismatch::Function => "has another function there",
                Mismatch::WrongTask => "has this activity in another task",
                Mismatch::NoCodel => "has no codel there",
            };
            format!("executed `{function}` ({task} {service} {from}), but the specification {why}")
        }
        DeviationKind::Transition { from, to } => {
            format!("led from {from} to {to}, which is not declared")
        }
        DeviationKind::Elsewhere { state, awaited } => match awaited {
            Some(awaited) => format!("was executed in {state}, while {awaited} was to follow"),
            None => format!("was executed in {state}, to which nothing had led"),
        },
        DeviationKind::Longer { took, limit } => {
            format!("took {}, more than the declared {}", nanos(*took), nanos(*limit))
        }
        DeviationKind::Shorter { took, limit } => {
            format!("took {}, less than the declared {}", nanos(*took), nanos(*limit))
        }
        DeviationKind::Together { other } => format!("was executed together with {other}"),
        DeviationKind::Overtaken { other } => {
            format!("got its locks before {other}, which had asked earlier")
        }
        DeviationKind::SameTask { other } => {
            format!("was executed while its task executed {other}")
        }
        DeviationKind::SameCore { other, core } => {
            format!("was executed while {other} had their only core, {core}")
        }
        DeviationKind::Cores { executing, cores } => {
            format!("was one of {executing} codels that executed at one time on {cores} cores")
        }
        DeviationKind::Early { by, period } => format!(
            "began a turn at least {} before its tick, with a period of {}",
            nanos(*by),
            nanos(*period)
        ),
        DeviationKind::Late { by, period } => format!(
            "began a turn at least {} later than its response time allows, with a period of {}",
            nanos(*by),
            nanos(*period)
        ),
        DeviationKind::Response { response, bound } => {
            format!("took {} for a job, more than the proved {}", nanos(*response), nanos(*bound))
        }
        DeviationKind::Check => "is violated".to_owned(),
    }
}
