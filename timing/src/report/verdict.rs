//! Verdicts.

use serde::Serialize;

/// The answer to a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The property holds.
    Proved,
    /// The property holds if something is true that is not stated:
    /// [`conditions`](super::CheckReport::conditions).
    Conditional,
    /// The property holds because its subject never occurs; [`note`](super::CheckReport::note) says why.
    Vacuous,
    /// The scenario states no limit, and the upper bound is at least the period; the value may be less.
    Bounded,
    /// The scenario states no limit, and the value is at least the period.
    Exceeds,
    /// The property does not hold.
    Refuted,
    /// The verification was given up.
    Unknown,
    /// Nothing can hold or fail: execution times are missing.
    Nothing,
    /// There is no answer yet. Only in intermediate reports.
    Open,
}

impl Verdict {
    /// All verdicts, in the order of counts.
    pub const ALL: [Verdict; 9] = [
        Verdict::Proved,
        Verdict::Conditional,
        Verdict::Vacuous,
        Verdict::Bounded,
        Verdict::Exceeds,
        Verdict::Refuted,
        Verdict::Unknown,
        Verdict::Nothing,
        Verdict::Open,
    ];

    /// True if the property holds, whatever the proof is worth.
    pub fn holds(self) -> bool {
        match self {
            Verdict::Proved
            | Verdict::Conditional
            | Verdict::Vacuous
            | Verdict::Bounded
            | Verdict::Exceeds => true,
            Verdict::Refuted | Verdict::Unknown | Verdict::Nothing | Verdict::Open => false,
        }
    }

    /// The word in a table.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Proved => "proved",
            Verdict::Conditional => "conditional",
            Verdict::Vacuous => "vacuous",
            Verdict::Bounded => "bounded",
            Verdict::Exceeds => "exceeds",
            Verdict::Refuted => "refuted",
            Verdict::Unknown => "gave up",
            Verdict::Nothing => "nothing",
            Verdict::Open => "open",
        }
    }

    /// The word after a count: `2 nothing to verify`.
    pub fn counted(self) -> &'static str {
        match self {
            Verdict::Exceeds => "beyond the period",
            Verdict::Nothing => "nothing to verify",
            _ => self.word(),
        }
    }
}
