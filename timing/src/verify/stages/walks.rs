//! Walks to missed deadlines: single runs that prefer what makes a job long. They refute, and prove nothing.

use super::few_requests::staying;
use crate::explore::{Findings, Kind, Limits, Stop, bytes_of_walks, explore, walk};
use crate::report::{Report, Verdict};
use crate::verify::checks::What;
use crate::verify::group::Group;
use crate::verify::part::Part;

/// Limit on the actions before schedule abstraction, which may take long to find that it cannot tell.
const EARLY_ACTIONS: u64 = 200_000;

/// Limit on the actions after the stages with few requests.
const LATE_ACTIONS: u64 = 3_000_000;

/// Number of actions of the exploration that comes before walks. It finds the shortest runs, if they are
/// short.
const FIRST: u64 = 50_000;

/// Looks for missed deadlines without requests, if clients may wait for ever.
pub(super) fn early(part: &mut Part, report: &mut Report) {
    let staying = staying(part.group.built, 0);
    let group = Group { built: staying.as_ref().unwrap_or(part.group.built), ..part.group };
    to_misses(group, part, EARLY_ACTIONS, report);
}

/// Looks for missed deadlines that come late.
pub(super) fn late(part: &mut Part, report: &mut Report) {
    to_misses(part.group, part, LATE_ACTIONS, report);
}

fn to_misses(group: Group, part: &Part, actions: u64, report: &mut Report) {
    let deadlines = part.open(report).into_iter();
    let deadlines = deadlines.filter(|(_, check)| matches!(check.what, What::Schedulable(_)));
    let (mut watch, places) = group.watch(part.checks, deadlines.map(|(i, _)| i), &part.analysed);
    if places.is_empty() || group.limits.without.contains(Kind::RandomSearch) {
        return;
    }
    let system = &group.built.system;
    let limits = Limits { steps: group.limits.steps.min(FIRST).min(actions / 4), ..group.limits };
    let explored = explore(system, &watch, limits, group.cancel);
    if matches!(explored.stopped, None | Some(Stop::Answered)) {
        return;
    }
    // The longest job and the first missed deadline of each task.
    let bytes = bytes_of_walks(2 * places.len());
    if explored.bytes + bytes > group.limits.bytes {
        return;
    }
    watch.response.clear();
    // An action takes less time than a state that is kept.
    let actions = actions.min((group.limits.states as u64).saturating_mul(8));
    let walked = walk(system, &watch, actions, group.cancel);
    let runs = explored.missed.into_iter().zip(walked.missed);
    let found = Findings {
        missed: runs.map(|(shortest, walked)| shortest.or(walked)).collect(),
        states: explored.states + walked.actions as usize,
        stopped: Some(Stop::States),
        ..Findings::default()
    };
    report.effort(&found);
    for (i, place) in places {
        let entry = group.one(&part.checks[i], place, &found);
        if entry.verdict == Verdict::Refuted {
            report.answer(i, entry);
        }
    }
}
