//! Programs that are to be started, and what must not outlive the process that wanted them.
//!
//! Nothing here starts one: the layer that does input and output implements [`Processes`].

use std::ffi::OsString;
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// How long at most it takes until somebody who wants to stop is heard.
const LOOK: Duration = Duration::from_millis(20);

/// A program and how it is to run.
#[derive(Debug, Clone)]
pub struct Program {
    /// The file to run, or a name to be looked for on the path.
    pub path: PathBuf,
    /// Its arguments.
    pub arguments: Vec<OsString>,
    /// Directory it runs in; empty for the current one.
    pub directory: PathBuf,
    /// Its standard channels.
    pub channels: Channels,
    /// What it may use up.
    pub resources: Resources,
    /// What it may reach; `None` for all that its user may.
    pub access: Option<Access>,
}

/// The standard channels of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channels {
    /// Pipes for all three.
    Pipes,
    /// Pipes for input and output; the error output is that of this process.
    PipesBut,
    /// Those of this process: for a tool that talks to the user of a terminal.
    Shared,
}

/// What a program may use up. What a system cannot limit is not limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Resources {
    /// Address space, in bytes.
    pub memory: Option<u64>,
    /// Time on a processor.
    pub time: Option<Duration>,
    /// Size of each file it writes, in bytes.
    pub file: Option<u64>,
}

/// What a confined program may reach. It starts no other program, and has no network.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Access {
    /// Files and folders it may read, besides what it needs to run.
    pub read: Vec<PathBuf>,
    /// Folders in which it may do what it wants.
    pub write: Vec<PathBuf>,
}

/// Something that the system does not keep a confined program from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gap {
    /// Reading and writing files elsewhere.
    Files,
    /// Starting programs.
    Programs,
    /// Connections.
    Network,
    /// Using up memory and time.
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
    /// Starts a program. It ends with this process, however that ends, and so does what it has started.
    ///
    /// # Errors
    /// As the system tells them.
    fn start(&self, program: &Program) -> io::Result<Process>;

    /// Starts the renderer of MiniJinja texts ([`crate::builtin::serve_renderer`]), confined, in a
    /// process of its own; `None` where there is no program that could be it.
    ///
    /// # Errors
    /// As the system tells them.
    fn renderer(&self, resources: Resources) -> Option<io::Result<Process>>;

    /// Makes a temporary folder in a directory (by default that of the system). It is removed with what
    /// is returned, or with this process, however that ends.
    ///
    /// # Errors
    /// As the system tells them.
    fn folder(&self, parent: Option<&Path>) -> io::Result<Box<dyn Folder>>;

    /// What the system does not keep a confined program from.
    fn gaps(&self) -> Vec<Gap>;

    /// Measures the space that folders take on the disk, each time it is called.
    fn meter(&self, folders: Vec<PathBuf>) -> Meter;
}

/// The bytes that some folders take now.
pub type Meter = Box<dyn Fn() -> u64 + Send>;

/// A temporary folder.
pub trait Folder: fmt::Debug + Send {
    /// Its absolute path.
    fn path(&self) -> &Path;
    /// Leaves it where it is.
    fn keep(&mut self);
}

/// A running program. Dropping it kills it.
pub struct Process {
    /// The program itself.
    pub child: Child,
    /// It and what it has started.
    pub group: Box<dyn Group>,
}

/// A program and all it has started. Dropped when the program was waited for.
pub trait Group: Send {
    /// Ends all of them.
    fn kill(&self, child: &mut Child);
}

impl Process {
    /// Ends the program and what it has started.
    pub fn kill(&mut self) {
        self.group.kill(&mut self.child);
        // It is a zombie until somebody waits; that it was waited for before is no error.
        let _ = self.child.wait();
    }

    /// Waits for the end of the program, with nothing to read for it. What it has printed, if there are
    /// pipes: on both outputs, the error output behind.
    ///
    /// # Errors
    /// As the system tells them.
    pub fn wait_with_output(&mut self) -> io::Result<(ExitStatus, Vec<u8>)> {
        self.wait_with_output_unless(&|| false)
    }

    /// Likewise, but ends it as soon as `stop` says so: it is asked again and again.
    ///
    /// # Errors
    /// As the system tells them.
    pub fn wait_with_output_unless(
        &mut self,
        stop: &dyn Fn() -> bool,
    ) -> io::Result<(ExitStatus, Vec<u8>)> {
        drop(self.child.stdin.take());
        let (ended, both) = channel();
        let output = self.child.stdout.take();
        let output = output.map(|it| read_all(it, ended.clone()));
        let errors = self.child.stderr.take();
        let errors = errors.map(|it| read_all(it, ended));
        // Ends when neither output is read any more.
        while let Err(RecvTimeoutError::Timeout) = both.recv_timeout(LOOK) {
            if stop() {
                self.kill();
                break;
            }
        }
        let mut printed = Vec::new();
        for it in [output, errors].into_iter().flatten() {
            printed.extend(it.join().unwrap_or_default());
        }
        Ok((self.child.wait()?, printed))
    }

    /// Waits for the end of the program, with nothing to read for it. What it has printed on its output, if
    /// there are pipes; what it has printed on its error output is dropped.
    ///
    /// # Errors
    /// As the system tells them.
    pub fn output(mut self) -> io::Result<(ExitStatus, Vec<u8>)> {
        drop(self.child.stdin.take());
        let errors = self.child.stderr.take().map(|mut errors| {
            // A full pipe would stop the program.
            std::thread::spawn(move || io::copy(&mut errors, &mut io::sink()))
        });
        let mut printed = Vec::new();
        if let Some(mut output) = self.child.stdout.take() {
            output.read_to_end(&mut printed)?;
        }
        // What could not be read was to be dropped.
        let _ = errors.map(std::thread::JoinHandle::join);
        Ok((self.child.wait()?, printed))
    }

    /// Waits for the end of the program.
    ///
    /// # Errors
    /// As the system tells them.
    pub fn wait(&mut self) -> io::Result<ExitStatus> {
        self.child.wait()
    }
}

/// Reads to the end, on a thread of its own, which holds `ended` for so long.
fn read_all(mut from: impl Read + Send + 'static, ended: Sender<()>) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        // What came before a broken pipe counts.
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
