//! The disk, as an interface for code generation. This crate does not read or write files itself: it uses
//! this trait, which the caller implements (a server, a command, a test).

use std::fmt;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;

/// All access of code generation to files, except specifications, which are read through
/// `dotgen_analysis::host::Loader`.
pub trait Disk: fmt::Debug + Send + Sync {
    /// The bytes of a file.
    ///
    /// # Errors
    /// The errors of the system; `NotFound` if the file does not exist.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// The status of a path's target, with links followed; `None` if the target does not exist or cannot be
    /// reached.
    fn status(&self, path: &Path) -> Option<Status>;

    /// The entries of a directory, in no order.
    ///
    /// # Errors
    /// The errors of the system.
    fn list(&self, directory: &Path) -> io::Result<Vec<Entry>>;

    /// The absolute path with all links followed.
    ///
    /// # Errors
    /// The errors of the system; `NotFound` if the path does not exist.
    fn canonical(&self, path: &Path) -> io::Result<PathBuf>;

    /// The current directory, where relative paths start.
    fn current_dir(&self) -> PathBuf;

    /// Gives files new content: either all of them or none. Missing directories are created. An existing file
    /// keeps its mode and owner, links are followed, and the file is complete at any moment. A file that is
    /// no longer as it was read, and a file outside of its folders, are errors.
    ///
    /// # Errors
    /// The first file that cannot be written, and the state of the others.
    fn write(&self, files: &[NewContent]) -> Result<(), WriteError>;

    /// Sets the permissions of a file, as `chmod` does. Has no effect on systems without permissions.
    ///
    /// # Errors
    /// The errors of the system.
    fn set_mode(&self, path: &Path, mode: u32) -> io::Result<()>;

    /// True if a path is itself a link.
    fn is_link(&self, path: &Path) -> bool;

    /// Writes a temporary file that no other program uses, without the precautions for files of users.
    ///
    /// # Errors
    /// The errors of the system.
    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()>;

    /// Removes a temporary file, if it exists.
    fn remove(&self, path: &Path);

    /// True if the target of a path is a file.
    fn is_file(&self, path: &Path) -> bool {
        self.status(path).is_some_and(|status| status.kind == Kind::File)
    }

    /// True if the target of a path is a directory.
    fn is_dir(&self, path: &Path) -> bool {
        self.status(path).is_some_and(|status| status.kind == Kind::Directory)
    }

    /// True if the target of a path exists.
    fn exists(&self, path: &Path) -> bool {
        self.status(path).is_some()
    }

    /// The absolute path, with the current directory as prefix of a relative one.
    fn absolute(&self, path: &Path) -> PathBuf {
        if path.is_absolute() { path.to_owned() } else { self.current_dir().join(path) }
    }
}

/// The kind of a path's target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A regular file.
    File,
    Directory,
    /// A device, pipe or socket.
    Other,
}

/// The status of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    pub kind: Kind,
    /// Unix permissions (`0o7777`); 0 on systems without them.
    pub mode: u32,
    /// Time of its last change, if the system provides it.
    pub modified: Option<SystemTime>,
}

/// An entry of a directory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    pub path: PathBuf,
    /// True if it is a directory itself, not a link to one.
    pub is_dir: bool,
}

/// New content of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewContent {
    /// Its path, absolute or from the current directory.
    pub path: PathBuf,
    /// The whole content.
    pub bytes: Vec<u8>,
    /// Unix permissions; `None` for the present ones, or the system's default for a new file.
    pub mode: Option<u32>,
    /// The content that the new one was computed from.
    pub before: Before,
    /// The folders of which one must contain the file, with all links followed. Empty for a path that the
    /// user named: such a path may lead anywhere.
    pub within: Vec<PathBuf>,
}

impl NewContent {
    /// The new content of a file whose present content does not matter, at a path that the user named.
    pub fn new(path: impl Into<PathBuf>, bytes: Vec<u8>) -> NewContent {
        NewContent { path: path.into(), bytes, mode: None, before: Before::Any, within: Vec::new() }
    }

    /// Returns the reason why the file may not be written: a link leads out of its folders, or `..` does.
    pub fn leads_out(&self, disk: &dyn Disk) -> Option<String> {
        let name = |path: &Path| format!("`{}`", path.display());
        if self.within.is_empty() || is_below(disk, &self.path, &self.within) {
            return None;
        }
        let folders: Vec<String> = self.within.iter().map(|folder| name(folder)).collect();
        let folders = folders.join(" and ");
        Some(match link_out(disk, &self.path, &self.within) {
            Some(link) => format!("the link {} leads out of {folders}", name(&link)),
            None => format!(
                "it is outside of {folders}, the folder of the nearest `dotgen.toml` or of the specification"
            ),
        })
    }
}

/// The content that a file had when it was read. A file with another content at the moment of writing was
/// changed by another program, and is left as it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Before {
    /// Does not matter.
    Any,
    /// There was no file.
    Missing,
    /// These bytes.
    Bytes(Vec<u8>),
}

impl From<Option<Vec<u8>>> for Before {
    fn from(bytes: Option<Vec<u8>>) -> Before {
        bytes.map_or(Before::Missing, Before::Bytes)
    }
}

/// A failure to write files.
#[derive(Debug)]
pub struct WriteError {
    /// The file that could not be written.
    pub path: PathBuf,
    pub reason: io::Error,
    /// Files that have their new content and could not be restored, each with the error.
    pub changed: Vec<(PathBuf, io::Error)>,
    /// Total number of files.
    pub of: usize,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot write `{}`: {}", self.path.display(), words(&self.reason))?;
        match self.of {
            0 | 1 => return Ok(()),
            of if self.changed.is_empty() => write!(f, "; none of the {of} files was changed")?,
            _ => {}
        }
        for (path, reason) in &self.changed {
            let path = path.display();
            write!(f, "; `{path}` was changed before and cannot be put back: {}", words(reason))?;
        }
        Ok(())
    }
}

impl std::error::Error for WriteError {}

/// The message of an error, without the error number: "permission denied".
fn words(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((text, _)) => text.to_lowercase(),
        None => text,
    }
}

/// Tcl's `file normalize`: an absolute path with links followed, except the last one. `None` if no part of it
/// exists.
pub(crate) fn normalize(disk: &dyn Disk, path: &Path) -> Option<PathBuf> {
    let path = disk.absolute(path);
    match (path.parent(), path.file_name()) {
        (Some(dir), Some(name)) => {
            let dir = disk.canonical(dir).ok().or_else(|| normalize(disk, dir))?;
            Some(dir.join(name))
        }
        _ => disk.canonical(&path).ok(),
    }
}

/// Returns true if a file would be below one of the folders once written, with all links on the way resolved.
pub fn is_below(disk: &dyn Disk, path: &Path, folders: &[PathBuf]) -> bool {
    let Some(path) = resolve(disk, path) else {
        return false;
    };
    folders.iter().any(|folder| resolve(disk, folder).is_some_and(|other| path.starts_with(other)))
}

/// The outermost link on the way to a path that leads out of all of the folders; `None` if no link does.
pub fn link_out(disk: &dyn Disk, path: &Path, folders: &[PathBuf]) -> Option<PathBuf> {
    let path = plain(disk, path);
    let mut ancestors: Vec<&Path> = path.ancestors().collect();
    ancestors.reverse();
    let named: Vec<PathBuf> = folders.iter().map(|folder| plain(disk, folder)).collect();
    let inside = |path: &&&Path| named.iter().any(|folder| path.starts_with(folder));
    let mut inside = ancestors.iter().filter(inside);
    inside.find(|at| disk.is_link(at) && !is_below(disk, at, folders)).map(|at| at.to_path_buf())
}

/// The path with links resolved; its last parts need not exist. `None` for a dangling link: a file written
/// there would be created at the target of the link.
pub(crate) fn resolve(disk: &dyn Disk, path: &Path) -> Option<PathBuf> {
    let path = plain(disk, path);
    for ancestor in path.ancestors() {
        if let Ok(real) = disk.canonical(ancestor) {
            let rest = path.strip_prefix(ancestor).ok()?;
            return Some(if rest.as_os_str().is_empty() { real } else { real.join(rest) });
        }
        if disk.is_link(ancestor) {
            return None;
        }
    }
    Some(disk.absolute(&path))
}

/// The path without `.` and `..`, absolute.
pub(crate) fn plain(disk: &dyn Disk, path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for component in disk.absolute(path).components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}
