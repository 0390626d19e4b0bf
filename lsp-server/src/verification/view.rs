//! A verification as people look at it, made once: command line, lenses, panel and diagnostics show this.

use std::ops::Range;

use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{
    Awaited, CheckReport, Delay, Report, Soundness, TaskId, Value, Verdict,
};
use dotgen_timing::scn::ast::{Check, CheckKind, Item, Scenario};
use dotgen_timing::verify::{Options, settings};

use super::Problem;
use super::summary::{Scale, percent};
use super::why::Why;

/// What an answer amounts to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It holds.
    Proved,
    /// It holds because what it is about never happens.
    Vacuous,
    /// It has a bound that is greater than the period of the task, and may be less in fact.
    Bounded,
    /// It has a bound beyond the period of the task, and the scenario states no limit.
    Exceeds,
    /// It does not hold.
    Refuted,
    /// It may not hold: the run that shows it is one with rounded durations.
    PossiblyRefuted,
    /// Nobody knows.
    GaveUp,
    /// Execution times are missing.
    Nothing,
    /// There is no answer yet.
    Open,
}

impl Outcome {
    /// In the table of the command line, and the panel.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Outcome::Proved => "proved",
            Outcome::Vacuous => "vacuous",
            Outcome::Bounded => "bounded",
            Outcome::Exceeds => "exceeds",
            Outcome::Refuted => "refuted",
            Outcome::PossiblyRefuted => "refuted?",
            Outcome::GaveUp => "gave up",
            Outcome::Nothing => "nothing",
            Outcome::Open => "open",
        }
    }

    /// Where several are counted: `2 nothing to verify`.
    pub(crate) fn counted(self) -> &'static str {
        match self {
            Outcome::Exceeds => "beyond the period",
            Outcome::PossiblyRefuted => "possibly refuted",
            Outcome::Nothing => "nothing to verify",
            _ => self.word(),
        }
    }

    /// In the order in which they are counted.
    pub(crate) const ALL: [Outcome; 9] = [
        Outcome::Proved,
        Outcome::Vacuous,
        Outcome::Bounded,
        Outcome::Exceeds,
        Outcome::Refuted,
        Outcome::PossiblyRefuted,
        Outcome::GaveUp,
        Outcome::Nothing,
        Outcome::Open,
    ];

    fn of(report: &CheckReport) -> Outcome {
        match report.verdict {
            Verdict::Proved if report.vacuous => Outcome::Vacuous,
            Verdict::Proved if report.exceeds() => Outcome::Exceeds,
            // An upper bound beyond the period says neither that it is kept nor that it is not.
            Verdict::Proved if report.slack().is_some_and(|it| it < 0.0) => Outcome::Bounded,
            Verdict::Proved => Outcome::Proved,
            // That something is reachable is what rounding makes uncertain, not that it is not.
            Verdict::Refuted if report.rounded && report.kind != PropertyKind::Reachable => {
                Outcome::PossiblyRefuted
            }
            Verdict::Refuted => Outcome::Refuted,
            Verdict::Unknown => Outcome::GaveUp,
            Verdict::Nothing => Outcome::Nothing,
            Verdict::Open => Outcome::Open,
        }
    }
}

/// An answer.
#[derive(Debug, Clone)]
pub(crate) struct CheckView<'r> {
    /// What was found.
    pub(crate) report: &'r CheckReport,
    /// What it amounts to.
    pub(crate) outcome: Outcome,
    /// `≤ 5 ms`; the sign says whether it is a bound.
    pub(crate) value: Option<String>,
    /// `10 ms`: stated, or the period.
    pub(crate) limit: Option<String>,
    /// `≥ 30 %`
    pub(crate) slack: Option<String>,
    /// What the verdict is worth, if it is not exact.
    pub(crate) worth: Option<&'static str>,
    /// Why a job is late, a sentence for each wait.
    pub(crate) reason: Vec<String>,
    /// Why it fails in one sentence, for a task.
    pub(crate) cause: Option<String>,
    /// What would make it hold, if that is known.
    pub(crate) remedy: Option<String>,
    /// Both as data.
    pub(crate) why: Option<&'r Why>,
    /// Where the check is written, in the scenario.
    pub(crate) written: Option<Range<usize>>,
    /// It is one of several answers to a check of all tasks.
    pub(crate) is_one_of_all: bool,
}

/// See the module.
pub(crate) struct View<'r> {
    /// In the order of the report.
    pub(crate) checks: Vec<CheckView<'r>>,
}

impl<'r> View<'r> {
    /// Of the report of a problem.
    pub(crate) fn new(
        problem: &Problem,
        options: &Options,
        report: &'r Report,
        why: &'r [Option<Why>],
    ) -> View<'r> {
        let scale = Scale::of(&settings(&problem.scenario, options));
        // Checks of the command line stand in no scenario.
        let written = options.checks.is_empty() && problem.is_written();
        let scenario = written.then_some(&problem.scenario);
        let checks = report.checks.iter().enumerate();
        let why = |i: usize| why.get(i).and_then(Option::as_ref);
        View {
            checks: checks
                .map(|(i, it)| CheckView::new(it, scale, scenario, why(i)))
                .collect(),
        }
    }

    /// The answers about a task.
    pub(crate) fn of_task(&self, task: TaskId) -> impl Iterator<Item = (usize, &CheckView<'r>)> {
        let all = self.checks.iter().enumerate();
        all.filter(move |it| it.1.report.id.task == Some(task))
    }
}

impl<'r> CheckView<'r> {
    fn new(
        report: &'r CheckReport,
        scale: Scale,
        scenario: Option<&Scenario>,
        why: Option<&'r Why>,
    ) -> CheckView<'r> {
        let outcome = Outcome::of(report);
        let bound = report.rounded || report.soundness == Soundness::UpperBound;
        let (sign, least) = match report.verdict {
            Verdict::Unknown => ("≥ ", ""),
            _ if bound => ("≤ ", "≥ "),
            _ => ("", ""),
        };
        let written = scenario.and_then(|it| check_of(it, report));
        CheckView {
            report,
            outcome,
            // A bound that says nothing is none.
            value: report.value.map(|it| match it {
                Value::Unbounded => scale.show_value(it),
                Value::Time(_) => format!("{sign}{}", scale.show_value(it)),
            }),
            limit: report.limit.map(|it| scale.show(it.time())),
            slack: report.slack().map(|it| format!("{least}{}", percent(it))),
            worth: match report.soundness {
                _ if report.rounded => Some("durations are rounded"),
                // The sign before the value says it, and the note why.
                Soundness::Exact | Soundness::UpperBound => None,
                Soundness::Safe => Some("safe: a failure may be a false alarm"),
                Soundness::Under => Some("for worst-case durations only"),
                Soundness::WholeUnits => Some("shown for ends at whole units of time"),
                Soundness::Neither => Some("for worst-case durations only, indicative"),
            },
            reason: report.reason.iter().map(|it| sentence(it, scale)).collect(),
            cause: why.map(|it| it.cause_in_words(scale)),
            remedy: why.and_then(|it| it.remedy_in_words(scale)),
            why,
            written: written.map(|it| it.range.clone()),
            is_one_of_all: written.is_some_and(is_of_all),
        }
    }

    /// `schedulable c.t`
    pub(crate) fn title(&self) -> String {
        format!("{} {}", self.report.kind, self.report.of)
    }
}

/// The check of a scenario that a report answers.
fn check_of<'s>(scenario: &'s Scenario, report: &CheckReport) -> Option<&'s Check> {
    let checks = scenario.items.iter().filter_map(|it| match it {
        Item::Check(check) => Some(check),
        _ => None,
    });
    checks.into_iter().nth(report.id.written)
}

fn is_of_all(check: &Check) -> bool {
    use CheckKind::{NoOverdue, Response, Schedulable};
    matches!(
        check.kind,
        Schedulable(None) | NoOverdue(None) | Response(None, _)
    )
}

/// `waits for a lock from 4 ms to 9 ms (b.u.main): c.v.main of c.v has it until 7 ms, then …`
fn sentence(it: &Delay, scale: Scale) -> String {
    let what = match (&it.codel, it.awaited) {
        (Some(codel), _) => format!("{codel} waits for its locks"),
        (None, Awaited::Core | Awaited::Lock) => "the job waits for a core".to_owned(),
    };
    let held = it.held.iter().map(|it| {
        let who = match &it.codel {
            Some(codel) => codel.clone(),
            None => it.by.clone(),
        };
        format!(
            "{who} ({} to {})",
            scale.show(it.from),
            scale.show(it.until)
        )
    });
    let held: Vec<String> = held.collect();
    let by = match &held[..] {
        [] => String::new(),
        [it] => format!(", held by {it}"),
        all => format!(
            ", held by {}, each of which took it as soon as it was free",
            all.join(", then ")
        ),
    };
    let (from, until) = (scale.show(it.from), scale.show(it.until));
    format!("{what} from {from} to {until}{by}")
}
