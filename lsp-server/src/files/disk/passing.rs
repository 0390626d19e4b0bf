//! Files that are only there while this process works: sockets, and files under temporary names.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// All of them.
static ALL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn all() -> MutexGuard<'static, Vec<PathBuf>> {
    ALL.lock().unwrap_or_else(|it| it.into_inner())
}

/// A file that is removed when this is dropped, and by [`leave`].
#[derive(Debug)]
pub(crate) struct Passing {
    path: PathBuf,
}

impl Passing {
    /// For a file that is there, or will be.
    pub(crate) fn new(path: PathBuf) -> Passing {
        all().push(path.clone());
        Passing { path }
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        let mut all = all();
        all.retain(|it| *it != self.path);
        // It may have got another name, or somebody may have taken it away.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Ends this process at once, without such files. What it has started ends with it.
pub(crate) fn leave(status: i32) -> ! {
    // The lock stays taken: nothing begins any more that would be left behind.
    let all = all();
    for it in all.iter() {
        let _ = std::fs::remove_file(it);
    }
    std::process::exit(status)
}
