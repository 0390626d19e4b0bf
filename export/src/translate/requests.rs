//! The requests of a control task: a place, codels, the reply.

use dotgen_timing::explore::Action;
use dotgen_timing::system::{CodelId, FOREVER, ServiceId};

use crate::model::{Edge, Guard, LocationKind, Process, Relation, Term, Update, all, any};

use super::activities::{examine, free, interrupted, mark};
use super::layout::{Layout, Part, number, status, step, tracked, wanted};

/// Adds the handling of every requested service to the process of a control task.
pub(super) fn add(layout: &Layout, part: &Part, out: &mut Process) {
    for (service, codels) in &part.services {
        let mut writer =
            Writer { layout, part, service: *service, codels, out, name: String::new() };
        writer.name.clone_from(&layout.system.services[*service].name);
        writer.takes();
        writer.codels();
        writer.reply();
    }
}

struct Writer<'w> {
    layout: &'w Layout<'w>,
    part: &'w Part,
    service: ServiceId,
    codels: &'w [CodelId],
    out: &'w mut Process,
    name: String,
}

impl Writer<'_> {
    fn is_activity(&self) -> bool {
        self.layout.kind_of(self.service).is_some()
    }

    fn location(&self, what: &str) -> String {
        format!("{what}_{}", self.name)
    }

    /// Takes a request, and gives an activity its place.
    fn takes(&mut self) {
        let (layout, part) = (self.layout, self.part);
        let places = self.location("places");
        let begins = self.location("begins");
        self.out.location(&places, LocationKind::Committed, "looks for a free place");
        self.out.location(&begins, LocationKind::Committed, "checks `after` and `before`");
        for (client, definition) in layout.system.clients.iter_enumerated() {
            let sends = definition.steps.iter().any(|step| step.requests() == Some(self.service));
            if !sends {
                continue;
            }
            let target = if self.is_activity() { &places } else { &begins };
            let edge = Edge::new("ready", target, format!("takes a request for {}", self.name));
            let edge = edge.when(part.step().is(step::READY));
            let base =
                layout.kind_of(self.service).map_or(0, |(_, kind)| part.task(kind.task).base);
            let updates =
                [part.own("sender").set(usize::from(client) + 1), part.own("at").set(base)];
            self.out.edge(edge.receives(layout.request(client, self.service)).with(updates));
        }
        let at = part.own("at");
        if let Some((_, kind)) = layout.kind_of(self.service) {
            let is = |value: usize| part.status(at.clone()).is(value);
            let found = Edge::new(&places, &begins, "gives the activity a place");
            let found = found.when(is(status::FREE)).with([
                part.status(at.clone()).set(status::ACCEPTED),
                part.kind(at.clone()).set(kind.number),
                part.own("place").set(at.clone().plus(1)),
                at.clone().set(0_usize),
            ]);
            self.out.edge(found);
            let next = Edge::new(&places, &places, "the place is taken");
            let taken = all([
                part.status(at.clone()).is_not(status::FREE),
                part.status(at.clone()).is_not(status::LAST),
            ]);
            self.out.edge(next.when(taken).with([at.clone().set(at.clone().plus(1))]));
            let none = Edge::new(&places, &self.location("replies"), "no place: it is rejected");
            let none = none.when(is(status::LAST)).sends("step");
            let rejected = [part.own("refused").set(1_usize), at.set(0_usize)];
            self.out.edge(none.with(rejected).with([part.step().set(step::REPLIES)]));
        }
        self.order(&begins);
    }

    /// Checks the order of services.
    fn order(&mut self, begins: &str) {
        let service = &self.layout.system.services[self.service];
        let succeeded = |&of: &ServiceId| {
            if self.layout.notes_success(of) {
                self.layout.success(of).is(1_usize)
            } else {
                any([])
            }
        };
        let after = service.after.iter().map(succeeded);
        let before = service.before.iter().map(|of| succeeded(of).negated());
        let allowed = all(after.chain(before));
        let refused = allowed.negated();
        let edge = self.next(begins, 0, "goes on").when(allowed);
        self.out.edge(edge);
        let edge = Edge::new(begins, &self.location("replies"), "not allowed now: refused");
        let edge = edge.when(refused.clone()).sends("step").with(self.done(true));
        if refused != any([]) {
            self.out.edge(edge);
        }
    }

    /// Returns the edge to the codel with a number, or to the reply.
    fn next(&self, from: &str, codel: usize, comment: &str) -> Edge {
        let Some(&id) = self.codels.get(codel) else {
            let edge = Edge::new(from, &self.location("replies"), comment);
            return edge.sends("step").with(self.done(false));
        };
        let target = format!("{}_{codel}", self.location("ticket"));
        let wants = wanted(&self.part.name).set(number(id));
        let busy = self.part.step().set(step::CODELS);
        Edge::new(from, &target, comment).sends("step").with([wants, busy])
    }

    /// Returns the updates after the last codel: all tasks are runnable.
    fn done(&self, refused: bool) -> Vec<Update> {
        let mut out = self.part.wake(None);
        if refused {
            out.push(self.part.own("refused").set(1_usize));
        }
        out.push(self.part.step().set(step::REPLIES));
        if self.part.has_control_codels() {
            out.push(wanted(&self.part.name).set(0_usize));
        }
        out
    }

    fn codels(&mut self) {
        let (layout, part) = (self.layout, self.part);
        let queues = part.tasks.len() + 1;
        let executor = layout.control_executor(part);
        for (index, &id) in self.codels.iter().enumerate() {
            let [ticket, queued, executes] = ["ticket", "queued", "executes"]
                .map(|what| format!("{}_{index}", self.location(what)));
            let codel = &layout.system.codels[id];
            let upper = (codel.upper != FOREVER).then_some(i64::from(codel.upper));
            let clock = part.clock();
            self.out.location(&ticket, LocationKind::Urgent, "before it takes a ticket");
            let kind = if part.queue { LocationKind::Normal } else { LocationKind::Urgent };
            self.out.location(&queued, kind, "waits until its codel may begin");
            let words = layout.codel_in_words(id);
            let comment = format!("{words}: {}", layout.interval(codel.lower, codel.upper));
            self.out.bounded(&executes, &clock, upper, comment);
            let take = Edge::new(&ticket, &queued, "takes a ticket").sends("step");
            self.out.edge(take.with(part.push(queues)).begins(Action::Ticket { executor }));
            let mut begin = Edge::new(&queued, &executes, format!("begins {}", codel.path))
                .begins(Action::Acquire { executor });
            if part.queue {
                let free: Vec<Guard> =
                    layout.blocked(id, &part.name).iter().map(Guard::negated).collect();
                begin = begin.when(all([part.lock_queue(0_usize).is(queues), all(free)]));
            }
            let executing = part.own("codel").set(number(id));
            let begin = begin.sends("step").with([executing, Update::Reset(clock.clone())]);
            self.out.edge(begin.with(part.pop()));
            let free = part.own("codel").set(0_usize);
            let end = self.next(&executes, index + 1, "the codel ends");
            let end = end.when_clock(&clock, Relation::AtLeast, codel.lower).with([free.clone()]);
            self.out.edge(end.begins(Action::Finish { executor, outcome: 0 }));
            let validates = index == 0 && layout.system.services[self.service].validate.is_some();
            if validates || codel.throws {
                let replies = self.location("replies");
                let edge = Edge::new(&executes, &replies, "the codel refuses").sends("step");
                let edge = edge.when_clock(&clock, Relation::AtLeast, codel.lower);
                let edge = edge.begins(Action::Finish { executor, outcome: 1 });
                self.out.edge(edge.with(self.done(true)).with([free]));
            }
        }
    }

    /// The reply, and what comes with it.
    fn reply(&mut self) {
        let (layout, part) = (self.layout, self.part);
        let replies = self.location("replies");
        let comment = "before the reply and the examination of all activities";
        self.out.location(&replies, LocationKind::Urgent, comment);
        let (place, refused) = (part.own("place"), part.own("refused"));
        let edge = |target: &str, comment: &str| {
            Edge::new(&replies, target, comment).begins(Action::Reply { component: part.id })
        };
        if self.is_activity() {
            let accepted = edge("examines", "the activity is accepted");
            let accepted = accepted.when(refused.clone().is(0_usize));
            let value = place.clone().plus((tracked::PLACE - 1 + part.offset) as i64);
            let accepted = accepted.with(self.answered(&value, false)).with(examine(part));
            self.out.edge(accepted);
            let rejected = edge("examines", "rejected for lack of a place");
            let rejected =
                rejected.when(all([refused.clone().is(1_usize), place.clone().is(0_usize)]));
            let nothing = Term::from(tracked::NOTHING);
            self.out.edge(rejected.with(self.answered(&nothing, true)).with(examine(part)));
            let edge = edge("examines", "refused: its place is free again");
            let edge = edge.when(all([refused.is(1_usize), place.clone().is_not(0_usize)]));
            let freed = free(layout, part, &place.plus(-1));
            self.out.edge(edge.with(freed).with(self.answered(&nothing, true)).with(examine(part)));
            return;
        }
        let nothing = Term::from(tracked::NOTHING);
        let refusal = edge("examines", "the request is refused").when(refused.clone().is(1_usize));
        self.out.edge(refusal.with(self.answered(&nothing, true)).with(examine(part)));
        let mut last = self.answered(&nothing, false);
        if layout.notes_success(self.service) {
            last.insert(0, layout.success(self.service).set(1_usize));
        }
        if interrupted(layout, part, self.service).next().is_none() {
            let success = edge("examines", "the request has succeeded");
            let success = success.when(refused.is(0_usize));
            self.out.edge(success.with(last).with(examine(part)));
            return;
        }
        let marks = self.location("interrupts");
        let success = edge(&marks, "the request has succeeded: it interrupts");
        let success = success.when(refused.is(0_usize)).with([part.own("other").set(0_usize)]);
        self.out.edge(success);
        self.out.location(&marks, LocationKind::Committed, "marks the activities it interrupts");
        mark(layout, part, self.service, &marks, None, self.out);
        let end = Edge::new(&marks, "examines", "all that it interrupts are marked");
        let end = end.when(part.own("other").is(part.size - 1));
        self.out.edge(end.with(last).with(examine(part)));
    }

    /// Returns the updates of the answer, also to a refused request. `tracked`: what the client follows from
    /// now on.
    fn answered(&self, tracked: &Term, refused: bool) -> Vec<Update> {
        let (layout, part) = (self.layout, self.part);
        let sender = part.own("sender");
        let mut out = Vec::new();
        for (client, number) in layout.trackers() {
            let tracker = layout.tracker(client, number);
            let is_new = all([
                sender.clone().is(usize::from(client) + 1),
                tracker.clone().is(tracked::HANDLED),
            ]);
            let failed = refused && layout.asks_outcome(client, number);
            let value = if failed { Term::from(tracked::FAILED) } else { tracked.clone() };
            out.push(tracker.set_if(is_new, value));
        }
        for client in layout.system.clients.keys() {
            let asks = layout.outstanding(client);
            out.push(asks.set_if(sender.clone().is(usize::from(client) + 1), 0_usize));
        }
        out.push(sender.set(0_usize));
        out.push(part.own("place").set(0_usize));
        out.push(part.own("refused").set(0_usize));
        out.push(part.step().set(step::READY));
        out
    }
}
