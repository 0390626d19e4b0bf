//! Speculative compilation: the units affected by some edits are compiled again, in a separate database.
//!
//! Renaming and refactoring must not change anything else. The language has too many ways to clash and to
//! capture for a reliable list; compiling the result and comparing finds them all.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use rustc_hash::{FxHashMap, FxHashSet};

use super::resolve::elaborated_of_many;
use crate::progress::Progress;

use crate::{
    base::{Db, RootDatabase, SourceFile},
    diagnostic::{Diagnostic, FileEdit, Severity},
    elab::Elaborated,
    loader::{FileContent, Loader, PackageFlags},
    parallel,
    queries::elaborated,
    report::unit_report,
    unit::{UnitKey, files, roots_of, unit_of_root},
    unit_result::{UnitResult, unit_result},
};

/// One unit before and after.
pub(crate) struct Comparison {
    pub(crate) root: SourceFile,
    pub(crate) before: Arc<Elaborated>,
    pub(crate) after: Arc<Elaborated>,
    /// Errors that did not exist before.
    pub(crate) new_errors: Vec<Diagnostic>,
}

/// A text with edits applied; they do not overlap.
pub(crate) fn apply<'e>(text: &str, edits: impl IntoIterator<Item = &'e FileEdit>) -> String {
    let mut edits: Vec<&FileEdit> = edits.into_iter().collect();
    edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        out.push_str(text.get(at..edit.range.start).unwrap_or_default());
        out.push_str(&edit.new_text);
        at = edit.range.end.max(at);
    }
    out.push_str(text.get(at..).unwrap_or_default());
    out
}

/// Number of units that are compiled in one database, which is then dropped: they share their includes.
const BATCH: usize = 16;

/// Compiles the units of the edited files before and after, on all cores, and returns the results of
/// `differs` for each, by path of the root.
pub(crate) fn compare<R: Send>(
    db: &dyn Db,
    edits: &[FileEdit],
    differs: impl Fn(&dyn Db, &Comparison) -> Option<R> + Sync,
) -> Vec<R> {
    compare_some(db, edits, |_, _| true, differs, &Progress::default())
}

/// Like [`compare`], for the units that are `tried`, by root.
pub(crate) fn compare_some<R: Send>(
    db: &dyn Db,
    edits: &[FileEdit],
    tried: impl Fn(&dyn Db, SourceFile) -> bool + Sync,
    differs: impl Fn(&dyn Db, &Comparison) -> Option<R> + Sync,
    progress: &Progress,
) -> Vec<R> {
    let mut by_file: FxHashMap<SourceFile, Vec<&FileEdit>> = FxHashMap::default();
    for edit in edits {
        by_file.entry(db.file(&edit.path)).or_default().push(edit);
    }
    let roots: FxHashSet<SourceFile> =
        by_file.keys().flat_map(|&file| roots_of(db, file).iter().copied()).collect();
    let roots: Vec<SourceFile> = roots.into_iter().collect();
    let roots = parallel::over(db, &roots, |db, &root| tried(db, root).then_some(root));
    let mut roots: Vec<SourceFile> = roots.into_iter().flatten().collect();
    roots.sort_by_key(|root| root.path(db).clone());
    let batches: Vec<&[SourceFile]> = roots.chunks(BATCH).collect();
    progress.expect(roots.len());
    let found = parallel::over(db, &batches, |db, batch| {
        let mut texts: FxHashMap<Utf8PathBuf, String> = FxHashMap::default();
        for file in batch.iter().flat_map(|&root| files(db, unit_of_root(db, root))) {
            let edits = by_file.get(&file).into_iter().flatten().copied();
            texts.entry(file.path(db).clone()).or_insert_with(|| apply(file.text(db), edits));
        }
        let overlay = Overlay { texts, below: db.loader().clone() };
        let other = RootDatabase::with_settings_of(db, Arc::new(overlay));
        let mut found = Vec::new();
        for &root in *batch {
            db.unwind_if_revision_cancelled();
            let unit = unit_of_root(db, root);
            let there = unit_of_root(&other, other.file(root.path(db)));
            let comparison = Comparison {
                root,
                before: elaborated_of_many(db, unit, roots.len()),
                after: elaborated(&other, there).clone(),
                new_errors: new_errors(db, unit, &other, there),
            };
            found.extend(differs(db, &comparison));
            progress.step();
        }
        found
    });
    found.into_iter().flatten().collect()
}

/// The unit of a root after some edits.
pub(crate) fn edited_unit(db: &dyn Db, root: SourceFile, edits: &[FileEdit]) -> UnitResult {
    let mut texts: FxHashMap<Utf8PathBuf, String> = FxHashMap::default();
    for file in files(db, unit_of_root(db, root)) {
        let path = file.path(db);
        let here = edits.iter().filter(|edit| edit.path == *path);
        texts.insert(path.clone(), apply(file.text(db), here));
    }
    let overlay = Overlay { texts, below: db.loader().clone() };
    let other = RootDatabase::with_settings_of(db, Arc::new(overlay));
    let there = unit_of_root(&other, other.file(root.path(db)));
    unit_result(&other, there)
}

/// Errors that occur more often after the edits.
fn new_errors(
    db: &dyn Db,
    unit: UnitKey<'_>,
    other: &dyn Db,
    there: UnitKey<'_>,
) -> Vec<Diagnostic> {
    let mut known: FxHashMap<&str, usize> = FxHashMap::default();
    for report in unit_report(db, unit).iter() {
        *known.entry(report.code).or_default() += 1;
    }
    let mut out = Vec::new();
    for report in unit_report(other, there).iter() {
        match known.get_mut(report.code).filter(|left| **left > 0) {
            Some(left) => *left -= 1,
            None if report.severity == Severity::Error => out.push(report.clone()),
            None => {}
        }
    }
    out
}

/// The files of some units with their new texts.
struct Overlay {
    texts: FxHashMap<Utf8PathBuf, String>,
    below: Arc<dyn Loader>,
}

impl Loader for Overlay {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match self.texts.get(path) {
            Some(text) => FileContent::Text(text.clone()),
            None => self.below.read(path),
        }
    }

    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String> {
        self.below.packages(arguments)
    }
}
