//! The work of executors.

use crate::system::{AutomatonId, ClientId, CodelId, ServiceId, Ticks};

/// The work of an executor. Numbers index into the tables of the [`TimedSystem`](crate::system::TimedSystem).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// A codel of a state machine.
    State {
        codel: CodelId,
        /// The task that executes it.
        task: usize,
        /// The automaton: the permanent activity, or an activity.
        automaton: AutomatonId,
        /// The state of its machine.
        state: usize,
        /// Place of the activity, which it keeps to its end.
        slot: usize,
    },
    /// A codel of a control task.
    Control {
        codel: CodelId,
        /// The service that is handled.
        service: ServiceId,
        /// Number of the codel: the validation, if there is one, then the others in order.
        number: usize,
    },
    /// A delay of a client.
    Delay { client: ClientId },
}

impl Work {
    /// Returns the codel; `None` for a delay.
    pub fn codel(&self) -> Option<CodelId> {
        match *self {
            Work::State { codel, .. } | Work::Control { codel, .. } => Some(codel),
            Work::Delay { .. } => None,
        }
    }
}

/// The only work of a periodic task in its next cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IdleTurn {
    /// Executor of its codels.
    pub executor: usize,
    /// Place of the activity, as in [`Work::State`].
    pub slot: usize,
    /// The permanent activity, or an activity.
    pub automaton: AutomatonId,
    /// State of its machine in which the cycle begins.
    pub state: usize,
    /// Time until the next tick, in base units.
    pub tick: Ticks,
}
