//! A single change that makes a failed check of a task hold: a shorter codel, or more cores.

use super::change::Change;
use super::suspects::suspects;
use super::trial::Trial;
use crate::explore::Limits;
use crate::report::{Awaited, CheckReport, Report, Verdict};
use crate::scn::ast::{CheckKind, Path, Scenario};
use crate::scn::names::Names;
use crate::verify::{Cancel, Options, SystemInput, settings};

/// Number of codels that are tried.
const MAX_CODELS_TRIED: usize = 3;

/// Limit on the states for each question: a multiple of the states of the verification, and a minimum.
const STATES: (usize, usize) = (4, 20_000);

/// Returns the limits for each question, given the effort of the verification in a report.
pub(super) fn limits(report: &Report, options: &Options) -> Limits {
    Limits {
        states: (report.states * STATES.0).max(STATES.1).min(options.limits.states),
        ..options.limits
    }
}

/// Finds a simple change with which all answered checks of a task hold, if one is found before `cancel` is
/// over. The task has a refuted check. First it tries shorter execution times of the codels that the job
/// executes or waits for, the longest first. If the job waits for a core, it then tries more cores.
pub fn remedy(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    (report, check): (&Report, &CheckReport),
    cancel: &Cancel,
) -> Option<Change> {
    if check.verdict != Verdict::Refuted {
        return None;
    }
    let names = Names::new(&input.specs);
    let mut settings = settings(scenario, options);
    check.id.task?;
    let task = Path::of(&check.of);
    // All checks of the task that have an answer, each narrowed to it.
    let mut written = 0;
    settings.checks.retain_mut(|asked| {
        let number = written;
        written += 1;
        let answered = |report: &CheckReport| {
            report.id.written == number
                && report.of == check.of
                && report.verdict != Verdict::Unknown
        };
        match &mut asked.kind {
            CheckKind::Schedulable(of) | CheckKind::NoOverdue(of) | CheckKind::Response(of, _) => {
                *of = Some(task.clone());
                report.checks.iter().any(answered)
            }
            _ => false,
        }
    });
    let trial = Trial::new(&names, settings, report, limits(report, options), cancel, None);
    let suspects = suspects(check).into_iter().take(MAX_CODELS_TRIED);
    let by_codel = { suspects }.find_map(|codel| trial.wcet(&codel));
    let waits = || check.reason.iter().any(|reason| reason.awaited == Awaited::Core);
    by_codel.or_else(|| waits().then(|| trial.cores()).flatten())
}
