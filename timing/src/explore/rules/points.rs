//! The points of the semantics, each with the reading that holds.

use crate::scn::semantics::{LockRule, PauseRule, Semantics, TickRule, TurnRule};
use crate::system::TimedSystem;

/// The cycle of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cycle {
    /// Passes: in each pass, every automaton that runs and is not paused executes one codel (section 21). A
    /// task is one executor.
    Passes,
    /// Jobs: each automaton has one turn, up to its pause or end (section 4). An automaton is an executor:
    /// its first turn and its asynchronous codels are executed while its task does other work.
    Jobs,
}

/// The start of the tasks of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StartUp {
    /// A task begins with its first tick. The next task is started after its first pass (section 21).
    FirstPass,
    /// A task executes its first codel at once, without a core. The next task is started after that codel
    /// (section 3).
    FirstCodel,
}

/// The handling of a message by a control task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Handling {
    /// Several steps: a request is taken, validated and answered, then all activities are examined
    /// (section 21). Other actions can happen between the steps.
    InSteps,
    /// One step, except for codels (section 7).
    AtOnce,
}

/// The reading of each point: those with a keyword of the scenario language, and those without one, which
/// follow the published models only if all others do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Points {
    pub(super) ticks: TickRule,
    pub(super) turns: TurnRule,
    pub(super) locks: LockRule,
    pub(super) pause: PauseRule,
    pub(crate) cycle: Cycle,
    pub(super) start_up: StartUp,
    pub(super) handling: Handling,
}

impl Points {
    /// Returns the points of a system's semantics.
    pub(super) fn of(system: &TimedSystem) -> Points {
        let semantics = system.platform.semantics;
        let Semantics { ticks, turns, locks, pause, .. } = semantics;
        let (cycle, start_up, handling) = if semantics.is_published() {
            (Cycle::Jobs, StartUp::FirstCodel, Handling::AtOnce)
        } else {
            (Cycle::Passes, StartUp::FirstPass, Handling::InSteps)
        };
        Points { ticks, turns, locks, pause, cycle, start_up, handling }
    }
}
