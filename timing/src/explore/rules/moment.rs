//! Lines of a run for readers.

use super::Action;
use crate::explore::details::MomentDetails;
use crate::system::{CodelId, TaskId};

/// One line of a run for readers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moment {
    /// Time, in base units.
    pub time: u64,
    /// Component or client.
    pub component: String,
    /// Task; `None` for the control task and clients.
    pub task: Option<TaskId>,
    pub codel: Option<CodelId>,
    /// Description.
    pub what: String,
    /// Kind, for timelines.
    pub kind: MomentKind,
    pub about: MomentDetails,
    /// Action; `None` before the first action.
    pub action: Option<Action>,
}

/// Kinds of [`Moment`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MomentKind {
    /// A timer has expired.
    Tick,
    /// A task asks for a core.
    Release,
    /// A task gets a core.
    Grant,
    /// A codel waits for locks.
    Wait,
    /// A codel begins.
    Begin,
    /// A codel ends.
    End,
    /// A task ends its job.
    Complete,
    /// A client or control task acts.
    Request,
    /// A limit is exceeded.
    Excess,
}
