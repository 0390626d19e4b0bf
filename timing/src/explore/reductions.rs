//! Reductions: actions that need not be followed, and states that need not be kept.
//!
//! Strategies use reductions to select the enabled actions to follow ([`Reductions::persistent`],
//! [`Reductions::follow`]), and to find the ends that can be postponed
//! ([`Reductions::waiters`], [`Reductions::closure`]).
//!
//! Each reduction is one type with the trait [`Reduction`]. It applies to a system, the points of its
//! semantics and its watched properties, or gives a [`Reason`] for not applying. The module of each reduction
//! describes it and proves its soundness; `docs/explorer.md` gives an overview.

mod all;
mod ample;
mod components;
mod deferral;
mod facts;
mod kind;
mod sleep_sets;

use smallvec::SmallVec;

use self::facts::Facts;
pub use self::kind::{Activity, Kind, Kinds, Reason};
use super::rules::{Action, Enabled, Rules, SystemRules};
use super::state::State;
use super::store::Encoded;
use crate::property::Predicate;
use crate::system::{AutomatonId, Ticks, TimedSystem};

/// A sleep set: the actions held back for now. Executors from bit 0 on, ticks from bit 64 on.
pub(crate) type SleepSet = u128;

/// The watched properties of a system, as far as reductions must respect them.
pub(crate) struct Watched<'a> {
    /// Predicates on single states.
    pub(crate) predicates: Vec<&'a Predicate>,
    /// Tasks with a clock for their response time.
    pub(crate) measured: Vec<bool>,
}

/// The input of a reduction's examination.
pub(crate) struct Setting<'a> {
    pub(crate) rules: &'a SystemRules<'a>,
    pub(super) asked: &'a Watched<'a>,
    /// Known facts about the system.
    pub(super) facts: &'a Facts,
    /// Reductions that are switched off.
    pub(crate) without: Kinds,
}

impl Setting<'_> {
    pub(crate) fn system(&self) -> &TimedSystem {
        self.rules.system
    }
}

pub(crate) trait Reduction: Sized {
    /// Kind of the reduction.
    const KIND: Kind;

    /// Returns the reduction for a system and its watched properties.
    ///
    /// # Errors
    ///
    /// Returns the reason why the reduction is not sound, or of no use, for the system.
    fn applies(setting: &Setting) -> Result<Self, Reason>;

    /// Applies the reduction unless it is switched off, and records the outcome in `notes`.
    fn examine(setting: &Setting, notes: &mut Vec<Activity>) -> Option<Self> {
        let result = if setting.without.contains(Self::KIND) {
            Err(Reason::SwitchedOff)
        } else {
            Self::applies(setting)
        };
        notes.push(Activity { kind: Self::KIND, off: result.as_ref().err().copied() });
        result.ok()
    }
}

/// The reductions of a search, as far as they apply to one system and its watched properties.
pub(crate) trait Reductions<R: Rules>: Sized {
    /// Examines a system. The reductions in `without` are switched off.
    fn new(rules: &R, asked: &Watched, without: Kinds) -> Self;

    /// Returns the reductions used, and the reasons against the others.
    fn activities(&self) -> &[Activity];

    /// Writes the actions to follow in a state: a persistent set, with which all calm states of this moment
    /// are still reached, or all enabled actions.
    fn persistent(&self, rules: &R, s: &State, enabled: &Enabled, out: &mut Vec<Action>);

    /// Writes the actions to follow in a state in which some actions are held back, each with the actions
    /// that it holds back. `first` is scratch memory.
    fn follow(
        &self,
        rules: &R,
        at: (&State, SleepSet),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, SleepSet)>,
    );

    /// Returns the actions still held back after an action that led from `before` to `s`.
    fn sleep_set_after(
        &self,
        rules: &R,
        before: &State,
        action: Action,
        s: &State,
        held: SleepSet,
    ) -> SleepSet;

    /// Returns the executors whose ends can be postponed in a calm state, if there are any.
    fn waiters(&self, rules: &R, s: &State) -> Option<Deferrable>;

    /// Calls `found` with calm states that a calm state reaches by ends that can be postponed, and that need
    /// not be kept. Subtracts the number of examined states from the budget.
    fn closure(&self, rules: &R, s: &State, budget: &mut usize, found: impl FnMut(&Encoded));

    /// Returns the time until the next moment to examine after a calm state, in base units. `None`: never.
    fn next_moment(&self, rules: &R, s: &State) -> Option<Ticks> {
        let waiters = self.waiters(rules, s);
        rules.next_moment(s, &|executor| {
            let waits = waiters.as_ref();
            waits.is_some_and(|wait| wait.can_be_deferred(rules.system(), executor))
        })
    }
}

/// Tasks, control tasks and clients whose ends can be postponed in one state: numbered as *members*, in this
/// order.
#[derive(Debug, Clone)]
pub(crate) struct Deferrable {
    pub(super) members: SmallVec<[bool; 24]>,
    /// Automata are executors, instead of tasks.
    pub(super) automata: bool,
}

impl Deferrable {
    /// Returns true if the end of an executor's work can be postponed.
    pub(crate) fn can_be_deferred(&self, system: &TimedSystem, executor: usize) -> bool {
        let automata = &system.automata;
        let member = match automata.get(AutomatonId::from(executor)) {
            _ if !self.automata => executor,
            Some(automaton) => usize::from(automaton.task),
            None => executor - automata.len() + system.tasks.len(),
        };
        self.members[member]
    }
}

/// Rules with reductions.
pub(crate) trait Reduced: Rules {
    /// The reductions that are sound for the rules.
    type Reductions: Reductions<Self>;
}

/// No reductions, for searches that follow data: nothing is left out.
#[derive(Debug)]
pub(crate) struct NoReductions(Vec<Activity>);

impl<R: Rules> Reductions<R> for NoReductions {
    fn new(_: &R, _: &Watched, _: Kinds) -> Self {
        let off = |kind| Activity { kind, off: Some(Reason::Chain) };
        let kinds = [Kind::PersistentSets, Kind::SleepSets, Kind::Deferral, Kind::RestingLoops];
        NoReductions(kinds.into_iter().map(off).collect())
    }

    fn activities(&self) -> &[Activity] {
        &self.0
    }

    fn persistent(&self, _: &R, _: &State, enabled: &Enabled, out: &mut Vec<Action>) {
        out.clone_from(&enabled.actions);
    }

    fn follow(
        &self,
        _: &R,
        (_, held): (&State, SleepSet),
        enabled: &Enabled,
        _: &mut Vec<Action>,
        out: &mut Vec<(Action, SleepSet)>,
    ) {
        out.clear();
        out.extend(enabled.actions.iter().map(|&action| (action, held)));
    }

    fn sleep_set_after(&self, _: &R, _: &State, _: Action, _: &State, _: SleepSet) -> SleepSet {
        0
    }

    fn waiters(&self, _: &R, _: &State) -> Option<Deferrable> {
        None
    }

    fn closure(&self, _: &R, _: &State, _: &mut usize, _: impl FnMut(&Encoded)) {}
}
