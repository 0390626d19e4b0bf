//! Components with real codels: hosts execute the decisions of the engine, and the yields of the codels
//! decide the run.
//!
//! A host executes a codel when the model begins it. Others see its port data when the model ends it. Between
//! the two moments no other codel reads the data, because the codel holds the locks.

mod components;
mod data;
mod delegation;
mod ending;
mod machines;
mod outcomes;
mod requests;

use std::collections::{HashMap, VecDeque};
use std::time::Duration;

use dotgen_analysis::model::PortId;
use dotgen_timing::explore::{Action, Seen, Stepper, Work};
use dotgen_timing::property::DataFact;
use dotgen_timing::system::{CodelId, ComponentId, ServiceId, TaskId, TimedSystem, Yield};
use typed_index_collections::{TiVec, ti_vec};

use crate::end::{HOST_WITHIN, STOP_WITHIN};
use crate::hosts::{
    Call, CodelEnd, CodelResult, Connection, Hosts, Message, OutsideRequest, Reader, Source,
};
use crate::watch::{CodelViolation, PortUpdate};
pub use components::{DataFlow, HostedComponent, HostedComponents};
use delegation::Delegations;

/// A request under way.
#[derive(Debug)]
struct Instance {
    number: u32,
    service: ServiceId,
    /// Number of the outside request, if it comes from outside.
    wanted: Option<u64>,
    /// The exception that ended it, with its detail.
    failed: Option<(String, Vec<u8>)>,
    /// The state of the machine that has been reported.
    state: Option<usize>,
    /// The request has ended by itself.
    ended: bool,
    refused: bool,
}

/// The present work of an executor.
#[derive(Debug)]
struct Running {
    work: Work,
    /// A host executes it.
    real: bool,
    ran: Option<CodelResult>,
    /// Start on the clock of the hosts, in nanoseconds.
    since: u64,
    /// It has been reported that it takes too long.
    late: bool,
    /// It has yielded an event that the model does not know.
    undeclared: bool,
}

/// Time between two looks for a codel that the host has not begun, in nanoseconds.
const LOOK_NANOS: u64 = 1_000_000;

/// Returns the number of the thread that executes the codels of a task.
fn lane(task: TaskId) -> u32 {
    u32::try_from(usize::from(task)).unwrap_or(u32::MAX - 1)
}

/// Real codels of a system. See the [module](self).
pub struct Live<'p> {
    system: &'p TimedSystem,
    parts: &'p HostedComponents<'p>,
    hosts: &'p mut dyn Hosts,
    /// The engine waits for every codel, as on the virtual clock.
    waits: bool,
    /// An activity whose codel takes too long is ended.
    stops_activities: bool,
    alive: TiVec<ComponentId, bool>,
    running: Vec<Option<Running>>,
    /// Requests that control tasks handle, by component.
    pending: TiVec<ComponentId, Option<Instance>>,
    /// Activities, by place.
    places: Vec<Option<Instance>>,
    next_instance: u32,
    fault: Option<String>,
    /// Violations to be reported.
    broken: Vec<CodelViolation>,
    /// Output ports that were written since the engine asked.
    written: Vec<(ComponentId, PortId)>,
    /// Port data is kept for a recording, in `published`.
    keeps_data: bool,
    published: Vec<PortUpdate>,
    /// Comparisons of data in checks.
    facts: &'p [DataFact],
    /// Requests from outside, by component.
    wanted: TiVec<ComponentId, VecDeque<OutsideRequest>>,
    /// Requests from outside that must end.
    aborts: Vec<u64>,
    /// Calls of remote services by codels, by number: the component, and its own number for the call.
    asks: HashMap<u64, (ComponentId, u32)>,
    next_ask: u64,
    /// Connections of ports from outside.
    connected: Vec<Connection>,
    /// Work that hosts execute without the engine.
    delegations: Delegations,
    /// Longest end of a run.
    stop_within: Duration,
    /// Time in which a host that executes cycles must answer.
    host_within: Duration,
    /// The run is ending: there are no new requests.
    ending: bool,
    /// What has not ended within the bound, in words.
    unfinished: Vec<String>,
    /// Places of activities whose codels take too long, which must be interrupted.
    overrun: Vec<usize>,
}

impl<'p> Live<'p> {
    /// Creates the real codels for runs of a system.
    pub fn new(
        system: &'p TimedSystem,
        parts: &'p HostedComponents<'p>,
        hosts: &'p mut dyn Hosts,
        waits: bool,
        stops_activities: bool,
    ) -> Self {
        let components = system.components.len();
        Live {
            alive: ti_vec![true; components],
            running: Vec::new(),
            pending: (0..components).map(|_| None).collect(),
            places: Vec::new(),
            next_instance: 1,
            fault: None,
            broken: Vec::new(),
            written: Vec::new(),
            keeps_data: false,
            published: Vec::new(),
            facts: &[],
            wanted: (0..components).map(|_| VecDeque::new()).collect(),
            aborts: Vec::new(),
            connected: Vec::new(),
            asks: HashMap::new(),
            next_ask: 0,
            delegations: Delegations::new(components),
            stop_within: STOP_WITHIN,
            host_within: HOST_WITHIN,
            ending: false,
            unfinished: Vec::new(),
            overrun: Vec::new(),
            system,
            parts,
            hosts,
            waits,
            stops_activities,
        }
    }

    /// Begins a run. Returns false if a component cannot be started; [`Live::fault`] gives the reason.
    pub fn begin(&mut self, stepper: &Stepper) -> bool {
        self.alive.fill(true);
        self.running.clear();
        self.pending.iter_mut().for_each(|instance| *instance = None);
        self.places = (0..stepper.places()).map(|_| None).collect();
        self.asks.clear();
        self.delegations = Delegations::new(self.system.components.len());
        self.ending = false;
        self.overrun.clear();
        self.fault = self.hosts.start().err();
        let components = self.system.components.keys();
        for component in components.filter(|&component| self.parts.of(component).is_some()) {
            self.hosts.watch_engine(component, self.parts.machines(self.system, component));
        }
        self.fault.is_none()
    }

    /// Returns the reason why a component could not be started.
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    pub fn hosts(&mut self) -> &mut dyn Hosts {
        self.hosts
    }

    /// Returns the violations since the last call.
    pub(crate) fn take_broken(&mut self) -> Vec<CodelViolation> {
        std::mem::take(&mut self.broken)
    }

    /// Keeps port data, for a recording of the run.
    pub(crate) fn keep_data(&mut self) {
        self.keeps_data = true;
    }

    /// Returns the port data since the last call, if it is [kept](Self::keep_data).
    pub(crate) fn take_published(&mut self) -> Vec<PortUpdate> {
        std::mem::take(&mut self.published)
    }

    /// Returns the output ports that were written since the last call.
    pub(crate) fn take_written(&mut self) -> Vec<(ComponentId, PortId)> {
        std::mem::take(&mut self.written)
    }

    /// Returns true if a component is not lost.
    pub(crate) fn is_alive(&self, component: ComponentId) -> bool {
        self.alive.get(component).copied().unwrap_or(false)
    }

    /// Returns true if a host executes the codel.
    pub fn is_real(&self, codel: CodelId) -> bool {
        let component = self.system.codels.get(codel).map(|codel| codel.component);
        self.parts.codel(codel).is_some()
            && component.is_some_and(|component| self.is_alive(component))
    }

    /// Performs the events of a step in the hosts.
    pub fn step(&mut self, stepper: &Stepper, seen: &[Seen]) {
        for observation in seen {
            match *observation {
                Seen::Ended { executor, work, outcome } => self.ended(executor, &work, outcome),
                Seen::Requested { client, service } => self.requested(client, service),
                _ => {}
            }
        }
        self.begin_and_end_requests(stepper);
        for observation in seen {
            if let Seen::Begun { executor, work, .. } = *observation {
                self.report_state(&work);
                self.note_begin(executor, work);
            }
        }
    }

    /// Returns the request or activity of a piece of work.
    fn instance(&mut self, work: &Work) -> Option<&mut Instance> {
        match *work {
            Work::State { slot, automaton, .. } => {
                self.system.automata[automaton].service?;
                self.places.get_mut(slot)?.as_mut()
            }
            Work::Control { service, .. } => {
                let component = self.system.services[service].component;
                let activity = self.system.services[service].activity;
                match &self.pending[component] {
                    Some(_) => self.pending[component].as_mut(),
                    // An activity already has its place: it is the youngest one of its service.
                    None if activity => {
                        let all = self.places.iter_mut().flatten();
                        all.filter(|place| place.service == service)
                            .max_by_key(|place| place.number)
                    }
                    None => None,
                }
            }
            Work::Delay { .. } => None,
        }
    }

    fn note_begin(&mut self, executor: usize, work: Work) {
        if self.running.len() <= executor {
            self.running.resize_with(executor + 1, || None);
        }
        let codel = work.codel();
        let real = codel.is_some_and(|codel| self.is_real(codel));
        let since = self.hosts.now();
        self.running[executor] =
            Some(Running { work, real, ran: None, since, late: false, undeclared: false });
        let Some((codel, call)) = self.call(executor, &work).filter(|_| real) else {
            return;
        };
        let component = self.system.codels[codel].component;
        if !self.waits {
            return self.run_unless_delegated(codel, call);
        }
        self.hosts.run(&call);
        let until = self.work_deadline_nanos();
        while self.is_running(executor) {
            match self.hosts.wait(until) {
                Some(message) => self.message(message),
                // The run must end, and all work under way ends with it.
                None if self.hosts.now() < until => return,
                None => {
                    self.hosts.kill(component);
                    let why = "did not end within 10 s".to_owned();
                    self.message(Message::Lost { component, why });
                }
            }
        }
    }

    /// Returns the codel of a piece of work, with its call; `None` if no host executes it.
    fn call(&mut self, executor: usize, work: &Work) -> Option<(CodelId, Call)> {
        let codel = work.codel()?;
        let number = self.parts.codel(codel)?;
        let task = match *work {
            Work::State { task, .. } => Some(TaskId::from(task)),
            _ => None,
        };
        let call = Call {
            lane: task.map_or(u32::MAX, lane),
            ticket: u32::try_from(executor).unwrap_or(u32::MAX),
            core: task.and_then(|task| self.system.tasks[task].affinity),
            instance: self.instance(work).map_or(0, |instance| instance.number),
            component: self.system.codels[codel].component,
            codel: number,
        };
        Some((codel, call))
    }

    /// Returns the time until which the present work must end, on the clock of the hosts, in nanoseconds.
    fn work_deadline_nanos(&self) -> u64 {
        let blocked_after_nanos = self.hosts.blocked_after_nanos();
        blocked_after_nanos.map_or(u64::MAX, |number| self.hosts.now().saturating_add(number))
    }

    /// Returns the execution time of the codel that an action ends, in nanoseconds, if a host has executed
    /// it.
    pub(crate) fn executed(&self, action: Action) -> Option<u64> {
        let Action::Finish { executor, .. } = action else { return None };
        let running = self.running.get(executor)?.as_ref()?;
        Some(running.ran.as_ref().filter(|_| running.real)?.nanos)
    }

    /// Returns true if a host executes work for an executor.
    pub(crate) fn is_running(&self, executor: usize) -> bool {
        let running = self.running.get(executor).and_then(Option::as_ref);
        running.is_some_and(|running| running.real && running.ran.is_none())
    }

    /// Handles a message of a host.
    pub fn message(&mut self, message: Message) {
        match message {
            Message::CodelResult(component, ran) => {
                if !self.is_alive(component) {
                    return;
                }
                let Some(ran) = self.keep_delegated(component, ran) else {
                    return;
                };
                let executor = ran.ticket as usize;
                let Some(Some(running)) = self.running.get_mut(executor) else {
                    return;
                };
                let codel = running.work.codel().and_then(|codel| self.system.codels.get(codel));
                // A message is valid only for the codels of its own component, whatever those codels do to
                // their host.
                if codel.is_none_or(|codel| codel.component != component) || running.ran.is_some() {
                    return;
                }
                running.ran = Some(ran);
                self.measure(executor);
            }
            Message::Recalled { component, ticket } => self.recalled(component, ticket),
            Message::Probed { component, probe, until } => self.probed(component, probe, until),
            Message::Lost { component, why } => self.lost(component, why),
            Message::OutsideRequest(request) => {
                let Some(request) = self.defer_request(request) else {
                    return;
                };
                let component = self.system.services[request.service].component;
                if self.ending {
                    self.answer_failed(request.id, requests::STOPPING);
                } else if self.is_alive(component) {
                    self.wanted[component].push_back(request);
                } else {
                    self.answer_failed(request.id, requests::COMPONENT_LOST);
                }
            }
            Message::Abort(id) => self.defer_abort(id),
            Message::Asked { component, ask, remote, inputs } => {
                self.call_remote(component, ask, remote, inputs);
            }
            Message::Connect(connection) => {
                let other = |known: &Connection| {
                    (known.to, &known.name) != (connection.to, &connection.name)
                };
                self.connected.retain(other);
                self.connected.push(connection);
            }
            Message::Fed { component, port, name, data } => {
                let reader = Reader { component, port, name: &name };
                if self.is_alive(component) {
                    self.hosts.feed(reader, &data);
                }
            }
        }
    }

    /// Compares a finished codel with its stated execution time. On the virtual clock the stated time counts.
    fn measure(&mut self, executor: usize) {
        let Some(Some(running)) = self.running.get(executor) else {
            return;
        };
        let (Some(codel), Some(ran)) = (running.work.codel(), &running.ran) else {
            return;
        };
        let limit = match self.parts.limit(codel) {
            Some(limit) if !self.waits && ran.nanos > limit => limit,
            _ => return,
        };
        self.overruns(executor, codel, (ran.nanos, limit));
    }

    /// Reports codels of tasks that have not returned although their time is over, by the time since the call
    /// of their function. Returns the time of the next look, in nanoseconds on the clock of the hosts.
    pub(crate) fn note_late(&mut self) -> Option<u64> {
        let now = self.hosts.now();
        let mut next: Option<u64> = None;
        for executor in 0..self.running.len() {
            let Some(running) = &self.running[executor] else { continue };
            let awaited = running.real && running.ran.is_none() && !running.late;
            // The model may be behind the thread of a delegated task.
            if !awaited || self.is_delegated_executor(executor) {
                continue;
            }
            let Work::State { codel, task, .. } = running.work else { continue };
            let Some(limit) = self.parts.limit(codel) else { continue };
            let mut look = running.since.saturating_add(limit);
            if look < now {
                let component = self.system.codels[codel].component;
                let executing = self.hosts.executing(component, lane(task.into()));
                look = match executing.filter(|of| Some(of.0) == self.parts.codel(codel)) {
                    Some((_, begun)) if now.saturating_sub(begun) > limit => {
                        self.overruns(executor, codel, (now - begun, limit));
                        if let Some(running) = &mut self.running[executor] {
                            running.late = true;
                        }
                        continue;
                    }
                    Some((_, begun)) => begun.saturating_add(limit).saturating_add(1),
                    // It has not begun, or its result is under way.
                    None => now.saturating_add(LOOK_NANOS),
                };
            }
            next = Some(next.map_or(look, |next| next.min(look)));
        }
        next
    }

    /// Reports a codel that takes, or has taken, too long; its activity is interrupted if that is wanted.
    fn overruns(&mut self, executor: usize, codel: CodelId, (took, limit): (u64, u64)) {
        let known = self.running[executor].as_ref().is_some_and(|running| running.late);
        self.broken.push(CodelViolation::Overrun {
            codel: self.system.codels[codel].path.to_string(),
            function: self.parts.function(codel),
            took,
            limit,
            known,
        });
        if let Some(Some(Running { work: Work::State { slot, automaton, .. }, .. })) =
            self.running.get(executor)
            && self.stops_activities
            && !known
            && self.system.automata[*automaton].service.is_some()
        {
            self.overrun.push(*slot);
        }
    }

    fn lost(&mut self, component: ComponentId, why: String) {
        if !std::mem::replace(&mut self.alive[component], false) {
            return;
        }
        self.hosts.gone(component, &why);
        let (delegated, mut culprit) = self.end_delegations(component);
        for (executor, running) in self.running.iter_mut().enumerate() {
            let Some(running) = running else { continue };
            let codel = running.work.codel();
            let Some(codel) =
                codel.filter(|&codel| self.system.codels[codel].component == component)
            else {
                continue;
            };
            if running.real && running.ran.is_none() {
                let path = self.system.codels[codel].path.to_string();
                // The model may be behind the thread of a delegated task.
                if !delegated.contains(&executor) {
                    culprit.get_or_insert((path, self.parts.function(codel)));
                }
                running.real = false;
            }
        }
        self.broken.push(CodelViolation::Lost {
            component: self.system.components[component].name.clone(),
            codel: culprit,
            why,
        });
        let places = self.places.iter_mut().flatten();
        let pending = self.pending[component].iter_mut();
        let all = places.chain(pending);
        let of = all.filter(|place| self.system.services[place.service].component == component);
        let mut gone: Vec<u64> = of.filter_map(|place| place.wanted.take()).collect();
        gone.extend(self.wanted[component].drain(..).map(|request| request.id));
        gone.extend(self.take_deferred(component));
        for id in gone {
            self.answer_failed(id, requests::COMPONENT_LOST);
        }
    }

    fn ended(&mut self, executor: usize, work: &Work, outcome: usize) {
        let Some(running) = self.running.get_mut(executor).and_then(Option::take) else {
            return;
        };
        self.note_candidate(work);
        let usual = match *work {
            Work::State { automaton, state, .. } => {
                let yields = &self.system.machine_of(automaton).states[state].yields;
                let ends = yields.get(outcome).is_none_or(|transition| *transition == Yield::End);
                if let (true, Some(instance)) = (ends, self.instance(work)) {
                    instance.ended = true;
                }
                outcome < yields.len()
            }
            _ => outcome == 0,
        };
        let Some(ran) = running.ran else { return };
        // In the model, a codel without `throws` has no exception: its end stands for one.
        let failed = ran.how == CodelEnd::Exception || running.undeclared || !usual;
        if failed && let Some(instance) = self.instance(work) {
            let name = match ran.how {
                CodelEnd::Exception => ran.name.clone(),
                _ => "::genom::bad_transition".to_owned(),
            };
            instance.failed = Some((name, ran.detail.clone()));
        }
        let Some(component) = work.codel().map(|codel| self.system.codels[codel].component) else {
            return;
        };
        for port_write in ran.written {
            if let Some(data) = port_write.data {
                self.publish(component, port_write.port, &port_write.id, &data);
            }
        }
    }

    fn publish(&mut self, component: ComponentId, port: PortId, id: &str, data: &[u8]) {
        self.hosts.published(component, port, id, data);
        self.written.push((component, port));
        if self.keeps_data {
            self.published.push(PortUpdate {
                component,
                port,
                id: id.to_owned(),
                data: data.to_vec(),
            });
        }
        let feeds = self.parts.feeds.iter();
        let feeds = feeds.filter(|flow| flow.from == (component, port));
        let feeds = feeds.map(|flow| Reader {
            component: flow.to.0,
            port: flow.to.1,
            name: match (flow.multiple, id) {
                (false, _) => "",
                (true, "") => &self.system.components[component].name,
                (true, id) => id,
            },
        });
        // A connection from outside replaces the one of the scenario.
        let replaced = |reader: &Reader<'_>| {
            let mut all = self.connected.iter();
            all.any(|connection| {
                connection.to == (reader.component, reader.port) && connection.name == reader.name
            })
        };
        let connected = self.connected.iter();
        let connected = connected
            .filter(|connection| connection.from == (component, port) && connection.id == id);
        let connected = connected.map(|connection| Reader {
            component: connection.to.0,
            port: connection.to.1,
            name: &connection.name,
        });
        let readers = feeds.filter(|reader| !replaced(reader)).chain(connected);
        let readers = readers.filter(|reader| self.alive[reader.component]);
        let readers: Vec<Reader<'_>> = readers.collect();
        if !readers.is_empty() {
            let from = Source { component, port, id };
            self.hosts.share(from, &readers, data);
        }
    }
}
