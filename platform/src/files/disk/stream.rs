//! A file that is written as a whole or not at all: a trace. It gets its name when it is complete.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::temporary_file::TemporaryFile;
use super::write;

/// A file with a temporary name, next to the file that it replaces. It is removed on drop. Devices and pipes
/// are written directly.
#[derive(Debug)]
pub struct Stream {
    out: BufWriter<File>,
    /// The temporary file, and the path that it replaces.
    replaces: Option<(TemporaryFile, PathBuf)>,
}

impl Stream {
    /// Creates the file. The path need not exist; its directory must.
    ///
    /// # Errors
    /// The file cannot be written there, or the existing file is read-only.
    pub fn create(path: &Path) -> io::Result<Stream> {
        let (file, replaces) = match std::fs::metadata(path) {
            Ok(metadata) if !metadata.is_file() => (File::options().write(true).open(path)?, None),
            _ => {
                let (temporary, target, file) = write::beside(path)?;
                (file, Some((TemporaryFile::new(temporary), target)))
            }
        };
        Ok(Stream { out: BufWriter::with_capacity(1 << 20, file), replaces })
    }

    /// Renames the file to its final name, and replaces an existing file.
    ///
    /// # Errors
    /// A write failed. The existing file is then unchanged.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.flush()?;
        let Some((temporary, target)) = &self.replaces else {
            return Ok(());
        };
        self.out.get_ref().sync_all()?;
        std::fs::rename(temporary.path(), target)
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_its_name_when_it_is_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.out");
        std::fs::write(&path, "before").expect("written");
        let names = || -> Vec<PathBuf> {
            let entries = std::fs::read_dir(folder.path()).expect("a folder");
            entries.flatten().map(|entry| entry.path()).collect()
        };
        let mut dropped = Stream::create(&path).expect("created");
        dropped.write_all(b"half").expect("written");
        drop(dropped);
        assert_eq!(names(), std::slice::from_ref(&path), "nothing stays behind");
        let mut stream = Stream::create(&path).expect("created");
        stream.write_all(b"whole").expect("written");
        assert_eq!(std::fs::read(&path).expect("a file"), b"before");
        stream.finish().expect("finished");
        assert_eq!(std::fs::read(&path).expect("a file"), b"whole");
        assert_eq!(names(), [path]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_device_is_written_and_not_replaced() {
        let device = Path::new("/dev/full");
        let kind = || {
            let metadata = device.metadata().expect("a device");
            std::os::unix::fs::FileTypeExt::is_char_device(&metadata.file_type())
        };
        assert!(kind());
        let mut stream = Stream::create(device).expect("opened");
        assert!(stream.replaces.is_none(), "it would take the place of the device");
        stream.write_all(b"something").expect("it waits");
        let error = stream.finish().expect_err("there is no room");
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(kind());
    }
}
