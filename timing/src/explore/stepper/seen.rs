//! The events of a run.

use crate::explore::rules::Work;
use crate::system::{ClientId, ServiceId, Ticks};

/// An event of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// An executor asks for the locks of a codel, which it often gets at the same moment.
    Asked {
        executor: usize,
        /// Work that it is about to begin.
        work: Work,
    },
    /// An executor begins work that takes time.
    Begun {
        executor: usize,
        work: Work,
        /// Least and greatest duration of the work, in base units.
        time: (Ticks, Ticks),
    },
    /// An executor ends its work.
    Ended {
        executor: usize,
        work: Work,
        /// Outcome, as in [`Action::Finish`](crate::explore::Action::Finish).
        outcome: usize,
    },
    /// A control task has taken a request.
    Requested {
        /// The client that sent it.
        client: ClientId,
        service: ServiceId,
    },
    /// A control task refuses a request: for lack of a slot, by `after` or `before`, or by a codel.
    Refused { service: ServiceId },
    /// A measured job ends.
    Job {
        task: usize,
        /// Response time, in base units.
        response: Ticks,
    },
    /// A tick comes before its previous job has ended.
    Missed { task: usize },
    /// A job waits for a core for at least the period of its task.
    Overdue { task: usize },
    /// A monitor of [`Watched::monitors`](super::Watched::monitors) has been exercised, as
    /// [`Monitor::is_exercised`](crate::property::Monitor::is_exercised) says.
    Opened {
        /// Index of the monitor.
        monitor: usize,
    },
    /// A monitor of [`Watched::monitors`](super::Watched::monitors) is violated, and begins again.
    Violated {
        /// Index of the monitor.
        monitor: usize,
    },
    /// A predicate of [`Watched::reach`](super::Watched::reach) has become true.
    Reached {
        /// Index of the predicate.
        predicate: usize,
    },
    /// The last predicate of an entry of [`Watched::within`](super::Watched::within) has followed the first.
    Answered {
        /// Index of the entry.
        within: usize,
        /// Time since the first predicate became true, in base units.
        after: Ticks,
    },
}

/// The times of a run that goes on: of a [`Stepper`](super::Stepper), or of a log.
pub trait RunState {
    /// Returns the time since the start, in base units.
    fn now(&self) -> u64;

    /// Returns the duration so far of a task's job, in base units, if the task has a measured job.
    fn job(&self, task: usize) -> Option<Ticks>;

    /// Returns the time, in base units, for which the responses of an entry of
    /// [`Watched::within`](super::Watched::within) have been awaited, if they are.
    fn awaited(&self, within: usize) -> Option<Ticks>;

    /// Returns true if a comparison of data has been set in this run.
    fn knows_fact(&self, fact: usize) -> bool;
}
