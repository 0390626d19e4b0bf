//! The kinds of properties that can be checked.

use serde::Serialize;

/// What kind of property a check asks for (section 10 of the timed semantics).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PropertyKind {
    /// No tick comes before the job of the previous one has ended.
    Schedulable,
    /// A task never waits for a core as long as its period.
    NoOverdue,
    /// The longest time from the release of a job to its end.
    Response,
    /// The longest time from one predicate to another.
    Within,
    /// The longest time from a new first datum of a chain to the first last one that depends on it.
    Reaction,
    /// The greatest age of the first datum of a chain in the last one.
    Age,
    /// One predicate follows another on every run.
    #[serde(rename = "leadsto")]
    LeadsTo,
    /// A predicate becomes true on every run.
    Eventually,
    /// A predicate holds in every state.
    Always,
    /// A predicate holds in some state.
    Reachable,
    /// There is no state after which nothing happens.
    Deadlock,
}

impl PropertyKind {
    /// As scenarios and reports write it.
    pub fn word(self) -> &'static str {
        match self {
            PropertyKind::Schedulable => "schedulable",
            PropertyKind::NoOverdue => "no-overdue",
            PropertyKind::Response => "response",
            PropertyKind::Within => "within",
            PropertyKind::Reaction => "reaction",
            PropertyKind::Age => "age",
            PropertyKind::LeadsTo => "leadsto",
            PropertyKind::Eventually => "eventually",
            PropertyKind::Always => "always",
            PropertyKind::Reachable => "reachable",
            PropertyKind::Deadlock => "deadlock",
        }
    }

    /// Whether it is about the deadline of a task.
    pub fn is_deadline(self) -> bool {
        matches!(self, PropertyKind::Schedulable | PropertyKind::NoOverdue)
    }

    /// Whether its answer has a value, the longest time.
    pub fn is_time(self) -> bool {
        use PropertyKind::{Age, Reaction, Response, Within};
        matches!(self, Response | Within | Reaction | Age)
    }
}

impl std::fmt::Display for PropertyKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.word())
    }
}
