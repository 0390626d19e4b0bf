//! Common mistakes, seeded into real components: each gives one error on its line, and the first fix restores
//! the text. Fixes must never make a text worse.
//!
//! `MISTAKES=report cargo test -p dotgen-analysis --test suite mistakes -- --nocapture` prints each of them
//! and the numbers in `docs/fixes.md`.

mod complete;
mod mutate;
mod prefix;
mod seed;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::{
    diagnostic::{Diagnostic, Fix, Severity},
    host::{AnalysisHost, BatchInput, DirEntry, FileContent, Input, Loader, PackageFlags},
};

/// The disk, with one text in the place of a file; packages are in a few folders.
struct Overlay {
    path: Utf8PathBuf,
    text: String,
    packages: Vec<Utf8PathBuf>,
}

impl Loader for Overlay {
    fn read(&self, path: &Utf8Path) -> FileContent {
        if *path == self.path {
            return FileContent::Text(self.text.clone());
        }
        match std::fs::read_to_string(path) {
            Ok(text) => FileContent::Text(text),
            Err(_) => FileContent::Missing,
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags { include_dirs: self.packages.clone(), ..PackageFlags::default() })
    }

    fn list_dir(&self, path: &Utf8Path) -> Vec<DirEntry> {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        let entry = |entry: std::fs::DirEntry| DirEntry {
            name: entry.file_name().to_string_lossy().into_owned(),
            is_dir: entry.path().is_dir(),
        };
        entries.map(entry).collect()
    }
}

/// A correct component.
struct Component {
    path: Utf8PathBuf,
    text: String,
    includes: Vec<Utf8PathBuf>,
}

impl Component {
    /// The errors of the component with another text.
    fn errors(&self, text: &str) -> Vec<Diagnostic> {
        let loader = Overlay {
            path: self.path.clone(),
            text: text.to_owned(),
            packages: self.includes.clone(),
        };
        let input = BatchInput {
            inputs: vec![Input::File(self.path.clone())],
            include_dirs: self.includes.clone(),
            ..BatchInput::default()
        };
        let host = AnalysisHost::new(Arc::new(loader));
        let result = host.analysis().batch(&input).unwrap();
        let errors = result.diagnostics.iter();
        let errors = errors.filter(|error| error.severity == Severity::Error);
        errors.cloned().collect()
    }
}

/// A text after a fix. `None` if it changes other files.
fn apply(path: &Utf8Path, text: &str, fix: &Fix) -> Option<String> {
    let mut edits: Vec<_> = fix.edits.iter().collect();
    edits.sort_by_key(|edit| std::cmp::Reverse(edit.range.start));
    let mut text = text.to_owned();
    for edit in edits {
        if edit.path != path {
            return None;
        }
        text.replace_range(edit.range.clone(), &edit.new_text);
    }
    Some(text)
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Specifications below a folder that have no error.
fn components(folder: &Path, includes: &[Utf8PathBuf]) -> Vec<Component> {
    let mut paths = Vec::new();
    collect(folder, &mut paths);
    paths.sort();
    let paths = paths.into_iter().filter_map(|path| path.canonicalize().ok());
    let paths = paths.filter_map(|path| Utf8PathBuf::from_path_buf(path).ok());
    let component = |path: Utf8PathBuf| {
        let text = std::fs::read_to_string(&path).ok()?;
        let around = path.ancestors().skip(1).take(2);
        let own = around.flat_map(|ancestor| {
            [ancestor.to_owned(), ancestor.join("idl"), ancestor.join("include")]
        });
        let includes: Vec<Utf8PathBuf> = own.chain(includes.iter().cloned()).collect();
        let component = Component { path, text, includes };
        component.errors(&component.text).is_empty().then_some(component)
    };
    paths.filter_map(component).collect()
}

fn collect(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, out);
        } else if path.extension().is_some_and(|extension| extension == "gen") {
            out.push(path);
        }
    }
}

fn examples() -> Vec<Component> {
    let all = components(&root().join("examples"), &[]);
    assert!(all.len() >= 8, "only {} examples are read", all.len());
    all
}

/// Published components, if they are next to the project.
fn published() -> Vec<Component> {
    let Some(corpus) = dotgen_loaders::shared("corpus/components") else {
        return Vec::new();
    };
    let mut folders = Vec::new();
    let mut add = |path: PathBuf| folders.extend(Utf8PathBuf::from_path_buf(path));
    for entry in std::fs::read_dir(&corpus).into_iter().flatten().flatten() {
        add(entry.path());
        for inner in std::fs::read_dir(entry.path()).into_iter().flatten().flatten() {
            if inner.path().is_dir() {
                add(inner.path());
            }
        }
    }
    components(&corpus, &folders)
}
