//! Results that the user must confirm.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::disk::Disk;
use crate::template::readable_files;

/// The reason why a result needs confirmation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Concern {
    /// The file or a folder around it is hidden.
    pub hidden: bool,
    /// The file becomes executable.
    pub executable: bool,
}

impl fmt::Display for Concern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match (self.hidden, self.executable) {
            (true, true) => "hidden and executable",
            (true, false) => "hidden",
            (false, _) => "executable",
        })
    }
}

/// Permission bits that make a file executable, or executable with the rights of others.
const EXECUTABLE: u32 = 0o7111;

/// The reason why a result needs confirmation, if any. `mode` is the mode set by the template.
pub(super) fn concern(
    disk: &dyn Disk,
    path: &Path,
    mode: Option<u32>,
    folders: &[PathBuf],
) -> Option<Concern> {
    let executable = is_new_executable(disk, path, mode);
    let hidden = readable_files::is_hidden(disk, path, folders);
    (hidden || executable).then_some(Concern { hidden, executable })
}

/// Returns true if a file becomes executable.
pub(super) fn is_new_executable(disk: &dyn Disk, path: &Path, mode: Option<u32>) -> bool {
    let had = || disk.status(path).map_or(0, |status| status.mode);
    mode.is_some_and(|mode| mode & EXECUTABLE & !had() != 0)
}
