//! What a measured time of a run is spent on, and what makes a time unbounded.

use dotgen_analysis::model::Src;

use crate::system::{CodelName, ThreadName};

/// An interval of a run. The intervals of a check have no gaps, and add up to the time that is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Start, in the unit of the report.
    pub from: f64,
    /// End, in the unit of the report.
    pub until: f64,
    /// The thread that has to act; `None` if the run names none.
    pub thread: Option<ThreadName>,
    pub kind: StretchKind,
    /// An execution begins with the interval; false if it goes on after a preemption.
    pub begins: bool,
}

/// What the thread of a [`Stretch`] does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StretchKind {
    Executes(CodelName),
    /// The codel has begun, and other threads have its core.
    Preempted(CodelName),
    /// The codel waits for its locks, which the `holder` has.
    Locks {
        codel: CodelName,
        holder: Option<CodelName>,
    },
    /// The job waits for a core.
    Core,
    /// The next job has not begun: a task waits for its tick, or to be woken.
    Between,
    /// No request for the service, with its component, is accepted.
    Unrequested(String),
    /// The client has not come to the awaited step.
    Client,
    /// Nothing that the run names.
    Nothing,
}

/// What goes on for ever in a run, so that a time has no bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Endless {
    pub thread: Option<ThreadName>,
    pub kind: EndlessKind,
}

/// See [`Endless`].
#[derive(Debug, Clone, PartialEq)]
pub enum EndlessKind {
    /// The codels are executed in turn.
    Loop {
        codels: Vec<CodelName>,
        /// The yields with which the codels could leave the loop, and do not.
        exits: Vec<LoopExit>,
    },
    /// The thread waits.
    Waits(StretchKind),
}

/// A yield that leaves a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopExit {
    pub codel: CodelName,
    /// The yield, as the specification writes it.
    pub yields: String,
    /// Declaration of the codel: number of the specification, and place.
    pub src: Option<(usize, Src)>,
}
