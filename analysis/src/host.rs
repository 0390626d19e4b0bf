//! The public interface of the analysis: [`AnalysisHost`] takes changes, [`Analysis`] is a snapshot that
//! answers queries.
//!
//! The host is owned by one writer. `apply` cancels the running snapshots, and waits until they are dropped:
//! never keep an idle snapshot. All paths are absolute.

mod features;

use std::{fmt, panic::AssertUnwindSafe, sync::Arc};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_syntax::{TextRange, line_index::LineIndex};
use rustc_hash::FxHashSet;
use salsa::{Database as _, Setter as _};
use smol_str::SmolStr;

use crate::language;
use crate::{
    base::{Db, FileStatus, RootDatabase, SourceFile, line_index},
    deps::{self, Dependencies, standin::StandIn},
    diagnostic::{Diagnostic, FileEdit, Fix},
    ide::{self, *},
    queries::{self, elaborated},
    release::ReleaseChoice,
    report, requirement,
    unit::{self, UnitKey},
    unit_result::unit_result,
};

pub use crate::{
    base::normalize,
    config::{Config, LintConfig, MAX_FILE_BYTES, Project},
    loader::{DirEntry, FileContent, Loader, PackageFlags},
    requirement::required_release,
    unit_result::UnitResult,
};

/// One batch of changes.
#[derive(Debug, Clone, Default)]
pub struct Change {
    /// Files: new text, or `None` to read from the loader again (closed, created, changed, deleted).
    pub files: Vec<(Utf8PathBuf, Option<String>)>,
    /// Every root: the `.gen` files of the workspace and the open files. `None` for no change.
    pub roots: Option<Vec<Utf8PathBuf>>,
    /// The document that the user is editing: headers are shown as its unit sees them.
    pub active: Option<Utf8PathBuf>,
    /// All files with a root that the user chose to show them in, and that root.
    pub chosen: Option<Vec<(Utf8PathBuf, Utf8PathBuf)>>,
    /// New settings.
    pub config: Option<Config>,
    /// True to run the package tool again.
    pub reload_packages: bool,
    /// True if queries may search for the files that include a file (see [`Analysis::index`]), which is the
    /// default. Until then a root counts only for itself.
    pub indexed: Option<bool>,
}

/// The reason why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cancelled {
    /// A change arrived: repeat the query.
    PendingWrite,
    /// Cancelled with its [`CancellationToken`].
    Local,
    /// Another thread panicked in a query that this one waited for.
    PropagatedPanic,
}

/// An answer, unless it was cancelled.
pub type Cancellable<T> = Result<T, Cancelled>;

/// Cancels one [`Analysis`] from another thread.
#[derive(Clone)]
pub struct CancellationToken(salsa::CancellationToken);

/// One input of a batch compilation.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Input {
    File(Utf8PathBuf),
    /// A text in memory; quoted includes in it are relative to the directory of `name`.
    Text {
        /// Name used in diagnostics.
        name: Utf8PathBuf,
        text: Arc<str>,
    },
}

/// Several inputs compiled as one unit, in order, as on the command line of GenoM3.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct BatchInput {
    /// In order.
    pub inputs: Vec<Input>,
    /// Searched before those of [`Config`].
    pub include_dirs: Vec<Utf8PathBuf>,
    /// Defined after those of [`Config`].
    pub defines: Vec<(SmolStr, SmolStr)>,
}

/// Owner of the database.
pub struct AnalysisHost {
    db: RootDatabase,
}

/// A snapshot: cheap to make, for use on one thread; drop it soon.
#[derive(Clone)]
pub struct Analysis {
    db: RootDatabase,
}

impl AnalysisHost {
    /// An empty database over a loader.
    pub fn new(loader: Arc<dyn Loader>) -> AnalysisHost {
        AnalysisHost { db: RootDatabase::new(loader, None) }
    }

    /// Like [`AnalysisHost::new`], with a callback that receives the events of the database.
    #[cfg(test)]
    pub(crate) fn with_events(
        loader: Arc<dyn Loader>,
        events: crate::base::EventCallback,
    ) -> AnalysisHost {
        AnalysisHost { db: RootDatabase::new(loader, Some(events)) }
    }

    /// Applies changes. Cancels the running snapshots and waits until they are dropped.
    pub fn apply(&mut self, change: Change) {
        let db = &mut self.db;
        if change.reload_packages {
            db.reload_packages();
        }
        for (path, text) in change.files {
            db.set_file(&path, text);
        }
        let workspace = db.workspace();
        if let Some(roots) = change.roots {
            let mut known = FxHashSet::default();
            let roots: Vec<Utf8PathBuf> = roots
                .iter()
                .map(|root| normalize(root))
                .filter(|root| known.insert(root.clone()))
                .collect();
            if *workspace.roots(db) != roots {
                workspace.set_roots(db).to(roots);
            }
        }
        if let Some(indexed) = change.indexed.filter(|flag| flag != workspace.indexed(db)) {
            workspace.set_indexed(db).to(indexed);
        }
        if let Some(config) = change.config {
            db.set_max_bytes(config.max_file_bytes.unwrap_or(MAX_FILE_BYTES));
            if *workspace.include_dirs(db) != config.include_dirs {
                workspace.set_include_dirs(db).to(config.include_dirs);
            }
            if *workspace.defines(db) != config.defines {
                workspace.set_defines(db).to(config.defines);
            }
            if *workspace.release(db) != config.release {
                workspace.set_release(db).to(config.release);
            }
            if *workspace.projects(db) != config.projects {
                workspace.set_projects(db).to(config.projects);
            }
            if *workspace.severities(db) != config.severities {
                workspace.set_severities(db).to(config.severities);
            }
            if *workspace.lints(db) != config.lints {
                workspace.set_lints(db).to(config.lints);
            }
        }
        if let Some(mut chosen) = change.chosen {
            for pair in &mut chosen {
                *pair = (normalize(&pair.0), normalize(&pair.1));
            }
            if *workspace.chosen(db) != chosen {
                workspace.set_chosen(db).to(chosen);
            }
        }
        if let Some(active) = change.active {
            let active = Some(normalize(&active));
            // A header does not choose the unit that shows it.
            let is_root = active.as_ref().is_some_and(|path| workspace.roots(db).contains(path))
                && active.as_ref().is_some_and(|path| {
                    let file = db.file(path);
                    unit::roots_of(db, file).first() == Some(&file)
                });
            if is_root && *workspace.active(db) != active {
                workspace.set_active(db).to(active);
            }
        }
    }

    /// Makes [`AnalysisHost::evict_cache`] evict nearly everything from now on: for a host that queries each
    /// file only once.
    pub fn keep_little(&mut self) {
        const FEW: usize = 64;
        unit::keep(&mut self.db, FEW);
        queries::keep(&mut self.db, FEW);
        report::keep(&mut self.db, FEW);
    }

    /// Evicts large results that are seldom requested again, except for the most recently requested. Cancels
    /// the running snapshots and waits until they are dropped.
    pub fn evict_cache(&mut self) {
        self.db.evict_cache();
    }

    /// The known files at or below a path, existing or not.
    pub fn known_at(&self, path: &Utf8Path) -> Vec<Utf8PathBuf> {
        self.db.known_at(path)
    }

    /// A snapshot of the present state.
    pub fn analysis(&self) -> Analysis {
        Analysis { db: self.db.clone() }
    }
}

impl CancellationToken {
    /// Makes the snapshot's running and later queries end with [`Cancelled::Local`].
    pub fn cancel(&self) {
        self.0.cancel();
    }
}

impl From<salsa::Cancelled> for Cancelled {
    fn from(cancellation: salsa::Cancelled) -> Cancelled {
        match cancellation {
            salsa::Cancelled::Local => Cancelled::Local,
            salsa::Cancelled::PropagatedPanic => Cancelled::PropagatedPanic,
            _ => Cancelled::PendingWrite,
        }
    }
}

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Cancelled::PendingWrite => "cancelled by a change",
            Cancelled::Local => "cancelled on request",
            Cancelled::PropagatedPanic => "another request failed while computing this answer",
        })
    }
}

impl std::error::Error for Cancelled {}

impl Analysis {
    /// A token that cancels this snapshot.
    pub fn cancellation_token(&self) -> CancellationToken {
        CancellationToken(self.db.cancellation_token())
    }

    fn with<T>(&self, f: impl FnOnce(&dyn Db) -> T) -> Cancellable<T> {
        // A query that unwinds leaves no memo: the database is unchanged.
        let f = AssertUnwindSafe(|| f(&self.db));
        salsa::Cancelled::catch(f).map_err(Cancelled::from)
    }

    /// Answers from the unit that serves a file.
    fn in_file<T>(
        &self,
        path: &Utf8Path,
        f: impl FnOnce(&FileView<'_>) -> T,
    ) -> Cancellable<Option<T>> {
        // A scenario of the verifier is not a specification.
        if language::is_scenario(path) {
            return Ok(None);
        }
        self.with(|db| FileView::new(db, db.file(path)).map(|view| f(&view)))
    }

    /// Text of a file in the analysis; `None` if it cannot be read.
    pub fn text(&self, path: &Utf8Path) -> Cancellable<Option<Arc<str>>> {
        self.with(|db| {
            let file = db.file(path);
            file.status(db).is_text().then(|| file.text(db).clone())
        })
    }

    /// Returns true if a file is larger than the limit.
    pub fn is_too_large(&self, path: &Utf8Path) -> Cancellable<bool> {
        self.with(|db| matches!(db.file(path).status(db), FileStatus::TooLarge(_)))
    }

    /// Returns true if a file was read from the disk and is not UTF-8: the displayed text differs from its
    /// content.
    pub fn is_not_utf8(&self, path: &Utf8Path) -> Cancellable<bool> {
        self.with(|db| *db.file(path).status(db) == FileStatus::NotUtf8)
    }

    /// Lines of a file.
    pub fn line_index(&self, path: &Utf8Path) -> Cancellable<Arc<LineIndex>> {
        self.with(|db| line_index(db, db.file(path)).clone())
    }

    /// Diagnostics of one file, from all units that contain it, by place.
    pub fn diagnostics(&self, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>> {
        self.with(|db| report::file_diagnostics(db, db.file(path)))
    }

    /// Fixes of a syntax error, found by trial: changes after which the text parses. Parses the text several
    /// hundred times. `all` are the diagnostics of the file.
    pub fn trials(&self, of: &Diagnostic, all: &[Diagnostic]) -> Cancellable<Vec<Fix>> {
        self.with(|db| report::trials(db, of, all))
    }

    /// Applies the configuration and the comments of the specifications to findings of a layer above: sets
    /// their severities, and removes disabled or allowed ones.
    pub fn adjusted(&self, diagnostics: Vec<Diagnostic>) -> Cancellable<Vec<Diagnostic>> {
        self.with(|db| report::adjust(db, diagnostics))
    }

    /// Codes of a layer above (`family`, of which `known` exist) that comments of a root allow without a
    /// finding. `found` are the findings of that layer before [`Analysis::adjusted`].
    pub fn unused_allowances(
        &self,
        root: &Utf8Path,
        family: &str,
        known: &[&str],
        found: &[Diagnostic],
    ) -> Cancellable<Vec<Diagnostic>> {
        self.with(|db| report::unused_allowances(db, root, family, known, found))
    }

    /// Returns true if the configuration switches a code off.
    pub fn is_off(&self, code: &str) -> Cancellable<bool> {
        self.with(|db| report::is_switched_off(db, code))
    }

    /// A comment, in a file that is not a specification, that allows a code without a finding.
    pub fn unused_allowance(
        code: &str,
        known: bool,
        path: &Utf8Path,
        range: std::ops::Range<usize>,
    ) -> Diagnostic {
        let kind = report::unused_allowance(code, known).into();
        let offset = crate::source_map::offset;
        let range = TextRange::new(offset(range.start), offset(range.end.max(range.start)));
        report::shown(&kind, None, None, path, range)
    }

    /// The unit that serves a file: the unit of the active document, otherwise of the first other root that
    /// includes it, otherwise its own.
    pub fn unit(&self, path: &Utf8Path) -> Cancellable<UnitResult> {
        self.with(|db| unit_result(db, unit::serving_unit(db, db.file(path))))
    }

    /// Root of the unit that serves a file (the file itself if no other file includes it).
    pub fn root_of(&self, path: &Utf8Path) -> Cancellable<Utf8PathBuf> {
        self.with(|db| unit::roots_of(db, db.file(path))[0].path(db).clone())
    }

    /// Roots of the units that contain a file, the one that serves it first.
    pub fn roots_containing(&self, path: &Utf8Path) -> Cancellable<Vec<Utf8PathBuf>> {
        self.with(|db| {
            let roots = unit::roots_of(db, db.file(path));
            roots.iter().map(|root| root.path(db).clone()).collect()
        })
    }

    /// The unit that begins with a file, as compiled by the command line, even if other files include it.
    pub fn root_unit(&self, path: &Utf8Path) -> Cancellable<UnitResult> {
        self.with(|db| unit_result(db, unit::unit_of_root(db, db.file(path))))
    }

    /// [`Analysis::root_unit`] after some edits, which do not overlap.
    pub fn edited_root_unit(&self, path: &Utf8Path, edits: &[FileEdit]) -> Cancellable<UnitResult> {
        self.with(|db| ide::speculate::edited_unit(db, db.file(path), edits))
    }

    /// Reads the includes of every root, so that later queries for including files are fast. Returns true if
    /// a root is included by another one, and so does not count for itself.
    pub fn index(&self) -> Cancellable<bool> {
        self.with(unit::index)
    }

    /// The diagnostics of [`Analysis::root_unit`] alone.
    pub fn root_diagnostics(&self, path: &Utf8Path) -> Cancellable<Arc<Vec<Diagnostic>>> {
        self.with(|db| report::unit_report(db, unit::unit_of_root(db, db.file(path))).clone())
    }

    /// Every file of the unit that begins with a file, in order of first visit.
    pub fn files_of_root(&self, path: &Utf8Path) -> Cancellable<Vec<Utf8PathBuf>> {
        self.with(|db| {
            let files = unit::files(db, unit::unit_of_root(db, db.file(path)));
            files.iter().map(|file| file.path(db).clone()).collect()
        })
    }

    /// The dependencies of the specification of a root, with the missing ones.
    pub fn dependencies(&self, path: &Utf8Path) -> Cancellable<Dependencies> {
        self.with(|db| deps::dependencies(db, db.file(path)))
    }

    /// Stand-ins for the included files of a root that are not found.
    pub fn stand_ins(&self, path: &Utf8Path) -> Cancellable<Vec<StandIn>> {
        self.with(|db| {
            let file = db.file(path);
            let needs = deps::dependencies(db, file);
            let spec = &elaborated(db, unit::unit_of_root(db, file)).spec;
            deps::standin::stand_ins(path, &needs, spec)
        })
    }

    /// The release of GenoM3 that a specification is read as.
    pub fn release(&self, path: &Utf8Path) -> Cancellable<ReleaseChoice> {
        self.with(|db| requirement::of_inputs(db, &[db.file(path)]))
    }

    /// Several inputs as one unit.
    pub fn batch(&self, input: &BatchInput) -> Cancellable<UnitResult> {
        self.with(|db| {
            let inputs = input.inputs.iter().map(|input| match input {
                Input::File(path) => db.file(path),
                Input::Text { name, text } => db.text(name, text),
            });
            let inputs: Vec<SourceFile> = inputs.collect();
            let (dirs, defines) = (input.include_dirs.clone(), input.defines.clone());
            unit_result(db, UnitKey::new(db, inputs, dirs, defines))
        })
    }

    /// The syntax tree of a file as text.
    pub fn syntax_tree(&self, path: &Utf8Path) -> Cancellable<Option<String>> {
        self.in_file(path, ide::syntax_tree::syntax_tree)
    }

    /// The declarations of a file as text, as lowering sees them.
    pub fn item_tree(&self, path: &Utf8Path) -> Cancellable<Option<String>> {
        self.in_file(path, |view| format!("{:#?}", unit::item_tree(view.db, view.key)))
    }
}
