//! A file that grows during a run: a log, a trace, a recording.
//!
//! A separate thread writes the file, so that the recording thread does not wait for the disk, except if much
//! data is waiting. Recorded data is in the file within [`FLUSH_INTERVAL`], and on the disk within [`SYNC`].
//! A process that is killed loses at most the data of that time. There is no temporary file.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Maximum delay until bytes are in the file.
const FLUSH_INTERVAL: Duration = Duration::from_millis(200);

/// Maximum delay until bytes in the file are also on the disk.
const SYNC: Duration = Duration::from_secs(1);

/// Number of bytes that are written at once, without a pause.
const MANY: usize = 256 << 10;

/// Maximum number of waiting bytes.
const LIMIT: usize = 8 << 20;

/// A file that grows. See the [module](self).
#[derive(Debug)]
pub struct AppendedFile {
    shared: Arc<Shared>,
    writer: Option<JoinHandle<()>>,
    /// The path, if the file did not exist before.
    new: Option<PathBuf>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    /// Signals that there is much to write, or that the data is complete.
    more: Condvar,
    /// Signals that there is room again.
    room: Condvar,
}

#[derive(Debug, Default)]
struct State {
    bytes: Vec<u8>,
    over: bool,
    /// True if the recording is complete: the file is emptied even if nothing was written.
    finished: bool,
    failed: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl AppendedFile {
    /// Opens a file that need not exist; its directory must. The file keeps its content until the first
    /// write. If the first write fails, the file is unchanged. `tell` receives the first error.
    ///
    /// # Errors
    /// The file cannot be opened or created.
    pub fn create(
        path: &Path,
        tell: impl FnOnce(&io::Error) + Send + 'static,
    ) -> io::Result<AppendedFile> {
        let made = OpenOptions::new().write(true).create_new(true).open(path);
        let (file, new) = match made {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                let mut options = OpenOptions::new();
                // The link may point to a file that does not exist.
                let file = options.write(true).create(true).truncate(false).open(path)?;
                (file, None)
            }
            made => (made?, Some(path.to_owned())),
        };
        let shared = Arc::new(Shared::default());
        let writer = std::thread::Builder::new().name("recording".to_owned());
        let writer = writer.spawn({
            let shared = shared.clone();
            move || {
                if let Err(error) = write(&shared, file) {
                    let mut state = shared.lock();
                    (state.failed, state.bytes) = (true, Vec::new());
                    drop(state);
                    shared.room.notify_all();
                    tell(&error);
                }
            }
        })?;
        Ok(AppendedFile { writer: Some(writer), shared, new })
    }

    /// Ends the file. Returns false after an error, which was already reported.
    pub fn finish(mut self) -> bool {
        self.new = None;
        self.shared.lock().finished = true;
        self.end();
        !self.shared.lock().failed
    }

    fn end(&mut self) {
        self.shared.lock().over = true;
        self.shared.more.notify_all();
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
    }
}

/// Removes the file if it was not finished and did not exist before: its run did not begin.
impl Drop for AppendedFile {
    fn drop(&mut self) {
        self.end();
        if let Some(path) = self.new.take().filter(|_| !std::thread::panicking()) {
            let _ = std::fs::remove_file(path);
        }
    }
}

impl Write for AppendedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.shared.lock();
        while state.bytes.len() >= LIMIT && !state.failed {
            let waited = self.shared.room.wait(state);
            state = waited.unwrap_or_else(std::sync::PoisonError::into_inner);
        }
        // After an error, which was reported, data is dropped.
        if !state.failed {
            let before = state.bytes.len();
            state.bytes.extend_from_slice(bytes);
            if before < MANY && state.bytes.len() >= MANY {
                self.shared.more.notify_all();
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Writes until the data is complete.
fn write(shared: &Shared, mut file: File) -> io::Result<()> {
    let is_file = file.metadata().is_ok_and(|metadata| metadata.is_file());
    let mut piece = Vec::new();
    let mut begun = false;
    // The time of the first write that is not yet synced.
    let mut unsynced: Option<Instant> = None;
    loop {
        let mut state = shared.lock();
        if state.bytes.len() < MANY && !state.over {
            let waited = shared.more.wait_timeout(state, FLUSH_INTERVAL);
            state = waited.unwrap_or_else(std::sync::PoisonError::into_inner).0;
        }
        piece.clear();
        std::mem::swap(&mut state.bytes, &mut piece);
        let (over, finished) = (state.over, state.finished);
        drop(state);
        shared.room.notify_all();
        if is_file && !begun && (finished || !piece.is_empty()) {
            file.set_len(0)?;
            begun = true;
        }
        if !piece.is_empty() {
            file.write_all(&piece)?;
            unsynced.get_or_insert_with(Instant::now);
        }
        if is_file
            && (over || unsynced.is_some_and(|instant| instant.elapsed() + FLUSH_INTERVAL >= SYNC))
        {
            sync(&file)?;
            unsynced = None;
        }
        if over {
            return Ok(());
        }
    }
}

/// Syncs a file. Some file systems do not support this, which is not an error of the file.
fn sync(file: &File) -> io::Result<()> {
    let cannot = |error: &io::Error| {
        matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported)
    };
    file.sync_data().or_else(|error| if cannot(&error) { Ok(()) } else { Err(error) })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    fn growing(path: &Path) -> AppendedFile {
        AppendedFile::create(path, |error| panic!("{error}")).expect("created")
    }

    #[test]
    fn what_is_written_replaces_what_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log");
        std::fs::write(&path, "something that is longer").expect("written");
        let mut log = growing(&path);
        for piece in 0..100_000 {
            writeln!(log, "{piece} and some words to fill the room").expect("never fails");
        }
        assert!(log.finish());
        let text = std::fs::read_to_string(&path).expect("a file");
        assert_eq!(text.lines().count(), 100_000);
        assert!(text.starts_with("0 and") && text.ends_with('\n'));
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }

    #[test]
    fn a_file_of_a_run_that_does_not_begin_is_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log");
        drop(growing(&path));
        assert!(!path.exists());
        // An existing file is kept, and emptied by a run that records nothing.
        std::fs::write(&path, "before").expect("written");
        drop(growing(&path));
        let log = growing(&path);
        assert_eq!(std::fs::read(&path).expect("a file"), b"before");
        assert!(log.finish());
        assert_eq!(std::fs::read(&path).expect("a file"), b"");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_told_once_and_stops_nobody() {
        let (send, told) = channel();
        let tell = move |error: &io::Error| send.send(error.kind()).expect("heard");
        let mut log = AppendedFile::create(Path::new("/dev/full"), tell).expect("opened");
        // More than the limit of waiting bytes.
        for _ in 0..100 {
            log.write_all(&vec![b'x'; LIMIT / 10]).expect("never fails");
        }
        assert!(!log.finish());
        assert_eq!(told.iter().collect::<Vec<_>>(), [ErrorKind::StorageFull]);
        assert!(Path::new("/dev/full").exists());
    }
}
