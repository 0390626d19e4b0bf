//! The paths of the sockets of this user.

use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

/// The extension of the name of a socket.
const SUFFIX: &str = "sock";

/// Returns the folder that only this user may enter, and creates it if necessary.
///
/// # Errors
/// The folder cannot be created, or another user can enter it.
pub(crate) fn folder() -> io::Result<PathBuf> {
    let own = rustix::process::getuid().as_raw();
    let folder = match std::env::var_os("XDG_RUNTIME_DIR").filter(|variable| !variable.is_empty()) {
        Some(variable) => PathBuf::from(variable).join("dotgen"),
        None => std::env::temp_dir().join(format!("dotgen-{own}")),
    };
    match std::fs::DirBuilder::new().mode(0o700).create(&folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    let found = std::fs::symlink_metadata(&folder)?;
    if !found.is_dir() || found.uid() != own || found.mode() & 0o077 != 0 {
        let why = format!("`{}` is open to others than this user", folder.display());
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, why));
    }
    Ok(folder)
}

/// Returns the path of the socket of a run.
pub fn socket(name: &str) -> io::Result<PathBuf> {
    Ok(folder()?.join(format!("{name}.{SUFFIX}")))
}

/// Returns the file with the token of a run that listens at a TCP port.
///
/// # Errors
/// The folder cannot be created, or another user can enter it.
pub(super) fn token(port: u16) -> io::Result<PathBuf> {
    Ok(folder()?.join(format!("{port}.token")))
}

/// Connects to a run: the one at a path, or else the only one.
///
/// # Errors
/// A message: no run listens, or several runs do.
pub fn connect(path: Option<&Path>) -> Result<UnixStream, String> {
    if let Some(path) = path {
        let wrong = |error| format!("no run listens at `{}`: {error}", path.display());
        return UnixStream::connect(path).map_err(wrong);
    }
    let folder = folder().map_err(|error| error.to_string())?;
    let entries = std::fs::read_dir(&folder).map_err(|error| error.to_string())?;
    let sockets = entries.filter_map(Result::ok).map(|entry| entry.path());
    let sockets =
        sockets.filter(|socket| socket.extension().is_some_and(|extension| extension == SUFFIX));
    let mut found: Vec<(PathBuf, UnixStream)> = sockets
        .filter_map(|socket| UnixStream::connect(&socket).ok().map(|stream| (socket, stream)))
        .collect();
    match found.len() {
        0 => Err("no run accepts requests; start one with `dotgen run --clock real FILE`. A run that was just started \
             may still be compiling".to_owned()),
        1 => found.pop().map(|(_, stream)| stream).ok_or_else(String::new),
        _ => {
            let names = found.iter().map(|(socket, _)| socket.display().to_string());
            let names: Vec<String> = names.collect();
            let names = names.join(", ");
            Err(format!(
                "there are several runs; choose one with --socket: {names}"
            ))
        }
    }
}
