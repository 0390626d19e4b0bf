//! The reasons why the middle tier has no bound for a task.

use crate::system::TaskId;
use std::fmt;

/// The reason why a task has no bound from the middle tier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// Some point of the semantics differs from both presets, or the lock order is not supported.
    Semantics,
    /// Executing codels can be preempted.
    Preemption,
    /// Clients request services.
    Requests,
    /// The task has no period, or tasks without a period may hold all cores.
    Aperiodic,
    /// A task keeps its tick while it has no work.
    KeepsTicks,
    /// A separate thread executes a codel.
    Apart,
    /// A turn need not reach a pause.
    WithoutPause,
    /// A codel of a task has no longest time, or may wait for a codel that has none.
    Endless { task: TaskId },
    /// Published models: start-up takes time, or can lead to too many places.
    StartUp,
    /// Published models: a task has no permanent activity, or one that can end.
    Ends,
    /// The hyperperiod is too long.
    Hyperperiod,
    /// The number of states exceeds the budget.
    States {
        /// Number of states.
        looked_at: usize,
    },
    /// A job may still be under way when the next tick of its task comes.
    MayMiss { task: TaskId },
    /// The verification was cancelled, or the time limit is reached.
    Cancelled,
}

impl Refusal {
    /// Returns the task that cannot be followed, if other tasks can.
    pub(super) fn task(self) -> Option<TaskId> {
        match self {
            Refusal::MayMiss { task } | Refusal::Endless { task } => Some(task),
            _ => None,
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Semantics => f.write_str("single points of the semantics differ"),
            Refusal::Preemption => f.write_str("cores are taken away from codels that execute"),
            Refusal::Requests => f.write_str("clients request services"),
            Refusal::Aperiodic => f.write_str("a task has no period"),
            Refusal::KeepsTicks => f.write_str("ticks of idle tasks are kept"),
            Refusal::Apart => f.write_str("`async` codels have threads of their own"),
            Refusal::WithoutPause => f.write_str("a turn need not come to a pause"),
            Refusal::Endless { .. } => f.write_str("a codel has no longest time"),
            Refusal::StartUp => f.write_str("starting up takes time"),
            Refusal::Ends => f.write_str("a task has nothing to execute, or may end to have"),
            Refusal::Hyperperiod => f.write_str("the periods have too long a common multiple"),
            Refusal::States { looked_at } => {
                write!(f, "given up after {looked_at} abstract states")
            }
            Refusal::MayMiss { .. } => {
                f.write_str("a deadline may be missed, as far as it can tell")
            }
            Refusal::Cancelled => f.write_str("there was no time for it"),
        }
    }
}
