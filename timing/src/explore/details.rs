//! Details of a line of a run, as data: blocked codels, requests, preemptions.

use crate::system::{ClientId, CodelId, ComponentId, ServiceId, TaskId};

/// The details of a [moment](super::Moment) beyond its task and its codel.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum MomentDetails {
    /// No details.
    #[default]
    Nothing,
    /// From this moment on, a task waits for a core.
    AwaitsCore,
    /// From this moment on, a codel waits for these codels: first those that execute, then those ahead in the
    /// queue.
    Blocked(Vec<Blocker>),
    /// The control task takes a request of a client.
    Requested { client: ClientId, service: ServiceId },
    /// A control task allows an activity of a task to go on.
    Released { task: TaskId },
    /// A thread is preempted.
    Preempted(Executing),
}

/// A thread that executes codels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Executing {
    Task(TaskId),
    /// The control task of a component.
    Control(ComponentId),
}

/// A codel that keeps another codel waiting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blocker {
    pub codel: CodelId,
    /// Thread that executes it, or is about to.
    pub by: Executing,
    /// The codel waits as well, ahead in the queue; otherwise it executes.
    pub ahead: bool,
}
