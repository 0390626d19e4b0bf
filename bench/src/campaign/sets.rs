//! Measured workspaces: copies of examples, of shared test data and of public components.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use xtask::root;
use xtask::shared::optional;

/// Folders of public components, each named `OWNER+NAME`; not part of the repository.
const CLONES: &str = "DOTGEN_CLONES";

/// A workspace to copy.
pub(crate) struct Set {
    pub(crate) name: String,
    /// The folder to copy.
    source: PathBuf,
    /// Folders of the copy whose documents are measured, relative to it.
    pub(crate) folders: Vec<PathBuf>,
    /// The `dotgen.toml` of the copy, if the folder has none.
    settings: Option<String>,
}

/// A copy of a workspace, removed when it is dropped.
pub(crate) struct Copy {
    pub(crate) root: PathBuf,
}

impl Drop for Copy {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.root).ok();
    }
}

/// All workspaces, or the examples alone, whose names contain one of `only` if there are any.
pub(crate) fn sets(only_examples: bool, only: &[String]) -> Result<Vec<Set>> {
    let mut out = Vec::new();
    let examples = root().join("examples");
    for name in names(&examples)? {
        out.push(Set {
            name: format!("examples/{name}"),
            source: examples.clone(),
            folders: vec![name.into()],
            settings: None,
        });
    }
    if !only_examples {
        corpus(&mut out)?;
        clones(&mut out)?;
    }
    if !only.is_empty() {
        out.retain(|set| only.iter().any(|text| set.name.contains(text.as_str())));
    }
    Ok(out)
}

fn corpus(out: &mut Vec<Set>) -> Result<()> {
    for (folder, settings) in [
        ("components", "include-paths = [\"standins\"]\n"),
        ("quadcopter", "include-paths = [\".\"]\n"),
        ("robnav", "include-paths = [\".\"]\n"),
    ] {
        let Some(source) = optional(&format!("corpus/{folder}")) else {
            continue;
        };
        for name in names(&source)? {
            if name == "standins" {
                continue;
            }
            let below = source.join(&name);
            if documents(&below).iter().any(|document| is_specification(document)) {
                out.push(Set {
                    name: format!("corpus/{folder}/{name}"),
                    source: source.clone(),
                    folders: vec![name.into()],
                    settings: Some(settings.to_owned()),
                });
            }
        }
    }
    Ok(())
}

fn clones(out: &mut Vec<Set>) -> Result<()> {
    let Some(folder) = std::env::var_os(CLONES).map(PathBuf::from) else {
        return Ok(());
    };
    let standins = optional("corpus/components/standins");
    let settings = standins.map(|standin| format!("include-paths = [\"{}\"]\n", standin.display()));
    for name in names(&folder)? {
        out.push(Set {
            source: folder.join(&name),
            name: format!("clones/{name}"),
            folders: vec![PathBuf::new()],
            settings: settings.clone(),
        });
    }
    Ok(())
}

impl Set {
    /// Makes a copy below the temporary directory.
    pub(crate) fn copy(&self) -> Result<Copy> {
        static NEXT: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
        let number = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let name = format!("dotgen-campaign-{}-{number}", std::process::id());
        let root = std::env::temp_dir().canonicalize()?.join(name);
        copy_folder(&self.source, &root)?;
        let copy = Copy { root };
        if let Some(settings) = &self.settings {
            let path = copy.root.join("dotgen.toml");
            if !path.exists() {
                std::fs::write(path, settings)?;
            }
        }
        Ok(copy)
    }

    /// Documents of a copy that are measured.
    pub(crate) fn documents(&self, root: &Path) -> Vec<PathBuf> {
        let folders = self.folders.iter();
        folders.flat_map(|folder| documents(&root.join(folder))).collect()
    }
}

/// True if a file is a specification with a component, and not a file of types.
pub(crate) fn is_specification(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "gen")
}

/// Specifications and sources of codels below a folder, sorted.
fn documents(folder: &Path) -> Vec<PathBuf> {
    const EXTENSIONS: [&str; 9] = ["gen", "c", "cc", "cpp", "cxx", "h", "hh", "hpp", "hxx"];
    let mut out = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            if is_hidden || entry.file_name() == "headers" {
                continue;
            }
            let extension = path.extension().and_then(|extension| extension.to_str());
            if path.is_dir() {
                open.push(path);
            } else if extension.is_some_and(|extension| EXTENSIONS.contains(&extension)) {
                out.push(path);
            }
        }
    }
    out.sort();
    out
}

/// Names of the folders in a folder, sorted.
fn names(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder);
    let entries = entries.with_context(|| format!("cannot read {}", folder.display()))?;
    let folders = entries.flatten().filter(|entry| entry.path().is_dir());
    let mut out: Vec<_> = folders
        .map(|folder| folder.file_name().to_string_lossy().into_owned())
        .filter(|folder| !folder.starts_with('.'))
        .collect();
    out.sort();
    Ok(out)
}

fn copy_folder(from: &Path, to: &Path) -> Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if name == ".git" || name == ".dotgen" {
            continue;
        }
        match entry.path().is_dir() {
            true => copy_folder(&entry.path(), &to.join(name))?,
            // A dangling link is not copied.
            false => _ = std::fs::copy(entry.path(), to.join(name)).ok(),
        }
    }
    Ok(())
}
