//! Reductions: actions that need not be followed.
//!
//! A reduction applies to a system, the points of its semantics and its watched properties, or has a
//! [`Reason`] for not applying. Its module describes it and proves its soundness; `docs/explorer.md` gives an
//! overview.

mod components;
mod kind;

use self::components::Components;
pub use self::kind::{Activity, Kind, Kinds, Reason};
use super::rules::{Action, Enabled, Rules};
use super::state::State;
use crate::property::Predicate;

/// The reductions that are sound for a system and some predicates on single states.
#[derive(Debug)]
pub(crate) struct Reductions {
    persistent: Option<Components>,
    activities: Vec<Activity>,
}

impl Reductions {
    /// Examines a system. The reductions in `without` are switched off. A search that follows data has none:
    /// every order of actions may matter to it.
    pub(crate) fn new(rules: &Rules, predicates: &[&Predicate], without: Kinds) -> Self {
        let persistent = if without.contains(Kind::PersistentSets) {
            Err(Reason::SwitchedOff)
        } else if rules.token.is_some() {
            Err(Reason::Chain)
        } else {
            Components::of(rules, predicates)
        };
        let off = persistent.as_ref().err().copied();
        Reductions {
            persistent: persistent.ok(),
            activities: vec![Activity { kind: Kind::PersistentSets, off }],
        }
    }

    /// Returns the reductions used, and the reasons against the others.
    pub(crate) fn activities(&self) -> &[Activity] {
        &self.activities
    }

    /// Writes the actions to follow in a state: a persistent set, with which all calm states of this moment
    /// are still reached, or all enabled actions.
    pub(crate) fn persistent(
        &self,
        rules: &Rules,
        s: &State,
        enabled: &Enabled,
        out: &mut Vec<Action>,
    ) {
        match &self.persistent {
            Some(components) => components.select(rules, s, enabled, out),
            None => out.clone_from(&enabled.actions),
        }
    }
}
