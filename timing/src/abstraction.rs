//! The middle tier: schedule abstraction, which bounds response times between response-time analysis and the
//! exact exploration.
//!
//! It follows schedule-abstraction graphs (M. Nasri, B. Brandenburg, *An exact and sustainable analysis of
//! non-preemptive scheduling*, RTSS 2017; M. Nasri, G. Nelissen, B. Brandenburg, *Response-time analysis of
//! limited-preemptive parallel DAG tasks under global scheduling*, ECRTS 2019). An abstract state records the
//! work that is done: the jobs, and the progress of each. Intervals bound the times at which codels end and
//! cores become free. States with the same work done are merged, whatever the order of that work. The merged
//! intervals are the hulls of the intervals of the merged states.
//!
//! * `model`: the part of a system that the abstraction covers, and the reasons for a refusal;
//! * `activities`, `cycle_automaton`: the work of each task, including requests at any time;
//! * `others`: codels outside the abstraction that take tickets at any time;
//! * `order`: the start of each task, after the tasks declared before it;
//! * `state`: abstract states, and when two of them are equal;
//! * `steps`: the two kinds of steps, granting a core and beginning a codel;
//! * `starting`: the consequences of the end of a job, and the start-up of tasks;
//! * `batch`: busy windows of independent jobs, taken in one step whatever their order;
//! * `coarse`: a model with fewer states, in which tasks forget between jobs what they have done;
//! * `search`: the construction of the graph, within a budget.
//!
//! The bounds are never below the exact values. `docs/explorer.md` explains what they bound and proves it.

mod activities;
mod batch;
mod coarse;
mod cycle_automaton;
mod model;
mod order;
mod others;
mod refusal;
mod search;
mod span;
mod starting;
mod state;
mod steps;
mod thread;

use self::batch::Batches;
use self::model::{Model, models};
pub use self::refusal::Refusal;
use self::search::Search;
use crate::cancel::Cancel;
use crate::system::{TaskId, Ticks, TimedSystem};
use typed_index_collections::{TiVec, ti_vec};

/// Upper limits on the number and size of abstract states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Number of states that are followed step by step, which gives tighter bounds. Beyond it, busy windows
    /// are taken in one step if possible, or else a coarser model is tried, which has fewer states.
    pub before_coarse: usize,
    /// Busy windows may be taken in one step.
    pub batches: bool,
    /// Number of states at which a model is refused.
    pub states: usize,
    /// Bytes of kept states at which the system is refused.
    pub bytes: usize,
}

/// Upper limit on states times tasks: each state keeps an interval for each task in memory.
const MAX_INTERVALS: usize = 2_000_000;

impl Default for Budget {
    fn default() -> Self {
        Budget { before_coarse: 5_000, batches: true, states: 250_000, bytes: usize::MAX }
    }
}

/// Returns, by task, a bound on its response time, or the reason why none is known. A task whose bound is
/// below its period meets its deadlines.
pub fn abstract_bounds(
    system: &TimedSystem,
    budget: Budget,
    cancel: &Cancel,
) -> TiVec<TaskId, Result<Ticks, Refusal>> {
    // Tasks that are not followed: they execute any of their codels at any time.
    let mut left: TiVec<TaskId, Option<Refusal>> = ti_vec![None; system.tasks.len()];
    loop {
        let parts = match models(system, &mut left) {
            Ok(parts) => parts,
            Err(refusal) => return ti_vec![Err(refusal); left.len()],
        };
        let mut out: TiVec<TaskId, Result<Ticks, Refusal>> =
            left.iter().map(|refusal| Err(refusal.unwrap_or(Refusal::Cancelled))).collect();
        let mut leaves = false;
        for (tasks, model) in parts {
            let servers = model.as_ref().is_ok_and(|model| model.queue);
            match model.and_then(|model| bounds(&model, budget, cancel)) {
                Ok(found) => tasks.iter().zip(found).for_each(|(&task, result)| out[task] = result),
                Err(refusal) => {
                    for &task in &tasks {
                        out[task] = Err(refusal);
                    }
                    if let Some(task) =
                        refusal.task().filter(|&task| servers && left[task].is_none())
                    {
                        left[task] = Some(refusal);
                        leaves = true;
                    }
                }
            }
        }
        if !leaves {
            return out;
        }
    }
}

/// Returns the bounds of the tasks of a part of a system.
fn bounds(
    model: &Model,
    budget: Budget,
    cancel: &Cancel,
) -> Result<Vec<Result<Ticks, Refusal>>, Refusal> {
    let budget =
        Budget { states: budget.states.min(MAX_INTERVALS / model.threads.len().max(1)), ..budget };
    let mut search = Search::new(model, None, budget.bytes, cancel);
    let mut found = search.run(budget.before_coarse, false);
    if let Err(Refusal::States { .. }) = found {
        let batches = Batches::new(model).filter(|_| budget.batches);
        if batches.is_some() {
            search = Search::new(model, batches, budget.bytes, cancel);
            found = search.run(budget.states, false);
        }
    }
    if let Err(Refusal::States { .. } | Refusal::MayMiss { .. }) = found {
        let coarse = model.coarse();
        let coarser = Search::new(&coarse, None, budget.bytes, cancel).run(budget.states, true);
        found = match (coarser, found) {
            (Ok(bounds), _) if meets_all(model, &bounds) => Ok(bounds),
            (coarser, Err(miss @ Refusal::MayMiss { .. })) => coarser.or(Err(miss)),
            (coarser, _) => tighter(coarser, search.run(budget.states, false)),
        };
    }
    let bound = |bound: i64| Ticks::try_from(bound).map_err(|_| Refusal::Hyperperiod);
    Ok(found?.into_iter().map(bound).collect())
}

/// Returns true if each bound is below the period of its task.
fn meets_all(model: &Model, bounds: &[i64]) -> bool {
    let mut all = model.threads.iter().zip(bounds);
    all.all(|(thread, &bound)| bound < thread.period)
}

/// Returns the lower one of the bounds of two models for each thread, or the bounds of the only one that has
/// any.
fn tighter(
    coarse: Result<Vec<i64>, Refusal>,
    fine: Result<Vec<i64>, Refusal>,
) -> Result<Vec<i64>, Refusal> {
    match (coarse, fine) {
        (Ok(coarse), Ok(fine)) => {
            Ok(coarse.into_iter().zip(fine).map(|(one, other)| one.min(other)).collect())
        }
        (coarse, fine) => fine.or_else(|refusal| coarse.map_err(|_| refusal)),
    }
}
