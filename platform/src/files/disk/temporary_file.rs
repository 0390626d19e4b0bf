//! Files that exist only while this process runs: sockets, and files with temporary names.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// The paths of these files.
static ALL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn all() -> MutexGuard<'static, Vec<PathBuf>> {
    ALL.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A file that is removed on drop, and by [`leave`].
#[derive(Debug)]
pub struct TemporaryFile {
    path: PathBuf,
}

impl TemporaryFile {
    /// Registers a path, whether the file exists or not.
    pub fn new(path: PathBuf) -> TemporaryFile {
        all().push(path.clone());
        TemporaryFile { path }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        let mut all = all();
        all.retain(|path| *path != self.path);
        // The file may have been renamed, or removed by another process.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Removes these files and ends this process at once. Its child processes end with it.
pub fn leave(status: i32) -> ! {
    // The lock is never released: no other thread can create a file that would remain.
    let all = all();
    for path in all.iter() {
        let _ = std::fs::remove_file(path);
    }
    std::process::exit(status)
}
