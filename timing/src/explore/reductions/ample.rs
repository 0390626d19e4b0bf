//! Which of several simultaneous actions are followed first: the partial-order reduction within one
//! moment.
//!
//! Where actions commute, following them in one order is enough. A set of actions of a state is
//! *ample* if (1) whatever else can happen before one of them, at this moment, commutes with all of
//! them and leaves them possible; (2) one of them has to happen at this moment; (3) nothing that is
//! observed changes by them; (4) they cannot happen for ever without time passing. Then only the
//! ample set is followed. (These are the conditions of persistent and ample sets: D. Peled,
//! *Combining partial order reductions with on-the-fly model-checking*, CAV 1994.) As time waits for
//! urgent actions, "at this moment" ends any path to be considered.
//!
//! Four kinds of ample sets are looked for. All concern *plain* tasks: no activities, no kept ticks,
//! no separate threads, past their start-up, so that neither control tasks nor clients have to do
//! with them.
//!
//! * **A tick** of a task that is idle, if it gets a core whatever happens before (no limit, or more
//!   free cores than tasks that can ask at this moment).
//! * **All ticks** that are due, under FIFO, if no other task can ask for a core at this moment. The
//!   order of ticks matters, so all of them are in the set; giving a core back commutes with a tick:
//!   the queue is the same, and its head is granted, whichever comes first. A task that has nothing to do
//!   delays nobody, so it is enough that its own tick comes last, which makes it wait longest. (Unless its response
//!   time is measured: after a miss the next job would be measured from a later moment.)
//! * **The end** of a codel whose window is over. It only gives locks back, which nobody else can do,
//!   and begins to wait for the next ones. If it can end the cycle, no tick of the same task may be
//!   due (the order of those two is what `schedulable` is about). If somebody can be waiting for the
//!   core then, this needs FIFO for the same reason as ticks; and all who can be waiting must be plain
//!   and not have their own tick due, as a job with nothing to do ends in the step that grants its
//!   core.
//! * **Acquisitions** of codels that exclude each other, if nobody else can want any of their locks
//!   at this moment.
//!
//! Clients and activities have ample sets of their own, see [`requests`].
//!
//! None of this with locks in order of arrival, where every request for a lock counts.

mod requests;

use self::requests::Requests;
use crate::explore::rules::published::Published;
use crate::explore::rules::published::layout::{Layout, mode};
use crate::explore::rules::{Action, Enabled};
use crate::explore::state::{State, TaskStatus, phase};
use crate::property::{Atom, Predicate};
use crate::system::{CodelSet, LockOrder, Machine, Policy, TimedSystem, Yield};

/// What predicates say something about.
#[derive(Debug)]
pub(crate) struct Visible {
    /// These tasks.
    pub(super) tasks: Vec<bool>,
    /// Some control task or client.
    pub(super) others: bool,
    /// The same in more detail.
    parts: Parts,
}

/// Parts of a system.
#[derive(Debug, Clone, Default)]
struct Parts {
    /// Tasks: whether they run.
    statuses: Vec<bool>,
    /// State machines: where they are.
    machines: Vec<bool>,
    /// Services: what is in their slots.
    slots: Vec<bool>,
    /// Clients: where they are.
    clients: Vec<bool>,
    /// Control tasks: what they do.
    controls: Vec<bool>,
}

impl Visible {
    /// What these predicates say something about.
    pub(crate) fn new<'p>(
        system: &TimedSystem,
        predicates: impl Iterator<Item = &'p Predicate>,
    ) -> Self {
        let mut tasks = vec![false; system.tasks.len()];
        let mut others = false;
        let mut parts = Parts {
            statuses: vec![false; system.tasks.len()],
            machines: vec![false; system.machines.len()],
            slots: vec![false; system.services.len()],
            clients: vec![false; system.clients.len()],
            controls: vec![false; system.components.len()],
        };
        for predicate in predicates {
            predicate.atoms(&mut |atom| match *atom {
                Atom::Task(task, _) => parts.statuses[task] = true,
                Atom::State { machine, .. } => parts.machines[machine] = true,
                Atom::Slot(service, _) => parts.slots[service] = true,
                Atom::Client(client, _) => parts.clients[client] = true,
                Atom::Handling { service, .. } => {
                    parts.controls[system.services[service].component] = true;
                }
                Atom::ControlBusy(component) => parts.controls[component] = true,
            });
            predicate.atoms(&mut |atom| match *atom {
                Atom::Task(task, _) => tasks[task] = true,
                Atom::State { machine, .. } => {
                    for it in system.automata.iter().filter(|it| it.machine == machine) {
                        tasks[it.task] = true;
                    }
                }
                Atom::Slot(service, _) => {
                    for &a in &system.services[service].slots {
                        tasks[system.automata[a].task] = true;
                    }
                    others = true;
                }
                Atom::Handling { .. } | Atom::ControlBusy(_) | Atom::Client(..) => others = true,
            });
        }
        Visible {
            tasks,
            others,
            parts,
        }
    }
}

/// What is known beforehand about the tasks of a system.
#[derive(Debug)]
pub(crate) struct Ample {
    /// Nothing to do with control tasks, clients or separate threads.
    plain: Vec<bool>,
    /// Predicates say something about it.
    visible: Vec<bool>,
    /// Predicates say something about control tasks or clients.
    others_visible: bool,
    /// Some visible task needs a core.
    visible_on_cores: bool,
    /// The cycle of its permanent activity never ends, and it has no activities.
    endless: Vec<bool>,
    /// Its response time, or how long it waits, is measured.
    measured: Vec<bool>,
    /// Who executes each codel.
    owner: Vec<Owner>,
    /// Tasks with activities that can run.
    active: Vec<bool>,
    /// Per automaton and state the codels that the same turn can come to after it.
    later: Vec<Vec<CodelSet>>,
    requests: Requests,
    enabled: bool,
}

impl Ample {
    /// Examines a system of which `visible` tasks are observed by predicates and `measured` ones by clocks.
    pub(crate) fn new(system: &TimedSystem, visible: Visible, measured: &[bool]) -> Self {
        let requested = system.requested();
        let plain = |task: usize| {
            let it = &system.tasks[task];
            let simple = it.permanent.is_none_or(|a| {
                let machine = system.machine_of(a);
                let separate =
                    system.platform.async_free && machine.states.iter().any(|it| it.is_async);
                !separate && !loops_in_no_time(system, machine, it.period.is_none())
            });
            simple && !it.keep_idle_tick && !system.has_activities(task, &requested)
        };
        let endless = |task: usize| {
            let it = &system.tasks[task];
            !system.has_activities(task, &requested)
                && it.permanent.is_some_and(|a| {
                    let machine = system.machine_of(a);
                    let mut states = machine.states.iter();
                    let separate = system.platform.async_free && states.any(|it| it.is_async);
                    !separate && machine.is_endless()
                })
        };
        let mut owner = vec![Owner::Nobody; system.codels.len()];
        for automaton in &system.automata {
            if automaton.service.is_none_or(|it| requested[it]) {
                for state in &system.machines[automaton.machine].states {
                    owner[state.codel] = Owner::Task(automaton.task);
                }
            }
        }
        for (service, it) in system.services.iter().enumerate() {
            if requested[service] {
                for &codel in it.validate.iter().chain(&it.simple) {
                    owner[codel] = Owner::Control;
                }
            }
        }
        let tasks = 0..system.tasks.len();
        Ample {
            requests: Requests::new(system, &visible),
            plain: tasks.clone().map(plain).collect(),
            visible_on_cores: tasks
                .clone()
                .any(|t| visible.tasks[t] && system.needs_core(t)),
            others_visible: visible.others,
            visible: visible.tasks,
            measured: measured.to_vec(),
            endless: tasks.clone().map(endless).collect(),
            owner,
            active: tasks
                .clone()
                .map(|it| system.has_activities(it, &requested))
                .collect(),
            later: (0..system.automata.len())
                .map(|a| later(system.machine_of(a)))
                .collect(),
            enabled: system.platform.locks == LockOrder::Free,
        }
    }

    /// Whether a task has nothing to do with control tasks, clients or separate threads.
    pub(super) fn plain(&self, task: usize) -> bool {
        self.plain[task]
    }

    /// Whether predicates say something about anything.
    pub(super) fn observed(&self) -> bool {
        self.others_visible || self.visible.contains(&true)
    }

    /// Whether the cycle of a task never ends.
    pub(super) fn endless(&self, task: usize) -> bool {
        self.endless[task]
    }

    /// The codels that the same turn of an automaton can come to after a state.
    pub(super) fn later(&self, automaton: usize, state: usize) -> &CodelSet {
        &self.later[automaton][state]
    }

    /// Writes an ample set of a state to `out`, or all enabled actions.
    pub(crate) fn select(
        &self,
        rules: &Published,
        s: &State,
        enabled: &Enabled,
        out: &mut Vec<Action>,
    ) {
        out.clear();
        if self.enabled && !enabled.committed && enabled.actions.len() > 1 {
            let moment = Moment {
                ample: self,
                rules,
                s,
                enabled,
            };
            if moment.select(out) {
                return;
            }
            out.clear();
        }
        out.extend(&enabled.actions);
    }
}

/// Who executes a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Owner {
    Task(usize),
    Control,
    /// It belongs to a service that nobody requests.
    Nobody,
}

/// Whether a turn can go round without time passing, in codels that take none. The turns of an aperiodic task follow
/// each other at once.
fn loops_in_no_time(system: &TimedSystem, machine: &Machine, aperiodic: bool) -> bool {
    if machine.loop_limit.is_some() && !machine.rounds && !aperiodic {
        return false;
    }
    let instant = |state: usize| system.codels[machine.states[state].codel].upper == 0;
    (0..machine.states.len()).any(|start| {
        let mut seen = vec![false; machine.states.len()];
        let mut stack = vec![start];
        while let Some(at) = stack.pop() {
            if !instant(at) {
                continue;
            }
            for it in &machine.states[at].yields {
                let next = match *it {
                    Yield::Next(next) => next,
                    Yield::Pause(next) if aperiodic => next,
                    _ => continue,
                };
                if next == start {
                    return true;
                }
                if !std::mem::replace(&mut seen[next], true) {
                    stack.push(next);
                }
            }
        }
        false
    })
}

/// Per state, codels of the states that the same turn can enter after it.
fn later(machine: &Machine) -> Vec<CodelSet> {
    (0..machine.states.len())
        .map(|start| {
            let mut out = CodelSet::default();
            let mut seen = vec![false; machine.states.len()];
            let mut stack = vec![start];
            while let Some(at) = stack.pop() {
                for it in &machine.states[at].yields {
                    if let Yield::Next(next) = *it
                        && !std::mem::replace(&mut seen[next], true)
                    {
                        out.insert(machine.states[next].codel);
                        stack.push(next);
                    }
                }
            }
            out
        })
        .collect()
}

/// One state, and what can happen in it before time passes.
struct Moment<'m, 's> {
    ample: &'m Ample,
    rules: &'m Published<'s>,
    s: &'m State,
    enabled: &'m Enabled,
}

impl Moment<'_, '_> {
    fn select(&self, out: &mut Vec<Action>) -> bool {
        let actions = &self.enabled.actions;
        for &action in actions {
            match action {
                Action::Tick { task } if self.tick_alone(task) => {
                    out.push(action);
                    return true;
                }
                Action::Finish { executor, .. }
                    if self.end_alone(executor)
                        || self.activity_end_alone(executor)
                        || self.control_end_alone(executor)
                        || self.delay_alone(executor) =>
                {
                    self.with_outcomes(action, out);
                    return true;
                }
                Action::Request { client, .. } if self.request_alone(client) => {
                    self.with_outcomes(action, out);
                    return true;
                }
                Action::Signal { component } if self.report_alone(component) => {
                    out.push(action);
                    return true;
                }
                _ => {}
            }
        }
        for &action in actions {
            if let Action::Acquire { executor } = action
                && self.acquisitions(executor, out)
            {
                return true;
            }
        }
        out.clear();
        self.all_ticks(out)
    }

    fn layout(&self) -> &Layout {
        &self.rules.layout
    }

    fn system(&self) -> &TimedSystem {
        self.rules.system
    }

    /// Its timer has come to the end.
    fn due(&self, task: usize) -> bool {
        let it = &self.system().tasks[task];
        it.period.is_some_and(|period| {
            self.layout().started(self.s, task)
                && self.layout().timer(self.s, task) == period + it.delay
        })
    }

    /// Past its start-up.
    fn started_up(&self, task: usize) -> bool {
        let l = self.layout();
        let permanent = self.system().tasks[task].permanent;
        l.started(self.s, task)
            && permanent.is_none_or(|a| matches!(l.mode(self.s, a), mode::NORMAL | mode::ENDED))
    }

    /// A plain task past its start-up.
    fn settled(&self, task: usize) -> bool {
        self.ample.plain[task] && self.started_up(task)
    }

    /// A settled task whose tick will be taken as soon as it comes.
    fn ready(&self, task: usize) -> bool {
        self.settled(task)
            && !self.ample.visible[task]
            && self.layout().status(self.s, task) == TaskStatus::Idle
            && !self.layout().pending(self.s, task)
    }

    /// Whether a task that is not due can ask for a core at this moment.
    fn may_ask(&self, task: usize) -> bool {
        let l = self.layout();
        if !self.system().needs_core(task) || self.due(task) {
            return false;
        }
        let status = l.status(self.s, task);
        if self.system().tasks[task].period.is_some() {
            return l.pending(self.s, task);
        }
        if status != TaskStatus::Idle {
            return !self.ample.endless[task];
        }
        let it = &self.system().tasks[task];
        self.ample.active[task]
            || it
                .permanent
                .is_some_and(|a| l.mode(self.s, a) != mode::ENDED)
    }

    /// Nobody has to wait for a core at this moment, whatever happens.
    fn cores_for_all(&self) -> bool {
        let Some(cores) = self.system().platform.cores else {
            return true;
        };
        let l = self.layout();
        if !l.queue(self.s).is_empty() {
            return false;
        }
        let tasks = 0..self.system().tasks.len();
        let wanted = tasks.filter(|&t| {
            self.system().needs_core(t)
                && (l.status(self.s, t) != TaskStatus::Idle || self.due(t) || self.may_ask(t))
        });
        wanted.count() <= cores as usize
    }

    fn tick_alone(&self, task: usize) -> bool {
        self.ready(task) && self.cores_for_all()
    }

    fn all_ticks(&self, out: &mut Vec<Action>) -> bool {
        if self.system().platform.policy != Policy::Fifo {
            return false;
        }
        let mut tasks = 0..self.system().tasks.len();
        if tasks.any(|t| {
            if self.due(t) {
                !self.ready(t)
            } else {
                self.may_ask(t)
            }
        }) {
            return false;
        }
        let ticks = self.enabled.actions.iter();
        out.extend(ticks.filter(|it| matches!(it, Action::Tick { .. })));
        let last =
            |it: &Action| matches!(*it, Action::Tick { task } if self.has_nothing_to_do(task));
        if !out.iter().all(last) {
            out.retain(|it| !last(it));
        }
        !out.is_empty()
    }

    /// Whether the jobs of a plain task end as soon as they get a core, and nobody measures how long that takes.
    fn has_nothing_to_do(&self, task: usize) -> bool {
        let permanent = self.system().tasks[task].permanent;
        !self.ample.measured[task]
            && permanent.is_none_or(|a| self.layout().mode(self.s, a) == mode::ENDED)
    }

    fn end_alone(&self, executor: usize) -> bool {
        let l = self.layout();
        let Some(automaton) = self.system().automata.get(executor) else {
            return false;
        };
        let task = automaton.task;
        if l.window(self.s, executor).1 > 0
            || automaton.service.is_some()
            || !self.settled(task)
            || self.ample.visible[task]
            || l.mode(self.s, executor) != mode::NORMAL
        {
            return false;
        }
        let state = &self.system().machine_of(executor).states[l.at(self.s, executor) as usize];
        if state.yields.iter().all(|it| matches!(it, Yield::Next(_))) {
            return true;
        }
        self.system().tasks[task].period.is_some()
            && !self.due(task)
            && !l.pending(self.s, task)
            && (self.cores_for_all() || self.hand_over_commutes())
    }

    /// Whether a core given back now can as well be given back later at this moment. Whoever gets it
    /// may end in the same step: its activities must not change meanwhile, nor its tick come.
    fn hand_over_commutes(&self) -> bool {
        let l = self.layout();
        self.system().platform.policy == Policy::Fifo
            && !self.ample.visible_on_cores
            && (0..self.system().tasks.len()).all(|t| {
                let waits = l.status(self.s, t) == TaskStatus::Waiting;
                !self.system().needs_core(t)
                    || !(waits || self.due(t) || self.may_ask(t))
                    || (self.settled(t) && !(waits && self.due(t)))
            })
    }

    /// Acquisitions of `first` and of whoever competes with it.
    fn acquisitions(&self, first: usize, out: &mut Vec<Action>) -> bool {
        out.clear();
        let mut members = vec![first];
        let mut at = 0;
        while let Some(&executor) = members.get(at) {
            at += 1;
            if !self.may_acquire_alone(executor) {
                return false;
            }
            let Some(codel) = self.rules.codel(self.s, executor) else {
                return false;
            };
            for other in self.system().codels[codel].conflicts.iter() {
                let rival = match self.ample.owner[other] {
                    Owner::Nobody => continue,
                    Owner::Control => {
                        let component = self.system().codels[other].component;
                        let own = executor == self.layout().control_executor(component);
                        if !own && self.control_may_want(component, codel) {
                            return false;
                        }
                        continue;
                    }
                    Owner::Task(rival) => rival,
                };
                if members.iter().any(|&it| self.runs(it, rival)) {
                    continue;
                }
                match self.rivalry(rival, codel) {
                    Rivalry::None => {}
                    Rivalry::Now(executor) => members.push(executor),
                    Rivalry::Later => return false,
                }
            }
            out.push(Action::Acquire { executor });
        }
        true
    }

    fn runs(&self, executor: usize, task: usize) -> bool {
        let automaton = self.system().automata.get(executor);
        automaton.is_some_and(|it| it.task == task)
    }

    /// Whether an acquisition by this executor changes nothing that is observed, and cannot be repeated for ever in no time.
    fn may_acquire_alone(&self, executor: usize) -> bool {
        match self.system().automata.get(executor) {
            Some(it) if it.service.is_none() => {
                self.settled(it.task) && !self.ample.visible[it.task]
            }
            _ => self.may_acquire_for_request(executor),
        }
    }

    /// Whether a task can want a lock of `codel` at this moment.
    fn rivalry(&self, task: usize, codel: usize) -> Rivalry {
        let l = self.layout();
        if !self.ample.plain[task] && !self.task_may_want(task, codel) {
            return Rivalry::None;
        }
        if !self.settled(task) || self.due(task) || l.pending(self.s, task) {
            return Rivalry::Later;
        }
        let Some(a) = self.system().tasks[task].permanent else {
            return Rivalry::None;
        };
        let periodic = self.system().tasks[task].period.is_some();
        match l.status(self.s, task) {
            TaskStatus::Idle if periodic || l.mode(self.s, a) == mode::ENDED => Rivalry::None,
            TaskStatus::Running if periodic || self.ample.endless[task] => {
                let conflicts = &self.system().codels[codel].conflicts;
                let state = l.at(self.s, a) as usize;
                let later = self.ample.later[a][state]
                    .iter()
                    .any(|it| conflicts.contains(it));
                match l.phase(self.s, a) {
                    phase::EXECUTING if !later || l.window(self.s, a).0 > 0 => Rivalry::None,
                    phase::LOCKING => {
                        let here = self.rules.codel(self.s, a);
                        let now = self
                            .enabled
                            .actions
                            .contains(&Action::Acquire { executor: a });
                        if here.is_some_and(|it| conflicts.contains(it)) {
                            // What comes after belongs to states after the set.
                            if now { Rivalry::Now(a) } else { Rivalry::Later }
                        } else if later {
                            Rivalry::Later
                        } else {
                            Rivalry::None
                        }
                    }
                    _ => Rivalry::Later,
                }
            }
            _ => Rivalry::Later,
        }
    }
}

enum Rivalry {
    /// It cannot.
    None,
    /// This executor of it can take one now.
    Now(usize),
    /// Perhaps after something else.
    Later,
}
