//! The range of actions, for reductions.

use super::status::{control, flag, slot, thread};
use super::{Action, Rules};
use crate::explore::state::{State, phase};
use crate::system::{ClientAction, ClientId, ComponentId, TaskId};

impl Rules<'_> {
    /// Returns the component of an action; `None` for actions of clients alone.
    pub(crate) fn component_of_action(&self, s: &State, action: Action) -> Option<ComponentId> {
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
            _ => Some(self.system.tasks[TaskId::from(self.task_of(action)?)].component),
        }
    }

    pub(crate) fn client_of_action(&self, action: Action) -> Option<ClientId> {
        match action {
            Action::Proceed { client, .. } | Action::Request { client, .. } => Some(client),
            Action::Finish { executor, .. } => self.layout.client_of_executor(executor),
            _ => None,
        }
    }

    /// Returns true if an action must be performed before time passes.
    pub(crate) fn has_to_act(&self, s: &State, action: Action) -> bool {
        match action {
            Action::Finish { executor, .. } => self.layout.window(s, executor).1 == 0,
            Action::Preempt { .. } => false,
            _ => true,
        }
    }

    /// Returns true if a client may still interact with components.
    pub(crate) fn is_active(&self, s: &State, client: ClientId) -> bool {
        let l = &self.layout;
        let definition = &self.system.clients[client];
        l.outstanding(s, client) != 0
            || l.position(s, client) as usize != definition.done()
            || (0..definition.trackers).any(|t| l.tracker(s, client, t) != 0)
    }

    /// Returns true if some task of these components waits for a core.
    pub(crate) fn waits_for_core(&self, s: &State, of: impl Fn(ComponentId) -> bool) -> bool {
        let mut queue = self.layout.core_queue(s).iter();
        queue.any(|&task| of(self.system.tasks[TaskId::from(task as usize)].component))
    }

    /// Returns true if a task has a core.
    pub(crate) fn has_core(&self, s: &State, task: TaskId) -> bool {
        self.layout.has(s, task.into(), flag::CORE)
    }

    /// Returns true if an action frees a core, or lets a task ask for one.
    pub(crate) fn is_about_cores(&self, s: &State, action: Action) -> bool {
        if self.system.platform.cores.is_none() {
            return false;
        }
        // An action of a client alone changes nothing at the cores.
        let Some(component) = self.component_of_action(s, action) else {
            return false;
        };
        let tasks = &self.system.components[component].tasks;
        let at_cores = |s: &State| -> Vec<(bool, bool)> {
            let of = |&task: &usize| {
                let asks = self.begins(s, task) && self.asks_for_core(s, task);
                (self.layout.has(s, task, flag::CORE), asks)
            };
            tasks.iter().map(|&task| of(&task.into())).collect()
        };
        let before = at_cores(s);
        let mut next = s.clone();
        self.perform(&mut next, action);
        at_cores(&next) != before
    }

    /// Returns true if one of these tasks has a tick that is kept from its first cycle.
    pub(crate) fn keeps_first_tick(&self, s: &State, of: impl Fn(usize) -> bool) -> bool {
        let both = |task: usize| {
            let flags = self.layout.flags(s, task);
            flags & flag::FIRST != 0 && flags & flag::TICK != 0 && self.in_cycle(s, task)
        };
        (0..self.layout.tasks).any(|task| of(task) && both(task))
    }

    /// Returns true if the permanent activity of a task executes the codel of a state, or has ended (by an
    /// exception), and its component is up.
    pub(crate) fn rests(&self, s: &State, task: usize, state: usize) -> bool {
        let l = &self.layout;
        let first = l.slots(task)[0];
        let executes = l.thread_of(s, task) == thread::EXECUTING
            && l.phase(s, task) == phase::EXECUTING
            && l.turn(s, task) == Some(first)
            && l.mode(s, first) & slot::STATUS == slot::RUN
            && l.at(s, first) as usize == state;
        let has_ended = l.thread_of(s, task) == thread::IDLE && l.activity(s, first) == slot::VOID;
        (executes || has_ended)
            && l.control(s, self.system.tasks[TaskId::from(task)].component) != control::OFF
    }
}
