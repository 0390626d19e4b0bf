//! Lines of a run for readers.

use super::Action;
use crate::explore::about::About;

/// One line of a run for readers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moment {
    /// Time in base units.
    pub time: u64,
    /// The component, or the client.
    pub component: String,
    /// The task; `None` for the control task and clients.
    pub task: Option<usize>,
    /// The executing codel that the line is about.
    pub codel: Option<usize>,
    /// Words.
    pub what: String,
    /// Its kind, for timelines.
    pub kind: MomentKind,
    /// What else it is about.
    pub about: About,
    /// The step that it tells of; `None` before the first.
    pub action: Option<Action>,
}

/// Kinds of [`Moment`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MomentKind {
    /// A timer has wrapped.
    Tick,
    /// A task asks for a core.
    Release,
    /// A task got its core.
    Grant,
    /// A codel waits for locks.
    Wait,
    /// A codel begins.
    Begin,
    /// A codel ends.
    End,
    /// A task has ended its job.
    Complete,
    /// A client or control task did something.
    Request,
    /// A limit is exceeded.
    Excess,
}
