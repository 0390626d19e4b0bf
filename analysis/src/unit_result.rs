//! All results for one unit, in a form independent of the database.

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

/// All results for one translation unit. Independent of its snapshot.
#[derive(Clone)]
pub struct UnitResult {
    /// The resolved model.
    pub spec: Arc<Spec>,
    /// Diagnostics of all its files, by file and place.
    pub diagnostics: Arc<Vec<Diagnostic>>,
    /// Every file it read, in order of first visit.
    pub files: Vec<Utf8PathBuf>,
    /// Maps ids to places.
    pub locations: Arc<UnitLocations>,
    /// Every word of its files, if it has errors: a declaration may be lost in text that does not parse.
    pub words: Arc<FxHashSet<SmolStr>>,
    /// True if a file ends at an error: the text that should follow is missing.
    pub is_cut: bool,
}

impl UnitResult {
    /// Returns true if GenoM3 would accept it: it has no error.
    pub fn accepted(&self) -> bool {
        !self.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Returns the errors of its text: files missing on this machine are not errors of the text.
    pub fn errors_in_text(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|diagnostic| {
            diagnostic.severity == Severity::Error && !codes::is_environment(diagnostic.code)
        })
    }

    /// Returns true if its text has [errors](Self::errors_in_text).
    pub fn has_errors_in_text(&self) -> bool {
        self.errors_in_text().next().is_some()
    }

    /// Returns true if some of its text does not parse.
    pub fn has_syntax_errors(&self) -> bool {
        let mut errors =
            self.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
        errors.any(|error| {
            dotgen_syntax::codes::find(error.code).is_some() && !codes::is_environment(error.code)
        })
    }

    /// Returns true if it needs files or packages that are missing on this machine.
    pub fn lacks_files(&self) -> bool {
        self.diagnostics.iter().any(|diagnostic| codes::is_environment(diagnostic.code))
    }
}

/// The present results for a unit.
pub(crate) fn unit_result<'db>(db: &'db dyn Db, unit: UnitKey<'db>) -> UnitResult {
    let diagnostics = report::unit_report(db, unit).clone();
    let rejected = diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error);
    let words = unit::files(db, unit).into_iter().filter(|_| rejected);
    let words = words.flat_map(|file| unit::mentioned(db, file).words.iter().cloned());
    let is_cut = unit::files(db, unit).into_iter().any(|file| {
        let errors = diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
        let mut here = errors.filter(|error| error.path == *file.path(db));
        let end = file.text(db).trim_end().len();
        here.any(|error| dotgen_syntax::codes::find(error.code).is_some() && error.range.end >= end)
    });
    UnitResult {
        is_cut,
        words: Arc::new(words.collect()),
        spec: elaborated(db, unit).spec.clone(),
        diagnostics,
        files: unit::files(db, unit).iter().map(|file| file.path(db).clone()).collect(),
        locations: Arc::new(UnitLocations::new(db, unit)),
    }
}
