//! `dotgen host`: a process that runs one component. An internal subcommand.
//!
//! The host reads commands from its standard input until the end of the input, and writes results to its
//! standard output. Codels get another output and input: their output goes to standard error, and their input
//! is empty.

mod alone;
mod lane;
mod signals;

use std::collections::{BTreeMap, HashMap};
use std::ffi::c_int;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::ExitCode;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::debugger;
use super::executing::Executing;
use super::library::{Component, REMOTE_CALL, RemoteCall};
use super::realtime;
use super::wire::{HostCommand, HostMessage};
pub(super) use alone::STATUS as ALONE;
use lane::Lane;

/// The subcommand.
pub(super) const COMMAND: &str = "host";

/// Options of a host: its first argument, as JSON.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct HostOptions {
    /// The component, which gives the process its name.
    pub(super) component: String,
    /// The path of the [table](super::executing) of the codels that threads execute.
    pub(super) executing: String,
    /// Number of entries of the table: the tasks of all components.
    pub(super) lanes: usize,
    /// The threads of the tasks, by lane.
    pub(super) tasks: BTreeMap<u32, HostThread>,
    /// Real-time priority of the thread of the control task.
    pub(super) control_priority: u8,
    /// True if memory is locked and threads are bound to cores.
    pub(super) real_time: bool,
    /// True if threads have real-time priority: the system has granted that of the engine.
    pub(super) raised: bool,
    /// True if the host waits for a debugger before it begins.
    pub(super) debug: bool,
    /// Time in which the host expects a sign of the engine; zero: any time.
    pub(super) engine_within: Duration,
    /// Time that the `stop` codels may take without the engine.
    pub(super) stop_within: Duration,
}

/// A thread that executes the codels of a task.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct HostThread {
    /// The task, which gives the thread its name.
    pub(super) name: String,
    /// Real-time priority.
    pub(super) priority: u8,
}

/// Runs the subcommand if the command line contains it.
pub fn intercept() -> Option<ExitCode> {
    let words: Vec<_> = std::env::args_os().skip(1).collect();
    let [command, rest @ ..] = words.as_slice() else {
        return None;
    };
    if command != COMMAND {
        return None;
    }
    let [manner, library] = rest else {
        return None;
    };
    let manner: HostOptions = serde_json::from_str(manner.to_str()?).ok()?;
    Some(match serve(Path::new(library), manner) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::from(2),
    })
}

/// Why a host is alone whose channel to the engine has ended.
const ENGINE_ENDED: &str = "its channel to the engine has ended";

/// The name of the thread that validates requests and copies attributes.
const CONTROL: &str = "control";

type Output = Arc<Mutex<File>>;

/// Codels that wait for the answer of another component, by the number of their request.
#[derive(Default)]
struct Waiting {
    next: u32,
    all: HashMap<u32, Sender<Result<Vec<u8>, c_int>>>,
}

/// Creates the function that sends a request to another component through the engine.
fn remote_call(output: Output, waiting: Arc<Mutex<Waiting>>) -> RemoteCall {
    Box::new(move |remote, inputs| {
        let (sender, answer) = channel();
        let mut all = waiting.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        all.next = all.next.wrapping_add(1);
        let ask = all.next;
        all.all.insert(ask, sender);
        drop(all);
        let inputs = inputs.to_vec();
        let asked = HostMessage::Asked { ask, remote, inputs };
        send(&output, asked).map_err(|_| libc::ENOTCONN)?;
        answer.recv().unwrap_or(Err(libc::ENOTCONN))
    })
}

/// The state that all threads of a host use.
struct Host {
    options: HostOptions,
    component: Component,
    output: Output,
    executing: Option<Executing>,
    waiting: Arc<Mutex<Waiting>>,
    activities: alone::Activities,
}

fn serve(library: &Path, options: HostOptions) -> io::Result<()> {
    realtime::name_process(&options.component);
    signals::crash_as_usual();
    if options.raised {
        // This thread passes on what the engine commands.
        realtime::raise_priority(realtime::ENGINE_PRIORITY);
    }
    let (input, output) = channels()?;
    // Without the table, the engine cannot name the codel with which this process ends.
    let executing = Executing::open(&options.executing, options.lanes).ok();
    let component = match Component::load(library) {
        Ok(component) => component,
        Err(why) => return send(&output, HostMessage::Unusable(why)),
    };
    if options.debug {
        debugger::permit();
        send(&output, HostMessage::Waiting)?;
        debugger::wait();
    }
    if options.real_time && !realtime::lock_memory(realtime::Pages::All) {
        send(&output, HostMessage::Denied("locked memory".to_owned()))?;
    }
    let waiting = Arc::<Mutex<Waiting>>::default();
    // The value is set once: a process has one component.
    let _ = REMOTE_CALL.set(remote_call(output.clone(), waiting.clone()));
    send(&output, HostMessage::Ready)?;
    let activities = alone::Activities::default();
    let host = Arc::new(Host { options, component, output, executing, waiting, activities });
    // An error is one of a channel to the engine.
    let _ = follow(&host, input);
    alone::stop(&host, ENGINE_ENDED);
}

/// Executes commands until the end of the input.
fn follow(host: &Arc<Host>, mut input: impl Read) -> io::Result<()> {
    let mut lanes: HashMap<u32, Lane> = HashMap::new();
    while let Some(command) = HostCommand::receive(&mut input)? {
        match command {
            HostCommand::Make { service, instance, inputs } => {
                host.component.make(service, instance, &inputs);
            }
            HostCommand::Answered { ask, error, outputs } => {
                let mut waiting =
                    host.waiting.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                let result = match error {
                    0 => Ok(outputs),
                    error => Err(c_int::try_from(error).unwrap_or(libc::EIO)),
                };
                if let Some(sender) = waiting.all.remove(&ask) {
                    let _ = sender.send(result);
                }
            }
            HostCommand::Share { port, id, path } => host.component.share(port, &id, &path)?,
            HostCommand::End { service, instance } => {
                let outputs = host.component.end(service, instance);
                host.activities.forget(instance);
                send(&host.output, HostMessage::Ended(outputs))?;
            }
            HostCommand::WatchEngine(machines) => {
                host.activities.set_machines(machines);
                realtime::outlive_parent();
                alone::watch(host);
            }
            HostCommand::Run(call) => {
                let lane = lanes.entry(call.lane);
                let lane = lane.or_insert_with(|| Lane::start(call.lane, host, call.core));
                lane.run(call);
            }
            HostCommand::Delegate(delegation) => {
                let call = delegation.call;
                let lane = lanes.entry(call.lane);
                let lane = lane.or_insert_with(|| Lane::start(call.lane, host, call.core));
                lane.delegate(delegation);
            }
            HostCommand::Recall { lane } => {
                if let Some(lane) = lanes.get(&lane) {
                    lane.recall();
                }
            }
            HostCommand::Probe { lane, probe } => {
                if let Some(lane) = lanes.get(&lane) {
                    lane.probe(host, probe)?;
                }
            }
        }
    }
    Ok(())
}

/// Opens the channels to the engine, and closes them for codels.
fn channels() -> io::Result<(BufReader<File>, Output)> {
    let input: OwnedFd = rustix::io::dup(rustix::stdio::stdin())?;
    let output: OwnedFd = rustix::io::dup(rustix::stdio::stdout())?;
    rustix::stdio::dup2_stdin(File::open("/dev/null")?)?;
    rustix::stdio::dup2_stdout(rustix::stdio::stderr())?;
    let output = Arc::new(Mutex::new(File::from(output)));
    Ok((BufReader::new(File::from(input)), output))
}

fn send(output: &Output, message: HostMessage) -> io::Result<()> {
    send_all(output, &[message])
}

fn send_all(output: &Output, messages: &[HostMessage]) -> io::Result<()> {
    let mut output = output.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    HostMessage::send_all(messages, &mut *output)
}
