//! Files: reading for analysis, writing for users, and packages.

pub mod disk;
pub mod history;
pub mod vfs;

use std::fs::File;
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// Reads a regular file. A pipe, device or other special file is an error at once: reading it might never
/// end.
///
/// # Errors
/// The errors of the system, and `InvalidInput` for a file that is not regular.
pub(crate) fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let mut options = File::options();
    options.read(true);
    // Opening a pipe would wait for a writer. A read of a file of the kernel could wait for data.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        rustix::fs::OFlags::NONBLOCK.bits().cast_signed(),
    );
    let not_regular = || io::Error::new(ErrorKind::InvalidInput, "it is not a regular file");
    // Opening a device may have an effect.
    if std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        return Err(not_regular());
    }
    let mut file = options.open(path)?;
    let metadata = file.metadata()?;
    if metadata.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    // The path may lead to another file now.
    if !metadata.is_file() {
        return Err(not_regular());
    }
    let mut bytes = Vec::new();
    match file.read_to_end(&mut bytes) {
        Ok(_) => Ok(bytes),
        Err(error) if error.kind() == ErrorKind::WouldBlock => Err(not_regular()),
        Err(error) => Err(error),
    }
}

/// Reads a regular file as UTF-8.
///
/// # Errors
/// Those of [`read_regular`], and `InvalidData` for other text.
pub fn read_regular_to_string(path: &Path) -> io::Result<String> {
    String::from_utf8(read_regular(path)?)
        .map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is not UTF-8"))
}

/// The message of an error, without the error number: "permission denied".
pub fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((text, _)) => text.to_lowercase(),
        None => text,
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let special = folder.path().join("special");
        let _socket = std::os::unix::net::UnixListener::bind(&special).unwrap();
        let link = folder.path().join("link.idl");
        std::os::unix::fs::symlink(&special, &link).unwrap();
        for path in [&special, &link, Path::new("/dev/zero"), Path::new("/dev/null")] {
            let error = read_regular(path).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidInput, "{}", path.display());
        }
        assert_eq!(read_regular(folder.path()).unwrap_err().kind(), ErrorKind::IsADirectory);
        let file = folder.path().join("a");
        assert_eq!(read_regular(&file).unwrap_err().kind(), ErrorKind::NotFound);
        std::fs::write(&file, b"a\xff").unwrap();
        assert_eq!(read_regular(&file).unwrap(), b"a\xff");
        assert_eq!(read_regular_to_string(&file).unwrap_err().kind(), ErrorKind::InvalidData);
        // A file of the kernel that waits for data, unless reading it is not permitted.
        if Path::new("/proc/kmsg").exists() {
            assert!(read_regular(Path::new("/proc/kmsg")).is_err());
        }
    }
}
