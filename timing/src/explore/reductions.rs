//! Reductions: what need not be followed, kept or told apart.
//!
//! Which reductions there are depends on the rules they were shown to be sound for ([`Reduced`]).
//! Strategies ask at five places, whatever the rules: which of the enabled actions to follow
//! ([`Reductions::persistent`], [`Reductions::follow`]), whose end can be put off ([`Reductions::waiters`],
//! [`Reductions::closure`]), and which of the states that differ only by names to keep
//! ([`Reductions::order`]).
//!
//! Each reduction is one type behind the trait [`Reduction`]: it tells when it applies to a system, its rules
//! and what is asked, and else the [`Reason`]. What it leaves out and why that is sound stands at its module;
//! `docs/explorer.md` is the map.

mod ample;
mod facts;
mod kind;
mod lazy;
mod overtake;
mod published;
mod servers;
mod symmetry;

use smallvec::SmallVec;

use self::facts::Facts;
pub use self::kind::{Activity, Kind, Kinds, Reason};
pub(crate) use self::symmetry::{Label, Orbits, Renaming};
use super::rules::{Action, Enabled, Rules};
use super::state::State;
use super::store::Encoded;
use crate::property::Predicate;
use crate::system::{Ticks, TimedSystem};

/// What is put off for now: a sleep set. Executors from bit 0 on, ticks from bit 64 on.
pub(crate) type Held = u128;

/// What is asked of a system, as far as reductions have to respect it.
pub(crate) struct Watched<'a> {
    /// Tasks with equal labels are asked the same.
    pub(crate) labels: Vec<Label>,
    /// What is said about single states.
    pub(crate) predicates: Vec<&'a Predicate>,
    /// Tasks with a clock for their response time.
    pub(crate) measured: Vec<bool>,
}

impl<'a> Watched<'a> {
    /// Nothing but some predicates.
    pub(crate) fn only(system: &TimedSystem, predicates: Vec<&'a Predicate>) -> Self {
        Watched {
            labels: vec![Label::default(); system.tasks.len()],
            predicates,
            measured: vec![false; system.tasks.len()],
        }
    }
}

/// What a reduction may or may not be used for.
pub(crate) struct Setting<'a, R> {
    pub(crate) rules: &'a R,
    pub(super) asked: &'a Watched<'a>,
    /// What is known beforehand.
    pub(super) facts: &'a Facts,
    /// What is switched off.
    pub(crate) without: Kinds,
}

impl<R: Rules> Setting<'_, R> {
    pub(crate) fn system(&self) -> &TimedSystem {
        self.rules.system()
    }
}

/// One reduction, for one set of rules.
pub(crate) trait Reduction<R>: Sized {
    /// Which one it is.
    const KIND: Kind;

    /// The reduction, examined for a system and what is asked of it, or the reason why it is not sound, or of
    /// no use, there.
    fn applies(setting: &Setting<R>) -> Result<Self, Reason>;

    /// The same, unless it is switched off; notes which of both.
    fn examine(setting: &Setting<R>, notes: &mut Vec<Activity>) -> Option<Self> {
        let it = match setting.without.contains(Self::KIND) {
            true => Err(Reason::SwitchedOff),
            false => Self::applies(setting),
        };
        notes.push(Activity {
            kind: Self::KIND,
            off: it.as_ref().err().copied(),
        });
        it.ok()
    }
}

/// All reductions that are known for a set of rules, as far as they apply to one system and what is asked of
/// it.
pub(crate) trait Reductions<R: Rules>: Sized {
    /// Examines a system. Some are switched off.
    fn new(rules: &R, asked: &Watched, without: Kinds) -> Self;

    /// Which are used, and why others are not.
    fn activities(&self) -> &[Activity];

    /// Writes the actions to follow in a state, so that all calm states are still come to at this moment (a
    /// persistent set), or all that are enabled.
    fn persistent(&self, rules: &R, s: &State, enabled: &Enabled, out: &mut Vec<Action>);

    /// Writes the actions to follow in a state in which some are held back, with what they hold back. `first`
    /// is memory.
    fn follow(
        &self,
        rules: &R,
        at: (&State, Held),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, Held)>,
    );

    /// What is still held back after an action that led from one state to another.
    fn held_after(&self, rules: &R, before: &State, action: Action, s: &State, held: Held) -> Held;

    /// Those whose ends can be put off in a calm state, if there are any.
    fn waiters(&self, rules: &R, s: &State) -> Option<Waiters>;

    /// Calls `found` with calm states that a calm state can reach by ends that can be put off, so that they
    /// need not be kept. Takes what it looked at off the budget.
    fn closure(&self, rules: &R, s: &State, budget: &mut usize, found: impl FnMut(&Encoded));

    /// Puts what is alike in order. `None` if it is.
    fn order(&self, rules: &R, s: &mut State) -> Option<Renaming>;

    /// What is alike.
    fn orbits(&self) -> &Orbits;

    /// The next moment at which something has to be looked at, after a calm state. `None`: never.
    fn next_moment(&self, rules: &R, s: &State) -> Option<Ticks> {
        let waiters = self.waiters(rules, s);
        rules.next_moment(s, &|executor| {
            let waits = waiters.as_ref();
            waits.is_some_and(|it| it.can_wait(rules.system(), executor))
        })
    }
}

/// Tasks, control tasks and clients whose ends can be put off in one state: numbered as *members*, in this
/// order.
#[derive(Debug, Clone)]
pub(crate) struct Waiters(pub(super) SmallVec<[bool; 24]>);

impl Waiters {
    /// Whether the end of what an executor executes can be put off.
    pub(crate) fn can_wait(&self, system: &TimedSystem, executor: usize) -> bool {
        let automata = &system.automata;
        let member = match automata.get(executor) {
            Some(it) => it.task,
            // Control tasks and clients come after the automata, as among the members after the tasks.
            None => executor - automata.len() + system.tasks.len(),
        };
        self.0[member]
    }
}

/// Rules for which it was shown which reductions are sound.
pub(crate) trait Reduced: Rules {
    /// These reductions.
    type Reductions: Reductions<Self>;
}

/// Nothing is left out: for rules that nothing is known of.
#[derive(Debug)]
#[allow(
    dead_code,
    reason = "for sets of rules to begin with; the published ones have their own"
)]
pub(crate) struct NoReductions(Orbits, Vec<Activity>);

impl<R: Rules> Reductions<R> for NoReductions {
    fn new(rules: &R, _: &Watched, _: Kinds) -> Self {
        let unknown = |kind| Activity {
            kind,
            off: Some(Reason::RulesUnknown),
        };
        let kinds = [
            Kind::PersistentSets,
            Kind::PersistentRequests,
            Kind::SleepSets,
            Kind::Deferral,
            Kind::RestingLoops,
            Kind::Symmetry,
        ];
        NoReductions(
            Orbits::none(rules.system()),
            kinds.into_iter().map(unknown).collect(),
        )
    }

    fn activities(&self) -> &[Activity] {
        &self.1
    }

    fn persistent(&self, _: &R, _: &State, enabled: &Enabled, out: &mut Vec<Action>) {
        out.clone_from(&enabled.actions);
    }

    fn follow(
        &self,
        _: &R,
        (_, held): (&State, Held),
        enabled: &Enabled,
        _: &mut Vec<Action>,
        out: &mut Vec<(Action, Held)>,
    ) {
        out.clear();
        out.extend(enabled.actions.iter().map(|&it| (it, held)));
    }

    fn held_after(&self, _: &R, _: &State, _: Action, _: &State, _: Held) -> Held {
        0
    }

    fn waiters(&self, _: &R, _: &State) -> Option<Waiters> {
        None
    }

    fn closure(&self, _: &R, _: &State, _: &mut usize, _: impl FnMut(&Encoded)) {}

    fn order(&self, _: &R, _: &mut State) -> Option<Renaming> {
        None
    }

    fn orbits(&self) -> &Orbits {
        &self.0
    }
}
