//! The rules: which actions a state allows, what each does, and how time passes.
//!
//! One function per rule of sections 3 to 9. Actions come in four ranks, and only those of the
//! best rank present may happen: clients moving on (part of the step that lets them), tasks asking
//! for a core, granting cores, and everything else. Within a rank any order is possible.

mod control_task;
mod cycle;
mod perform;
mod possible;
mod time;

use std::cell::Cell;

use super::state::{Layout, State, control};
use crate::system::TimedSystem;

/// Something that happens without taking time. Executors are numbered: automata, then the control
/// tasks of components, then clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Action {
    /// What a client waited for has happened; it goes on.
    Proceed {
        /// The client.
        client: usize,
        /// Its next step.
        next: usize,
    },
    /// A task is released: takes its tick and asks for a core.
    Release {
        /// The task.
        task: usize,
    },
    /// A waiting task gets a core.
    Grant {
        /// The task.
        task: usize,
    },
    /// A timer wraps.
    Tick {
        /// The task.
        task: usize,
    },
    /// A codel takes its locks.
    Acquire {
        /// What executes it.
        executor: usize,
    },
    /// A codel or a delay ends.
    Finish {
        /// What executed it.
        executor: usize,
        /// For automata the index of the yield; for control tasks 0 is "accepted" (or done), 1
        /// "refused"; for clients the step after the delay.
        outcome: usize,
    },
    /// The control task handles the end of activities.
    Signal {
        /// Its component.
        component: usize,
    },
    /// The control task takes a client's request.
    Request {
        /// The client.
        client: usize,
        /// The client's next step.
        next: usize,
    },
}

/// The actions of a state.
#[derive(Debug, Default)]
pub(crate) struct Enabled {
    /// All of the best rank.
    pub(crate) actions: Vec<Action>,
    /// At least one of them must happen before time passes, whatever the windows.
    pub(crate) urgent: bool,
    /// They are of a rank before the last: part of the step that made them possible.
    pub(crate) committed: bool,
    /// Some executing codel has come to the end of its window.
    pub(crate) forced: bool,
}

/// The rules applied to one system.
#[derive(Debug)]
pub(crate) struct Stepper<'s> {
    pub(crate) system: &'s TimedSystem,
    pub(crate) layout: Layout,
    /// Services of which a request was refused for want of a slot.
    pub(crate) refused: Vec<Cell<bool>>,
    /// Codels (by number) that exclude no other.
    lockless: Vec<bool>,
    /// Automata of each machine.
    pub(crate) automata_of: Vec<Vec<usize>>,
}

impl<'s> Stepper<'s> {
    pub(crate) fn new(system: &'s TimedSystem, layout: Layout) -> Self {
        let mut automata_of = vec![Vec::new(); system.machines.len()];
        for (a, it) in system.automata.iter().enumerate() {
            automata_of[it.machine].push(a);
        }
        Stepper {
            automata_of,
            system,
            layout,
            refused: vec![Cell::new(false); system.services.len()],
            lockless: system
                .codels
                .iter()
                .map(|it| it.conflicts.is_empty())
                .collect(),
        }
    }

    /// The state at time 0, with the first task of every component started.
    pub(crate) fn initial(&self) -> State {
        let l = &self.layout;
        let mut s = l.blank();
        for (c, component) in self.system.components.iter().enumerate() {
            l.set_starting(&mut s, c, 0);
            for service in &component.services {
                for &a in &self.system.services[*service].slots {
                    self.reset_slot(&mut s, a);
                }
            }
            self.start_tasks(&mut s, c);
        }
        for (k, client) in self.system.clients.iter().enumerate() {
            // One past the end: the position before the first step.
            l.set_position(&mut s, k, client.done() as u16 + 1);
        }
        s
    }

    /// The codel an executor is at; `None` for clients.
    pub(crate) fn codel(&self, s: &State, executor: usize) -> Option<usize> {
        let l = &self.layout;
        if executor < l.automata {
            let machine = self.system.machine_of(executor);
            Some(machine.states[l.at(s, executor) as usize].codel)
        } else if executor < l.automata + l.components {
            let component = executor - l.automata;
            let service = &self.system.services[l.handled(s, component) as usize];
            if l.control(s, component) == control::VALIDATE {
                service.validate
            } else {
                service.simple.get(l.simple(s, component) as usize).copied()
            }
        } else {
            None
        }
    }
}
