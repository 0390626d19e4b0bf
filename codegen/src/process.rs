//! Programs to be started, and resources that must not outlive this process.
//!
//! This crate starts no program: the layer for input and output implements [`Processes`].

use std::ffi::OsString;
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Maximum delay until a stop is noticed.
const STOP_POLL_INTERVAL: Duration = Duration::from_millis(20);

/// A program and the way it runs.
#[derive(Debug, Clone)]
pub struct Program {
    /// The file, or a name to search on the path.
    pub path: PathBuf,
    pub arguments: Vec<OsString>,
    /// Its working directory; empty for the current one.
    pub directory: PathBuf,
    /// Its standard channels.
    pub channels: Channels,
    /// The limits on its resources.
    pub resources: Resources,
    /// The files it may access; `None` for the rights of its user.
    pub access: Option<Access>,
    /// Time that it may take to end by itself after this process has ended. Usually zero.
    pub outlives: Duration,
}

/// The standard channels of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channels {
    /// Pipes for all three.
    Pipes,
    /// Pipes for input and output; the error output of this process.
    PipesBut,
    /// The channels of this process: for a tool that uses the terminal.
    Shared,
}

/// The limits on a program's resources. A limit that the system does not support has no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Resources {
    /// Address space, in bytes.
    pub memory: Option<u64>,
    /// Processor time.
    pub time: Option<Duration>,
    /// Size of each file it writes, in bytes.
    pub file: Option<u64>,
}

/// The access of a confined program to files. It can neither start programs nor use the network.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Access {
    /// Files and folders it may read, in addition to those it needs to run.
    pub read: Vec<PathBuf>,
    /// Folders with full access.
    pub write: Vec<PathBuf>,
}

/// A part of the confinement that the system does not support.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gap {
    /// Access to other files.
    Files,
    /// Start of programs.
    Programs,
    /// Connections.
    Network,
    /// Use of memory and time.
    Resources,
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Gap::Files => "reading and writing files elsewhere",
            Gap::Programs => "starting programs",
            Gap::Network => "opening connections",
            Gap::Resources => "using up memory and time",
        })
    }
}

/// Starts programs.
pub trait Processes: Send + Sync {
    /// Starts a program. It ends with this process, however that ends, and so do its children. One that
    /// [outlives](Program::outlives) it gets this time if it asks the system not to end it at once.
    ///
    /// # Errors
    /// The errors of the system.
    fn start(&self, program: &Program) -> io::Result<Process>;

    /// Starts the renderer of MiniJinja texts ([`crate::builtin::serve_renderer`]), confined, in a separate
    /// process; `None` if no program for it is available.
    ///
    /// # Errors
    /// The errors of the system.
    fn renderer(&self, resources: Resources) -> Option<io::Result<Process>>;

    /// Creates a temporary folder in a directory (by default the system's). It is removed when the result is
    /// dropped, or when this process ends, however it ends.
    ///
    /// # Errors
    /// The errors of the system.
    fn folder(&self, parent: Option<&Path>) -> io::Result<Box<dyn Folder>>;

    /// The parts of the confinement that the system does not support.
    fn gaps(&self) -> Vec<Gap>;

    /// Measures the space of folders on the disk, at each call of the result.
    fn meter(&self, folders: Vec<PathBuf>) -> Meter;
}

/// Returns the present size of some folders in bytes.
pub type Meter = Box<dyn Fn() -> u64 + Send>;

/// A temporary folder.
pub trait Folder: fmt::Debug + Send {
    /// Its absolute path.
    fn path(&self) -> &Path;
    /// Keeps the folder on drop.
    fn keep(&mut self);
}

/// A running program. Dropping it kills it.
pub struct Process {
    /// The program itself.
    pub child: Child,
    /// The program and its children.
    pub group: Box<dyn Group>,
}

/// A program and its children. Dropped when the program has ended and was waited for.
pub trait Group: Send {
    /// Kills all of them.
    fn kill(&self, child: &mut Child);
}

impl Process {
    /// Kills the program and its children.
    pub fn kill(&mut self) {
        self.group.kill(&mut self.child);
        // A killed process is a zombie until it is waited for. An earlier wait is not an error.
        let _ = self.child.wait();
    }

    /// Waits for the end of the program, with empty input. Returns both outputs, the error output last, if
    /// there are pipes.
    ///
    /// # Errors
    /// The errors of the system.
    pub fn wait_with_output(&mut self) -> io::Result<(ExitStatus, Vec<u8>)> {
        self.wait_with_output_unless(&|| false)
    }

    /// Waits as [`Process::wait_with_output`] does, but kills the program as soon as `stop` returns true.
    /// `stop` is polled.
    ///
    /// # Errors
    /// The errors of the system.
    pub fn wait_with_output_unless(
        &mut self,
        stop: &dyn Fn() -> bool,
    ) -> io::Result<(ExitStatus, Vec<u8>)> {
        let (status, mut printed, errors) = self.wait_with_outputs_unless(stop)?;
        printed.extend(errors);
        Ok((status, printed))
    }

    /// Waits as [`Process::wait_with_output_unless`] does. Returns the output and the error output.
    ///
    /// # Errors
    /// The errors of the system.
    pub fn wait_with_outputs_unless(
        &mut self,
        stop: &dyn Fn() -> bool,
    ) -> io::Result<(ExitStatus, Vec<u8>, Vec<u8>)> {
        drop(self.child.stdin.take());
        let (ended, both) = channel();
        let output = self.child.stdout.take();
        let output = output.map(|output| read_all(output, ended.clone()));
        let errors = self.child.stderr.take();
        let errors = errors.map(|error| read_all(error, ended));
        // Ends when both outputs are closed.
        while let Err(RecvTimeoutError::Timeout) = both.recv_timeout(STOP_POLL_INTERVAL) {
            if stop() {
                self.kill();
                break;
            }
        }
        let text =
            |handle: Option<JoinHandle<Vec<u8>>>| handle.and_then(|handle| handle.join().ok());
        let (output, errors) = (text(output), text(errors));
        Ok((self.child.wait()?, output.unwrap_or_default(), errors.unwrap_or_default()))
    }

    /// Waits for the end of the program, with empty input. Returns the standard output, if there are pipes.
    /// The error output is dropped.
    ///
    /// # Errors
    /// The errors of the system.
    pub fn output(mut self) -> io::Result<(ExitStatus, Vec<u8>)> {
        drop(self.child.stdin.take());
        let errors = self.child.stderr.take().map(|mut errors| {
            // A full pipe would block the program.
            std::thread::spawn(move || io::copy(&mut errors, &mut io::sink()))
        });
        let mut printed = Vec::new();
        if let Some(mut output) = self.child.stdout.take() {
            output.read_to_end(&mut printed)?;
        }
        // The error output is dropped, so errors in reading it do not matter.
        let _ = errors.map(std::thread::JoinHandle::join);
        Ok((self.child.wait()?, printed))
    }

    /// Waits for the end of the program.
    ///
    /// # Errors
    /// The errors of the system.
    pub fn wait(&mut self) -> io::Result<ExitStatus> {
        self.child.wait()
    }
}

/// Reads to the end, on a separate thread, which holds `ended` until then.
fn read_all(mut from: impl Read + Send + 'static, ended: Sender<()>) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        // The bytes before a broken pipe are kept.
        let _ = from.read_to_end(&mut bytes);
        drop(ended);
        bytes
    })
}

impl Drop for Process {
    fn drop(&mut self) {
        self.kill();
    }
}

impl fmt::Debug for Process {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Process").field(&self.child.id()).finish()
    }
}
