//! Cores as an operating system gives them (section 22): preemptive policies.
//!
//! A thread is *ready* if it can do something: it is neither idle nor waits in the lock queue for somebody
//! else. The ready threads are listed in the state, in the order in which they became ready; those that do
//! not fit on the cores neither act nor execute, and what remains of their codels stays. A codel that has
//! come to its end ends, whoever comes at that moment.
//!
//! * `priority`: at each moment the ready threads of highest priority have the cores; ties in order of the
//!   list. A control task has the highest priority of its component.
//! * `fair`: any of them, as long as no core idles. The list begins with those that have a core; a swap with
//!   another one is an action, which is possible at any moment. ([`Action::Preempt`])

use super::layout::{control, flag, thread};
use super::{Action, Enabled, Servers};
use crate::explore::state::{State, phase};
use crate::system::{ClientAction, Policy};

/// Executors as bits.
pub(super) type Threads = u128;

impl Servers<'_> {
    /// Whether cores are given and taken away by an operating system.
    pub(crate) fn preempts(&self) -> bool {
        self.system.preempts()
    }

    fn uses_core(&self, executor: usize) -> bool {
        executor >= self.layout.tasks || self.system.needs_core(executor)
    }

    /// Whether a thread can do something, given a core.
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
        let component = executor - l.tasks;
        match l.control(s, component) {
            control::TICKET | control::EXECUTING | control::REST => true,
            control::QUEUED => self.may_leave(s, executor),
            control::READY => {
                l.signal(s, component) != 0
                    || (0..self.system.clients.len()).any(|it| self.asks(s, it, component))
            }
            _ => false,
        }
    }

    /// Whether a client has a request for a component that is not taken.
    fn asks(&self, s: &State, client: usize, component: usize) -> bool {
        let l = &self.layout;
        let steps = &self.system.clients[client].steps;
        let step = steps.get(l.position(s, client) as usize);
        l.outstanding(s, client) == 0
            && step.is_some_and(|it| {
                matches!(it.action, ClientAction::Send { service, .. }
                    if self.system.services[service].component == component)
            })
    }

    /// The threads that have a core, or need none. All, unless the policy preempts.
    pub(super) fn running(&self, s: &State) -> Threads {
        if !self.preempts() {
            return Threads::MAX;
        }
        let l = &self.layout;
        let mut order: Vec<usize> = (l.core_queue(s).iter()).map(|&it| it as usize).collect();
        if self.system.platform.policy == Policy::Priority {
            order.sort_by_key(|&it| self.priorities[it]);
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

    /// Whether a task has a tick to serve, but no core to begin its cycle on. (Under the other policies tasks
    /// ask for a core as they clear their flag.)
    pub(super) fn waits_to_begin(&self, s: &State, task: usize) -> bool {
        let l = &self.layout;
        self.preempts()
            && l.thread_of(s, task) == thread::IDLE
            && l.has(s, task, flag::TICK)
            && self.running(s) >> task & 1 == 0
    }

    /// The first of a list that fit on the cores.
    fn chosen(&self, order: &[usize]) -> Vec<usize> {
        let cores = self.system.platform.cores.unwrap_or(u32::MAX) as usize;
        let core = |it: usize| (self.system.tasks.get(it)).and_then(|task| task.affinity);
        let mut chosen: Vec<usize> = Vec::new();
        for &executor in order {
            let tied = core(executor);
            let taken = tied.is_some() && chosen.iter().any(|&it| core(it) == tied);
            if chosen.len() < cores && !taken {
                chosen.push(executor);
            }
        }
        chosen
    }

    /// After a step: who is ready no more leaves the list, who has become ready is added.
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
                l.core_queue_push(s, executor, false);
            }
        }
        self.normalize(s);
    }

    /// Whether the order in which some threads have become ready at the same moment matters for one of them.
    fn has_rival(&self, new: &[usize], executor: usize) -> bool {
        let own = self.priorities[executor];
        let mut others = new.iter().filter(|&&it| it != executor);
        self.system.platform.policy == Policy::Priority
            && others.any(|&it| self.priorities[it] == own)
    }

    /// Threads that have become ready at the same moment, of which any may be the next.
    pub(super) fn becomes_ready(&self, s: &State, out: &mut Enabled) {
        let l = &self.layout;
        for executor in 0..l.tasks + l.components {
            let listed = || l.core_queue(s).contains(&(executor as u16));
            if self.uses_core(executor) && self.is_ready(s, executor) && !listed() {
                out.actions.push(Action::Ready { executor });
            }
        }
    }

    /// Puts the list in an order that depends on nothing that does not matter.
    fn normalize(&self, s: &mut State) {
        let l = &self.layout;
        let mut order: Vec<usize> = (l.core_queue(s).iter()).map(|&it| it as usize).collect();
        if self.system.platform.policy == Policy::Fair {
            let chosen = self.chosen(&order);
            order.sort_by_key(|&it| (!chosen.contains(&it), it));
        } else {
            // Between different priorities the order means nothing.
            order.sort_by_key(|&it| self.priorities[it]);
        }
        order.iter().for_each(|&it| l.core_queue_remove(s, it));
        order.iter().for_each(|&it| l.core_queue_push(s, it, false));
    }

    /// The swaps that the policy `fair` allows.
    pub(super) fn swaps(&self, s: &State, running: Threads, out: &mut Enabled) {
        if !self.preempts() || self.system.platform.policy != Policy::Fair {
            return;
        }
        let list = self.layout.core_queue(s);
        let has_core = |it: u16| running >> it & 1 == 1;
        for &by in list.iter().filter(|&&it| !has_core(it)) {
            for &executor in list.iter().filter(|&&it| has_core(it)) {
                out.actions.push(Action::Preempt {
                    executor: executor as usize,
                    by: by as usize,
                });
            }
        }
    }

    /// One thread takes the core of another.
    pub(super) fn preempt(&self, s: &mut State, executor: usize, by: usize) {
        let l = &self.layout;
        let order: Vec<usize> = (l.core_queue(s).iter())
            .map(|&it| it as usize)
            .filter(|&it| it != by && it != executor)
            .collect();
        l.core_queue_remove(s, by);
        l.core_queue_remove(s, executor);
        order.iter().for_each(|&it| l.core_queue_remove(s, it));
        let others = order.iter().copied();
        for it in std::iter::once(by).chain(others).chain([executor]) {
            l.core_queue_push(s, it, false);
        }
        self.normalize(s);
    }

    /// Whether a thread that is ready has no core: then everything may change at any moment with `fair`.
    pub(super) fn may_swap(&self, s: &State, running: Threads) -> bool {
        self.system.platform.policy == Policy::Fair
            && self.preempts()
            && (self.layout.core_queue(s).iter()).any(|&it| running >> it & 1 == 0)
    }

    /// Whether an executor gets on with its codel.
    pub(super) fn executes_on(&self, s: &State, running: Threads, executor: usize) -> bool {
        let client = executor >= self.layout.tasks + self.layout.components;
        self.layout.phase(s, executor) == phase::EXECUTING
            && (client || running >> executor & 1 == 1)
    }
}
