//! What is to be found out in an exploration.

use super::reductions::Kinds;
use crate::cancel::Cancel;
use crate::property::Predicate;
use crate::system::Ticks;

/// What is to be found out in one exploration.
#[derive(Debug, Clone, Default)]
pub struct Watch {
    /// Tasks whose ticks must not come before their jobs have ended.
    pub schedulable: Vec<usize>,
    /// Tasks that must not wait for a core as long as their period.
    pub overdue: Vec<usize>,
    /// Response times that are wanted.
    pub response: Vec<ResponseTime>,
    /// Predicates to be reached.
    pub reach: Vec<Predicate>,
    /// Pairs of predicates whose least bound is wanted.
    pub within: Vec<Within>,
    /// Look for states in which nothing will ever happen again.
    pub deadlock: bool,
    /// Stop as soon as a tick came too early.
    pub stop_at_first: bool,
    /// Look at everything in order of time, as only what happens early is of interest.
    pub in_order: bool,
}

/// The response time of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResponseTime {
    /// The task.
    pub task: usize,
    /// If the time exceeds this, the shortest run that does so is wanted.
    pub limit: Option<Ticks>,
    /// No job takes longer, as is known from analysis: one that takes as long ends the search for this time.
    pub most: Option<Ticks>,
}

/// The time that passes until others follow one predicate.
#[derive(Debug, Clone)]
pub struct Within {
    /// Whenever this becomes true,
    pub trigger: Predicate,
    /// these are awaited, one after the other; at least one.
    pub responses: Vec<Predicate>,
    /// If the time exceeds this, the shortest run that does so is wanted.
    pub limit: Option<Ticks>,
}

/// Bounds on the effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Greatest number of states kept.
    pub states: usize,
    /// Greatest number of bytes for them.
    pub bytes: usize,
    /// Greatest number of actions followed in one exploration.
    pub steps: u64,
    /// Greatest number of explorations at the same time, where there are several. What is found does not
    /// depend on it.
    pub threads: usize,
    /// Reductions that are switched off, to see what they bring. What is found does not depend on it.
    pub without: Kinds,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            states: 20_000_000,
            bytes: 4 << 30,
            steps: u64::MAX,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            without: Kinds::NONE,
        }
    }
}

/// Why an exploration did not finish.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stop {
    /// Too many states.
    States,
    /// Too much memory.
    Memory,
    /// Time is up.
    Time,
    /// Whoever waits has waited long enough.
    Interrupted,
    /// Nobody wants to know any more.
    Cancelled,
    /// Everything that was asked has been found, or with [`Watch::stop_at_first`] the first of it.
    Answered,
}

impl Stop {
    /// What ends an exploration of this size, if anything.
    pub(super) fn reason(
        states: usize,
        bytes: usize,
        limits: Limits,
        cancel: &Cancel,
    ) -> Option<Stop> {
        cancel.at_work(states, bytes);
        if cancel.is_over() {
            Some(match (cancel.is_abandoned(), cancel.is_interrupted()) {
                (true, _) => Stop::Cancelled,
                (false, true) => Stop::Interrupted,
                (false, false) => Stop::Time,
            })
        } else if states > limits.states {
            Some(Stop::States)
        } else if bytes > limits.bytes {
            Some(Stop::Memory)
        } else {
            None
        }
    }
}
