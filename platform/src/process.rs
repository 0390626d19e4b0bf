//! Every program that dotgen starts, and every temporary folder it creates. None of them outlives dotgen, but
//! the hosts of components, which get some time for an end in order.
//!
//! A killed process cannot clean up. Three mechanisms do so for its children:
//! - The program `dotgen` starts itself again (`dotgen confined`, [`launch`]). That process ends with its
//!   parent, limits and confines itself, and then becomes the requested program. No code runs between `fork`
//!   and `exec`, where few functions are safe.
//! - A program has its own process group, with all of its children.
//! - A helper ([`watcher`]) holds a pipe to this process and knows its groups and temporary folders. When the
//!   pipe breaks, the helper kills the groups and removes the folders. It also completes writes of several
//!   files.
//!
//! The exception is a tool that is machine code and answers one question ([`ask`]): it reads files, writes
//! to a pipe of this process, and ends.

pub(crate) mod confine;
pub mod folders;
pub mod launch;
pub mod memory;
mod watcher;

use std::ffi::OsString;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::Duration;

use dotgen_codegen::process::{
    Channels, Folder, Gap, Group, Meter, Process, Processes, Program, Resources,
};

use watcher::Watcher;
#[cfg(test)]
pub(crate) use watcher::carry_out;
pub(crate) use watcher::{CleanupGuard, Move};

/// The subcommand.
const COMMAND: &str = "confined";

/// The path of this program, if it can be started again.
static OWN_PATH: OnceLock<PathBuf> = OnceLock::new();

/// Declares that this process is `dotgen` itself. Other processes (tests of the library) cannot start it
/// again: their programs are neither limited nor confined, and [`Processes::gaps`] reports that.
pub fn is_dotgen() {
    // The file may be replaced while it runs: this name still refers to the running program.
    let own = PathBuf::from("/proc/self/exe");
    let own = if own.exists() { Some(own) } else { std::env::current_exe().ok() };
    if let Some(own) = own {
        let _ = OWN_PATH.set(own);
    }
}

/// Starts programs for this process.
#[derive(Debug, Clone, Copy, Default)]
pub struct System;

/// [`System`] as a shared object.
pub fn system() -> Arc<dyn Processes> {
    Arc::new(System)
}

impl Processes for System {
    fn start(&self, program: &Program) -> io::Result<Process> {
        run(command(program)?, program.channels, program.outlives)
    }

    fn renderer(&self, resources: Resources) -> Option<io::Result<Process>> {
        let mut command = again(OWN_PATH.get()?);
        command.args(launch::renderer_arguments(resources));
        Some(run(command, Channels::Pipes, Duration::ZERO))
    }

    fn folder(&self, parent: Option<&Path>) -> io::Result<Box<dyn Folder>> {
        folders::create(parent)
    }

    fn gaps(&self) -> Vec<Gap> {
        match OWN_PATH.get() {
            Some(_) => confine::gaps(),
            None => vec![Gap::Files, Gap::Programs, Gap::Network, Gap::Resources],
        }
    }

    fn meter(&self, folders: Vec<PathBuf>) -> Meter {
        Box::new(move || folders.iter().map(|folder| folders::size(folder)).sum())
    }
}

/// Runs a command with empty input and returns its output; for short queries to tools.
///
/// A tool in machine code is started directly: it answers and ends. A script may start other programs and
/// wait, so it is started like any other program, with two more processes.
pub fn ask(
    program: &str,
    arguments: Vec<OsString>,
    environment: &[(&str, String)],
) -> io::Result<Process> {
    let file = find(Path::new(program), Path::new(""))?;
    let environment = environment.iter().map(|(name, value)| (name, value));
    if is_machine_code(&file) {
        let mut command = Command::new(file);
        command.args(arguments).envs(environment);
        pipes(&mut command, Channels::Pipes);
        command.stdin(Stdio::null());
        return Ok(Process {
            child: start(command)?,
            group: Box::new(ProcessGroup { own_group: false, _watched: None }),
        });
    }
    let program = Program {
        path: program.into(),
        arguments,
        directory: PathBuf::new(),
        channels: Channels::Pipes,
        resources: Resources::default(),
        access: None,
        outlives: Duration::ZERO,
    };
    let mut command = command(&program)?;
    command.envs(environment);
    let mut process = run(command, Channels::Pipes, Duration::ZERO)?;
    drop(process.child.stdin.take());
    Ok(process)
}

/// Registers moves of files, which the helper completes if this process is killed. Valid until the result is
/// dropped. `None` if the helper cannot be started.
pub(crate) fn finish(moves: &[Move]) -> Option<CleanupGuard> {
    Watcher::get().map(|watcher| watcher.moves(moves))
}

fn command(program: &Program) -> io::Result<Command> {
    let mut command = if let Some(own) = OWN_PATH.get() {
        // A missing program is reported as such, not as a failure of `dotgen confined`.
        find(&program.path, &program.directory)?;
        let mut command = again(own);
        command.args(launch::arguments(program));
        command
    } else {
        let mut command = Command::new(&program.path);
        command.args(&program.arguments);
        command
    };
    if !program.directory.as_os_str().is_empty() {
        command.current_dir(&program.directory);
    }
    Ok(command)
}

/// A command for this program, under its own name: as `genom3` it would expect other arguments.
fn again(own: &Path) -> Command {
    let mut command = Command::new(own);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::arg0(&mut command, "dotgen");
    command
}

/// The file of a program, found as the system does: a path is relative to `directory`, a name is searched in
/// `PATH`.
///
/// # Errors
/// The file does not exist.
fn find(name: &Path, directory: &Path) -> io::Result<PathBuf> {
    let found = if name.components().count() > 1 {
        Some(directory.join(name)).filter(|path| path.is_file())
    } else {
        find_in_path(name)
    };
    found.ok_or_else(|| io::ErrorKind::NotFound.into())
}

/// The first program of this name in the directories of `PATH`.
pub(crate) fn find_in_path(name: &Path) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path)
        .map(|path| path.join(name))
        .find(|path| path.is_file() && is_executable(path))
}

/// The system lets this process execute the file.
fn is_executable(file: &Path) -> bool {
    #[cfg(unix)]
    return rustix::fs::access(file, rustix::fs::Access::EXEC_OK).is_ok();
    #[cfg(not(unix))]
    file.is_file()
}

/// True if the file is an ELF program, not a script.
pub(crate) fn is_machine_code(file: &Path) -> bool {
    let mut magic = [0; 4];
    std::fs::File::open(file)
        .and_then(|mut file| file.read_exact(&mut magic))
        .is_ok_and(|()| magic == *b"\x7fELF")
}

/// Sets the channels of a command.
fn pipes(command: &mut Command, channels: Channels) {
    if channels == Channels::Shared {
        return;
    }
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    command.stderr(match channels {
        Channels::Pipes => Stdio::piped(),
        _ => Stdio::inherit(),
    });
}

fn run(mut command: Command, channels: Channels, outlives: Duration) -> io::Result<Process> {
    pipes(&mut command, channels);
    let own_group = channels != Channels::Shared;
    #[cfg(unix)]
    if own_group {
        // A program that uses the terminal stays in the group of dotgen: another group could not read from
        // it.
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
    }
    // The helper is started first, so that it runs before the program does.
    let watcher = Watcher::get().filter(|_| own_group);
    let child = start(command)?;
    let group = watcher.map(|watcher| watcher.group(child.id(), outlives));
    let group = ProcessGroup { own_group, _watched: group };
    Ok(Process { child, group: Box::new(group) })
}

/// Starts a command on a thread that lives as long as this process.
///
/// The system binds the life of a child to the *thread* that started it, not to the process. Threads of a
/// pool end when they are idle, and their children would end with them.
fn start(command: Command) -> io::Result<Child> {
    type SpawnRequest = (Command, Sender<io::Result<Child>>);
    static SPAWN_REQUESTS: LazyLock<Option<Sender<SpawnRequest>>> = LazyLock::new(|| {
        let (orders, queue) = channel::<SpawnRequest>();
        let work = move || {
            for (mut command, reply) in queue {
                // Fails if the result is no longer awaited. The child is then killed here.
                if let Err(lost) = reply.send(command.spawn())
                    && let Ok(mut child) = lost.0
                {
                    let _ = child.kill();
                    let _ = child.wait();
                }
            }
        };
        let thread = std::thread::Builder::new().name("starter".to_owned());
        thread.spawn(work).ok().map(|_| orders)
    });
    let gone = || io::Error::other("the thread that starts programs is gone");
    let (reply, answer) = channel();
    let orders = SPAWN_REQUESTS.as_ref().ok_or_else(gone)?;
    orders.send((command, reply)).map_err(|_| gone())?;
    answer.recv().map_err(|_| gone())?
}

/// A program and its group.
struct ProcessGroup {
    own_group: bool,
    _watched: Option<watcher::CleanupGuard>,
}

impl Group for ProcessGroup {
    fn kill(&self, child: &mut Child) {
        #[cfg(unix)]
        if self.own_group
            && let Some(group) =
                i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw)
        {
            // Fails if all processes of the group have ended.
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
        let _ = child.kill();
    }
}
