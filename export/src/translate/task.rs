//! The process of a task: its cycles, with their passes over the places of activities.

use dotgen_timing::explore::Action;
use dotgen_timing::system::{FOREVER, Machine, State, Yield};

use crate::model::{Edge, Guard, LocationKind, Process, Relation, Term, Update, all, any, var};

use super::checks::Checks;
use super::layout::{Kind, Layout, Part, TaskPart, number, position, status, step, wanted};
use super::unique::Unique;

/// Writes the process of one task.
struct Writer<'w> {
    layout: &'w Layout<'w>,
    part: &'w Part,
    task: &'w TaskPart,
    checks: &'w Checks<'w>,
    /// Names of the locations of codels.
    locations: Unique,
    out: Process,
}

/// Returns the process of a task.
pub(super) fn process(layout: &Layout, part: &Part, task: &TaskPart, checks: &Checks) -> Process {
    let name = format!("task_{}", task.name);
    let words = layout.task_in_words(task.id);
    let comment = match task.period {
        Some(period) => format!("task {words}, period {}", layout.time(period)),
        None => format!("task {words}, aperiodic"),
    };
    let out = Process::new(&name, comment);
    let mut writer = Writer { layout, part, task, checks, locations: Unique::default(), out };
    writer.cycle();
    writer.begin();
    writer.proceed();
    for kind in writer.kinds() {
        writer.codels(kind);
    }
    writer.end_of_pass();
    writer.out
}

impl<'w> Writer<'w> {
    /// Returns what can be in the places of the task.
    fn kinds(&self) -> Vec<&'w Kind> {
        self.part.kinds.iter().filter(|kind| kind.task == self.task.id).collect()
    }

    /// Returns the number of the task, which is also that of its executor.
    fn executor(&self) -> usize {
        self.task.id.into()
    }

    /// Returns the place of the pass.
    fn at(&self) -> Term {
        self.task.flag("place")
    }

    fn status_is(&self, value: usize) -> Guard {
        self.part.status(self.at()).is(value)
    }

    /// Returns the condition that an array of marks has a value at the place of the pass.
    fn mark(&self, mark: &Term, is_set: bool) -> Guard {
        mark.clone().is(usize::from(is_set))
    }

    fn next_place(&self) -> Update {
        self.at().set(self.at().plus(1))
    }

    /// The locations between passes, and what begins one.
    fn cycle(&mut self) {
        let task = self.task;
        let add = |writer: &mut Self, name: &str, kind, comment: &str| {
            writer.out.location(name, kind, comment);
        };
        add(self, "rest", LocationKind::Normal, "not started, or between two cycles");
        if task.needs_core {
            add(self, "waits", LocationKind::Normal, "waits for a core");
        }
        add(self, "again", LocationKind::Urgent, "before the next pass of the cycle");
        if task.wakes {
            add(
                self,
                "wakes",
                LocationKind::Urgent,
                "its cycle is over; before it wakes the others",
            );
        }
        add(
            self,
            "begins",
            LocationKind::Committed,
            "updates all activities at the start of a pass",
        );
        add(self, "proceeds", LocationKind::Committed, "looks for the next activity of the pass");
        add(self, "ticket", LocationKind::Urgent, "before it takes a ticket for the codel");
        let queued = if self.part.queue { LocationKind::Normal } else { LocationKind::Urgent };
        add(self, "queued", queued, "waits until its codel may begin");
        let (taken, resumes) = self.takes_flag();
        let mut start = Edge::new("rest", "begins", "begins a cycle").when(task.begins());
        if task.needs_core {
            start = start.when(task.could_run(self.part).negated());
            self.cores();
        }
        let pass = [
            task.position().set(position::CYCLE),
            self.at().set(task.base),
            task.flag("resumes").set(1_usize),
        ];
        let begin = Action::Begin { task: self.executor() };
        self.out.edge(start.with(taken).with(pass).begins(begin));
        let again = Edge::new("again", "begins", "begins the next pass of the cycle");
        let again = again.when(task.is_awake()).begins(begin);
        self.out.edge(again.with([self.at().set(task.base)]).with(resumes));
        for source in ["again", "wakes"].into_iter().filter(|_| task.wakes) {
            let target = if source == "again" { "again" } else { "rest" };
            let edge = Edge::new(source, target, "makes the other tasks runnable");
            let wake = Action::Wake { task: self.executor() };
            let edge = edge.when(task.flag("wakes").is(1_usize)).sends("step");
            let mut edge = edge.begins(wake);
            edge.updates.push(task.flag("wakes").set(0_usize));
            edge.updates.extend(self.part.wake(Some(task.id)));
            if source == "wakes" {
                edge.updates.extend(self.frees_core());
            }
            self.out.edge(edge);
        }
    }

    /// Returns the updates that clear the flag at the start of a cycle, and those that decide whether a later
    /// pass resumes paused activities.
    fn takes_flag(&self) -> (Vec<Update>, Vec<Update>) {
        let (due, resumes) = (self.task.due(), self.task.flag("resumes"));
        let clear = vec![due.clone().set(0_usize)];
        match self.task.period {
            Some(_) => (clear, vec![resumes.set(0_usize)]),
            None => (clear, vec![resumes.set(due.clone()), due.set(0_usize)]),
        }
    }

    /// Asking for a core, and getting it.
    fn cores(&mut self) {
        let (layout, task) = (self.layout, self.task);
        let number = usize::from(task.id) + 1;
        let mut ask = Edge::new("rest", "waits", "takes its flag and asks for a core")
            .when(all([task.begins(), task.could_run(self.part)]))
            .receives("ask")
            .begins(Action::Release { task: self.executor() });
        if task.period.is_some() {
            ask.updates.push(task.due().set(0_usize));
        }
        ask.updates.push(task.position().set(position::WAITS));
        let mut grant = Edge::new("waits", "begins", "gets a core")
            .receives("grant")
            .begins(Action::Grant { task: self.executor() });
        let used = var("cores_used");
        grant.updates.push(used.clone().set(used.plus(1)));
        grant.updates.push(task.flag("core").set(1_usize));
        if layout.is_fifo() {
            let (length, queue) = (var("core_waiting"), |i: Term| Term::element("core_queue", i));
            ask.updates.push(queue(length.clone()).set(number));
            ask.updates.push(length.clone().set(length.clone().plus(1)));
            grant.guard = queue(Term::from(0_usize)).is(number);
            let shift = |i: usize| queue(Term::from(i)).set(queue(Term::from(i + 1)));
            grant.updates.extend((0..layout.system.tasks.len()).map(shift));
            grant.updates.push(length.clone().set(length.plus(-1)));
        }
        if task.period.is_some() {
            grant.updates.push(task.flag("resumes").set(1_usize));
        } else {
            grant.updates.push(task.flag("resumes").set(task.due()));
            grant.updates.push(task.due().set(0_usize));
        }
        grant.updates.push(task.position().set(position::CYCLE));
        grant.updates.push(self.at().set(task.base));
        self.out.edge(ask);
        self.out.edge(grant);
    }

    fn frees_core(&self) -> Vec<Update> {
        if !self.task.needs_core {
            return Vec::new();
        }
        let (used, core) = (var("cores_used"), self.task.flag("core"));
        let less = used.clone().plus(-1);
        vec![used.set_if(core.clone().is(1_usize), less), core.set(0_usize)]
    }

    /// The start of a pass: all activities are updated, one after the other.
    fn begin(&mut self) {
        let (part, at) = (self.part, self.at());
        let edge = |comment: &str| Edge::new("begins", "begins", comment);
        let resumes = self.task.flag("resumes").is(1_usize);
        let paused = self.mark(&part.paused(at.clone()), true);
        let (released, interrupted, not_interrupted) = if part.activities {
            let interrupted = part.interrupted(at.clone());
            let released = part.released(at.clone()).is(1_usize);
            (released, self.mark(&interrupted, true), self.mark(&interrupted, false))
        } else {
            (Guard::always(), any([]), Guard::always())
        };
        let active = any([self.status_is(status::RUNS), self.status_is(status::STOPS)]);
        // An interrupted activity that has its status `stops` has noticed.
        let may_resume = any([self.status_is(status::STOPS), not_interrupted.clone()]);
        let resumed = all([active.clone(), may_resume, resumes.clone(), paused.clone()]);
        let begun = all([
            self.status_is(status::ACCEPTED),
            not_interrupted.clone(),
            released.clone(),
            resumes.clone(),
        ]);
        let mut others = vec![
            any([self.status_is(status::FREE), self.status_is(status::ENDED)]),
            all([active, resumed.negated()]),
            all([self.status_is(status::ACCEPTED), begun.negated()]),
        ];
        if part.activities {
            let stops = any([
                self.status_is(status::RUNS),
                all([self.status_is(status::ACCEPTED), part.permanent(at.clone()).is(1_usize)]),
            ]);
            let stopped = all([interrupted.clone(), stops]);
            self.interruptions(&stopped, &interrupted);
            others[1] = all([others[1].clone(), stopped.negated()]);
            others[2] = all([others[2].clone(), not_interrupted]);
        }
        for kind in self.kinds() {
            let start = self.layout.machine(kind).map_or(0, |machine| machine.start);
            let comment = format!("{} begins", kind.name);
            let edge =
                edge(&comment).when(all([begun.clone(), part.kind(at.clone()).is(kind.number)]));
            let updates =
                [part.status(at.clone()).set(status::RUNS), part.state(at.clone()).set(start)];
            let edge = edge.with(updates).with(part.clear(&at)).with([self.next_place()]);
            self.out.edge(edge);
        }
        let resume = part.paused(at.clone()).set(0_usize);
        let resumed =
            edge("a paused activity continues").when(resumed).with([resume, self.next_place()]);
        self.out.edge(resumed);
        let other = edge("nothing changes").when(any(others)).with([self.next_place()]);
        self.out.edge(other);
        let last = Edge::new("begins", "proceeds", "all activities are updated");
        let last = last.when(self.status_is(status::LAST));
        let rest = [self.at().set(self.task.base), self.task.flag("resumes").set(0_usize)];
        self.out.edge(last.with(rest));
    }

    /// The edges of interrupted activities at the start of a pass.
    fn interruptions(&mut self, stopped: &Guard, interrupted: &Guard) {
        let (part, at) = (self.part, self.at());
        for kind in self.kinds() {
            let machine = self.layout.machine(kind);
            let stop = machine.map_or(1, |machine| machine.stop.unwrap_or(machine.states.len()));
            let edge = Edge::new("begins", "begins", format!("{} is interrupted", kind.name));
            let edge = edge.when(all([stopped.clone(), part.kind(at.clone()).is(kind.number)]));
            let updates =
                [part.status(at.clone()).set(status::STOPS), part.state(at.clone()).set(stop)];
            self.out.edge(edge.with(updates).with(part.clear(&at)).with([self.next_place()]));
        }
        let comment = "an interrupted activity ends before its first codel";
        let edge = Edge::new("begins", "begins", comment).when(all([
            self.status_is(status::ACCEPTED),
            interrupted.clone(),
            part.permanent(at.clone()).is(0_usize),
        ]));
        let mut updates =
            vec![part.status(at.clone()).set(status::ENDED), part.state(at.clone()).set(0_usize)];
        updates.extend(part.clear(&at));
        updates.extend(self.ends());
        self.out.edge(edge.with(updates).with([self.next_place()]));
    }

    /// Returns the update that notes the end of an activity, for the control task.
    fn ends(&self) -> Option<Update> {
        self.part.control.then(|| self.task.flag("ends").set(1_usize))
    }

    /// Returns the updates of the end of the activity in the place of the pass.
    fn end_of_activity(&self, success: impl Into<Term>) -> Vec<Update> {
        let (part, at) = (self.part, self.at());
        let mut out =
            vec![part.status(at.clone()).set(status::ENDED), part.state(at.clone()).set(0_usize)];
        out.extend(part.clear(&at));
        out.push(part.success(at).set(success));
        out.extend(self.ends());
        out.push(self.task.flag("event").set(1_usize));
        out
    }

    /// The choice of the next activity of a pass.
    fn proceed(&mut self) {
        let (part, at) = (self.part, self.at());
        let edge = |target: &str, comment: &str| Edge::new("proceeds", target, comment);
        let active = any([self.status_is(status::RUNS), self.status_is(status::STOPS)]);
        let runs = all([active.clone(), part.paused(at.clone()).is(0_usize)]);
        let rests = all([runs.negated(), part.status(at.clone()).is_not(status::LAST)]);
        let skip = edge("proceeds", "the activity is paused, or there is none");
        self.out.edge(skip.when(rests).with([self.next_place()]));
        for kind in self.kinds() {
            let of_kind = all([runs.clone(), part.kind(at.clone()).is(kind.number)]);
            let states = self.layout.machine(kind).map_or(&[][..], |machine| &machine.states);
            for (index, state) in entered(states) {
                let comment = format!("{} is in {}", kind.name, state.name);
                let edge = edge("ticket", &comment);
                let edge = edge.when(all([of_kind.clone(), part.state(at.clone()).is(index)]));
                let wants = wanted(&self.task.name).set(number(state.codel));
                self.out.edge(edge.sends("step").with([wants]));
            }
            let machine = self.layout.machine(kind);
            let has_stop = |machine: &Machine| machine.stop.is_some() || !part.activities;
            if machine.is_some_and(has_stop) {
                continue;
            }
            let comment = format!("{} has no codel for its state: it ends", kind.name);
            let edge = edge("proceeds", &comment).when(of_kind);
            let edge = edge.when(part.state(at.clone()).at_least(states.len()));
            let permanent = part.permanent(at.clone());
            let end = self.end_of_activity(permanent);
            self.out.edge(edge.with(end).with([self.next_place()]));
        }
        let last = edge("ended", "the pass has ended").when(self.status_is(status::LAST));
        self.out.edge(last.with([self.at().set(self.task.base)]));
    }

    /// The codels of a machine.
    fn codels(&mut self, kind: &Kind) {
        let Some(machine) = self.layout.machine(kind) else {
            return;
        };
        for (index, state) in entered(&machine.states) {
            let name = format!("executes_{}_{}", kind.name, state.name);
            let location = self.locations.take(&name, &state.name);
            let codel = &self.layout.system.codels[state.codel];
            let upper = (codel.upper != FOREVER).then_some(i64::from(codel.upper));
            let clock = self.task.clock();
            let words = self.layout.codel_in_words(state.codel);
            let comment = format!("{words}: {}", self.layout.interval(codel.lower, codel.upper));
            self.out.bounded(&location, &clock, upper, comment);
            let begin = Edge::new("queued", &location, format!("begins {}", codel.path));
            let wants = wanted(&self.task.name);
            let mut begin = begin
                .when(wants.is(number(state.codel)))
                .begins(Action::Acquire { executor: self.executor() });
            if entered(&machine.states).filter(|(_, other)| other.codel == state.codel).count() > 1
            {
                // A loop with a limit is unfolded.
                begin = begin.when(self.part.state(self.at()).is(index));
            }
            if self.part.queue {
                let first = self.part.lock_queue(0_usize).is(self.task.executor());
                let free = self
                    .layout
                    .blocked(state.codel, &self.task.name)
                    .iter()
                    .map(Guard::negated)
                    .collect::<Vec<_>>();
                begin = begin.when(all([first, all(free)]));
            }
            let executes = self.task.flag("codel").set(number(state.codel));
            let begin = begin.sends("step").with([executes, Update::Reset(clock.clone())]);
            self.out.edge(begin.with(self.part.pop()));
            let ends = state.yields.iter().copied().map(Some).chain(self.throws(kind, state));
            for outcome in ends {
                self.end_of_codel(kind, (index, &location), outcome);
            }
        }
        if self.out.edges.iter().all(|edge| edge.target != "queued") {
            let edge = Edge::new("ticket", "queued", "takes a ticket")
                .sends("step")
                .begins(Action::Ticket { executor: self.executor() });
            self.out.edge(edge.with(self.part.push(self.task.executor())));
        }
    }

    /// Returns the end by an exception, if it differs from the ends by yields.
    fn throws(&self, kind: &Kind, state: &State) -> Option<Option<Yield>> {
        let throws = self.layout.system.codels[state.codel].throws;
        let noted = self.layout.asks_outcomes()
            || kind.service.is_none_or(|service| self.layout.notes_success(service));
        (throws && (noted || !state.yields.contains(&Yield::End))).then_some(None)
    }

    /// The end of a codel with a yield, or without one by an exception.
    fn end_of_codel(&mut self, kind: &Kind, (state, location): (usize, &str), by: Option<Yield>) {
        let (part, at) = (self.part, self.at());
        let Some(machine) = self.layout.machine(kind) else {
            return;
        };
        let codel = &self.layout.system.codels[machine.states[state].codel];
        let name = |to: usize| machine.states.get(to).map_or("ether", |state| &state.name);
        let (what, updates) = match by {
            Some(Yield::Next(to)) => (
                name(to).to_owned(),
                vec![
                    part.state(at.clone()).set(to),
                    self.task.flag("event").set(1_usize),
                    self.task.flag("goes_on").set(1_usize),
                ],
            ),
            Some(Yield::Pause(to)) => (
                format!("pause::{}", name(to)),
                vec![part.state(at.clone()).set(to), part.paused(at.clone()).set(1_usize)],
            ),
            Some(Yield::End) => ("ether".to_owned(), self.end_of_activity(1_usize)),
            None => ("an exception".to_owned(), self.end_of_activity(0_usize)),
        };
        let edge = Edge::new(location, "proceeds", format!("ends with {what}"));
        let mut edge = edge.when_clock(&self.task.clock(), Relation::AtLeast, codel.lower);
        edge.action = (kind.automaton)
            .and_then(|id| self.layout.end_of_codel((id, self.executor()), state, by));
        let executor = [self.task.flag("codel").set(0_usize), wanted(&self.task.name).set(0_usize)];
        self.out.edge(edge.with(executor).with(updates).with([self.next_place()]));
    }

    /// The end of a pass, and of the cycle if no pass follows.
    fn end_of_pass(&mut self) {
        self.out.location("ended", LocationKind::Committed, "the pass has ended");
        self.out.location(
            "settles",
            LocationKind::Committed,
            "before the next pass or the next cycle",
        );
        let (part, task) = (self.part, self.task);
        let event = task.flag("event").is(1_usize);
        let mut updates = Vec::new();
        if task.period.is_none() {
            updates.push(task.due().set_if(event.clone(), 1_usize));
        }
        if task.wakes {
            updates.push(task.flag("wakes").set_if(event, 1_usize));
        }
        if part.control {
            let ended = part.own("ended");
            updates.push(ended.set_if(task.flag("ends").is(1_usize), 1_usize));
            updates.push(task.flag("ends").set(0_usize));
        }
        updates.push(task.flag("event").set(0_usize));
        let next = self.starts_next();
        if let Some((guard, start)) = &next {
            let edge =
                Edge::new("ended", "settles", "its first pass is over: the next task starts");
            self.out.edge(edge.when(guard.clone()).with(updates.clone()).with(start.clone()));
        }
        let otherwise = next.map_or(Guard::always(), |(guard, _)| guard.negated());
        let edge = Edge::new("ended", "settles", "the pass has no effect on the start-up");
        self.out.edge(edge.when(otherwise).with(updates));
        let again = Edge::new("settles", "again", "another pass follows");
        let again = again.when(task.flag("goes_on").is(1_usize)).sends("step");
        self.out.edge(again.with([task.flag("goes_on").set(0_usize)]));
        let ends = [(task.is_awake(), "rest"), (task.is_awake().negated(), "wakes")];
        for (guard, measured, comment) in self.checks.at_end(task) {
            let idle = [task.position().set(position::IDLE), task.flag("first").set(0_usize)];
            for (awake, target) in ends.iter().take(1 + usize::from(task.wakes)) {
                let edge = Edge::new("settles", target, comment);
                let over = task.flag("goes_on").is(0_usize);
                let edge = edge.when(all([over, awake.clone(), guard.clone()]));
                let mut edge = edge.sends("step").with(measured.clone()).with(idle.clone());
                if *target == "rest" {
                    edge.updates.extend(self.frees_core());
                }
                self.out.edge(edge);
            }
        }
    }

    /// Returns the condition under which a pass lets the next task start, and the start.
    fn starts_next(&self) -> Option<(Guard, Vec<Update>)> {
        let (part, task) = (self.part, self.task);
        if !part.starts() {
            return None;
        }
        let place = task.base;
        let begun =
            any([part.status(place).is_not(status::ACCEPTED), part.permanent(place).is(0_usize)]);
        let succeeded = any([
            part.status(place).is_not(status::ENDED),
            part.permanent(place).is(0_usize),
            part.success(place).is(1_usize),
        ]);
        let starting = part.own("starting");
        let guard = all([starting.clone().is(task.index), begun, succeeded]);
        let mut updates = vec![starting.set(task.index + 1)];
        match part.tasks.get(task.index + 1) {
            Some(next) => updates.push(next.position().set(position::IDLE)),
            None if part.control => updates.push(part.step().set(step::READY)),
            None => {}
        }
        Some((guard, updates))
    }
}

/// Returns the states of a machine that can be entered, with their indices.
fn entered(states: &[State]) -> impl Iterator<Item = (usize, &State)> {
    states.iter().enumerate().filter(|(_, state)| !state.yields.is_empty())
}
