//! Which reductions there are, and why one is not used.

use std::fmt;

/// Kinds of reductions, with the field's terms for their names. `docs/explorer.md` has a section for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Of simultaneous actions that commute one order is followed.
    PersistentSets,
    /// The same for what clients, activities and control tasks do.
    PersistentRequests,
    /// Ends before something due are followed only in order to overtake all that is due.
    SleepSets,
    /// Ends that gain nothing by coming early are put off to the next hard moment.
    Deferral,
    /// A polling loop counts as at rest while it polls.
    RestingLoops,
    /// Parts that are alike are not told apart.
    Symmetry,
    /// States that differ in one window, over adjoining ranges, are joined.
    WindowUnion,
    /// A state with wider windows and older clocks covers one with narrower and younger ones.
    WindowInclusion,
    /// Uncalm states of moments at which very much happens are kept, and not followed again at later ones.
    MomentCovering,
    /// What can never be reached is also looked for with zones.
    Zones,
    /// What a single state shows is also looked for by randomised depth-first search.
    RandomSearch,
    /// Deadlines and bounds on response times are looked for among abstract states first.
    ScheduleAbstraction,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 12] = [
        Kind::PersistentSets,
        Kind::PersistentRequests,
        Kind::SleepSets,
        Kind::Deferral,
        Kind::RestingLoops,
        Kind::Symmetry,
        Kind::WindowUnion,
        Kind::WindowInclusion,
        Kind::MomentCovering,
        Kind::Zones,
        Kind::RandomSearch,
        Kind::ScheduleAbstraction,
    ];

    /// Its name, for options and people.
    pub fn name(self) -> &'static str {
        match self {
            Kind::PersistentSets => "persistent-sets",
            Kind::PersistentRequests => "persistent-requests",
            Kind::SleepSets => "sleep-sets",
            Kind::Deferral => "deferral",
            Kind::RestingLoops => "resting-loops",
            Kind::Symmetry => "symmetry",
            Kind::WindowUnion => "window-union",
            Kind::WindowInclusion => "window-inclusion",
            Kind::MomentCovering => "moment-covering",
            Kind::Zones => "zones",
            Kind::RandomSearch => "random-search",
            Kind::ScheduleAbstraction => "schedule-abstraction",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|it| it.name() == name)
    }
}

/// A set of kinds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Kinds(u16);

impl Kinds {
    /// None of them.
    pub const NONE: Kinds = Kinds(0);

    /// The set with one more.
    #[must_use]
    pub const fn with(self, kind: Kind) -> Kinds {
        Kinds(self.0 | 1 << kind as u16)
    }

    /// Whether one is there.
    pub const fn contains(self, kind: Kind) -> bool {
        self.0 >> kind as u16 & 1 == 1
    }
}

impl FromIterator<Kind> for Kinds {
    fn from_iter<I: IntoIterator<Item = Kind>>(kinds: I) -> Self {
        kinds.into_iter().fold(Kinds::NONE, Kinds::with)
    }
}

/// Why a reduction is not used in an exploration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Somebody asked for that.
    SwitchedOff,
    /// Another one that it is a part of is not used.
    Without(Kind),
    /// Nobody has shown that it is sound under these rules.
    RulesUnknown,
    /// A client asks for `abort`, `kill` or `connect`.
    Builtins,
    /// Locks are given in order of arrival.
    LocksInOrder,
    /// A predicate looks at the states in between.
    Predicates,
    /// There are clients.
    Clients,
    /// Nothing is requested.
    NoClients,
    /// A client can go round without time passing.
    HastyClient,
    /// There are more than it has bits for.
    TooMany,
    /// Some task has activities, separate threads, kept ticks or codels that take no time in a circle.
    NotPlain,
    /// No task is periodic.
    NothingPeriodic,
    /// Some task is periodic.
    Periodic,
    /// Every group of tasks has codels that do not begin at 0, or something that is asked about.
    NothingToPutOff,
    /// No loop polls.
    NothingRests,
    /// No two parts are alike in the system and in what is asked.
    NothingAlike,
    /// Nothing lasts long.
    Short,
    /// Something lasts longer than zones can count.
    TooLong,
    /// Everything takes as long each time.
    Fixed,
    /// Nothing is asked that it could answer.
    NothingToFind,
    /// Only what happens early is of interest.
    InOrder,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Reason::SwitchedOff => "switched off",
            Reason::Without(kind) => return write!(f, "a part of {}, which is off", kind.name()),
            Reason::RulesUnknown => "not shown to be sound under these rules",
            Reason::Builtins => "a client asks for `abort`, `kill` or `connect`",
            Reason::LocksInOrder => "locks are given in order of arrival",
            Reason::Predicates => "a predicate looks at the states in between",
            Reason::Clients => "there are clients",
            Reason::NoClients => "nothing is requested",
            Reason::HastyClient => "a client can go round without time passing",
            Reason::TooMany => "more tasks, automata or services than it can count",
            Reason::NotPlain => {
                "some task has activities, async codels, kept ticks or a loop that takes no time"
            }
            Reason::NothingPeriodic => "no task is periodic",
            Reason::Periodic => "some task is periodic",
            Reason::NothingToPutOff => {
                "whatever could end early has a lower bound, or something is asked about it"
            }
            Reason::NothingRests => "no loop polls",
            Reason::NothingAlike => "no two parts are alike in the system and in what is asked",
            Reason::Short => "nothing lasts long",
            Reason::TooLong => "something lasts longer than zones can count",
            Reason::Fixed => "everything takes as long each time",
            Reason::NothingToFind => "nothing is asked that it could answer",
            Reason::InOrder => "only what happens early is looked for",
        })
    }
}

/// Whether a reduction is used in an exploration, and else why not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
pub struct Activity {
    /// Which one.
    pub kind: Kind,
    /// Why it is not used.
    pub off: Option<Reason>,
}
