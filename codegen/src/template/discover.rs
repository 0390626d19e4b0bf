//! Finding templates: directories with a `template.tcl` below the directories of a search path.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use dotgen_analysis::release::Release;

use crate::disk::{Disk, Entry};

/// The search path of templates.
#[derive(Debug, Clone, Default)]
pub struct SearchPath {
    /// Directories in order.
    pub dirs: Vec<PathBuf>,
    /// The built-in directory, searched last.
    pub builtin: Option<PathBuf>,
}

/// The reason why a name gives no template.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FindError {
    /// The name is the name of a file: the template argument is missing.
    MissingArgument(String),
    /// No directory of the path has it.
    NotFound(String),
    /// The directory holds no `template.` file.
    NoEntry,
    /// The template is written for another engine.
    UnknownEngine(String),
}

impl std::fmt::Display for FindError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FindError::MissingArgument(name) => {
                write!(f, "missing template argument before '{name}'")
            }
            FindError::NotFound(name) => write!(f, "cannot find template '{name}'"),
            FindError::NoEntry => f.write_str("cannot find template entry 'template.<engine>'"),
            FindError::UnknownEngine(engine) if engine.is_empty() => {
                f.write_str("no generator engine")
            }
            FindError::UnknownEngine(engine) => write!(f, "unknown generator engine '{engine}'"),
        }
    }
}

impl std::error::Error for FindError {}

impl SearchPath {
    /// Splits a colon separated list; empty elements are ignored.
    pub fn parse(list: &str) -> Vec<PathBuf> {
        list.split(':').filter(|dir| !dir.is_empty()).map(PathBuf::from).collect()
    }

    fn all(&self) -> impl Iterator<Item = &PathBuf> {
        self.dirs.iter().chain(&self.builtin)
    }

    /// The absolute directory of a template given by name or absolute path.
    ///
    /// # Errors
    /// Fails if there is no such template.
    pub fn find(&self, disk: &dyn Disk, name: &str) -> Result<PathBuf, FindError> {
        let path = Path::new(name);
        if disk.exists(path) && !disk.is_dir(path) {
            return Err(FindError::MissingArgument(name.to_owned()));
        }
        let dir = if path.is_absolute() {
            path.to_owned()
        } else {
            self.all()
                .map(|dir| dir.join(name))
                .find(|dir| disk.is_dir(dir) && entry(disk, dir).is_some())
                .ok_or_else(|| FindError::NotFound(name.to_owned()))?
        };
        match entry(disk, &dir) {
            None => Err(FindError::NoEntry),
            Some(engine) if engine == "tcl" => Ok(disk.absolute(&dir)),
            Some(engine) => Err(FindError::UnknownEngine(engine)),
        }
    }

    /// The directory of a template without Tcl (one with a `template.toml`), if the name matches one and no
    /// directory before it has a Tcl template of that name.
    pub(crate) fn find_manifest(&self, disk: &dyn Disk, name: &str) -> Option<PathBuf> {
        let path = Path::new(name);
        let dir = if path.is_absolute() {
            Some(path.to_owned())
        } else {
            let mut dirs = self.all().map(|dir| dir.join(name));
            dirs.find(|dir| disk.is_dir(dir) && entry(disk, dir).is_some())
        };
        dir.filter(|dir| entry(disk, dir).as_deref() == Some("toml"))
    }

    /// Names of all templates at any depth, sorted, each once.
    pub fn list(&self, disk: &dyn Disk) -> Vec<String> {
        let mut names = BTreeSet::new();
        for dir in self.all() {
            list_below(disk, dir, "", &mut names, 16);
        }
        names.into_iter().collect()
    }
}

/// The release of the GenoM3 that one of these template directories belongs to, and the file that contains
/// it: the version file of the template engine, which is installed next to them.
pub fn release_of(disk: &dyn Disk, dirs: &[PathBuf]) -> Option<(Release, PathBuf)> {
    dirs.iter().find_map(|dir| {
        let file = dir.parent()?.join("engines/tcl/version.tcl");
        let text = String::from_utf8(disk.read(&file).ok()?).ok()?;
        let provided = text
            .lines()
            .find_map(|line| line.trim().strip_prefix("package provide genom-engine"))?;
        Some((provided.trim().parse().ok()?, file))
    })
}

/// A path, made absolute by putting `here` in front; for a text that need not be one path.
pub(crate) fn absolute_text(here: &Path, text: &str) -> String {
    if text.starts_with('/') {
        return text.to_owned();
    }
    format!("{}/{text}", here.display())
}

/// Suffix of the entry of a template directory. A Tcl entry is preferred.
fn entry(disk: &dyn Disk, dir: &Path) -> Option<String> {
    let entries = disk.list(dir).ok()?;
    let mut engines: Vec<String> = (entries.iter())
        .filter_map(|entry| entry.path.file_name()?.to_str())
        .filter_map(|name| name.strip_prefix("template.").map(str::to_owned))
        .collect();
    engines.sort_by_key(|engine| engine != "tcl");
    engines.into_iter().next()
}

fn list_below(
    disk: &dyn Disk,
    dir: &Path,
    prefix: &str,
    names: &mut BTreeSet<String>,
    depth: usize,
) {
    let Some(depth) = depth.checked_sub(1) else {
        return;
    };
    let Ok(entries) = disk.list(dir) else {
        return;
    };
    for Entry { path, is_dir } in entries {
        // Links to directories are not followed, since they could form a cycle.
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        if !is_dir {
            continue;
        }
        let name = if prefix.is_empty() { name.to_owned() } else { format!("{prefix}/{name}") };
        list_below(disk, &path, &name, names, depth);
        if entry(disk, &path).is_some() {
            names.insert(name);
        }
    }
}
