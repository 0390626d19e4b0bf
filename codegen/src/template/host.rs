//! The Tcl interpreter: a `tclsh` process that communicates over pipes.
//!
//! The process runs the engine's prelude, sent on its standard input. After that both directions carry
//! messages: a line with the lengths of the words in bytes, then the words.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::process::{Access, Channels, Meter, Process, Processes, Program, Resources};

const PRELUDE: &str = include_str!("prelude.tcl");

/// Maximum length of a message, in bytes. Longer ones are refused; no template writes as much.
const MESSAGE_LIMIT: usize = 1 << 30;

/// The resource limits of a template.
#[derive(Debug, Clone, Default)]
pub struct Limits {
    /// Time until the interpreter is killed.
    pub time: Option<Duration>,
    /// Address space of the interpreter, in bytes (on systems that limit it).
    pub memory: Option<u64>,
    /// Size of everything printed and of everything written, in bytes.
    pub output: Option<u64>,
    /// Set to stop the run.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl Limits {
    /// The limits that the operating system enforces.
    pub(crate) fn resources(&self) -> Resources {
        Resources { memory: self.memory, time: self.time, file: self.output }
    }

    /// Limits for running a template from an editor: 60 s, 1 GiB, 64 MiB.
    pub fn preview() -> Limits {
        Limits {
            time: Some(Duration::from_mins(1)),
            memory: Some(1 << 30),
            output: Some(64 << 20),
            cancel: None,
        }
    }
}

/// Finds the Tcl shell: `DOTGEN_TCLSH`, else `tclsh8.6` or `tclsh` on the path.
///
/// # Errors
/// Returns a message with the package to install.
pub fn find_tclsh() -> Result<PathBuf, String> {
    if let Some(given) = std::env::var_os("DOTGEN_TCLSH").filter(|variable| !variable.is_empty()) {
        let given = PathBuf::from(given);
        if given.is_file() {
            return Ok(given);
        }
        return Err(format!("DOTGEN_TCLSH names {}, which is not a file", given.display()));
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    for name in ["tclsh8.6", "tclsh86", "tclsh"] {
        for dir in std::env::split_paths(&path) {
            let candidate = dir.join(name);
            if candidate.is_file() {
                return Ok(candidate);
            }
        }
    }
    Err("this template needs Tcl 8.6, and no tclsh was found: install it \
         (Debian and Ubuntu: `apt install tcl`; Fedora: `dnf install tcl`; macOS: \
         `brew install tcl-tk@8`; robotpkg: lang/tcl), or set DOTGEN_TCLSH to its path"
        .into())
}

const RUNNING: u8 = 0;
const TIMED_OUT: u8 = 1;
const CANCELLED: u8 = 2;
const TOO_LARGE: u8 = 3;

/// Interval between checks of the cancellation flag and the written size.
const STEP: Duration = Duration::from_millis(20);

/// A running interpreter. Dropping it kills the process.
pub(crate) struct Host {
    child: Arc<Mutex<Process>>,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    errors: Option<JoinHandle<Vec<u8>>>,
    ended: Arc<AtomicU8>,
    /// Dropped to stop the watchdog thread.
    watch: Option<mpsc::Sender<()>>,
}

impl Host {
    /// Starts the interpreter in a directory (empty: the current one). With `capture`, its error channel is
    /// kept for [`Host::take_errors`]; otherwise it is inherited.
    ///
    /// # Errors
    /// Fails if there is no Tcl shell, or if it cannot be started.
    pub(crate) fn start(
        processes: &dyn Processes,
        limits: &Limits,
        dir: &Path,
        capture: bool,
        access: Option<Access>,
    ) -> Result<Host, String> {
        let tclsh = find_tclsh()?;
        // If a template writes files itself, the system limits the size of each file, not their number.
        let folders = access.as_ref().map(|access| access.write.clone());
        let space = (limits.output.zip(folders))
            .map(|(most, folders)| DiskQuota { most, used: processes.meter(folders) });
        let mut process = processes
            .start(&Program {
                path: tclsh.clone(),
                arguments: Vec::new(),
                directory: dir.to_owned(),
                channels: if capture { Channels::Pipes } else { Channels::PipesBut },
                resources: limits.resources(),
                access,
                outlives: std::time::Duration::ZERO,
            })
            .map_err(|error| format!("cannot start {}: {error}", tclsh.display()))?;
        let child = &mut process.child;
        let (Some(mut to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("cannot talk to tclsh".into());
        };
        let errors = child.stderr.take().map(|mut stderr| {
            let limit = limits.output.unwrap_or(u64::MAX);
            std::thread::spawn(move || {
                let mut text = Vec::new();
                let _ = stderr.by_ref().take(limit).read_to_end(&mut text);
                // Keep reading: a full pipe would block the template.
                let _ = std::io::copy(&mut stderr, &mut std::io::sink());
                text
            })
        });
        to.write_all(PRELUDE.as_bytes())
            .and_then(|()| to.flush())
            .map_err(|error| format!("cannot talk to tclsh: {error}"))?;
        let child = Arc::new(Mutex::new(process));
        let ended = Arc::new(AtomicU8::new(RUNNING));
        let watch = watch(limits, space, &child, &ended);
        Ok(Host { child, to, from: BufReader::with_capacity(1 << 16, from), errors, ended, watch })
    }

    /// Receives the next message.
    ///
    /// # Errors
    /// Fails if the process has ended.
    pub(crate) fn receive(&mut self) -> Result<Vec<Vec<u8>>, String> {
        let mut head = String::new();
        let read = self.from.read_line(&mut head);
        if !matches!(read, Ok(length) if length > 0) {
            return Err(self.why_ended());
        }
        let mut words = Vec::new();
        for length in head.split_ascii_whitespace().skip(1) {
            let length: usize = length
                .parse()
                .ok()
                .filter(|length| *length <= MESSAGE_LIMIT)
                .ok_or("the Tcl interpreter sent a message that cannot be read")?;
            let mut word = vec![0; length];
            if self.from.read_exact(&mut word).is_err() {
                return Err(self.why_ended());
            }
            words.push(word);
        }
        Ok(words)
    }

    /// Sends a message.
    ///
    /// # Errors
    /// Returns the reason if the process has ended.
    pub(crate) fn send(&mut self, words: &[&[u8]]) -> Result<(), String> {
        let lengths: Vec<String> = words.iter().map(|word| word.len().to_string()).collect();
        let mut message = lengths.join(" ").into_bytes();
        message.push(b'\n');
        for word in words {
            message.extend_from_slice(word);
        }
        self.to.write_all(&message).and_then(|()| self.to.flush()).map_err(|_| self.why_ended())
    }

    fn why_ended(&mut self) -> String {
        if let Some(why) = why_stopped(&self.ended) {
            return why.into();
        }
        self.watch = None;
        let status = match self.child.lock() {
            Ok(mut child) => child.wait().map(|status| status.to_string()),
            Err(_) => return "the Tcl interpreter ended".into(),
        };
        let status = status.unwrap_or_else(|error| error.to_string());
        format!("the Tcl interpreter ended before the template did ({status})")
    }

    /// Ends the process and returns its error output, if that was captured.
    pub(crate) fn take_errors(&mut self) -> Vec<u8> {
        self.kill();
        let errors = self.errors.take();
        errors.and_then(|error| error.join().ok()).unwrap_or_default()
    }

    fn kill(&mut self) {
        self.watch = None;
        if let Ok(mut child) = self.child.lock() {
            child.kill();
        }
    }

    /// Waits for the process to end by itself after its last message.
    pub(crate) fn finish(&mut self) {
        self.watch = None;
        if let Ok(mut child) = self.child.lock() {
            let _ = child.wait();
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.kill();
    }
}

/// The reason why [`watch`] killed a process, if it did.
pub(crate) fn why_stopped(ended: &AtomicU8) -> Option<&'static str> {
    match ended.load(Ordering::Acquire) {
        TIMED_OUT => Some("stopped: the template took too long"),
        CANCELLED => Some("cancelled"),
        TOO_LARGE => Some("stopped: the template has written more than it may"),
        _ => None,
    }
}

/// The folders a process may write to, and their size limit.
pub(crate) struct DiskQuota {
    most: u64,
    used: Meter,
}

/// Kills the process on timeout, on cancellation, or if it has written too much.
pub(crate) fn watch(
    limits: &Limits,
    space: Option<DiskQuota>,
    child: &Arc<Mutex<Process>>,
    ended: &Arc<AtomicU8>,
) -> Option<mpsc::Sender<()>> {
    if limits.time.is_none() && limits.cancel.is_none() && space.is_none() {
        return None;
    }
    let deadline = limits.time.map(|time| Instant::now() + time);
    let cancel = limits.cancel.clone();
    let (child, ended) = (Arc::clone(child), Arc::clone(ended));
    let (keep, stop) = mpsc::channel::<()>();
    std::thread::spawn(move || {
        let reason = loop {
            let step = match deadline {
                Some(deadline) => deadline.saturating_duration_since(Instant::now()),
                None => Duration::MAX,
            };
            let step = if cancel.is_some() || space.is_some() { step.min(STEP) } else { step };
            match stop.recv_timeout(step) {
                Err(RecvTimeoutError::Timeout) => {}
                _ => return,
            }
            if cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Acquire)) {
                break CANCELLED;
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                break TIMED_OUT;
            }
            if space.as_ref().is_some_and(|space| (space.used)() > space.most) {
                break TOO_LARGE;
            }
        };
        ended.store(reason, Ordering::Release);
        if let Ok(mut child) = child.lock() {
            child.kill();
        }
    });
    Some(keep)
}
