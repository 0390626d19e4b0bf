//! Temporary folders. Each is locked by the process that created it: a folder without a lock is a leftover.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use dotgen_codegen::process::Folder;

use super::watcher::{CleanupGuard, Watcher};

/// The beginning of the names of temporary folders. Leftovers are known by it, so no other folder may be
/// called so.
const PREFIX: &str = "dotgen-temporary-";
/// Minimum age of leftovers: a younger folder may not be locked yet.
const MIN_LEFTOVER_AGE: Duration = Duration::from_mins(1);
/// Minimum space of a file on usual file systems, in bytes.
const BLOCK: u64 = 4096;

#[derive(Debug)]
struct Temporary {
    folder: Option<tempfile::TempDir>,
    path: PathBuf,
    /// The open file that holds the lock.
    _lock: Option<File>,
    watched: Option<CleanupGuard>,
}

impl Folder for Temporary {
    fn path(&self) -> &Path {
        &self.path
    }

    fn keep(&mut self) {
        if let Some(folder) = self.folder.take() {
            let _ = folder.keep();
        }
        self.watched = None;
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // The folder is removed first: the helper must know it as long as it exists.
        self.folder = None;
        self.watched = None;
    }
}

/// Creates a temporary folder.
pub(super) fn create(parent: Option<&Path>) -> io::Result<Box<dyn Folder>> {
    let parent = parent.map_or_else(std::env::temp_dir, Path::to_owned);
    let parent = parent.canonicalize().unwrap_or(parent);
    let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(parent)?;
    let path = folder.path().to_owned();
    let watched = Watcher::get().map(|watcher| watcher.folder(&path));
    Ok(Box::new(Temporary { _lock: lock(&path, false), folder: Some(folder), path, watched }))
}

/// The space of a folder in bytes. Every entry counts as at least a block, so that many empty files count
/// too.
pub(super) fn size(folder: &Path) -> u64 {
    let entries = walkdir::WalkDir::new(folder).into_iter().flatten();
    let space = |entry: walkdir::DirEntry| {
        let length = entry.metadata().map_or(0, |metadata| metadata.len());
        length.next_multiple_of(BLOCK).max(BLOCK)
    };
    entries.map(space).sum()
}

/// Removes leftovers of processes that were killed together with their helpers.
pub fn clean_up() {
    clean_up_in(&std::env::temp_dir());
}

fn clean_up_in(parent: &Path) {
    let entries = std::fs::read_dir(parent);
    for entry in entries.into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_ours = name.as_encoded_bytes().starts_with(PREFIX.as_bytes());
        // The type of the entry itself: a link is not a folder.
        if !is_ours || !entry.file_type().is_ok_and(|file_type| file_type.is_dir()) {
            continue;
        }
        let changed = entry.metadata().and_then(|metadata| metadata.modified());
        let age =
            changed.map(|metadata| SystemTime::now().duration_since(metadata).unwrap_or_default());
        if !age.is_ok_and(|age| age > MIN_LEFTOVER_AGE) {
            continue;
        }
        if let Some(_lock) = lock(&entry.path(), true) {
            tracing::info!(path = %entry.path().display(), "removing what was left behind");
            // Fails for folders of other users.
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

/// Locks a folder, exclusively or shared; `None` if that fails.
#[cfg(unix)]
fn lock(path: &Path, alone: bool) -> Option<File> {
    use rustix::fs::{FlockOperation, flock};
    let file = File::open(path).ok()?;
    let how = if alone {
        FlockOperation::NonBlockingLockExclusive
    } else {
        FlockOperation::NonBlockingLockShared
    };
    flock(&file, how).ok().map(|()| file)
}

#[cfg(not(unix))]
fn lock(_: &Path, _: bool) -> Option<File> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_uses_is_removed_some_time_later() {
        let parent = tempfile::tempdir().expect("a directory");
        let old = SystemTime::now() - 2 * MIN_LEFTOVER_AGE;
        let make = |name: &str, changed: SystemTime| {
            let path = parent.path().join(name);
            std::fs::create_dir(&path).expect("a folder");
            std::fs::write(path.join("file"), "x").expect("a file");
            let folder = File::open(&path).expect("a folder");
            folder.set_modified(changed).expect("its date changes");
            path
        };
        let left = make("dotgen-temporary-left", old);
        let young = make("dotgen-temporary-young", SystemTime::now());
        let other = make("dotgen-robot", old);
        let used = make("dotgen-temporary-used", old);
        let _lock = lock(&used, false).expect("a lock");
        clean_up_in(parent.path());
        let there = [&left, &young, &other, &used].map(|path| path.exists());
        assert_eq!(there, [false, true, true, true]);
    }

    #[test]
    fn a_folder_in_use_is_locked() {
        let folder = create(None).expect("a folder");
        assert!(lock(folder.path(), true).is_none());
        let path = folder.path().to_owned();
        drop(folder);
        assert!(!path.exists());
    }
}
