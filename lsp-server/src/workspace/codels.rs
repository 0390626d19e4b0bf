//! What is known of the C and C++ sources of codels, from snapshot to snapshot, and which files are such
//! sources by their name and place.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Analysis, Cancellable, UnitResult};
use dotgen_codegen::codels::drift::Drift;
use dotgen_codegen::codels::files::{FilesConfig, Indexes};
use dotgen_codegen::codels::folder::Folder;
use rustc_hash::FxHashMap;

/// What is known of sources, shared by all snapshots.
#[derive(Default)]
pub(crate) struct Cache {
    pub(crate) indexes: Mutex<Indexes>,
    /// By root of the unit.
    pub(crate) compared: Mutex<FxHashMap<Utf8PathBuf, Arc<Compared>>>,
    /// By root of the unit: what it was when it last had no syntax error. Serves while somebody types.
    pub(crate) good: Mutex<FxHashMap<Utf8PathBuf, Good>>,
}

/// A unit without syntax errors, and the texts that it was read from.
#[derive(Clone)]
pub(crate) struct Good {
    pub(crate) unit: UnitResult,
    pub(crate) texts: Arc<BTreeMap<Utf8PathBuf, Arc<str>>>,
}

/// The folders of a unit, compared.
pub(crate) struct Compared {
    /// Revision of the snapshot that looked last.
    pub(crate) revision: u64,
    /// Folders with what differs there, before configuration and comments are looked at.
    pub(crate) folders: Vec<(Folder, Vec<Drift>)>,
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether a document holds C or C++, by what its client calls it and by its name. A header belongs
/// to a specification unless its client says otherwise.
pub(crate) fn is_code(path: &Utf8Path, language: Option<&str>) -> bool {
    let languages = [
        "c",
        "cpp",
        "c++",
        "cuda-cpp",
        "objective-c",
        "objective-cpp",
    ];
    matches!(path.extension(), Some("c" | "cc" | "cpp" | "cxx"))
        || language.is_some_and(|it| languages.contains(&it))
}

/// Whether a file is a header by its name.
pub(crate) fn is_header(path: &Utf8Path) -> bool {
    matches!(path.extension(), Some("h" | "hh" | "hpp" | "hxx"))
}

/// The folder whose specifications have the codels of a source, if the source is in a folder of
/// codels.
pub(crate) fn home(config: &FilesConfig, source: &Utf8Path) -> Option<Utf8PathBuf> {
    let mut folders = source.ancestors().skip(1);
    folders.find_map(|inner| {
        let mut outers = inner.ancestors();
        // A specification is never below its codels, nor far above them.
        outers
            .by_ref()
            .take(config.folder.components().count() + 1)
            .find(|outer| config.folder_of(&outer.join("_.gen")) == inner)
            .map(Utf8Path::to_owned)
    })
}

impl Compared {
    /// The folders.
    pub(crate) fn folders(&self) -> impl Iterator<Item = &Folder> {
        self.folders.iter().map(|it| &it.0)
    }

    /// Folders with their findings as configuration and comments want them.
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
            let config = FilesConfig {
                folder: folder.into(),
                ..FilesConfig::default()
            };
            super::home(&config, source.into()).map(Utf8PathBuf::into_string)
        };
        assert_eq!(home("codels", "/a/codels/x.c").as_deref(), Some("/a"));
        assert_eq!(home("codels", "/a/codels/sub/x.c").as_deref(), Some("/a"));
        assert_eq!(
            home("src/codels", "/a/src/codels/x.c").as_deref(),
            Some("/a")
        );
        assert_eq!(home("codels", "/a/other/x.c"), None);
        assert_eq!(home(".", "/a/x.c").as_deref(), Some("/a"));
    }
}
