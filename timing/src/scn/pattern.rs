//! Patterns of predicates in time, as scenarios write them.

use super::values::{Bound, Pred};

/// A pattern of predicates in time, with the form in which it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// Form.
    pub form: PatternForm,
    /// Requirement.
    pub kind: MonitorKind,
    /// The predicates of the kind, in its order.
    pub predicates: Vec<Pred>,
    /// Time of [`MonitorKind::Absent`].
    pub time: Bound,
}

/// The requirement that a monitor checks. *P*, *Q* and *R* are its predicates, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MonitorKind {
    /// *Q* does not hold from a moment at which *P* becomes true until just before the time is over.
    Absent,
    /// *Q* does not hold before *P* has held.
    Precedes,
    /// Before *P* holds for the first time, *Q* does not hold.
    NeverBefore,
    /// From the first moment of *P* on, *Q* does not hold.
    NeverAfter,
    /// From *P* to the next *Q*, if that comes, *R* does not hold.
    NeverBetween,
    /// From *P* to the next *Q*, if that comes, *R* holds at some moment.
    SomeBetween,
    /// From *P* until the next *Q*, or for ever, *R* does not hold.
    NeverUntil,
}

impl MonitorKind {
    /// Returns the index of the predicate without which nothing is claimed of a run: what is preceded calls
    /// for the other, everything else begins with its first predicate.
    pub(crate) fn opening(self) -> usize {
        usize::from(self == MonitorKind::Precedes)
    }

    /// Returns the index of the predicate that must follow the opening one, or else nothing is claimed.
    pub(crate) fn closing(self) -> Option<usize> {
        matches!(self, MonitorKind::NeverBetween | MonitorKind::SomeBetween).then_some(1)
    }
}

/// The written form of a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PatternForm {
    /// `within P => Q in [5, …] ms`: the lower bound.
    Lower,
    /// `absent Q after P for 10 ms`
    Absent,
    /// `lasts P >= 2 ms`
    Lasts,
    /// `P precedes Q`
    Precedes,
    /// `before P never Q`, `between P and Q always R` and the like.
    Scope(ScopeWord),
}

/// The claim about the last predicate of a scope.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScopeWord {
    /// It does not hold.
    Never,
    /// It holds all the time. The predicate of the monitor is its negation.
    Always,
    /// It holds at some moment.
    Eventually,
}

impl ScopeWord {
    /// Returns the word as scenarios write it.
    pub fn word(self) -> &'static str {
        match self {
            ScopeWord::Never => "never",
            ScopeWord::Always => "always",
            ScopeWord::Eventually => "eventually",
        }
    }
}

impl Pattern {
    /// Returns the pattern as it is written, normalised.
    pub fn text(&self) -> String {
        let of = |index: usize| self.predicates[index].text();
        let part = |index: usize| match &self.predicates[index] {
            pred @ (Pred::And(..) | Pred::Or(..)) => format!("({})", pred.text()),
            pred => pred.text(),
        };
        let time =
            self.time.map_or(String::new(), |(count, unit)| format!("{count} {}", unit.name()));
        let word = match self.form {
            PatternForm::Lower => return format!("{} => {} after {time}", of(0), of(1)),
            PatternForm::Absent => {
                return format!("absent {} after {} for {time}", part(1), part(0));
            }
            PatternForm::Lasts => return format!("lasts {} >= {time}", part(0)),
            PatternForm::Precedes => return format!("{} precedes {}", part(0), part(1)),
            PatternForm::Scope(word) => word,
        };
        let claimed = self.predicates.last().map_or(String::new(), |last| match (word, last) {
            (ScopeWord::Always, Pred::Not(claimed)) => claimed.text(),
            _ => last.text(),
        });
        let scope = match self.kind {
            // The monitor needs what is claimed first.
            MonitorKind::Precedes => return format!("before {} eventually {}", part(1), of(0)),
            MonitorKind::NeverBefore => format!("before {}", part(0)),
            MonitorKind::NeverBetween | MonitorKind::SomeBetween => {
                format!("between {} and {}", part(0), part(1))
            }
            MonitorKind::NeverUntil => format!("after {} until {}", part(0), part(1)),
            _ => format!("after {}", part(0)),
        };
        format!("{scope} {} {claimed}", word.word())
    }
}
