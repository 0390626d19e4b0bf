//! A change, as data.

use dotgen_analysis::model::{Seconds, Src};
use serde::Serialize;

use crate::scn::ast::Policy;
use crate::system::CodelName;

/// A single change, with everything else unchanged. Times are in the unit of the report; those skipped in
/// JSON are in seconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "change", rename_all = "kebab-case")]
pub enum Change {
    /// The execution time of a codel.
    Wcet {
        codel: CodelName,
        /// Present longest execution time.
        now: f64,
        /// Longest execution time with which the checks hold.
        #[serde(rename = "at-most")]
        at_most: f64,
        /// Exact value of `at_most`, in seconds.
        #[serde(skip)]
        seconds: Seconds,
        /// Shorter times hold as well. With fixed durations only this one was verified.
        #[serde(rename = "or-less")]
        or_less: bool,
        /// Declaration of the codel: number of the specification, and place.
        #[serde(skip)]
        src: Option<(usize, Src)>,
    },
    /// The period of a task. The checks need not hold with longer periods.
    Period {
        /// `component.task`
        task: String,
        /// Present period.
        now: f64,
        /// Period with which the checks hold.
        needed: f64,
        /// Exact value of `needed`, in seconds.
        #[serde(skip)]
        seconds: Seconds,
        /// Declaration of the period.
        #[serde(skip)]
        src: Option<(usize, Src)>,
    },
    /// The offset of a task, its `delay`.
    Delay {
        /// `component.task`
        task: String,
        /// Present offset.
        now: f64,
        /// Offset with which the checks hold.
        needed: f64,
        /// Exact value of `needed`, in seconds.
        #[serde(skip)]
        seconds: Seconds,
        /// Declaration of the delay, or else of the task.
        #[serde(skip)]
        src: Option<(usize, Src)>,
    },
    /// A codel that works on a copy of the data it shares with another codel, so that neither waits for the
    /// other.
    Lock {
        /// Codel that takes the copy.
        codel: CodelName,
        other: CodelName,
        /// Data and ports that both use, in words. The copy separates the codel from all other codels with
        /// which it shares nothing else.
        through: Vec<String>,
    },
    /// The number of cores.
    Cores {
        /// Present number of cores.
        now: u32,
        /// Sufficient number of cores.
        needed: u32,
    },
    /// The order in which cores are granted.
    Policy {
        /// Present policy.
        now: Policy,
        /// Policy with which the checks hold.
        needed: Policy,
    },
}

impl Change {
    /// Returns the size of the change, for sorting: first changes without an effect on the work, then times
    /// by their relative change, then changes of the design of codels, last changes of the computer.
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
