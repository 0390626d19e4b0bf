//! The files of the disk, for tests: without the care that files of users get.

use std::io;
use std::path::{Path, PathBuf};

use dotgen_codegen::disk::{Disk, Entry, Kind, NewContent, Status, WriteError};

#[derive(Debug)]
pub(crate) struct Files;

impl Disk for Files {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        std::fs::read(path)
    }

    fn status(&self, path: &Path) -> Option<Status> {
        let metadata = std::fs::metadata(path).ok()?;
        Some(Status {
            kind: if metadata.is_dir() { Kind::Directory } else { Kind::File },
            mode: mode(&metadata),
            modified: metadata.modified().ok(),
        })
    }

    fn list(&self, directory: &Path) -> io::Result<Vec<Entry>> {
        let entries = std::fs::read_dir(directory)?.flatten();
        let entry = |entry: std::fs::DirEntry| Entry {
            path: entry.path(),
            is_dir: entry.file_type().is_ok_and(|file_type| file_type.is_dir()),
        };
        Ok(entries.map(entry).collect())
    }

    fn canonical(&self, path: &Path) -> io::Result<PathBuf> {
        path.canonicalize()
    }

    fn current_dir(&self) -> PathBuf {
        std::env::current_dir().unwrap_or_default()
    }

    fn write(&self, files: &[NewContent]) -> Result<(), WriteError> {
        for file in files {
            let written = std::fs::create_dir_all(file.path.parent().unwrap_or(&file.path))
                .and_then(|()| std::fs::write(&file.path, &file.bytes))
                .and_then(|()| file.mode.map_or(Ok(()), |mode| self.set_mode(&file.path, mode)));
            written.map_err(|reason| WriteError {
                path: file.path.clone(),
                reason,
                changed: Vec::new(),
                of: files.len(),
            })?;
        }
        Ok(())
    }

    #[cfg(unix)]
    fn set_mode(&self, path: &Path, mode: u32) -> io::Result<()> {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode))
    }

    #[cfg(not(unix))]
    fn set_mode(&self, _: &Path, _: u32) -> io::Result<()> {
        Ok(())
    }

    fn is_link(&self, path: &Path) -> bool {
        path.is_symlink()
    }

    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        std::fs::write(path, bytes)
    }

    fn remove(&self, path: &Path) {
        let _ = std::fs::remove_file(path);
    }
}

#[cfg(unix)]
fn mode(metadata: &std::fs::Metadata) -> u32 {
    use std::os::unix::fs::PermissionsExt;
    metadata.permissions().mode() & 0o7777
}

#[cfg(not(unix))]
fn mode(_: &std::fs::Metadata) -> u32 {
    0
}
