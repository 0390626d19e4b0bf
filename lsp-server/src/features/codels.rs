//! Comparison of specifications with the C and C++ sources of their codels, in a snapshot.
//!
//! A source is parsed again only when its text changes. A folder is compared again only when its
//! specification or one of its sources changes. `Cache` keeps the other results from snapshot to snapshot.
//! Texts come from analysis, so open documents count, and a pending change cancels the work between two
//! files.

pub(crate) mod actions;
pub mod headers;
pub(crate) mod judged_actions;
pub(crate) mod lenses;
pub(crate) mod navigation;
pub mod standins;

use std::cell::Cell;
use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::{Cancellable, Cancelled, FileContent, UnitResult};
use dotgen_analysis::language::Language;
use dotgen_analysis::source_map::{Location, TextMove};
use dotgen_codegen::codels::diagnostics::{Side, diagnostics};
use dotgen_codegen::codels::drift::{Drift, Repair};
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::files::{
    Files, FilesConfig, IndexedFile, ModificationTime, Sources as SourceFiles,
};
use dotgen_codegen::codels::folder::{self, Folder};
use dotgen_codegen::codels::repair::Repairs;
use dotgen_codegen::codels::stub::StubOptions;
use dotgen_codegen::template::notice;
use rustc_hash::FxHasher;

use crate::workspace::codels::{ComparedFolders, ValidUnit, lock};
use crate::workspace::snapshot::Snapshot;
use dotgen_platform::files::{history, vfs};

/// The files on the disk.
pub struct Disk;

impl Files for Disk {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        match vfs::read(path) {
            FileContent::Text(text) | FileContent::NotUtf8(text) => Some(text.into()),
            _ => None,
        }
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        folder.is_dir().then(|| {
            let files = walkdir::WalkDir::new(folder).into_iter().filter_map(Result::ok);
            files
                .filter(|file| file.file_type().is_file())
                .filter_map(|file| Utf8PathBuf::from_path_buf(file.into_path()).ok())
                .filter_map(|path| Some(path.strip_prefix(folder).ok()?.to_owned()))
                .collect()
        })
    }

    fn unlisted(&self, folder: &Utf8Path) -> Vec<String> {
        if !folder.is_dir() {
            return Vec::new();
        }
        let unreadable = vfs::files_below(folder, &[]).unreadable;
        unreadable.iter().map(ToString::to_string).collect()
    }

    fn changed(&self, path: &Utf8Path) -> Option<ModificationTime> {
        history::changed(path, true).map(ModificationTime::At)
    }
}

/// The files of a snapshot. After a cancellation every read fails.
pub(crate) struct Texts<'a> {
    snapshot: &'a Snapshot,
    cancelled: Cell<Option<Cancelled>>,
}

impl<'a> Texts<'a> {
    pub(crate) fn new(snapshot: &'a Snapshot) -> Texts<'a> {
        Texts { snapshot, cancelled: Cell::new(None) }
    }

    /// Returns true if a file is an open document.
    pub(crate) fn is_open(&self, path: &Utf8Path) -> bool {
        self.snapshot.open.contains_key(path)
    }

    /// The time at which a file on disk got its text. Without trust, no program is asked.
    pub(crate) fn changed_on_disk(&self, path: &Utf8Path) -> Option<ModificationTime> {
        let may_run = self.snapshot.config.packages.may_run;
        history::changed(path, may_run).map(ModificationTime::At)
    }

    /// Returns the cancellation, if there was one: results are then invalid.
    pub(crate) fn check(&self) -> Cancellable<()> {
        self.cancelled.get().map_or(Ok(()), Err)
    }
}

impl Files for Texts<'_> {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        if self.cancelled.get().is_some() {
            return None;
        }
        let text = self.snapshot.analysis.text(path);
        text.unwrap_or_else(|cancelled| {
            self.cancelled.set(Some(cancelled));
            None
        })
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        let open = self.snapshot.open.keys();
        let open = open.filter_map(|key| key.strip_prefix(folder).ok().map(Utf8Path::to_owned));
        let open: Vec<_> = open.collect();
        match Disk.list(folder) {
            Some(mut listing) => {
                listing.extend(open);
                Some(listing)
            }
            None => (!open.is_empty()).then_some(open),
        }
    }

    fn changed(&self, path: &Utf8Path) -> Option<ModificationTime> {
        let is_saved = || self.read(path).as_deref() == Disk.read(path).as_deref();
        if self.snapshot.open.contains_key(path) && !is_saved() {
            Some(ModificationTime::Unsaved)
        } else {
            self.changed_on_disk(path)
        }
    }
}

/// The folders of the unit that serves a specification, or of the units whose codels are in the folder of a
/// source. Empty for any other file.
pub(crate) fn around(
    snapshot: &Snapshot,
    path: &Utf8Path,
) -> Cancellable<Vec<Arc<ComparedFolders>>> {
    if !snapshot.is_code(path) {
        return Ok(vec![of_unit(snapshot, &snapshot.analysis.root_of(path)?)?]);
    }
    let mut out = Vec::new();
    for root in roots_around(snapshot, path)? {
        let compared = of_unit(snapshot, &root)?;
        if compared.folders().any(|folder| folder.sources.file(path).is_some()) {
            out.push(compared);
        }
    }
    Ok(out)
}

/// The roots of the units whose codels are in the folder of a source.
pub(crate) fn roots_around(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Utf8PathBuf>> {
    let mut roots: Vec<Utf8PathBuf> = Vec::new();
    for root in snapshot.roots.iter() {
        let config = snapshot.config.codels_of(root);
        if config.is_some_and(|config| path.starts_with(config.folder_of(root))) {
            let root = snapshot.analysis.root_of(root)?;
            if !roots.contains(&root) {
                roots.push(root);
            }
        }
    }
    Ok(roots)
}

/// The folders of the unit of a root, compared.
fn of_unit(snapshot: &Snapshot, root: &Utf8Path) -> Cancellable<Arc<ComparedFolders>> {
    let nothing = || ComparedFolders { revision: snapshot.revision, folders: Vec::new() };
    let Some(config) = snapshot.config.codels_of(root) else {
        return Ok(Arc::new(nothing()));
    };
    let known = lock(&snapshot.codels.compared).get(root).cloned();
    if let Some(known) = &known
        && known.revision == snapshot.revision
    {
        return Ok(known.clone());
    }
    let mut fresh = nothing();
    for folder in folders(snapshot, config, root)? {
        let mut before = known.iter().flat_map(|lock| &lock.folders);
        let findings = before
            .find(|other| same(&other.0, &folder))
            .map_or_else(|| differences(&folder), |folder| folder.1.clone());
        fresh.folders.push((folder, findings));
    }
    let fresh = Arc::new(fresh);
    // Without codels the result is cheap to compute again, and keeping it would keep the model.
    if fresh.folders().any(|folder| folder.sources.exists) {
        lock(&snapshot.codels.compared).insert(root.to_owned(), fresh.clone());
    } else {
        lock(&snapshot.codels.compared).remove(root);
        lock(&snapshot.codels.good).remove(root);
    }
    Ok(fresh)
}

/// The differences in a folder. A comparison with an earlier text of the specification gives no edits of the
/// present text.
fn differences(folder: &Folder) -> Vec<Drift> {
    let mut found = folder.check(&folder.expected());
    if folder.is_earlier {
        for drift in &mut found {
            drift.repairs.retain(|repair| {
                matches!(
                    repair,
                    Repair::Stub { .. }
                        | Repair::UpdateSignature { .. }
                        | Repair::RefreshComment { .. }
                        | Repair::RenameFunction { .. }
                )
            });
        }
    }
    found
}

/// The unit of a root with which codels are compared, and its texts if these are earlier ones.
fn serving(snapshot: &Snapshot, root: &Utf8Path) -> Cancellable<(UnitResult, Option<ValidUnit>)> {
    let unit = snapshot.analysis.root_unit(root)?;
    if unit.has_syntax_errors() {
        let good = lock(&snapshot.codels.good).get(root).cloned();
        return Ok(match good {
            Some(good) => (good.unit.clone(), Some(good)),
            None => (unit, None),
        });
    }
    let mut texts = BTreeMap::new();
    for path in &unit.files {
        if let Some(text) = snapshot.analysis.text(path)? {
            texts.insert(path.clone(), text);
        }
    }
    let good = ValidUnit { unit: unit.clone(), texts: Arc::new(texts) };
    lock(&snapshot.codels.good).insert(root.to_owned(), good);
    Ok((unit, None))
}

/// Adapts folders of an earlier unit to the present texts: moves places to where they are now, and removes
/// codels with changed text.
fn adapt_folders(
    snapshot: &Snapshot,
    folders: &mut [Folder],
    earlier: &ValidUnit,
) -> Cancellable<()> {
    let mut now: BTreeMap<Utf8PathBuf, Arc<str>> = BTreeMap::new();
    for path in earlier.texts.keys() {
        if let Some(text) = snapshot.analysis.text(path)? {
            now.insert(path.clone(), text);
        }
    }
    let both = |path: &Utf8Path| Some((earlier.texts.get(path)?.clone(), now.get(path)?.clone()));
    let moved: BTreeMap<&Utf8Path, TextMove> = earlier
        .texts
        .keys()
        .filter_map(|path| {
            let (old, new) = both(path)?;
            Some((path.as_path(), TextMove::between(&old, &new)?))
        })
        .collect();
    let changed = |location: &Location| {
        let moved = moved.get(location.path.as_path());
        moved.is_some_and(|moved| moved.is_within(&location.range))
    };
    let locations = Arc::new(earlier.unit.locations.moved(both));
    for folder in folders {
        let mut trust = (*folder.trust).clone();
        trust.leave_out(&earlier.unit, &changed);
        folder.trust = Arc::new(trust);
        folder.unit.locations = locations.clone();
        folder.is_earlier = true;
    }
    Ok(())
}

/// True if there can be findings about a specification and its codels: a folder of codels exists, or a
/// comment allows findings. Does not compile the specification.
fn may_have_findings(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<bool> {
    let text = snapshot.analysis.text(path)?;
    if snapshot.config.codels_of(path).is_some() && text.is_some_and(|text| text.contains("allow("))
    {
        return Ok(true);
    }
    may_have_sources(snapshot, &snapshot.analysis.root_of(path)?)
}

/// True if there is a folder of codels for a file of the unit of a root, on the disk or in the editor. Does
/// not compile the specification.
pub(crate) fn may_have_sources(snapshot: &Snapshot, root: &Utf8Path) -> Cancellable<bool> {
    let Some(config) = snapshot.config.codels_of(root) else {
        return Ok(false);
    };
    let files = snapshot.analysis.files_of_root(root)?;
    let is_there = |folder: Utf8PathBuf| {
        folder.is_dir() || snapshot.open.keys().any(|key| key.starts_with(&folder))
    };
    Ok(files.iter().any(|file| is_there(config.folder_of(file))))
}

/// The folders of a unit, without findings that the units of other roots disprove.
fn folders(snapshot: &Snapshot, config: &FilesConfig, root: &Utf8Path) -> Cancellable<Vec<Folder>> {
    let (unit, earlier) = serving(snapshot, root)?;
    let texts = Texts::new(snapshot);
    let mut index = |path: Utf8PathBuf, text: Arc<str>, cxx| -> IndexedFile {
        lock(&snapshot.codels.indexes).get(path, text, cxx)
    };
    let mut sources = |specification: &Utf8Path| {
        SourceFiles::load_with(specification, config, &texts, &mut index)
    };
    let mut found = folder::folders(&unit, &mut sources);
    if let Some(earlier) = &earlier {
        adapt_folders(snapshot, &mut found, earlier)?;
    }
    texts.check()?;
    let mut out = Vec::new();
    for mut folder in found {
        if snapshot.analysis.root_of(&folder.specification)? != root {
            continue;
        }
        // Specifications in one folder share its codels. Without sources the search for those specifications
        // is skipped.
        if !folder.sources.exists {
            out.push(folder);
            continue;
        }
        let beside = folder.specification.parent();
        for other in snapshot.roots.iter().filter(|root| root.parent() == beside) {
            for component in &snapshot.analysis.root_unit(other)?.spec.components {
                let codels = component.all_codels();
                let names = codels.map(|codel| component.codel(codel).name.clone());
                folder.also_named.extend(names);
            }
        }
        out.push(folder);
    }
    Ok(out)
}

/// True if two states of a folder have the same findings.
fn same(a: &Folder, b: &Folder) -> bool {
    a.specification == b.specification
        && Arc::ptr_eq(&a.unit.spec, &b.unit.spec)
        && a.components == b.components
        && a.trust == b.trust
        && a.is_earlier == b.is_earlier
        && a.sources.exists == b.sources.exists
        && a.sources.incomplete == b.sources.incomplete
        && a.sources.folder == b.sources.folder
        && a.sources.all().count() == b.sources.all().count()
        && std::iter::zip(a.sources.all(), b.sources.all()).all(|(a, b)| a.is(b))
        && a.also_named == b.also_named
}

/// The diagnostics of a specification or a source.
pub(crate) fn file_diagnostics(
    snapshot: &Snapshot,
    path: &Utf8Path,
) -> Cancellable<Vec<Diagnostic>> {
    let mut out: Vec<Diagnostic> = Vec::new();
    if !snapshot.is_code(path) && !may_have_findings(snapshot, path)? {
        return Ok(out);
    }
    for compared in around(snapshot, path)? {
        for found in compared.findings(&snapshot.analysis) {
            let (folder, findings) = found?;
            let all = diagnostics(&findings, &*folder.unit.locations, Side::First);
            for diagnostic in all.into_iter().filter(|diagnostic| diagnostic.path == *path) {
                if !out.contains(&diagnostic) {
                    out.push(diagnostic);
                }
            }
        }
    }
    out.extend(unused_in(snapshot, path)?);
    out.sort_by_key(|diagnostic| (diagnostic.range.start, diagnostic.range.end));
    Ok(out)
}

/// The findings about a specification that its codels do not disprove.
pub(crate) fn unrefuted_findings(
    snapshot: &Snapshot,
    path: &Utf8Path,
) -> Cancellable<Vec<Diagnostic>> {
    let mut all = snapshot.analysis.diagnostics(path)?;
    if all.iter().any(|diagnostic| diagnostic.code == folder::NEVER_THROWN)
        && let Some(text) = snapshot.analysis.text(path)?
    {
        let compared = around(snapshot, path)?;
        let folders = || compared.iter().flat_map(|folders| folders.folders());
        all.retain(|diagnostic| {
            !folders().any(|of| folder::is_refuted(diagnostic, &text, &of.sources))
        });
    }
    Ok(all)
}

/// The comments of a file that allow findings which do not occur.
pub(crate) fn unused_in(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>> {
    let mut unused = unused_allowances(snapshot, &around(snapshot, path)?)?;
    unused.retain(|allowance| allowance.path == *path);
    Ok(unused)
}

/// Diagnostics for comments that allow findings which do not occur.
fn unused_allowances(
    snapshot: &Snapshot,
    compared: &[Arc<ComparedFolders>],
) -> Cancellable<Vec<Diagnostic>> {
    let folders = compared.iter().flat_map(|folder| &folder.folders);
    let folders: Vec<_> = folders.map(|folder| (&folder.0, folder.1.as_slice())).collect();
    folder::unused_allowances(&folders, &snapshot.analysis)
}

/// The sources of the workspace that have findings.
pub(crate) fn sources_with_findings(snapshot: &Snapshot) -> Cancellable<Vec<Utf8PathBuf>> {
    let mut out = Vec::new();
    let shown =
        |path: &&Utf8PathBuf| snapshot.in_workspace(path) || snapshot.open.contains_key(*path);
    for root in snapshot.roots.iter().filter(shown) {
        let Some(config) = snapshot.config.codels_of(root) else {
            continue;
        };
        if snapshot.analysis.root_of(root)? != *root && !config.folder_of(root).is_dir() {
            continue;
        }
        if !may_have_findings(snapshot, root)? {
            continue;
        }
        for found in
            of_unit(snapshot, &snapshot.analysis.root_of(root)?)?.findings(&snapshot.analysis)
        {
            for source in found?.1.into_iter().filter_map(|drift| drift.source) {
                if !out.contains(&source.path) {
                    out.push(source.path);
                }
            }
        }
    }
    Ok(out)
}

/// A hash of the findings about specifications and open sources, without their places; 0 if there are none.
pub(crate) fn fingerprint(snapshot: &Snapshot) -> Cancellable<u64> {
    let mut hasher = FxHasher::default();
    let mut anything = false;
    let code = snapshot.open.iter().filter(|(_, open)| open.language == Language::Codel);
    for path in code.map(|(path, _)| path) {
        for (lens, _) in crate::features::codels::lenses::lenses(snapshot, path)? {
            anything = true;
            lens.hash(&mut hasher);
        }
    }
    let compared: Vec<_> = lock(&snapshot.codels.compared).values().cloned().collect();
    let (mut seen, mut seen_unused) = (Vec::new(), Vec::new());
    for found in compared.iter().flat_map(|lock| lock.findings(&snapshot.analysis)) {
        seen.extend(
            found?.1.into_iter().map(|drift| (drift.code(), drift.severity, drift.message())),
        );
    }
    for allowance in unused_allowances(snapshot, &compared)? {
        seen_unused.push((allowance.path, allowance.message));
    }
    seen_unused.sort();
    seen_unused.hash(&mut hasher);
    anything |= !seen_unused.is_empty();
    seen.sort();
    seen.hash(&mut hasher);
    anything |= !seen.is_empty();
    Ok(if anything { hasher.finish() } else { 0 })
}

/// The options for stubs in a folder: with the notice of its specification.
pub(crate) fn stub_options(folder: &Folder, texts: &Texts<'_>) -> StubOptions {
    let text = texts.read(&folder.specification);
    StubOptions {
        use_parameters: true,
        notice: text.and_then(|text| notice(&text)),
        ..StubOptions::default()
    }
}

/// The repairs of a component of a folder.
pub(crate) fn repairs<'a>(
    folder: &'a Folder,
    expected: &'a Expected<'a>,
    texts: &'a Texts<'a>,
    stubs: &'a StubOptions,
) -> Repairs<'a> {
    Repairs {
        expected,
        sources: &folder.sources,
        locations: &*folder.unit.locations,
        text: texts,
        stubs,
    }
}
