//! Explorations with few requests, and in few states.
//!
//! Clients that may send anything at any time make most systems too large to be explored to the end. But what
//! fails usually fails after no request, one or two, and small systems are explored at once. So both are
//! tried before the whole system is explored for what is left.

use std::sync::OnceLock;

use crate::explore::{Limits, Stop, explore};
use crate::report::{Report, Value, Verdict};
use crate::system::indexed::Built;
use crate::verify::bounds::ResponseBounds;
use crate::verify::group::Group;
use crate::verify::part::Part;

/// For each exploration: the number of times that a client which may wait for ever continues (`None`: no
/// limit), and the limit on states.
const ROUNDS: [(Option<usize>, usize); 4] =
    [(Some(0), 100_000), (None, 20_000), (Some(1), 100_000), (Some(2), 100_000)];

/// An exploration with requests takes at most this part of the states that the whole may have.
const SHARE: usize = 4;

/// Answers what can be answered soon. What is alone and has no clients that may wait is explored anyway.
pub(super) fn answer(part: &mut Part, report: &mut Report) {
    for (rounds, states) in ROUNDS {
        let share = if rounds == Some(0) { 1 } else { SHARE };
        let staying = staying(part.group.built, rounds.unwrap_or(0));
        let built = match (rounds, &staying) {
            (None, None) if part.alone => break,
            (None, _) => part.group.built,
            (Some(_), None) => continue,
            (Some(_), Some(built)) => built,
        };
        let limits = part.group.limits;
        let limits = Limits { states: (limits.states / share).min(states), ..limits };
        let group = Group { built, limits, ..part.group };
        let (ticks, others): (Vec<_>, Vec<_>) = (part.open(report).into_iter())
            .filter(|(_, check)| check.is_of_task())
            .partition(|(_, check)| group.is_about_ticks(check));
        for some in [ticks, others] {
            let some: Vec<usize> = some.into_iter().map(|(i, _)| i).collect();
            explore_some(group, part, some, rounds.is_none(), report);
        }
    }
}

/// Returns the system whose clients wait for ever after some requests, if they may wait.
pub(super) fn staying(built: &Built, rounds: usize) -> Option<Built> {
    let system = built.system.waiting_forever_after(rounds)?;
    Some(Built { system, shared: OnceLock::new(), ..built.clone() })
}

fn explore_some(group: Group, part: &mut Part, some: Vec<usize>, whole: bool, report: &mut Report) {
    let checks = part.checks;
    let analysed = ResponseBounds::new(group.built, group.cancel);
    let (mut watch, places) = group.watch(checks, some.into_iter(), &analysed);
    // What fails later is left to later explorations.
    watch.in_order = true;
    if places.is_empty() {
        return;
    }
    let found = explore(&group.built.system, &watch, group.limits, group.cancel);
    report.effort(&found);
    let complete = whole && matches!(found.stopped, None | Some(Stop::Answered));
    if complete {
        part.refusals(&found, report);
    }
    for (i, place) in places {
        let mut entry = group.one(&checks[i], place, &found);
        if complete {
            group.bound_unknown(&checks[i], &analysed, &mut entry);
            group.bound_between_units(&checks[i], &analysed, &mut entry);
        }
        // With more requests some other run may take longer, unless this one takes for ever.
        let final_value = matches!(entry.value, None | Some(Value::Unbounded));
        if complete || (entry.verdict == Verdict::Refuted && final_value) {
            report.answer(i, entry);
        } else if found.stopped != Some(Stop::Cancelled) {
            part.seen.note(i, entry);
        }
    }
    (group.tell)(report);
}
