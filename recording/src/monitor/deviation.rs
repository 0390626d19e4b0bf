//! What a run does that no run of the model does.

use crate::matching::Stray;

/// A deviation.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Deviation {
    /// The line of the log at which it shows.
    pub line: u64,
    /// When the codel of that line began, in nanoseconds.
    pub at: i64,
    /// The codel, or the task.
    pub of: String,
    /// What is wrong.
    #[serde(flatten)]
    pub what: What,
    /// The rule of the model that it breaks: see [`What::rule`].
    pub rule: &'static str,
}

/// What is wrong. Times are in nanoseconds.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the words of each variant say it")]
pub enum What {
    /// The specifications have no such codel there.
    Unknown {
        task: String,
        service: String,
        function: String,
        from: String,
        why: Stray,
    },
    /// It led where the specification does not let it.
    Transition { from: String, to: String },
    /// It was executed in a state to which nothing had led.
    Elsewhere {
        state: String,
        awaited: Option<String>,
    },
    /// It took longer than it may.
    Longer { took: i64, limit: i64 },
    /// It took less time than it must.
    Shorter { took: i64, limit: i64 },
    /// It was executed together with one that excludes it.
    Together { other: String },
    /// It got its locks before one that had asked earlier.
    Overtaken { other: String },
    /// Its task executed another one at the same time.
    SameTask { other: String },
    /// The one core of both tasks executed another one at the same time.
    SameCore { other: String, core: u32 },
    /// More codels were executed than there are cores.
    Cores { executing: usize, cores: u32 },
    /// A turn came before its tick can have come.
    Early { by: i64, period: i64 },
    /// A turn came later than its tick and its response time allow.
    Late { by: i64, period: i64 },
    /// A response time beyond its bound.
    Response { response: i64, bound: i64 },
}

impl What {
    /// Its name in counts.
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

    /// The rule of the model that it breaks.
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
