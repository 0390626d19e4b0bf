//! Deviations of a log from the model.

use crate::matching::Mismatch;

#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Deviation {
    /// Line of the log that shows it.
    pub line: u64,
    /// Beginning of the codel of that line, in nanoseconds.
    pub at: i64,
    /// Codel or task.
    pub of: String,
    /// Kind and details.
    #[serde(flatten)]
    pub what: DeviationKind,
    /// Violated rule of the model: see [`DeviationKind::rule`].
    pub rule: &'static str,
}

/// The kind and details of a deviation. Times are in nanoseconds.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum DeviationKind {
    /// The specifications have no such codel.
    Unknown { task: String, service: String, function: String, from: String, why: Mismatch },
    /// The codel took a transition that the specification does not declare.
    Transition { from: String, to: String },
    /// The codel was executed in a state that does not follow from the previous one.
    Elsewhere { state: String, awaited: Option<String> },
    /// The codel took longer than its greatest time.
    Longer { took: i64, limit: i64 },
    /// The codel took less than its least time.
    Shorter { took: i64, limit: i64 },
    /// The codel was executed together with a codel that excludes it.
    Together { other: String },
    /// The codel got its locks before a codel that had asked earlier.
    Overtaken { other: String },
    /// The task executed another codel at the same time.
    SameTask { other: String },
    /// The one core of both tasks executed another codel at the same time.
    SameCore { other: String, core: u32 },
    /// More codels were executed at the same time than there are cores.
    Cores { executing: usize, cores: u32 },
    /// A turn came before its possible ticks.
    Early { by: i64, period: i64 },
    /// A turn came later than its tick and its response time allow.
    Late { by: i64, period: i64 },
    /// A response time exceeds its bound.
    Response { response: i64, bound: i64 },
    /// A check of the scenario is violated.
    Check,
}

impl DeviationKind {
    /// Returns the name of the kind in counts.
    pub fn kind(&self) -> &'static str {
        match self {
            DeviationKind::Unknown { .. } => "unknown",
            DeviationKind::Transition { .. } => "transition",
            DeviationKind::Elsewhere { .. } => "elsewhere",
            DeviationKind::Longer { .. } => "longer",
            DeviationKind::Shorter { .. } => "shorter",
            DeviationKind::Together { .. } => "together",
            DeviationKind::Overtaken { .. } => "overtaken",
            DeviationKind::SameTask { .. } => "same-task",
            DeviationKind::SameCore { .. } => "same-core",
            DeviationKind::Cores { .. } => "cores",
            DeviationKind::Early { .. } => "early",
            DeviationKind::Late { .. } => "late",
            DeviationKind::Response { .. } => "response",
            DeviationKind::Check => "check",
        }
    }

    /// Returns the violated rule of the model.
    pub fn rule(&self) -> &'static str {
        match self {
            DeviationKind::Unknown { .. } => "only codels of the specification are executed",
            DeviationKind::Transition { .. } => "a codel leads to one of its yields",
            DeviationKind::Elsewhere { .. } => "a state follows the one that led to it",
            DeviationKind::Longer { .. } | DeviationKind::Shorter { .. } => {
                "a codel takes a time that is declared"
            }
            DeviationKind::Together { .. } => "codels that share something exclude each other",
            DeviationKind::Overtaken { .. } => {
                "locks are given in the order in which they are asked for"
            }
            DeviationKind::SameTask { .. } => "a task executes one codel after the other",
            DeviationKind::SameCore { .. } | DeviationKind::Cores { .. } => {
                "a core executes one codel at a time"
            }
            DeviationKind::Early { .. } | DeviationKind::Late { .. } => {
                "ticks are one period apart"
            }
            DeviationKind::Response { .. } => "a response time has its proved bound",
            DeviationKind::Check => "a check of the scenario",
        }
    }
}
