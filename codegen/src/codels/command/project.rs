//! The specifications and sources of a command.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, Fix};
use dotgen_analysis::host::{AnalysisHost, Change};
use dotgen_analysis::model::Name;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::codels::{
    drift::Drift,
    expected::Expected,
    files::{Files, FilesConfig, Indexes, ModificationTime, Sources},
    folder::{self, Folder},
    repair::Repairs,
    stub::StubOptions,
};
use crate::template::notice;

/// A host, the folders of codels, and texts that replace those of files. Each file is read once, by the
/// host, and each folder is listed once.
pub struct Project<'a> {
    host: &'a mut AnalysisHost,
    files: &'a dyn Files,
    config: FilesConfig,
    stubs: StubOptions,
    /// The texts that were replaced, by path; `None` if there was no file.
    replaced: BTreeMap<Utf8PathBuf, Option<Arc<str>>>,
    listings: RefCell<FxHashMap<Utf8PathBuf, Option<Vec<Utf8PathBuf>>>>,
    unlisted: RefCell<FxHashMap<Utf8PathBuf, Vec<String>>>,
    indexes: Arc<Mutex<Indexes>>,
}

impl<'a> Project<'a> {
    /// A project over a configured host (include directories, definitions).
    pub fn new(
        host: &'a mut AnalysisHost,
        files: &'a dyn Files,
        config: FilesConfig,
        stubs: StubOptions,
    ) -> Project<'a> {
        Project {
            host,
            files,
            config,
            stubs,
            replaced: BTreeMap::new(),
            listings: RefCell::default(),
            unlisted: RefCell::default(),
            indexes: Arc::default(),
        }
    }

    /// The project with indexes of sources that it shares with others.
    pub fn sharing(self, indexes: Arc<Mutex<Indexes>>) -> Project<'a> {
        Project { indexes, ..self }
    }

    /// Puts a text in place of a file.
    pub fn overlay(&mut self, path: Utf8PathBuf, text: String) {
        if !self.replaced.contains_key(&path) {
            self.replaced.insert(path.clone(), self.text(&path));
        }
        self.host.apply(Change { files: vec![(path, Some(text))], ..Change::default() });
    }

    /// Restores the text before [`Project::overlay`]; `None` if there was no file.
    pub fn restore(&mut self, path: Utf8PathBuf, text: Option<String>) {
        if self.replaced.get(&path).is_some_and(|before| before.as_deref() == text.as_deref()) {
            self.replaced.remove(&path);
        }
        self.host.apply(Change { files: vec![(path, text)], ..Change::default() });
    }

    /// Findings of the specifications of some roots, and of the files they include.
    pub fn diagnostics(&self, roots: &[Utf8PathBuf]) -> Vec<Diagnostic> {
        let analysis = self.host.analysis();
        let reports = roots.iter().map(|root| analysis.root_diagnostics(root));
        let found = reports.flatten().flat_map(|report| report.to_vec());
        let mut seen = FxHashSet::default();
        found
            .filter(|report| !self.refutes(report))
            .filter(|report| {
                seen.insert((
                    report.path.clone(),
                    report.range.clone(),
                    report.code,
                    report.message.clone(),
                ))
            })
            .collect()
    }

    /// True if the sources of a specification disprove a finding about it: see [`folder::is_refuted`].
    pub fn refutes(&self, finding: &Diagnostic) -> bool {
        finding.code == folder::NEVER_THROWN
            && self.text(&finding.path).is_some_and(|text| {
                folder::is_refuted(finding, &text, &self.sources(&finding.path))
            })
    }

    /// See [`Analysis::trials`](dotgen_analysis::host::Analysis::trials).
    pub fn trials(&self, of: &Diagnostic, all: &[Diagnostic]) -> Vec<Fix> {
        // Nothing cancels: no other thread uses the host.
        self.host.analysis().trials(of, all).unwrap_or_default()
    }

    /// Roots whose units contain a file.
    pub fn roots_of(&self, path: &Utf8Path) -> Vec<Utf8PathBuf> {
        let roots = self.host.analysis().roots_containing(path);
        roots.unwrap_or_default()
    }

    /// Present text of a file.
    pub fn text(&self, path: &Utf8Path) -> Option<Arc<str>> {
        // Nothing cancels: no other thread uses the host.
        self.host.analysis().text(path).unwrap_or_default()
    }

    /// Text of a file before all changes.
    pub(crate) fn text_before(&self, path: &Utf8Path) -> Option<Arc<str>> {
        self.replaced.get(path).cloned().unwrap_or_else(|| self.text(path))
    }

    /// The folders of codels of all components that the roots and their included files declare.
    pub fn folders(&mut self, roots: &[Utf8PathBuf], errors: &mut Vec<String>) -> Vec<Folder> {
        let mut out: Vec<Folder> = Vec::new();
        let mut seen: FxHashSet<(Utf8PathBuf, Name)> = FxHashSet::default();
        for root in roots {
            let unit = match self.host.analysis().root_unit(root) {
                Ok(unit) => unit,
                Err(reason) => {
                    errors.push(format!("{root}: {reason}"));
                    continue;
                }
            };
            if self.text(root).is_none() {
                errors.push(format!("{root}: cannot read the file"));
                continue;
            }
            for mut folder in folder::folders(&unit, &mut |path| self.sources(path)) {
                for error in &folder.sources.unreadable {
                    if !errors.contains(error) {
                        errors.push(error.clone());
                    }
                }
                let specification = folder.specification.clone();
                folder.retain(|name| seen.insert((specification.clone(), name.clone())));
                if !folder.components.is_empty() {
                    out.push(folder);
                }
            }
        }
        folder::share_names(&mut out);
        out
    }

    /// True if the text of a specification has errors, so that it cannot be compared completely.
    pub fn has_errors_in_text(&self, root: &Utf8Path) -> bool {
        let unit = self.host.analysis().root_unit(root);
        unit.is_ok_and(|unit| unit.has_errors_in_text())
    }

    fn sources(&self, specification: &Utf8Path) -> Sources {
        let mut index = |path: Utf8PathBuf, text: Arc<str>, cxx| {
            let mut indexes = self.indexes.lock().unwrap_or_else(PoisonError::into_inner);
            indexes.get(path, text, cxx)
        };
        Sources::load_with(specification, &self.config, self, &mut index)
    }

    /// The differences in a folder, after configuration and comments are applied.
    pub fn findings(&self, folder: &Folder, all: &[Expected<'_>]) -> Vec<Drift> {
        self.adjusted(folder, folder.check(all))
    }

    /// Differences of a folder, after configuration and comments are applied.
    pub fn adjusted(&self, folder: &Folder, found: Vec<Drift>) -> Vec<Drift> {
        // Nothing cancels: no other thread uses the host.
        let adjusted = folder.adjust(found, &self.host.analysis());
        adjusted.unwrap_or_default()
    }

    /// Comments on both sides that allow findings which do not occur.
    pub fn unused_allowances(&self, compared: &[(Folder, Vec<Drift>)]) -> Vec<Diagnostic> {
        let compared: Vec<_> = compared.iter().map(|(folder, found)| (folder, &**found)).collect();
        folder::unused_allowances(&compared, &self.host.analysis()).unwrap_or_default()
    }

    /// The options for stubs of a specification: with its notice.
    pub fn stub_options(&self, specification: &Utf8Path) -> StubOptions {
        let text = self.text(specification);
        StubOptions {
            notice: self.stubs.notice.clone().or_else(|| notice(text.as_deref()?)),
            ..self.stubs.clone()
        }
    }

    /// The repairs of one component of a folder.
    pub fn repairs<'r>(
        &'r self,
        folder: &'r Folder,
        expected: &'r Expected<'r>,
        stubs: &'r StubOptions,
    ) -> Repairs<'r> {
        Repairs {
            expected,
            sources: &folder.sources,
            locations: &*folder.unit.locations,
            text: self,
            stubs,
        }
    }
}

impl Files for Project<'_> {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        self.text(path)
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        let below = self.replaced.keys().filter_map(|key| key.strip_prefix(folder).ok());
        let below: Vec<Utf8PathBuf> = below.map(Utf8Path::to_owned).collect();
        let mut listings = self.listings.borrow_mut();
        let listing = listings.entry(folder.to_owned());
        match listing.or_insert_with(|| self.files.list(folder)).clone() {
            Some(mut listing) => {
                listing.extend(below);
                Some(listing)
            }
            None => (!below.is_empty()).then_some(below),
        }
    }

    fn unlisted(&self, folder: &Utf8Path) -> Vec<String> {
        let mut unlisted = self.unlisted.borrow_mut();
        unlisted.entry(folder.to_owned()).or_insert_with(|| self.files.unlisted(folder)).clone()
    }

    fn changed(&self, path: &Utf8Path) -> Option<ModificationTime> {
        self.files.changed(path)
    }
}
