//! Every program that dotgen starts, and every temporary folder it makes: none outlives it.
//!
//! A process that is killed cleans up nothing, so three things hold for what it has started:
//! - the program `dotgen` starts itself again (`dotgen confined`, [`launch`]), which binds its life to
//!   that of its parent, limits and confines itself, and only then becomes the program that was wanted.
//!   So no code has to run between `fork` and `exec`, where little is safe;
//! - a program has a process group of its own, with all that it starts;
//! - a helper ([`watcher`]) holds a pipe to this process and knows groups and temporary folders: when the
//!   pipe breaks, it ends the ones and removes the others. It also finishes what writes several files.

pub(crate) mod confine;
pub(crate) mod folders;
pub(crate) mod launch;
pub(crate) mod memory;
mod watcher;

use std::ffi::OsString;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, LazyLock, OnceLock};

use dotgen_codegen::process::{
    Channels, Folder, Gap, Group, Meter, Process, Processes, Program, Resources,
};

use watcher::Watcher;
#[cfg(test)]
pub(crate) use watcher::carry_out;
pub(crate) use watcher::{Move, Watched};

/// The subcommand.
const COMMAND: &str = "confined";

/// This program, where it can be started again.
static OWN: OnceLock<PathBuf> = OnceLock::new();

/// Says that this process is `dotgen` itself. Otherwise (in a test of the library) it cannot be started
/// again: then nothing is limited or confined, and [`Processes::gaps`] says so.
pub(crate) fn is_dotgen() {
    // The file may be replaced while it runs: this name still means what runs.
    let own = PathBuf::from("/proc/self/exe");
    let own = if own.exists() {
        Some(own)
    } else {
        std::env::current_exe().ok()
    };
    if let Some(own) = own {
        let _ = OWN.set(own);
    }
}

/// Starts programs for this process.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct System;

/// For whoever wants it shared.
pub(crate) fn system() -> Arc<dyn Processes> {
    Arc::new(System)
}

impl Processes for System {
    fn start(&self, program: &Program) -> io::Result<Process> {
        run(command(program)?, program.channels)
    }

    fn renderer(&self, resources: Resources) -> Option<io::Result<Process>> {
        let mut command = again(OWN.get()?);
        command.args(launch::renderer_arguments(resources));
        Some(run(command, Channels::Pipes))
    }

    fn folder(&self, parent: Option<&Path>) -> io::Result<Box<dyn Folder>> {
        folders::create(parent)
    }

    fn gaps(&self) -> Vec<Gap> {
        match OWN.get() {
            Some(_) => confine::gaps(),
            None => vec![Gap::Files, Gap::Programs, Gap::Network, Gap::Resources],
        }
    }

    fn meter(&self, folders: Vec<PathBuf>) -> Meter {
        Box::new(move || folders.iter().map(|it| folders::size(it)).sum())
    }
}

/// Runs a command whose input is empty and whose output is read; for short questions to tools.
///
/// A tool that is machine code answers and ends: it is started directly. A script may start more and wait,
/// so it is started like any other program, which takes two further processes.
pub(crate) fn ask(
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
            group: Box::new(Started {
                own_group: false,
                _watched: None,
            }),
        });
    }
    let program = Program {
        path: program.into(),
        arguments,
        directory: PathBuf::new(),
        channels: Channels::Pipes,
        resources: Resources::default(),
        access: None,
    };
    let mut command = command(&program)?;
    command.envs(environment);
    let mut process = run(command, Channels::Pipes)?;
    drop(process.child.stdin.take());
    Ok(process)
}

/// Has moves of files finished when this process is killed before it has done them all. The promise holds as
/// long as the result lives; there is none where the helper cannot be started.
pub(crate) fn finish(moves: &[Move]) -> Option<Watched> {
    Watcher::get().map(|it| it.moves(moves))
}

/// The command that becomes a program.
fn command(program: &Program) -> io::Result<Command> {
    let mut command = match OWN.get() {
        Some(own) => {
            // What cannot be found is told as that, not as a failure of what is started in its place.
            find(&program.path, &program.directory)?;
            let mut command = again(own);
            command.args(launch::arguments(program));
            command
        }
        None => {
            let mut command = Command::new(&program.path);
            command.args(&program.arguments);
            command
        }
    };
    if !program.directory.as_os_str().is_empty() {
        command.current_dir(&program.directory);
    }
    Ok(command)
}

/// This program again, by its own name: as `genom3` it would take other words.
fn again(own: &Path) -> Command {
    let mut command = Command::new(own);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::arg0(&mut command, "dotgen");
    command
}

/// The file of a program, looked for as the system does: a path is relative to `directory`, a name is in
/// `PATH`.
///
/// # Errors
/// There is none.
fn find(name: &Path, directory: &Path) -> io::Result<PathBuf> {
    let found = match name.components().count() > 1 {
        true => Some(directory.join(name)).filter(|it| it.is_file()),
        false => in_path(name),
    };
    found.ok_or_else(|| io::ErrorKind::NotFound.into())
}

/// The first file of this name in the directories of `PATH`.
pub(crate) fn in_path(name: &Path) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path)
        .map(|it| it.join(name))
        .find(|it| it.is_file())
}

/// The file is an ELF program, no script.
pub(crate) fn is_machine_code(file: &Path) -> bool {
    let mut magic = [0; 4];
    std::fs::File::open(file)
        .and_then(|mut it| it.read_exact(&mut magic))
        .is_ok_and(|()| magic == *b"\x7fELF")
}

/// Connects a command as `channels` says.
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

fn run(mut command: Command, channels: Channels) -> io::Result<Process> {
    pipes(&mut command, channels);
    let own_group = channels != Channels::Shared;
    #[cfg(unix)]
    if own_group {
        // Who talks to the terminal stays in its group: a group of its own could not read from it.
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
    }
    // The helper first: it must not have to be started while the program runs already.
    let watcher = Watcher::get().filter(|_| own_group);
    let child = start(command)?;
    let group = watcher.map(|it| it.group(child.id()));
    let group = Started {
        own_group,
        _watched: group,
    };
    Ok(Process {
        child,
        group: Box::new(group),
    })
}

/// Starts a command on a thread that lives as long as this process.
///
/// The system binds the life of a child to the *thread* that has started it, not to its process. Threads
/// of a pool end when they have nothing to do, and their children would end with them.
fn start(command: Command) -> io::Result<Child> {
    type Order = (Command, Sender<io::Result<Child>>);
    static ORDERS: LazyLock<Option<Sender<Order>>> = LazyLock::new(|| {
        let (orders, queue) = channel::<Order>();
        let work = move || {
            for (mut command, reply) in queue {
                // Fails when nobody waits any more; then nobody would end the child either.
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
    let orders = ORDERS.as_ref().ok_or_else(gone)?;
    orders.send((command, reply)).map_err(|_| gone())?;
    answer.recv().map_err(|_| gone())?
}

/// A program and its group.
struct Started {
    own_group: bool,
    _watched: Option<watcher::Watched>,
}

impl Group for Started {
    fn kill(&self, child: &mut Child) {
        #[cfg(unix)]
        if self.own_group
            && let Some(group) = i32::try_from(child.id())
                .ok()
                .and_then(rustix::process::Pid::from_raw)
        {
            // Fails when all of it has ended.
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
        let _ = child.kill();
    }
}
