//! The interface to the processes that run codels. Components are numbered as in the timed system, and
//! services, codels and ports as in the model of their component. An attribute has one more codel, which
//! copies its values.

use dotgen_analysis::model::PortId;
use dotgen_timing::system::{ComponentId, ServiceId};
use serde::{Deserialize, Serialize};

/// A call of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Call {
    /// Not sent: a host has one component.
    #[serde(skip)]
    pub component: ComponentId,
    /// Thread: a task of the system, or `u32::MAX` for the control task.
    pub lane: u32,
    /// Number that [`CodelResult`] repeats.
    pub ticket: u32,
    pub codel: u32,
    /// Activity or request, if there is one.
    pub instance: u32,
    /// Core that its task is bound to, counted from 0.
    pub core: Option<u32>,
}

/// Cycles of a task that its thread executes without the engine, one at each tick: the codels of one
/// automaton from a state on, until the automaton pauses. They end with the first codel whose end leads
/// elsewhere, or when the engine [recalls](Hosts::recall) them. [`Message::Recalled`] follows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Delegation {
    /// The call of the first codel.
    pub call: Call,
    /// Time of the first tick, in nanoseconds since the start.
    pub first_tick: u64,
    /// Time between ticks, in nanoseconds. Several ticks during a cycle count as one.
    pub period: u64,
    /// State in which the first cycle begins.
    pub state: usize,
    /// The states of the machine.
    pub states: Vec<DelegatedState>,
}

/// A state of a machine that a thread executes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DelegatedState {
    pub codel: u32,
    /// The state that follows, by full name of the event. Other events end the delegation.
    pub next: Vec<(String, DelegatedYield)>,
}

impl DelegatedState {
    /// Returns what follows an event of the codel; `None` if nothing of the machine does.
    pub fn next_of(&self, event: &str) -> Option<DelegatedYield> {
        let next = self.next.iter().find(|(name, _)| name == event);
        next.map(|&(_, next)| next)
    }
}

/// The machine of an activity, by which a host without an engine executes its `stop` codels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HostMachine {
    /// `component.task` or `component.service`.
    pub name: String,
    /// Thread of its task.
    pub lane: u32,
    /// Period of its task, in nanoseconds; 0 without one.
    pub period: u64,
    /// States. The codel of one that no host executes is [`HostMachine::SIMULATED`].
    pub states: Vec<DelegatedState>,
    /// State after an interruption.
    pub stop: Option<usize>,
}

impl HostMachine {
    /// The codel of a state that no host executes.
    pub const SIMULATED: u32 = u32::MAX;
}

/// The successor of a codel in a [`Delegation`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum DelegatedYield {
    /// Another state, in the same cycle.
    Next(usize),
    /// Another state, in the next cycle.
    Pause(usize),
}

/// An output port, or one instance of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source<'a> {
    pub component: ComponentId,
    pub port: PortId,
    /// Instance; empty if the port is not `multiple`.
    pub id: &'a str,
}

/// An input port that reads an output port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reader<'a> {
    pub component: ComponentId,
    pub port: PortId,
    /// Name by which the input distinguishes its sources; empty if the port is not `multiple`.
    pub name: &'a str,
}

/// The way in which a codel has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CodelEnd {
    /// With an event, or without one.
    Event,
    /// With a declared exception.
    Exception,
    /// With a value that is neither an event nor a declared exception.
    Other,
}

/// Output of a codel to a port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PortWrite {
    pub port: PortId,
    /// Instance, if the port is `multiple`.
    pub id: String,
    /// New data; `None` if the instance was opened or closed.
    #[serde(with = "serde_bytes")]
    pub data: Option<Vec<u8>>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CodelResult {
    /// Ticket of the call.
    pub ticket: u32,
    pub codel: u32,
    /// Execution time, in nanoseconds.
    pub nanos: u64,
    /// Time of the end, in nanoseconds since the start.
    pub ended: u64,
    /// Way in which the codel ended.
    pub how: CodelEnd,
    /// Full name of the event or exception; empty for `genom_ok`. For other values, a description.
    pub name: String,
    /// Detail of the exception.
    #[serde(with = "serde_bytes")]
    pub detail: Vec<u8>,
    /// Port data, in the order of writing.
    pub written: Vec<PortWrite>,
}

/// A request from outside the system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideRequest {
    /// Number that its answers repeat.
    pub id: u64,
    /// Service of the system.
    pub service: ServiceId,
    pub inputs: Vec<u8>,
}

/// The answers to a request from outside, in this order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RequestReply {
    /// An activity is accepted; a second answer follows at its end.
    Accepted,
    /// The request succeeded, with these outputs.
    Done(Vec<u8>),
    /// The request was refused or interrupted, or ended with an exception.
    Failed {
        /// Full name of the exception.
        exception: String,
        /// Detail of the exception, as bytes.
        detail: Vec<u8>,
    },
}

/// A connection of an input port to an output port, requested from outside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connection {
    /// Component and output port.
    pub from: (ComponentId, PortId),
    /// Instance of the output; empty if the port is not `multiple`.
    pub id: String,
    /// Component and input port.
    pub to: (ComponentId, PortId),
    /// Name by which the input finds the source; empty if the input is not `multiple`.
    pub name: String,
}

/// The reason for which a remote service has no outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplyError {
    /// There is no such service, or none that can answer in time.
    NoService,
    /// The component of the service is lost.
    Lost,
    /// The request was refused or interrupted, or ended with an exception.
    Failed,
}

/// A message of a host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// A codel has ended.
    CodelResult(ComponentId, CodelResult),
    /// A delegation has ended: its results have all been sent.
    Recalled {
        component: ComponentId,
        /// Ticket of its call.
        ticket: u32,
    },
    /// All results of a delegation until a time have been sent.
    Probed {
        component: ComponentId,
        /// Number of the probe.
        probe: u32,
        /// Time, in nanoseconds since the start.
        until: u64,
    },
    /// The process of a component has ended.
    Lost {
        component: ComponentId,
        /// Reason, in words: "was ended by signal 11 (SIGSEGV)".
        why: String,
    },
    OutsideRequest(OutsideRequest),
    /// An abort of the request with this number, from outside.
    Abort(u64),
    /// A call of a remote service, for which a codel waits.
    Asked {
        /// Component of the codel.
        component: ComponentId,
        /// Number that [`Hosts::reply`] repeats.
        ask: u32,
        /// Remote, by number in the model of the component.
        remote: u32,
        /// Inputs of the service.
        inputs: Vec<u8>,
    },
    /// A connection of ports, from outside. It replaces the present one.
    Connect(Connection),
    /// New data from outside for an input port: of another machine, or of a client.
    Fed {
        component: ComponentId,
        port: PortId,
        /// Name by which the input finds the source; empty if the port is not `multiple`.
        name: String,
        data: Vec<u8>,
    },
}

/// Runs codels, and provides the time. Calls for a lost component have no effect.
pub trait Hosts {
    /// Starts all components afresh.
    ///
    /// # Errors
    ///
    /// A message that names a component that cannot be started.
    fn start(&mut self) -> Result<(), String>;

    /// Lets a component that has been started watch the engine: if the engine is gone, the component executes
    /// the `stop` codels of these machines by itself.
    fn watch_engine(&mut self, _component: ComponentId, _machines: Vec<HostMachine>) {}

    /// Begins a request, with its inputs.
    fn make(&mut self, component: ComponentId, service: u32, instance: u32, inputs: &[u8]);

    /// Begins a codel. [`Message::CodelResult`] or [`Message::Lost`] follows.
    fn run(&mut self, call: &Call);

    /// Lets the thread of a task execute its cycles by itself. A [`Message::CodelResult`] follows for each
    /// codel, then [`Message::Recalled`].
    fn delegate(&mut self, delegation: &Delegation);

    /// Ends a delegation after the codel that its thread executes. [`Message::Recalled`] follows.
    fn recall(&mut self, component: ComponentId, lane: u32);

    /// Asks until when all results of a delegation have been sent. [`Message::Probed`] follows, with the
    /// number of this probe.
    fn probe(&mut self, component: ComponentId, lane: u32, probe: u32);

    /// Returns the codel that the thread of a task executes, or executed when its component was lost, with
    /// the time of its call in nanoseconds since the start.
    fn executing(&self, component: ComponentId, lane: u32) -> Option<(u32, u64)>;

    /// Ends a request and returns its outputs; `None` if the component is lost or does not answer.
    fn end(&mut self, component: ComponentId, service: u32, instance: u32) -> Option<Vec<u8>>;

    /// Passes new data of an output port to its readers.
    fn share(&mut self, from: Source<'_>, readers: &[Reader<'_>], data: &[u8]);

    /// Passes new data from outside to an input port.
    fn feed(&mut self, reader: Reader<'_>, data: &[u8]);

    /// Waits for the next message, until a time in nanoseconds since the start. Returns `None` at that time,
    /// or earlier if the run must end.
    fn wait(&mut self, until: u64) -> Option<Message>;

    /// Returns the time since the start, in nanoseconds.
    fn now(&self) -> u64;

    /// Returns the time after which a codel on the virtual clock counts as blocked, in nanoseconds. `None`:
    /// no limit, for instance under a debugger.
    fn blocked_after_nanos(&self) -> Option<u64>;

    /// Returns true if the run must end at once, with what is under way.
    fn is_over(&self) -> bool {
        false
    }

    /// Kills a component that does not answer.
    fn kill(&mut self, component: ComponentId);

    /// Answers a codel that called a remote service, with the outputs of the service.
    fn reply(&mut self, component: ComponentId, ask: u32, outputs: Result<Vec<u8>, ReplyError>);

    /// Sends an answer to the sender of an outside request.
    fn answer(&mut self, id: u64, answer: RequestReply);

    /// Reports the new state of an activity that an outside request began.
    fn entered(&mut self, id: u64, state: &str);

    /// Reports that a component is lost, and the reason.
    fn gone(&mut self, component: ComponentId, why: &str);

    /// Publishes new data of an output port.
    fn published(&mut self, component: ComponentId, port: PortId, id: &str, data: &[u8]);
}
