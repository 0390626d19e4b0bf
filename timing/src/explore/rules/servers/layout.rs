//! The places of the servers in a [`State`].

use std::ops::Deref;

use super::Servers;
use crate::explore::rules::{Exchangeable, Names, Part, Parts, UnitPlaces};
use crate::explore::state::{Clocks, Frame, Places, State};
use crate::scn::semantics::{LockRule, Semantics};
use crate::system::{Builtin, Client, ClientAction, Policy, Ticks, TimedSystem};

/// The position of a task's thread.
pub(super) mod thread {
    /// Not started.
    pub(in super::super) const OFF: u16 = 0;
    /// Between cycles.
    pub(in super::super) const IDLE: u16 = 1;
    /// Has cleared its flag and waits for a core.
    pub(in super::super) const WAITING: u16 = 2;
    /// Before the next pass of its cycle.
    pub(in super::super) const AGAIN: u16 = 3;
    /// Before it takes a ticket for the next codel of its pass.
    pub(in super::super) const TICKET: u16 = 4;
    /// Waits in the lock queue.
    pub(in super::super) const QUEUED: u16 = 5;
    /// Executes a codel.
    pub(in super::super) const EXECUTING: u16 = 6;
    /// Has ended with its component.
    pub(in super::super) const ENDED: u16 = 7;
}

/// Flags of a task.
pub(super) mod flag {
    /// A tick has come since the last cycle began.
    pub(in super::super) const TICK: u16 = 1;
    /// Paused automata must be resumed (aperiodic tasks).
    pub(in super::super) const RUNNABLE: u16 = 2;
    /// The other tasks must be woken before any other action.
    pub(in super::super) const WAKE: u16 = 4;
    /// The first cycle is not over.
    pub(in super::super) const FIRST: u16 = 8;
    /// In this pass some automaton continues without a pause.
    pub(in super::super) const GOES_ON: u16 = 16;
    /// In this pass an activity has ended, and must be signalled.
    pub(in super::super) const ENDED: u16 = 32;
    /// In this pass there was an event.
    pub(in super::super) const EVENT: u16 = 64;
    /// A tick has come while another one waited for a core: its deadline is missed, although no cycle has
    /// begun.
    pub(in super::super) const LATE: u16 = 128;
    /// The task holds a core: from the grant until its thread has made the wake-ups after its last pass.
    pub(in super::super) const CORE: u16 = 256;
    /// Flags of a pass.
    pub(in super::super) const OF_PASS: u16 = GOES_ON | ENDED | EVENT;
}

/// Status of an activity, and its flags.
pub(super) mod slot {
    pub(in super::super) const VOID: u16 = 0;
    /// Accepted, has not begun.
    pub(in super::super) const INIT: u16 = 1;
    pub(in super::super) const RUN: u16 = 2;
    pub(in super::super) const STOP: u16 = 3;
    /// Ended, not reported.
    pub(in super::super) const ETHER: u16 = 4;
    /// Mask of the status.
    pub(in super::super) const STATUS: u16 = 7;
    /// Released: it may begin.
    pub(in super::super) const START: u16 = 8;
    /// Interrupted, and has not noticed yet.
    pub(in super::super) const MARK: u16 = 16;
    pub(in super::super) const PAUSED: u16 = 32;
    /// Ended without exception.
    pub(in super::super) const SUCCESS: u16 = 64;
    /// The permanent activity.
    pub(in super::super) const PERMANENT: u16 = 128;
}

/// Steps of a control task.
pub(super) mod control {
    /// Its component is starting, or has failed to, or has ended.
    pub(in super::super) const OFF: u16 = 0;
    pub(in super::super) const READY: u16 = 1;
    /// Before it takes a ticket.
    pub(in super::super) const TICKET: u16 = 2;
    pub(in super::super) const QUEUED: u16 = 3;
    pub(in super::super) const EXECUTING: u16 = 4;
    /// Codels are done: before the reply and the examination of all activities.
    pub(in super::super) const REST: u16 = 5;
}

/// Values of trackers other than "slot" (which is [`tracker::SLOT`] plus its number among all).
pub(super) mod tracker {
    pub(in super::super) const NONE: u16 = 0;
    /// Sent, not accepted yet.
    pub(in super::super) const HANDLED: u16 = 1;
    /// The request has ended without success; only if a client depends on the outcome.
    pub(in super::super) const FAILED: u16 = 2;
    pub(in super::super) const SLOT: u16 = 3;
}

/// Numbers per slot.
const OF_SLOT: usize = 3;

/// Numbers per component.
const OF_COMPONENT: usize = 8;

impl Exchangeable for Servers<'_> {
    fn complete(&self, parts: &mut Parts) {
        let l = &self.layout;
        parts[Part::Place] = (parts[Part::Task].iter())
            .flat_map(|&task| l.slots(task))
            .collect();
        let controls = parts[Part::Component]
            .iter()
            .map(|&component| l.control_executor(component));
        let clients = parts[Part::Client]
            .iter()
            .map(|&index| l.client_executor(index));
        let executors = parts[Part::Task]
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
            let base = l.task_base + 3 * task;
            d.extend(base..base + 3);
            t.push(task);
            t.extend(
                l.ages
                    .iter()
                    .flat_map(|base| [base + task, base + l.tasks + task]),
            );
            t.extend(l.response[task].into_iter().chain(l.kept(task)));
        }
        for &slot in &parts[Part::Place] {
            let base = l.slot_base + OF_SLOT * slot;
            d.extend(base..base + OF_SLOT);
            let (visits, most) = l.visits[slot];
            d.extend(visits..visits + most);
        }
        d.extend(
            parts[Part::Service]
                .iter()
                .filter_map(|&index| l.success[index]),
        );
        for &component in &parts[Part::Component] {
            let base = l.component_base + OF_COMPONENT * component;
            d.extend(base..base + OF_COMPONENT);
            let tasks = self.system.components[component].tasks.len();
            d.extend(
                l.lock_queue[component]
                    .into_iter()
                    .flat_map(|base| base..base + 2 + tasks),
            );
            d.extend(l.shutdown[component]);
        }
        for &client in &parts[Part::Client] {
            let base = l.client_base[client];
            d.extend(base..base + 2 + self.system.clients[client].trackers);
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
        for slot in 0..l.visits.len() {
            out.single
                .push((l.slot_base + OF_SLOT * slot + 1, Part::Automaton, 1));
        }
        for component in 0..l.components {
            let base = l.component_base + OF_COMPONENT * component;
            out.single.push((base + 2, Part::Service, 1));
            out.single.push((base + 4, Part::Client, 1));
            out.single.push((base + 5, Part::Place, 1));
        }
        for (client, &base) in l.client_base.iter().enumerate() {
            let trackers = base + 2..base + 2 + self.system.clients[client].trackers;
            out.single
                .extend(trackers.map(|tracker| (tracker, Part::Place, tracker::SLOT)));
        }
        for (component, base) in l.lock_queue.iter().enumerate() {
            let capacity = 1 + self.system.components[component].tasks.len();
            (out.lists).extend(base.map(|base| (base, capacity, Part::Executor)));
        }
        let cores = l
            .core_queue
            .map(|base| (base, l.tasks + l.components, Part::Executor));
        match self.system.platform.policy {
            Policy::Any => out.sets.extend(cores),
            _ => out.lists.extend(cores),
        }
        out
    }

    fn restore_order(&self, s: &mut State) {
        if let (Some(base), Policy::Any) = (self.layout.core_queue, self.system.platform.policy) {
            let length = s.d[base] as usize;
            s.d[base + 1..=base + length].sort_unstable();
        }
    }
}

/// The places in a state. The [`Frame`] has those common to all rules.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    frame: Frame,
    pub(super) tasks: usize,
    pub(super) components: usize,
    /// Per task three: thread, flags, slot of its pass among its own.
    task_base: usize,
    /// First slot of each task, among all; then the number of slots.
    pub(super) first_slot: Vec<usize>,
    slot_base: usize,
    /// For each slot, the first place and number of its counters of entered states.
    pub(super) visits: Vec<(usize, usize)>,
    component_base: usize,
    client_base: Vec<usize>,
    core_queue: Option<usize>,
    /// Length, then executors, of each component.
    lock_queue: Vec<Option<usize>>,
    /// Place of the shutdown stage of each component that a client may kill; 0: not killed.
    pub(super) shutdown: Vec<Option<usize>>,
    /// Clients for which the step that sent a request matters.
    pub(super) follows: Vec<bool>,
    /// By client and tracker, whether the outcome of a request matters.
    pub(super) outcomes: Vec<Vec<bool>>,
    /// Place of the success of each service, if it matters.
    pub(super) success: Vec<Option<usize>>,
    /// Places of the time since the tick of a waiting task, then since its kept tick, for each task; with
    /// EDF.
    pub(super) ages: Option<usize>,
    /// Clock of the time since a tick that is kept during a cycle.
    kept: Vec<Option<usize>>,
}

impl Deref for Layout {
    type Target = Frame;

    fn deref(&self) -> &Frame {
        &self.frame
    }
}

impl Layout {
    pub(super) fn new(system: &TimedSystem, semantics: Semantics, clocks: &Clocks) -> Layout {
        let mut places = Places::default();
        let tasks = system.tasks.len();
        let components = system.components.len();
        let task_base = places.discrete(3 * tasks);
        places.executors(tasks + components + system.clients.len());
        let mut first_slot = vec![0];
        for task in 0..tasks {
            first_slot.push(first_slot[task] + most_slots(system, task));
        }
        let slots = first_slot[tasks];
        let slot_base = places.discrete(OF_SLOT * slots);
        let mut visits = Vec::new();
        for task in 0..tasks {
            let definition = &system.tasks[task];
            let automata = definition.permanent.iter().chain(&definition.slots);
            let counted = automata.map(|&a| system.machine_of(a));
            let counted = counted.filter(|machine| machine.loop_limit.is_some());
            let most = counted
                .map(|machine| machine.states.len())
                .max()
                .unwrap_or(0);
            for _ in first_slot[task]..first_slot[task + 1] {
                visits.push((places.discrete(most), most));
            }
        }
        let component_base = places.discrete(OF_COMPONENT * components);
        let client_base = (system.clients.iter())
            .map(|client| places.discrete(2 + client.trackers))
            .collect();
        let core_queue = (system.platform.cores).map(|_| places.discrete(1 + tasks + components));
        let lock_queue = (system.components.iter())
            .map(|component| {
                let queued = semantics.locks != LockRule::Free;
                queued.then(|| places.discrete(2 + component.tasks.len()))
            })
            .collect();
        let requested = system.requested();
        let success = (0..system.services.len())
            .map(|service| {
                let lists = system.services.iter().zip(&requested);
                let mut lists = lists.filter(|pair| *pair.1).map(|pair| pair.0);
                let matters = lists
                    .any(|other| other.after.contains(&service) || other.before.contains(&service));
                (matters && requested[service]).then(|| places.discrete(1))
            })
            .collect();
        let shutdown = (system.components.iter())
            .map(|component| {
                let kill = |&of: &usize| system.services[of].builtin == Some(Builtin::Kill);
                component
                    .services
                    .iter()
                    .any(kill)
                    .then(|| places.discrete(1))
            })
            .collect();
        let timers = places.times(tasks);
        debug_assert_eq!(timers, 0, "timers come first");
        let edf = system.platform.cores.is_some() && system.platform.policy == Policy::Edf;
        let ages = edf.then(|| places.times(2 * tasks));
        let measured = clocks.response.iter().filter(|response| **response).count();
        let (frame, first_kept) = places.frame_with(clocks, measured);
        let mut next = first_kept;
        let kept = (clocks.response.iter())
            .map(|&measured| {
                measured.then(|| {
                    next += 1;
                    next - 1
                })
            })
            .collect();
        Layout {
            frame,
            tasks,
            components,
            task_base,
            first_slot,
            slot_base,
            visits,
            component_base,
            client_base,
            core_queue,
            lock_queue,
            shutdown,
            follows: system.clients.iter().map(follows).collect(),
            outcomes: (system.clients.iter())
                .map(|client| {
                    (0..client.trackers)
                        .map(|t| client.asks_outcome(t))
                        .collect()
                })
                .collect(),
            success,
            ages,
            kept,
        }
    }

    /// Returns the numbers of the slots of a task, among all.
    pub(super) fn slots(&self, task: usize) -> std::ops::Range<usize> {
        self.first_slot[task]..self.first_slot[task + 1]
    }

    /// Returns the slot whose codel a task executes, among all; only while there is one.
    pub(super) fn turn(&self, s: &State, task: usize) -> usize {
        self.first_slot[task] + s.d[self.task_base + 3 * task + 2] as usize
    }

    /// Sets the slot whose codel a task executes; its first slot if there is none.
    pub(super) fn set_turn(&self, s: &mut State, task: usize, slot: usize) {
        s.d[self.task_base + 3 * task + 2] = (slot - self.first_slot[task]) as u16;
    }

    /// Returns the service that a control task handles, if it handles one.
    pub(super) fn handled(&self, s: &State, component: usize) -> Option<usize> {
        (self.handled_number(s, component) as usize).checked_sub(1)
    }

    pub(super) fn control_executor(&self, component: usize) -> usize {
        self.tasks + component
    }

    pub(super) fn client_executor(&self, client: usize) -> usize {
        self.tasks + self.components + client
    }

    pub(super) fn tracker(&self, s: &State, client: usize, tracker: usize) -> u16 {
        s.d[self.client_base[client] + 2 + tracker]
    }

    pub(super) fn set_tracker(&self, s: &mut State, client: usize, tracker: usize, value: u16) {
        s.d[self.client_base[client] + 2 + tracker] = value;
    }

    pub(super) fn timer(&self, s: &State, task: usize) -> Ticks {
        s.t[task]
    }

    pub(super) fn set_timer(&self, s: &mut State, task: usize, value: Ticks) {
        s.t[task] = value;
    }

    /// Returns the clock of a kept tick, if the task is measured.
    pub(super) fn kept(&self, task: usize) -> Option<usize> {
        self.kept.get(task).copied().flatten()
    }

    /// Returns true if a task has a flag.
    pub(super) fn has(&self, s: &State, task: usize, flag: u16) -> bool {
        self.flags(s, task) & flag != 0
    }

    pub(super) fn raise(&self, s: &mut State, task: usize, flag: u16) {
        let flags = self.flags(s, task);
        self.set_flags(s, task, flags | flag);
    }

    pub(super) fn lower(&self, s: &mut State, task: usize, flag: u16) {
        let flags = self.flags(s, task);
        self.set_flags(s, task, flags & !flag);
    }

    /// Returns the status of a slot.
    pub(super) fn status(&self, s: &State, slot: usize) -> u16 {
        self.mode(s, slot) & slot::STATUS
    }

    /// Returns the tasks that wait for a core, in order.
    pub(super) fn core_queue<'s>(&self, s: &'s State) -> &'s [u16] {
        self.core_queue.map_or(&[], |base| list(s, base))
    }

    pub(super) fn core_queue_push(&self, s: &mut State, task: usize, sorted: bool) {
        let base = self
            .core_queue
            .expect("tasks wait only for cores that are limited");
        push(s, base, task as u16, sorted);
    }

    pub(super) fn core_queue_remove(&self, s: &mut State, task: usize) {
        if let Some(base) = self.core_queue {
            remove(s, base, task as u16);
        }
    }

    /// Returns the executors that wait in the lock queue of a component, in order.
    pub(super) fn lock_queue<'s>(&self, s: &'s State, component: usize) -> &'s [u16] {
        self.lock_queue[component].map_or(&[], |base| list(s, base))
    }

    pub(super) fn lock_queue_push(&self, s: &mut State, component: usize, executor: usize) {
        if let Some(base) = self.lock_queue[component] {
            push(s, base, executor as u16, false);
        }
    }

    pub(super) fn lock_queue_remove(&self, s: &mut State, component: usize, executor: usize) {
        if let Some(base) = self.lock_queue[component] {
            remove(s, base, executor as u16);
        }
    }
}

/// Returns true if a client can abort instances that it has requested.
fn follows(client: &Client) -> bool {
    client.steps.iter().any(|step| match &step.action {
        ClientAction::Send {
            accepted, aborts, ..
        } => aborts.is_some() || !accepted.is_empty(),
        _ => false,
    })
}

/// Returns the greatest number of activities of a task at the same time: at most its places, and at most the
/// requests.
fn most_slots(system: &TimedSystem, task: usize) -> usize {
    let places = system.tasks[task].places as usize;
    let of_task = |service: usize| {
        let mut slots = system.services[service].slots.iter();
        slots.any(|&a| system.automata[a].task == task)
    };
    let mut most = 1;
    for client in &system.clients {
        for (at, step) in client.steps.iter().enumerate() {
            let ClientAction::Send { service, .. } = step.action else {
                continue;
            };
            if of_task(service) {
                if client.comes_again(at) {
                    return places;
                }
                most += 1;
            }
        }
    }
    most.min(places)
}

fn list(s: &State, base: usize) -> &[u16] {
    &s.d[base + 1..base + 1 + s.d[base] as usize]
}

/// Adds to a list, at its end or in order of number.
fn push(s: &mut State, base: usize, number: u16, sorted: bool) {
    let length = s.d[base] as usize;
    let at = match sorted {
        true => list(s, base).partition_point(|&other| other < number),
        false => length,
    };
    s.d[base + 1..=base + 1 + length][at..].rotate_right(1);
    s.d[base + 1 + at] = number;
    s.d[base] += 1;
}

fn remove(s: &mut State, base: usize, number: u16) {
    let length = s.d[base] as usize;
    let Some(at) = list(s, base).iter().position(|&other| other == number) else {
        return;
    };
    s.d[base + 1..base + 1 + length][at..].rotate_left(1);
    s.d[base + length] = 0;
    s.d[base] -= 1;
}

/// Named access to the numbers.
macro_rules! fields {
    ($($(#[$doc:meta])* $get:ident $set:ident ($self:ident, $i:ident) $at:expr;)*) => {
        impl Layout {
            $(
                $(#[$doc])*
                #[inline]
                pub(super) fn $get(&$self, s: &State, $i: usize) -> u16 { s.d[$at] }
                #[inline]
                pub(super) fn $set(&$self, s: &mut State, $i: usize, value: u16) { s.d[$at] = value; }
            )*
        }
    };
}

fields! {
    /// Position of the thread, see [`thread`].
    thread_of set_thread (self, task) self.task_base + 3 * task;
    /// See [`flag`].
    flags set_flags (self, task) self.task_base + 3 * task + 1;
    /// See [`slot`].
    mode set_mode (self, slot) self.slot_base + OF_SLOT * slot;
    /// Automaton, plus one; 0 for a permanent activity without codels.
    automaton set_automaton (self, slot) self.slot_base + OF_SLOT * slot + 1;
    /// State of its machine; the number of states for the default `stop`.
    at set_at (self, slot) self.slot_base + OF_SLOT * slot + 2;
    /// Number of the task being started, among the tasks of the component.
    starting set_starting (self, component) self.component_base + OF_COMPONENT * component;
    /// See [`control`].
    control set_control (self, component) self.component_base + OF_COMPONENT * component + 1;
    /// Service being handled, plus one.
    handled_number set_handled_number (self, component) self.component_base + OF_COMPONENT * component + 2;
    /// Number of its control codel.
    codel_number set_codel_number (self, component) self.component_base + OF_COMPONENT * component + 3;
    /// Client that sent the request, plus one.
    sender set_sender (self, component) self.component_base + OF_COMPONENT * component + 4;
    /// Slot of the request, plus one.
    given set_given (self, component) self.component_base + OF_COMPONENT * component + 5;
    /// The request is refused.
    refused set_refused (self, component) self.component_base + OF_COMPONENT * component + 6;
    /// The end of some activity was signalled.
    signal set_signal (self, component) self.component_base + OF_COMPONENT * component + 7;
    /// Step of a client; one past the end: before the first.
    position set_position (self, client) self.client_base[client];
    /// Request of the client without an answer: 0 for none. If the sending step matters, the number of the
    /// step plus one.
    outstanding set_outstanding (self, client) self.client_base[client] + 1;
}
