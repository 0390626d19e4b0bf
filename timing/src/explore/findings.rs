//! The findings of an exploration.

use super::never_observed::NeverObserved;
use super::reductions::Activity;
use super::run::Run;
use super::spans::ChainSpans;
use super::watch::Stop;
use crate::system::{ServiceId, TaskId, Ticks};

/// A supremum of a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Bound {
    /// Reached, and never exceeded, in base units.
    Finite(Ticks),
    /// There is no supremum.
    Unbounded,
}

/// A time that was measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measured {
    /// Supremum.
    pub bound: Bound,
    /// Run that reaches the supremum, or shows that there is none.
    pub longest: Run,
    /// Run that exceeds the limit, and ends as soon as the limit is exceeded. If the time has a bound, no run
    /// exceeds the limit earlier.
    pub excess: Option<Run>,
}

/// The findings of an exploration. Lists correspond to those of the [`Watch`](super::watch::Watch).
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// Runs in which a tick came before its job had ended.
    pub missed: Vec<Option<Run>>,
    /// Runs in which a task waited for a core for its whole period.
    pub overdue: Vec<Option<Run>>,
    /// Response times; `None` if the task was never released.
    pub response: Vec<Option<Measured>>,
    /// Runs that reach the predicates.
    pub reached: Vec<Option<Run>>,
    /// Least bounds; `None` if the first predicate never became true.
    pub within: Vec<Option<Measured>>,
    /// Jobs and atoms that no examined state has.
    pub absent: NeverObserved,
    /// Run to a deadlock.
    pub deadlock: Option<Run>,
    /// Services with a request that was refused because no slot was free.
    pub refused: Vec<ServiceId>,
    /// Services that interrupt themselves, if two waiting instances interrupted each other.
    pub restarts: Vec<ServiceId>,
    /// What delays the datum of a chain.
    pub chain: ChainSpans,
    /// Tasks that hold all cores for ever. States after that were not followed, because no question is about
    /// them: requests may be refused there.
    pub hold_cores: Vec<TaskId>,
    /// Reductions used in each exploration.
    pub reductions: Vec<Vec<Activity>>,
    /// Number of states kept.
    pub states: usize,
    /// Number of actions followed.
    pub steps: u64,
    /// Bytes taken by states.
    pub bytes: usize,
    /// Reason for an incomplete exploration. Then findings may be missing, and bounds are lower bounds.
    pub stopped: Option<Stop>,
}

impl Findings {
    /// Adds the effort of another exploration for the same watch.
    pub(super) fn absorb(&mut self, other: &Findings) {
        self.states += other.states;
        let new = other.hold_cores.iter().filter(|task| !self.hold_cores.contains(task));
        let new: Vec<TaskId> = new.copied().collect();
        self.hold_cores.extend(new);
        self.reductions.extend(other.reductions.iter().cloned());
        self.steps += other.steps;
        self.bytes = self.bytes.max(other.bytes);
        // A complete answer of one exploration says nothing about the next exploration.
        let given_up = |stop: Option<Stop>| stop.filter(|&stop| stop != Stop::Answered);
        self.stopped = given_up(self.stopped).or(given_up(other.stopped)).or(self.stopped);
    }
}
