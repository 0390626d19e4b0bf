//! The rules of the published formal models: the actions that a state allows, their effects, and the passage
//! of time.
//!
//! There is one function per rule of sections 3 to 9. Actions have four ranks, and only those of the best
//! rank present may happen: clients that proceed (part of the step that lets them), tasks that ask for a
//! core, granting cores, and all other actions. Within a rank any order is possible.

mod atoms;
mod control_task;
mod cycle;
mod describe;
pub(crate) mod layout;
mod perform;
mod possible;
mod time;

use std::cell::Cell;

use self::layout::{Layout, control};
use super::{Action, Enabled, Rules};
use crate::explore::rules::Moment;
use crate::explore::rules::Work;
use crate::explore::state::{Clocks, Frame, State, TaskStatus, phase};
use crate::property::Atom;
use crate::system::{ClientAction, Ticks, TimedSystem};

/// The rules applied to one system.
#[derive(Debug)]
pub(crate) struct Published<'s> {
    pub(crate) system: &'s TimedSystem,
    pub(crate) layout: Layout,
    /// Services with a request that was refused for lack of a slot.
    refused: Vec<Cell<bool>>,
    /// Codels (by number) that exclude no other codel.
    lockless: Vec<bool>,
    /// Automata of each machine.
    automata_of: Vec<Vec<usize>>,
}

impl<'s> Published<'s> {
    /// Creates the rules for a system.
    pub(crate) fn new(system: &'s TimedSystem) -> Self {
        let clocks = Clocks::none(system.tasks.len());
        Published::with(system, Layout::new(system, &clocks))
    }

    fn with(system: &'s TimedSystem, layout: Layout) -> Self {
        let mut automata_of = vec![Vec::new(); system.machines.len()];
        for (a, automaton) in system.automata.iter().enumerate() {
            automata_of[automaton.machine].push(a);
        }
        Published {
            automata_of,
            system,
            layout,
            refused: vec![Cell::new(false); system.services.len()],
            lockless: system
                .codels
                .iter()
                .map(|codel| codel.conflicts.is_empty())
                .collect(),
        }
    }

    /// Returns the state at time 0, with the first task of every component started.
    fn at_start(&self) -> State {
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

    /// Returns the present codel of an executor; `None` for clients.
    pub(crate) fn codel(&self, s: &State, executor: usize) -> Option<usize> {
        let l = &self.layout;
        if executor < l.automata {
            let machine = self.system.machine_of(executor);
            Some(machine.states[l.at(s, executor) as usize].codel)
        } else if executor < l.automata + l.components {
            let component = executor - l.automata;
            let (service, _) = l.request(s, component)?;
            let service = &self.system.services[service];
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

impl Rules for Published<'_> {
    fn with_clocks(&self, clocks: &Clocks) -> Self {
        Published::with(self.system, Layout::new(self.system, clocks))
    }

    #[inline]
    fn system(&self) -> &TimedSystem {
        self.system
    }

    #[inline]
    fn frame(&self) -> &Frame {
        &self.layout
    }

    fn initial(&self) -> State {
        self.at_start()
    }

    #[inline]
    fn enabled(&self, s: &State, out: &mut Enabled) {
        self.list_enabled(s, out);
    }

    #[inline]
    fn apply(&self, s: &mut State, action: Action) {
        self.perform(s, action);
    }

    fn next_moment(&self, s: &State, can_be_deferred: &dyn Fn(usize) -> bool) -> Option<Ticks> {
        self.until_next(s, can_be_deferred)
    }

    #[inline]
    fn elapse(&self, s: &mut State, time: Ticks) {
        self.pass(s, time);
    }

    #[inline]
    fn job(&self, s: &State, task: usize) -> TaskStatus {
        self.layout.status(s, task)
    }

    fn awaits_start_up(&self, s: &State, task: usize) -> Option<usize> {
        let l = &self.layout;
        let definition = &self.system.tasks[task];
        if !l.started(s, task) {
            let tasks = &self.system.components[definition.component].tasks;
            return tasks
                .get(l.starting(s, definition.component) as usize)
                .copied();
        }
        let first_run = |a: usize| {
            let mode = l.mode(s, a);
            mode == layout::mode::FIRST_CODEL || mode == layout::mode::FIRST_RUN
        };
        definition.permanent.filter(|&a| first_run(a)).map(|_| task)
    }

    #[inline]
    fn missed(&self, s: &State, task: usize) -> bool {
        self.layout.pending(s, task) && self.layout.status(s, task) != TaskStatus::Idle
    }

    fn atom(&self, s: &State, atom: &Atom) -> bool {
        self.value_of(s, atom)
    }

    fn has_refused(&self, service: usize) -> bool {
        self.refused[service].get()
    }

    fn task_of(&self, action: Action) -> Option<usize> {
        match action {
            Action::Grant { task } | Action::Release { task } | Action::Tick { task } => Some(task),
            Action::Acquire { executor } | Action::Finish { executor, .. } => self
                .system
                .automata
                .get(executor)
                .map(|automaton| automaton.task),
            Action::Proceed { .. } | Action::Signal { .. } | Action::Request { .. } => None,
            // Actions of other rules.
            Action::Begin { .. }
            | Action::Preempt { .. }
            | Action::Ready { .. }
            | Action::Ticket { .. }
            | Action::Wake { .. }
            | Action::Shut { .. }
            | Action::Mark { .. }
            | Action::Reply { .. } => None,
        }
    }

    fn duration(&self, s: &State, executor: usize) -> (Ticks, Ticks) {
        if let Some(codel) = self.codel(s, executor) {
            let codel = &self.system.codels[codel];
            return (codel.lower, codel.upper);
        }
        let l = &self.layout;
        let client = executor - l.automata - l.components;
        let position = l.position(s, client) as usize;
        match self.system.clients[client]
            .steps
            .get(position)
            .map(|step| &step.action)
        {
            Some(&ClientAction::Delay(lower, upper)) => (lower, upper),
            _ => (0, 0),
        }
    }

    fn work(&self, s: &State, executor: usize) -> Option<Work> {
        let l = &self.layout;
        if l.phase(s, executor) == phase::REST {
            return None;
        }
        if let Some(client) = executor.checked_sub(l.automata + l.components) {
            return Some(Work::Delay { client });
        }
        let codel = self.codel(s, executor)?;
        Some(match executor.checked_sub(l.automata) {
            Some(component) => {
                let (service, _) = l.request(s, component)?;
                let validates = self.system.services[service].validate.is_some();
                let simple = l.simple(s, component) as usize + usize::from(validates);
                Work::Control {
                    codel,
                    service,
                    number: match l.control(s, component) {
                        control::VALIDATE => 0,
                        _ => simple,
                    },
                }
            }
            None => Work::State {
                codel,
                task: self.system.automata[executor].task,
                automaton: executor,
                state: l.at(s, executor) as usize,
                slot: executor,
            },
        })
    }

    fn position(&self, s: &State, client: usize) -> usize {
        self.layout.position(s, client) as usize
    }

    fn places(&self) -> usize {
        self.layout.automata
    }

    fn activity(&self, s: &State, place: usize) -> Option<usize> {
        (self.layout.mode(s, place) != layout::slot::VOID).then_some(place)
    }

    fn interrupt_activity(&self, s: &mut State, place: usize) {
        self.interrupt_one(s, place);
    }

    fn handling(&self, s: &State, component: usize) -> Option<(usize, bool)> {
        let (service, _) = self.layout.request(s, component)?;
        Some((service, false))
    }

    fn tell(
        &self,
        (before, after): (&State, &State),
        action: Option<Action>,
        time: u64,
        out: &mut Vec<Moment>,
    ) {
        self.describe(before, after, action, time, out);
    }
}
