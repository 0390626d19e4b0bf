//! Reading of files for analysis, and packages.
//!
//! All input and output of the analysis goes through [`Vfs`], which implements its `Loader`.

mod installed;
mod interfaces;
mod pkg_config;
mod pkg_file;

use std::collections::HashMap;
use std::fmt;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError, RwLock};
use std::time::SystemTime;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{DirEntry, FileContent, Loader, PackageFlags};
use dotgen_analysis::language;
use dotgen_analysis::release::ReleaseChoice;

use dotgen_syntax::encoding;

pub use dotgen_analysis::host::normalize;
pub use interfaces::{
    has as has_own_interfaces, include_of as include_of_own_interface, is_own as is_own_interface,
};
pub use pkg_config::query;
pub use pkg_config::words;

/// The search for packages of `#pragma requires`, and for GenoM3 itself.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct PackageConfig {
    /// Directories with `.pc` files, searched before those of the system.
    pub paths: Vec<Utf8PathBuf>,
    /// Directories of templates. The installed GenoM3 is the one that the first of them with a release
    /// belongs to.
    pub templates: Vec<Utf8PathBuf>,
    /// True if the package tool may be run. Otherwise dotgen reads `.pc` files itself.
    pub may_run: bool,
    /// True if the interfaces included in dotgen replace packages that are not installed.
    pub own_interfaces: bool,
}

/// The disk and the package tool, as the loader of analysis.
///
/// Open documents need no overlay here: their text is set on the host, which uses the loader only for other
/// files.
#[derive(Debug, Default)]
pub struct Vfs {
    packages: RwLock<PackageConfig>,
    /// True if text that is not UTF-8 is read in the form that editors show.
    for_editor: bool,
    /// The files that were asked for, with their states before that. Only for editors.
    asked: Mutex<HashMap<Utf8PathBuf, Option<Stamp>>>,
}

/// The state of a file on disk, without its text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
    /// On Unix: the inode, and the time of its last change. A replaced file has another inode, even if its
    /// length and time are those of the old file.
    #[cfg(unix)]
    inode: (u64, i64, i64),
}

impl Stamp {
    /// The state of a file. `None` if there is no such file.
    pub fn of(path: &Utf8Path) -> Option<Stamp> {
        let metadata = std::fs::metadata(path).ok()?;
        #[cfg(unix)]
        let inode = {
            use std::os::unix::fs::MetadataExt;
            (metadata.ino(), metadata.ctime(), metadata.ctime_nsec())
        };
        metadata.is_file().then(|| Stamp {
            length: metadata.len(),
            modified: metadata.modified().ok(),
            #[cfg(unix)]
            inode,
        })
    }
}

/// A change of a file on disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileChange {
    /// The file.
    pub path: Utf8PathBuf,
    /// True if the file existed before.
    pub existed: bool,
    /// True if the file exists now.
    pub exists: bool,
}

impl Vfs {
    /// A loader with the package search of `packages`.
    pub fn new(packages: PackageConfig) -> Vfs {
        Vfs { packages: RwLock::new(packages), ..Vfs::default() }
    }

    /// A loader for a server. Text that is not UTF-8 is read with U+FFFD, as editors show it, so that
    /// positions agree. Such a text is never written: edits of the file are refused unless the file is open,
    /// in which case the client's text is used.
    pub fn for_editor() -> Vfs {
        Vfs { for_editor: true, ..Vfs::default() }
    }

    /// Records the state of a file, before it is read.
    pub fn watch(&self, path: &Utf8Path) {
        if self.for_editor {
            let stamp = Stamp::of(path);
            let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
            asked.insert(path.to_owned(), stamp);
        }
    }

    /// The files whose state differs from that at the last read, or at the last call. Costs a system call for
    /// each file that was ever asked for.
    pub fn changed(&self) -> Vec<FileChange> {
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        let mut changes = Vec::new();
        for (path, stamp) in asked.iter_mut() {
            let now = Stamp::of(path);
            let before = std::mem::replace(stamp, now);
            if before != now {
                changes.push(FileChange {
                    path: path.clone(),
                    existed: before.is_some(),
                    exists: now.is_some(),
                });
            }
        }
        changes.sort_by(|a, b| a.path.cmp(&b.path));
        changes
    }

    /// Changes the package search. Returns true if it differs from the previous one.
    pub fn set_packages(&self, packages: &PackageConfig) -> bool {
        let mut current = self.packages.write().unwrap_or_else(PoisonError::into_inner);
        let changed = *current != *packages;
        if changed {
            packages.clone_into(&mut current);
        }
        changed
    }
}

impl Loader for Vfs {
    fn read(&self, path: &Utf8Path) -> FileContent {
        self.watch(path);
        match read(path) {
            FileContent::Text(text) if self.for_editor => FileContent::Text(shown(text)),
            FileContent::NotUtf8(text) if self.for_editor => FileContent::NotUtf8(shown(text)),
            content => content,
        }
    }

    fn size(&self, path: &Utf8Path) -> Option<u64> {
        let metadata = std::fs::metadata(path).ok()?;
        metadata.is_file().then_some(metadata.len())
    }

    fn packages(&self, arguments: &[String]) -> Result<PackageFlags, String> {
        let config = self.packages.read().unwrap_or_else(PoisonError::into_inner).clone();
        let _span = tracing::info_span!("packages", ?arguments).entered();
        query(&config, arguments)
    }

    fn installed_release(&self) -> Option<ReleaseChoice> {
        let config = self.packages.read().unwrap_or_else(PoisonError::into_inner).clone();
        installed::release(&config)
    }

    fn list_dir(&self, path: &Utf8Path) -> Vec<DirEntry> {
        let entries = path.read_dir_utf8().into_iter().flatten();
        let entries = entries.filter_map(Result::ok).take(MAX_ENTRIES);
        let convert = entries.map(|entry| DirEntry {
            name: entry.file_name().to_owned(),
            is_dir: entry.path().is_dir(),
        });
        convert.collect()
    }

    fn package_names(&self) -> Vec<String> {
        let config = self.packages.read().unwrap_or_else(PoisonError::into_inner).clone();
        pkg_file::names(&config.paths)
    }
}

fn shown(text: String) -> String {
    match encoding::shown(&text) {
        std::borrow::Cow::Owned(shown) => shown,
        std::borrow::Cow::Borrowed(_) => text,
    }
}

/// Maximum number of listed entries of a directory.
const MAX_ENTRIES: usize = 2_000;

/// What a path is, without reading it: a regular file is an empty text.
pub fn kind(path: &Utf8Path) -> FileContent {
    match std::fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => FileContent::Directory,
        // A read of a pipe or device might never end.
        Ok(metadata) if !metadata.is_file() => {
            FileContent::Unreadable("it is not a regular file".to_owned())
        }
        Ok(_) => FileContent::Text(String::new()),
        Err(error) if missing(&error) => FileContent::Missing,
        Err(error) => FileContent::Unreadable(super::reason(&error)),
    }
}

/// Reads a file from the disk.
pub fn read(path: &Utf8Path) -> FileContent {
    match kind(path) {
        FileContent::Text(_) => {}
        other => return other,
    }
    match super::read_regular(path.as_std_path()) {
        Ok(bytes) => {
            if let Some(name) = encoding::other_unicode(&bytes) {
                return FileContent::Unreadable(format!("it is {name}; save it as UTF-8"));
            }
            let valid = std::str::from_utf8(&bytes).is_ok();
            let text = encoding::decode(bytes);
            if valid { FileContent::Text(text) } else { FileContent::NotUtf8(text) }
        }
        Err(error) if missing(&error) => FileContent::Missing,
        Err(error) => FileContent::Unreadable(super::reason(&error)),
    }
}

fn missing(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidFilename
    )
}

/// The `.gen` files in a directory, without subdirectories, sorted.
pub fn specifications_in(directory: &Utf8Path) -> Vec<Utf8PathBuf> {
    let entries = directory.read_dir_utf8().into_iter().flatten().flatten();
    let paths = entries.map(|entry| directory.join(entry.file_name()));
    let mut out: Vec<_> =
        paths.filter(|path| language::is_specification(path) && path.is_file()).collect();
    out.sort();
    out
}

/// The files that a walk found, and what it could not read.
#[derive(Debug, Default)]
pub struct FilesBelow {
    /// The files, sorted.
    pub files: Vec<Utf8PathBuf>,
    /// The folders that cannot be listed, each with the reason.
    pub unreadable: Vec<UnreadableFolder>,
}

/// A folder that cannot be listed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnreadableFolder {
    /// The folder.
    pub path: PathBuf,
    /// The error of the system.
    pub reason: String,
}

impl fmt::Display for UnreadableFolder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot list the folder `{}`: {}", self.path.display(), self.reason)
    }
}

/// Every file below `directory` with one of the extensions. Hidden directories, `build` directories of other
/// tools and links to directories are skipped.
pub fn files_below(directory: &Utf8Path, extensions: &[&str]) -> FilesBelow {
    let visible = |entry: &walkdir::DirEntry| {
        let name = entry.file_name().to_string_lossy();
        entry.depth() == 0
            || !(entry.file_type().is_dir()
                && (name.starts_with('.') || matches!(&*name, "node_modules" | "target")))
    };
    let mut found = FilesBelow::default();
    for entry in walkdir::WalkDir::new(directory).into_iter().filter_entry(visible) {
        match entry {
            Ok(entry) => {
                let Ok(path) = Utf8PathBuf::from_path_buf(entry.path().to_owned()) else {
                    continue;
                };
                let wanted = path.extension().is_some_and(|end| extensions.contains(&end));
                if wanted && is_file(&entry) {
                    found.files.push(path);
                }
            }
            Err(error) => found.unreadable.extend(unreadable(directory, &error)),
        }
    }
    found.files.sort();
    found
}

/// Returns true if an entry of a folder is a file, or a link to one. A target that cannot be examined counts:
/// the error is reported when the file is read.
fn is_file(entry: &walkdir::DirEntry) -> bool {
    if !entry.path_is_symlink() {
        return entry.file_type().is_file();
    }
    match std::fs::metadata(entry.path()) {
        Ok(metadata) => metadata.is_file(),
        Err(error) => !missing(&error),
    }
}

/// The folder of an error of a walk; `None` if the folder vanished during the walk.
fn unreadable(directory: &Utf8Path, error: &walkdir::Error) -> Option<UnreadableFolder> {
    let cause = error.io_error()?;
    if error.depth() > 0 && missing(cause) {
        return None;
    }
    let path = error.path().unwrap_or(directory.as_std_path()).to_owned();
    Some(UnreadableFolder { path, reason: super::reason(cause) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_cannot_be_listed_is_an_error_of_the_walk() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        std::fs::create_dir(folder.join("sub")).unwrap();
        for name in ["b.gen", "a.gen", "c.txt", "sub/d.gen"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        let found = files_below(folder, &["gen"]);
        let names: Vec<_> =
            found.files.iter().map(|path| path.strip_prefix(folder).unwrap()).collect();
        assert_eq!(names, ["a.gen", "b.gen", "sub/d.gen"]);
        assert_eq!(found.unreadable, []);
        let found = files_below(&folder.join("none"), &["gen"]);
        assert!(found.files.is_empty());
        let errors: Vec<_> = found.unreadable.iter().map(ToString::to_string).collect();
        let expected = format!("cannot list the folder `{folder}/none`: ");
        assert!(matches!(errors.as_slice(), [error] if error.starts_with(&expected)), "{errors:?}");
    }

    #[test]
    fn changes_on_disk_are_noticed_once() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let (a, b) = (folder.join("a.gen"), folder.join("b.gen"));
        std::fs::write(&a, "one").unwrap();
        let vfs = Vfs::for_editor();
        assert_eq!(
            (vfs.read(&a), vfs.read(&b)),
            (FileContent::Text("one".into()), FileContent::Missing)
        );
        assert_eq!(vfs.changed(), []);
        // A file of the same length, put in the place of the old one.
        std::fs::write(folder.join("new"), "two").unwrap();
        std::fs::rename(folder.join("new"), &a).unwrap();
        std::fs::write(&b, "").unwrap();
        let change = |path: &Utf8PathBuf, existed, exists| FileChange {
            path: path.clone(),
            existed,
            exists,
        };
        assert_eq!(vfs.changed(), [change(&a, true, true), change(&b, false, true)]);
        assert_eq!(vfs.changed(), []);
        std::fs::remove_file(&a).unwrap();
        assert_eq!(vfs.changed(), [change(&a, true, false)]);
    }

    #[test]
    fn utf_16_is_not_read_as_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::from_path_buf(folder.path().join("a.gen")).unwrap();
        let units = "\u{feff}struct a { long x; };\n".encode_utf16();
        let bytes: Vec<u8> = units.flat_map(u16::to_le_bytes).collect();
        std::fs::write(&path, bytes).unwrap();
        let FileContent::Unreadable(why) = read(&path) else {
            panic!("it is read");
        };
        assert_eq!(why, "it is UTF-16; save it as UTF-8");
    }
}
