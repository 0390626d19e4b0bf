//! State machines: the graph that the codels with states of one task or activity form (language
//! reference, section 13).

use rustc_hash::{FxHashMap, FxHashSet};
use typed_index_collections::TiSlice;

use super::{Codel, CodelId, CodelKind, Name};

/// The machine of one task or activity.
#[derive(Debug, Clone)]
pub struct Machine<'m> {
    /// The codels, with their index among all codels of the owner.
    pub codels: Vec<(CodelId, &'m Codel)>,
    /// The codel of each state, by position in `codels`.
    by_state: FxHashMap<&'m str, usize>,
}

impl<'m> Machine<'m> {
    /// The machine of some codels; those without states are left out.
    pub fn new(codels: &'m TiSlice<CodelId, Codel>) -> Self {
        let codels: Vec<(CodelId, &Codel)> =
            codels.iter_enumerated().filter(|(_, number)| number.kind == CodelKind::Fsm).collect();
        let mut by_state = FxHashMap::default();
        for (position, (_, codel)) in codels.iter().enumerate() {
            for state in &codel.triggers {
                by_state.entry(state.name.as_str()).or_insert(position);
            }
        }
        Self { codels, by_state }
    }

    /// Returns true if there are no codels.
    pub fn is_empty(&self) -> bool {
        self.codels.is_empty()
    }

    /// The states that have a codel, in order of declaration.
    pub fn states(&self) -> impl Iterator<Item = &'m Name> + '_ {
        self.codels.iter().flat_map(|(_, codel)| codel.triggers.iter().map(|trigger| &trigger.name))
    }

    /// The codel of a state, with its index among all codels of the owner.
    pub fn codel(&self, state: &str) -> Option<(CodelId, &'m Codel)> {
        self.by_state.get(state).map(|state| self.codels[*state])
    }

    /// The codel of a state, as its position in [`Machine::codels`].
    pub fn position(&self, state: &str) -> Option<usize> {
        self.by_state.get(state).copied()
    }

    /// Every state that can be reached from a state, itself included, following all yields, plain or paused.
    /// Empty if the state has no codel.
    pub fn reachable(&self, from: &str) -> FxHashSet<&'m str> {
        let mut reached = FxHashSet::default();
        let Some((&from, _)) = self.by_state.get_key_value(from) else {
            return reached;
        };
        let mut pending = vec![from];
        while let Some(state) = pending.pop() {
            if !reached.insert(state) {
                continue;
            }
            if let Some((_, codel)) = self.codel(state) {
                pending.extend(codel.yields.iter().map(|state| state.name.as_str()));
            }
        }
        reached
    }
}
