//! Names, times and predicates of scenarios, with their places in the text.

use std::ops::Range;

use dotgen_analysis::model::Seconds;
use serde::{Deserialize, Serialize};

/// A value and its range in the text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spanned<T> {
    /// Value.
    pub value: T,
    /// Range of bytes.
    pub range: Range<usize>,
}

/// `a.b.c`
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Path {
    /// Names, in order.
    pub names: Vec<Spanned<String>>,
}

impl Path {
    /// Returns the range from the first to the last name.
    pub fn range(&self) -> Range<usize> {
        match (self.names.first(), self.names.last()) {
            (Some(first), Some(last)) => first.range.start..last.range.end,
            _ => 0..0,
        }
    }

    /// Returns a path that is not part of a text.
    pub fn of(text: &str) -> Path {
        let names = text.split('.').map(|part| Spanned { value: part.to_owned(), range: 0..0 });
        Path { names: names.collect() }
    }

    /// Returns the path as written, without blanks.
    pub fn text(&self) -> String {
        let names: Vec<&str> = self.names.iter().map(|name| name.value.as_str()).collect();
        names.join(".")
    }
}

/// A unit of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Unit {
    /// `s`
    #[serde(rename = "s")]
    Seconds,
    /// `ms`
    #[serde(rename = "ms")]
    Milliseconds,
    /// `us`
    #[serde(rename = "us")]
    Microseconds,
}

impl Unit {
    /// Returns the unit in seconds.
    pub fn seconds(self) -> Seconds {
        Seconds::new(
            1,
            match self {
                Unit::Seconds => 1,
                Unit::Milliseconds => 1_000,
                Unit::Microseconds => 1_000_000,
            },
        )
    }

    /// Returns the unit as scenarios write it.
    pub fn name(self) -> &'static str {
        match self {
            Unit::Seconds => "s",
            Unit::Milliseconds => "ms",
            Unit::Microseconds => "us",
        }
    }
}

/// `3`, `[1, 3]` or `[1, *]`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Interval {
    /// Lower bound.
    pub lower: u64,
    /// Upper bound; `None` if there is none.
    pub upper: Option<u64>,
}

/// A bound: `<= 50 ms`.
pub type Bound = Option<(u64, Unit)>;

/// The operator of a comparison of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    Below,
    AtMost,
    Above,
    AtLeast,
    Equal,
    Unequal,
}

impl Operator {
    /// Returns the operator as scenarios write it.
    pub fn text(self) -> &'static str {
        match self {
            Operator::Below => "<",
            Operator::AtMost => "<=",
            Operator::Above => ">",
            Operator::AtLeast => ">=",
            Operator::Equal => "==",
            Operator::Unequal => "!=",
        }
    }
}

/// `COMPONENT.PORT.MEMBER <= 3`: a comparison of data of a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Comparison {
    pub path: Path,
    pub operator: Operator,
    /// A number, `true`, `false` or the name of an enumerator.
    pub operand: Spanned<String>,
}

/// A predicate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Pred {
    /// A path. Its last name may be a status.
    Atom(Path),
    /// `leave ATOM`
    Leave(Path),
    Comparison(Comparison),
    /// `not P`
    Not(Box<Pred>),
    /// `P and Q`
    And(Box<Pred>, Box<Pred>),
    /// `P or Q`
    Or(Box<Pred>, Box<Pred>),
}

impl Pred {
    /// Returns the atoms, the atoms that are left, and the comparisons.
    pub(crate) fn parts(&self) -> Box<dyn Iterator<Item = &Pred> + '_> {
        match self {
            Pred::Atom(_) | Pred::Leave(_) | Pred::Comparison(_) => Box::new(std::iter::once(self)),
            Pred::Not(predicate) => predicate.parts(),
            Pred::And(one, other) | Pred::Or(one, other) => {
                Box::new(one.parts().chain(other.parts()))
            }
        }
    }

    /// Returns the comparisons of data.
    pub(crate) fn comparisons(&self) -> impl Iterator<Item = &Comparison> {
        self.parts().filter_map(|part| match part {
            Pred::Comparison(comparison) => Some(comparison),
            _ => None,
        })
    }

    /// Returns normalised text.
    pub fn text(&self) -> String {
        match self {
            Pred::Comparison(Comparison { path, operator, operand }) => {
                format!("{} {} {}", path.text(), operator.text(), operand.value)
            }
            Pred::Atom(path) => path.text(),
            Pred::Leave(path) => format!("leave {}", path.text()),
            Pred::Not(predicate) => match **predicate {
                Pred::Atom(_) | Pred::Leave(_) | Pred::Not(_) => {
                    format!("not {}", predicate.text())
                }
                _ => format!("not ({})", predicate.text()),
            },
            Pred::And(one, other) => {
                let side = |predicate: &Pred| match predicate {
                    Pred::Or(..) => format!("({})", predicate.text()),
                    _ => predicate.text(),
                };
                format!("{} and {}", side(one), side(other))
            }
            Pred::Or(one, other) => format!("{} or {}", one.text(), other.text()),
        }
    }
}
