//! The places of the published rules in a state.

use std::ops::Deref;

use super::Published;
use crate::explore::rules::{Exchangeable, Names, Part, Parts, UnitPlaces};
use crate::explore::state::{Clocks, Frame, Places, State, TaskStatus};
use crate::system::{Policy, Ticks, TimedSystem};

/// `mode` of a permanent activity.
pub(crate) mod mode {
    // 0: its task is not started.
    /// First codel of the start-up.
    pub(crate) const FIRST_CODEL: u16 = 1;
    /// In its first run, past the first codel.
    pub(crate) const FIRST_RUN: u16 = 2;
    /// Runs with its task.
    pub(crate) const NORMAL: u16 = 3;
    /// Ended.
    pub(crate) const ENDED: u16 = 4;
}

/// `mode` of a slot: its status.
pub(crate) mod slot {
    pub(crate) const VOID: u16 = 0;
    pub(crate) const WAIT: u16 = 1;
    pub(crate) const RUN: u16 = 2;
    /// Interrupted, `stop` not entered yet.
    pub(crate) const STOP: u16 = 3;
    /// Interrupted, past the entry of `stop`.
    pub(crate) const STOPPING: u16 = 5;
    pub(crate) const ETHER: u16 = 4;
}

/// Steps of a control task.
pub(crate) mod control {
    // 0: the component is starting.
    pub(crate) const READY: u16 = 1;
    pub(crate) const VALIDATE: u16 = 2;
    pub(crate) const SIMPLE: u16 = 3;
}

/// Values of trackers other than "slot" (which is [`tracker::SLOT`] plus the automaton).
pub(crate) mod tracker {
    pub(crate) const NONE: u16 = 0;
    /// Sent, not accepted yet.
    pub(crate) const HANDLED: u16 = 1;
    pub(crate) const SLOT: u16 = 2;
}

const PENDING: u16 = 4;
const STARTED: u16 = 8;

/// The places in the arrays of a [`State`].
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    /// Places common to all rules.
    frame: Frame,
    pub(crate) tasks: usize,
    pub(crate) automata: usize,
    pub(crate) components: usize,
    /// Per task two: flags, turn.
    task_base: usize,
    /// Per automaton two: mode, state.
    automaton_base: usize,
    /// Per component six; the third is the service being handled plus one, the fifth is its client plus one.
    component_base: usize,
    /// Per client two: position, outstanding.
    client_base: Vec<usize>,
    /// Length, then tasks.
    queue_base: usize,
    /// Length, then executors; only with FIFO locks.
    pub(crate) lock_queue_base: Option<usize>,
    /// Visits of states in the current turn, for automata with a loop limit.
    pub(crate) visits: Vec<Option<usize>>,
    /// Number of states of each automaton with a loop limit, 0 of the others.
    counted: Vec<usize>,
    /// Number of trackers of each client.
    trackers: Vec<usize>,
    slack_base: Option<usize>,
}

impl Deref for Layout {
    type Target = Frame;

    #[inline]
    fn deref(&self) -> &Frame {
        &self.frame
    }
}

impl Layout {
    /// Returns the layout for a system with these clocks.
    pub(crate) fn new(system: &TimedSystem, clocks: &Clocks) -> Layout {
        let mut places = Places::default();
        let task_base = places.discrete(2 * system.tasks.len());
        let executors = system.automata.len() + system.components.len() + system.clients.len();
        places.executors(executors);
        let automaton_base = places.discrete(2 * system.automata.len());
        let component_base = places.discrete(6 * system.components.len());
        let client_base = system
            .clients
            .iter()
            .map(|client| places.discrete(2 + client.trackers))
            .collect();
        let queue_base = places.discrete(1 + system.tasks.len());
        let lock_queue_base = (system.platform.locks == crate::system::LockOrder::Fifo)
            .then(|| places.discrete(1 + executors));
        let visits = (0..system.automata.len())
            .map(|a| {
                let machine = system.machine_of(a);
                machine
                    .loop_limit
                    .map(|_| places.discrete(machine.states.len()))
            })
            .collect();
        let counted = (0..system.automata.len())
            .map(|a| system.machine_of(a))
            .map(|number| number.loop_limit.map_or(0, |_| number.states.len()))
            .collect();
        // Timers, at 0.
        places.times(system.tasks.len());
        let edf = system.platform.cores.is_some() && system.platform.policy == Policy::Edf;
        let slack_base = edf.then(|| places.times(system.tasks.len()));
        Layout {
            frame: places.frame(clocks),
            tasks: system.tasks.len(),
            automata: system.automata.len(),
            components: system.components.len(),
            task_base,
            automaton_base,
            component_base,
            client_base,
            queue_base,
            lock_queue_base,
            visits,
            counted,
            trackers: system
                .clients
                .iter()
                .map(|client| client.trackers)
                .collect(),
            slack_base,
        }
    }

    pub(crate) fn control_executor(&self, component: usize) -> usize {
        self.automata + component
    }

    pub(crate) fn client_executor(&self, client: usize) -> usize {
        self.automata + self.components + client
    }
}

impl Exchangeable for Published<'_> {
    fn complete(&self, parts: &mut Parts) {
        let l = &self.layout;
        parts[Part::Place] = parts[Part::Automaton].clone();
        let controls = parts[Part::Component]
            .iter()
            .map(|&component| l.control_executor(component));
        let clients = parts[Part::Client]
            .iter()
            .map(|&index| l.client_executor(index));
        let executors = parts[Part::Automaton]
            .iter()
            .copied()
            .chain(controls)
            .chain(clients);
        parts[Part::Executor] = executors.collect();
    }

    fn unit_places(&self, parts: &Parts) -> UnitPlaces {
        let l = &self.layout;
        let UnitPlaces {
            discrete: mut d,
            times: mut t,
        } = UnitPlaces::default();
        for &task in &parts[Part::Task] {
            d.extend([l.task_base + 2 * task, l.task_base + 2 * task + 1]);
            t.push(task);
            t.extend(l.slack_base.map(|base| base + task));
            t.extend(l.response[task]);
        }
        for &a in &parts[Part::Automaton] {
            d.extend([l.automaton_base + 2 * a, l.automaton_base + 2 * a + 1]);
            let visits = l.visits[a].unwrap_or(0);
            d.extend(visits..visits + l.counted[a]);
        }
        for &component in &parts[Part::Component] {
            let base = l.component_base + 6 * component;
            d.extend(base..base + 6);
        }
        for &client in &parts[Part::Client] {
            let base = l.client_base[client];
            d.extend(base..base + 2 + l.trackers[client]);
        }
        for &e in &parts[Part::Executor] {
            d.push(l.phase_place(e));
            t.extend([l.window_place(e), l.window_place(e) + 1]);
        }
        UnitPlaces {
            discrete: d,
            times: t,
        }
    }

    fn names(&self) -> Names {
        let l = &self.layout;
        let mut out = Names::default();
        for component in 0..l.components {
            let base = l.component_base + 6 * component;
            out.single.push((base + 2, Part::Service, 1));
            out.single.push((base + 4, Part::Client, 1));
        }
        for (client, &base) in l.client_base.iter().enumerate() {
            let trackers = base + 2..base + 2 + l.trackers[client];
            out.single
                .extend(trackers.map(|tracker| (tracker, Part::Place, tracker::SLOT)));
        }
        let cores = (l.queue_base, l.tasks, Part::Task);
        match self.any_order() {
            true => out.sets.push(cores),
            false => out.lists.push(cores),
        }
        let executors = l.executors();
        let locks = l.lock_queue_base;
        (out.lists).extend(locks.map(|base| (base, executors, Part::Executor)));
        out
    }

    fn restore_order(&self, s: &mut State) {
        if self.any_order() {
            list_mut(s, self.layout.queue_base).sort_unstable();
        }
    }
}

impl Published<'_> {
    /// Returns true if the order of the tasks that wait for a core is irrelevant.
    fn any_order(&self) -> bool {
        self.system.platform.policy == Policy::Any
    }
}

/// Named access to the numbers.
macro_rules! fields {
    ($($(#[$doc:meta])* $get:ident $set:ident ($self:ident, $i:ident) $at:expr;)*) => {
        impl Layout {
            $(
                $(#[$doc])*
                #[inline]
                pub(crate) fn $get(&$self, s: &State, $i: usize) -> u16 { s.d[$at] }
                #[inline]
                #[allow(dead_code, reason = "some are only read")]
                pub(crate) fn $set(&$self, s: &mut State, $i: usize, value: u16) { s.d[$at] = value; }
            )*
        }
    };
}

fields! {
    /// 0 between turns; else 1 + position: 0 for the permanent activity, 1 + k for slot k.
    turn set_turn (self, i) self.task_base + 2 * i + 1;
    /// See [`mode`] and [`slot`].
    mode set_mode (self, i) self.automaton_base + 2 * i;
    /// Codel state in which the automaton is or resumes.
    at set_at (self, i) self.automaton_base + 2 * i + 1;
    /// Position in the component's tasks of the task being started.
    starting set_starting (self, i) self.component_base + 6 * i;
    /// See [`control`].
    control set_control (self, i) self.component_base + 6 * i + 1;
    /// Simple codel of the service being executed.
    simple set_simple (self, i) self.component_base + 6 * i + 3;
    /// An end of activity is signalled.
    signal set_signal (self, i) self.component_base + 6 * i + 5;
    /// Step of a client.
    position set_position (self, i) self.client_base[i];
    /// The client's last request is neither accepted nor refused yet.
    outstanding set_outstanding (self, i) self.client_base[i] + 1;
}

impl Layout {
    #[inline]
    pub(crate) fn status(&self, s: &State, task: usize) -> TaskStatus {
        match s.d[self.task_base + 2 * task] & 3 {
            0 => TaskStatus::Idle,
            1 => TaskStatus::Waiting,
            _ => TaskStatus::Running,
        }
    }

    #[inline]
    pub(crate) fn set_status(&self, s: &mut State, task: usize, status: TaskStatus) {
        let flags = &mut s.d[self.task_base + 2 * task];
        *flags = (*flags & !3) | status as u16;
    }

    #[inline]
    pub(crate) fn pending(&self, s: &State, task: usize) -> bool {
        s.d[self.task_base + 2 * task] & PENDING != 0
    }

    #[inline]
    pub(crate) fn set_pending(&self, s: &mut State, task: usize, on: bool) {
        let flags = &mut s.d[self.task_base + 2 * task];
        *flags = if on {
            *flags | PENDING
        } else {
            *flags & !PENDING
        };
    }

    #[inline]
    pub(crate) fn started(&self, s: &State, task: usize) -> bool {
        s.d[self.task_base + 2 * task] & STARTED != 0
    }

    pub(crate) fn set_started(&self, s: &mut State, task: usize) {
        s.d[self.task_base + 2 * task] |= STARTED;
    }

    #[inline]
    pub(crate) fn timer(&self, s: &State, task: usize) -> Ticks {
        s.t[task]
    }

    #[inline]
    pub(crate) fn set_timer(&self, s: &mut State, task: usize, value: Ticks) {
        s.t[task] = value;
    }

    /// Returns the time to the deadline of a waiting task (EDF), at least 0, in base units.
    #[inline]
    pub(crate) fn slack(&self, s: &State, task: usize) -> Ticks {
        self.slack_base.map_or(0, |base| s.t[base + task])
    }

    #[inline]
    pub(crate) fn set_slack(&self, s: &mut State, task: usize, value: Ticks) {
        if let Some(base) = self.slack_base {
            s.t[base + task] = value;
        }
    }

    #[inline]
    pub(crate) fn has_slack(&self) -> bool {
        self.slack_base.is_some()
    }

    #[inline]
    pub(crate) fn tracker(&self, s: &State, client: usize, tracker: usize) -> u16 {
        s.d[self.client_base[client] + 2 + tracker]
    }

    #[inline]
    pub(crate) fn set_tracker(&self, s: &mut State, client: usize, tracker: usize, value: u16) {
        s.d[self.client_base[client] + 2 + tracker] = value;
    }

    pub(crate) fn trackers<'s>(&self, s: &'s State, client: usize) -> &'s [u16] {
        let base = self.client_base[client] + 2;
        &s.d[base..base + self.trackers[client]]
    }

    /// Returns the service and the client of the request that a control task handles, if it handles one.
    #[inline]
    pub(crate) fn request(&self, s: &State, component: usize) -> Option<(usize, usize)> {
        let base = self.component_base + 6 * component;
        let named = |place: usize| (s.d[place] as usize).checked_sub(1);
        named(base + 2).zip(named(base + 4))
    }

    /// Sets the service and the client of the request that a control task handles.
    pub(crate) fn set_request(
        &self,
        s: &mut State,
        component: usize,
        request: Option<(usize, usize)>,
    ) {
        let base = self.component_base + 6 * component;
        let number = |optional: Option<usize>| optional.map_or(0, |number| number as u16 + 1);
        s.d[base + 2] = number(request.map(|request| request.0));
        s.d[base + 4] = number(request.map(|request| request.1));
    }

    /// Returns the tasks that wait for a core, in the order in which they get one.
    #[inline]
    pub(crate) fn queue<'s>(&self, s: &'s State) -> &'s [u16] {
        list(s, self.queue_base)
    }

    pub(crate) fn queue_insert(&self, s: &mut State, position: usize, task: u16) {
        list_insert(s, self.queue_base, position, task);
    }

    pub(crate) fn queue_remove(&self, s: &mut State, position: usize) {
        list_remove(s, self.queue_base, position);
    }

    /// Returns the executors that wait for locks in order of arrival; empty with free locks.
    pub(crate) fn lock_queue<'s>(&self, s: &'s State) -> &'s [u16] {
        self.lock_queue_base.map_or(&[], |base| list(s, base))
    }

    pub(crate) fn lock_queue_push(&self, s: &mut State, executor: usize) {
        if let Some(base) = self.lock_queue_base {
            let end = s.d[base] as usize;
            list_insert(s, base, end, executor as u16);
        }
    }

    pub(crate) fn lock_queue_remove(&self, s: &mut State, executor: usize) {
        if let Some(base) = self.lock_queue_base
            && let Some(at) = list(s, base)
                .iter()
                .position(|&number| number as usize == executor)
        {
            list_remove(s, base, at);
        }
    }
}

fn list(s: &State, base: usize) -> &[u16] {
    &s.d[base + 1..base + 1 + s.d[base] as usize]
}

fn list_mut(s: &mut State, base: usize) -> &mut [u16] {
    let end = base + 1 + s.d[base] as usize;
    &mut s.d[base + 1..end]
}

fn list_insert(s: &mut State, base: usize, position: usize, value: u16) {
    let len = s.d[base] as usize;
    s.d[base] += 1;
    for i in (position..len).rev() {
        s.d[base + 2 + i] = s.d[base + 1 + i];
    }
    s.d[base + 1 + position] = value;
}

fn list_remove(s: &mut State, base: usize, position: usize) {
    let len = s.d[base] as usize;
    s.d[base] -= 1;
    for i in position + 1..len {
        s.d[base + i] = s.d[base + 1 + i];
    }
    s.d[base + len] = 0;
}
