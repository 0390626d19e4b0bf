//! The places of the rules in a [`State`].

use std::ops::Deref;

use typed_index_collections::{TiVec, ti_vec};

use super::points::{Cycle, Points};
use super::status::{flag, slot, thread};
use crate::explore::state::{Clocks, Frame, Places, State, TaskStatus};
use crate::scn::semantics::LockRule;
use crate::system::{
    AutomatonId, Builtin, Client, ClientAction, ClientId, ComponentId, Policy, ServiceId, TaskId,
    Ticks, TimedSystem,
};

/// Numbers per task.
pub(super) const OF_TASK: usize = 3;

/// Numbers per component.
pub(super) const OF_COMPONENT: usize = 8;

/// The places in a state. The [`Frame`] has those common to all rules.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    frame: Frame,
    /// Number of executors of state machines: tasks or, with jobs, automata. Control tasks and clients
    /// follow.
    pub(crate) threads: usize,
    pub(crate) tasks: usize,
    pub(crate) components: usize,
    /// Thread, flags, turn.
    pub(super) task_base: usize,
    /// Slots of each task, in slot order, numbered among all. With jobs, slots are automata.
    slots: Vec<Vec<usize>>,
    pub(super) slot_base: usize,
    /// Numbers per slot.
    pub(super) of_slot: usize,
    /// For each slot, the first place and number of its counters of entered states.
    pub(crate) visits: Vec<(usize, usize)>,
    pub(super) component_base: usize,
    pub(super) client_base: TiVec<ClientId, usize>,
    /// Length, then executors, at most this many.
    pub(super) core_queue: Option<(usize, usize)>,
    /// Length, then executors, of each component. With jobs, all components share one queue.
    pub(super) lock_queue: TiVec<ComponentId, Option<usize>>,
    /// Place of the shutdown stage of each component that a client, or the end of a run, may kill; 0: not
    /// killed.
    pub(super) shutdown: TiVec<ComponentId, Option<usize>>,
    /// Clients for which the step that sent a request matters.
    pub(super) follows: TiVec<ClientId, bool>,
    /// By client and tracker, whether the outcome of a request matters.
    pub(super) outcomes: TiVec<ClientId, Vec<bool>>,
    /// Place of the success of each service, if it matters.
    pub(super) success: TiVec<ServiceId, Option<usize>>,
    /// Places of the times that decide about cores under EDF.
    pub(super) edf: Option<EdfTimes>,
    /// Clock of the time since a tick that is kept during a cycle.
    pub(super) kept: Vec<Option<usize>>,
}

/// The times that decide about cores under EDF. Deadlines count from ticks in passes, and from releases in
/// jobs.
#[derive(Debug, Clone, Copy)]
pub(super) enum EdfTimes {
    /// First place of the time since the tick of each waiting task, and of the time since its kept tick.
    Ages {
        /// Since the tick of a waiting task.
        tick: usize,
        /// Since a tick that is kept.
        kept: usize,
    },
    /// First place of the time to the deadline of each waiting task, at least 0. The queue is in this order.
    Slack(usize),
}

impl Deref for Layout {
    type Target = Frame;

    #[inline]
    fn deref(&self) -> &Frame {
        &self.frame
    }
}

impl Layout {
    pub(super) fn new(system: &TimedSystem, points: &Points, clocks: &Clocks) -> Layout {
        let jobs = points.cycle == Cycle::Jobs;
        let mut places = Places::default();
        let tasks = system.tasks.len();
        let components = system.components.len();
        let threads = if jobs { system.automata.len() } else { tasks };
        let task_base = places.discrete(OF_TASK * tasks);
        let executors = threads + components + system.clients.len();
        places.executors(executors);
        let slots = slots(system, jobs);
        let of_slot = if jobs { 2 } else { 3 };
        let slot_base = places.discrete(of_slot * slots.iter().map(Vec::len).sum::<usize>());
        let visits = visits(system, &slots, jobs, &mut places);
        let component_base = places.discrete(OF_COMPONENT * components);
        let client_base =
            (system.clients.iter()).map(|client| places.discrete(2 + client.trackers)).collect();
        let capacity = if system.preempts() { tasks + components } else { tasks };
        let core_queue = (system.platform.cores).map(|_| (places.discrete(1 + capacity), capacity));
        let lock_queue = if points.locks == LockRule::Free {
            ti_vec![None; components]
        } else if jobs {
            ti_vec![Some(places.discrete(1 + executors)); components]
        } else {
            let queue = |tasks: usize| Some(places.discrete(2 + tasks));
            let tasks = system.components.iter().map(|component| component.tasks.len());
            tasks.map(queue).collect()
        };
        let success = success(system, jobs, &mut places);
        let shutdown = (system.components.iter())
            .map(|component| {
                let kill = |&of: &ServiceId| system.services[of].builtin == Some(Builtin::Kill);
                let ends = clocks.ends && !jobs || component.services.iter().any(kill);
                ends.then(|| places.discrete(1))
            })
            .collect();
        let timers = places.times(tasks);
        debug_assert_eq!(timers, 0, "timers come first");
        let by_deadline = system.platform.cores.is_some() && system.platform.policy == Policy::Edf;
        let edf = by_deadline.then(|| {
            if jobs {
                EdfTimes::Slack(places.times(tasks))
            } else {
                EdfTimes::Ages { tick: places.times(tasks), kept: places.times(tasks) }
            }
        });
        let measured = clocks.response.iter().map(|&measured| measured && !jobs);
        let (frame, first_kept) =
            places.frame(clocks, measured.clone().filter(|response| *response).count());
        let mut kept_places = first_kept..;
        Layout {
            frame,
            threads,
            tasks,
            components,
            task_base,
            slots,
            slot_base,
            of_slot,
            visits,
            component_base,
            client_base,
            core_queue,
            lock_queue,
            shutdown,
            follows: (system.clients.iter()).map(|client| !jobs && follows(client)).collect(),
            outcomes: (system.clients.iter())
                .map(|client| (0..client.trackers).map(|t| client.asks_outcome(t)).collect())
                .collect(),
            success,
            edf,
            kept: measured.map(|measured| measured.then(|| kept_places.next()).flatten()).collect(),
        }
    }

    /// Returns the numbers of the slots of a task, among all, in slot order.
    #[inline]
    pub(crate) fn slots(&self, task: usize) -> &[usize] {
        &self.slots[task]
    }

    /// Returns the number of slots of all tasks.
    pub(crate) fn all_slots(&self) -> usize {
        self.visits.len()
    }

    /// Returns the slot of a task, if any, whose codel the task executes: with passes, only while there is
    /// one.
    #[inline]
    pub(crate) fn turn(&self, s: &State, task: usize) -> Option<usize> {
        let turn = self.turn_number(s, task) as usize;
        turn.checked_sub(1).map(|place| self.slots[task][place])
    }

    /// Returns the automaton of a slot; `None` for a permanent activity without codels, or a free slot.
    #[inline]
    pub(crate) fn automaton(&self, s: &State, slot: usize) -> Option<AutomatonId> {
        if self.of_slot == 2 {
            Some(self.automaton_numbered(slot))
        } else {
            let number = (s.d[self.slot_base + 3 * slot + 2] as usize).checked_sub(1);
            number.map(AutomatonId::from)
        }
    }

    pub(super) fn set_automaton(&self, s: &mut State, slot: usize, automaton: Option<AutomatonId>) {
        if self.of_slot == 3 {
            let number = automaton.map_or(0, |automaton| usize::from(automaton) as u16 + 1);
            s.d[self.slot_base + 3 * slot + 2] = number;
        }
    }

    /// Returns the number of an automaton among slots and among executors (jobs).
    #[inline]
    pub(crate) fn number_of(&self, automaton: AutomatonId) -> usize {
        debug_assert_eq!(self.of_slot, 2, "slots are automata only with jobs");
        usize::from(automaton)
    }

    /// Returns the automaton with a number among slots or among executors (jobs). Control tasks and clients
    /// have numbers after the last automaton.
    #[inline]
    pub(crate) fn automaton_numbered(&self, number: usize) -> AutomatonId {
        debug_assert_eq!(self.of_slot, 2, "slots are automata only with jobs");
        AutomatonId::from(number)
    }

    /// Returns the place of the numbers of a component.
    #[inline]
    pub(super) fn component_place(&self, component: ComponentId) -> usize {
        self.component_base + OF_COMPONENT * usize::from(component)
    }

    /// Returns the service that a control task handles, if it handles one.
    #[inline]
    pub(crate) fn handled(&self, s: &State, component: ComponentId) -> Option<ServiceId> {
        let number = (self.handled_number(s, component) as usize).checked_sub(1);
        number.map(ServiceId::from)
    }

    /// Returns the client that sent the request that a control task handles, if it handles one.
    #[inline]
    pub(crate) fn sender(&self, s: &State, component: ComponentId) -> Option<ClientId> {
        let number = (self.sender_number(s, component) as usize).checked_sub(1);
        number.map(ClientId::from)
    }

    pub(crate) fn control_executor(&self, component: ComponentId) -> usize {
        self.threads + usize::from(component)
    }

    pub(crate) fn client_executor(&self, client: ClientId) -> usize {
        self.threads + self.components + usize::from(client)
    }

    /// Returns the client that is an executor, if it is one.
    #[inline]
    pub(crate) fn client_of_executor(&self, executor: usize) -> Option<ClientId> {
        let number = executor.checked_sub(self.threads + self.components);
        number.map(ClientId::from)
    }

    #[inline]
    pub(crate) fn tracker(&self, s: &State, client: ClientId, tracker: usize) -> u16 {
        s.d[self.client_base[client] + 2 + tracker]
    }

    #[inline]
    pub(super) fn set_tracker(&self, s: &mut State, client: ClientId, tracker: usize, value: u16) {
        s.d[self.client_base[client] + 2 + tracker] = value;
    }

    /// Returns the time to the next tick of a task, in base units.
    #[inline]
    pub(crate) fn timer(&self, s: &State, task: usize) -> Ticks {
        s.t[task]
    }

    #[inline]
    pub(super) fn set_timer(&self, s: &mut State, task: usize, value: Ticks) {
        s.t[task] = value;
    }

    /// Returns the clock of a kept tick, if the task is measured.
    #[inline]
    pub(super) fn kept(&self, task: usize) -> Option<usize> {
        self.kept.get(task).copied().flatten()
    }

    /// Returns the flags of a task, see [`flag`].
    #[inline]
    pub(crate) fn flags(&self, s: &State, task: usize) -> u16 {
        s.d[self.task_base + OF_TASK * task + 1]
    }

    /// Returns true if a task has one of these flags.
    #[inline]
    pub(crate) fn has(&self, s: &State, task: usize, flag: u16) -> bool {
        self.flags(s, task) & flag != 0
    }

    #[inline]
    pub(super) fn raise(&self, s: &mut State, task: usize, flag: u16) {
        s.d[self.task_base + OF_TASK * task + 1] |= flag;
    }

    #[inline]
    pub(super) fn lower(&self, s: &mut State, task: usize, flag: u16) {
        s.d[self.task_base + OF_TASK * task + 1] &= !flag;
    }

    /// Returns true if a task is started.
    #[inline]
    pub(crate) fn started(&self, s: &State, task: usize) -> bool {
        self.thread_of(s, task) != thread::OFF
    }

    /// Returns true if a task has a tick that it has not taken.
    #[inline]
    pub(crate) fn pending(&self, s: &State, task: usize) -> bool {
        self.has(s, task, flag::TICK)
    }

    /// Returns the status of a task: in a cycle or not.
    #[inline]
    pub(crate) fn status(&self, s: &State, task: usize) -> TaskStatus {
        match self.thread_of(s, task) {
            thread::WAITING => TaskStatus::Waiting,
            thread::AGAIN..=thread::EXECUTING => TaskStatus::Running,
            _ => TaskStatus::Idle,
        }
    }

    /// Returns the status of an activity, see [`slot`].
    #[inline]
    pub(crate) fn activity(&self, s: &State, slot: usize) -> u16 {
        self.mode(s, slot) & slot::STATUS
    }

    /// Returns the tasks (with preemption: the threads) that wait for a core, in order.
    #[inline]
    pub(crate) fn core_queue<'s>(&self, s: &'s State) -> &'s [u16] {
        self.core_queue.map_or(&[], |(base, _)| list(s, base))
    }

    /// Adds to the queue for cores, at an index.
    pub(super) fn core_queue_insert(&self, s: &mut State, at: usize, executor: usize) {
        let (base, _) = self.core_queue.expect("tasks wait only for cores that are limited");
        insert(s, base, at, executor as u16);
    }

    /// Adds to the end of the queue for cores.
    pub(super) fn core_queue_push(&self, s: &mut State, executor: usize) {
        let end = self.core_queue(s).len();
        self.core_queue_insert(s, end, executor);
    }

    pub(super) fn core_queue_remove(&self, s: &mut State, executor: usize) {
        if let Some((base, _)) = self.core_queue {
            remove(s, base, executor as u16);
        }
    }

    /// Returns the executors that wait in the lock queue of a component, in order.
    #[inline]
    pub(crate) fn lock_queue<'s>(&self, s: &'s State, component: ComponentId) -> &'s [u16] {
        self.lock_queue[component].map_or(&[], |base| list(s, base))
    }

    pub(super) fn lock_queue_push(&self, s: &mut State, component: ComponentId, executor: usize) {
        if let Some(base) = self.lock_queue[component] {
            insert(s, base, s.d[base] as usize, executor as u16);
        }
    }

    pub(super) fn lock_queue_remove(&self, s: &mut State, component: ComponentId, executor: usize) {
        if let Some(base) = self.lock_queue[component] {
            remove(s, base, executor as u16);
        }
    }
}

/// Returns the slots of each task: with jobs its automata, else places for activities.
fn slots(system: &TimedSystem, jobs: bool) -> Vec<Vec<usize>> {
    let mut next = 0;
    let of_task = |task: usize| {
        let definition = &system.tasks[TaskId::from(task)];
        if jobs {
            let automata = definition.permanent.iter().chain(&definition.slots);
            return automata.map(|&automaton| automaton.into()).collect();
        }
        let first = next;
        next += system.most_places(TaskId::from(task));
        (first..next).collect()
    };
    (0..system.tasks.len()).map(of_task).collect()
}

/// Allocates the counters of entered states of each slot.
fn visits(
    system: &TimedSystem,
    slots: &[Vec<usize>],
    jobs: bool,
    places: &mut Places,
) -> Vec<(usize, usize)> {
    let counted = |automaton: AutomatonId| {
        let machine = system.machine_of(automaton);
        machine.loop_limit.map_or(0, |_| machine.states.len())
    };
    if jobs {
        let counters = system.automata.keys().map(counted);
        return counters.map(|most| (places.discrete(most), most)).collect();
    }
    let mut out = Vec::new();
    for (task, slots) in system.tasks.iter().zip(slots) {
        let automata = task.permanent.iter().chain(&task.slots);
        let most = automata.map(|&automaton| counted(automaton)).max();
        let most = most.unwrap_or(0);
        out.extend(slots.iter().map(|_| (places.discrete(most), most)));
    }
    out
}

/// Allocates the success of each service that a request depends on. (With jobs none does.)
fn success(
    system: &TimedSystem,
    jobs: bool,
    places: &mut Places,
) -> TiVec<ServiceId, Option<usize>> {
    let requested = system.requested();
    let mut matters = |service: ServiceId| {
        let lists = system.services.iter().zip(&requested);
        let mut lists = lists.filter(|(_, requested)| **requested);
        let named = lists
            .any(|(other, _)| other.after.contains(&service) || other.before.contains(&service));
        (!jobs && named && requested[service]).then(|| places.discrete(1))
    };
    system.services.keys().map(&mut matters).collect()
}

/// Returns true if a client can abort instances that it has requested.
fn follows(client: &Client) -> bool {
    client.steps.iter().any(|step| match &step.action {
        ClientAction::Send { accepted, aborts, .. } => aborts.is_some() || !accepted.is_empty(),
        _ => false,
    })
}

/// Returns the list at a place, which begins with its length.
pub(super) fn list(s: &State, base: usize) -> &[u16] {
    &s.d[base + 1..base + 1 + s.d[base] as usize]
}

fn insert(s: &mut State, base: usize, at: usize, number: u16) {
    let length = s.d[base] as usize;
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
    ($($(#[$doc:meta])* $get:ident $set:ident ($self:ident, $i:ident: $index:ty) $at:expr;)*) => {
        impl Layout {
            $(
                $(#[$doc])*
                #[inline]
                pub(crate) fn $get(&$self, s: &State, $i: $index) -> u16 { s.d[$at] }
                #[inline]
                pub(super) fn $set(&$self, s: &mut State, $i: $index, value: u16) { s.d[$at] = value; }
            )*
        }
    };
}

fields! {
    /// Position of the thread, see [`thread`].
    thread_of set_thread (self, task: usize) self.task_base + OF_TASK * task;
    /// Index of the slot whose turn it is, among those of the task, plus one; 0 between turns.
    turn_number set_turn_number (self, task: usize) self.task_base + OF_TASK * task + 2;
    /// See [`slot`].
    mode set_mode (self, slot: usize) self.slot_base + self.of_slot * slot;
    /// State of its machine; the number of states for the default `stop`.
    at set_at (self, slot: usize) self.slot_base + self.of_slot * slot + 1;
    /// Number of the task being started, among the tasks of the component.
    starting set_starting (self, component: ComponentId) self.component_place(component);
    /// See [`control`](super::status::control).
    control set_control (self, component: ComponentId) self.component_place(component) + 1;
    /// Service being handled, plus one.
    handled_number set_handled_number (self, component: ComponentId) self.component_place(component) + 2;
    /// Number of its control codel.
    codel_number set_codel_number (self, component: ComponentId) self.component_place(component) + 3;
    /// Client that sent the request, plus one.
    sender_number set_sender_number (self, component: ComponentId) self.component_place(component) + 4;
    /// Slot of the request, plus one.
    given set_given (self, component: ComponentId) self.component_place(component) + 5;
    /// The request is refused.
    refused set_refused (self, component: ComponentId) self.component_place(component) + 6;
    /// The end of some activity was signalled.
    signal set_signal (self, component: ComponentId) self.component_place(component) + 7;
    /// Step of a client; one past the end: before the first.
    position set_position (self, client: ClientId) self.client_base[client];
    /// Request of the client without an answer: 0 for none. If the sending step matters, the number of the
    /// step plus one.
    outstanding set_outstanding (self, client: ClientId) self.client_base[client] + 1;
}
