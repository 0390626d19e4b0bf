//! The kinds of reductions, and the reasons against their use.

use std::fmt;

/// The kinds of reductions, named with the field's terms. `docs/explorer.md` has a section for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Follow simultaneous actions that commute in one order only.
    PersistentSets,
    /// Follow ends before a due action only in order to overtake all that is due.
    SleepSets,
    /// Postpone ends that gain nothing by coming early to the next hard moment.
    Deferral,
    /// Treat a polling loop as resting while it polls.
    RestingLoops,
    /// Join states that differ in one window, if their ranges adjoin.
    WindowUnion,
    /// Let a state with wider windows and older clocks cover a state with narrower windows and younger
    /// clocks.
    WindowInclusion,
    /// Look for properties of single states by randomised depth-first search as well.
    RandomSearch,
    /// Look for deadlines and bounds on response times by schedule abstraction first.
    ScheduleAbstraction,
    /// Prove predicates by invariants first.
    Invariants,
}

impl Kind {
    pub const ALL: [Kind; 9] = [
        Kind::PersistentSets,
        Kind::SleepSets,
        Kind::Deferral,
        Kind::RestingLoops,
        Kind::WindowUnion,
        Kind::WindowInclusion,
        Kind::RandomSearch,
        Kind::ScheduleAbstraction,
        Kind::Invariants,
    ];

    /// Returns the name, for options and messages.
    pub fn name(self) -> &'static str {
        match self {
            Kind::PersistentSets => "persistent-sets",
            Kind::SleepSets => "sleep-sets",
            Kind::Deferral => "deferral",
            Kind::RestingLoops => "resting-loops",
            Kind::WindowUnion => "window-union",
            Kind::WindowInclusion => "window-inclusion",
            Kind::RandomSearch => "random-search",
            Kind::ScheduleAbstraction => "schedule-abstraction",
            Kind::Invariants => "invariants",
        }
    }

    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// A set of kinds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Kinds(u16);

impl Kinds {
    /// The empty set.
    pub const NONE: Kinds = Kinds(0);

    /// Returns the set with one more kind.
    #[must_use]
    pub const fn with(self, kind: Kind) -> Kinds {
        Kinds(self.0 | 1 << kind as u16)
    }

    /// Returns true if the set contains a kind.
    pub const fn contains(self, kind: Kind) -> bool {
        self.0 >> kind as u16 & 1 == 1
    }
}

impl FromIterator<Kind> for Kinds {
    fn from_iter<I: IntoIterator<Item = Kind>>(kinds: I) -> Self {
        kinds.into_iter().fold(Kinds::NONE, Kinds::with)
    }
}

/// The reason why a reduction is not used in an exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// An option switches it off.
    SwitchedOff,
    /// It is a part of another reduction that is not used.
    Without(Kind),
    /// A chain follows data, and every order of actions may matter to it.
    Chain,
    /// The actions of a component do not commute: they meet in its lock queue, or at its control task, which
    /// examines all activities.
    OneQueue,
    /// Threads preempt each other.
    Preemption,
    /// Codels of different components exclude each other by ports.
    LockedPorts,
    /// A client requests `abort`, `kill` or `connect`.
    Builtins,
    /// Locks are granted in order of arrival.
    LocksInOrder,
    /// A predicate observes the intermediate states.
    Predicates,
    /// The system has clients.
    Clients,
    /// The system has more parts than the reduction has bits.
    TooMany,
    /// Some task has activities, separate threads, kept ticks or a loop of codels that take no time.
    NotPlain,
    /// No task is periodic.
    NothingPeriodic,
    /// Every group of tasks has codels with a least time above 0, or is observed.
    NothingToPutOff,
    /// The system has no polling loop.
    NothingRests,
    /// Only early events are of interest.
    InOrder,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Reason::SwitchedOff => "switched off",
            Reason::Without(kind) => return write!(f, "a part of {}, which is off", kind.name()),
            Reason::Chain => "a chain follows data, and every order of actions may matter to it",
            Reason::OneQueue => {
                "the actions of a component meet in its lock queue or at its control task, which see their order"
            }
            Reason::Preemption => "threads of different components preempt each other",
            Reason::LockedPorts => "components lock each other's ports",
            Reason::Builtins => "a client asks for `abort`, `kill` or `connect`",
            Reason::LocksInOrder => "locks are given in order of arrival",
            Reason::Predicates => "a predicate looks at the states in between",
            Reason::Clients => "there are clients",
            Reason::TooMany => "more tasks, automata or services than it can count",
            Reason::NotPlain => {
                "some task has activities, async codels, kept ticks or a loop that takes no time"
            }
            Reason::NothingPeriodic => "no task is periodic",
            Reason::NothingToPutOff => {
                "whatever could end early has a lower bound, or something is asked about it"
            }
            Reason::NothingRests => "no loop polls",
            Reason::InOrder => "only what happens early is looked for",
        })
    }
}

/// The use of a reduction in an exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub struct Activity {
    /// Kind of the reduction.
    pub kind: Kind,
    /// Reason against its use; `None` if it is used.
    pub off: Option<Reason>,
}
