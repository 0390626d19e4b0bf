//! The rules of the generated servers (section 21 of the timed semantics).
//!
//! Every *atomic step* of that section is one action: a tick for one task; the beginning of a pass up to its
//! first codel; taking a ticket; leaving the queue; the end of a codel; waking the other tasks; taking a
//! request; the end of a control codel; the rest of the handling. Between them any other action may happen.
//! Executors are the threads: tasks, control tasks, and clients, in this order. Ranks are those of the
//! published rules: clients that proceed, tasks that ask for a core, granting cores, and all other actions.
//!
//! Single points of the semantics can follow the published models. A comment marks each place where they
//! differ.

mod control_task;
mod cores;
mod describe;
mod layout;
mod pass;
mod perform;
mod possible;
mod predicates;
mod reach;
mod shutdown;
mod time;

use std::cell::Cell;

use self::layout::{Layout, control, flag, slot, thread};
use super::{Action, Enabled, Rules};
use crate::explore::rules::Moment;
use crate::explore::rules::Work;
use crate::explore::state::{Clocks, Frame, State, TaskStatus};
use crate::property::Atom;
use crate::scn::semantics::{Semantics, TickRule};
use crate::system::{ClientAction, Codel, Machine, State as MachineState, Ticks, TimedSystem};

/// The rules applied to one system.
#[derive(Debug)]
pub(crate) struct Servers<'s> {
    system: &'s TimedSystem,
    semantics: Semantics,
    layout: Layout,
    /// Priority of every executor that needs a core; the lower number goes first.
    priorities: Vec<u64>,
    /// Services with a request that was rejected for lack of a slot.
    rejected: Vec<Cell<bool>>,
    /// Services of which two waiting instances have interrupted each other.
    restarts: Vec<Cell<bool>>,
}

impl<'s> Servers<'s> {
    /// Creates the rules for a system.
    pub(crate) fn new(system: &'s TimedSystem) -> Self {
        Servers::with(system, &Clocks::none(system.tasks.len()))
    }

    fn with(system: &'s TimedSystem, clocks: &Clocks) -> Self {
        let semantics = system.platform.semantics;
        Servers {
            layout: Layout::new(system, semantics, clocks),
            priorities: system.priorities(),
            rejected: vec![Cell::new(false); system.services.len()],
            restarts: vec![Cell::new(false); system.services.len()],
            semantics,
            system,
        }
    }

    /// Returns the component of an executor; `None` for clients.
    fn component_of(&self, executor: usize) -> Option<usize> {
        if executor < self.layout.tasks {
            Some(self.system.tasks[executor].component)
        } else {
            let component = executor - self.layout.tasks;
            (component < self.layout.components).then_some(component)
        }
    }

    fn is_periodic(&self, task: usize) -> bool {
        self.system.tasks[task].period.is_some()
    }

    /// Returns the machine of a slot; `None` for a permanent activity without codels.
    fn machine(&self, s: &State, slot: usize) -> Option<&'s Machine> {
        let automaton = self.layout.automaton(s, slot).checked_sub(1)?;
        Some(self.system.machine_of(automaton as usize))
    }

    /// Returns the machine state of a slot; `None` if no codel runs there: the default `start` and `stop`.
    fn machine_state(&self, s: &State, slot: usize) -> Option<&'s MachineState> {
        (self.machine(s, slot)?.states).get(self.layout.at(s, slot) as usize)
    }

    /// Returns the service of a slot; `None` for a permanent activity.
    fn service(&self, s: &State, slot: usize) -> Option<usize> {
        let automaton = self.layout.automaton(s, slot).checked_sub(1)?;
        self.system.automata[automaton as usize].service
    }

    /// Returns the codel for which an executor takes a ticket, waits or executes.
    fn codel(&self, s: &State, executor: usize) -> Option<usize> {
        let l = &self.layout;
        if executor < l.tasks {
            let at_codel = thread::TICKET..=thread::EXECUTING;
            if !at_codel.contains(&l.thread_of(s, executor)) {
                return None;
            }
            let state = self.machine_state(s, l.turn(s, executor))?;
            return Some(state.codel);
        }
        let component = executor - l.tasks;
        if component >= l.components {
            return None;
        }
        let at_codel = control::TICKET..=control::EXECUTING;
        if !at_codel.contains(&l.control(s, component)) {
            return None;
        }
        let service = &self.system.services[l.handled(s, component)?];
        let mut codels = service.validate.iter().chain(&service.simple);
        codels.nth(l.codel_number(s, component) as usize).copied()
    }

    /// Returns true if an executor executes a codel that blocks the waiting one.
    fn blocks(&self, s: &State, waiting: &Codel, executor: usize) -> bool {
        (self.codel(s, executor)).is_some_and(|codel| waiting.conflicts.contains(codel))
    }

    /// Returns true if a task has a measured job: after its first cycle.
    fn in_cycle(&self, s: &State, task: usize) -> bool {
        (thread::WAITING..=thread::EXECUTING).contains(&self.layout.thread_of(s, task))
    }

    /// Returns the state at time 0, with the first task of every component started.
    fn at_start(&self) -> State {
        let l = &self.layout;
        let mut s = l.blank();
        for (task, entry) in self.system.tasks.iter().enumerate() {
            l.raise(&mut s, task, flag::FIRST);
            if entry.period.is_none() {
                l.raise(&mut s, task, flag::RUNNABLE);
            } else if self.semantics.ticks == TickRule::Component {
                l.set_timer(&mut s, task, self.first_tick(task));
            }
            let first = l.slots(task).start;
            l.set_mode(&mut s, first, slot::INIT | slot::START | slot::PERMANENT);
            l.set_automaton(&mut s, first, entry.permanent.map_or(0, |a| a as u16 + 1));
        }
        for component in 0..l.components {
            l.set_starting(&mut s, component, u16::MAX);
            self.start_next(&mut s, component);
        }
        for (k, client) in self.system.clients.iter().enumerate() {
            l.set_position(&mut s, k, client.done() as u16 + 1);
        }
        self.list_ready(&mut s);
        s
    }

    /// Returns the time from the start of a clock to the first tick in base units: the delay, or else the
    /// period.
    fn first_tick(&self, task: usize) -> Ticks {
        let task = &self.system.tasks[task];
        match (self.semantics.ticks, task.delay) {
            (TickRule::Component, 0) => task.period.unwrap_or(0),
            (TickRule::Component, delay) => delay,
            (TickRule::Task, delay) => task.period.unwrap_or(0) + delay,
        }
    }

    /// Starts the next task of a component, or the control task after all other tasks.
    fn start_next(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let next = l.starting(s, component).wrapping_add(1);
        l.set_starting(s, component, next);
        let Some(&task) = self.system.components[component].tasks.get(next as usize) else {
            l.set_control(s, component, control::READY);
            return;
        };
        l.set_thread(s, task, thread::IDLE);
        if self.semantics.ticks == TickRule::Task && self.is_periodic(task) {
            // Its timer starts now, and its first pass needs no tick.
            l.set_timer(s, task, self.first_tick(task));
            l.raise(s, task, flag::TICK);
        }
    }
}

impl Rules for Servers<'_> {
    fn with_clocks(&self, clocks: &Clocks) -> Self {
        Servers::with(self.system, clocks)
    }

    fn system(&self) -> &TimedSystem {
        self.system
    }

    fn frame(&self) -> &Frame {
        &self.layout
    }

    fn initial(&self) -> State {
        self.at_start()
    }

    fn enabled(&self, s: &State, out: &mut Enabled) {
        self.list_enabled(s, out);
    }

    fn apply(&self, s: &mut State, action: Action) {
        self.perform(s, action);
        self.list_ready(s);
    }

    fn next_moment(&self, s: &State, can_be_deferred: &dyn Fn(usize) -> bool) -> Option<Ticks> {
        self.until_next(s, can_be_deferred)
    }

    fn elapse(&self, s: &mut State, time: Ticks) {
        self.pass_time(s, time);
    }

    fn progresses(&self, s: &State, executor: usize) -> bool {
        !self.preempts() || self.executes_on(s, self.running(s), executor)
    }

    fn job(&self, s: &State, task: usize) -> TaskStatus {
        let l = &self.layout;
        if l.has(s, task, flag::FIRST) {
            return TaskStatus::Idle;
        }
        match l.thread_of(s, task) {
            thread::WAITING => TaskStatus::Waiting,
            thread::AGAIN..=thread::EXECUTING => TaskStatus::Running,
            _ if self.waits_to_begin(s, task) => TaskStatus::Waiting,
            // A job begins with its tick.
            thread::IDLE if l.has(s, task, flag::TICK) => TaskStatus::Running,
            _ => TaskStatus::Idle,
        }
    }

    fn awaits_start_up(&self, s: &State, task: usize) -> Option<usize> {
        let l = &self.layout;
        let component = self.system.tasks[task].component;
        let tasks = &self.system.components[component].tasks;
        let before = tasks.get(l.starting(s, component) as usize);
        let first = l.has(s, task, flag::FIRST).then_some(task);
        before.copied().filter(|&index| index < task).or(first)
    }

    fn missed(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        let in_cycle = self.in_cycle(s, task) && l.has(s, task, flag::TICK);
        self.is_periodic(task)
            && (in_cycle || l.has(s, task, flag::LATE))
            && !l.has(s, task, flag::FIRST)
    }

    fn may_begin_to_wait(&self, action: Action, task: usize) -> bool {
        // Under preemption any thread that becomes ready may take a core.
        self.preempts() || action == Action::Release { task }
    }

    fn atom(&self, s: &State, atom: &Atom) -> bool {
        self.holds(s, atom)
    }

    fn has_refused(&self, service: usize) -> bool {
        self.rejected[service].get()
    }

    fn has_ended_restarts(&self, service: usize) -> bool {
        self.restarts[service].get()
    }

    fn task_of(&self, action: Action) -> Option<usize> {
        let of_executor = |executor: usize| (executor < self.layout.tasks).then_some(executor);
        match action {
            Action::Release { task }
            | Action::Grant { task }
            | Action::Tick { task }
            | Action::Begin { task }
            | Action::Wake { task } => Some(task),
            Action::Ticket { executor }
            | Action::Acquire { executor }
            | Action::Ready { executor }
            | Action::Finish { executor, .. } => of_executor(executor),
            Action::Preempt { by, .. } => of_executor(by),
            Action::Signal { .. }
            | Action::Request { .. }
            | Action::Reply { .. }
            | Action::Shut { .. }
            | Action::Mark { .. }
            | Action::Proceed { .. } => None,
        }
    }

    fn duration(&self, s: &State, executor: usize) -> (Ticks, Ticks) {
        if let Some(codel) = self.codel(s, executor) {
            let codel = &self.system.codels[codel];
            return (codel.lower, codel.upper);
        }
        let l = &self.layout;
        let Some(client) = executor.checked_sub(l.tasks + l.components) else {
            return (0, 0);
        };
        let steps = &self.system.clients[client].steps;
        let step = steps.get(l.position(s, client) as usize);
        match step.map(|step| &step.action) {
            Some(&ClientAction::Delay(lower, upper)) => (lower, upper),
            _ => (0, 0),
        }
    }

    fn work(&self, s: &State, executor: usize) -> Option<Work> {
        let l = &self.layout;
        if let Some(client) = executor.checked_sub(l.tasks + l.components) {
            let waits = l.is_executing(s, executor);
            return waits.then_some(Work::Delay { client });
        }
        let codel = self.codel(s, executor)?;
        if executor >= l.tasks {
            let component = executor - l.tasks;
            return Some(Work::Control {
                codel,
                service: l.handled(s, component)?,
                number: l.codel_number(s, component) as usize,
            });
        }
        let slot = l.turn(s, executor);
        let automaton = (l.automaton(s, slot) as usize).checked_sub(1)?;
        Some(Work::State {
            codel,
            task: executor,
            automaton,
            state: l.at(s, slot) as usize,
            slot,
        })
    }

    fn position(&self, s: &State, client: usize) -> usize {
        self.layout.position(s, client) as usize
    }

    fn places(&self) -> usize {
        self.layout.first_slot.last().copied().unwrap_or(0)
    }

    fn activity(&self, s: &State, place: usize) -> Option<usize> {
        let l = &self.layout;
        match l.status(s, place) {
            layout::slot::VOID => None,
            _ => (l.automaton(s, place) as usize).checked_sub(1),
        }
    }

    fn interrupt_activity(&self, s: &mut State, place: usize) {
        let l = &self.layout;
        if let Some(task) = (0..l.tasks).find(|&task| l.slots(task).contains(&place)) {
            self.mark(s, task, place);
        }
    }

    fn handling(&self, s: &State, component: usize) -> Option<(usize, bool)> {
        let l = &self.layout;
        let service = l.handled(s, component)?;
        Some((service, l.refused(s, component) != 0))
    }

    fn requested_place(&self, s: &State, component: usize) -> Option<usize> {
        (self.layout.given(s, component) as usize).checked_sub(1)
    }

    fn tell(
        &self,
        change: (&State, &State),
        action: Option<Action>,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        self.moments(change, action, time, out);
    }
}
