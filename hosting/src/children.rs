//! The engine's side of the hosts: starts and ends their processes, and exchanges messages with them.

mod inbox;
mod pipe;
mod ports;
mod spawn;

use std::collections::{BTreeSet, VecDeque};
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use camino::Utf8PathBuf;
use dotgen_analysis::model::PortId;
use dotgen_codegen::process::Process;
use dotgen_runtime::hosts::{
    Call, Delegation, HostMachine, Hosts, Message, Reader, ReplyError, RequestReply, Source,
};
use dotgen_timing::verify::Interrupt;
use rustix::process::Pid;

use super::clock::monotonic_nanos;
use super::executing::Executing;
use super::orphans;
use super::wire::{HostCommand, HostMessage};
use dotgen_timing::system::ComponentId;

use inbox::EngineEvent;
pub(crate) use inbox::InputSlot;
pub use inbox::{RunInbox, RunListener};
use pipe::{in_words, send};
use ports::{Origin, SharedDataPool};
use typed_index_collections::TiVec;

/// Maximum time for a reply of a host that does not depend on a codel.
const REPLY_TIMEOUT: Duration = Duration::from_secs(10);

/// The same for a host under a debugger. No run takes longer.
const DEBUGGER_TIMEOUT: Duration = Duration::from_hours(876_000);

/// Maximum time between the end of the output of a process and the end of the process.
const EXIT_TIMEOUT: Duration = Duration::from_millis(20);

/// Maximum time between the end of a process and the end of its output.
const OUTPUT_TIMEOUT: Duration = Duration::from_secs(1);

/// Maximum delay of the reaction to an interruption.
const INTERRUPT_POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A component with the process that runs it.
struct Child {
    library: Option<Utf8PathBuf>,
    process: Option<Process>,
    executing: Option<Executing>,
    /// Time at which the process was seen to have ended while its output had not.
    exited: Option<Instant>,
}

/// A function that is called for each host that waits for a debugger, with the component and the process ID.
pub type Waiting = Box<dyn Fn(&str, u32)>;

/// A component of a system, as its host needs it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HostedComponent {
    pub name: String,
    /// Real-time priority of its control task; see [`priorities`](crate::realtime::priorities).
    pub priority: u8,
}

/// A task of a system, as its host needs it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HostedTask {
    pub component: ComponentId,
    /// Name, without the component.
    pub name: String,
    /// Real-time priority; see [`priorities`](crate::realtime::priorities).
    pub priority: u8,
}

/// All hosts of a run.
pub struct Children {
    children: TiVec<ComponentId, Child>,
    components: TiVec<ComponentId, HostedComponent>,
    /// By lane.
    tasks: Vec<HostedTask>,
    real: bool,
    /// True if the system has granted the engine its real-time priority.
    raised: bool,
    /// Set if hosts wait for a debugger: the function to call, and no timeouts.
    debug: Option<Waiting>,
    interrupt: Interrupt,
    /// Time that an orderly end may take after an interruption.
    stop_within: Duration,
    /// Time in which hosts expect a sign of the engine; zero: any time.
    engine_within: Duration,
    /// All hosts have begun: an interruption is a request for an orderly end.
    running: bool,
    /// Number of starts. Messages of hosts of an earlier start are ignored.
    started: u64,
    /// Time of the start, on the clock of the hosts, in nanoseconds.
    begin: u64,
    arrivals: Receiver<EngineEvent>,
    sender: Sender<EngineEvent>,
    /// Messages that arrived while the engine waited for something else.
    early: VecDeque<Message>,
    outside: Vec<Box<dyn RunListener>>,
    /// The number of requests from outside.
    requests: Arc<AtomicU64>,
    shared_data: SharedDataPool,
    denied: BTreeSet<String>,
    /// Time of the last check for hosts that have ended.
    looked: Instant,
}

impl Children {
    /// Creates the hosts of the components that have a shared object. `components` and `tasks` are all of the
    /// system.
    pub fn new(
        libraries: TiVec<ComponentId, Option<Utf8PathBuf>>,
        components: TiVec<ComponentId, HostedComponent>,
        tasks: Vec<HostedTask>,
        real: bool,
        (interrupt, stop_within): (Interrupt, Duration),
    ) -> Children {
        let (sender, arrivals) = channel();
        let children = libraries.into_iter().map(|library| Child {
            process: None,
            executing: None,
            exited: None,
            library,
        });
        Children {
            children: children.collect(),
            components,
            tasks,
            real,
            raised: false,
            debug: None,
            interrupt,
            stop_within,
            engine_within: Duration::ZERO,
            running: false,
            started: 0,
            begin: monotonic_nanos(),
            early: VecDeque::new(),
            outside: Vec::new(),
            requests: Arc::default(),
            shared_data: SharedDataPool::default(),
            denied: BTreeSet::new(),
            looked: Instant::now(),
            arrivals,
            sender,
        }
    }

    /// The rights that the system does not grant to hosts, as text.
    pub fn denied(&self) -> &BTreeSet<String> {
        &self.denied
    }

    /// Gives threads of hosts real-time priority: the system has granted that of the engine, the highest one.
    pub fn raise_priorities(&mut self) {
        self.raised = true;
    }

    /// Sets the time in which hosts expect a sign of the engine. Without one they stop by themselves.
    pub fn watch_engine_within(&mut self, within: Duration) {
        self.engine_within = within;
    }

    /// Makes hosts wait for a debugger before they begin.
    pub fn debug(&mut self, waiting: Waiting) {
        self.debug = Some(waiting);
    }

    /// The time at which a reply of a host that does not depend on a codel is overdue.
    fn deadline(&self) -> Instant {
        let patience = match &self.debug {
            Some(_) => DEBUGGER_TIMEOUT,
            None => REPLY_TIMEOUT,
        };
        Instant::now() + patience
    }

    /// A sender of messages from outside.
    pub fn inbox(&self) -> RunInbox {
        RunInbox { sender: self.sender.clone(), requests: self.requests.clone() }
    }

    /// Adds a subscriber.
    pub fn subscribe(&mut self, outside: Box<dyn RunListener>) {
        self.outside.push(outside);
    }

    fn order(&mut self, component: ComponentId, order: &HostCommand) {
        let process = self.children.get_mut(component);
        let process = process.and_then(|process| process.process.as_mut());
        let Some(process) = process else { return };
        let sent = match (order.bytes(), &mut process.child.stdin) {
            (Ok(bytes), Some(input)) => send(input, &bytes),
            _ => Ok(()),
        };
        // If the write fails because the host has ended, the end of its output is an event. A host that does
        // not read is ended.
        if sent.is_err_and(|error| error.kind() == io::ErrorKind::TimedOut) {
            process.kill();
        }
    }

    /// Removes a host that has ended, and returns its way of ending.
    fn ended(&mut self, component: ComponentId) -> String {
        let Some(mut process) = self.children[component].process.take() else {
            return "ended".to_owned();
        };
        let until = Instant::now() + EXIT_TIMEOUT;
        let mut status = process.child.try_wait();
        while matches!(status, Ok(None)) && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
            status = process.child.try_wait();
        }
        if let Ok(Some(status)) = status {
            return in_words(status);
        }
        // A process that is ending anyway keeps its own exit status.
        process.kill();
        match process.wait() {
            Ok(status) if std::os::unix::process::ExitStatusExt::signal(&status) != Some(9) => {
                in_words(status)
            }
            _ => {
                "has closed its channel to the engine, or written into it, and was ended".to_owned()
            }
        }
    }

    /// Returns the next event of this start, or `None` at the time `until`.
    fn next(&mut self, until: Instant) -> Option<EngineEvent> {
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let arrival = match self.arrivals.recv_timeout(left) {
                Ok(message) => message,
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return None,
            };
            match arrival {
                EngineEvent::HostMessage(_, of, _) | EngineEvent::Closed(_, of)
                    if of != self.started => {}
                arrival => return Some(arrival),
            }
        }
    }

    /// Returns the next event of this start, or `None` at the time `until` or after an interruption.
    fn next_unless_interrupted(&mut self, until: Instant) -> Option<EngineEvent> {
        loop {
            self.children
                .iter()
                .filter_map(|child| child.executing.as_ref())
                .for_each(Executing::beat);
            if let Some(exited) = self.exited() {
                return Some(exited);
            }
            let look = Instant::now() + INTERRUPT_POLL_INTERVAL;
            match self.next(until.min(look)) {
                None if look < until && !self.must_end() => {}
                other => return other,
            }
        }
    }

    /// Returns true if the run must end without what is under way.
    fn must_end(&self) -> bool {
        if self.running {
            self.interrupt.is_over(self.stop_within)
        } else {
            self.interrupt.is_raised()
        }
    }

    /// Returns the end of a host whose process has ended while its output has not, because a process that a
    /// codel started still holds the output.
    fn exited(&mut self) -> Option<EngineEvent> {
        let now = Instant::now();
        if now < self.looked + INTERRUPT_POLL_INTERVAL {
            return None;
        }
        self.looked = now;
        let processes = self.children.iter().filter_map(|child| child.process.as_ref());
        let hosts =
            processes.filter_map(|process| Pid::from_raw(process.child.id().try_into().ok()?));
        orphans::reap(&hosts.collect::<Vec<_>>());
        for (component, child) in self.children.iter_mut_enumerated() {
            let Some(process) = &mut child.process else {
                continue;
            };
            match child.exited {
                // Messages that the host sent before its end have been received meanwhile.
                Some(since) if now > since + OUTPUT_TIMEOUT => {
                    return Some(EngineEvent::Closed(component, self.started));
                }
                None if matches!(process.child.try_wait(), Ok(Some(_))) => child.exited = Some(now),
                _ => {}
            }
        }
        None
    }

    /// Converts a time of a host to nanoseconds since the start. No time is in the future, whatever a codel
    /// has done to its host.
    fn since_begin(&self, nanos: u64) -> u64 {
        nanos.saturating_sub(self.begin).min(self.now())
    }

    /// Converts an event to a message for the engine.
    fn message(&mut self, arrival: EngineEvent) -> Option<Message> {
        match arrival {
            EngineEvent::HostMessage(component, _, HostMessage::CodelResult(mut ran)) => {
                ran.ended = self.since_begin(ran.ended);
                Some(Message::CodelResult(component, ran))
            }
            EngineEvent::HostMessage(component, _, HostMessage::Recalled { ticket }) => {
                Some(Message::Recalled { component, ticket })
            }
            EngineEvent::HostMessage(component, _, HostMessage::Probed { probe, until }) => {
                let until = self.since_begin(until);
                Some(Message::Probed { component, probe, until })
            }
            EngineEvent::HostMessage(_, _, HostMessage::Denied(what)) => {
                self.denied.insert(what);
                None
            }
            EngineEvent::HostMessage(component, _, HostMessage::Asked { ask, remote, inputs }) => {
                Some(Message::Asked { component, ask, remote, inputs })
            }
            EngineEvent::HostMessage(..) => None,
            EngineEvent::Closed(component, _) => {
                // The end may be known already.
                self.children.get(component)?.process.as_ref()?;
                let why = self.ended(component);
                Some(Message::Lost { component, why })
            }
            EngineEvent::Outside(message) => Some(message),
            EngineEvent::Fed(newest) => Some(Message::Fed {
                component: newest.component,
                port: newest.port,
                name: newest.name.clone(),
                data: newest.swap(None)?,
            }),
        }
    }
}

impl Hosts for Children {
    fn start(&mut self) -> Result<(), String> {
        self.started += 1;
        self.running = false;
        self.early.clear();
        self.shared_data = SharedDataPool::default();
        for component in self.children.keys() {
            // Dropping a process ends it.
            self.children[component].process = None;
            self.spawn(component)?;
        }
        let until = self.deadline();
        let wanted = self.children.iter().filter(|child| child.process.is_some());
        let mut missing = wanted.count();
        while missing > 0 {
            match self.next_unless_interrupted(until) {
                Some(EngineEvent::HostMessage(_, _, HostMessage::Ready)) => missing -= 1,
                Some(EngineEvent::HostMessage(component, _, HostMessage::Waiting)) => {
                    let process = &self.children[component].process;
                    if let (Some(waiting), Some(process)) = (&self.debug, process) {
                        waiting(&self.components[component].name, process.child.id());
                    }
                }
                Some(EngineEvent::HostMessage(component, _, HostMessage::Unusable(why))) => {
                    let name = &self.components[component].name;
                    return Err(format!("the codels of `{name}` cannot be loaded: {why}"));
                }
                Some(EngineEvent::Closed(component, _)) => {
                    let why = self.ended(component);
                    let name = &self.components[component].name;
                    return Err(format!("the codels of `{name}` cannot be loaded: its host {why}"));
                }
                Some(event) => {
                    let message = self.message(event);
                    self.early.extend(message);
                }
                None if self.must_end() => return Err("interrupted".to_owned()),
                None => return Err("a host does not begin".to_owned()),
            }
        }
        self.begin = monotonic_nanos();
        self.running = true;
        Ok(())
    }

    fn watch_engine(&mut self, component: ComponentId, machines: Vec<HostMachine>) {
        self.order(component, &HostCommand::WatchEngine(machines));
    }

    fn make(&mut self, component: ComponentId, service: u32, instance: u32, inputs: &[u8]) {
        let inputs = inputs.to_vec();
        self.order(component, &HostCommand::Make { service, instance, inputs });
    }

    fn run(&mut self, call: &Call) {
        self.order(call.component, &HostCommand::Run(*call));
    }

    fn delegate(&mut self, delegation: &Delegation) {
        let mut delegation = delegation.clone();
        delegation.first_tick += self.begin;
        let component = delegation.call.component;
        self.order(component, &HostCommand::Delegate(delegation));
    }

    fn recall(&mut self, component: ComponentId, lane: u32) {
        self.order(component, &HostCommand::Recall { lane });
    }

    fn probe(&mut self, component: ComponentId, lane: u32, probe: u32) {
        self.order(component, &HostCommand::Probe { lane, probe });
    }

    fn executing(&self, component: ComponentId, lane: u32) -> Option<(u32, u64)> {
        let (codel, begun) = self.children.get(component)?.executing.as_ref()?.get(lane)?;
        Some((codel, self.since_begin(begun)))
    }

    fn end(&mut self, component: ComponentId, service: u32, instance: u32) -> Option<Vec<u8>> {
        self.order(component, &HostCommand::End { service, instance });
        let until = self.deadline();
        loop {
            match self.next_unless_interrupted(until) {
                None if self.must_end() => return None,
                None => {
                    self.kill(component);
                    let why = "did not answer within 10 s".to_owned();
                    self.early.push_back(Message::Lost { component, why });
                    return None;
                }
                Some(EngineEvent::HostMessage(of, _, HostMessage::Ended(outputs)))
                    if of == component =>
                {
                    return Some(outputs);
                }
                Some(arrival) => {
                    let lost = matches!(&arrival, EngineEvent::Closed(of, _) if *of == component);
                    let message = self.message(arrival);
                    self.early.extend(message);
                    if lost {
                        return None;
                    }
                }
            }
        }
    }

    fn share(&mut self, from: Source<'_>, readers: &[Reader<'_>], data: &[u8]) {
        let origin = Origin::Output(from.component, from.port, from.id.to_owned());
        self.show(origin, readers, data);
    }

    fn feed(&mut self, reader: Reader<'_>, data: &[u8]) {
        let origin = Origin::Elsewhere(reader.component, reader.port, reader.name.to_owned());
        self.show(origin, &[reader], data);
    }

    fn wait(&mut self, until: u64) -> Option<Message> {
        if let Some(message) = self.early.pop_front() {
            return Some(message);
        }
        let left = Duration::from_nanos(until.saturating_sub(self.now()));
        let until = Instant::now() + left.min(DEBUGGER_TIMEOUT);
        loop {
            let arrival = self.next_unless_interrupted(until)?;
            if let Some(message) = self.message(arrival) {
                return Some(message);
            }
        }
    }

    fn now(&self) -> u64 {
        monotonic_nanos().saturating_sub(self.begin)
    }

    fn blocked_after_nanos(&self) -> Option<u64> {
        match &self.debug {
            Some(_) => None,
            None => u64::try_from(REPLY_TIMEOUT.as_nanos()).ok(),
        }
    }

    fn is_over(&self) -> bool {
        self.must_end()
    }

    fn kill(&mut self, component: ComponentId) {
        if let Some(child) = self.children.get_mut(component) {
            child.process = None;
        }
    }

    fn reply(&mut self, component: ComponentId, ask: u32, outputs: Result<Vec<u8>, ReplyError>) {
        let (error, outputs) = match outputs {
            Ok(outputs) => (0, outputs),
            Err(ReplyError::NoService) => (libc::ENOSYS, Vec::new()),
            Err(ReplyError::Lost) => (libc::ENOTCONN, Vec::new()),
            Err(ReplyError::Failed) => (libc::EIO, Vec::new()),
        };
        let error = error.unsigned_abs();
        self.order(component, &HostCommand::Answered { ask, error, outputs });
    }

    fn answer(&mut self, id: u64, answer: RequestReply) {
        for listener in &mut self.outside {
            listener.answer(id, &answer);
        }
    }

    fn entered(&mut self, id: u64, state: &str) {
        for listener in &mut self.outside {
            listener.entered(id, state);
        }
    }

    fn gone(&mut self, component: ComponentId, why: &str) {
        for listener in &mut self.outside {
            listener.gone(component, why);
        }
    }

    fn published(&mut self, component: ComponentId, port: PortId, id: &str, data: &[u8]) {
        for listener in &mut self.outside {
            listener.published(component, port, id, data);
        }
    }
}
