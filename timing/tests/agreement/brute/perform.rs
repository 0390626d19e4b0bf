//! The effects of actions: clients, tasks and their automata.

use dotgen_timing::explore::Action;
use dotgen_timing::scn::semantics::LockRule;
use dotgen_timing::system::{
    AutomatonId, ClientAction, ClientId, ComponentId, Policy, TaskId, Yield,
};

use super::state::{Doing, Mode, State, Status, Step, Tracked};
use super::{Brute, Results};

impl Brute<'_> {
    pub(super) fn perform(&self, s: &State, action: Action, results: &mut Results) -> State {
        let mut n = s.clone();
        match action {
            Action::Proceed { client, next } => {
                n.clients[client].at = Some(next);
                n.clients[client].clock = 0;
            }
            Action::Release { task } => {
                n.tasks[task].tick = false;
                n.tasks[task].age = 0;
                if self.system.needs_core(TaskId::from(task)) {
                    n.tasks[task].status = Status::Waiting;
                    n.queue.push(task);
                    if self.system.platform.policy == Policy::Any {
                        n.queue.sort_unstable();
                    }
                } else {
                    n.tasks[task].status = Status::Running;
                    self.turns(&mut n, task, 0);
                }
            }
            Action::Grant { task } => {
                n.queue.retain(|&queue| queue != task);
                n.tasks[task].status = Status::Running;
                self.turns(&mut n, task, 0);
            }
            Action::Tick { task } => {
                n.tasks[task].timer = Some(self.system.tasks[TaskId::from(task)].delay);
                n.tasks[task].tick = true;
            }
            Action::Acquire { executor } => {
                n.lock_queue.retain(|&lock_queue| lock_queue != executor);
                if executor < n.automata.len() {
                    n.automata[AutomatonId::from(executor)].doing = Doing::Executing(0);
                } else {
                    let na = n.automata.len();
                    n.controls[ComponentId::from(executor - na)].doing = Doing::Executing(0);
                }
            }
            Action::Finish { executor, outcome } => {
                let (na, nc) = (n.automata.len(), n.controls.len());
                if executor < na {
                    self.end_state(&mut n, executor.into(), outcome);
                } else if executor < na + nc {
                    self.end_control(&mut n, (executor - na).into(), outcome, results);
                } else {
                    let client = &mut n.clients[ClientId::from(executor - na - nc)];
                    client.at = Some(outcome);
                    client.clock = 0;
                }
            }
            Action::Signal { component } => {
                n.controls[component].signal = false;
                self.finish(&mut n, component);
            }
            Action::Request { client, next } => {
                let at = n.clients[client].at.unwrap();
                let ClientAction::Send { service, ref trackers, .. } =
                    self.system.clients[client].steps[at].action
                else {
                    panic!("not at a request");
                };
                n.clients[client].outstanding = true;
                for &t in trackers {
                    n.clients[client].tracked[t] = Tracked::Handled;
                }
                n.clients[client].at = Some(next);
                n.clients[client].clock = 0;
                let c = self.system.services[service].component;
                if self.system.services[service].validate.is_some() {
                    n.controls[c].step = Step::Validate(service, client);
                    self.control_codel(&mut n, c);
                } else {
                    self.accepted(&mut n, c, service, client, results);
                }
            }
            // Actions of other rules.
            _ => unreachable!("{action:?}"),
        }
        self.watch(Some(s), &mut n);
        n
    }

    pub(super) fn start_from(&self, s: &mut State, c: ComponentId, first: usize) {
        let tasks = &self.system.components[c].tasks;
        for (i, &t) in tasks.iter().enumerate().skip(first) {
            if self.system.tasks[t].period.is_some() {
                s.tasks[usize::from(t)].timer = Some(0);
            }
            if let Some(a) = self.system.tasks[t].permanent {
                s.automata[a].mode = Mode::FirstCodel;
                s.controls[c].step = Step::Starting(i);
                self.enter(s, a, self.system.machine_of(a).start);
                return;
            }
            s.controls[c].step = Step::Starting(i);
        }
        s.controls[c].step = Step::Ready;
    }

    fn turns(&self, s: &mut State, t: usize, first: usize) {
        for (position, a) in self.order(t).into_iter().enumerate().skip(first) {
            if !self.can_run(s, a) {
                continue;
            }
            let mut state = s.automata[a].at;
            if s.automata[a].mode == Mode::Stop && !s.automata[a].stopping {
                if let Some(stop) = self.system.machine_of(a).stop {
                    state = stop;
                } else {
                    self.to_ether(s, a);
                    continue;
                }
                s.automata[a].stopping = true;
            }
            s.tasks[t].turn = position;
            s.automata[a].visits.fill(0);
            self.enter(s, a, state);
            if !s.automata[a].separate {
                return;
            }
        }
        let task = &mut s.tasks[t];
        task.turn = 0;
        task.status = Status::Idle;
        task.age = 0;
        let slots = &self.system.tasks[TaskId::from(t)].slots;
        if slots.iter().any(|&a| s.automata[a].mode == Mode::Ether) {
            s.controls[self.system.tasks[TaskId::from(t)].component].signal = true;
        }
    }

    fn enter(&self, s: &mut State, a: AutomatonId, state: usize) {
        let entry = &self.system.machine_of(a).states[state];
        let in_cycle = !matches!(s.automata[a].mode, Mode::FirstCodel | Mode::FirstRun);
        let automaton = &mut s.automata[a];
        automaton.at = state;
        if self.system.machine_of(a).loop_limit.is_some() {
            automaton.visits[state] += 1;
        }
        automaton.separate = entry.is_async && self.system.platform.async_free && in_cycle;
        if self.system.codels[entry.codel].conflicts.is_empty() {
            automaton.doing = Doing::Executing(0);
        } else {
            automaton.doing = Doing::Locking;
            if self.system.platform.semantics.locks == LockRule::Fifo {
                s.lock_queue.push(a.into());
            }
        }
    }

    fn end_state(&self, s: &mut State, a: AutomatonId, outcome: usize) {
        let t = self.system.automata[a].task;
        let c = self.system.tasks[t].component;
        let machine = self.system.machine_of(a);
        let chosen = machine.states[s.automata[a].at].yields[outcome];
        let mode = s.automata[a].mode;
        let separate = s.automata[a].separate;
        s.automata[a].doing = Doing::Nothing;
        s.automata[a].separate = false;
        let first_run = matches!(mode, Mode::FirstCodel | Mode::FirstRun);
        let mut turn_ends = true;
        let aperiodic = self.system.tasks[t].period.is_none();
        match chosen {
            Yield::Next(to) if mode == Mode::FirstCodel && aperiodic => {
                s.automata[a].at = to;
                s.automata[a].visits.fill(0);
                s.automata[a].mode = Mode::Normal;
            }
            Yield::Next(to) if !separate => {
                if let (true, Some(limit)) = (machine.rounds, machine.loop_limit)
                    && s.automata[a].visits[to] >= limit
                {
                    s.automata[a].visits.fill(0);
                }
                if mode == Mode::FirstCodel {
                    s.automata[a].mode = Mode::FirstRun;
                }
                self.enter(s, a, to);
                turn_ends = s.automata[a].separate;
            }
            Yield::Next(to) | Yield::Pause(to) => {
                s.automata[a].at = to;
                s.automata[a].visits.fill(0);
                if first_run {
                    s.automata[a].mode = Mode::Normal;
                }
            }
            Yield::End => {
                if matches!(mode, Mode::Run | Mode::Stop) {
                    self.to_ether(s, a);
                    if separate {
                        s.controls[c].signal = true;
                    }
                } else {
                    s.automata[a].visits.fill(0);
                    s.automata[a].at = 0;
                    s.automata[a].mode = Mode::Ended;
                }
            }
        }
        if mode == Mode::FirstCodel {
            let Step::Starting(i) = s.controls[c].step else { panic!("not starting") };
            self.start_from(s, c, i + 1);
        }
        if turn_ends && !first_run && !separate {
            let next = s.tasks[usize::from(t)].turn + 1;
            self.turns(s, usize::from(t), next);
        }
    }

    pub(super) fn to_ether(&self, s: &mut State, a: AutomatonId) {
        self.to_void(s, a);
        s.automata[a].mode = Mode::Ether;
    }

    pub(super) fn to_void(&self, s: &mut State, a: AutomatonId) {
        let automaton = &mut s.automata[a];
        automaton.mode = Mode::Void;
        automaton.stopping = false;
        automaton.at = self.system.machine_of(a).start;
        automaton.visits.fill(0);
    }
}
