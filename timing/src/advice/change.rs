//! A change, as data.

use dotgen_analysis::model::{Seconds, Src};
use serde::Serialize;

use crate::scn::ast::Policy;

/// What to change, the rest as it is. Times are in the unit of the report, those without a place in JSON in
/// seconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "change", rename_all = "kebab-case")]
pub enum Change {
    /// The execution time of a codel.
    Wcet {
        /// `component.owner.state`
        codel: String,
        /// The longest one now.
        now: f64,
        /// The longest one with which it holds.
        #[serde(rename = "at-most")]
        at_most: f64,
        /// Likewise, exactly.
        #[serde(skip)]
        seconds: Seconds,
        /// Shorter ones hold as well. With fixed durations only this one was verified.
        #[serde(rename = "or-less")]
        or_less: bool,
        /// Where the codel is declared: number of the specification, and place.
        #[serde(skip)]
        src: Option<(usize, Src)>,
    },
    /// The period of a task. Longer ones need not hold.
    Period {
        /// `component.task`
        task: String,
        /// The one it has.
        now: f64,
        /// The one with which it holds.
        needed: f64,
        /// Likewise, exactly.
        #[serde(skip)]
        seconds: Seconds,
        /// Where the period is declared.
        #[serde(skip)]
        src: Option<(usize, Src)>,
    },
    /// The offset of a task, its `delay`.
    Delay {
        /// `component.task`
        task: String,
        /// The one it has.
        now: f64,
        /// The one with which it holds.
        needed: f64,
        /// Likewise, exactly.
        #[serde(skip)]
        seconds: Seconds,
        /// Where the task is declared, or its delay if it has one.
        #[serde(skip)]
        src: Option<(usize, Src)>,
    },
    /// A codel that works on a copy of what it shares with another one, so that neither waits for the other.
    Lock {
        /// The one that takes the copy: `component.owner.state`
        codel: String,
        /// The other one.
        other: String,
        /// What both use, in words. The copy separates the codel from all others with which it shares nothing
        /// else.
        through: Vec<String>,
    },
    /// The number of cores.
    Cores {
        /// So many there are.
        now: u32,
        /// So many are enough.
        needed: u32,
    },
    /// The order in which cores are given.
    Policy {
        /// The one there is.
        #[serde(serialize_with = "by_name")]
        now: Policy,
        /// The one with which it holds.
        #[serde(serialize_with = "by_name")]
        needed: Policy,
    },
}

fn by_name<S: serde::Serializer>(policy: &Policy, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(policy.name())
}

impl Change {
    /// How much it is: what leaves all work as it is goes first, then times by the part of them that changes,
    /// then what takes another design of codels, last what takes another computer.
    pub fn size(&self) -> (u8, f64) {
        let part = |now: f64, needed: f64| (needed - now).abs() / now.max(f64::MIN_POSITIVE);
        match self {
            Change::Policy { .. } => (0, 0.0),
            Change::Delay { now, needed, .. } => (0, needed - now),
            Change::Wcet { now, at_most, .. } => (1, part(*now, *at_most)),
            Change::Period { now, needed, .. } => (1, part(*now, *needed)),
            Change::Lock { .. } => (2, 0.0),
            Change::Cores { now, needed } => (3, f64::from(needed - now)),
        }
    }
}
