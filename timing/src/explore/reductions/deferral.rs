//! Deferral: ends that can be postponed.
//!
//! With least times of 0, ending a codel now instead of at the next *hard* moment (a tick, the end of a
//! window) gains nothing, if no executor waits for the end meanwhile. At the hard moment the codel can still
//! end first. All that follows the end can follow there as well, in the same order and in no time, and codels
//! begun later have wider windows. So such an end is followed only where an urgent action is about to happen,
//! and a state that differs from another one only by such ends need not be kept.
//!
//! This holds for *lazy groups* of tasks, control tasks and clients: [`jobs`] and [`passes`] say which
//! groups are lazy, for the two kinds of cycles of tasks. A group can have a resting place, see [`rest`];
//! while it is elsewhere the group is not lazy.

mod jobs;
mod passes;
mod rest;

use rustc_hash::FxHashSet;

use self::jobs::LazyMembers;
use self::passes::LazyComponents;
use super::{Deferrable, Kind, Reason, Reduction, Setting};
use crate::explore::rules::points::Cycle;
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::state::State;
use crate::explore::store::{Encoded, encode};

/// Upper limit on the states of a lazy closure. Larger closures are truncated, and fewer states are dropped.
const CLOSURE: usize = 1024;

/// The lazy groups of a system.
#[derive(Debug)]
pub(crate) enum Deferral {
    /// Groups of members.
    Jobs(LazyMembers),
    /// Groups of components.
    Passes(LazyComponents),
}

impl Reduction for Deferral {
    const KIND: Kind = Kind::Deferral;

    fn applies(setting: &Setting) -> Result<Self, Reason> {
        match setting.rules.points.cycle {
            Cycle::Jobs => LazyMembers::of(setting).map(Deferral::Jobs),
            Cycle::Passes => LazyComponents::of(setting).map(Deferral::Passes),
        }
    }
}

impl Deferral {
    /// Returns the reason why no loop rests.
    pub(super) fn without_rest(&self, setting: &Setting) -> Option<Reason> {
        let nothing_rests = match self {
            Deferral::Jobs(lazy) => lazy.rest.is_empty(),
            Deferral::Passes(lazy) => lazy.rest.is_empty(),
        };
        if setting.without.contains(Kind::RestingLoops) {
            Some(Reason::SwitchedOff)
        } else {
            nothing_rests.then_some(Reason::NothingRests)
        }
    }

    /// Returns the members whose ends can be postponed in a calm state, if there are any.
    pub(crate) fn waiters(&self, rules: &Rules, s: &State) -> Option<Deferrable> {
        match self {
            Deferral::Jobs(lazy) => lazy.waiters(rules, s),
            Deferral::Passes(lazy) => lazy.waiters(rules, s),
        }
    }

    /// Calls `found` with every calm state that a calm state can reach by ends that can be postponed, unless
    /// there are too many. Subtracts the number of examined states from the budget.
    pub(crate) fn closure(
        &self,
        rules: &Rules,
        s: &State,
        budget: &mut usize,
        mut found: impl FnMut(&Encoded),
    ) {
        let Some(waiters) = self.waiters(rules, s) else {
            return;
        };
        let mut executing = rules.layout.executing(s);
        if !executing.any(|executor| waiters.can_be_deferred(rules.system, executor)) {
            return;
        }
        let mut seen: FxHashSet<Encoded> = FxHashSet::default();
        let mut stack = vec![s.clone()];
        let mut enabled = Enabled::default();
        let mut encoded = Encoded::default();
        while let Some(s) = stack.pop() {
            rules.enabled(&s, &mut enabled);
            *budget = budget.saturating_sub(1);
            if seen.len() > CLOSURE || *budget == 0 {
                break;
            }
            for &action in &enabled.actions {
                if !is_of_lazy(rules, &waiters, action) {
                    continue;
                }
                let mut next = s.clone();
                rules.apply(&mut next, action);
                encode(&rules.layout, &next, &mut encoded);
                if seen.insert(encoded.clone()) {
                    found(&encoded);
                    stack.push(next);
                }
            }
        }
    }
}

/// Returns true if an action is one of a member whose ends can be postponed.
fn is_of_lazy(rules: &Rules, waiters: &Deferrable, action: Action) -> bool {
    let system = rules.system;
    let member = match action {
        Action::Tick { .. } | Action::Mark { .. } => return false,
        Action::Finish { executor, .. }
        | Action::Acquire { executor }
        | Action::Ticket { executor }
        | Action::Ready { executor }
        | Action::Preempt { executor, .. } => return waiters.can_be_deferred(system, executor),
        Action::Release { task }
        | Action::Grant { task }
        | Action::Begin { task }
        | Action::Wake { task } => task,
        Action::Signal { component } | Action::Reply { component } | Action::Shut { component } => {
            system.tasks.len() + usize::from(component)
        }
        Action::Request { client, .. } | Action::Proceed { client, .. } => {
            system.tasks.len() + system.components.len() + usize::from(client)
        }
    };
    waiters.members[member]
}
