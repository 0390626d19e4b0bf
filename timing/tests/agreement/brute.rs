//! An independent interpreter of timed systems, written from the semantics by the obvious method:
//! states are plain structures with a clock per executing codel, time passes unit by unit, every
//! order of simultaneous actions is followed, and nothing is merged.

use std::collections::HashSet;

use dotgen_timing::explore::{Action, Within};
use dotgen_timing::property::{Atom, Predicate, SlotStatus, StatePhase, TaskState};
use dotgen_timing::system::{ClientAction, FOREVER, LockOrder, Policy, TimedSystem, Yield};

/// Ages above this are taken for unbounded.
pub(crate) const CAP: u32 = 150;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Status {
    Idle,
    Waiting,
    Running,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Mode {
    // Permanent activities.
    Unstarted,
    FirstCodel,
    FirstRun,
    Normal,
    Ended,
    // Slots.
    Void,
    Wait,
    Run,
    Stop,
    Ether,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Doing {
    Nothing,
    Locking,
    Executing(u32),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Task {
    status: Status,
    tick: bool,
    timer: Option<u32>,
    /// Since release.
    age: u32,
    /// Position of the automaton that has its turn.
    turn: usize,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Automaton {
    mode: Mode,
    /// Entered its `stop` state.
    stopping: bool,
    at: usize,
    doing: Doing,
    /// Executed by a separate thread.
    separate: bool,
    visits: Vec<u16>,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Step {
    Starting(usize),
    Ready,
    Validate(usize, usize),
    Simple(usize, usize, usize),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Control {
    step: Step,
    doing: Doing,
    signal: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Tracked {
    Over,
    Handled,
    Slot(usize),
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Client {
    /// `None`: before the first step.
    at: Option<usize>,
    clock: u32,
    outstanding: bool,
    tracked: Vec<Tracked>,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct State {
    tasks: Vec<Task>,
    automata: Vec<Automaton>,
    controls: Vec<Control>,
    clients: Vec<Client>,
    queue: Vec<usize>,
    lock_queue: Vec<usize>,
    /// Age of the open obligation of each observer.
    obligations: Vec<Option<u32>>,
}

pub(crate) struct Brute<'s> {
    pub(crate) system: &'s TimedSystem,
    pub(crate) within: &'s [Within],
}

#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Results {
    pub(crate) missed: Vec<bool>,
    pub(crate) overdue: Vec<bool>,
    /// `Some(CAP)`: unbounded.
    pub(crate) response: Vec<Option<u32>>,
    pub(crate) within: Vec<Option<u32>>,
    /// The earliest moment at which each response time, and each obligation, has reached each age.
    pub(crate) response_at: Vec<Vec<u64>>,
    pub(crate) within_at: Vec<Vec<u64>>,
    pub(crate) deadlock: bool,
    pub(crate) refused: Vec<bool>,
    pub(crate) states: usize,
}

impl Brute<'_> {
    pub(crate) fn initial(&self) -> State {
        let sys = self.system;
        let mut s = State {
            tasks: sys
                .tasks
                .iter()
                .map(|_| Task {
                    status: Status::Idle,
                    tick: false,
                    timer: None,
                    age: 0,
                    turn: 0,
                })
                .collect(),
            automata: sys
                .automata
                .iter()
                .map(|it| Automaton {
                    mode: if it.service.is_some() {
                        Mode::Void
                    } else {
                        Mode::Unstarted
                    },
                    stopping: false,
                    at: if it.service.is_some() {
                        sys.machines[it.machine].start
                    } else {
                        0
                    },
                    doing: Doing::Nothing,
                    separate: false,
                    visits: vec![0; sys.machines[it.machine].states.len()],
                })
                .collect(),
            controls: sys
                .components
                .iter()
                .map(|_| Control {
                    step: Step::Starting(0),
                    doing: Doing::Nothing,
                    signal: false,
                })
                .collect(),
            clients: sys
                .clients
                .iter()
                .map(|it| Client {
                    at: None,
                    clock: 0,
                    outstanding: false,
                    tracked: vec![Tracked::Over; it.trackers],
                })
                .collect(),
            queue: Vec::new(),
            lock_queue: Vec::new(),
            obligations: vec![None; self.within.len()],
        };
        for c in 0..sys.components.len() {
            self.start_from(&mut s, c, 0);
        }
        self.watch(None, &mut s);
        s
    }

    fn start_from(&self, s: &mut State, c: usize, first: usize) {
        let tasks = &self.system.components[c].tasks;
        for (i, &t) in tasks.iter().enumerate().skip(first) {
            if self.system.tasks[t].period.is_some() {
                s.tasks[t].timer = Some(0);
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

    fn doing(&self, s: &State, e: usize) -> Doing {
        let (na, nc) = (s.automata.len(), s.controls.len());
        if e < na {
            s.automata[e].doing
        } else if e < na + nc {
            s.controls[e - na].doing
        } else {
            let k = e - na - nc;
            match s.clients[k]
                .at
                .and_then(|at| self.system.clients[k].steps.get(at))
            {
                Some(it) if matches!(it.action, ClientAction::Delay(..)) => {
                    Doing::Executing(s.clients[k].clock)
                }
                _ => Doing::Nothing,
            }
        }
    }

    fn codel(&self, s: &State, e: usize) -> usize {
        let na = s.automata.len();
        if e < na {
            self.system.machine_of(e).states[s.automata[e].at].codel
        } else {
            match s.controls[e - na].step {
                Step::Validate(service, _) => self.system.services[service].validate.unwrap(),
                Step::Simple(service, _, i) => self.system.services[service].simple[i],
                _ => unreachable!("no codel"),
            }
        }
    }

    fn bounds(&self, s: &State, e: usize) -> (u32, u32) {
        let n = s.automata.len() + s.controls.len();
        if e < n {
            let codel = &self.system.codels[self.codel(s, e)];
            (codel.lower, codel.upper)
        } else {
            let at = s.clients[e - n].at.unwrap();
            match self.system.clients[e - n].steps[at].action {
                ClientAction::Delay(a, b) => (a, b),
                _ => unreachable!("not a delay"),
            }
        }
    }

    fn executors(&self, s: &State) -> usize {
        s.automata.len() + s.controls.len() + s.clients.len()
    }

    fn locks_free(&self, s: &State, e: usize) -> bool {
        let mine = &self.system.codels[self.codel(s, e)].conflicts;
        let n = s.automata.len() + s.controls.len();
        for other in 0..n {
            if other != e
                && matches!(self.doing(s, other), Doing::Executing(_))
                && mine.contains(self.codel(s, other))
            {
                return false;
            }
        }
        if self.system.platform.locks == LockOrder::Fifo {
            let place = s.lock_queue.iter().position(|&it| it == e).unwrap();
            if s.lock_queue[..place]
                .iter()
                .any(|&it| mine.contains(self.codel(s, it)))
            {
                return false;
            }
        }
        true
    }

    fn can_run(&self, s: &State, a: usize) -> bool {
        s.automata[a].doing == Doing::Nothing
            && matches!(s.automata[a].mode, Mode::Normal | Mode::Run | Mode::Stop)
    }

    /// Automata of a task in the order of turns.
    fn order(&self, t: usize) -> Vec<usize> {
        let it = &self.system.tasks[t];
        it.permanent.iter().chain(&it.slots).copied().collect()
    }

    fn something_to_do(&self, s: &State, t: usize) -> bool {
        self.order(t).iter().any(|&a| self.can_run(s, a))
    }

    /// Actions that may happen now, and whether one of them has to before time passes.
    pub(crate) fn actions(&self, s: &State) -> (Vec<Action>, bool) {
        let sys = self.system;
        let mut out = Vec::new();
        for (k, client) in s.clients.iter().enumerate() {
            let it = &sys.clients[k];
            let over = |t: usize| client.tracked[t] == Tracked::Over;
            match client.at {
                None => out.extend(
                    it.first
                        .iter()
                        .map(|&next| Action::Proceed { client: k, next }),
                ),
                Some(at) if at < it.steps.len() => {
                    let ready = match it.steps[at].action {
                        ClientAction::AwaitAccepted => !client.outstanding,
                        ClientAction::AwaitEnded(t) => over(t),
                        _ => false,
                    };
                    if ready {
                        let next = &it.steps[at].next;
                        out.extend(next.iter().map(|&next| Action::Proceed { client: k, next }));
                    }
                }
                Some(_) => {}
            }
        }
        if !out.is_empty() {
            return (out, true);
        }
        for (t, task) in s.tasks.iter().enumerate() {
            let it = &sys.tasks[t];
            let wants = match it.period {
                Some(_) => task.tick && (!it.keep_idle_tick || self.something_to_do(s, t)),
                None => self.something_to_do(s, t),
            };
            if task.status == Status::Idle && wants {
                out.push(Action::Release { task: t });
            }
        }
        if !out.is_empty() {
            return (out, true);
        }
        let busy = (0..s.tasks.len())
            .filter(|&t| s.tasks[t].status == Status::Running && sys.needs_core(t))
            .count();
        if !s.queue.is_empty() && busy < sys.platform.cores.unwrap() as usize {
            match sys.platform.policy {
                Policy::Fifo => out.push(Action::Grant { task: s.queue[0] }),
                Policy::Any => out.extend(s.queue.iter().map(|&task| Action::Grant { task })),
                Policy::Edf => {
                    // The queue is in order of release; the first least deadline wins.
                    let deadline = |t: usize| match sys.tasks[t].period {
                        Some(p) => i64::from(p) - i64::from(s.tasks[t].age),
                        None => i64::MAX,
                    };
                    let task = *s.queue.iter().min_by_key(|&&t| deadline(t)).unwrap();
                    out.push(Action::Grant { task });
                }
            }
            return (out, true);
        }
        let mut urgent = false;
        for (t, task) in s.tasks.iter().enumerate() {
            if let (Some(timer), Some(period)) = (task.timer, sys.tasks[t].period)
                && timer == period + sys.tasks[t].delay
            {
                out.push(Action::Tick { task: t });
                urgent = true;
            }
        }
        for e in 0..self.executors(s) {
            match self.doing(s, e) {
                Doing::Locking if self.locks_free(s, e) => {
                    out.push(Action::Acquire { executor: e });
                    urgent = true;
                }
                Doing::Executing(elapsed) => {
                    let (a, b) = self.bounds(s, e);
                    if elapsed >= a {
                        for outcome in self.outcomes(s, e) {
                            out.push(Action::Finish {
                                executor: e,
                                outcome,
                            });
                        }
                    }
                    urgent |= elapsed == b && b != FOREVER;
                }
                _ => {}
            }
        }
        for (c, it) in s.controls.iter().enumerate() {
            if it.step == Step::Ready && it.signal {
                out.push(Action::Signal { component: c });
                urgent = true;
            }
        }
        for (k, client) in s.clients.iter().enumerate() {
            let Some(step) = client.at.and_then(|at| sys.clients[k].steps.get(at)) else {
                continue;
            };
            if let ClientAction::Send { service, .. } = step.action {
                let control = &s.controls[sys.services[service].component];
                if control.step == Step::Ready && !control.signal && !client.outstanding {
                    out.extend(
                        step.next
                            .iter()
                            .map(|&next| Action::Request { client: k, next }),
                    );
                    urgent = true;
                }
            }
        }
        (out, urgent)
    }

    fn outcomes(&self, s: &State, e: usize) -> Vec<usize> {
        let (na, nc) = (s.automata.len(), s.controls.len());
        if e < na {
            let machine = self.system.machine_of(e);
            let it = &s.automata[e];
            let yields = &machine.states[it.at].yields;
            let fresh = |y: &Yield| match (y, machine.loop_limit) {
                (&Yield::Next(to), Some(limit)) => it.visits[to] < limit,
                _ => true,
            };
            let mut out: Vec<usize> = (0..yields.len()).filter(|&i| fresh(&yields[i])).collect();
            if out.is_empty() && machine.rounds {
                out = (0..yields.len())
                    .filter(|&i| yields[i] != Yield::Next(it.at))
                    .collect();
            }
            out
        } else if e < na + nc {
            match s.controls[e - na].step {
                Step::Validate(..) => vec![0, 1],
                _ => vec![0],
            }
        } else {
            let k = e - na - nc;
            self.system.clients[k].steps[s.clients[k].at.unwrap()]
                .next
                .clone()
        }
    }

    pub(crate) fn perform(&self, s: &State, action: Action, results: &mut Results) -> State {
        let mut n = s.clone();
        match action {
            Action::Proceed { client, next } => {
                n.clients[client].at = Some(next);
                n.clients[client].clock = 0;
            }
            Action::Release { task } => {
                n.tasks[task].tick = false;
                n.tasks[task].age = 0;
                if self.system.needs_core(task) {
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
                n.queue.retain(|&it| it != task);
                n.tasks[task].status = Status::Running;
                self.turns(&mut n, task, 0);
            }
            Action::Tick { task } => {
                n.tasks[task].timer = Some(self.system.tasks[task].delay);
                n.tasks[task].tick = true;
            }
            Action::Acquire { executor } => {
                n.lock_queue.retain(|&it| it != executor);
                if executor < n.automata.len() {
                    n.automata[executor].doing = Doing::Executing(0);
                } else {
                    let na = n.automata.len();
                    n.controls[executor - na].doing = Doing::Executing(0);
                }
            }
            Action::Finish { executor, outcome } => {
                let (na, nc) = (n.automata.len(), n.controls.len());
                if executor < na {
                    self.end_state(&mut n, executor, outcome);
                } else if executor < na + nc {
                    self.end_control(&mut n, executor - na, outcome, results);
                } else {
                    let client = &mut n.clients[executor - na - nc];
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
                let ClientAction::Send {
                    service,
                    ref trackers,
                } = self.system.clients[client].steps[at].action
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
        }
        self.watch(Some(s), &mut n);
        n
    }

    fn enter(&self, s: &mut State, a: usize, state: usize) {
        let it = &self.system.machine_of(a).states[state];
        let in_cycle = !matches!(s.automata[a].mode, Mode::FirstCodel | Mode::FirstRun);
        let automaton = &mut s.automata[a];
        automaton.at = state;
        if self.system.machine_of(a).loop_limit.is_some() {
            automaton.visits[state] += 1;
        }
        automaton.separate = it.is_async && self.system.platform.async_free && in_cycle;
        if self.system.codels[it.codel].conflicts.is_empty() {
            automaton.doing = Doing::Executing(0);
        } else {
            automaton.doing = Doing::Locking;
            if self.system.platform.locks == LockOrder::Fifo {
                s.lock_queue.push(a);
            }
        }
    }

    fn end_state(&self, s: &mut State, a: usize, outcome: usize) {
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
            let Step::Starting(i) = s.controls[c].step else {
                panic!("not starting")
            };
            self.start_from(s, c, i + 1);
        }
        if turn_ends && !first_run && !separate {
            let next = s.tasks[t].turn + 1;
            self.turns(s, t, next);
        }
    }

    fn turns(&self, s: &mut State, t: usize, first: usize) {
        for (position, a) in self.order(t).into_iter().enumerate().skip(first) {
            if !self.can_run(s, a) {
                continue;
            }
            let mut state = s.automata[a].at;
            if s.automata[a].mode == Mode::Stop && !s.automata[a].stopping {
                match self.system.machine_of(a).stop {
                    Some(stop) => state = stop,
                    None => {
                        self.to_ether(s, a);
                        continue;
                    }
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
        let slots = &self.system.tasks[t].slots;
        if slots.iter().any(|&a| s.automata[a].mode == Mode::Ether) {
            s.controls[self.system.tasks[t].component].signal = true;
        }
    }

    fn to_ether(&self, s: &mut State, a: usize) {
        self.to_void(s, a);
        s.automata[a].mode = Mode::Ether;
    }

    fn to_void(&self, s: &mut State, a: usize) {
        let it = &mut s.automata[a];
        it.mode = Mode::Void;
        it.stopping = false;
        it.at = self.system.machine_of(a).start;
        it.visits.fill(0);
    }

    fn control_codel(&self, s: &mut State, c: usize) {
        let e = s.automata.len() + c;
        if self.system.codels[self.codel(s, e)].conflicts.is_empty() {
            s.controls[c].doing = Doing::Executing(0);
        } else {
            s.controls[c].doing = Doing::Locking;
            if self.system.platform.locks == LockOrder::Fifo {
                s.lock_queue.push(e);
            }
        }
    }

    fn end_control(&self, s: &mut State, c: usize, outcome: usize, results: &mut Results) {
        s.controls[c].doing = Doing::Nothing;
        match s.controls[c].step.clone() {
            Step::Validate(service, client) => {
                if outcome == 0 {
                    self.accepted(s, c, service, client, results);
                } else {
                    self.replied(s, c, client);
                }
            }
            Step::Simple(service, client, i) => {
                if i + 1 < self.system.services[service].simple.len() {
                    s.controls[c].step = Step::Simple(service, client, i + 1);
                    self.control_codel(s, c);
                } else {
                    self.replied(s, c, client);
                }
            }
            _ => panic!("no codel"),
        }
    }

    fn accepted(
        &self,
        s: &mut State,
        c: usize,
        service: usize,
        client: usize,
        results: &mut Results,
    ) {
        let it = &self.system.services[service];
        let mut own = None;
        if it.activity {
            own = it
                .slots
                .iter()
                .copied()
                .find(|&a| s.automata[a].mode == Mode::Void);
            let Some(a) = own else {
                results.refused[service] = true;
                self.replied(s, c, client);
                return;
            };
            s.automata[a].mode = Mode::Wait;
            for t in &mut s.clients[client].tracked {
                if *t == Tracked::Handled {
                    *t = Tracked::Slot(a);
                }
            }
        }
        for &other in &it.interrupts {
            for &a in &self.system.services[other].slots {
                if Some(a) != own {
                    match s.automata[a].mode {
                        Mode::Wait => self.to_ether(s, a),
                        Mode::Run => s.automata[a].mode = Mode::Stop,
                        _ => {}
                    }
                }
            }
        }
        if !it.activity && !it.simple.is_empty() {
            s.controls[c].step = Step::Simple(service, client, 0);
            self.control_codel(s, c);
        } else {
            self.replied(s, c, client);
        }
    }

    fn replied(&self, s: &mut State, c: usize, client: usize) {
        s.clients[client].outstanding = false;
        for t in &mut s.clients[client].tracked {
            if *t == Tracked::Handled {
                *t = Tracked::Over;
            }
        }
        self.finish(s, c);
    }

    fn finish(&self, s: &mut State, c: usize) {
        s.controls[c].step = Step::Ready;
        for &service in &self.system.components[c].services {
            for &a in &self.system.services[service].slots {
                if s.automata[a].mode == Mode::Ether {
                    self.to_void(s, a);
                    for client in &mut s.clients {
                        for t in &mut client.tracked {
                            if *t == Tracked::Slot(a) {
                                *t = Tracked::Over;
                            }
                        }
                    }
                }
            }
        }
        for &t in &self.system.components[c].tasks {
            for &a in &self.system.tasks[t].slots {
                if s.automata[a].mode == Mode::Wait {
                    let service = self.system.automata[a].service.unwrap();
                    let free = self.system.services[service]
                        .interrupts
                        .iter()
                        .all(|&other| {
                            let slots = &self.system.services[other].slots;
                            slots
                                .iter()
                                .all(|&b| b == a || s.automata[b].mode == Mode::Void)
                        });
                    if free {
                        s.automata[a].mode = Mode::Run;
                    }
                }
            }
        }
    }

    /// One unit of time.
    pub(crate) fn pass(&self, s: &State) -> State {
        let mut n = s.clone();
        for task in &mut n.tasks {
            task.timer = task.timer.map(|it| it + 1);
            if task.status != Status::Idle {
                task.age = (task.age + 1).min(CAP);
            }
        }
        for e in 0..self.executors(s) {
            if let Doing::Executing(elapsed) = self.doing(s, e) {
                let (a, b) = self.bounds(s, e);
                let elapsed = if b == FOREVER {
                    (elapsed + 1).min(a)
                } else {
                    elapsed + 1
                };
                let (na, nc) = (n.automata.len(), n.controls.len());
                if e < na {
                    n.automata[e].doing = Doing::Executing(elapsed);
                } else if e < na + nc {
                    n.controls[e - na].doing = Doing::Executing(elapsed);
                } else {
                    n.clients[e - na - nc].clock = elapsed;
                }
            }
        }
        for it in n.obligations.iter_mut().flatten() {
            *it = (*it + 1).min(CAP);
        }
        n
    }

    /// Whether anything will ever happen after a state in which time passes.
    fn dead(&self, s: &State) -> bool {
        s.tasks.iter().all(|it| it.timer.is_none())
            && (0..self.executors(s)).all(|e| !matches!(self.doing(s, e), Doing::Executing(_)))
    }

    fn watch(&self, before: Option<&State>, now: &mut State) {
        for (i, it) in self.within.iter().enumerate() {
            let (p, q) = (&it.trigger, &it.response);
            let value = |it: &Predicate| self.predicate(before, now, it);
            if now.obligations[i].is_some() {
                if value(q) {
                    now.obligations[i] = None;
                }
            } else if value(p)
                && !before.is_some_and(|before| self.predicate(Some(before), before, p))
                && !value(q)
            {
                now.obligations[i] = Some(0);
            }
        }
    }

    pub(crate) fn predicate(&self, before: Option<&State>, now: &State, it: &Predicate) -> bool {
        match it {
            Predicate::Atom(it) => self.atom(now, it),
            Predicate::Leave(it) => {
                before.is_some_and(|before| self.atom(before, it)) && !self.atom(now, it)
            }
            Predicate::Not(it) => !self.predicate(before, now, it),
            Predicate::And(a, b) => {
                self.predicate(before, now, a) && self.predicate(before, now, b)
            }
            Predicate::Or(a, b) => self.predicate(before, now, a) || self.predicate(before, now, b),
        }
    }

    fn atom(&self, s: &State, it: &Atom) -> bool {
        match *it {
            Atom::Task(t, state) => match state {
                TaskState::Idle => s.tasks[t].status == Status::Idle,
                TaskState::Waiting => s.tasks[t].status == Status::Waiting,
                TaskState::Running => s.tasks[t].status == Status::Running,
                TaskState::Active => s.tasks[t].status != Status::Idle,
            },
            Atom::State {
                machine,
                state,
                phase,
            } => (0..s.automata.len()).any(|a| {
                self.system.automata[a].machine == machine
                    && s.automata[a].at == state
                    && match s.automata[a].doing {
                        Doing::Nothing => false,
                        Doing::Locking => phase != StatePhase::Exec,
                        Doing::Executing(_) => phase != StatePhase::Lock,
                    }
            }),
            Atom::Slot(service, status) => {
                let mut modes = self.system.services[service]
                    .slots
                    .iter()
                    .map(|&a| s.automata[a].mode);
                match status {
                    SlotStatus::Void => modes.all(|it| it == Mode::Void),
                    SlotStatus::Wait => modes.any(|it| it == Mode::Wait),
                    SlotStatus::Run => modes.any(|it| it == Mode::Run),
                    SlotStatus::Stop => modes.any(|it| it == Mode::Stop),
                    SlotStatus::Active => modes.any(|it| it != Mode::Void),
                }
            }
            Atom::Handling { .. } | Atom::ControlBusy(_) | Atom::Client(..) => {
                unreachable!("not generated")
            }
        }
    }

    fn inspect(&self, s: &State, now: u64, out: &mut Results) {
        let reach = |ages: &mut Vec<u64>, age: u32| {
            ages.resize(ages.len().max(age as usize + 1), now);
        };
        for (t, task) in s.tasks.iter().enumerate() {
            if task.status == Status::Idle {
                continue;
            }
            out.missed[t] |= task.tick;
            if let Some(period) = self.system.tasks[t].period {
                out.overdue[t] |= task.status == Status::Waiting && task.age >= period;
            }
            out.response[t] = out.response[t].max(Some(task.age));
            reach(&mut out.response_at[t], task.age);
        }
        for (i, it) in s.obligations.iter().enumerate() {
            out.within[i] = out.within[i].max(*it);
            if let Some(age) = *it {
                reach(&mut out.within_at[i], age);
            }
        }
    }

    fn blank(&self) -> Results {
        let n = self.system.tasks.len();
        Results {
            missed: vec![false; n],
            overdue: vec![false; n],
            response: vec![None; n],
            within: vec![None; self.within.len()],
            response_at: vec![Vec::new(); n],
            within_at: vec![Vec::new(); self.within.len()],
            deadlock: false,
            refused: vec![false; self.system.services.len()],
            states: 0,
        }
    }

    /// Everything there is to know, or `None` above `limit` states.
    pub(crate) fn explore(&self, limit: usize) -> Option<Results> {
        let mut out = self.blank();
        let initial = self.initial();
        // Moment by moment, so that a state is seen at the earliest moment at which it can be reached.
        let mut seen: HashSet<State> = HashSet::new();
        let mut later = vec![initial];
        let mut now = 0;
        while !later.is_empty() {
            let mut todo = std::mem::take(&mut later);
            todo.retain(|it| seen.insert(it.clone()));
            while let Some(s) = todo.pop() {
                if seen.len() > limit {
                    return None;
                }
                self.inspect(&s, now, &mut out);
                let (actions, urgent) = self.actions(&s);
                for action in actions {
                    let next = self.perform(&s, action, &mut out);
                    if seen.insert(next.clone()) {
                        todo.push(next);
                    }
                }
                if !urgent {
                    out.deadlock |= self.dead(&s);
                    later.push(self.pass(&s));
                }
            }
            now += 1;
        }
        out.states = seen.len();
        Some(out)
    }

    /// Plays a run; fails at an action that is not possible. Returns what was seen in its last state.
    pub(crate) fn replay(&self, steps: &[(u64, Action)], end: u64) -> Result<Results, String> {
        let mut out = self.blank();
        let mut s = self.initial();
        let mut now = 0;
        let advance = |s: &mut State, now: &mut u64, to: u64| {
            while *now < to {
                if self.actions(s).1 {
                    return Err(format!("time may not pass at {now}"));
                }
                *s = self.pass(s);
                *now += 1;
            }
            Ok(())
        };
        for &(time, action) in steps {
            advance(&mut s, &mut now, time)?;
            if !self.actions(&s).0.contains(&action) {
                return Err(format!("{action:?} is not possible at {now}"));
            }
            s = self.perform(&s, action, &mut out);
        }
        advance(&mut s, &mut now, end)?;
        let mut last = self.blank();
        self.inspect(&s, end, &mut last);
        last.deadlock = self.dead(&s);
        Ok(last)
    }
}
