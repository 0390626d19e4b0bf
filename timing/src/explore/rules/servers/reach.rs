//! How far actions reach: what reductions have to know.

use super::layout::{control, flag, slot, thread};
use super::{Action, Servers};
use crate::explore::rules::Rules;
use crate::explore::state::{State, phase};
use crate::system::ClientAction;

impl Servers<'_> {
    /// The component an action is one of; `None` for those of clients alone.
    pub(crate) fn component_of_action(&self, s: &State, action: Action) -> Option<usize> {
        match action {
            Action::Signal { component }
            | Action::Reply { component }
            | Action::Shut { component } => Some(component),
            Action::Request { client, .. } => {
                let steps = &self.system.clients[client].steps;
                match steps.get(self.layout.position(s, client) as usize)?.action {
                    ClientAction::Send { service, .. } => {
                        Some(self.system.services[service].component)
                    }
                    _ => None,
                }
            }
            Action::Ticket { executor }
            | Action::Acquire { executor }
            | Action::Ready { executor }
            | Action::Finish { executor, .. } => self.component_of(executor),
            _ => Some(self.system.tasks[self.task_of(action)?].component),
        }
    }

    /// The client that an action is one of.
    pub(crate) fn client_of_action(&self, action: Action) -> Option<usize> {
        match action {
            Action::Proceed { client, .. } | Action::Request { client, .. } => Some(client),
            Action::Finish { executor, .. } => {
                let before = self.system.tasks.len() + self.system.components.len();
                executor.checked_sub(before)
            }
            _ => None,
        }
    }

    /// Whether an action must be performed before time passes.
    pub(crate) fn has_to_act(&self, s: &State, action: Action) -> bool {
        match action {
            Action::Finish { executor, .. } => self.layout.window(s, executor).1 == 0,
            Action::Preempt { .. } => false,
            _ => true,
        }
    }

    /// Whether a client may still have something to do with components.
    pub(crate) fn is_active(&self, s: &State, client: usize) -> bool {
        let l = &self.layout;
        let it = &self.system.clients[client];
        l.outstanding(s, client) != 0
            || l.position(s, client) as usize != it.done()
            || (0..it.trackers).any(|t| l.tracker(s, client, t) != 0)
    }

    /// Whether some task of these components waits for a core.
    pub(crate) fn waits_for_core(&self, s: &State, of: impl Fn(usize) -> bool) -> bool {
        let mut queue = self.layout.core_queue(s).iter();
        queue.any(|&task| of(self.system.tasks[task as usize].component))
    }

    /// Whether an action frees a core, or lets a task ask for one.
    pub(crate) fn is_about_cores(&self, s: &State, action: Action) -> bool {
        if self.system.platform.cores.is_none() {
            return false;
        }
        // A step of a client alone changes nothing at the cores.
        let Some(component) = self.component_of_action(s, action) else {
            return false;
        };
        let tasks = &self.system.components[component].tasks;
        let at_cores = |s: &State| -> Vec<(bool, bool)> {
            let of = |&task: &usize| {
                let asks = self.begins(s, task) && self.asks_for_core(s, task);
                (self.in_cycle(s, task), asks)
            };
            tasks.iter().map(of).collect()
        };
        let before = at_cores(s);
        let mut next = s.clone();
        self.perform(&mut next, action);
        at_cores(&next) != before
    }

    /// Whether at this moment only ticks of idle tasks let anybody ask for a core, and how many cores are free: every task that
    /// needs one has been started, none that is at work has a tick that is kept or due, and aperiodic ones never ask again.
    pub(crate) fn only_ticks_ask(&self, s: &State) -> Option<usize> {
        let l = &self.layout;
        let mut at_work = 0;
        for (task, it) in self.system.tasks.iter().enumerate() {
            let needs_core = self.system.needs_core(task);
            let thread = l.thread_of(s, task);
            let cycle = (thread::WAITING..=thread::EXECUTING).contains(&thread);
            if thread == thread::OFF || l.has(s, task, flag::WAKE) {
                return None;
            }
            let asks_by_itself = match it.period {
                Some(_) => cycle && (l.timer(s, task) == 0 || l.has(s, task, flag::TICK)),
                None if cycle => {
                    let endless = |a: usize| self.system.machine_of(a).is_endless();
                    !it.slots.is_empty() || !it.permanent.is_some_and(endless)
                }
                None => l
                    .slots(task)
                    .any(|it| !matches!(l.status(s, it), slot::VOID | slot::ETHER)),
            };
            if needs_core && asks_by_itself {
                return None;
            }
            at_work += usize::from(needs_core && cycle);
        }
        let cores = self
            .system
            .platform
            .cores
            .map_or(usize::MAX, |it| it as usize);
        Some(cores.saturating_sub(at_work))
    }

    /// Whether an action is the tick of an idle task.
    pub(crate) fn is_idle_tick(&self, s: &State, action: Action) -> bool {
        matches!(action, Action::Tick { task } if self.layout.thread_of(s, task) == thread::IDLE)
    }

    /// Whether one of these tasks has a tick that is kept from its first cycle.
    pub(crate) fn keeps_first_tick(&self, s: &State, of: impl Fn(usize) -> bool) -> bool {
        let both = |task: usize| {
            let flags = self.layout.flags(s, task);
            flags & flag::FIRST != 0 && flags & flag::TICK != 0 && self.in_cycle(s, task)
        };
        (0..self.layout.tasks).any(|task| of(task) && both(task))
    }

    /// Whether the permanent activity of a task executes the codel of a state, or has ended (by an exception), and its component
    /// is up.
    pub(crate) fn rests(&self, s: &State, task: usize, state: usize) -> bool {
        let l = &self.layout;
        let first = l.slots(task).start;
        let executes = l.thread_of(s, task) == thread::EXECUTING
            && l.phase(s, task) == phase::EXECUTING
            && l.turn(s, task) as usize == first
            && l.mode(s, first) & slot::STATUS == slot::RUN
            && l.at(s, first) as usize == state;
        let has_ended = l.thread_of(s, task) == thread::IDLE && l.status(s, first) == slot::VOID;
        (executes || has_ended) && l.control(s, self.system.tasks[task].component) != control::OFF
    }
}
