//! Deviations of a log from the model.

use crate::matching::Stray;

/// A deviation.
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
    pub what: What,
    /// Violated rule of the model: see [`What::rule`].
    pub rule: &'static str,
}

/// The kind and details of a deviation. Times are in nanoseconds.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the words of each variant say it")]
pub enum What {
    /// The specifications have no such codel.
    Unknown {
        task: String,
        service: String,
        function: String,
        from: String,
        why: Stray,
    },
    /// The codel took a transition that the specification does not declare.
    Transition { from: String, to: String },
    /// The codel was executed in a state that does not follow from the previous one.
    Elsewhere {
        state: String,
        awaited: Option<String>,
    },
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
}

impl What {
    /// Returns the name of the kind in counts.
    pub fn kind(&self) -> &'static str {
        match self {
            What::Unknown { .. } => "unknown",
            What::Transition { .. } => "transition",
            What::Elsewhere { .. } => "elsewhere",
            What::Longer { .. } => "longer",
            What::Shorter { .. } => "shorter",
            What::Together { .. } => "together",
            What::Overtaken { .. } => "overtaken",
            What::SameTask { .. } => "same-task",
            What::SameCore { .. } => "same-core",
            What::Cores { .. } => "cores",
            What::Early { .. } => "early",
            What::Late { .. } => "late",
            What::Response { .. } => "response",
        }
    }

    /// Returns the violated rule of the model.
    pub fn rule(&self) -> &'static str {
        match self {
            What::Unknown { .. } => "only codels of the specification are executed",
            What::Transition { .. } => "a codel leads to one of its yields",
            What::Elsewhere { .. } => "a state follows the one that led to it",
            What::Longer { .. } | What::Shorter { .. } => "a codel takes a time that is declared",
            What::Together { .. } => "codels that share something exclude each other",
            What::Overtaken { .. } => "locks are given in the order in which they are asked for",
            What::SameTask { .. } => "a task executes one codel after the other",
            What::SameCore { .. } | What::Cores { .. } => "a core executes one codel at a time",
            What::Early { .. } | What::Late { .. } => "ticks are one period apart",
            What::Response { .. } => "a response time has its proved bound",
        }
    }
}
