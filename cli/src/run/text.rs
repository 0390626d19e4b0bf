//! `--format text`: tables of tasks, services and checks, transitions that were never taken, violations.

use std::io::Write;

use clap::builder::styling::{AnsiColor, Style};
use dotgen_analysis::terminal;
use dotgen_runtime::checker::Verdict;
use dotgen_runtime::engine::End;
use dotgen_runtime::report::{CheckOutcome, RunMoment, RunReport, Violated};
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{CheckReport, TimeUnit, Value};

use super::{Answer, Contents};
use crate::verify::text::ground;
use crate::width::{Table, heading, wrapped};

const TITLE: Style = Style::new().bold();
const FAINT: Style = Style::new().dimmed();
const GOOD: Style = AnsiColor::Green.on_default();
const BAD: Style = AnsiColor::Red.on_default().bold();
const OPEN: Style = AnsiColor::Yellow.on_default();

/// Maximum number of listed transitions that were never taken. Further ones are only counted.
const NEVER: usize = 20;

pub(super) fn print(answers: &[Answer]) -> anyhow::Result<()> {
    let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
    for (i, answer) in answers.iter().enumerate() {
        if i > 0 {
            writeln!(out)?;
        }
        print_one(&mut out, answer)?;
    }
    Ok(())
}

fn print_one(out: &mut impl Write, answer: &Answer) -> anyhow::Result<()> {
    let report = &answer.report;
    let unit = report.unit;
    let simulated = answer.executed_codels == 0;
    let platform = &answer.platform;
    let platform = if simulated { format!("simulated, {platform}") } else { platform.clone() };
    let rest = heading(&report.scenario, &platform, &answer.file);
    writeln!(out, "{TITLE}{}{TITLE:#}: {rest}", report.scenario)?;
    let runs = match report.runs {
        1 => "1 run".to_owned(),
        n => format!("{n} runs"),
    };
    writeln!(
        out,
        "{} clock, {} in {runs}, {}{} durations, seed {}",
        answer.clock.word(),
        unit.show_value(report.time),
        executed(answer),
        durations(report),
        report.seed,
    )?;
    tasks(out, report, unit)?;
    ports(out, report, unit)?;
    services(out, report)?;
    transitions(out, report)?;
    checks(out, &report.checks, unit)?;
    violations(out, report, unit)?;
    ground(out, &report.assumptions, &report.notes)?;
    for (path, count, of) in &answer.written {
        let what = match of {
            Contents::Lines => "lines",
            Contents::Codels => "runs of codels",
            Contents::Steps => "steps",
            Contents::Messages(_) => "messages of ports",
        };
        let path = terminal::name(path.as_str());
        let steps = match of {
            Contents::Messages(steps) => format!(" and {steps} steps"),
            _ => String::new(),
        };
        let line = format!("{TITLE}note{TITLE:#}: wrote {count} {what}{steps} to {path}");
        writeln!(out, "{}", wrapped(&line, 0, 2))?;
    }
    let (style, what) = match report.violation_count {
        0 => (GOOD, "nothing violated".to_owned()),
        1 => (BAD, "1 violation".to_owned()),
        n => (BAD, format!("{n} violations")),
    };
    let prefix = if simulated { "simulated: " } else { "" };
    write!(out, "\n{style}{prefix}{what}{style:#}")?;
    let idle = report.checks.iter().filter(|check| check.why.is_some()).count();
    match idle {
        0 => {}
        1 => write!(out, "; {OPEN}1 check not exercised{OPEN:#}")?,
        count => write!(out, "; {OPEN}{count} checks not exercised{OPEN:#}")?,
    }
    if !report.unfinished.is_empty() {
        write!(out, "; {BAD}not stopped in time: {}{BAD:#}", report.unfinished.join(", "))?;
    }
    match ended(report.end) {
        Some(why) => writeln!(out, "; {OPEN}{why}{OPEN:#}")?,
        None => writeln!(out)?,
    }
    Ok(())
}

/// Returns the number of executed codels, if there are any.
fn executed(answer: &Answer) -> String {
    match (answer.executed_codels, answer.simulated_codels) {
        (0, _) => String::new(),
        (real, 0) => format!("{real} codels executed, "),
        (real, simulated) => format!("{real} codels executed, {simulated} simulated, "),
    }
}

fn durations(report: &RunReport) -> &'static str {
    use dotgen_runtime::decide::Durations::{Best, Random, Worst};
    match report.durations {
        Worst => "worst",
        Random => "random",
        Best => "best",
    }
}

/// Returns the reason why the last run ended early.
fn ended(end: End) -> Option<&'static str> {
    match end {
        End::Done => None,
        End::NothingLeft => Some("the last run ended when nothing was left to happen"),
        End::Standstill => Some(
            "ended where time stands still: codels that take no time follow each other without a pause; \
             state their `wcet`",
        ),
        End::Stopped => Some("stopped at the first one, as was asked for"),
        End::Measure => Some("ended by a measure of the scenario"),
        End::Interrupted => Some("interrupted"),
        End::NotStarted => Some("a component could not be started"),
    }
}

fn value(value: Option<Value>, unit: TimeUnit) -> String {
    value.map_or_else(String::new, |value| unit.show_value(value))
}

fn tasks(out: &mut impl Write, report: &RunReport, unit: TimeUnit) -> std::io::Result<()> {
    let rows = report.tasks.iter().map(|task| {
        let missed = if task.period.is_some() { task.missed.to_string() } else { String::new() };
        vec![
            task.task.clone(),
            value(task.period, unit),
            task.jobs.to_string(),
            value(task.mean, unit),
            value(task.greatest, unit),
            value(task.bound, unit),
            missed,
        ]
    });
    let head = ["task", "period", "jobs", "mean", "greatest", "bound", "missed"];
    table(out, &head, &rows.collect::<Vec<_>>())
}

fn ports(out: &mut impl Write, report: &RunReport, unit: TimeUnit) -> std::io::Result<()> {
    let rows = report.ports.iter().map(|row| {
        let age = row.greatest_age.map_or("never written".to_owned(), |age| unit.show_value(age));
        vec![row.port.clone(), row.writes.to_string(), age]
    });
    table(out, &["port", "writes", "greatest age"], &rows.collect::<Vec<_>>())
}

fn services(out: &mut impl Write, report: &RunReport) -> std::io::Result<()> {
    let rows = report.services.iter().filter(|service| service.requests > 0);
    let rows = rows.map(|row| {
        vec![
            row.service.clone(),
            row.requests.to_string(),
            row.refused.to_string(),
            if row.is_activity || row.ended > 0 { row.ended.to_string() } else { String::new() },
        ]
    });
    let rows: Vec<_> = rows.collect();
    table(out, &["service", "requests", "refused", "ended"], &rows)?;
    match report.requests_outside_model {
        0 => Ok(()),
        1 => writeln!(
            out,
            "outside the verified model: 1 request, which no client of the scenario sends"
        ),
        count => writeln!(
            out,
            "outside the verified model: {count} requests, which no client of the scenario sends"
        ),
    }
}

fn transitions(out: &mut impl Write, report: &RunReport) -> std::io::Result<()> {
    let all = report.machines.iter().flat_map(|machine| {
        let of = machine.transitions.iter();
        of.map(move |transition| (&machine.machine, transition))
    });
    let (mut taken, mut never) = (0, Vec::new());
    for (machine, transition) in all {
        match transition.taken {
            0 => never.push(format!("{machine}: {} → {}", transition.from, transition.to)),
            _ => taken += 1,
        }
    }
    let of = taken + never.len();
    if of == 0 {
        return Ok(());
    }
    writeln!(out, "\n{TITLE}transitions{TITLE:#}: {taken} of {of} taken")?;
    for text in never.iter().take(NEVER) {
        writeln!(out, "  {FAINT}never{FAINT:#} {text}")?;
    }
    if never.len() > NEVER {
        let more = never.len() - NEVER;
        writeln!(out, "  {FAINT}… and {more} more; `--format json` has all{FAINT:#}")?;
    }
    Ok(())
}

fn word(outcome: &CheckOutcome) -> &'static str {
    match outcome.verdict {
        // The word that `dotgen verify` uses.
        Verdict::Kept | Verdict::Simulated if outcome.exceeded => "exceeds",
        Verdict::Simulated => "simulated",
        Verdict::Kept | Verdict::Seen => "kept",
        Verdict::Violated => "violated",
        Verdict::NotExercised | Verdict::NotSeen => "not exercised",
    }
}

/// Prints the results of checks.
pub(crate) fn checks(
    out: &mut impl Write,
    checks: &[CheckOutcome],
    unit: TimeUnit,
) -> std::io::Result<()> {
    let rows = checks.iter().map(|check| {
        vec![
            word(check).to_owned(),
            title(check),
            value(check.greatest, unit),
            value(check.limit, unit),
            check.probability.map_or(String::new(), |estimate| {
                format!("{:.4} … {:.4}", estimate.low, estimate.high)
            }),
        ]
    });
    let rows: Vec<_> = rows.collect();
    table(out, &["verdict", "check", "greatest", "limit", "probability"], &rows)?;
    if let Some(estimate) = checks.iter().find_map(|check| check.probability) {
        let line = format!(
            "probability: that a run violates the check, or sees the expected event, with the choices as \
             they are drawn; {} % confidence",
            100.0 * estimate.confidence
        );
        writeln!(out, "{FAINT}{}{FAINT:#}", wrapped(&line, 0, 2))?;
    }
    for check in checks {
        if let Some(why) = &check.why {
            let line = format!("{OPEN}not exercised{OPEN:#} {}: {why}", title(check));
            writeln!(out, "{}", wrapped(&line, 0, 2))?;
        }
    }
    Ok(())
}

/// Returns the name of a check of a run.
pub(crate) fn title(outcome: &CheckOutcome) -> String {
    titled(outcome.name.as_deref(), outcome.check, &outcome.of)
}

/// Returns the name of a check of a run that goes on.
pub(crate) fn check_title(check: &CheckReport) -> String {
    titled(check.name.as_deref(), check.kind, &check.of)
}

fn titled(name: Option<&str>, kind: PropertyKind, of: &str) -> String {
    let named = name.map_or(String::new(), |name| format!("{name}: "));
    let of = if of.is_empty() { String::new() } else { format!(" {of}") };
    format!("{named}{kind}{of}")
}

fn violations(out: &mut impl Write, report: &RunReport, unit: TimeUnit) -> std::io::Result<()> {
    for violation in &report.violations {
        let at = moment(&violation.at, report, unit);
        let what = match &violation.what {
            Violated::Check { check } => report.checks.get(*check).map_or_else(String::new, title),
            other => violated(other, unit),
        };
        let more = times(violation.times);
        let line = format!("{BAD}violated{BAD:#} {what}, {at}{more}");
        writeln!(out, "\n{}", wrapped(&line, 0, 2))?;
    }
    Ok(())
}

/// Returns what is violated, and how, for a violation of no check.
pub(super) fn violated(what: &Violated, unit: TimeUnit) -> String {
    match what {
        Violated::Check { .. } => "a check".to_owned(),
        Violated::BeyondBound { task, response, bound } => format!(
            "the proved bound of {task}: {} is more than {}",
            unit.show_value(*response),
            unit.show_value(*bound)
        ),
        Violated::Undeclared { codel, function, event } => {
            let what = if event.is_empty() {
                "something that is not an event of its component".to_owned()
            } else {
                format!("`{event}`, which its specification does not declare")
            };
            format!("the transitions of {codel}: `{function}` returned {what}")
        }
        Violated::Lost { component, codel, function, why } => {
            let of = match (codel, function) {
                (Some(codel), Some(function)) => format!(" in `{function}` ({codel})"),
                _ => String::new(),
            };
            format!("that components run: `{component}` {why}{of}")
        }
        Violated::Overrun { codel, function, took, limit } => format!(
            "the execution time of {codel}: `{function}` took {}, more than {}",
            unit.show_value(*took),
            unit.show_value(*limit)
        ),
    }
}

fn times(count: u64) -> String {
    match count {
        0 | 1 => String::new(),
        n => format!("; {n} times in all"),
    }
}

/// Returns the time of an event, and the options that repeat it.
fn moment(at: &RunMoment, report: &RunReport, unit: TimeUnit) -> String {
    let time = unit.show_value(at.time);
    match report.runs {
        1 => format!("first at {time}"),
        _ => format!("first at {time} of run {} (`--seed {}`)", at.run, at.seed),
    }
}

/// Prints a table. The first column is left-aligned, and so is the second if it is text. Numbers are
/// right-aligned.
fn table(out: &mut impl Write, head: &[&str], rows: &[Vec<String>]) -> std::io::Result<()> {
    if rows.is_empty() {
        return Ok(());
    }
    let texts = if head[0] == "verdict" { 2 } else { 1 };
    let rows = rows.iter().map(|row| row.iter().map(String::as_str).collect::<Vec<_>>());
    let rows: Vec<Vec<&str>> = std::iter::once(head.to_vec()).chain(rows).collect();
    let mut lines = Table { texts, long: texts - 1, indent: 2 }.lines(&rows).into_iter();
    writeln!(out, "\n{FAINT}{}{FAINT:#}", lines.next().unwrap_or_default())?;
    for line in lines {
        writeln!(out, "{line}")?;
    }
    Ok(())
}
