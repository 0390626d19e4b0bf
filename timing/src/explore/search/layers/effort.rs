//! Effort of a search in layers: states, memory, and the reductions in use.

use super::Layers;
use crate::explore::reductions::{Activity, Kind, Reason, SleepSet};
use crate::explore::search::graph::NodeId;
use crate::explore::watch::Stop;

/// Bytes that the reconstruction of a run may take, even if the states have used up the limit.
const MIN_BYTES_FOR_RUN: usize = 8 << 20;

/// Number of steps per kept state above which instants are dense: then most effort goes into single moments.
const STEPS_PER_STATE_OF_DENSE_INSTANTS: u64 = 64;

impl Layers<'_> {
    /// Returns true if most effort goes into single moments.
    pub(in crate::explore::search) fn is_dense(&self) -> bool {
        self.steps > STEPS_PER_STATE_OF_DENSE_INSTANTS * self.graph.len() as u64
    }

    /// Returns the number of states that are kept, or were reached at the present moment.
    pub(in crate::explore::search) fn states_now(&self) -> usize {
        self.graph.len() + self.layer.states.len() + self.layer.released.0
    }

    /// Returns the number of states kept; after an incomplete exploration, including those of the last
    /// moment.
    pub(in crate::explore::search) fn states(&self) -> usize {
        match self.stopped {
            None | Some(Stop::Answered) => self.graph.len(),
            Some(_) => self.states_now(),
        }
    }

    /// Returns the bytes of a state in the work list.
    pub(in crate::explore::search) fn bytes_to_do(&self) -> usize {
        size_of::<(NodeId, SleepSet)>() + self.observations.rules.frame().state_bytes()
    }

    /// Returns the bytes in use.
    pub(in crate::explore::search) fn memory(&self) -> usize {
        self.graph.memory() + self.memory_outside_graph() + self.layer.released.1
    }

    pub(super) fn memory_outside_graph(&self) -> usize {
        self.layer.states.memory()
            + self.layer.under_way
            + self.spare.len() * self.observations.rules.frame().state_bytes()
    }

    /// Returns the bytes that the reconstruction of a run may take.
    pub(super) fn room_for_run(&self) -> usize {
        let used = self.graph.memory() + self.memory_outside_graph();
        let left = self.limits.bytes.saturating_sub(used);
        left.max(self.limits.bytes / 8).max(MIN_BYTES_FOR_RUN)
    }

    /// Returns the reductions in use.
    pub(in crate::explore::search) fn activities(&self) -> impl Iterator<Item = Activity> {
        let switched = [Kind::WindowUnion, Kind::WindowInclusion].map(|kind| {
            let off = self.limits.without.contains(kind);
            Activity { kind, off: off.then_some(Reason::SwitchedOff) }
        });
        let own = self.observations.reductions.activities().iter().copied();
        own.chain(switched)
    }
}
