//! The meaning of the numbers in a state: positions of threads, flags of tasks, statuses of activities, steps
//! of control tasks, and the progress of requests.

/// The position of a task's thread.
pub(crate) mod thread {
    /// Not started.
    pub(crate) const OFF: u16 = 0;
    /// Between cycles.
    pub(crate) const IDLE: u16 = 1;
    /// Has cleared its flag and waits for a core.
    pub(crate) const WAITING: u16 = 2;
    /// Before the next pass of its cycle.
    pub(crate) const AGAIN: u16 = 3;
    /// Before it takes a ticket for the next codel of its pass.
    pub(crate) const TICKET: u16 = 4;
    /// Waits in the lock queue.
    pub(crate) const QUEUED: u16 = 5;
    /// Executes a codel; with jobs, also between codels.
    pub(crate) const EXECUTING: u16 = 6;
    /// Has ended with its component.
    pub(crate) const ENDED: u16 = 7;
}

/// Flags of a task.
pub(crate) mod flag {
    /// A tick has come since the last cycle began.
    pub(crate) const TICK: u16 = 1;
    /// Paused automata must be resumed (aperiodic tasks).
    pub(crate) const RUNNABLE: u16 = 2;
    /// The other tasks must be woken before any other action.
    pub(crate) const WAKE: u16 = 4;
    /// The first cycle is not over.
    pub(crate) const FIRST: u16 = 8;
    /// In this pass some automaton continues without a pause.
    pub(crate) const GOES_ON: u16 = 16;
    /// In this pass an activity has ended, and must be signalled.
    pub(crate) const ENDED: u16 = 32;
    /// In this pass there was an event.
    pub(crate) const EVENT: u16 = 64;
    /// The task holds a core: from the grant until its thread has made the wake-ups after its last pass.
    pub(crate) const CORE: u16 = 128;
    /// A tick has come while another one waited for a core: its deadline is missed, although no cycle has
    /// begun.
    pub(crate) const LATE: u16 = 256;
    /// Flags of a pass.
    pub(crate) const OF_PASS: u16 = GOES_ON | ENDED | EVENT;
}

/// Status of an activity, and its flags.
pub(crate) mod slot {
    pub(crate) const VOID: u16 = 0;
    /// Accepted, has not begun.
    pub(crate) const INIT: u16 = 1;
    pub(crate) const RUN: u16 = 2;
    pub(crate) const STOP: u16 = 3;
    /// Ended, not reported.
    pub(crate) const ETHER: u16 = 4;
    /// Mask of the status.
    pub(crate) const STATUS: u16 = 7;
    /// Released: it may begin. (With jobs a released activity has the status `RUN`.)
    pub(crate) const START: u16 = 8;
    /// Interrupted, and has not noticed yet.
    pub(crate) const MARK: u16 = 16;
    pub(crate) const PAUSED: u16 = 32;
    /// Ended without exception.
    pub(crate) const SUCCESS: u16 = 64;
    /// The permanent activity.
    pub(crate) const PERMANENT: u16 = 128;
}

/// Status of a permanent activity, if tasks start with a codel
/// ([`StartUp::FirstCodel`](super::points::StartUp)).
pub(crate) mod permanent {
    // 0: its task is not started.
    /// First codel of the start-up.
    pub(crate) const FIRST_CODEL: u16 = 1;
    /// In its first turn, past the first codel.
    pub(crate) const FIRST_TURN: u16 = 2;
    /// Runs with its task.
    pub(crate) const NORMAL: u16 = 3;
    pub(crate) const ENDED: u16 = 4;
}

/// Steps of a control task.
pub(crate) mod control {
    /// Its component is starting, or has failed to, or has ended.
    pub(crate) const OFF: u16 = 0;
    pub(crate) const READY: u16 = 1;
    /// Before it takes a ticket.
    pub(crate) const TICKET: u16 = 2;
    pub(crate) const QUEUED: u16 = 3;
    /// Executes a codel, or waits for its locks without a queue.
    pub(crate) const EXECUTING: u16 = 4;
    /// Codels are done: before the reply and the examination of all activities.
    pub(crate) const REST: u16 = 5;
}

/// Values of trackers other than "slot" (which is [`tracker::SLOT`] plus its number among all).
pub(crate) mod tracker {
    pub(crate) const NONE: u16 = 0;
    /// Sent, not accepted yet.
    pub(crate) const HANDLED: u16 = 1;
    /// The request has ended without success; only if a client depends on the outcome.
    pub(crate) const FAILED: u16 = 2;
    pub(crate) const SLOT: u16 = 3;
}
