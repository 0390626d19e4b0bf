//! What an exploration found.

use super::absent::Absent;
use super::reductions::Activity;
use super::run::Run;
use super::watch::Stop;
use crate::system::Ticks;

/// A supremum of a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Bound {
    /// Reached, and never exceeded.
    Finite(Ticks),
    /// There is none.
    Unbounded,
}

/// Something found, with a run that shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// From time 0 to the state in question.
    pub run: Run,
}

/// A time that was measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measured {
    /// Its supremum.
    pub bound: Bound,
    /// A run that reaches it, or shows that there is none.
    pub longest: Found,
    /// The limit is exceeded: by this run, which ends when that has happened. If the time has a bound, no
    /// run exceeds the limit earlier.
    pub excess: Option<Found>,
}

/// What an exploration found. Lists follow those of the [`Watch`](super::watch::Watch).
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// Runs in which a tick came too early.
    pub missed: Vec<Option<Found>>,
    /// Runs in which a task waited too long.
    pub overdue: Vec<Option<Found>>,
    /// Response times; `None` if the task was never released.
    pub response: Vec<Option<Measured>>,
    /// Runs to the predicates.
    pub reached: Vec<Option<Found>>,
    /// Least bounds; `None` if the first predicate never became true.
    pub within: Vec<Option<Measured>>,
    /// Whether each predicate is known to be never reached, even if the exploration was stopped.
    pub never: Vec<bool>,
    /// What no state has that was looked at.
    pub absent: Absent,
    /// A run to a deadlock.
    pub deadlock: Option<Found>,
    /// It is known that there is no deadlock, even if the exploration was stopped.
    pub no_deadlock: bool,
    /// Services of which a request was refused because no slot was free.
    pub refused: Vec<usize>,
    /// Services that interrupt themselves, of which two waiting instances interrupted each other.
    pub restarts: Vec<usize>,
    /// Which reductions were used, of each exploration.
    pub reductions: Vec<Vec<Activity>>,
    /// States kept.
    pub states: usize,
    /// Steps taken.
    pub steps: u64,
    /// Bytes used for states.
    pub bytes: usize,
    /// Set when the exploration is not complete: what was not found may still exist, and bounds are
    /// lower bounds.
    pub stopped: Option<Stop>,
}

impl Findings {
    /// Adds the effort of another exploration for the same watch.
    pub(super) fn absorb(&mut self, other: &Findings) {
        self.states += other.states;
        self.reductions.extend(other.reductions.iter().cloned());
        self.steps += other.steps;
        self.bytes = self.bytes.max(other.bytes);
        // What one exploration has answered says nothing about the next.
        let given_up = |it: Option<Stop>| it.filter(|&it| it != Stop::Answered);
        self.stopped = given_up(self.stopped)
            .or(given_up(other.stopped))
            .or(self.stopped);
    }
}
