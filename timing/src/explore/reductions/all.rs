//! All reductions of a search of a system.

use super::ample::Ample;
use super::components::Components;
use super::deferral::Deferral;
use super::facts::Facts;
use super::sleep_sets::{Now, Overtake};
use super::{
    Activity, Deferrable, Kind, Kinds, Reason, Reduced, Reduction, Reductions, Setting, SleepSet,
    Watched,
};
use crate::explore::rules::points::Cycle;
use crate::explore::rules::{Action, Enabled, SystemRules};
use crate::explore::state::State;
use crate::explore::store::Encoded;

/// The reductions that are sound for a system, the points of its semantics and its watched properties.
#[derive(Debug)]
pub(crate) struct AllReductions {
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

impl Reduced for SystemRules<'_> {
    type Reductions = AllReductions;
}

impl Reductions<SystemRules<'_>> for AllReductions {
    fn new(rules: &SystemRules, asked: &Watched, without: Kinds) -> Self {
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
        AllReductions { persistent, overtake, deferral, facts, activities: notes }
    }

    fn activities(&self) -> &[Activity] {
        &self.activities
    }

    fn persistent(&self, rules: &SystemRules, s: &State, enabled: &Enabled, out: &mut Vec<Action>) {
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

    fn follow(
        &self,
        rules: &SystemRules,
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

    fn sleep_set_after(
        &self,
        rules: &SystemRules,
        before: &State,
        action: Action,
        s: &State,
        held: SleepSet,
    ) -> SleepSet {
        let overtake = self.overtake.as_ref();
        overtake.map_or(0, |overtake| overtake.after(rules, before, action, s, held))
    }

    fn waiters(&self, rules: &SystemRules, s: &State) -> Option<Deferrable> {
        self.deferral.as_ref()?.waiters(rules, s)
    }

    fn closure(
        &self,
        rules: &SystemRules,
        s: &State,
        budget: &mut usize,
        found: impl FnMut(&Encoded),
    ) {
        if let Some(deferral) = &self.deferral {
            deferral.closure(rules, s, budget, found);
        }
    }
}

/// Returns the activity of a part of a reduction, which is used only together with the whole.
fn part(kind: Kind, off: Option<Option<Reason>>, whole: Kind) -> Activity {
    Activity { kind, off: off.unwrap_or(Some(Reason::Without(whole))) }
}
