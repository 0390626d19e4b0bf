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

pub(crate) use self::all::Reductions;
use self::facts::Facts;
pub use self::kind::{Activity, Kind, Kinds, Reason};
use super::rules::Rules;
use crate::property::Predicate;
use crate::system::{AutomatonId, TimedSystem};

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
    pub(crate) rules: &'a Rules<'a>,
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
        } else if setting.rules.token.is_some() {
            Err(Reason::Chain)
        } else {
            Self::applies(setting)
        };
        notes.push(Activity { kind: Self::KIND, off: result.as_ref().err().copied() });
        result.ok()
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
