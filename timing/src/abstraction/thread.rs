//! Tasks that the abstraction follows.

use super::cycle_automaton::CycleAutomaton;
use super::others::Interference;
use super::span::Span;
use crate::system::TaskId;

/// The start of a followed task.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// Time of the start, from the end of the first pass of the followed task before it, or from 0 if there
    /// is none; `None`: at any time, or never.
    pub(super) after: Option<Span>,
    /// A task before it may fail in its first pass, after which no further task is started.
    pub(super) fails: bool,
}

impl Start {
    pub(super) const AT_ONCE: Start = Start { after: Some(Span { from: 0, to: 0 }), fails: false };

    /// Returns the start after this one and another first pass.
    pub(super) fn then(self, pass: Start) -> Self {
        Start {
            after: self.after.and_then(|span| pass.after.map(|pass| span.plus(pass))),
            fails: self.fails || pass.fails,
        }
    }
}

/// A task.
#[derive(Debug, Clone)]
pub(super) struct Thread {
    /// Number of the task in the system.
    pub(super) task: TaskId,
    pub(super) period: i64,
    /// First tick, in base units.
    pub(super) first: i64,
    /// Sequences of codels; `None` if there are none.
    pub(super) cycle_automaton: Option<CycleAutomaton>,
    pub(super) group: usize,
    /// The task shares locks with others of its group.
    pub(super) contends: bool,
    /// Possible rests before the first tick. Servers: none, as the task begins with the first rest.
    pub(super) paused: Vec<usize>,
    /// Servers: task that is started after the first pass of this one.
    pub(super) next_task: Option<TaskId>,
    /// The thread of that task in the model.
    pub(super) successor: Option<usize>,
    /// Servers: another thread starts this one.
    pub(super) started: bool,
    pub(super) start: Start,
    /// Servers: interference with the first pass.
    pub(super) early: Option<Interference>,
}

impl Thread {
    /// Returns the time of one of the thread's ticks, in base units.
    pub(super) fn tick(&self, number: i64) -> i64 {
        self.first + number * self.period
    }

    /// Returns the number of the last tick before time 0.
    pub(super) fn last_before_zero(&self) -> i64 {
        (-1 - self.first).div_euclid(self.period)
    }
}
