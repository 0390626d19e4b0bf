//! The files written so far by a template. They are written to disk when the template has ended.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use super::{PreviewFile, concern, permissions};
use crate::disk::{Disk, NewContent, WriteError};
use crate::template::Failure;
use crate::template::readable_files::plain;

/// The destination of the files of a template: files in memory over files on disk. Reads return what was
/// written before.
#[derive(Debug)]
pub struct OutputSink {
    /// The files, by absolute path.
    pub files: BTreeMap<PathBuf, PreviewFile>,
    /// True if the files only stay in memory. Otherwise they are written to disk after the template has ended
    /// without an error: all files, or none.
    pub preview: bool,
}

impl OutputSink {
    /// The disk.
    pub const DIRECT: OutputSink = OutputSink { files: BTreeMap::new(), preview: false };
    /// A sink that writes nothing.
    pub const PREVIEW: OutputSink = OutputSink { files: BTreeMap::new(), preview: true };

    /// Number of files that differ from those of the disk.
    pub(crate) fn changed(&self) -> usize {
        let differ = |file: &&PreviewFile| file.before.as_ref() != Some(&file.after);
        self.files.values().filter(differ).count()
    }

    /// Ends the run: writes the files to disk, unless they are only a preview or the run has failed.
    pub(crate) fn finish(
        self,
        disk: &dyn Disk,
        failed: bool,
    ) -> (OutputSink, Result<(), WriteError>) {
        if self.preview {
            return (self, Ok(()));
        }
        let mut written = Ok(());
        if !failed {
            let (mut contents, mut modes) = (Vec::new(), Vec::new());
            for (path, file) in self.files {
                // An unchanged file is not written: build tools compare modification times.
                if file.before.as_ref() == Some(&file.after) {
                    modes.extend(file.mode.map(|mode| (path, mode)));
                } else {
                    contents.push(NewContent {
                        mode: file.mode,
                        before: file.before.into(),
                        ..NewContent::new(path, file.after)
                    });
                }
            }
            written = disk.write(&contents);
            for (path, mode) in modes {
                if let (Ok(()), Err(reason)) = (&written, disk.set_mode(&path, mode)) {
                    written = Err(WriteError { path, reason, changed: Vec::new(), of: 1 });
                }
            }
        }
        (OutputSink::DIRECT, written)
    }

    /// Bytes of a file, `None` if it does not exist.
    ///
    /// # Errors
    /// Fails if the file on disk cannot be read.
    pub(crate) fn read(&self, disk: &dyn Disk, path: &Path) -> io::Result<Option<Vec<u8>>> {
        match self.files.get(&plain(disk, path)) {
            Some(file) => Ok(Some(file.after.clone())),
            None => on_disk(disk, path),
        }
    }

    pub(crate) fn exists(&self, disk: &dyn Disk, path: &Path) -> bool {
        self.files.contains_key(&plain(disk, path)) || disk.exists(path)
    }

    /// Stores bytes at a path, replacing any existing content.
    ///
    /// # Errors
    /// Fails if an existing file on disk cannot be read.
    pub(crate) fn write(&mut self, disk: &dyn Disk, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let path = plain(disk, path);
        let known = self.files.get(&path);
        let (before, mode) = match known {
            Some(file) => (file.before.clone(), file.mode),
            None => (on_disk(disk, &path)?, None),
        };
        let file = PreviewFile { before, after: bytes.to_vec(), mode, concern: None };
        self.files.insert(path, file);
        Ok(())
    }

    /// The mode that a file would have with permissions in one of the forms of Tcl.
    ///
    /// # Errors
    /// Fails for an unknown form.
    pub(crate) fn mode(&self, disk: &dyn Disk, path: &Path, text: &str) -> Result<u32, Failure> {
        let known = self.files.get(&plain(disk, path)).and_then(|file| file.mode);
        let current =
            known.unwrap_or_else(|| match disk.status(path).map_or(0, |status| status.mode) {
                0 => 0o644,
                mode => mode,
            });
        permissions::parse(text, current)
            .ok_or_else(|| Failure::Error(format!("unknown permission string format \"{text}\"")))
    }

    /// Records the reason why the user must review a file. `folders` are the folders of the results.
    pub(crate) fn mark(&mut self, disk: &dyn Disk, path: &Path, folders: &[PathBuf]) {
        if let Some(file) = self.files.get_mut(&plain(disk, path)) {
            file.concern = concern(disk, path, file.mode, folders);
        }
    }

    /// Sets the permissions of a file, in one of the forms of Tcl.
    ///
    /// # Errors
    /// Fails for an unknown form.
    pub(crate) fn set_permissions(
        &mut self,
        disk: &dyn Disk,
        path: &Path,
        text: &str,
    ) -> Result<(), Failure> {
        let key = plain(disk, path);
        let on_disk_mode = || disk.status(path).map_or(0, |status| status.mode);
        let mode = self.mode(disk, path, text)?;
        match self.files.get_mut(&key) {
            Some(file) => file.mode = Some(mode),
            // Up to date, except for its permissions.
            None if mode != on_disk_mode() => {
                let bytes = on_disk(disk, &key).ok().flatten().unwrap_or_default();
                let file = PreviewFile {
                    before: Some(bytes.clone()),
                    after: bytes,
                    mode: Some(mode),
                    concern: None,
                };
                self.files.insert(key, file);
            }
            None => {}
        }
        Ok(())
    }
}

fn on_disk(disk: &dyn Disk, path: &Path) -> io::Result<Option<Vec<u8>>> {
    match disk.read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}
