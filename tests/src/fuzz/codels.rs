//! Sources of codels.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{AnalysisHost, FileContent, Loader, PackageFlags};
use dotgen_codegen::codels::command::{self, Project, SyncOptions};
use dotgen_codegen::codels::files::{Files, FilesConfig};
use dotgen_codegen::codels::stub::StubOptions;
use dotgen_syntax::encoding;

/// The specification that the sources belong to.
const SPECIFICATION: &str = include_str!("../../../examples/drift/tank.gen");

/// A folder in memory: the specification and one source.
#[derive(Clone)]
struct Memory(Arc<BTreeMap<Utf8PathBuf, Arc<str>>>);

impl Loader for Memory {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match self.0.get(path) {
            Some(text) => FileContent::Text(text.to_string()),
            None => FileContent::Missing,
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

impl Files for Memory {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        self.0.get(path).cloned()
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        let below = |path: &Utf8PathBuf| path.strip_prefix(folder).ok().map(Utf8Path::to_owned);
        let files: Vec<_> = self.0.keys().filter_map(below).collect();
        (!files.is_empty()).then_some(files)
    }
}

/// Compares an input with the specification, then repairs what can be repaired; the repaired text is compared
/// again.
pub(super) fn compare(input: &[u8]) {
    let root = Utf8PathBuf::from("/tank.gen");
    let texts = BTreeMap::from([
        (root.clone(), Arc::from(SPECIFICATION)),
        ("/codels/tank_codels.c".into(), Arc::from(&*encoding::decode(input.to_vec()))),
    ]);
    let memory = Memory(Arc::new(texts));
    let mut host = AnalysisHost::new(Arc::new(memory.clone()));
    let config = FilesConfig::default();
    let mut project = Project::new(&mut host, &memory, config, StubOptions::default());
    let before = command::check(&mut project, std::slice::from_ref(&root));
    let options = SyncOptions::default();
    let report = command::sync(&mut project, std::slice::from_ref(&root), &options);
    let after = command::check(&mut project, &[root]);
    drop((before, report, after));
}
