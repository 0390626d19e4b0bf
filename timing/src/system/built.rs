//! What is built: a [`TimedSystem`], where it comes from, and what was assumed.

use std::collections::HashMap;

use dotgen_analysis::model::{Owner, Seconds};

use super::TimedSystem;
use crate::diagnostic::{Diagnostic, Severity};
use crate::scn::ast::Path;

/// A system, and how to find things in it.
#[derive(Debug, Clone)]
pub struct Built {
    /// The system.
    pub system: TimedSystem,
    /// Tasks by component (as in [`Names::components`](crate::scn::names::Names::components)) and index.
    pub tasks: HashMap<(usize, u32), usize>,
    /// Services likewise.
    pub services: HashMap<(usize, u32), usize>,
    /// Machines of tasks and activities.
    pub machines: HashMap<(usize, Owner), usize>,
    /// Components.
    pub components: HashMap<usize, usize>,
    /// Problems that do not prevent verification, or (with errors) do.
    pub diagnostics: Vec<Diagnostic>,
    /// What the result depends on, in words.
    pub assumptions: Vec<String>,
    /// Codels whose times are no multiples of the unit of the scenario, and were rounded.
    pub rounded: Vec<Rounded>,
    /// The coarsest unit in which nothing would have to be rounded, in seconds; none without a unit.
    pub exact_unit: Option<Seconds>,
}

/// A time of a codel that was rounded, in seconds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rounded {
    /// Path of the codel.
    pub codel: String,
    /// What is stated.
    pub exact: Seconds,
    /// What was verified instead.
    pub taken: Seconds,
}

impl Built {
    /// Whether something prevents verification.
    pub fn has_errors(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|it| it.severity == Severity::Error)
    }
}

/// What a path leads to is not what is wanted there.
pub(crate) fn not_a(what: &str, path: &Path) -> Diagnostic {
    let message = format!("`{}` is no {what}", path.text());
    Diagnostic::error("scn-wrong-kind", path.range(), message)
}
