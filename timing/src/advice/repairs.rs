//! Every single change with which all deadlines and limits are kept, where some are not.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::blame::{distinct, suspects, tasks, waited_for};
use super::change::Change;
use super::remedy::limits;
use super::trial::Trial;
use crate::explore::Limits;
use crate::questions;
use crate::report::{CheckReport, Report, Verdict};
use crate::scn::ast::{Policy, Scenario};
use crate::scn::names::Names;
use crate::system::FOREVER;
use crate::verify::{Cancel, Options, SystemInput, settings};

/// Policies that are worth trying: with the others an order is left open, which proves nothing that these do
/// not.
const POLICIES: [Policy; 3] = [Policy::Priority, Policy::Edf, Policy::Fifo];

/// What was found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Repairs {
    /// Changes with which everything holds, [the smallest](Change::size) first.
    pub changes: Vec<Change>,
    /// Set when time was up, or it was cancelled: not everything was tried.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub incomplete: bool,
}

/// How far [`repairs`] has come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trying {
    /// What was tried, of all.
    pub done: usize,
    /// All that is tried.
    pub of: usize,
    /// What is tried now, in words.
    pub trying: String,
}

/// What is tried.
enum Candidate {
    Policy(Policy),
    Cores,
    Wcet(String),
    Lock(String, String),
    Period(usize),
    Delay(usize),
}

impl Candidate {
    fn in_words(&self, trial: &Trial) -> String {
        let task = |it: &usize| trial.built().system.task_path(*it);
        match self {
            Candidate::Policy(it) => format!("policy {}", it.name()),
            Candidate::Cores => "more cores".to_owned(),
            Candidate::Wcet(codel) => format!("less time for {codel}"),
            Candidate::Lock(copies, other) => format!("{copies} apart from {other}"),
            Candidate::Period(it) => format!("a longer period for {}", task(it)),
            Candidate::Delay(it) => format!("a later start of {}", task(it)),
        }
    }

    fn tried(&self, trial: &Trial) -> Option<Change> {
        match self {
            Candidate::Policy(it) => trial.policy(*it),
            Candidate::Cores => trial.cores(),
            Candidate::Wcet(codel) => trial.wcet(codel),
            Candidate::Lock(copies, other) => trial.apart(copies, other),
            Candidate::Period(it) => trial.period(*it),
            Candidate::Delay(it) => trial.delay(*it),
        }
    }
}

/// Whether a deadline or a limit is missed for certain.
fn misses(it: &CheckReport) -> bool {
    let limited = it.kind.is_deadline() || it.kind.is_time();
    let fails = it.verdict == Verdict::Refuted && !it.rounded;
    limited && (fails || it.exceeds())
}

/// Who is told: what is being tried, and each change when it is found.
pub type Tell<'a, T = Change> = (&'a (dyn Fn(Trying) + Sync), &'a (dyn Fn(&T) + Sync));

/// The single changes with which every check of a deadline or a limit holds, those that were given up apart:
/// what is blamed by the runs that show what is missed is tried first. Each is told when it is found, and was
/// verified itself. Nothing where nothing is missed.
///
/// With a `patience` nothing more is tried after it.
pub fn repairs(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    report: &Report,
    (cancel, patience): (&Cancel, Option<Duration>),
    (trying, tell): Tell<'_>,
) -> Repairs {
    let missed: Vec<&CheckReport> = report.checks.iter().filter(|it| misses(it)).collect();
    if missed.is_empty() {
        return Repairs::default();
    }
    let names = Names::new(&input.specs);
    let mut settings = settings(scenario, options);
    // What was not answered cannot be asked of a change either.
    let asked = |written: usize| {
        let mut own = report.checks.iter().filter(|it| it.id.written == written);
        let kept = |it: &CheckReport| {
            let limited = it.kind.is_deadline() || it.kind.is_time();
            limited && matches!(it.verdict, Verdict::Proved | Verdict::Refuted)
        };
        own.clone().next().is_some() && own.all(kept)
    };
    let mut written = 0..;
    settings
        .checks
        .retain(|_| written.next().is_some_and(&asked));
    let limits = limits(report, options);
    let together = limits.threads.max(1);
    let limits = Limits {
        bytes: limits.bytes / together,
        ..limits
    };
    let end = patience.map(|it| Instant::now() + it);
    let trial = Trial::new(&names, settings, limits, cancel, end);
    let candidates = candidates(&trial, &missed);
    let late = || end.is_some_and(|end| Instant::now() > end);
    let found = questions::all(
        &candidates,
        together,
        cancel,
        &|done, it| {
            trying(Trying {
                done,
                of: candidates.len(),
                trying: it.in_words(&trial),
            })
        },
        &|it| it.tried(&trial),
        &|it| it.iter().for_each(tell),
    );
    let mut changes: Vec<Change> = found.into_iter().flatten().flatten().collect();
    changes.sort_by(|a, b| {
        let ((kind, size), (other, than)) = (a.size(), b.size());
        kind.cmp(&other).then(size.total_cmp(&than))
    });
    Repairs {
        changes,
        incomplete: cancel.is_over() || late(),
    }
}

/// What is blamed first; of the rest the longest codels first. Codels that nothing executes are left out.
fn candidates(trial: &Trial, missed: &[&CheckReport]) -> Vec<Candidate> {
    let system = &trial.built().system;
    let executed = system.executed();
    let mut codels: Vec<_> = (system.codels.iter().zip(executed))
        .filter(|(it, executed)| *executed && it.site.is_some() && it.upper != FOREVER)
        .map(|it| it.0)
        .collect();
    codels.sort_by_key(|it| std::cmp::Reverse(it.upper));
    let of_system = |path: &String| codels.iter().any(|it| it.path == *path);
    let blamed = missed.iter().flat_map(|it| suspects(it)).filter(of_system);
    let others = codels.iter().map(|it| it.path.clone());
    let blamed_tasks = distinct(missed.iter().flat_map(|it| tasks(it)));
    let mut tasks: Vec<usize> = (0..system.tasks.len())
        .filter(|&it| system.tasks[it].period.is_some())
        .collect();
    let place = |it: &usize| {
        let path = system.task_path(*it);
        let place = blamed_tasks.iter().position(|it| *it == path);
        place.unwrap_or(usize::MAX)
    };
    tasks.sort_by_key(place);
    let pairs = distinct(missed.iter().flat_map(|it| waited_for(it)));
    let mut out: Vec<Candidate> = POLICIES.map(Candidate::Policy).into();
    out.push(Candidate::Cores);
    let codels = distinct(blamed.chain(others));
    out.extend(codels.into_iter().map(Candidate::Wcet));
    // Who holds the lock takes a copy, or who waits for it.
    out.extend(pairs.into_iter().flat_map(|(waits, holds)| {
        let pair = |copies: &String, other: &String| Candidate::Lock(copies.clone(), other.clone());
        [pair(&holds, &waits), pair(&waits, &holds)]
    }));
    out.extend(tasks.iter().map(|&it| Candidate::Delay(it)));
    out.extend(tasks.iter().map(|&it| Candidate::Period(it)));
    out
}
