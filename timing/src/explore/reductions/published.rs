//! What is known to be sound under the published rules.

use super::ample::{Ample, Visible};
use super::lazy::Lazy;
use super::overtake::{Now, Overtake};
use super::symmetry::{Orbits, Renaming, Symmetry};
use super::{Asked, Held, Reductions, Waiters};
use crate::explore::rules::published::Published;
use crate::explore::rules::{Action, Enabled};
use crate::explore::state::State;
use crate::explore::store::Encoded;

/// The reductions for the published rules.
#[derive(Debug)]
pub(crate) struct OfPublished {
    lazy: Lazy,
    ample: Ample,
    overtake: Overtake,
    symmetry: Symmetry,
}

impl Reductions<Published<'_>> for OfPublished {
    fn new(rules: &Published, asked: &Asked) -> Self {
        let system = rules.system;
        let visible = Visible::new(system, asked.predicates.iter().copied());
        let lazy = Lazy::new(system, &visible, &asked.measured);
        let ample = Ample::new(system, visible, &asked.measured);
        OfPublished {
            lazy,
            overtake: Overtake::new(system, &ample),
            ample,
            symmetry: Symmetry::new(system, &rules.layout, asked),
        }
    }

    fn persistent(&self, rules: &Published, s: &State, enabled: &Enabled, out: &mut Vec<Action>) {
        self.ample.select(rules, s, enabled, out);
    }

    fn follow(
        &self,
        rules: &Published,
        (s, held): (&State, Held),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, Held)>,
    ) {
        self.ample.select(rules, s, enabled, first);
        let now = Now {
            rules,
            ample: &self.ample,
            s,
            enabled,
        };
        self.overtake.select(now, held, first, out);
        let calm = enabled.is_calm();
        if let Some(waiters) = calm.then(|| self.lazy.waiters(rules, s)).flatten() {
            let waits = |executor| waiters.can_wait(rules.system, executor);
            out.retain(|it| !matches!(it.0, Action::Finish { executor, .. } if waits(executor)));
        }
    }

    fn held_after(
        &self,
        rules: &Published,
        before: &State,
        action: Action,
        s: &State,
        held: Held,
    ) -> Held {
        self.overtake.after(rules, before, action, s, held)
    }

    fn waiters(&self, rules: &Published, s: &State) -> Option<Waiters> {
        self.lazy.waiters(rules, s)
    }

    fn closure(
        &self,
        rules: &Published,
        s: &State,
        budget: &mut usize,
        found: impl FnMut(&Encoded),
    ) {
        self.lazy.closure(rules, s, budget, found);
    }

    fn order(&self, rules: &Published, s: &mut State) -> Option<Renaming> {
        self.symmetry.order(&rules.layout, s)
    }

    fn orbits(&self) -> &Orbits {
        self.symmetry.orbits()
    }
}
