//! The kinds of properties that can be checked.

use serde::{Deserialize, Serialize};

/// The kind of property that a check is about (section 10 of the timed semantics).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PropertyKind {
    /// No tick comes before the job of the previous one has ended.
    Schedulable,
    /// A task never waits for a core for its whole period.
    NoOverdue,
    /// The response time: the longest time from the release of a job to its end.
    Response,
    /// The longest time from one predicate to another.
    Within,
    /// The reaction time: the longest time from a new first datum of a chain to the first last datum that
    /// depends on it.
    Reaction,
    /// The data age: the greatest age of the first datum of a chain in the last one.
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
    /// A pattern of predicates in time holds on every run ([`super::MonitorKind`]).
    Pattern,
    /// There is no deadlock: some event always follows.
    Deadlock,
}

impl PropertyKind {
    /// Returns the word for it in scenarios and reports.
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
            PropertyKind::Pattern => "pattern",
            PropertyKind::Deadlock => "deadlock",
        }
    }

    /// Returns true if the property is about the deadline of a task.
    pub fn is_deadline(self) -> bool {
        matches!(self, PropertyKind::Schedulable | PropertyKind::NoOverdue)
    }

    /// Returns true if the answer has a value, the longest time.
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
