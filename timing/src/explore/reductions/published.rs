//! Reductions that are proved sound under the published rules.

use super::ample::Ample;
use super::deferral::Deferral;
use super::facts::Facts;
use super::sleep_sets::{Now, Overtake};
use super::symmetry::{Orbits, Renaming, Symmetry};
use super::{
    Activity, Deferrable, Kind, Kinds, Reason, Reduced, Reduction, Reductions, Setting, SleepSet,
    Watched,
};
use crate::explore::rules::published::Published;
use crate::explore::rules::{Action, Enabled};
use crate::explore::state::State;
use crate::explore::store::Encoded;

/// The reductions for the published rules.
#[derive(Debug)]
pub(crate) struct OfPublished {
    facts: Facts,
    ample: Option<Ample>,
    overtake: Option<Overtake>,
    lazy: Option<Deferral>,
    symmetry: Option<Symmetry>,
    /// Orbits without symmetry.
    alone: Orbits,
    activities: Vec<Activity>,
}

impl Reduced for Published<'_> {
    type Reductions = OfPublished;
}

impl Reductions<Published<'_>> for OfPublished {
    fn new(rules: &Published, asked: &Watched, without: Kinds) -> Self {
        let facts = Facts::new(rules.system, asked);
        let setting = Setting {
            rules,
            asked,
            facts: &facts,
            without,
        };
        let mut notes = Vec::new();
        let ample = Ample::examine(&setting, &mut notes);
        let requests = ample.as_ref().map(Ample::without_requests);
        notes.push(part(
            Kind::PersistentRequests,
            requests,
            Kind::PersistentSets,
        ));
        let overtake = Overtake::examine(&setting, &mut notes);
        let lazy = Deferral::examine(&setting, &mut notes);
        let resting = lazy.as_ref().map(|examine| examine.without_rest(&setting));
        notes.push(part(Kind::RestingLoops, resting, Kind::Deferral));
        let symmetry = Symmetry::examine(&setting, &mut notes);
        OfPublished {
            alone: Orbits::none(rules),
            ample,
            overtake,
            lazy,
            symmetry,
            facts,
            activities: notes,
        }
    }

    fn activities(&self) -> &[Activity] {
        &self.activities
    }

    fn persistent(&self, rules: &Published, s: &State, enabled: &Enabled, out: &mut Vec<Action>) {
        match &self.ample {
            Some(ample) => ample.select((rules, &self.facts), s, enabled, out),
            None => out.clone_from(&enabled.actions),
        }
    }

    fn follow(
        &self,
        rules: &Published,
        (s, held): (&State, SleepSet),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, SleepSet)>,
    ) {
        self.persistent(rules, s, enabled, first);
        let now = Now {
            rules,
            facts: &self.facts,
            s,
            enabled,
        };
        match &self.overtake {
            Some(overtake) => overtake.select(now, held, first, out),
            None => {
                out.clear();
                out.extend(first.iter().map(|&action| (action, held)));
            }
        }
        let waiters = self.lazy.as_ref().filter(|_| enabled.is_calm());
        if let Some(waiters) = waiters.and_then(|waiter| waiter.waiters(rules, s)) {
            let waits = |executor| waiters.can_be_deferred(rules.system, executor);
            out.retain(
                |pair| !matches!(pair.0, Action::Finish { executor, .. } if waits(executor)),
            );
        }
    }

    fn sleep_set_after(
        &self,
        rules: &Published,
        before: &State,
        action: Action,
        s: &State,
        held: SleepSet,
    ) -> SleepSet {
        let overtake = self.overtake.as_ref();
        overtake.map_or(0, |overtake| overtake.after(rules, before, action, s, held))
    }

    fn waiters(&self, rules: &Published, s: &State) -> Option<Deferrable> {
        self.lazy.as_ref()?.waiters(rules, s)
    }

    fn closure(
        &self,
        rules: &Published,
        s: &State,
        budget: &mut usize,
        found: impl FnMut(&Encoded),
    ) {
        if let Some(deferral) = &self.lazy {
            deferral.closure(rules, s, budget, found);
        }
    }

    fn order(&self, rules: &Published, s: &mut State) -> Option<Renaming> {
        self.symmetry.as_ref()?.order(rules, s)
    }

    fn orbits(&self) -> &Orbits {
        self.symmetry.as_ref().map_or(&self.alone, Symmetry::orbits)
    }
}

/// Returns the activity of a part of a reduction, which is used only together with the whole.
fn part(kind: Kind, off: Option<Option<Reason>>, whole: Kind) -> Activity {
    Activity {
        kind,
        off: off.unwrap_or(Some(Reason::Without(whole))),
    }
}
