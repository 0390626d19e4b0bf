//! The questions of an exploration.

use super::reductions::Kinds;
use crate::cancel::Cancel;
use crate::property::{Monitor, Predicate};
use crate::system::{TaskId, Ticks};

/// The questions of one exploration.
#[derive(Debug, Clone, Default)]
pub struct Watch {
    /// Tasks whose ticks must not come before their jobs have ended.
    pub schedulable: Vec<TaskId>,
    /// Tasks that must not wait for a core for their whole period.
    pub overdue: Vec<TaskId>,
    /// Response times to measure.
    pub response: Vec<ResponseTime>,
    pub reach: Vec<Predicate>,
    /// Predicates whose least bound must be found.
    pub within: Vec<Within>,
    /// Monitors, which predicates of `reach` name.
    pub monitors: Vec<Monitor>,
    /// Search for deadlocks.
    pub deadlock: bool,
    /// Stop at the first missed deadline.
    pub stop_at_first: bool,
    /// Explore in order of time only, because only early events are of interest.
    pub in_order: bool,
}

impl Watch {
    /// Returns the predicates whose time is measured, each with its responses.
    pub(super) fn predicates_within(&self) -> impl Iterator<Item = (&Predicate, &[Predicate])> {
        self.within.iter().map(|within| (&within.trigger, &*within.responses))
    }
}

/// The response time of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResponseTime {
    pub task: TaskId,
    /// Limit in base units. If the time exceeds the limit, the shortest such run is searched for.
    pub limit: Option<Ticks>,
    /// Upper bound from analysis, in base units. A job that takes as long ends the search for this time.
    pub most: Option<Ticks>,
}

/// The time between a predicate and its responses.
#[derive(Debug, Clone)]
pub struct Within {
    /// Predicate that starts the measurement.
    pub trigger: Predicate,
    /// Predicates that are awaited in order; at least one.
    pub responses: Vec<Predicate>,
    /// Limit in base units. If the time exceeds the limit, the shortest such run is searched for.
    pub limit: Option<Ticks>,
}

/// Limits on the effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Greatest number of states kept.
    pub states: usize,
    /// Greatest number of bytes for them.
    pub bytes: usize,
    /// Greatest number of actions followed in one exploration.
    pub steps: u64,
    /// Greatest number of concurrent explorations, if there are several. The findings do not depend on it.
    pub threads: usize,
    /// Reductions that are switched off, to measure their effect. The findings do not depend on it.
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

/// The reason for an incomplete exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stop {
    /// Too many states.
    States,
    /// Too much memory.
    Memory,
    /// The time limit is reached.
    Time,
    /// The user has interrupted the verification.
    Interrupted,
    /// The result is no longer needed.
    Cancelled,
    /// All questions are answered, or with [`Watch::stop_at_first`] the first one.
    Answered,
}

impl Stop {
    /// Returns the limit that ends an exploration of this size, if one does.
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
