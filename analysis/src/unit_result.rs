//! All that is known about one unit, as those outside of analysis hold it.

use std::sync::Arc;

use camino::Utf8PathBuf;
use rustc_hash::FxHashSet;
use smol_str::SmolStr;

use crate::{
    base::Db,
    codes,
    diagnostic::{Diagnostic, Severity},
    model::Spec,
    queries::elaborated,
    report,
    source_map::UnitLocations,
    unit::{self, UnitKey},
};

/// Everything known about one translation unit. Independent of the snapshot it came from.
#[derive(Clone)]
pub struct UnitResult {
    /// The resolved model.
    pub spec: Arc<Spec>,
    /// Diagnostics of all its files, by file and place.
    pub diagnostics: Arc<Vec<Diagnostic>>,
    /// Every file it read, in order of first visit.
    pub files: Vec<Utf8PathBuf>,
    /// From ids to places.
    pub locations: Arc<UnitLocations>,
    /// Every word of its files, if it has errors: a declaration may be lost in what was not understood.
    pub words: Arc<FxHashSet<SmolStr>>,
    /// Whether a file ends where an error is: what was to follow is not there.
    pub is_cut: bool,
}

impl UnitResult {
    /// Whether GenoM3 would accept it: it has no error.
    pub fn accepted(&self) -> bool {
        !self
            .diagnostics
            .iter()
            .any(|it| it.severity == Severity::Error)
    }

    /// Whether its text has errors: what is missing on this machine is none.
    pub fn has_errors_in_text(&self) -> bool {
        let mut all = self.diagnostics.iter();
        all.any(|it| it.severity == Severity::Error && !codes::is_environment(it.code))
    }

    /// Whether some text in it was not understood.
    pub fn has_syntax_errors(&self) -> bool {
        let mut errors = self
            .diagnostics
            .iter()
            .filter(|it| it.severity == Severity::Error);
        errors.any(|it| {
            dotgen_syntax::codes::find(it.code).is_some() && !codes::is_environment(it.code)
        })
    }

    /// Whether this machine lacks files or packages that it needs.
    pub fn lacks_files(&self) -> bool {
        self.diagnostics
            .iter()
            .any(|it| codes::is_environment(it.code))
    }
}

/// What is known about a unit now.
pub(crate) fn unit_result<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> UnitResult {
    let diagnostics = report::unit_report(db, unit).clone();
    let rejected = diagnostics.iter().any(|it| it.severity == Severity::Error);
    let words = unit::files(db, unit).into_iter().filter(|_| rejected);
    let words = words.flat_map(|it| unit::mentioned(db, it).words.iter().cloned());
    let is_cut = unit::files(db, unit).into_iter().any(|file| {
        let errors = diagnostics
            .iter()
            .filter(|it| it.severity == Severity::Error);
        let mut here = errors.filter(|it| it.path == *file.path(db));
        let end = file.text(db).trim_end().len();
        here.any(|it| dotgen_syntax::codes::find(it.code).is_some() && it.range.end >= end)
    });
    UnitResult {
        is_cut,
        words: Arc::new(words.collect()),
        spec: elaborated(db, unit).spec.clone(),
        diagnostics,
        files: unit::files(db, unit)
            .iter()
            .map(|it| it.path(db).clone())
            .collect(),
        locations: Arc::new(UnitLocations::new(db, unit)),
    }
}
