//! Cores granted by an operating system (section 22): preemptive policies.
//!
//! A thread is *ready* if it can act: it is neither idle nor waits in the lock queue for another thread. The
//! state lists the ready threads, in the order in which they became ready. Ready threads beyond the number of
//! cores neither act nor execute, and the rest of their codels remains. A codel at its end does end, whatever
//! thread becomes ready at that moment.
//!
//! * `priority`: at each moment the ready threads of highest priority have the cores; ties in order of the
//!   list. A control task has the highest priority of its component.
//! * `fair`: any ready threads have the cores, as long as no core idles. The list begins with the threads
//!   that have a core. A swap with another thread is an action ([`Action::Preempt`]), which is possible at
//!   any moment.

use super::status::{control, flag, thread};
use super::{Action, Enabled, Rules};
use crate::explore::state::State;
use crate::system::{ClientAction, ClientId, ComponentId, Policy, TaskId};

/// A set of executors, as bits.
pub(super) type Threads = u128;

impl Rules<'_> {
    /// Returns true if an operating system grants cores and preempts threads.
    pub(crate) fn preempts(&self) -> bool {
        self.system.preempts()
    }

    fn uses_core(&self, executor: usize) -> bool {
        executor >= self.layout.tasks || self.system.needs_core(TaskId::from(executor))
    }

    /// Returns true if a thread can act, given a core.
    fn is_ready(&self, s: &State, executor: usize) -> bool {
        let l = &self.layout;
        if executor < l.tasks {
            return match l.thread_of(s, executor) {
                thread::AGAIN | thread::TICKET | thread::EXECUTING => true,
                thread::QUEUED => self.may_leave(s, executor),
                thread::IDLE => l.has(s, executor, flag::WAKE) || self.begins(s, executor),
                _ => false,
            };
        }
        let component = ComponentId::from(executor - l.tasks);
        match l.control(s, component) {
            control::TICKET | control::EXECUTING | control::REST => true,
            control::QUEUED => self.may_leave(s, executor),
            control::READY => {
                l.signal(s, component) != 0
                    || self.system.clients.keys().any(|client| self.asks(s, client, component))
            }
            _ => false,
        }
    }

    /// Returns true if a client has a request for a component that is not taken yet.
    fn asks(&self, s: &State, client: ClientId, component: ComponentId) -> bool {
        let l = &self.layout;
        let steps = &self.system.clients[client].steps;
        let step = steps.get(l.position(s, client) as usize);
        l.outstanding(s, client) == 0
            && step.is_some_and(|step| {
                matches!(step.action, ClientAction::Send { service, .. }
                    if self.system.services[service].component == component)
            })
    }

    /// Returns the threads that have a core, or need none: all threads, unless the policy preempts.
    pub(super) fn running(&self, s: &State) -> Threads {
        if !self.preempts() {
            return Threads::MAX;
        }
        let l = &self.layout;
        let mut order: Vec<usize> =
            (l.core_queue(s).iter()).map(|&executor| executor as usize).collect();
        if self.system.platform.policy == Policy::Priority {
            order.sort_by_key(|&priority| self.priorities[priority]);
        }
        let mut out = Threads::MAX;
        let chosen = self.chosen(&order);
        for executor in order {
            if !chosen.contains(&executor) {
                out &= !(1 << executor);
            }
        }
        out
    }

    /// Returns true if a task has a tick to serve, but no core to begin its cycle on. (Under the other
    /// policies tasks ask for a core as they clear their flag.)
    pub(super) fn waits_to_begin(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        self.preempts()
            && l.thread_of(s, task) == thread::IDLE
            && l.has(s, task, flag::TICK)
            && self.running(s) >> task & 1 == 0
    }

    /// Returns the first threads of a list that fit on the cores.
    fn chosen(&self, order: &[usize]) -> Vec<usize> {
        let cores = self.system.platform.cores.unwrap_or(u32::MAX) as usize;
        let core = |index: usize| {
            (self.system.tasks.get(TaskId::from(index))).and_then(|task| task.affinity)
        };
        let mut chosen: Vec<usize> = Vec::new();
        for &executor in order {
            let tied = core(executor);
            let taken = tied.is_some() && chosen.iter().any(|&other| core(other) == tied);
            if chosen.len() < cores && !taken {
                chosen.push(executor);
            }
        }
        chosen
    }

    /// Updates the list after a step: threads that are no longer ready leave, threads that have become ready
    /// are added.
    pub(super) fn list_ready(&self, s: &mut State) {
        if !self.preempts() {
            return;
        }
        let l = &self.layout;
        let mut new: Vec<usize> = Vec::new();
        for executor in 0..l.tasks + l.components {
            if !self.uses_core(executor) {
                continue;
            }
            let listed = l.core_queue(s).contains(&(executor as u16));
            match (listed, self.is_ready(s, executor)) {
                (false, true) => new.push(executor),
                (true, false) => l.core_queue_remove(s, executor),
                _ => {}
            }
        }
        for &executor in &new {
            if !self.has_rival(&new, executor) {
                l.core_queue_push(s, executor);
            }
        }
        self.normalize(s);
    }

    /// Returns true if the order in which some threads became ready at the same moment matters for one of
    /// them.
    fn has_rival(&self, new: &[usize], executor: usize) -> bool {
        let own = self.priorities[executor];
        let mut others = new.iter().filter(|&&index| index != executor);
        self.system.platform.policy == Policy::Priority
            && others.any(|&priority| self.priorities[priority] == own)
    }

    /// Adds the actions that select the next one of the threads that became ready at the same moment.
    pub(super) fn becomes_ready(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        for executor in 0..l.tasks + l.components {
            let listed = || l.core_queue(s).contains(&(executor as u16));
            if self.uses_core(executor) && self.is_ready(s, executor) && !listed() {
                out.actions.push(Action::Ready { executor });
            }
        }
    }

    /// Puts the list in a normal form: only orders that matter remain.
    fn normalize(&self, s: &mut State) {
        let l = &self.layout;
        let mut order: Vec<usize> =
            (l.core_queue(s).iter()).map(|&executor| executor as usize).collect();
        if self.system.platform.policy == Policy::Fair {
            let chosen = self.chosen(&order);
            order.sort_by_key(|&order| (!chosen.contains(&order), order));
        } else {
            // Between different priorities the order is irrelevant.
            order.sort_by_key(|&priority| self.priorities[priority]);
        }
        for &executor in &order {
            l.core_queue_remove(s, executor);
        }
        for &executor in &order {
            l.core_queue_push(s, executor);
        }
    }

    /// Adds the swaps that the policy `fair` allows.
    pub(super) fn swaps(&self, s: &State, running: Threads, out: &mut Enabled) {
        if !self.preempts() || self.system.platform.policy != Policy::Fair {
            return;
        }
        let list = self.layout.core_queue(s);
        let has_core = |number: u16| running >> number & 1 == 1;
        for &by in list.iter().filter(|&&executor| !has_core(executor)) {
            for &executor in list.iter().filter(|&&executor| has_core(executor)) {
                out.actions.push(Action::Preempt { executor: executor as usize, by: by as usize });
            }
        }
    }

    /// Gives the core of one thread to another.
    pub(super) fn preempt(&self, s: &mut State, executor: usize, by: usize) {
        let l = &self.layout;
        let order: Vec<usize> = (l.core_queue(s).iter())
            .map(|&executor| executor as usize)
            .filter(|&other| other != by && other != executor)
            .collect();
        l.core_queue_remove(s, by);
        l.core_queue_remove(s, executor);
        for &executor in &order {
            l.core_queue_remove(s, executor);
        }
        let others = order.iter().copied();
        for executor in std::iter::once(by).chain(others).chain([executor]) {
            l.core_queue_push(s, executor);
        }
        self.normalize(s);
    }

    /// Returns true if a ready thread has no core: then a swap is possible at any moment with `fair`.
    pub(super) fn may_swap(&self, s: &State, running: Threads) -> bool {
        self.system.platform.policy == Policy::Fair
            && self.preempts()
            && (self.layout.core_queue(s).iter()).any(|&executor| running >> executor & 1 == 0)
    }

    /// Returns true if an executor makes progress with its codel.
    pub(super) fn executes_on(&self, s: &State, running: Threads, executor: usize) -> bool {
        let client = executor >= self.layout.threads + self.layout.components;
        self.layout.is_executing(s, executor)
            && (!self.preempts() || client || running >> executor & 1 == 1)
    }
}
