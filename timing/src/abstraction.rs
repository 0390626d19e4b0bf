//! The middle tier: bounds on response times from a graph of abstract states, between response-time analysis
//! and the exact search.
//!
//! It is an abstraction in the manner of schedule-abstraction graphs (M. Nasri, B. Brandenburg, *An exact and
//! sustainable analysis of non-preemptive scheduling*, RTSS 2017; M. Nasri, G. Nelissen, B. Brandenburg,
//! *Response-time analysis of limited-preemptive parallel DAG tasks under global scheduling*, ECRTS 2019). A
//! state says what has been done: which jobs, and how far each has come. When it was done is known as
//! intervals: of the ends of codels, of the moments at which cores are free. States in which the same has
//! been done are one, in whatever order it was done; its intervals are the hulls of theirs.
//!
//! * `model`: what of a system is looked at, and what is refused;
//! * `activities`, `course`: what a task executes, requests at any time included;
//! * `others`: who takes tickets beside, at any time;
//! * `state`: a state, and when two are the same;
//! * `steps`: the two kinds of steps, a core that is given and a codel that begins;
//! * `starting`: what follows the end of a job, and how tasks are started;
//! * `batch`: busy windows of independent jobs that are taken in one step, whatever their order;
//! * `search`: the graph, within a budget.
//!
//! The bounds are never below the exact values. What they are about, and why that is so: `docs/explorer.md`.

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

/// How many abstract states are looked at, at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Steps one by one give the tighter bounds. Where busy windows can be taken as a whole instead, this is
    /// when they are.
    pub before_batches: usize,
    /// Then the system is refused.
    pub states: usize,
    /// The system is also refused when the states that are kept take so many bytes.
    pub bytes: usize,
}

/// States, times the tasks that each has an interval for, at most: they have to be kept in memory.
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

/// Bounds on the response times of all tasks with a period, all of which meet their deadlines; or why there
/// are none.
///
/// # Errors
///
/// The first reason why the system cannot be treated, or why nothing follows.
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
