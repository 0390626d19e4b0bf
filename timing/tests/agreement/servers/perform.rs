//! The effects of steps: clients, cores, passes, tickets, and the passage of time.

use dotgen_timing::scn::ast::Policy;
use dotgen_timing::scn::semantics::{PauseRule, TickRule, TurnRule};

use super::model::{Action, Outcome};
use super::possible::Step;
use super::state::{
    CAP, Control, Doing, First, Instance, Phase, Since, State, Status, Who, machine,
};
use super::{Interpreter, Results};

impl Interpreter<'_> {
    pub(super) fn perform(&self, before: &State, step: Step, out: &mut Results) -> State {
        let mut s = before.clone();
        match step {
            Step::Proceed(k, next) => (s.clients[k].at, s.clients[k].clock) = (Some(next), 0),
            Step::Request(k, next) => self.request(&mut s, k, next, out),
            Step::Tick(c, t) => {
                let period = self.system.components[c].tasks[t].period;
                let has_core = self.has_core(before, c, Who::Task(t));
                let task = &mut s.components[c].tasks[t];
                task.timer = period;
                // Without a core an idle task cannot serve its tick.
                let at_work = task.phase != Phase::Idle || (task.flag.is_some() && !has_core);
                out.missed[c][t] |= at_work && task.first == First::Over;
                task.flag.get_or_insert(Since::default());
            }
            Step::Ask(c, t) => {
                self.take_flag(&mut s, c, t);
                let could_run = self.could_run(&s, c, t);
                let task = &mut s.components[c].tasks[t];
                if could_run {
                    task.phase = Phase::WaitingForCore;
                    s.queue.push((c, t));
                    if self.system.policy == Policy::Any {
                        s.queue.sort_unstable();
                    }
                } else {
                    // The wake-up is consumed. It is a job all the same, if it serves a tick.
                    task.runnable = false;
                    self.end_cycle(&mut s, c, t, out);
                }
            }
            Step::Grant(c, t) => {
                s.queue.retain(|queue| *queue != (c, t));
                s.components[c].tasks[t].on_core = true;
                self.begin(&mut s, c, t, out);
            }
            Step::Begin(c, t) => {
                if s.components[c].tasks[t].phase == Phase::Idle {
                    self.take_flag(&mut s, c, t);
                }
                self.begin(&mut s, c, t, out);
            }
            Step::Swap(on, off) => {
                s.on.retain(|candidate| *candidate != off);
                s.on.push(on);
                s.on.sort_unstable();
            }
            Step::Give(who) => {
                s.on.push(who);
                s.on.sort_unstable();
            }
            Step::Queue(who) => s.ready.push(who),
            Step::Ticket(c, who) => {
                s.components[c].tickets.push(who);
                s.set_doing(c, who, Doing::Queued);
            }
            Step::Leave(c, who) => {
                s.components[c].tickets.retain(|ticket| *ticket != who);
                s.set_doing(c, who, Doing::Executing(0));
            }
            Step::End(c, t, outcome) => self.end(&mut s, c, t, outcome, out),
            Step::Handled(c, goes_on) => self.handled(&mut s, c, goes_on),
            Step::Wake(c, t) => {
                let task = &mut s.components[c].tasks[t];
                task.wake = false;
                // The last action of the thread after its last pass.
                task.on_core &= task.phase != Phase::Idle;
                self.wake(&mut s, c, Some(t));
            }
            Step::Rest(c) => self.rest(&mut s, c),
            Step::Report(c) => self.report(&mut s, c),
            Step::Die(c) => self.die(&mut s, c),
        }
        self.no_more_ready(&mut s);
        self.watch(Some(before), &mut s);
        s
    }

    /// Makes all aperiodic tasks of a component except one runnable.
    pub(super) fn wake(&self, s: &mut State, c: usize, but: Option<usize>) {
        for t in 0..s.components[c].tasks.len() {
            if Some(t) != but {
                self.set_runnable(s, c, t);
            }
        }
    }

    /// Makes a task runnable. The flag of a periodic task is never read.
    pub(super) fn set_runnable(&self, s: &mut State, c: usize, t: usize) {
        let aperiodic = self.system.components[c].tasks[t].period.is_none();
        let task = &mut s.components[c].tasks[t];
        task.runnable = aperiodic && !task.gone;
    }

    /// Begins a cycle, which serves the tick, or is the first one.
    fn take_flag(&self, s: &mut State, c: usize, t: usize) {
        let task = &mut s.components[c].tasks[t];
        task.job = task.flag.take();
        if task.first == First::Started {
            task.first = First::InCycle;
        }
    }

    /// Begins a pass, up to its first codel.
    fn begin(&self, s: &mut State, c: usize, t: usize, out: &mut Results) {
        let periodic = self.system.components[c].tasks[t].period.is_some();
        let task = &mut s.components[c].tasks[t];
        let runnable = if periodic {
            task.phase != Phase::Between
        } else {
            std::mem::take(&mut task.runnable)
        };
        let mut turns = Vec::new();
        for slot in 0..task.slots.len() {
            let Some(instance) = &mut task.slots[slot] else {
                continue;
            };
            let machine = machine(self.system, c, t, instance);
            let nowhere = usize::MAX;
            let marked = std::mem::take(&mut instance.mark);
            match instance.status {
                // A permanent activity is marked when its component is killed, and executes `stop` in any
                // case.
                Status::Init(_) if marked && instance.service.is_none() => {
                    instance.status = Status::Stop;
                    instance.at = machine.stop.unwrap_or(nowhere);
                    turns.push(slot);
                }
                Status::Asked | Status::Init(_) if marked => {
                    instance.status = Status::Ended(false);
                    instance.at = 0;
                    task.ended = true;
                }
                Status::Init(true) if runnable => {
                    instance.status = Status::Run;
                    instance.at = machine.start.unwrap_or(nowhere);
                    turns.push(slot);
                }
                Status::Run if marked => {
                    instance.status = Status::Stop;
                    instance.at = machine.stop.unwrap_or(nowhere);
                    instance.paused = false;
                    turns.push(slot);
                }
                Status::Run | Status::Stop if runnable || !instance.paused => {
                    instance.paused = false;
                    turns.push(slot);
                }
                _ => instance.mark = marked,
            }
        }
        task.phase = Phase::Pass(turns, 0, Doing::Nothing);
        self.turn(s, c, t, out);
    }

    /// Proceeds to the next turn that has a codel. Turns without one end at once. After the last turn the
    /// pass ends.
    fn turn(&self, s: &mut State, c: usize, t: usize, out: &mut Results) {
        let task = &mut s.components[c].tasks[t];
        while let Phase::Pass(slots, at, doing) = &mut task.phase {
            let Some(&slot) = slots.get(*at) else {
                return self.end_pass(s, c, t, out);
            };
            let has_codel = task.slots[slot].as_ref().is_some_and(|slot| slot.at != usize::MAX);
            *doing = Doing::Nothing;
            if has_codel {
                return;
            }
            *at += 1;
            (task.event, task.ended) = (true, true);
            // The default `start` and `stop` of a permanent activity do nothing; an activity without `stop`
            // is interrupted.
            let permanent = task.slots[slot].as_ref().is_some_and(|slot| slot.service.is_none());
            end_instance(&mut task.slots[slot], permanent);
        }
    }

    fn end(&self, s: &mut State, c: usize, t: usize, outcome: Outcome, out: &mut Results) {
        let task = &mut s.components[c].tasks[t];
        let Phase::Pass(slots, at, _) = &mut task.phase else {
            unreachable!("a codel is executed in a pass");
        };
        let slot = slots[*at];
        *at += 1;
        task.event |= !matches!(outcome, Outcome::Pause(_));
        match (outcome, &mut task.slots[slot]) {
            (Outcome::Next(to), Some(slot)) => slot.at = to,
            (Outcome::Pause(to), Some(slot)) => (slot.at, slot.paused) = (to, true),
            (outcome, slot) => {
                let permanent = slot.as_ref().is_some_and(|instance| instance.service.is_none());
                task.failed |= permanent && outcome == Outcome::Throw;
                task.ended = true;
                end_instance(slot, outcome == Outcome::End);
            }
        }
        if self.system.semantics.turns == TurnRule::Pause && matches!(outcome, Outcome::Next(_)) {
            // The turn lasts until the automaton pauses or ends.
            if let Phase::Pass(_, at, doing) = &mut task.phase {
                *at -= 1;
                *doing = Doing::Nothing;
            }
            return;
        }
        self.turn(s, c, t, out);
    }

    fn end_pass(&self, s: &mut State, c: usize, t: usize, out: &mut Results) {
        let model = &self.system.components[c];
        let component = &mut s.components[c];
        let others =
            (0..model.tasks.len()).any(|task| task != t && model.tasks[task].period.is_none());
        let task = &mut component.tasks[t];
        let event = std::mem::take(&mut task.event);
        let paused = task.slots.iter().flatten().any(|slot| slot.paused);
        let goes_on = paused && self.system.semantics.pause == PauseRule::Turns;
        task.runnable |= (event || goes_on) && model.tasks[t].period.is_none();
        let failed = task.failed;
        task.wake = event && others;
        component.signal |= std::mem::take(&mut task.ended);
        task.phase = Phase::Between;
        let mut running = task.slots.iter().flatten();
        let continues =
            running.any(|slot| matches!(slot.status, Status::Run | Status::Stop) && !slot.paused);
        // After its first pass, a task lets the next one begin, unless its permanent activity has failed in
        // this pass.
        match component.tasks.get(t + 1) {
            _ if failed => {}
            Some(next) if next.first == First::NotStarted => self.start(s, c, t + 1),
            None if component.control == Control::Starting => component.control = Control::Ready,
            _ => {}
        }
        if !continues {
            self.end_cycle(s, c, t, out);
        }
    }

    /// Starts a task. With a timer of its own, the task begins at once.
    pub(super) fn start(&self, s: &mut State, c: usize, t: usize) {
        let model = &self.system.components[c].tasks[t];
        let task = &mut s.components[c].tasks[t];
        task.first = First::Started;
        if let (TickRule::Task, Some(period)) = (self.system.semantics.ticks, model.period) {
            task.timer = Some(period + model.delay);
            task.flag = Some(Since::default());
        }
    }

    fn end_cycle(&self, s: &mut State, c: usize, t: usize, out: &mut Results) {
        let task = &mut s.components[c].tasks[t];
        task.phase = Phase::Idle;
        task.on_core &= task.wake;
        let job = task.job.take();
        if task.first == First::InCycle {
            task.first = First::Over;
            // A tick kept from start-up counts from here.
            task.flag.iter_mut().for_each(|tick| tick.measured = 0);
        } else if let Some(job) = job {
            out.took(c, t, job.measured);
        }
    }

    /// Lets one unit of time pass.
    pub(super) fn pass(&self, s: &State) -> State {
        let mut n = s.clone();
        let edf = self.system.policy == Policy::Edf && self.cores.is_some();
        let older = |tick: &mut Since| {
            tick.measured = (tick.measured + 1).min(CAP);
            tick.tick = (tick.tick + u32::from(edf)).min(CAP);
        };
        for c in 0..n.components.len() {
            for who in s.everybody(c) {
                let on_core = self.has_core(s, c, who);
                if let (Some(Doing::Executing(elapsed)), true) = (n.doing(c, who), on_core) {
                    n.set_doing(c, who, Doing::Executing(elapsed + 1));
                }
            }
            for task in &mut n.components[c].tasks {
                task.timer = task.timer.map(|timer| timer - 1);
                task.flag.iter_mut().for_each(older);
                task.job.iter_mut().for_each(older);
            }
        }
        for k in 0..n.clients.len() {
            if n.delay(self.system, k).is_some() {
                n.clients[k].clock += 1;
            }
        }
        for obligation in &mut n.obligations {
            let older = |(stage, age)| (stage, u32::min(age + 1, CAP));
            *obligation = std::mem::take(obligation).into_iter().map(older).collect();
        }
        for (memory, pattern) in n.patterns.iter_mut().zip(self.patterns) {
            memory.pass(pattern);
        }
        n
    }

    /// Returns true if no event can follow a state in which time passes.
    pub(super) fn dead(&self, s: &State) -> bool {
        let timers = s.components.iter().flat_map(|component| &component.tasks);
        let executing = |c: usize| {
            let mut doing = s.everybody(c).filter_map(move |thread| s.doing(c, thread));
            doing.any(|doing| matches!(doing, Doing::Executing(_)))
        };
        timers.into_iter().all(|timer| timer.timer.is_none())
            && !(0..s.components.len()).any(executing)
            && !(0..s.clients.len()).any(|k| s.delay(self.system, k).is_some())
    }

    /// Takes a request.
    fn request(&self, s: &mut State, k: usize, next: usize, out: &mut Results) {
        let client = &self.system.clients[k];
        let at = s.clients[k].at.unwrap_or(client.end());
        let Action::Send(c, service) = client.nodes[at].action else {
            unreachable!("not at a request");
        };
        let client = &mut s.clients[k];
        (client.at, client.clock, client.outstanding) = (Some(next), 0, true);
        self.accept(s, (k, at), (c, service), out);
    }
}

/// Ends an automaton; the control task frees its slot, also that of a permanent activity.
fn end_instance(slot: &mut Option<Instance>, succeeded: bool) {
    if let Some(slot) = slot {
        slot.status = Status::Ended(succeeded);
        (slot.at, slot.paused, slot.mark) = (0, false, false);
    }
}

impl Who {
    /// Returns the task; `None` for the control task.
    pub(super) fn task(self) -> Option<usize> {
        match self {
            Who::Task(t) => Some(t),
            Who::Control => None,
        }
    }
}
