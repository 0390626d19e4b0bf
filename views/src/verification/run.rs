//! A verification: quick bounds, the exact answer, then the number of cores.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use dotgen_timing::advice::RepairCallbacks;
use dotgen_timing::derive::{MinimumCores, minimum_cores};
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{CheckReport, Report, Verdict};
use dotgen_timing::verify::{Cancel, Options, SystemInput};

use super::changes::{self, Repair, Repairs};
use super::results::Answer;
use super::{Problem, TaskBound, quick_bounds, why};

/// Maximum duration of a verification, in seconds, after which the number of cores is computed: each number
/// of cores needs a verification of its own.
const QUICK_SECONDS: f64 = 1.0;

/// Time limit of the search for repairs.
const REPAIR_TIMEOUT: Duration = Duration::from_secs(2);

/// One verification at a time: verifications compete for memory, and the editor needs the other cores.
static VERIFICATION_LOCK: Mutex<()> = Mutex::new(());

/// An interim result.
pub enum Interim {
    /// Quick bounds.
    Bounds(Arc<Vec<TaskBound>>),
    /// The known part of the exact answer.
    SoFar(Arc<Answer>),
    /// The exact answer. Sent again with the number of cores, and with the remedies.
    Answer(Arc<Answer>),
}

/// Verifies within a time limit and reports results. Reports nothing after a cancellation.
pub fn run(
    problem: Arc<Problem>,
    options: Options,
    limit: Duration,
    cancel: &Cancel,
    tell: impl Fn(Interim) + Sync,
) {
    let _turn = VERIFICATION_LOCK.lock().unwrap_or_else(PoisonError::into_inner);
    if cancel.is_abandoned() {
        return;
    }
    cancel.limit(limit);
    let bounds = Arc::new(quick_bounds(&problem, &options, cancel));
    tell(Interim::Bounds(bounds.clone()));
    let answer = |report, why, repairs, cores| {
        Arc::new(Answer {
            problem: problem.clone(),
            options: options.clone(),
            report,
            why,
            repairs,
            bounds: bounds.clone(),
            cores,
        })
    };
    let report = problem.verify(&options, cancel, &|so_far| {
        let why = why::of_report(&problem, &options, so_far, None);
        let none = Repairs::default();
        tell(Interim::SoFar(answer(so_far.clone(), why, none, None)));
    });
    if cancel.is_abandoned() {
        return;
    }
    let mut why = why::of_report(&problem, &options, &report, None);
    let with = |why: &Vec<_>, repairs| answer(report.clone(), why.clone(), repairs, None);
    tell(Interim::Answer(with(&why, Repairs::default())));
    if why.iter().any(Option::is_some) && !cancel.is_over() {
        let found = why::of_report(&problem, &options, &report, Some(cancel));
        let helps = found.iter().flatten().any(|report| report.remedy.is_some());
        if helps && !cancel.is_abandoned() {
            why = found;
            tell(Interim::Answer(with(&why, Repairs::default())));
        }
    }
    if report.seconds < QUICK_SECONDS && !cancel.is_over() {
        let until = (cancel, Some(REPAIR_TIMEOUT));
        let untold: RepairCallbacks<'_, Repair> = (&|_| {}, &|_| {});
        let repairs = changes::repairs(&problem, &options, &report, until, untold);
        if !repairs.all.is_empty() && !cancel.is_abandoned() {
            tell(Interim::Answer(with(&why, repairs)));
        }
    }
    if report.seconds < QUICK_SECONDS
        && all_deadlines_proved(&report)
        && !cancel.is_over()
        && let Some(cores) = decided_cores(&problem, &options, cancel)
        && !cancel.is_abandoned()
    {
        let none = Repairs::default();
        tell(Interim::Answer(answer(report, why, none, Some(cores))));
    }
}

/// Returns true if deadlines are proved, and the others are those of tasks that are never released.
fn all_deadlines_proved(report: &Report) -> bool {
    let checks = report.checks.iter();
    let mut deadlines = checks.filter(|check| check.kind == PropertyKind::Schedulable);
    let is_proved = |check: &&CheckReport| check.verdict == Verdict::Proved;
    deadlines.clone().any(|check| is_proved(&check))
        && deadlines.all(|check| is_proved(&check) || check.verdict == Verdict::Vacuous)
}

/// Returns the least number of cores, if every number that was tried has an answer.
fn decided_cores(problem: &Problem, options: &Options, cancel: &Cancel) -> Option<MinimumCores> {
    let input = SystemInput { specs: problem.specs() };
    let cores = minimum_cores(&input, &problem.scenario, options, cancel).ok()?;
    let mut tried = cores.tried.iter();
    let decided = cores.cores.is_some() && tried.all(|(_, verdict)| *verdict != Verdict::Unknown);
    decided.then_some(cores)
}
