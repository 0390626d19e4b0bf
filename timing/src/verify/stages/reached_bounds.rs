//! Walks to response times as long as their bounds, which are then exact, and to jobs of tasks that meet
//! their deadlines if they have any.

use crate::explore::{Findings, Kind, Limits, ResponseTime, Stop, Walked, Watch, explore, walk};
use crate::report::Report;
use crate::system::{TaskId, Ticks};
use crate::verify::group::Group;
use crate::verify::part::Part;

/// Limit on the actions.
const ACTIONS: u64 = 3_000_000;

/// Number of actions of a small system.
const SMALL: u64 = 20_000;

pub(super) fn answer(part: &mut Part, report: &mut Report) {
    let Part { group, checks, analysed, .. } = part;
    if group.limits.without.contains(Kind::RandomSearch) {
        return;
    }
    let open: Vec<usize> = part.of_group.iter().copied().filter(|&i| report.is_open(i)).collect();
    let settled = open.iter().copied().filter(|&i| group.is_settled(&checks[i], analysed));
    let (mut watch, places) = group.watch(checks, settled, analysed);
    let on_condition = open.iter().filter_map(|&i| {
        let bound = analysed.deadline_on_condition(&checks[i])?;
        Some((i, bound, group.built.tasks[&checks[i].what.task()?]))
    });
    let on_condition: Vec<(usize, Ticks, TaskId)> = on_condition.collect();
    let job = |&(.., task): &(usize, Ticks, TaskId)| ResponseTime {
        task,
        limit: None,
        // Any job is long enough.
        most: Some(0),
    };
    watch.response.extend(on_condition.iter().map(job));
    if watch.response.is_empty() || group.is_small(&watch) {
        return;
    }
    let Walked { response, .. } = walk(&group.built.system, &watch, ACTIONS, group.cancel);
    let found = Findings { response, stopped: Some(Stop::Answered), ..Findings::default() };
    let jobs = &found.response[found.response.len() - on_condition.len()..];
    for (&(i, bound, _), job) in on_condition.iter().zip(jobs) {
        if job.is_some() {
            report.answer(i, group.meets_deadlines(&checks[i], bound, analysed));
        }
    }
    for (i, place) in places {
        let mut entry = group.one(&checks[i], place, &found);
        let bound = analysed.response(&checks[i]).map(|bound| group.time(bound));
        if entry.value.is_some() && entry.value == bound {
            group.bound_unknown(&checks[i], analysed, &mut entry);
            report.answer(i, entry);
        } else {
            part.seen.note(i, entry);
        }
    }
}

impl Group<'_> {
    /// Returns true if an exploration soon comes to its end.
    fn is_small(&self, watch: &Watch) -> bool {
        let limits = Limits { steps: self.limits.steps.min(SMALL), ..self.limits };
        let explored = explore(&self.built.system, watch, limits, self.cancel);
        matches!(explored.stopped, None | Some(Stop::Answered))
    }
}
