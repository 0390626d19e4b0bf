//! A loader over the disk, small projects in memory, and the system's compilers.

use std::collections::BTreeMap;
use std::process::Command;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{
    AnalysisHost, Change, Config, FileContent, Loader, PackageFlags, UnitResult,
};
use dotgen_analysis::release::{Release, ReleaseChoice, ReleaseOrigin};
use dotgen_codegen::codels::drift::{self, Drift, DriftOptions};
use dotgen_codegen::codels::expected::Expected;
use dotgen_codegen::codels::files::{Files, FilesConfig, Sources};
use dotgen_codegen::codels::stub::NewFile;

/// The files on disk; every package is there.
pub(crate) struct Disk;

impl Loader for Disk {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match std::fs::read_to_string(path) {
            Ok(text) => FileContent::Text(text),
            Err(_) if path.is_dir() => FileContent::Directory,
            Err(_) => FileContent::Missing,
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

impl Files for Disk {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        std::fs::read_to_string(path).ok().map(Arc::from)
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        let entries = folder.read_dir_utf8().ok()?;
        let names = entries.flatten().map(|entry| entry.file_name().into());
        Some(names.collect())
    }
}

/// The root of the workspace.
pub(crate) fn workspace() -> Utf8PathBuf {
    let here = Utf8Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().expect("the crate is in a workspace").to_owned()
}

/// The shared test data with its recorded runs, if it is there.
pub(crate) fn shared() -> Option<Utf8PathBuf> {
    let manifest = dotgen_loaders::shared("golden/manifest.json")?;
    let folder = manifest.parent()?.parent()?.to_owned();
    Utf8PathBuf::from_path_buf(folder).ok()
}

pub(crate) fn host(include_dirs: Vec<Utf8PathBuf>) -> AnalysisHost {
    host_of(None, include_dirs)
}

/// A host that reads specifications as a release; `None` for what they require.
pub(crate) fn host_of(release: Option<Release>, include_dirs: Vec<Utf8PathBuf>) -> AnalysisHost {
    let mut host = AnalysisHost::new(Arc::new(Disk));
    let config = Config {
        include_dirs,
        release: release
            .map(|release| ReleaseChoice { release, origin: ReleaseOrigin::CommandLine }),
        ..Config::default()
    };
    host.apply(Change { config: Some(config), ..Change::default() });
    host
}

/// Files of a test, by absolute path.
pub(crate) struct Memory(pub(crate) BTreeMap<Utf8PathBuf, String>);

impl Loader for Memory {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match self.0.get(path) {
            Some(text) => FileContent::Text(text.clone()),
            None => FileContent::Missing,
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

impl Files for Memory {
    fn read(&self, path: &Utf8Path) -> Option<Arc<str>> {
        self.0.get(path).map(|text| text.as_str().into())
    }

    fn list(&self, folder: &Utf8Path) -> Option<Vec<Utf8PathBuf>> {
        let below = self.0.keys().filter_map(|key| key.strip_prefix(folder).ok());
        let below: Vec<Utf8PathBuf> = below.map(Utf8Path::to_owned).collect();
        (!below.is_empty()).then_some(below)
    }
}

/// A `.gen` and its codels: `/c.gen`, and files below `/codels/`.
pub(crate) struct Fixture {
    pub(crate) files: Arc<Memory>,
    pub(crate) unit: UnitResult,
    pub(crate) sources: Sources,
}

impl Fixture {
    pub(crate) fn new(specification: &str, codels: &[(&str, &str)]) -> Fixture {
        let mut files = BTreeMap::from([("/c.gen".into(), specification.to_owned())]);
        for (name, text) in codels {
            files.insert(Utf8PathBuf::from("/codels").join(name), (*text).to_owned());
        }
        let files = Arc::new(Memory(files));
        let host = AnalysisHost::new(files.clone());
        let unit = host.analysis().root_unit("/c.gen".into()).expect("nothing is cancelled");
        assert!(unit.accepted(), "{:?}", unit.diagnostics);
        let sources = Sources::load("/c.gen".into(), &FilesConfig::default(), &*files);
        Fixture { files, unit, sources }
    }

    pub(crate) fn expected(&self) -> Expected<'_> {
        Expected::new(&self.unit.spec, 0.into())
    }

    pub(crate) fn check(&self) -> Vec<Drift> {
        drift::check(&[self.expected()], &self.sources, &DriftOptions::default())
    }

    /// `code: message` of every finding.
    pub(crate) fn report(&self) -> Vec<String> {
        let all = self.check();
        all.iter().map(|check| format!("{}: {}", check.code(), check.message())).collect()
    }
}

/// A compiler of the system, if it is there.
pub(crate) fn compiler(name: &str) -> Option<&str> {
    let found = Command::new(name).arg("--version").output();
    if !found.is_ok_and(|output| output.status.success()) {
        dotgen_loaders::skip(format_args!("no `{name}` on this system"));
        return None;
    }
    Some(name)
}

pub(crate) fn write(folder: &Utf8Path, files: &[NewFile]) {
    for file in files {
        let path = folder.join(&file.path);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).expect("a temporary folder");
        }
        std::fs::write(path, &file.text).expect("a temporary file");
    }
}

/// Compiles a source with the flags of `compile_flags.txt` and `extra`; the messages on failure.
pub(crate) fn compile(
    compiler: &str,
    folder: &Utf8Path,
    source: &Utf8Path,
    extra: &[&str],
) -> Result<(), String> {
    let flags = std::fs::read_to_string(folder.join("compile_flags.txt")).expect("flags");
    let output = Command::new(compiler)
        .args(["-fsyntax-only", "-Wall", "-Wextra", "-Werror"])
        .args(extra)
        .args(flags.lines())
        .arg(source)
        .output()
        .expect("the compiler runs");
    if output.status.success() {
        Ok(())
    } else {
        Err(format!("{source}:\n{}", String::from_utf8_lossy(&output.stderr)))
    }
}

pub(crate) fn temporary() -> (tempfile::TempDir, Utf8PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = Utf8PathBuf::from_path_buf(folder.path().to_owned()).expect("UTF-8");
    (folder, path)
}
