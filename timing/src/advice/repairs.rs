//! All single changes with which all deadlines and limits are kept.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::change::Change;
use super::remedy::limits;
use super::suspects::{distinct, suspects, tasks, waited_for};
use super::trial::Trial;
use crate::explore::Limits;
use crate::questions;
use crate::report::{CheckReport, Report, Verdict};
use crate::scn::ast::{Policy, Scenario};
use crate::scn::names::Names;
use crate::system::{CodelName, FOREVER, TaskId};
use crate::verify::{Cancel, Options, SystemInput, settings};

/// Policies to try. The other policies leave the order open, and prove nothing that these do not.
const POLICIES: [Policy; 3] = [Policy::Priority, Policy::Edf, Policy::Fifo];

/// The repairs found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Repairs {
    /// Changes with which all checks hold, [the smallest](Change::size) first.
    pub changes: Vec<Change>,
    /// The time limit was reached, or the search was cancelled: not all changes were tried.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub incomplete: bool,
}

/// The progress of [`repairs`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RepairProgress {
    /// Number of changes tried.
    pub done: usize,
    /// Number of changes to try.
    pub of: usize,
    /// Present change, in words.
    pub trying: String,
}

/// A change to try.
enum Candidate {
    Policy(Policy),
    Cores,
    Wcet(CodelName),
    Lock(CodelName, CodelName),
    Period(TaskId),
    Delay(TaskId),
}

impl Candidate {
    fn describe(&self, trial: &Trial) -> String {
        let task = |task: &TaskId| trial.built().system.task_path(*task);
        match self {
            Candidate::Policy(policy) => format!("policy {}", policy.name()),
            Candidate::Cores => "more cores".to_owned(),
            Candidate::Wcet(codel) => format!("less time for {codel}"),
            Candidate::Lock(copies, other) => format!("{copies} apart from {other}"),
            Candidate::Period(period) => format!("a longer period for {}", task(period)),
            Candidate::Delay(delay) => format!("a later start of {}", task(delay)),
        }
    }

    fn tried(&self, trial: &Trial) -> Option<Change> {
        match self {
            Candidate::Policy(policy) => trial.policy(*policy),
            Candidate::Cores => trial.cores(),
            Candidate::Wcet(codel) => trial.wcet(codel),
            Candidate::Lock(copies, other) => trial.apart(copies, other),
            Candidate::Period(period) => trial.period(*period),
            Candidate::Delay(delay) => trial.delay(*delay),
        }
    }
}

/// Returns true if a deadline or a limit is certainly missed.
fn misses(report: &CheckReport) -> bool {
    let limited = report.kind.is_deadline() || report.kind.is_time();
    let fails = report.verdict == Verdict::Refuted;
    limited && (fails || report.exceeds())
}

/// Callbacks for progress: the change to be tried, and each change that was found.
pub type RepairCallbacks<'a, T = Change> =
    (&'a (dyn Fn(RepairProgress) + Sync), &'a (dyn Fn(&T) + Sync));

/// Finds the single changes with which every check of a deadline or a limit holds, except checks that were
/// given up. Causes named by the runs of failed checks are tried first. Each change is verified, and reported
/// when it is found. If no check fails, the result is empty.
///
/// After `time_limit`, no further change is tried.
pub fn repairs(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    report: &Report,
    (cancel, time_limit): (&Cancel, Option<Duration>),
    (trying, tell): RepairCallbacks<'_>,
) -> Repairs {
    let missed: Vec<&CheckReport> = report.checks.iter().filter(|check| misses(check)).collect();
    if missed.is_empty() {
        return Repairs::default();
    }
    let names = Names::new(&input.specs);
    let mut settings = settings(scenario, options);
    // A check without an answer cannot be required of a change.
    let asked = |written: usize| {
        let mut own = report.checks.iter().filter(|check| check.id.written == written);
        let kept = |report: &CheckReport| {
            let limited = report.kind.is_deadline() || report.kind.is_time();
            limited && (report.verdict.holds() || report.verdict == Verdict::Refuted)
        };
        own.clone().next().is_some() && own.all(kept)
    };
    let mut written = 0..;
    settings.checks.retain(|_| written.next().is_some_and(&asked));
    let limits = limits(report, options);
    let together = limits.threads.max(1);
    let limits = Limits { bytes: limits.bytes / together, ..limits };
    let end = time_limit.map(|limit| Instant::now() + limit);
    let trial = Trial::new(&names, settings, report, limits, cancel, end);
    let candidates = candidates(&trial, &missed);
    let late = || end.is_some_and(|end| Instant::now() > end);
    let found = questions::all(
        &candidates,
        together,
        cancel,
        &|done, candidate| {
            trying(RepairProgress {
                done,
                of: candidates.len(),
                trying: candidate.describe(&trial),
            });
        },
        &|candidate| candidate.tried(&trial),
        &|change| change.iter().for_each(tell),
    );
    let mut changes: Vec<Change> = found.into_iter().flatten().flatten().collect();
    changes.sort_by(|a, b| {
        let ((kind, size), (other, than)) = (a.size(), b.size());
        kind.cmp(&other).then(size.total_cmp(&than))
    });
    Repairs { changes, incomplete: cancel.is_over() || late() }
}

/// Returns the changes to try: first the causes named by runs, then the longest codels. Codels that are never
/// executed are left out.
fn candidates(trial: &Trial, missed: &[&CheckReport]) -> Vec<Candidate> {
    let system = &trial.built().system;
    let executed = system.executed();
    let mut codels: Vec<_> = (system.codels.iter().zip(executed))
        .filter(|(codel, executed)| *executed && codel.site.is_some() && codel.upper != FOREVER)
        .map(|(codel, _)| codel)
        .collect();
    codels.sort_by_key(|codel| std::cmp::Reverse(codel.upper));
    let of_system = |path: &CodelName| codels.iter().any(|codel| codel.path == *path);
    let blamed = missed.iter().flat_map(|report| suspects(report)).filter(of_system);
    let others = codels.iter().map(|codel| codel.path.clone());
    let blamed_tasks = distinct(missed.iter().flat_map(|report| tasks(report)));
    let mut tasks: Vec<TaskId> =
        system.tasks.keys().filter(|&task| system.tasks[task].period.is_some()).collect();
    let place = |index: &TaskId| {
        let path = system.task_name(*index);
        let place = blamed_tasks.iter().position(|task| *task == path);
        place.unwrap_or(usize::MAX)
    };
    tasks.sort_by_key(place);
    let pairs = distinct(missed.iter().flat_map(|report| waited_for(report)));
    let mut out: Vec<Candidate> = POLICIES.map(Candidate::Policy).into();
    out.push(Candidate::Cores);
    let codels = distinct(blamed.chain(others));
    out.extend(codels.into_iter().map(Candidate::Wcet));
    // Either the holder of the lock takes a copy, or the codel that waits.
    out.extend(pairs.into_iter().flat_map(|(waits, holds)| {
        let pair =
            |copies: &CodelName, other: &CodelName| Candidate::Lock(copies.clone(), other.clone());
        [pair(&holds, &waits), pair(&waits, &holds)]
    }));
    out.extend(tasks.iter().map(|&task| Candidate::Delay(task)));
    out.extend(tasks.iter().map(|&task| Candidate::Period(task)));
    out
}
