//! Directories for files that nobody else knows.

use std::io;
use std::path::Path;

use dotgen_codegen::disk::Scratch;
use tempfile::TempDir;

/// A directory that is removed when this is dropped.
#[derive(Debug)]
pub(super) struct Directory(TempDir);

impl Directory {
    /// A fresh one below `parent`, or below the directory of the system.
    pub(super) fn new(parent: Option<&Path>) -> io::Result<Directory> {
        let parent = parent.map_or_else(std::env::temp_dir, Path::to_owned);
        // Templates compare paths of it with those that Tcl makes, which follows links.
        let parent = parent.canonicalize().unwrap_or(parent);
        let directory = tempfile::Builder::new()
            .prefix("genom")
            .tempdir_in(parent)?;
        Ok(Directory(directory))
    }
}

impl Scratch for Directory {
    fn path(&self) -> &Path {
        self.0.path()
    }

    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        std::fs::write(path, bytes)
    }

    fn remove(&self, path: &Path) {
        let _ = std::fs::remove_file(path);
    }

    fn keep(&mut self) {
        self.0.disable_cleanup(true);
    }
}
