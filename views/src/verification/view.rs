//! The results of a verification in a common form, for command line, lenses, panel and diagnostics.

use std::ops::Range;

use dotgen_timing::report::{
    Awaited, CheckReport, Delay, Report, Soundness, TimeUnit, Value, Verdict,
};
use dotgen_timing::scn::ast::{Check, CheckKind, Scenario};
use dotgen_timing::system::ground;
use dotgen_timing::system::indexed::DeclaredTask;
use dotgen_timing::verify::{Options, settings};

use super::Problem;
use super::summary::percent;
use super::why::FailureCause;

/// A check with its result.
#[derive(Debug, Clone)]
pub struct CheckView<'r> {
    pub report: &'r CheckReport,
    pub verdict: Verdict,
    /// `≤ 5 ms`; the sign shows a bound.
    pub value: Option<String>,
    /// `10 ms`: the stated limit, or the period.
    pub limit: Option<String>,
    /// `≤ 5 of 10 ms`: the value and the limit; the value alone without a limit.
    pub share: Option<String>,
    /// `≥ 30 %`
    pub slack: Option<String>,
    /// What the verdict rests on although it is not stated, in a sentence.
    pub condition: Option<String>,
    /// A restriction of the verdict, if it is not exact.
    pub worth: Option<&'static str>,
    /// The causes of a late job, a sentence for each wait.
    pub reason: Vec<String>,
    /// The cause of a task's failure, in one sentence.
    pub cause: Option<String>,
    /// A change with which the check holds, if one is known.
    pub remedy: Option<String>,
    /// The cause and the remedy, as data.
    pub why: Option<&'r FailureCause>,
    /// The range of the check in the scenario.
    pub written: Option<Range<usize>>,
    /// True if it is one of several answers to a check of all tasks.
    pub is_one_of_all: bool,
}

/// The results of a verification.
pub struct View<'r> {
    /// The checks, in the order of the report.
    pub checks: Vec<CheckView<'r>>,
}

impl<'r> View<'r> {
    /// The view of the report of a problem.
    pub fn new(
        problem: &Problem,
        options: &Options,
        report: &'r Report,
        why: &'r [Option<FailureCause>],
    ) -> View<'r> {
        let unit = TimeUnit::of(&settings(&problem.scenario, options));
        // Checks of the command line are not in the scenario.
        let written = options.checks.is_empty() && problem.is_written();
        let scenario = written.then_some(&problem.scenario);
        let checks = report.checks.iter().enumerate();
        let why = |i: usize| why.get(i).and_then(Option::as_ref);
        View {
            checks: checks
                .map(|(i, check)| CheckView::new(check, unit, scenario, why(i)))
                .collect(),
        }
    }

    /// The results of a task.
    pub fn of_task(&self, task: DeclaredTask) -> impl Iterator<Item = (usize, &CheckView<'r>)> {
        let all = self.checks.iter().enumerate();
        all.filter(move |(_, check)| check.report.id.task == Some(task))
    }
}

impl<'r> CheckView<'r> {
    fn new(
        report: &'r CheckReport,
        unit: TimeUnit,
        scenario: Option<&Scenario>,
        why: Option<&'r FailureCause>,
    ) -> CheckView<'r> {
        let bound = report.rounded || report.soundness == Soundness::UpperBound;
        let (sign, least) = match report.verdict {
            Verdict::Unknown => ("≥ ", ""),
            _ if bound => ("≤ ", "≥ "),
            _ => ("", ""),
        };
        let written = scenario.and_then(|scenario| check_of(scenario, report));
        CheckView {
            report,
            verdict: report.verdict,
            // An infinite bound is not shown.
            value: report.value.map(|value| match value {
                Value::Unbounded => unit.show_value(value),
                Value::Time(_) => format!("{sign}{}", unit.show_value(value)),
            }),
            share: report.value.map(|value| match (value, report.limit) {
                (Value::Time(time), Some(limit)) => {
                    format!("{sign}{}", unit.show_share(time, limit.time()))
                }
                (Value::Time(time), None) => format!("{sign}{}", unit.show(time)),
                (Value::Unbounded, Some(limit)) => {
                    format!("{} of {}", unit.show_value(value), unit.show(limit.time()))
                }
                (Value::Unbounded, None) => unit.show_value(value),
            }),
            limit: report.limit.map(|limit| unit.show(limit.time())),
            slack: report.slack().map(|slack| format!("{least}{}", percent(slack))),
            condition: (!report.conditions.is_empty())
                .then(|| ground::sentence(&report.conditions)),
            worth: match report.soundness {
                _ if report.rounded => Some("durations are rounded"),
                // The sign before the value, and the note, show it.
                Soundness::Exact | Soundness::UpperBound | Soundness::LowerBound => None,
                Soundness::Safe => Some("safe: a failure may be a false alarm"),
                Soundness::Under => Some("for worst-case durations only"),
                Soundness::WholeUnits => Some("only for codels that end at whole units of time"),
                Soundness::Neither => Some("for worst-case durations only, indicative"),
            },
            reason: report.reason.iter().map(|reason| sentence(reason, unit)).collect(),
            cause: why.map(|cause| cause.cause_in_words(unit)),
            remedy: why.and_then(|cause| cause.remedy_in_words(unit)),
            why,
            written: written.map(|check| check.range.clone()),
            is_one_of_all: written.is_some_and(is_of_all),
        }
    }

    /// `schedulable c.t`
    pub fn title(&self) -> String {
        format!("{} {}", self.report.kind, self.report.of)
    }
}

/// The check of a scenario that a report answers.
fn check_of<'s>(scenario: &'s Scenario, report: &CheckReport) -> Option<&'s Check> {
    scenario.checks().nth(report.id.written)
}

fn is_of_all(check: &Check) -> bool {
    use CheckKind::{NoOverdue, Response, Schedulable};
    matches!(check.kind, Schedulable(None) | NoOverdue(None) | Response(None, _))
}

/// `waits for a lock from 4 ms to 9 ms (b.u.main): c.v.main of c.v has it until 7 ms, then …`
fn sentence(delay: &Delay, unit: TimeUnit) -> String {
    let what = match (&delay.codel, delay.awaited) {
        (Some(codel), _) => format!("{codel} waits for its locks"),
        (None, Awaited::Core | Awaited::Lock) => "the job waits for a core".to_owned(),
    };
    let held = delay.held.iter().map(|holder| {
        let who = match &holder.codel {
            Some(codel) => codel.to_string(),
            None => holder.by.to_string(),
        };
        format!("{who} ({} to {})", unit.show(holder.from), unit.show(holder.until))
    });
    let held: Vec<String> = held.collect();
    let by = match &held[..] {
        [] => String::new(),
        [name] => format!(", held by {name}"),
        all => format!(
            ", held by {}, each of which took it as soon as it was free",
            all.join(", then ")
        ),
    };
    let (from, until) = (unit.show(delay.from), unit.show(delay.until));
    format!("{what} from {from} to {until}{by}")
}
