//! What else a line of a run is about, as data: who keeps whom waiting, who asks whom.

/// What a [moment](super::Moment) is about beside its task and its codel.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum About {
    /// Nothing else.
    #[default]
    Nothing,
    /// A task waits for a core from here on.
    AwaitsCore,
    /// A codel waits for these: those that execute first, then those ahead of it in the queue.
    Blocked(Vec<Blocker>),
    /// A request of a client is taken.
    Requested {
        /// The client.
        client: usize,
        /// The service.
        service: usize,
    },
    /// A control task lets an activity go on, which a task executes.
    Released {
        /// The task.
        task: usize,
    },
    /// Somebody loses the core.
    Preempted(Executing),
}

/// Who executes codels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Executing {
    /// A task.
    Task(usize),
    /// The control task of a component.
    Control(usize),
}

/// Who keeps a codel waiting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blocker {
    /// Its codel.
    pub codel: usize,
    /// Who executes it, or is about to.
    pub by: Executing,
    /// It waits as well, ahead in the queue; otherwise it executes.
    pub ahead: bool,
}
