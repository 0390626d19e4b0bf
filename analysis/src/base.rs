//! The salsa database: inputs, the path table, and per-file text queries.
//!
//! A path becomes an input at its first query, even if it is missing, so that creating or deleting a file
//! re-runs exactly the queries that read it. All input and output goes through the [`Loader`]. The tables
//! only grow: the input of a path never changes, so reading them inside a query is harmless.

use std::sync::{
    Arc, Mutex, MutexGuard, PoisonError,
    atomic::{AtomicU64, Ordering},
};

use camino::{Utf8Component, Utf8Path, Utf8PathBuf};
use dotgen_syntax::{
    lexer::{RawTokens, lex},
    line_index::LineIndex,
};
use rustc_hash::{FxHashMap, FxHashSet};
use salsa::{Database as _, Durability, Setter};
use smol_str::SmolStr;

use crate::{
    config::{LintConfig, MAX_FILE_BYTES, Project},
    diagnostic::Severity,
    loader::{DirEntry, FileContent, Loader, PackageFlags},
    release::ReleaseChoice,
};

/// The interface of the database to queries.
#[salsa::db]
pub(crate) trait Db: salsa::Database {
    /// The input of a path.
    fn file(&self, path: &Utf8Path) -> SourceFile;
    /// The input of a directory.
    fn directory(&self, path: &Utf8Path) -> Directory;
    /// The input of a text in memory.
    fn text(&self, name: &Utf8Path, text: &Arc<str>) -> SourceFile;
    /// The input of an argument list of `#pragma requires`.
    fn packages(&self, arguments: &[String]) -> Packages;
    /// The installed GenoM3.
    fn installed(&self) -> Installed;
    /// The settings.
    fn workspace(&self) -> Workspace;
    /// For data that is read at the time of a request and never cached.
    fn loader(&self) -> &Arc<dyn Loader>;
    /// Maximum size of a text in bytes; larger texts are not read.
    fn max_bytes(&self) -> u64;
    /// Another handle, for another thread.
    fn fork(&self) -> RootDatabase;
}

/// A path and its content.
#[salsa::input(debug)]
pub struct SourceFile {
    /// Absolute, without `.` and `..`.
    pub path: Utf8PathBuf,
    /// The result of reading the path.
    pub status: FileStatus,
    /// The text; empty unless the status says otherwise.
    pub text: Arc<str>,
}

/// The result of reading a path.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum FileStatus {
    /// A text was read.
    Text,
    /// The path does not exist.
    Missing,
    Directory,
    /// A text with replacement characters.
    NotUtf8,
    /// The path cannot be read; the reason.
    Unreadable(String),
    /// The size in bytes, which is over the limit.
    TooLarge(u64),
}

/// A directory and its entries on disk; none if it cannot be read.
#[salsa::input(debug)]
pub struct Directory {
    /// Absolute, without `.` and `..`.
    pub path: Utf8PathBuf,
    /// Files and directories in it.
    pub entries: Vec<DirEntry>,
}

/// The answer of the package tool to one argument list.
#[salsa::input(debug)]
pub struct Packages {
    pub arguments: Vec<String>,
    /// Flags, or a message for the user.
    pub flags: Result<PackageFlags, String>,
}

/// The installed GenoM3.
#[salsa::input(debug)]
pub struct Installed {
    /// The release; `None` if none is found.
    pub release: Option<ReleaseChoice>,
}

/// Settings of the workspace.
#[salsa::input(debug)]
pub struct Workspace {
    /// Every file that begins a unit, in order.
    pub roots: Vec<Utf8PathBuf>,
    /// The document that the user is editing.
    pub active: Option<Utf8PathBuf>,
    /// `-I`
    pub include_dirs: Vec<Utf8PathBuf>,
    /// `-D`
    pub defines: Vec<(SmolStr, SmolStr)>,
    /// The release of GenoM3, if the user sets it.
    pub release: Option<ReleaseChoice>,
    /// Directories with an include path, macros and a release of their own.
    pub projects: Vec<Project>,
    /// Severity per code.
    pub severities: Vec<(String, Option<Severity>)>,
    /// The settings of the lints.
    pub lints: LintConfig,
    /// Files, and the roots that the user chose to show them in.
    pub chosen: Vec<(Utf8PathBuf, Utf8PathBuf)>,
    /// True if queries may search for the files that include a file, which reads every root. Until then a
    /// root counts only for itself.
    pub indexed: bool,
}

impl Workspace {
    /// Directories searched for included files, and macros, of a unit that begins with a file.
    pub(crate) fn reading<'db>(
        self,
        db: &'db dyn Db,
        root: &Utf8Path,
    ) -> (&'db [Utf8PathBuf], &'db [(SmolStr, SmolStr)]) {
        match self.project(db, root) {
            Some(project) => (&project.include_dirs, &project.defines),
            None => (self.include_dirs(db), self.defines(db)),
        }
    }

    /// The innermost project that contains a path.
    pub(crate) fn project<'db>(self, db: &'db dyn Db, path: &Utf8Path) -> Option<&'db Project> {
        let around = self.projects(db).iter();
        let around = around.filter(|project| path.starts_with(&project.directory));
        around.max_by_key(|project| project.directory.as_str().len())
    }
}

#[salsa::db]
#[derive(Clone)]
pub(crate) struct RootDatabase {
    storage: salsa::Storage<Self>,
    tables: Arc<Tables>,
    workspace: Option<Workspace>,
}

struct Tables {
    loader: Arc<dyn Loader>,
    /// Maximum size of a text in bytes; larger texts are not read.
    max_bytes: AtomicU64,
    files: Mutex<FxHashMap<Utf8PathBuf, SourceFile>>,
    /// Files with a text from the editor that differs from the disk: they change often.
    edited: Mutex<FxHashSet<SourceFile>>,
    directories: Mutex<FxHashMap<Utf8PathBuf, Directory>>,
    texts: Mutex<FxHashMap<(Utf8PathBuf, Arc<str>), SourceFile>>,
    packages: Mutex<FxHashMap<Vec<String>, Packages>>,
    installed: Mutex<Option<Installed>>,
}

/// A callback that receives the events of salsa; tests use it to prove which queries ran.
pub(crate) type EventCallback = Box<dyn Fn(salsa::Event) + Send + Sync>;

impl RootDatabase {
    pub(crate) fn new(loader: Arc<dyn Loader>, events: Option<EventCallback>) -> RootDatabase {
        let mut db = RootDatabase {
            storage: salsa::Storage::new(events),
            tables: Arc::new(Tables {
                loader,
                max_bytes: AtomicU64::new(MAX_FILE_BYTES),
                files: Mutex::default(),
                edited: Mutex::default(),
                directories: Mutex::default(),
                texts: Mutex::default(),
                packages: Mutex::default(),
                installed: Mutex::default(),
            }),
            workspace: None,
        };
        let workspace = Workspace::builder(
            Vec::new(),
            None,
            Vec::new(),
            Vec::new(),
            None,
            Vec::new(),
            Vec::new(),
            LintConfig::default(),
            Vec::new(),
            true,
        )
        .durability(Durability::MEDIUM)
        // They change with every document that is shown.
        .active_durability(Durability::LOW)
        .chosen_durability(Durability::LOW)
        .new(&db);
        db.workspace = Some(workspace);
        db
    }

    /// Evicts large results that are seldom requested again, except for the most recently requested. Cancels
    /// the running snapshots and waits until they are dropped.
    pub(crate) fn evict_cache(&mut self) {
        self.trigger_lru_eviction();
    }

    /// An input for a file with its content on disk.
    fn input(&self, path: Utf8PathBuf, (status, text): (FileStatus, Arc<str>)) -> SourceFile {
        let new = SourceFile::builder(path, status, text);
        // Queries that depend only on such files are not revalidated when a document is edited.
        new.durability(Durability::MEDIUM).new(self)
    }

    /// An empty database with the settings of another one, over another loader.
    pub(crate) fn with_settings_of(other: &dyn Db, loader: Arc<dyn Loader>) -> RootDatabase {
        let mut db = RootDatabase::new(loader, None);
        let (from, to) = (other.workspace(), db.workspace());
        to.set_roots(&mut db).to(from.roots(other).clone());
        to.set_include_dirs(&mut db).to(from.include_dirs(other).clone());
        to.set_defines(&mut db).to(from.defines(other).clone());
        // The installed release does not depend on the loader.
        let release = from.release(other).clone();
        let release = release.or_else(|| other.installed().release(other).clone());
        to.set_release(&mut db).to(release);
        to.set_projects(&mut db).to(from.projects(other).clone());
        to.set_severities(&mut db).to(from.severities(other).clone());
        db.set_max_bytes(other.max_bytes());
        db
    }

    /// Sets the maximum size of a file in bytes. Editor texts that fit the new limit must be set again.
    pub(crate) fn set_max_bytes(&mut self, limit: u64) {
        if self.tables.max_bytes.swap(limit, Ordering::Relaxed) == limit {
            return;
        }
        let known: Vec<(Utf8PathBuf, SourceFile)> =
            lock(&self.tables.files).iter().map(|(path, file)| (path.clone(), *file)).collect();
        for (path, file) in known {
            let size = match file.status(self) {
                FileStatus::TooLarge(size) => *size,
                _ => file.text(self).len() as u64,
            };
            let was_refused = matches!(file.status(self), FileStatus::TooLarge(_));
            if was_refused == (size > limit) {
                continue;
            }
            let edited = lock(&self.tables.edited).contains(&file);
            if edited {
                file.set_status(self).to(FileStatus::TooLarge(size));
                file.set_text(self).to("".into());
            } else {
                self.set_file(&path, None);
            }
        }
    }

    /// The content of a path on disk.
    fn read(&self, path: &Utf8Path) -> (FileStatus, Arc<str>) {
        match self.tables.loader.size(path).filter(|size| *size > self.max_bytes()) {
            Some(size) => (FileStatus::TooLarge(size), "".into()),
            None => self.split(self.tables.loader.read(path)),
        }
    }

    fn split(&self, content: FileContent) -> (FileStatus, Arc<str>) {
        let size = match &content {
            FileContent::Text(text) | FileContent::NotUtf8(text) => text.len() as u64,
            _ => 0,
        };
        if size > self.max_bytes() {
            (FileStatus::TooLarge(size), "".into())
        } else {
            split(content)
        }
    }

    /// Sets the text of a file, or reads it from the loader again.
    pub(crate) fn set_file(&mut self, path: &Utf8Path, text: Option<String>) {
        let path = normalize(path);
        let known = lock(&self.tables.files).get(&path).copied();
        let given = text.is_some();
        if !given || known.is_none_or(|file| !file.status(self).is_text()) {
            self.list_again(&path);
        }
        let (status, text) = match text {
            Some(text) => self.split(FileContent::Text(text)),
            None if known.is_none() => return,
            None => self.read(&path),
        };
        let file = known.unwrap_or_else(|| {
            let file = self.input(path.clone(), (FileStatus::Missing, "".into()));
            lock(&self.tables.files).insert(path, file);
            file
        });
        let changed = *file.text(self) != text;
        // Lowering the durability of an input re-runs all queries that depend on it: this does not happen
        // when a document is opened, but at its first edit.
        let (durability, moved) = match given {
            true if changed => {
                lock(&self.tables.edited).insert(file);
                (Durability::LOW, false)
            }
            true => (Durability::LOW, false),
            false => (Durability::MEDIUM, lock(&self.tables.edited).remove(&file)),
        };
        // A setter counts as a change even if the value is equal.
        if *file.status(self) != status {
            file.set_status(self).to(status);
        }
        if moved || changed {
            file.set_text(self).with_durability(durability).to(text);
        }
    }

    fn list(&self, directory: &Utf8Path) -> Vec<DirEntry> {
        let mut entries = self.tables.loader.list_dir(directory);
        entries.sort();
        entries
    }

    /// Lists the known directories around a path that may be new or gone.
    fn list_again(&mut self, path: &Utf8Path) {
        for around in path.ancestors() {
            let known = lock(&self.tables.directories).get(around).copied();
            let Some(directory) = known else { continue };
            let entries = self.list(around);
            if *directory.entries(self) != entries {
                directory.set_entries(self).to(entries);
            }
        }
    }

    /// The known paths at or below another one.
    pub(crate) fn known_at(&self, path: &Utf8Path) -> Vec<Utf8PathBuf> {
        let path = normalize(path);
        let files = lock(&self.tables.files);
        let below = files.keys().filter(|key| key.starts_with(&path));
        below.cloned().collect()
    }

    /// Repeats all former queries of the package tool.
    pub(crate) fn reload_packages(&mut self) {
        let known: Vec<Packages> = lock(&self.tables.packages).values().copied().collect();
        for packages in known {
            let arguments = packages.arguments(self).clone();
            let flags = self.tables.loader.packages(&arguments);
            if *packages.flags(self) != flags {
                _ = packages.set_flags(self).to(flags);
            }
        }
        let installed = *lock(&self.tables.installed);
        if let Some(installed) = installed {
            let release = self.tables.loader.installed_release();
            if *installed.release(self) != release {
                _ = installed.set_release(self).to(release);
            }
        }
    }
}

#[salsa::db]
impl salsa::Database for RootDatabase {}

#[salsa::db]
impl Db for RootDatabase {
    fn file(&self, path: &Utf8Path) -> SourceFile {
        let path = normalize(path);
        let mut files = lock(&self.tables.files);
        if let Some(&file) = files.get(&path) {
            return file;
        }
        let file = self.input(path.clone(), self.read(&path));
        files.insert(path, file);
        file
    }

    fn directory(&self, path: &Utf8Path) -> Directory {
        let path = normalize(path);
        let mut known = lock(&self.tables.directories);
        *known.entry(path.clone()).or_insert_with(|| {
            let entries = self.list(&path);
            Directory::builder(path, entries).durability(Durability::MEDIUM).new(self)
        })
    }

    fn max_bytes(&self) -> u64 {
        self.tables.max_bytes.load(Ordering::Relaxed)
    }

    fn fork(&self) -> RootDatabase {
        self.clone()
    }

    fn text(&self, name: &Utf8Path, text: &Arc<str>) -> SourceFile {
        let name = normalize(name);
        let mut texts = lock(&self.tables.texts);
        let new = || SourceFile::new(self, name.clone(), FileStatus::Text, text.clone());
        *texts.entry((name.clone(), text.clone())).or_insert_with(new)
    }

    fn packages(&self, arguments: &[String]) -> Packages {
        let mut known = lock(&self.tables.packages);
        if let Some(&packages) = known.get(arguments) {
            return packages;
        }
        let flags = self.tables.loader.packages(arguments);
        let packages = Packages::new(self, arguments.to_vec(), flags);
        known.insert(arguments.to_vec(), packages);
        packages
    }

    fn installed(&self) -> Installed {
        let mut known = lock(&self.tables.installed);
        *known.get_or_insert_with(|| Installed::new(self, self.tables.loader.installed_release()))
    }

    fn loader(&self) -> &Arc<dyn Loader> {
        &self.tables.loader
    }

    fn workspace(&self) -> Workspace {
        match self.workspace {
            Some(workspace) => workspace,
            None => unreachable!("set by the constructor"),
        }
    }
}

impl FileStatus {
    /// Returns true if there is a text to compile.
    pub fn is_text(&self) -> bool {
        matches!(self, FileStatus::Text | FileStatus::NotUtf8)
    }
}

/// Makes a path comparable: no `.`, no `..` that can be removed without reading the disk.
pub fn normalize(path: &Utf8Path) -> Utf8PathBuf {
    let mut out = Utf8PathBuf::new();
    for component in path.components() {
        match component {
            Utf8Component::CurDir => {}
            Utf8Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            Utf8Component::ParentDir if out.has_root() => {}
            other => out.push(other.as_str()),
        }
    }
    out
}

/// The tokens of a file.
#[derive(Debug, Clone)]
pub(crate) struct Lexed {
    pub(crate) raw: Arc<RawTokens>,
}

impl PartialEq for Lexed {
    /// Never equal: dependent queries must see a new text in any case.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.raw, &other.raw)
    }
}

#[salsa::tracked(lru = 24)]
pub(crate) fn lexed(db: &dyn Db, file: SourceFile) -> Lexed {
    Lexed { raw: Arc::new(lex(file.text(db))) }
}

#[salsa::tracked]
pub(crate) fn line_index(db: &dyn Db, file: SourceFile) -> Arc<LineIndex> {
    Arc::new(LineIndex::new(file.text(db)))
}

fn split(content: FileContent) -> (FileStatus, Arc<str>) {
    match content {
        FileContent::Text(text) => (FileStatus::Text, text.into()),
        FileContent::Missing => (FileStatus::Missing, "".into()),
        FileContent::Directory => (FileStatus::Directory, "".into()),
        FileContent::NotUtf8(text) => (FileStatus::NotUtf8, text.into()),
        FileContent::Unreadable(why) => (FileStatus::Unreadable(why), "".into()),
    }
}

/// The tables stay consistent even after a panic while they are locked.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalizes_paths() {
        let n = |path: &str| normalize(Utf8Path::new(path)).into_string();
        assert_eq!(n("/a/./b/../c"), "/a/c");
        assert_eq!(n("/../a"), "/a");
        assert_eq!(n("a/../../b"), "../b");
    }
}
