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
//! * `activities`, `course`: the work of each task, including requests at any time;
//! * `others`: codels outside the abstraction that take tickets at any time;
//! * `state`: abstract states, and when two of them are equal;
//! * `steps`: the two kinds of steps, granting a core and beginning a codel;
//! * `starting`: the consequences of the end of a job, and the start-up of tasks;
//! * `batch`: busy windows of independent jobs, taken in one step whatever their order;
//! * `search`: the construction of the graph, within a budget.
//!
//! The bounds are never below the exact values. `docs/explorer.md` explains what they bound and proves it.

mod activities;
mod batch;
mod course;
mod model;
mod others;
mod refusal;
mod search;
mod starting;
mod state;
mod steps;

use self::batch::Batches;
use self::model::models;
pub use self::refusal::Refusal;
use self::search::Search;
use crate::cancel::Cancel;
use crate::system::{Ticks, TimedSystem};

/// Upper limits on the number and size of abstract states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Number of states that are followed step by step, which gives tighter bounds. Beyond it, busy windows
    /// are taken in one step if possible.
    pub before_batches: usize,
    /// Number of states at which the system is refused.
    pub states: usize,
    /// Bytes of kept states at which the system is refused.
    pub bytes: usize,
}

/// Upper limit on states times tasks: each state keeps an interval for each task in memory.
const PLACES: usize = 2_000_000;

impl Default for Budget {
    fn default() -> Self {
        Budget {
            before_batches: 5_000,
            states: 250_000,
            bytes: usize::MAX,
        }
    }
}

/// Returns bounds on the response times of all tasks with a period. All of them meet their deadlines.
///
/// # Errors
///
/// Returns the first reason why the abstraction cannot treat the system, or why nothing follows from it.
pub fn abstract_bounds(
    system: &TimedSystem,
    budget: Budget,
    cancel: &Cancel,
) -> Result<Vec<Option<Ticks>>, Refusal> {
    let mut out = vec![None; system.tasks.len()];
    for model in models(system)? {
        let budget = Budget {
            states: budget.states.min(PLACES / model.threads.len().max(1)),
            ..budget
        };
        let search = |batches, states| {
            let budget = Budget { states, ..budget };
            Search::new(&model, batches, budget, cancel).run()
        };
        let found = match Batches::new(&model) {
            None => search(None, budget.states),
            batches => match search(None, budget.before_batches) {
                Err(Refusal::States { .. }) => search(batches, budget.states),
                it => it,
            },
        }?;
        for (thread, bound) in model.threads.iter().zip(found) {
            let bound = Ticks::try_from(bound).map_err(|_| Refusal::Hyperperiod)?;
            out[thread.task] = Some(bound);
        }
    }
    Ok(out)
}
