//! The rules: which actions a state allows, what each does, and how time passes.
//!
//! One function per rule of sections 3 to 9. Actions come in four ranks, and only those of the
//! best rank present may happen: clients moving on (part of the step that lets them), tasks asking
//! for a core, granting cores, and everything else. Within a rank any order is possible.

use std::cell::Cell;

use super::state::{Layout, State, TaskStatus, control, mode, phase, slot, tracker};
use crate::system::{ClientAction, FOREVER, LockOrder, Policy, Ticks, TimedSystem, Yield};

/// Something that happens without taking time. Executors are numbered: automata, then the control
/// tasks of components, then clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    /// What a client waited for has happened; it goes on.
    Proceed {
        /// The client.
        client: usize,
        /// Its next step.
        next: usize,
    },
    /// A task is released: takes its tick and asks for a core.
    Release {
        /// The task.
        task: usize,
    },
    /// A waiting task gets a core.
    Grant {
        /// The task.
        task: usize,
    },
    /// A timer wraps.
    Tick {
        /// The task.
        task: usize,
    },
    /// A codel takes its locks.
    Acquire {
        /// What executes it.
        executor: usize,
    },
    /// A codel or a delay ends.
    Finish {
        /// What executed it.
        executor: usize,
        /// For automata the index of the yield; for control tasks 0 is "accepted" (or done), 1
        /// "refused"; for clients the step after the delay.
        outcome: usize,
    },
    /// The control task handles the end of activities.
    Signal {
        /// Its component.
        component: usize,
    },
    /// The control task takes a client's request.
    Request {
        /// The client.
        client: usize,
        /// The client's next step.
        next: usize,
    },
}

/// The actions of a state.
#[derive(Debug, Default)]
pub(crate) struct Enabled {
    /// All of the best rank.
    pub(crate) actions: Vec<Action>,
    /// At least one of them must happen before time passes, whatever the windows.
    pub(crate) urgent: bool,
    /// They are of a rank before the last: part of the step that made them possible.
    pub(crate) committed: bool,
    /// Some executing codel has come to the end of its window.
    pub(crate) forced: bool,
}

/// The rules applied to one system.
#[derive(Debug)]
pub(crate) struct Stepper<'s> {
    pub(crate) system: &'s TimedSystem,
    pub(crate) layout: Layout,
    /// Services of which a request was refused for want of a slot.
    pub(crate) refused: Vec<Cell<bool>>,
    /// Codels (by number) that exclude no other.
    lockless: Vec<bool>,
    /// Automata of each machine.
    pub(crate) automata_of: Vec<Vec<usize>>,
}

impl<'s> Stepper<'s> {
    pub(crate) fn new(system: &'s TimedSystem, layout: Layout) -> Self {
        let mut automata_of = vec![Vec::new(); system.machines.len()];
        for (a, it) in system.automata.iter().enumerate() {
            automata_of[it.machine].push(a);
        }
        Stepper {
            automata_of,
            system,
            layout,
            refused: vec![Cell::new(false); system.services.len()],
            lockless: system
                .codels
                .iter()
                .map(|it| it.conflicts.is_empty())
                .collect(),
        }
    }

    /// The state at time 0, with the first task of every component started.
    pub(crate) fn initial(&self) -> State {
        let l = &self.layout;
        let mut s = l.blank();
        for (c, component) in self.system.components.iter().enumerate() {
            l.set_starting(&mut s, c, 0);
            for service in &component.services {
                for &a in &self.system.services[*service].slots {
                    self.reset_slot(&mut s, a);
                }
            }
            self.start_tasks(&mut s, c);
        }
        for (k, client) in self.system.clients.iter().enumerate() {
            // One past the end: the position before the first step.
            l.set_position(&mut s, k, client.done() as u16 + 1);
        }
        s
    }

    // ---- What is possible ------------------------------------------------------------------

    /// Lists the actions of a state.
    pub(crate) fn enabled(&self, s: &State, out: &mut Enabled) {
        out.actions.clear();
        out.urgent = true;
        out.committed = true;
        out.forced = false;
        self.proceeding_clients(s, &mut out.actions);
        if !out.actions.is_empty() {
            return;
        }
        for task in 0..self.layout.tasks {
            if self.asks_for_core(s, task) {
                out.actions.push(Action::Release { task });
            }
        }
        if !out.actions.is_empty() {
            return;
        }
        self.decisions(s, &mut out.actions);
        if !out.actions.is_empty() {
            return;
        }
        out.committed = false;
        self.ordinary(s, out);
    }

    fn proceeding_clients(&self, s: &State, out: &mut Vec<Action>) {
        let l = &self.layout;
        for (k, client) in self.system.clients.iter().enumerate() {
            let position = l.position(s, k) as usize;
            let next = if position > client.done() {
                &client.first
            } else if position == client.done() {
                continue;
            } else {
                let step = &client.steps[position];
                let satisfied = match &step.action {
                    ClientAction::AwaitAccepted => l.outstanding(s, k) == 0,
                    &ClientAction::AwaitEnded(t) => l.tracker(s, k, t) == tracker::NONE,
                    ClientAction::Send { .. } | ClientAction::Delay(..) => false,
                };
                if !satisfied {
                    continue;
                }
                &step.next
            };
            out.extend(next.iter().map(|&next| Action::Proceed { client: k, next }));
        }
    }

    /// Whether a task is to be released now (section 4, with the rule for idle ticks).
    fn asks_for_core(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        if l.status(s, task) != TaskStatus::Idle {
            return false;
        }
        let it = &self.system.tasks[task];
        if it.period.is_some() {
            l.pending(s, task) && (!it.keep_idle_tick || self.next_turn(s, task, 0).is_some())
        } else {
            self.next_turn(s, task, 0).is_some()
        }
    }

    fn decisions(&self, s: &State, out: &mut Vec<Action>) {
        let queue = self.layout.queue(s);
        if queue.is_empty() || !self.core_free(s) {
            return;
        }
        match self.system.platform.policy {
            Policy::Fifo | Policy::Edf => out.push(Action::Grant {
                task: queue[0] as usize,
            }),
            Policy::Any => {
                out.extend(queue.iter().map(|&task| Action::Grant {
                    task: task as usize,
                }));
            }
        }
    }

    fn core_free(&self, s: &State) -> bool {
        let Some(cores) = self.system.platform.cores else {
            return true;
        };
        let busy = (0..self.layout.tasks)
            .filter(|&t| {
                self.layout.status(s, t) == TaskStatus::Running && self.system.needs_core(t)
            })
            .count();
        busy < cores as usize
    }

    fn ordinary(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        let mut urgent = false;
        for (task, it) in self.system.tasks.iter().enumerate() {
            if let Some(period) = it.period
                && l.started(s, task)
                && l.timer(s, task) == period + it.delay
            {
                out.actions.push(Action::Tick { task });
                urgent = true;
            }
        }
        for (executor, &phase) in l.phases(s).iter().enumerate() {
            match phase & !phase::ASYNC {
                phase::LOCKING if self.can_acquire(s, executor) => {
                    out.actions.push(Action::Acquire { executor });
                    urgent = true;
                }
                phase::EXECUTING => {
                    let (a, b) = l.window(s, executor);
                    if a == 0 {
                        self.outcomes(s, executor, &mut out.actions);
                        out.forced |= b == 0;
                    }
                }
                _ => {}
            }
        }
        for component in 0..l.components {
            if l.control(s, component) == control::READY && l.signal(s, component) != 0 {
                out.actions.push(Action::Signal { component });
                urgent = true;
            }
        }
        for (k, client) in self.system.clients.iter().enumerate() {
            let Some(step) = client.steps.get(l.position(s, k) as usize) else {
                continue;
            };
            let ClientAction::Send { service, .. } = step.action else {
                continue;
            };
            let component = self.system.services[service].component;
            if l.outstanding(s, k) == 0
                && l.control(s, component) == control::READY
                && l.signal(s, component) == 0
            {
                out.actions.extend(
                    step.next
                        .iter()
                        .map(|&next| Action::Request { client: k, next }),
                );
                urgent = true;
            }
        }
        out.urgent = urgent;
    }

    /// The ways in which an executing codel may end.
    fn outcomes(&self, s: &State, executor: usize, out: &mut Vec<Action>) {
        let l = &self.layout;
        let mut push = |outcome| out.push(Action::Finish { executor, outcome });
        if executor < l.automata {
            let machine = self.system.machine_of(executor);
            let yields = &machine.states[l.at(s, executor) as usize].yields;
            let mut any = false;
            for (outcome, it) in yields.iter().enumerate() {
                if self.within_limit(s, executor, it) {
                    push(outcome);
                    any = true;
                }
            }
            if !any && machine.rounds {
                for (outcome, it) in yields.iter().enumerate() {
                    if *it != Yield::Next(l.at(s, executor) as usize) {
                        push(outcome);
                    }
                }
            }
        } else if executor < l.automata + l.components {
            push(0);
            if l.control(s, executor - l.automata) == control::VALIDATE {
                push(1);
            }
        } else {
            let client = executor - l.automata - l.components;
            let step = &self.system.clients[client].steps[l.position(s, client) as usize];
            for &next in &step.next {
                push(next);
            }
        }
    }

    fn within_limit(&self, s: &State, automaton: usize, it: &Yield) -> bool {
        match (
            it,
            self.layout.visits[automaton],
            self.system.machine_of(automaton).loop_limit,
        ) {
            (&Yield::Next(state), Some(base), Some(limit)) => s.d[base + state] < limit,
            _ => true,
        }
    }

    /// The codel an executor is at; `None` for clients.
    pub(crate) fn codel(&self, s: &State, executor: usize) -> Option<usize> {
        let l = &self.layout;
        if executor < l.automata {
            let machine = self.system.machine_of(executor);
            Some(machine.states[l.at(s, executor) as usize].codel)
        } else if executor < l.automata + l.components {
            let component = executor - l.automata;
            let service = &self.system.services[l.handled(s, component) as usize];
            if l.control(s, component) == control::VALIDATE {
                service.validate
            } else {
                service.simple.get(l.simple(s, component) as usize).copied()
            }
        } else {
            None
        }
    }

    /// Whether a codel that waits for its locks can take them.
    pub(crate) fn can_acquire(&self, s: &State, executor: usize) -> bool {
        let Some(codel) = self.codel(s, executor) else {
            return false;
        };
        let conflicts = &self.system.codels[codel].conflicts;
        let l = &self.layout;
        for other in l.executing(s) {
            if other != executor
                && self
                    .codel(s, other)
                    .is_some_and(|it| conflicts.contains(it))
            {
                return false;
            }
        }
        if self.system.platform.locks == LockOrder::Fifo {
            for &other in l.lock_queue(s) {
                if other as usize == executor {
                    break;
                }
                if self
                    .codel(s, other as usize)
                    .is_some_and(|it| conflicts.contains(it))
                {
                    return false;
                }
            }
        }
        true
    }

    // ---- What actions do -------------------------------------------------------------------

    /// Performs an action that is enabled.
    pub(crate) fn apply(&self, s: &mut State, action: Action) {
        let l = &self.layout;
        match action {
            Action::Proceed { client, next } => self.client_to(s, client, next),
            Action::Release { task } => self.release(s, task),
            Action::Grant { task } => {
                let at = l.queue(s).iter().position(|&it| it as usize == task);
                l.queue_remove(s, at.expect("a granted task waits"));
                l.set_slack(s, task, 0);
                self.run(s, task);
            }
            Action::Tick { task } => {
                l.set_timer(s, task, self.system.tasks[task].delay);
                l.set_pending(s, task, true);
            }
            Action::Acquire { executor } => {
                l.lock_queue_remove(s, executor);
                self.execute(s, executor);
            }
            Action::Finish { executor, outcome } => {
                l.set_window(s, executor, (0, 0));
                if executor < l.automata {
                    self.finish_state(s, executor, outcome);
                } else if executor < l.automata + l.components {
                    self.finish_control(s, executor - l.automata, outcome);
                } else {
                    self.client_to(s, executor - l.automata - l.components, outcome);
                }
            }
            Action::Signal { component } => {
                l.set_signal(s, component, 0);
                self.finish_message(s, component);
            }
            Action::Request { client, next } => self.request(s, client, next),
        }
    }

    fn client_to(&self, s: &mut State, client: usize, position: usize) {
        let l = &self.layout;
        let executor = l.client_executor(client);
        l.set_position(s, client, position as u16);
        l.set_phase(s, executor, phase::REST);
        if let Some(step) = self.system.clients[client].steps.get(position)
            && let ClientAction::Delay(lower, upper) = step.action
        {
            l.set_phase(s, executor, phase::EXECUTING);
            l.set_window(s, executor, (lower, upper));
        }
    }

    /// Starts tasks of a component from the one in `starting` on, up to one that has to run its
    /// first codel (section 3).
    fn start_tasks(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let tasks = &self.system.components[component].tasks;
        let mut at = l.starting(s, component) as usize;
        while let Some(&task) = tasks.get(at) {
            l.set_starting(s, component, at as u16);
            l.set_started(s, task);
            l.set_timer(s, task, 0);
            if let Some(a) = self.system.tasks[task].permanent {
                l.set_mode(s, a, mode::FIRST_CODEL);
                self.begin_turn_at(s, a, self.system.machine_of(a).start);
                return;
            }
            at += 1;
        }
        l.set_starting(s, component, 0);
        l.set_control(s, component, control::READY);
    }

    fn release(&self, s: &mut State, task: usize) {
        let l = &self.layout;
        l.set_pending(s, task, false);
        if !self.system.needs_core(task) {
            self.run(s, task);
            return;
        }
        l.set_status(s, task, TaskStatus::Waiting);
        let deadline = self.system.tasks[task].period.unwrap_or(FOREVER);
        let position = if l.has_slack() {
            l.queue(s)
                .iter()
                .position(|&it| l.slack(s, it as usize) > deadline)
        } else {
            None
        };
        let position = match (position, self.system.platform.policy) {
            (Some(position), _) => position,
            // Any of them may be chosen: their order means nothing.
            (None, Policy::Any) => l.queue(s).partition_point(|&it| (it as usize) < task),
            (None, _) => l.queue(s).len(),
        };
        l.queue_insert(s, position, task as u16);
        l.set_slack(s, task, deadline);
    }

    /// A task has its core (or needs none) and gives the first turn.
    fn run(&self, s: &mut State, task: usize) {
        self.layout.set_status(s, task, TaskStatus::Running);
        self.give_turn(s, task, 0);
    }

    /// The first position at or after `from` whose automaton has something to do.
    fn next_turn(&self, s: &State, task: usize, from: usize) -> Option<usize> {
        let l = &self.layout;
        let it = &self.system.tasks[task];
        if from == 0
            && let Some(a) = it.permanent
            && l.mode(s, a) == mode::NORMAL
            && l.phase(s, a) == phase::REST
        {
            return Some(0);
        }
        (from.max(1)..=it.slots.len()).find(|&position| {
            let a = it.slots[position - 1];
            matches!(l.mode(s, a), slot::RUN | slot::STOP | slot::STOPPING)
                && l.phase(s, a) == phase::REST
        })
    }

    /// Gives turns from a position on, until an automaton executes or the cycle ends.
    fn give_turn(&self, s: &mut State, task: usize, mut from: usize) {
        let l = &self.layout;
        let it = &self.system.tasks[task];
        while let Some(position) = self.next_turn(s, task, from) {
            from = position + 1;
            let a = match position {
                0 => it.permanent.expect("position 0 is the permanent activity"),
                _ => it.slots[position - 1],
            };
            let mut state = l.at(s, a) as usize;
            if position > 0 && l.mode(s, a) == slot::STOP {
                let Some(stop) = self.system.machine_of(a).stop else {
                    self.end_slot(s, a);
                    continue;
                };
                l.set_mode(s, a, slot::STOPPING);
                state = stop;
            }
            l.set_turn(s, task, 1 + position as u16);
            self.begin_turn_at(s, a, state);
            if l.phase(s, a) & phase::ASYNC == 0 {
                return;
            }
        }
        // End of the cycle.
        l.set_turn(s, task, 0);
        l.set_status(s, task, TaskStatus::Idle);
        if it.slots.iter().any(|&a| l.mode(s, a) == slot::ETHER) {
            l.set_signal(s, it.component, 1);
        }
        if let Some(clock) = l.response[task] {
            s.t[clock] = 0;
        }
    }

    fn begin_turn_at(&self, s: &mut State, automaton: usize, state: usize) {
        self.clear_visits(s, automaton);
        self.enter(s, automaton, state);
    }

    fn clear_visits(&self, s: &mut State, automaton: usize) {
        if let Some(base) = self.layout.visits[automaton] {
            let states = self.system.machine_of(automaton).states.len();
            s.d[base..base + states].fill(0);
        }
    }

    /// Enters a codel state: waits for locks if its codel excludes any other.
    fn enter(&self, s: &mut State, automaton: usize, state: usize) {
        let l = &self.layout;
        if let Some(base) = l.visits[automaton] {
            s.d[base + state] += 1;
        }
        l.set_at(s, automaton, state as u16);
        let it = &self.system.machine_of(automaton).states[state];
        let first_run = self.system.automata[automaton].service.is_none()
            && l.mode(s, automaton) != mode::NORMAL;
        let separate = it.is_async && self.system.platform.async_free && !first_run;
        let flag = if separate { phase::ASYNC } else { 0 };
        l.set_phase(s, automaton, phase::LOCKING | flag);
        if self.lockless[it.codel] {
            self.execute(s, automaton);
        } else {
            l.lock_queue_push(s, automaton);
        }
    }

    /// The codel an executor is at begins.
    fn execute(&self, s: &mut State, executor: usize) {
        let l = &self.layout;
        let codel = self.codel(s, executor).expect("only codels are executed");
        let codel = &self.system.codels[codel];
        l.set_window(s, executor, (codel.lower, codel.upper));
        if executor < l.automata {
            let flag = l.phase(s, executor) & phase::ASYNC;
            l.set_phase(s, executor, phase::EXECUTING | flag);
        } else {
            l.set_phase(s, executor, phase::EXECUTING);
        }
    }

    fn finish_state(&self, s: &mut State, a: usize, outcome: usize) {
        let l = &self.layout;
        let automaton = &self.system.automata[a];
        let machine = self.system.machine_of(a);
        let it = machine.states[l.at(s, a) as usize].yields[outcome];
        let permanent = automaton.service.is_none();
        let first_codel = permanent && l.mode(s, a) == mode::FIRST_CODEL;
        let first_run = permanent && l.mode(s, a) != mode::NORMAL;
        let separate = l.phase(s, a) & phase::ASYNC != 0;
        let new_round = machine.rounds && !self.within_limit(s, a, &it);

        l.set_phase(s, a, phase::REST);
        match it {
            // An aperiodic task has a core for all but its start-up codel (section 8): what follows
            // is its first cycle.
            Yield::Next(state)
                if first_codel && self.system.tasks[automaton.task].period.is_none() =>
            {
                self.clear_visits(s, a);
                l.set_at(s, a, state as u16);
                l.set_mode(s, a, mode::NORMAL);
            }
            Yield::Next(state) if !separate => {
                if new_round {
                    self.clear_visits(s, a);
                }
                if first_codel {
                    l.set_mode(s, a, mode::FIRST_RUN);
                }
                self.enter(s, a, state);
            }
            Yield::Next(state) | Yield::Pause(state) => {
                self.clear_visits(s, a);
                l.set_at(s, a, state as u16);
                if first_run {
                    l.set_mode(s, a, mode::NORMAL);
                }
            }
            Yield::End => {
                if permanent {
                    self.clear_visits(s, a);
                    l.set_at(s, a, 0);
                    l.set_mode(s, a, mode::ENDED);
                } else {
                    self.end_slot(s, a);
                    if separate {
                        l.set_signal(s, self.system.tasks[automaton.task].component, 1);
                    }
                }
            }
        }
        if first_codel {
            let component = self.system.tasks[automaton.task].component;
            let next = l.starting(s, component) + 1;
            l.set_starting(s, component, next);
            self.start_tasks(s, component);
        }
        let turn_over =
            l.phase(s, a) == phase::REST || (l.phase(s, a) & phase::ASYNC != 0 && !separate);
        if turn_over && !first_run && !separate {
            let position = l.turn(s, automaton.task) as usize;
            self.give_turn(s, automaton.task, position);
        }
    }

    fn end_slot(&self, s: &mut State, a: usize) {
        self.reset_slot(s, a);
        self.layout.set_mode(s, a, slot::ETHER);
    }

    /// Void, and ready to begin at `start`.
    fn reset_slot(&self, s: &mut State, a: usize) {
        let l = &self.layout;
        self.clear_visits(s, a);
        l.set_mode(s, a, slot::VOID);
        l.set_at(s, a, self.system.machine_of(a).start as u16);
        l.set_phase(s, a, phase::REST);
    }

    // ---- Control task (section 7) ----------------------------------------------------------

    fn request(&self, s: &mut State, client: usize, next: usize) {
        let l = &self.layout;
        let position = l.position(s, client) as usize;
        let ClientAction::Send {
            service,
            ref trackers,
        } = self.system.clients[client].steps[position].action
        else {
            return;
        };
        let component = self.system.services[service].component;
        l.set_outstanding(s, client, 1);
        for &t in trackers {
            l.set_tracker(s, client, t, tracker::HANDLED);
        }
        l.set_requester(s, component, client as u16);
        l.set_handled(s, component, service as u16);
        self.client_to(s, client, next);
        if self.system.services[service].validate.is_some() {
            l.set_control(s, component, control::VALIDATE);
            self.begin_control_codel(s, component);
        } else {
            self.accept(s, component);
        }
    }

    fn begin_control_codel(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let executor = l.control_executor(component);
        l.set_phase(s, executor, phase::LOCKING);
        if self.codel(s, executor).is_some_and(|it| self.lockless[it]) {
            self.execute(s, executor);
        } else {
            l.lock_queue_push(s, executor);
        }
    }

    fn finish_control(&self, s: &mut State, component: usize, outcome: usize) {
        let l = &self.layout;
        l.set_phase(s, l.control_executor(component), phase::REST);
        if l.control(s, component) == control::VALIDATE {
            if outcome == 0 {
                self.accept(s, component)
            } else {
                self.end_of_message(s, component)
            }
            return;
        }
        let service = &self.system.services[l.handled(s, component) as usize];
        let next = l.simple(s, component) + 1;
        if (next as usize) < service.simple.len() {
            l.set_simple(s, component, next);
            self.begin_control_codel(s, component);
        } else {
            self.end_of_message(s, component);
        }
    }

    /// The request being handled has passed validation.
    fn accept(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let number = l.handled(s, component) as usize;
        let service = &self.system.services[number];
        if service.activity {
            match service.slots.iter().find(|&&a| l.mode(s, a) == slot::VOID) {
                Some(&a) => {
                    l.set_mode(s, a, slot::WAIT);
                    let client = l.requester(s, component) as usize;
                    for t in 0..self.system.clients[client].trackers {
                        if l.tracker(s, client, t) == tracker::HANDLED {
                            l.set_tracker(s, client, t, tracker::SLOT + a as u16);
                        }
                    }
                    self.interrupt(s, number, Some(a));
                }
                None => self.refused[number].set(true),
            }
            self.end_of_message(s, component);
            return;
        }
        self.interrupt(s, number, None);
        if service.simple.is_empty() {
            self.end_of_message(s, component);
        } else {
            l.set_control(s, component, control::SIMPLE);
            l.set_simple(s, component, 0);
            self.begin_control_codel(s, component);
        }
    }

    fn interrupt(&self, s: &mut State, service: usize, except: Option<usize>) {
        let l = &self.layout;
        for &interrupted in &self.system.services[service].interrupts {
            for &a in &self.system.services[interrupted].slots {
                if Some(a) == except {
                    continue;
                }
                match l.mode(s, a) {
                    slot::WAIT => self.end_slot(s, a),
                    slot::RUN => l.set_mode(s, a, slot::STOP),
                    _ => {}
                }
            }
        }
    }

    /// The request being handled is accepted or refused; what it is waited for by that name is over
    /// unless it occupies a slot.
    fn end_of_message(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        let client = l.requester(s, component) as usize;
        for t in 0..self.system.clients[client].trackers {
            if l.tracker(s, client, t) == tracker::HANDLED {
                l.set_tracker(s, client, t, tracker::NONE);
            }
        }
        l.set_outstanding(s, client, 0);
        self.finish_message(s, component);
    }

    /// Reports ended activities, lets held ones run, and gets ready for the next message.
    fn finish_message(&self, s: &mut State, component: usize) {
        let l = &self.layout;
        l.set_requester(s, component, 0);
        l.set_handled(s, component, 0);
        l.set_simple(s, component, 0);
        l.set_control(s, component, control::READY);

        let services = &self.system.components[component].services;
        for &service in services {
            for &a in &self.system.services[service].slots {
                if l.mode(s, a) == slot::ETHER {
                    self.reset_slot(s, a);
                    for (k, client) in self.system.clients.iter().enumerate() {
                        for t in 0..client.trackers {
                            if l.tracker(s, k, t) == tracker::SLOT + a as u16 {
                                l.set_tracker(s, k, t, tracker::NONE);
                            }
                        }
                    }
                }
            }
        }
        for &task in &self.system.components[component].tasks {
            for &a in &self.system.tasks[task].slots {
                if l.mode(s, a) != slot::WAIT {
                    continue;
                }
                let service = self.system.automata[a]
                    .service
                    .expect("slots belong to services");
                let held = self.system.services[service]
                    .interrupts
                    .iter()
                    .any(|&other| {
                        let slots = &self.system.services[other].slots;
                        slots.iter().any(|&b| b != a && l.mode(s, b) != slot::VOID)
                    });
                if !held {
                    l.set_mode(s, a, slot::RUN);
                }
            }
        }
    }

    // ---- Time ------------------------------------------------------------------------------

    /// How long nothing needs to be looked at after a state without urgent actions: until the next
    /// moment at which something may happen, or, for executors whose end `can_wait`, has to. `None`:
    /// forever.
    pub(crate) fn next_moment(&self, s: &State, can_wait: &dyn Fn(usize) -> bool) -> Option<Ticks> {
        let l = &self.layout;
        let mut least = FOREVER;
        for (task, it) in self.system.tasks.iter().enumerate() {
            if let Some(period) = it.period
                && l.started(s, task)
            {
                least = least.min(period + it.delay - l.timer(s, task));
            }
        }
        for executor in l.executing(s) {
            let (a, b) = l.window(s, executor);
            least = least.min(if can_wait(executor) { b } else { a.max(1) });
        }
        (least != FOREVER).then_some(least)
    }

    /// Lets time pass, at most [`Stepper::next_moment`].
    pub(crate) fn elapse(&self, s: &mut State, time: Ticks) {
        let l = &self.layout;
        for (task, it) in self.system.tasks.iter().enumerate() {
            if it.period.is_some() && l.started(s, task) {
                l.set_timer(s, task, l.timer(s, task) + time);
            }
            let status = l.status(s, task);
            if l.has_slack() && status == TaskStatus::Waiting && l.slack(s, task) != FOREVER {
                l.set_slack(s, task, l.slack(s, task).saturating_sub(time));
            }
            if let Some(clock) = l.response[task]
                && status != TaskStatus::Idle
            {
                s.t[clock] += time;
            }
        }
        for executor in 0..l.executors() {
            if l.phase(s, executor) & phase::EXECUTING != 0 {
                let (a, b) = l.window(s, executor);
                let b = if b == FOREVER { b } else { b - time };
                l.set_window(s, executor, (a.saturating_sub(time), b));
            }
        }
        for (i, clock) in l.observer_clock.iter().enumerate() {
            if let Some(clock) = *clock
                && l.open(s, i) != 0
            {
                s.t[clock] += time;
            }
        }
    }
}
