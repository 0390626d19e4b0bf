//! The points of the semantics, each with the reading that holds.

pub(crate) use crate::scn::semantics::{Cycle, Handling, StartUp};
use crate::scn::semantics::{FixedPoints, LockRule, PauseRule, Semantics, TickRule, TurnRule};
use crate::system::TimedSystem;

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
        let FixedPoints { cycle, start_up, handling, .. } = semantics.fixed();
        Points { ticks, turns, locks, pause, cycle, start_up, handling }
    }
}
