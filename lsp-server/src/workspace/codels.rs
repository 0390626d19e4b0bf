//! Stored results about the C and C++ sources of codels, shared from snapshot to snapshot, and the rules that
//! recognize such sources by name and place.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Analysis, AnalysisHost, Cancellable, UnitResult};
use dotgen_analysis::language::Language;
use dotgen_codegen::codels::command::judge::Known;
use dotgen_codegen::codels::drift::Drift;
use dotgen_codegen::codels::files::{FilesConfig, Indexes};
use dotgen_codegen::codels::folder::Folder;
use rustc_hash::FxHashMap;

use crate::config::Config;

/// The results of comparisons, shared by all snapshots.
#[derive(Default)]
pub(crate) struct Cache {
    pub(crate) indexes: Arc<Mutex<Indexes>>,
    /// The last workshop; `None` while a request has it.
    pub(crate) workshop: Mutex<Option<Workshop>>,
    /// The comparisons, by root of the unit.
    pub(crate) compared: Mutex<FxHashMap<Utf8PathBuf, Arc<ComparedFolders>>>,
    /// The last state of a unit without syntax errors, by root. Used while the user types.
    pub(crate) good: Mutex<FxHashMap<Utf8PathBuf, ValidUnit>>,
}

/// A separate database for work that tries changes, with the texts of a revision.
pub(crate) struct Workshop {
    pub(crate) host: AnalysisHost,
    /// What was found about the edits of the revision.
    pub(crate) known: Known,
    pub(crate) revision: u64,
    pub(crate) config: Arc<Config>,
    pub(crate) roots: Arc<Vec<Utf8PathBuf>>,
}

/// A unit without syntax errors, and its texts.
#[derive(Clone)]
pub(crate) struct ValidUnit {
    pub(crate) unit: UnitResult,
    pub(crate) texts: Arc<BTreeMap<Utf8PathBuf, Arc<str>>>,
}

/// The folders of a unit, compared.
pub(crate) struct ComparedFolders {
    /// Revision of the last snapshot that compared.
    pub(crate) revision: u64,
    /// Folders with their differences, before configuration and comments are applied.
    pub(crate) folders: Vec<(Folder, Vec<Drift>)>,
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// True if a document is C or C++, by the language id of its client and by its name. A header belongs to a
/// specification unless the language id is C or C++.
pub(crate) fn is_code(path: &Utf8Path, language: Option<&str>) -> bool {
    let languages = ["c", "cpp", "c++", "cuda-cpp", "objective-c", "objective-cpp"];
    Language::of(path) == Some(Language::Codel)
        || language.is_some_and(|language| languages.contains(&language))
}

/// The folder of the specifications to which a source belongs, if the source is in a folder of codels.
pub(crate) fn home(config: &FilesConfig, source: &Utf8Path) -> Option<Utf8PathBuf> {
    let mut folders = source.ancestors().skip(1);
    folders.find_map(|inner| {
        let mut outers = inner.ancestors();
        // A specification is never in a folder below its codels, and at most a few folders above them.
        outers
            .by_ref()
            .take(config.folder.components().count() + 1)
            .find(|outer| config.folder_of(&outer.join("_.gen")) == inner)
            .map(Utf8Path::to_owned)
    })
}

impl ComparedFolders {
    pub(crate) fn folders(&self) -> impl Iterator<Item = &Folder> {
        self.folders.iter().map(|folder| &folder.0)
    }

    /// Folders with their findings, after configuration and comments are applied.
    pub(crate) fn findings<'a>(
        &'a self,
        analysis: &'a Analysis,
    ) -> impl Iterator<Item = Cancellable<(&'a Folder, Vec<Drift>)>> {
        self.folders.iter().map(|(folder, findings)| {
            let findings = folder.adjust(findings.clone(), analysis)?;
            Ok((folder, findings))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_home_of_a_source_is_where_its_specification_is() {
        let home = |folder: &str, source: &str| {
            let config = FilesConfig { folder: folder.into(), ..FilesConfig::default() };
            super::home(&config, source.into()).map(Utf8PathBuf::into_string)
        };
        assert_eq!(home("codels", "/a/codels/x.c").as_deref(), Some("/a"));
        assert_eq!(home("codels", "/a/codels/sub/x.c").as_deref(), Some("/a"));
        assert_eq!(home("src/codels", "/a/src/codels/x.c").as_deref(), Some("/a"));
        assert_eq!(home("codels", "/a/other/x.c"), None);
        assert_eq!(home(".", "/a/x.c").as_deref(), Some("/a"));
    }
}
