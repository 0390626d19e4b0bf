//! The process of a control task: it handles a message at once, except for codels.

use dotgen_timing::explore::Action;
use dotgen_timing::system::{AutomatonId, CodelId, FOREVER, ServiceId};

use crate::model::{Edge, LocationKind, Process, Relation, Term, Update, all};

use super::super::layout::{Layout, Part, executed, number, step, tracked, wanted};
use super::super::published::mode;

/// Returns the process of a control task.
pub(super) fn process(layout: &Layout, part: &Part) -> Process {
    let name = format!("control_task_{}", part.name);
    let mut out = Process::new(&name, format!("the control task of {}", part.name));
    out.location("ready", LocationKind::Normal, "waits for requests and ends of activities");
    out.location("ends", LocationKind::Committed, "the message is handled");
    let ended = all([part.step().is(step::READY), part.own("ended").is(1_usize)]);
    let signal = Edge::new("ready", "ready", "handles the ends of activities").when(ended);
    let signal = signal.sends("step").begins(Action::Signal { component: part.id });
    out.edge(signal.with([part.own("ended").set(0_usize)]).with(examine(layout, part)));
    let end = Edge::new("ends", "ready", "answers, and examines all activities").sends("step");
    out.edge(end.with(answer(layout, part)).with(examine(layout, part)));
    for (service, codels) in &part.services {
        let mut writer = Writer { layout, part, service: *service, codels, out: &mut out };
        writer.add();
    }
    out
}

/// A service that clients request.
struct Writer<'w> {
    layout: &'w Layout<'w>,
    part: &'w Part,
    service: ServiceId,
    codels: &'w [CodelId],
    out: &'w mut Process,
}

impl Writer<'_> {
    fn location(&self, what: &str) -> String {
        format!("{what}_{}", self.layout.service_name(self.service))
    }

    fn validates(&self) -> bool {
        self.layout.system.services[self.service].validate.is_some()
    }

    fn add(&mut self) {
        let (layout, part) = (self.layout, self.part);
        let [takes, accepts] = ["takes", "accepts"].map(|what| self.location(what));
        self.out.location(&takes, LocationKind::Committed, "has taken a request");
        self.out.location(&accepts, LocationKind::Committed, "accepts the request");
        for (client, definition) in layout.system.clients.iter_enumerated() {
            if definition.steps.iter().any(|step| step.requests() == Some(self.service)) {
                let path = layout.system.service_path(self.service);
                let edge = Edge::new("ready", &takes, format!("takes a request for {path}"));
                let sender = part.own("sender").set(usize::from(client) + 1);
                let edge = edge.receives(layout.request(client, self.service)).with([sender]);
                self.out.edge(edge.when(part.takes_requests()));
            }
        }
        let first = if self.validates() {
            self.next(&takes, 0, "validates the request")
        } else {
            Edge::new(&takes, &accepts, "the request needs no validation")
        };
        self.out.edge(first);
        if layout.system.services[self.service].activity {
            self.places(&accepts);
        } else {
            let edge = self.next(&accepts, usize::from(self.validates()), "interrupts, then acts");
            let interrupts = interrupts(layout, self.service, None);
            self.out.edge(Edge { updates: [interrupts, edge.updates].concat(), ..edge });
        }
        for index in 0..self.codels.len() {
            self.codel(index, &accepts);
        }
    }

    /// Gives an activity a place.
    fn places(&mut self, accepts: &str) {
        let layout = self.layout;
        let mut taken = Vec::new();
        for &place in layout.places(self.service) {
            let free = layout.mode(place).is(mode::FREE);
            let found = Edge::new(accepts, "ends", "gives the activity a place");
            let found = found.when(all(taken.iter().cloned().chain([free.clone()])));
            let found = found.with([layout.mode(place).set(mode::ACCEPTED)]);
            let value = tracked::PLACE + usize::from(place);
            let found = found.with(answered(layout, self.part, value));
            self.out.edge(found.with(interrupts(layout, self.service, Some(place))));
            taken.push(free.negated());
        }
        self.out.edge(Edge::new(accepts, "ends", "no place: the request is lost").when(all(taken)));
    }

    /// Returns the edge to a codel, or to the end of the message after the last one.
    fn next(&self, source: &str, index: usize, comment: &str) -> Edge {
        let Some(&codel) = self.codels.get(index) else {
            return Edge::new(source, "ends", comment);
        };
        let what = if self.layout.is_lockless(codel) { "executes" } else { "waits" };
        let target = format!("{}_{index}", self.location(what));
        let edge = Edge::new(source, &target, comment).sends("step");
        let busy = self.part.step().set(step::CODELS);
        edge.with(self.layout.begin(codel, &self.part.name)).with([busy])
    }

    fn codel(&mut self, index: usize, accepts: &str) {
        let (layout, part) = (self.layout, self.part);
        let id = self.codels[index];
        let codel = &layout.system.codels[id];
        let executor = layout.control_executor(part);
        let [waits, executes] =
            ["waits", "executes"].map(|what| format!("{}_{index}", self.location(what)));
        let (words, clock) = (layout.codel_in_words(id), part.clock());
        if !layout.is_lockless(id) {
            let comment = format!("waits for the locks of {words}");
            self.out.location(&waits, LocationKind::Normal, comment);
            let edge = Edge::new(&waits, &executes, format!("begins {}", codel.path));
            let edge = edge.when(layout.is_free(id, &part.name)).sends("step");
            let executing = executed(&part.name).set(number(id));
            let edge = edge.with([executing, Update::Reset(clock.clone())]);
            self.out.edge(edge.begins(Action::Acquire { executor }));
        }
        let upper = (codel.upper != FOREVER).then_some(i64::from(codel.upper));
        let comment = format!("{words}: {}", layout.interval(codel.lower, codel.upper));
        self.out.bounded(&executes, &clock, upper, comment);
        let idle = [executed(&part.name).set(0_usize), wanted(&part.name).set(0_usize)];
        let mut end = |edge: Edge, outcome: usize| {
            let mut edge = edge.when_clock(&clock, Relation::AtLeast, codel.lower);
            // The next codel begins after this one has ended.
            edge.updates.splice(0..0, idle.clone());
            self.out.edge(edge.begins(Action::Finish { executor, outcome }));
        };
        if index == 0 && layout.system.services[self.service].validate.is_some() {
            end(Edge::new(&executes, accepts, "the request is valid"), 0);
            end(Edge::new(&executes, "ends", "the request is refused"), 1);
        } else {
            let writer = Writer { out: &mut Process::default(), ..*self };
            let edge = writer.next(&executes, index + 1, "the codel ends");
            end(edge, 0);
        }
    }
}

/// Returns the updates of the interruptions by a service, or by its activity in a place.
fn interrupts(layout: &Layout, service: ServiceId, itself: Option<AutomatonId>) -> Vec<Update> {
    let mut out = Vec::new();
    let interrupted = layout.system.services[service].interrupts.iter();
    let others = interrupted.flat_map(|&of| layout.places(of));
    for &other in others.filter(|&&other| Some(other) != itself) {
        let mode = layout.mode(other);
        out.push(layout.interrupted(other).set_if(mode.clone().is(mode::RUNS), 1_usize));
        out.push(mode.clone().set_if(mode.is(mode::ACCEPTED), mode::ENDED));
    }
    out
}

/// Returns the updates by which the trackers of the sender follow a place, or nothing.
fn answered(layout: &Layout, part: &Part, value: usize) -> Vec<Update> {
    let trackers = layout.trackers().into_iter().map(|(client, number)| {
        let tracker = layout.tracker(client, number);
        let is_new = all([
            part.own("sender").is(usize::from(client) + 1),
            tracker.clone().is(tracked::HANDLED),
        ]);
        tracker.set_if(is_new, value)
    });
    trackers.collect()
}

/// Returns the updates of the answer to the sender.
fn answer(layout: &Layout, part: &Part) -> Vec<Update> {
    let mut out = answered(layout, part, tracked::NOTHING);
    let sender = part.own("sender");
    for client in layout.system.clients.keys() {
        let asks = layout.outstanding(client);
        out.push(asks.set_if(sender.clone().is(usize::from(client) + 1), 0_usize));
    }
    out.push(sender.set(0_usize));
    out.push(part.step().set(step::READY));
    out
}

/// Returns the updates of the examination: activities that have ended are reported, then those are released
/// that wait for none any more.
fn examine(layout: &Layout, part: &Part) -> Vec<Update> {
    let mut out = Vec::new();
    let places = || {
        let tasks = part.tasks.iter().flat_map(|task| layout.automata(task.id));
        tasks.filter_map(|id| Some((id, layout.system.automata[id].service?)))
    };
    for (id, _) in places() {
        let mode = layout.mode(id);
        let ended = mode.clone().is(mode::ENDED);
        for (client, number) in layout.trackers() {
            let tracker = layout.tracker(client, number);
            let follows = tracker.clone().is(tracked::PLACE + usize::from(id));
            out.push(tracker.set_if(all([ended.clone(), follows]), tracked::NOTHING));
        }
        out.push(mode.set_if(ended, mode::FREE));
    }
    for (id, service) in places() {
        let interrupted = layout.system.services[service].interrupts.iter();
        let others = interrupted.flat_map(|&of| layout.places(of)).filter(|&&other| other != id);
        let free = all(others.map(|&other| layout.mode(other).is(mode::FREE)));
        let released = all([layout.mode(id).is(mode::ACCEPTED), free]);
        let start = Term::from(layout.system.machine_of(id).start);
        out.push(layout.state(id).set_if(released.clone(), start));
        out.push(layout.mode(id).set_if(released, mode::RUNS));
    }
    out
}
