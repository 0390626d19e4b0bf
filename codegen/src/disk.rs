//! The disk as code generation sees it. Nothing in this crate reads or writes files by itself: it asks
//! this trait, which the caller implements (a server, a command, a test).

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// All access to files that code generation has, but for the specifications themselves, which come by
/// `dotgen_analysis::host::Loader`.
pub trait Disk: fmt::Debug + Send + Sync {
    /// The bytes of a file.
    ///
    /// # Errors
    /// Those of the system; `NotFound` when nothing is there.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// What a path leads to, links followed; `None` when nothing is there or it cannot be reached.
    fn status(&self, path: &Path) -> Option<Status>;

    /// What a directory holds, in no order.
    ///
    /// # Errors
    /// Those of the system.
    fn list(&self, directory: &Path) -> io::Result<Vec<Entry>>;

    /// The absolute path with all links followed.
    ///
    /// # Errors
    /// Those of the system; `NotFound` when nothing is there.
    fn canonical(&self, path: &Path) -> io::Result<PathBuf>;

    /// The directory where relative paths start.
    fn current_dir(&self) -> PathBuf;

    /// Gives files new content: all of them, or none. Directories that are missing are made. Of a file that
    /// is there, mode and owner stay, links are followed, and it is whole at any moment.
    ///
    /// # Errors
    /// The first file that cannot be written, with what became of the others.
    fn write(&self, files: &[NewContent]) -> Result<(), WriteError>;

    /// Sets the permissions of a file, as of `chmod`. Does nothing on systems without them.
    ///
    /// # Errors
    /// Those of the system.
    fn set_mode(&self, path: &Path, mode: u32) -> io::Result<()>;

    /// Whether a path is a link itself.
    fn is_link(&self, path: &Path) -> bool;

    /// Writes a temporary file that nobody else knows, without the care that files of users get.
    ///
    /// # Errors
    /// Those of the system.
    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()>;

    /// Removes a temporary file, if it is there.
    fn remove(&self, path: &Path);

    /// Whether a path leads to a file.
    fn is_file(&self, path: &Path) -> bool {
        self.status(path).is_some_and(|it| it.kind == Kind::File)
    }

    /// Whether a path leads to a directory.
    fn is_dir(&self, path: &Path) -> bool {
        self.status(path)
            .is_some_and(|it| it.kind == Kind::Directory)
    }

    /// Whether a path leads to anything.
    fn exists(&self, path: &Path) -> bool {
        self.status(path).is_some()
    }

    /// The path, made absolute by putting the current directory in front.
    fn absolute(&self, path: &Path) -> PathBuf {
        match path.is_absolute() {
            true => path.to_owned(),
            false => self.current_dir().join(path),
        }
    }
}

/// What a path leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A regular file.
    File,
    /// A directory.
    Directory,
    /// A device, pipe or socket.
    Other,
}

/// What is known of a file without reading it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// What it is.
    pub kind: Kind,
    /// Unix permissions (`0o7777`); 0 on systems without them.
    pub mode: u32,
    /// When it was changed, where the system knows.
    pub modified: Option<SystemTime>,
}

/// An entry of a directory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Its path.
    pub path: PathBuf,
    /// Whether it is a directory itself, not a link to one.
    pub is_dir: bool,
}

/// What a file is to hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewContent {
    /// Its path, absolute or from the current directory.
    pub path: PathBuf,
    /// All its bytes.
    pub bytes: Vec<u8>,
    /// Unix permissions; `None` for those it has, or those the system gives to a new file.
    pub mode: Option<u32>,
}

/// Why files were not written.
#[derive(Debug)]
pub struct WriteError {
    /// The file that could not be written.
    pub path: PathBuf,
    /// Why.
    pub reason: io::Error,
    /// Files that have their new content already and could not be put back, each with the reason.
    pub changed: Vec<(PathBuf, io::Error)>,
    /// How many files were to be written.
    pub of: usize,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "cannot write `{}`: {}",
            self.path.display(),
            words(&self.reason)
        )?;
        match self.of {
            0 | 1 => return Ok(()),
            of if self.changed.is_empty() => write!(f, "; none of the {of} files was changed")?,
            _ => {}
        }
        for (path, reason) in &self.changed {
            let path = path.display();
            write!(
                f,
                "; `{path}` was changed before and cannot be put back: {}",
                words(reason)
            )?;
        }
        Ok(())
    }
}

impl std::error::Error for WriteError {}

/// "permission denied", without the number of the operating system.
fn words(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((text, _)) => text.to_lowercase(),
        None => text,
    }
}

/// As Tcl's `file normalize`: an absolute path, links followed but for the last one. `None` if nothing of it
/// is there.
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
