//! The stages of a verification, the cheapest first. Each gets a [`Part`] with its open checks and what is
//! known so far, and answers the checks that it can: proved, refuted with a run, or a bound. Later stages see
//! only what is left. `docs/explorer.md` has a section for each.

mod analysis;
mod exploration;
mod few_requests;
mod invariants;
mod reached_bounds;
mod rounded;
mod schedule_abstraction;
mod walks;

use super::part::Part;
use crate::report::Report;

type Stage = fn(&mut Part, &mut Report);

/// All stages, in their order.
const ALL: [Stage; 9] = [
    analysis::answer,
    walks::early,
    schedule_abstraction::answer,
    invariants::answer,
    reached_bounds::answer,
    few_requests::answer,
    walks::late,
    rounded::answer,
    exploration::answer,
];

/// The stages for rounded times, whose answers are few and are confirmed.
const ROUNDED: [Stage; 3] = [analysis::answer, schedule_abstraction::answer, exploration::answer];

/// Answers the checks of all parts. The cheap stages of all parts come first, so that no part waits for the
/// exploration of another one.
pub(super) fn answer(parts: &mut [Part], report: &mut Report) {
    by(&ALL, parts, report);
}

fn by(stages: &[Stage], parts: &mut [Part], report: &mut Report) {
    for stage in stages {
        for part in &mut *parts {
            if part.is_done(report) {
                continue;
            }
            stage(part, report);
        }
        if let Some(part) = parts.first() {
            (part.group.tell)(report);
        }
    }
}
