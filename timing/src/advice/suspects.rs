//! The causes of a late job, from the run that shows it.

use crate::explore::MomentKind;
use crate::report::{CheckReport, Delay, Event};
use crate::system::{CodelName, ThreadName};

/// Returns codels whose execution times delay the job at the end of a run, the longest first.
pub(super) fn suspects(check: &CheckReport) -> Vec<CodelName> {
    let length = |delay: &Delay| delay.until - delay.from;
    let longest = check.reason.iter();
    let longest = longest.max_by(|a, b| length(a).total_cmp(&length(b)));
    let mut all: Vec<(f64, CodelName)> = Vec::new();
    if let Some(delay) = longest {
        for holder in &delay.held {
            match &holder.codel {
                Some(codel) => all.push((holder.until - holder.from, codel.clone())),
                None => {
                    all.extend(executed(check.run(), &holder.by, holder.from, holder.until));
                }
            }
        }
    } else {
        let Some(task) = &check.task else {
            return Vec::new();
        };
        let begins = |event: &&Event| event.kind == MomentKind::Release && event.thread == *task;
        let job = check.run().iter().rev().find(begins).map_or(0.0, |run| run.time);
        all.extend(executed(check.run(), task, job, f64::INFINITY));
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    distinct(all.into_iter().map(|(_, suspect)| suspect))
}

/// Returns pairs of codels, of which the first waited for a lock held by the second.
pub(super) fn waited_for(check: &CheckReport) -> Vec<(CodelName, CodelName)> {
    let pairs = check.reason.iter().flat_map(|reason| {
        let held = reason.held.iter().filter_map(|held| held.codel.as_ref());
        held.filter_map(|held| Some((reason.codel.clone()?, held.clone())))
    });
    distinct(pairs)
}

/// Returns the tasks most concerned by a run: the late one, then those that kept it waiting.
pub(super) fn tasks(check: &CheckReport) -> Vec<ThreadName> {
    let own = check.task.clone();
    let held = check.reason.iter().flat_map(|reason| &reason.held);
    distinct(own.into_iter().chain(held.map(|reason| reason.by.clone())))
}

/// Removes duplicates, and keeps the first of equal values.
pub(super) fn distinct<T: PartialEq>(all: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut out = Vec::new();
    for suspect in all {
        if !out.contains(&suspect) {
            out.push(suspect);
        }
    }
    out
}

/// Returns the codels that a thread executes between two times of a run, with their execution times.
fn executed(run: &[Event], by: &ThreadName, from: f64, until: f64) -> Vec<(f64, CodelName)> {
    let mut begun: Vec<(f64, &CodelName)> = Vec::new();
    let mut out = Vec::new();
    let end = run.last().map_or(0.0, |run| run.time).min(until);
    for run in run.iter().filter(|run| run.thread == *by) {
        let Some(codel) = run.codel.as_ref().filter(|_| run.time <= until) else {
            continue;
        };
        match run.kind {
            MomentKind::Begin => begun.push((run.time, codel)),
            MomentKind::End => {
                if let Some(at) = begun.iter().position(|begun| begun.1 == codel) {
                    let (since, _) = begun.remove(at);
                    if run.time > from {
                        out.push((run.time - since, codel.clone()));
                    }
                }
            }
            _ => {}
        }
    }
    out.extend(begun.into_iter().map(|(since, codel)| (end - since, codel.clone())));
    out
}
