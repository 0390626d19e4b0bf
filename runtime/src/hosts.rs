//! What runs codels, as the engine sees it. Components are numbered as in the timed system; services, codels
//! and ports of a component as in its model; an attribute has one codel more, which copies its values.

/// A codel that is to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Call {
    /// The component.
    pub component: usize,
    /// The thread: a task of the system, or `u32::MAX` for the control task.
    pub lane: u32,
    /// Comes back with what came of it.
    pub ticket: u32,
    /// The codel.
    pub codel: u32,
    /// The activity or request, if it is one.
    pub instance: u32,
    /// The core that its task is tied to, from 0.
    pub core: Option<u32>,
}

/// An output port, or one instance of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source<'a> {
    /// The component.
    pub component: usize,
    /// The port.
    pub port: u32,
    /// The instance; empty for a port that is not `multiple`.
    pub id: &'a str,
}

/// An input port that reads it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reader<'a> {
    /// The component.
    pub component: usize,
    /// The port.
    pub port: u32,
    /// By which name it tells its sources apart; empty for a port that is not `multiple`.
    pub name: &'a str,
}

/// How a codel has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum How {
    /// With an event, or with none.
    Event,
    /// With an exception that is declared somewhere.
    Exception,
    /// With something that is neither.
    Other,
}

/// What a codel did to an output port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The port.
    pub port: u32,
    /// Its instance, for a port that is `multiple`.
    pub id: String,
    /// New data; `None` where the instance was opened or closed.
    pub data: Option<Vec<u8>>,
}

/// What came of a codel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ran {
    /// That of the call.
    pub ticket: u32,
    /// How long it took, in nanoseconds.
    pub nanos: u64,
    /// How it ended.
    pub how: How,
    /// The full name of the event or exception; empty for `genom_ok`. Of something else, what is known.
    pub name: String,
    /// The detail of the exception.
    pub detail: Vec<u8>,
    /// What it wrote, in order.
    pub written: Vec<Written>,
}

/// A request from outside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wanted {
    /// Comes back with the answers.
    pub id: u64,
    /// The service of the system.
    pub service: usize,
    /// Its inputs.
    pub inputs: Vec<u8>,
}

/// What becomes of a request from outside, in this order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// An activity is accepted; its end follows.
    Accepted,
    /// It ended well, with these outputs.
    Done(Vec<u8>),
    /// It was refused, interrupted, or ended with an exception.
    Failed {
        /// Full name of the exception.
        exception: String,
        /// Its detail, as bytes.
        detail: Vec<u8>,
    },
}

/// An input port is to read an output port, as somebody outside wants it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connection {
    /// Component and output port.
    pub from: (usize, u32),
    /// Its instance; empty for a port that is not `multiple`.
    pub id: String,
    /// Component and input port.
    pub to: (usize, u32),
    /// The name by which that finds it; empty for a port that is not `multiple`.
    pub name: String,
}

/// Why a codel that asks a service of another component gets no outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unanswered {
    /// There is no such service, or none that can answer in time.
    Nobody,
    /// Its component is lost.
    Lost,
    /// It was refused, interrupted, or has thrown an exception.
    Failed,
}

/// What a host tells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// A codel has ended.
    Ran(usize, Ran),
    /// A component is gone.
    Lost {
        /// The component.
        component: usize,
        /// How it ended, in words: "was ended by signal 11 (SIGSEGV)".
        why: String,
    },
    /// Somebody outside wants a service.
    Wanted(Wanted),
    /// Somebody outside wants the request of this number to end.
    Abort(u64),
    /// A codel asks a service of another component, and waits.
    Asked {
        /// Its component.
        component: usize,
        /// Comes back with the answer.
        ask: u32,
        /// The remote, by number in its model.
        remote: u32,
        /// The inputs of the service.
        inputs: Vec<u8>,
    },
    /// Somebody outside connects ports, instead of what they were connected with.
    Connect(Connection),
    /// An input port has new data from another machine.
    Fed {
        /// The component.
        component: usize,
        /// The port.
        port: u32,
        /// The name by which it finds the source; empty for a port that is not `multiple`.
        name: String,
        /// The data.
        data: Vec<u8>,
    },
}

/// Runs codels, and knows the time. A component that is lost takes everything and does nothing.
pub trait Hosts {
    /// Starts all components afresh.
    ///
    /// # Errors
    /// In words, where one cannot be started.
    fn start(&mut self) -> Result<(), String>;

    /// A request begins, with its inputs.
    fn make(&mut self, component: usize, service: u32, instance: u32, inputs: &[u8]);

    /// A codel begins. [`Message::Ran`] or [`Message::Lost`] follows.
    fn run(&mut self, call: &Call);

    /// A request has ended: its outputs, unless the component is lost or does not answer.
    fn end(&mut self, component: usize, service: u32, instance: u32) -> Option<Vec<u8>>;

    /// New data of an output port, for those who read it.
    fn share(&mut self, from: Source<'_>, readers: &[Reader<'_>], data: &[u8]);

    /// New data of another machine for an input port.
    fn feed(&mut self, reader: Reader<'_>, data: &[u8]);

    /// Waits for what happens next, at most until a time in nanoseconds since the start; `None` when the time
    /// has come, or earlier when the run is to end.
    fn wait(&mut self, until: u64) -> Option<Message>;

    /// Nanoseconds since the start.
    fn now(&self) -> u64;

    /// How long a codel may take on the virtual clock before its component counts as blocked, in nanoseconds;
    /// `None`: as long as it likes, for instance because somebody looks at it in a debugger.
    fn patience(&self) -> Option<u64>;

    /// Ends a component that does not answer.
    fn kill(&mut self, component: usize);

    /// Answers a codel that has asked: the outputs of the service.
    fn reply(&mut self, component: usize, ask: u32, outputs: Result<Vec<u8>, Unanswered>);

    /// Tells whoever wanted something what became of it.
    fn answer(&mut self, id: u64, answer: Answer);

    /// Tells whoever watches that a component is gone, and how it ended.
    fn gone(&mut self, component: usize, why: &str);

    /// Tells whoever watches that an output port has new data.
    fn published(&mut self, component: usize, port: u32, id: &str, data: &[u8]);
}
