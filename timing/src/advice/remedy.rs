//! What would make a check of a task hold that fails: a shorter codel, or more cores.

use std::time::{Duration, Instant};

use super::blame::suspects;
use super::change::Change;
use super::trial::Trial;
use crate::explore::Limits;
use crate::report::{Awaited, CheckReport, Report, Verdict};
use crate::scn::ast::{CheckKind, Path, Scenario};
use crate::scn::names::Names;
use crate::verify::{Cancel, Options, SystemInput, settings};

/// Verifications that take longer together are not worth a hint.
const PATIENCE: Duration = Duration::from_secs(2);

/// Codels that are tried.
const SUSPECTS: usize = 3;

/// So many times the states of the verification may be looked at for each question, and so many in any case.
const STATES: (usize, usize) = (4, 20_000);

/// What each question may take, where a verification took what a report says.
pub(super) fn limits(report: &Report, options: &Options) -> Limits {
    Limits {
        states: (report.states * STATES.0)
            .max(STATES.1)
            .min(options.limits.states),
        ..options.limits
    }
}

/// What makes a refuted check of a task hold, if something plain does and is found soon: of the codels that
/// its job waits for, or is made of, the longest first, how short one has to be; else, where it waits for a
/// core, how many are needed.
pub fn remedy(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    (report, check): (&Report, &CheckReport),
    cancel: &Cancel,
) -> Option<Change> {
    if check.verdict != Verdict::Refuted || check.rounded {
        return None;
    }
    let names = Names::new(&input.specs);
    let mut settings = settings(scenario, options);
    let mut asked = settings.checks.get(check.id.written)?.clone();
    let task = Path::of(&check.of);
    check.id.task?;
    match &mut asked.kind {
        CheckKind::Schedulable(of) | CheckKind::NoOverdue(of) | CheckKind::Response(of, _) => {
            *of = Some(task)
        }
        _ => return None,
    }
    settings.checks = vec![asked];
    let end = Some(Instant::now() + PATIENCE);
    let trial = Trial::new(&names, settings, limits(report, options), cancel, end);
    let suspects = suspects(check).into_iter().take(SUSPECTS);
    let by_codel = { suspects }.find_map(|codel| trial.wcet(&codel));
    let waits = || check.reason.iter().any(|it| it.awaited == Awaited::Core);
    by_codel.or_else(|| trial.cores().filter(|_| waits()))
}
