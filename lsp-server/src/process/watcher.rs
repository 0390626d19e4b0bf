//! The helper that cleans up after a process that was killed: `dotgen confined watch`.
//!
//! It reads, from a pipe that only its process holds, which process groups and temporary folders there
//! are. When the pipe breaks, that process is gone, however it ended.

use std::ffi::OsStr;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Stdio};
use std::sync::{LazyLock, Mutex, PoisonError};

use super::{COMMAND, OWN};

/// The words that start it.
pub(super) const WORDS: [&str; 2] = [COMMAND, "watch"];

/// The helper of this process.
pub(super) struct Watcher {
    pipe: Mutex<ChildStdin>,
}

/// What the helper knows of. Dropped when there is nothing left to clean up.
#[derive(Debug)]
pub(super) struct Watched(Vec<u8>);

impl Watcher {
    /// The helper; started when it is first wanted. `None` where it cannot be.
    pub(super) fn get() -> Option<&'static Watcher> {
        static WATCHER: LazyLock<Option<Watcher>> = LazyLock::new(|| {
            let mut command = super::again(OWN.get()?);
            command.args(WORDS).stdin(Stdio::piped());
            command.stdout(Stdio::null()).stderr(Stdio::null());
            // It must not keep a folder busy, nor end with the terminal's group.
            command.current_dir("/");
            #[cfg(unix)]
            std::os::unix::process::CommandExt::process_group(&mut command, 0);
            let mut child = command.spawn().ok()?;
            let pipe = Mutex::new(child.stdin.take()?);
            Some(Watcher { pipe })
        });
        WATCHER.as_ref()
    }

    /// A process group to be ended.
    pub(super) fn group(&self, id: u32) -> Watched {
        self.tell(format!("g{id}").into_bytes())
    }

    /// A folder to be removed.
    pub(super) fn folder(&self, path: &Path) -> Watched {
        let mut item = b"f".to_vec();
        item.extend_from_slice(path.as_os_str().as_encoded_bytes());
        self.tell(item)
    }

    fn tell(&self, item: Vec<u8>) -> Watched {
        self.write(b'+', &item);
        Watched(item)
    }

    fn write(&self, sign: u8, item: &[u8]) {
        let mut pipe = self.pipe.lock().unwrap_or_else(PoisonError::into_inner);
        let message = [&[sign], item, b"\0"].concat();
        // A helper that somebody has killed cleans up nothing; the next start does.
        let _ = pipe.write_all(&message);
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        if let Some(watcher) = Watcher::get() {
            watcher.write(b'-', &self.0);
        }
    }
}

/// The helper itself: returns when the process is gone and all is cleaned up.
pub(super) fn serve(mut pipe: impl Read) {
    let mut bytes = Vec::new();
    // A broken pipe is the end as well.
    let _ = pipe.read_to_end(&mut bytes);
    let mut items: Vec<&[u8]> = Vec::new();
    // What follows the last end of an item was cut off.
    let end = bytes.iter().rposition(|it| *it == 0).unwrap_or(0);
    for told in bytes[..end].split(|it| *it == 0) {
        match told.split_first() {
            Some((b'+', item)) => items.push(item),
            Some((b'-', item)) => items.retain(|it| *it != item),
            _ => {}
        }
    }
    for item in &items {
        if let Some((b'g', id)) = item.split_first() {
            end_group(id);
        }
    }
    // Folders last: nobody writes in them any more.
    for item in &items {
        if let Some((b'f', path)) = item.split_first() {
            let _ = std::fs::remove_dir_all(path_of(path));
        }
    }
}

fn end_group(id: &[u8]) {
    #[cfg(unix)]
    {
        let id = str::from_utf8(id).ok().and_then(|it| it.parse().ok());
        if let Some(group) = id.and_then(rustix::process::Pid::from_raw) {
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
    }
    #[cfg(not(unix))]
    let _ = id;
}

#[cfg(unix)]
fn path_of(bytes: &[u8]) -> PathBuf {
    use std::os::unix::ffi::OsStrExt;
    PathBuf::from(OsStr::from_bytes(bytes))
}

#[cfg(not(unix))]
fn path_of(bytes: &[u8]) -> PathBuf {
    PathBuf::from(String::from_utf8_lossy(bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_removed() {
        let directory = tempfile::tempdir().expect("a directory");
        let make = |name: &str| {
            let path = directory.path().join(name);
            std::fs::create_dir_all(path.join("inner")).expect("a folder");
            path
        };
        let (left, done, cut) = (make("left"), make("done"), make("cut"));
        let mut told = Vec::new();
        for (sign, path) in [("+", &left), ("+", &done), ("-", &done), ("+", &cut)] {
            told.extend(format!("{sign}f{}\0", path.display()).into_bytes());
        }
        told.pop();
        serve(&*told);
        assert_eq!(
            (left.exists(), done.exists(), cut.exists()),
            (false, true, true)
        );
    }
}
