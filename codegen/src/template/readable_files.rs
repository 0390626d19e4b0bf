//! The files a confined run can reach: the one place that compares paths with the allowed folders.
//!
//! The operating system confines the interpreter. The reads and writes that the engine does for it are
//! checked here, with the same folders.

use std::path::{Path, PathBuf};

use super::Failure;
use super::discover::SearchPath;
use crate::disk::Disk;
pub use crate::disk::{is_below, link_out};
pub(crate) use crate::disk::{plain, resolve};
use crate::process::Access;

/// The readable files and folders.
#[derive(Debug, Clone)]
pub(crate) struct ReadableFiles {
    read: Vec<PathBuf>,
    tmpdir: PathBuf,
}

impl ReadableFiles {
    /// The reach of a template in `dir` with the arguments `words`: its own folder and those next to it, the
    /// files that the arguments name, and the temporary folder.
    pub(crate) fn new(
        disk: &dyn Disk,
        dir: &Path,
        search: &SearchPath,
        base: &Path,
        words: &[String],
        tmpdir: &Path,
    ) -> ReadableFiles {
        let folders = search.dirs.iter().chain(&search.builtin);
        let folders = folders.map(PathBuf::as_path).chain([dir, tmpdir]);
        let files = words.iter().map(|word| base.join(word)).filter(|path| disk.is_file(path));
        let read = folders.map(Path::to_owned).chain(files);
        ReadableFiles {
            read: read.filter_map(|folder| disk.canonical(&folder).ok()).collect(),
            tmpdir: tmpdir.to_owned(),
        }
    }

    /// The same rights in the form that the operating system enforces.
    pub(crate) fn access(&self) -> Access {
        Access { read: self.read.clone(), write: vec![self.tmpdir.clone()] }
    }

    /// Refuses to read a file elsewhere. Missing files are reported by the reader.
    ///
    /// # Errors
    /// Fails for a file that exists outside of the readable folders.
    pub(crate) fn check_read(&self, disk: &dyn Disk, path: &Path) -> Result<(), Failure> {
        match disk.canonical(path) {
            Ok(path) if !self.read.iter().any(|other| path.starts_with(other)) => {
                Err(Failure::Error(format!(
                    "\"{}\" is not to be read by a confined template: it is neither a file of a template \
                     nor an input",
                    path.display()
                )))
            }
            _ => Ok(()),
        }
    }
}

/// Returns true if a path, with all links resolved, has a part that begins with a dot below all of the
/// folders around the path. Such files configure tools, shells and editors: `.git/hooks`, `.vscode`,
/// `.profile`.
pub fn is_hidden(disk: &dyn Disk, path: &Path, folders: &[PathBuf]) -> bool {
    has_part(disk, path, folders, |part| part.starts_with(b"."))
}

/// Folders whose files configure tools, or are run by them.
const CONTROL_FOLDERS: [&str; 16] = [
    ".git",
    ".hg",
    ".svn",
    ".bzr",
    ".jj",
    ".github",
    ".gitlab",
    ".circleci",
    ".husky",
    ".vscode",
    ".idea",
    ".vs",
    ".zed",
    ".devcontainer",
    ".cargo",
    ".ssh",
];

/// Returns true if a path, with all links resolved, is in a control folder below all of the folders around
/// the path: see [`is_hidden`].
pub fn is_control(disk: &dyn Disk, path: &Path, folders: &[PathBuf]) -> bool {
    has_part(disk, path, folders, |part| {
        CONTROL_FOLDERS.iter().any(|name| part.eq_ignore_ascii_case(name.as_bytes()))
    })
}

fn has_part(
    disk: &dyn Disk,
    path: &Path,
    folders: &[PathBuf],
    is_wanted: impl Fn(&[u8]) -> bool,
) -> bool {
    let parts = |path: &Path, folders: &[PathBuf]| {
        let below = folders.iter().filter_map(|folder| path.strip_prefix(folder).ok());
        below
            .map(|rest| {
                let mut parts = rest.components();
                parts.any(|part| is_wanted(part.as_os_str().as_encoded_bytes()))
            })
            .reduce(|one, other| one && other)
    };
    let named: Vec<PathBuf> = folders.iter().map(|folder| plain(disk, folder)).collect();
    let real: Vec<PathBuf> = folders.iter().filter_map(|folder| resolve(disk, folder)).collect();
    let by_links = resolve(disk, path).and_then(|path| parts(&path, &real));
    by_links.unwrap_or(true) || parts(&plain(disk, path), &named).unwrap_or(false)
}
