//! The helper that cleans up after a killed process: `dotgen confined watch`.
//!
//! It reads process groups, temporary folders and pending moves of files from a pipe that only its process
//! holds. When the pipe breaks, that process has ended.

use std::ffi::OsStr;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Stdio};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::{COMMAND, OWN_PATH};

/// The arguments that start the helper.
pub(super) const WORDS: [&str; 2] = [COMMAND, "watch"];

/// Maximum delay until the end of a process is noticed.
const GROUP_POLL_INTERVAL: Duration = Duration::from_millis(10);

/// The helper of this process.
pub(super) struct Watcher {
    pipe: Mutex<ChildStdin>,
}

/// An item that the helper knows. Dropped when there is nothing left to clean up.
#[derive(Debug)]
pub(crate) struct CleanupGuard(Vec<u8>);

/// A move or removal of a file, part of a group of moves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Move {
    /// The file.
    pub(crate) from: PathBuf,
    /// The new path; `None` if the file is removed.
    pub(crate) to: Option<PathBuf>,
}

impl Watcher {
    /// The helper, started on first use. `None` if it cannot be started.
    pub(super) fn get() -> Option<&'static Watcher> {
        static WATCHER: LazyLock<Option<Watcher>> = LazyLock::new(|| {
            let mut command = super::again(OWN_PATH.get()?);
            command.args(WORDS).stdin(Stdio::piped());
            command.stdout(Stdio::null()).stderr(Stdio::null());
            // The helper must not keep a folder in use, nor end with the terminal's group.
            command.current_dir("/");
            #[cfg(unix)]
            std::os::unix::process::CommandExt::process_group(&mut command, 0);
            let mut child = command.spawn().ok()?;
            let pipe = Mutex::new(child.stdin.take()?);
            Some(Watcher { pipe })
        });
        WATCHER.as_ref()
    }

    /// Registers a process group, which will be killed: its first process has some time to end by itself.
    pub(super) fn group(&self, id: u32, outlives: Duration) -> CleanupGuard {
        self.tell(format!("g{id}:{}", outlives.as_millis()).into_bytes())
    }

    /// Registers a folder, which will be removed.
    pub(super) fn folder(&self, path: &Path) -> CleanupGuard {
        let mut item = b"f".to_vec();
        item.extend_from_slice(path.as_os_str().as_encoded_bytes());
        self.tell(item)
    }

    /// Registers a group of moves. The helper makes those that are not made yet.
    pub(super) fn moves(&self, moves: &[Move]) -> CleanupGuard {
        self.tell(packed(moves))
    }

    fn tell(&self, item: Vec<u8>) -> CleanupGuard {
        self.write(b'+', &item);
        CleanupGuard(item)
    }

    fn write(&self, sign: u8, item: &[u8]) {
        let mut pipe = self.pipe.lock().unwrap_or_else(PoisonError::into_inner);
        let message = [&[sign], item, b"\0"].concat();
        // A killed helper cleans up nothing; the next start of dotgen does.
        let _ = pipe.write_all(&message);
    }
}

impl Drop for CleanupGuard {
    fn drop(&mut self) {
        if let Some(watcher) = Watcher::get() {
            watcher.write(b'-', &self.0);
        }
    }
}

/// The helper itself: returns when the process has ended and everything is cleaned up.
pub(super) fn serve(mut pipe: impl Read) {
    let mut bytes = Vec::new();
    // A broken pipe is the end as well.
    let _ = pipe.read_to_end(&mut bytes);
    let mut items: Vec<&[u8]> = Vec::new();
    // A part after the last terminator is incomplete.
    let end = bytes.iter().rposition(|byte| *byte == 0).unwrap_or(0);
    for told in bytes[..end].split(|byte| *byte == 0) {
        match told.split_first() {
            Some((b'+', item)) => items.push(item),
            Some((b'-', item)) => items.retain(|byte| *byte != item),
            _ => {}
        }
    }
    let mut groups: Vec<(Duration, i32)> = Vec::new();
    for item in &items {
        match item.split_first() {
            Some((b'g', group)) => groups.extend(group_of(group)),
            Some((b'm', moves)) => carry_out(&unpack(moves)),
            _ => {}
        }
    }
    groups.sort_unstable();
    let since = Instant::now();
    for (outlives, id) in groups {
        end_group(id, since + outlives);
    }
    // Folders come last, when no process writes in them.
    for item in &items {
        if let Some((b'f', path)) = item.split_first() {
            let _ = std::fs::remove_dir_all(path_of(path));
        }
    }
}

/// Makes the moves that are not made yet.
pub(crate) fn carry_out(moves: &[Move]) {
    for movement in moves {
        // Fails for a move that the process has made itself.
        let _ = match &movement.to {
            Some(to) => std::fs::rename(&movement.from, to),
            None => std::fs::remove_file(&movement.from),
        };
    }
}

/// All moves as one item. An incomplete item is ignored, so either all moves are made or none. Each path is
/// preceded by its length and a colon. An empty path stands for a removal.
fn packed(moves: &[Move]) -> Vec<u8> {
    let mut item = b"m".to_vec();
    for movement in moves {
        for path in [Some(&movement.from), movement.to.as_ref()] {
            let path = path.map_or(&b""[..], |path| path.as_os_str().as_encoded_bytes());
            item.extend(format!("{}:", path.len()).into_bytes());
            item.extend_from_slice(path);
        }
    }
    item
}

fn unpack(mut bytes: &[u8]) -> Vec<Move> {
    let mut paths = Vec::new();
    while let Some((path, rest)) = first_path(bytes) {
        paths.push(path);
        bytes = rest;
    }
    let one = |ends: &[&[u8]]| Move {
        from: path_of(ends[0]),
        to: (!ends[1].is_empty()).then(|| path_of(ends[1])),
    };
    paths.chunks_exact(2).map(one).collect()
}

fn first_path(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let colon = bytes.iter().position(|byte| *byte == b':')?;
    let length = str::from_utf8(&bytes[..colon]).ok()?.parse().ok()?;
    bytes[colon + 1..].split_at_checked(length)
}

/// `ID:MILLISECONDS`
fn group_of(text: &[u8]) -> Option<(Duration, i32)> {
    let (id, outlives) = str::from_utf8(text).ok()?.split_once(':')?;
    Some((Duration::from_millis(outlives.parse().ok()?), id.parse().ok()?))
}

/// Kills a group when its first process has ended, or at a time.
fn end_group(id: i32, until: Instant) {
    #[cfg(unix)]
    {
        if let Some(group) = rustix::process::Pid::from_raw(id) {
            while Instant::now() < until && rustix::process::test_kill_process(group).is_ok() {
                std::thread::sleep(GROUP_POLL_INTERVAL);
            }
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
    }
    #[cfg(not(unix))]
    let _ = (id, until);
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
    fn moves_that_were_told_whole_are_done() {
        let directory = tempfile::tempdir().expect("a directory");
        let make = |name: &str| {
            let path = directory.path().join(name);
            std::fs::write(&path, name).expect("a file");
            path
        };
        // A name may contain a newline and a colon.
        let names = ["new:1", "new\n2", "new3"];
        let moves = names.map(|name| Move {
            from: make(name),
            to: Some(directory.path().join(name.replace("new", "file"))),
        });
        let second = Move { from: make("second"), to: None };
        let whole = packed(&[moves[0].clone(), moves[1].clone(), second]);
        let mut told = [b"+", &*whole, b"\0+", &packed(&moves[2..]), b"\0"].concat();
        told.pop();
        serve(&*told);
        let content = |name: &str| std::fs::read_to_string(directory.path().join(name)).ok();
        let text = |text: &str| Some(text.to_owned());
        assert_eq!(
            ["file:1", "file\n2", "second", "file3", "new3"].map(content),
            [text("new:1"), text("new\n2"), None, None, text("new3")]
        );
    }

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
        assert_eq!((left.exists(), done.exists(), cut.exists()), (false, true, true));
    }
}
