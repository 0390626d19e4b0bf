//! All reductions of a search of a system.

use super::ample::Ample;
use super::components::Components;
use super::deferral::Deferral;
use super::facts::Facts;
use super::sleep_sets::{Now, Overtake};
use super::{Activity, Deferrable, Kind, Kinds, Reason, Reduction, Setting, SleepSet, Watched};
use crate::explore::rules::points::Cycle;
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::state::State;
use crate::explore::store::Encoded;
use crate::system::Ticks;

/// The reductions that are sound for a system, the points of its semantics and its watched properties.
#[derive(Debug)]
pub(crate) struct Reductions {
    facts: Facts,
    persistent: Option<PersistentSets>,
    overtake: Option<Overtake>,
    deferral: Option<Deferral>,
    activities: Vec<Activity>,
}

/// Persistent sets: within jobs, or of components that are independent at a moment.
#[derive(Debug)]
enum PersistentSets {
    Ample,
    Components(Components),
}

impl Reductions {
    /// Examines a system. The reductions in `without` are switched off. A search that follows data has none:
    /// every order of actions may matter to it.
    pub(crate) fn new(rules: &Rules, asked: &Watched, without: Kinds) -> Self {
        let facts = Facts::new(rules.system, asked);
        let setting = Setting { rules, asked, facts: &facts, without };
        let mut notes = Vec::new();
        let persistent = match rules.points.cycle {
            Cycle::Jobs => Ample::examine(&setting, &mut notes).map(|Ample| PersistentSets::Ample),
            Cycle::Passes => {
                Components::examine(&setting, &mut notes).map(PersistentSets::Components)
            }
        };
        let overtake = Overtake::examine(&setting, &mut notes);
        let deferral = Deferral::examine(&setting, &mut notes);
        let resting = deferral.as_ref().map(|deferral| deferral.without_rest(&setting));
        notes.push(part(Kind::RestingLoops, resting, Kind::Deferral));
        Reductions { persistent, overtake, deferral, facts, activities: notes }
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
            Some(PersistentSets::Ample) => {
                Ample::select((rules, &self.facts), s, enabled, out);
            }
            Some(PersistentSets::Components(components)) => {
                components.select(rules, s, enabled, out);
            }
            None => out.clone_from(&enabled.actions),
        }
    }

    /// Writes the actions to follow in a state in which some actions are held back, each with the actions
    /// that it holds back. `first` is scratch memory.
    pub(crate) fn follow(
        &self,
        rules: &Rules,
        (s, held): (&State, SleepSet),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, SleepSet)>,
    ) {
        self.persistent(rules, s, enabled, first);
        let now = Now { rules, facts: &self.facts, s, enabled };
        if let Some(overtake) = &self.overtake {
            overtake.select(now, held, first, out);
        } else {
            out.clear();
            out.extend(first.iter().map(|&action| (action, held)));
        }
        let deferral = self.deferral.as_ref().filter(|_| enabled.is_calm());
        if let Some(waiters) = deferral.and_then(|deferral| deferral.waiters(rules, s)) {
            let waits = |executor| waiters.can_be_deferred(rules.system, executor);
            out.retain(|(action, _)| {
                !matches!(*action, Action::Finish { executor, .. } if waits(executor))
            });
        }
    }

    /// Returns the actions still held back after an action that led from `before` to `s`.
    pub(crate) fn sleep_set_after(
        &self,
        rules: &Rules,
        before: &State,
        action: Action,
        s: &State,
        held: SleepSet,
    ) -> SleepSet {
        let overtake = self.overtake.as_ref();
        overtake.map_or(0, |overtake| overtake.after(rules, before, action, s, held))
    }

    /// Returns the executors whose ends can be postponed in a calm state, if there are any.
    pub(crate) fn waiters(&self, rules: &Rules, s: &State) -> Option<Deferrable> {
        self.deferral.as_ref()?.waiters(rules, s)
    }

    /// Calls `found` with calm states that a calm state reaches by ends that can be postponed, and that need
    /// not be kept. Subtracts the number of examined states from the budget.
    pub(crate) fn closure(
        &self,
        rules: &Rules,
        s: &State,
        budget: &mut usize,
        found: impl FnMut(&Encoded),
    ) {
        if let Some(deferral) = &self.deferral {
            deferral.closure(rules, s, budget, found);
        }
    }

    /// Returns the time until the next moment to examine after a calm state, in base units. `None`: never.
    pub(crate) fn next_moment(&self, rules: &Rules, s: &State) -> Option<Ticks> {
        let waiters = self.waiters(rules, s);
        rules.next_moment(s, &|executor| {
            let waits = waiters.as_ref();
            waits.is_some_and(|wait| wait.can_be_deferred(rules.system, executor))
        })
    }
}

/// Returns the activity of a part of a reduction, which is used only together with the whole.
fn part(kind: Kind, off: Option<Option<Reason>>, whole: Kind) -> Activity {
    Activity { kind, off: off.unwrap_or(Some(Reason::Without(whole))) }
}
