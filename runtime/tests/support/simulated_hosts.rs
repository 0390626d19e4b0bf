//! Hosts that exist in simulated time only: their messages are delayed, and their codels take random times
//! and end at random.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap, HashSet};

use dotgen_analysis::model::PortId;
use dotgen_runtime::hosts::{
    Call, CodelEnd, CodelResult, DelegatedYield, Delegation, Hosts, Message, OutsideRequest,
    Reader, ReplyError, RequestReply, Source,
};
use dotgen_runtime::live::HostedComponents;
use dotgen_timing::system::{CodelId, ComponentId, ServiceId, TimedSystem};

use crate::random_systems::systems::Dice;

/// Nanoseconds of a millisecond.
pub(crate) const MS: u64 = 1_000_000;

type LaneId = (ComponentId, u32);

#[derive(Debug, Clone)]
enum Event {
    Run(Call),
    Delegate(Delegation),
    Recall(LaneId),
    Probe(LaneId, u32),
    /// The process of a component ends.
    Lost(ComponentId),
    /// The codel that a lane executes ends.
    End(LaneId),
    /// A tick of a lane, if its delegation has this number.
    Tick(LaneId, u64),
    Arrival(Message),
}

/// A thread of a simulated host.
#[derive(Debug, Default)]
struct Lane {
    /// Codel that it executes, with its ticket and begin.
    codel: Option<(u32, u32, u64)>,
    cycles: Option<Cycles>,
    unsent: Vec<CodelResult>,
    ticket: u32,
}

#[derive(Debug)]
struct Cycles {
    number: u64,
    delegation: Delegation,
    tick: u64,
    state: usize,
    recalled: bool,
}

/// See the [module](self).
pub(crate) struct Simulated<'s> {
    system: &'s TimedSystem,
    parts: &'s HostedComponents<'s>,
    dice: Dice,
    now: Cell<u64>,
    events: BTreeMap<(u64, u64), Event>,
    number: u64,
    /// Latest time at which a message of a component, or to it, arrives: pipes keep the order.
    latest: HashMap<(ComponentId, bool), u64>,
    lanes: HashMap<LaneId, Lane>,
    pub(crate) executed: u64,
    pub(crate) delegated: u64,
    /// Number of messages that the engine received, and of its waits without one.
    pub(crate) received: u64,
    pub(crate) waits: u64,
    /// The components that were reported as lost, with the reasons.
    pub(crate) lost: Vec<String>,
    /// Components whose processes have ended.
    gone: HashSet<ComponentId>,
    /// A component whose process stands still from a time on, in nanoseconds.
    stopped: Option<(ComponentId, u64)>,
    /// A codel that always takes the same time, in nanoseconds.
    long: Option<(String, u64)>,
    /// Ends of codels, in nanoseconds.
    pub(crate) ends: Vec<u64>,
    /// Number of planned requests, and of those with an answer or an acceptance.
    pub(crate) requests: u64,
    pub(crate) replied: HashSet<u64>,
    pub(crate) answered: RefCell<HashSet<u64>>,
}

impl<'s> Simulated<'s> {
    pub(crate) fn new(system: &'s TimedSystem, parts: &'s HostedComponents<'s>, seed: u64) -> Self {
        let mut hosts = Simulated {
            system,
            parts,
            dice: Dice::new(seed),
            now: Cell::new(7 * MS),
            events: BTreeMap::new(),
            number: 0,
            latest: HashMap::new(),
            lanes: HashMap::new(),
            executed: 0,
            delegated: 0,
            received: 0,
            waits: 0,
            lost: Vec::new(),
            gone: HashSet::new(),
            stopped: None,
            long: None,
            ends: Vec::new(),
            requests: 0,
            replied: HashSet::new(),
            answered: RefCell::default(),
        };
        hosts.plan_requests();
        hosts
    }

    /// Ends the process of a component at a time, in nanoseconds.
    pub(crate) fn lose(&mut self, component: ComponentId, time: u64) {
        self.plan(time, Event::Lost(component));
    }

    /// Fixes the execution time of a codel, in nanoseconds. No codel ends with an exception.
    pub(crate) fn fix(&mut self, codel: &str, time: u64) {
        self.long = Some((codel.to_owned(), time));
    }

    /// Requests a service at a time, in nanoseconds, and nothing else.
    pub(crate) fn only_request(&mut self, name: &str, time: u64) {
        self.events.clear();
        let mut services = self.system.services.iter_enumerated();
        let (service, _) =
            services.find(|(_, service)| service.name == name).expect("the service exists");
        let request = OutsideRequest { id: 1_000, service, inputs: Vec::new() };
        self.plan(time, Event::Arrival(Message::OutsideRequest(request)));
    }

    /// Lets the process of a component stand still from a time on, in nanoseconds.
    pub(crate) fn stop(&mut self, component: ComponentId, time: u64) {
        self.stopped = Some((component, time));
    }

    /// Plans requests and aborts from outside.
    fn plan_requests(&mut self) {
        let services = self.system.services.len() as u32;
        if services == 0 {
            return;
        }
        for id in 1..=u64::from(self.dice.below(30)) {
            let time =
                8 * MS + u64::from(self.dice.below(500)) * MS + u64::from(self.dice.below(999_999));
            let service = ServiceId::from(self.dice.below(services) as usize);
            if self.system.services[service].builtin.is_some() {
                continue;
            }
            self.requests += 1;
            let inputs = Vec::new();
            let request = OutsideRequest { id, service, inputs };
            self.plan(time, Event::Arrival(Message::OutsideRequest(request)));
            if self.dice.in_ten(4) {
                let later = u64::from(self.dice.below(30_000_000));
                self.plan(time + later, Event::Arrival(Message::Abort(id)));
            }
        }
    }

    fn plan(&mut self, time: u64, event: Event) {
        self.number += 1;
        self.events.insert((time, self.number), event);
    }

    /// Plans a message to or from a component, after those before.
    fn send(&mut self, component: ComponentId, to_host: bool, event: Event) {
        let delay = match self.dice.below(40) {
            0 => u64::from(self.dice.below(4_000)) * 1_000,
            _ => 5_000 + u64::from(self.dice.below(100_000)),
        };
        let latest = self.latest.entry((component, to_host)).or_default();
        *latest = (*latest).max(self.now.get() + delay);
        let time = *latest;
        self.plan(time, event);
    }

    fn tell(&mut self, component: ComponentId, message: Message) {
        self.send(component, false, Event::Arrival(message));
    }

    /// Returns the codels of the system that a number stands for.
    fn codels(&self, component: ComponentId, number: u32) -> Vec<CodelId> {
        let all = self.system.codels.iter_enumerated();
        let own = all.filter(|(_, codel)| codel.component == component);
        own.map(|(id, _)| id).filter(|&id| self.parts.codel(id) == Some(number)).collect()
    }

    fn begin(&mut self, lane: LaneId, ticket: u32, codel: u32) {
        let own = self.codels(lane.0, codel);
        assert!(!own.is_empty(), "the codel exists");
        for (other_lane, other) in &self.lanes {
            if self.gone.contains(&other_lane.0) {
                continue;
            }
            let Some((number, ..)) = other.codel else {
                continue;
            };
            let running = self.codels(other_lane.0, number);
            let excluded = own.iter().all(|&one| {
                let conflicts = &self.system.codels[one].conflicts;
                running.iter().all(|&other| conflicts.contains(other))
            });
            assert!(
                !excluded,
                "{} begins while {} executes",
                self.system.codels[own[0]].path, self.system.codels[running[0]].path
            );
        }
        let period = self.system.tasks.iter().filter_map(|task| task.period).min();
        let unit = u64::from(period.unwrap_or(1_000)) * 1_000;
        let time = match self.dice.below(20) {
            0 if self.dice.below(10) == 0 => u64::from(self.dice.below(20)) * unit,
            0 => u64::from(self.dice.below(2_500)) * unit / 1_000,
            1..=4 => u64::from(self.dice.below(300)) * unit / 1_000,
            _ => 1_000 + u64::from(self.dice.below(40_000)),
        };
        let path = self.system.codels[own[0]].path.to_string();
        let time = match &self.long {
            Some((long, fixed)) if *long == path => *fixed,
            _ => time,
        };
        let now = self.now.get();
        self.lanes.entry(lane).or_default().codel = Some((codel, ticket, now));
        self.plan(now + time, Event::End(lane));
    }

    /// Ends the codel of a lane, by an event that it declares, an exception, or something else.
    fn result(&mut self, lane: LaneId) -> CodelResult {
        let now = self.now.get();
        let state = self.lanes.get_mut(&lane).expect("it exists");
        let (codel, ticket, begun) = state.codel.take().expect("it executes a codel");
        let events = self.codels(lane.0, codel).first().copied();
        let events = events.map_or(&[][..], |codel| self.parts.events(codel));
        // With fixed times, all codels end with an event.
        let drawn = self.dice.below(60) + if self.long.is_some() { 60 } else { 0 };
        let (how, name) = match drawn {
            0 => (CodelEnd::Exception, "::e_planned".to_owned()),
            1 => (CodelEnd::Other, "-7".to_owned()),
            _ if events.is_empty() => (CodelEnd::Event, String::new()),
            _ => {
                let event = self.dice.below(events.len() as u32) as usize;
                (CodelEnd::Event, events[event].clone())
            }
        };
        self.executed += 1;
        self.ends.push(now);
        CodelResult {
            ticket,
            codel,
            nanos: now - begun,
            ended: now,
            how,
            name,
            detail: Vec::new(),
            written: Vec::new(),
        }
    }

    /// Returns true if an event is one of a process that has ended or stands still.
    fn is_of_dead(&self, event: &Event) -> bool {
        let component = match event {
            Event::Run(call) => call.component,
            Event::Delegate(delegation) => delegation.call.component,
            Event::Recall(lane) | Event::Probe(lane, _) => lane.0,
            Event::End(lane) | Event::Tick(lane, _) => lane.0,
            Event::Lost(_) | Event::Arrival(_) => return false,
        };
        let stopped =
            self.stopped.is_some_and(|(of, since)| of == component && self.now.get() >= since);
        stopped || self.gone.contains(&component)
    }

    fn happen(&mut self, event: Event) -> Option<Message> {
        if self.is_of_dead(&event) {
            return None;
        }
        match event {
            Event::Arrival(message) => return Some(message),
            Event::Run(call) => self.begin((call.component, call.lane), call.ticket, call.codel),
            Event::Delegate(delegation) => {
                let lane = (delegation.call.component, delegation.call.lane);
                self.number += 1;
                let number = self.number;
                let tick = delegation.first_tick;
                let state = self.lanes.entry(lane).or_default();
                assert!(state.codel.is_none() && state.cycles.is_none());
                state.ticket = delegation.call.ticket;
                state.cycles = Some(Cycles {
                    state: delegation.state,
                    number,
                    delegation,
                    tick,
                    recalled: false,
                });
                self.plan(tick.max(self.now.get()), Event::Tick(lane, number));
            }
            Event::Recall(lane) => {
                let state = self.lanes.get_mut(&lane)?;
                let cycles = state.cycles.as_mut()?;
                cycles.recalled = true;
                if state.codel.is_none() {
                    self.finish(lane);
                }
            }
            Event::Probe(lane, probe) => {
                self.flush(lane);
                let (component, until) = (lane.0, self.now.get());
                let answer = Message::Probed { component, probe, until };
                self.tell(component, answer);
            }
            Event::Lost(component) => {
                self.gone.insert(component);
                let why = "was planned to be lost".to_owned();
                self.tell(component, Message::Lost { component, why });
            }
            Event::Tick(lane, number) => {
                let cycles = self.lanes[&lane].cycles.as_ref();
                if let Some(cycles) = cycles.filter(|cycles| cycles.number == number) {
                    let codel = cycles.delegation.states[cycles.state].codel;
                    let ticket = cycles.delegation.call.ticket;
                    self.begin(lane, ticket, codel);
                }
            }
            Event::End(lane) => self.end(lane),
        }
        None
    }

    fn end(&mut self, lane: LaneId) {
        let ran = self.result(lane);
        let (how, name, now) = (ran.how, ran.name.clone(), self.now.get());
        let state = self.lanes.get_mut(&lane).expect("it exists");
        let Some(cycles) = &mut state.cycles else {
            return self.tell(lane.0, Message::CodelResult(lane.0, ran));
        };
        self.delegated += 1;
        state.unsent.push(ran);
        let next = &cycles.delegation.states[cycles.state].next;
        let next = next.iter().find(|(event, _)| *event == name);
        let next = next.filter(|_| how == CodelEnd::Event).map(|&(_, next)| next);
        match next {
            Some(DelegatedYield::Next(to)) if !cycles.recalled => {
                cycles.state = to;
                let codel = cycles.delegation.states[to].codel;
                let ticket = cycles.delegation.call.ticket;
                if self.dice.in_ten(5) {
                    self.flush(lane);
                }
                self.begin(lane, ticket, codel);
            }
            Some(DelegatedYield::Pause(to)) if !cycles.recalled => {
                cycles.state = to;
                let period = cycles.delegation.period;
                cycles.tick += (now.saturating_sub(cycles.tick) / period).max(1) * period;
                let event = Event::Tick(lane, cycles.number);
                let time = cycles.tick.max(now);
                self.plan(time, event);
                self.flush(lane);
            }
            _ => self.finish(lane),
        }
    }

    /// Sends the results of the cycles of a lane.
    fn flush(&mut self, lane: LaneId) {
        let state = self.lanes.get_mut(&lane).expect("it exists");
        for ran in std::mem::take(&mut state.unsent) {
            self.tell(lane.0, Message::CodelResult(lane.0, ran));
        }
    }

    /// Ends the cycles of a lane.
    fn finish(&mut self, lane: LaneId) {
        self.flush(lane);
        let state = self.lanes.get_mut(&lane).expect("it exists");
        state.cycles = None;
        let (component, ticket) = (lane.0, state.ticket);
        self.tell(component, Message::Recalled { component, ticket });
    }
}

impl Hosts for Simulated<'_> {
    fn start(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn make(&mut self, _: ComponentId, _: u32, _: u32, _: &[u8]) {}

    fn run(&mut self, call: &Call) {
        if call.ticket == u32::MAX {
            // The copy of an attribute: the engine waits for it.
            let ran = CodelResult {
                ticket: call.ticket,
                codel: call.codel,
                nanos: 0,
                ended: self.now.get(),
                how: CodelEnd::Event,
                name: String::new(),
                detail: Vec::new(),
                written: Vec::new(),
            };
            return self.tell(call.component, Message::CodelResult(call.component, ran));
        }
        self.send(call.component, true, Event::Run(*call));
    }

    fn delegate(&mut self, delegation: &Delegation) {
        let component = delegation.call.component;
        self.send(component, true, Event::Delegate(delegation.clone()));
    }

    fn recall(&mut self, component: ComponentId, lane: u32) {
        self.send(component, true, Event::Recall((component, lane)));
    }

    fn probe(&mut self, component: ComponentId, lane: u32, probe: u32) {
        self.send(component, true, Event::Probe((component, lane), probe));
    }

    fn executing(&self, _: ComponentId, _: u32) -> Option<(u32, u64)> {
        None
    }

    fn end(&mut self, _: ComponentId, _: u32, _: u32) -> Option<Vec<u8>> {
        Some(Vec::new())
    }

    fn share(&mut self, _: Source<'_>, _: &[Reader<'_>], _: &[u8]) {}

    fn feed(&mut self, _: Reader<'_>, _: &[u8]) {}

    fn wait(&mut self, until: u64) -> Option<Message> {
        loop {
            let limit = until.max(self.now.get());
            let next = self.events.first_entry();
            let Some(next) = next.filter(|next| next.key().0 <= limit) else {
                self.waits += 1;
                self.now.set(limit);
                return None;
            };
            let ((time, _), event) = next.remove_entry();
            self.now.set(self.now.get().max(time));
            if let Some(message) = self.happen(event) {
                self.received += 1;
                return Some(message);
            }
        }
    }

    fn now(&self) -> u64 {
        // The engine takes time, too.
        self.now.set(self.now.get() + 300);
        self.now.get()
    }

    fn blocked_after_nanos(&self) -> Option<u64> {
        Some(10_000 * MS)
    }

    fn kill(&mut self, _: ComponentId) {}

    fn reply(&mut self, _: ComponentId, _: u32, _: Result<Vec<u8>, ReplyError>) {}

    fn answer(&mut self, id: u64, answer: RequestReply) {
        self.replied.insert(id);
        if answer != RequestReply::Accepted {
            assert!(self.answered.borrow_mut().insert(id), "one answer");
        }
    }

    fn entered(&mut self, _: u64, _: &str) {}

    fn gone(&mut self, _: ComponentId, why: &str) {
        self.lost.push(why.to_owned());
    }

    fn published(&mut self, _: ComponentId, _: PortId, _: &str, _: &[u8]) {}
}
