//! New names of the parts of a system.

use crate::explore::rules::{Action, Part, Parts, Rules};
use crate::property::Atom;
use crate::system::{ClientId, ComponentId, TaskId, TimedSystem};

/// The index of a part of some kind.
pub(super) trait Id: Copy + Ord + From<usize> + Into<usize> {}

impl<I: Copy + Ord + From<usize> + Into<usize>> Id for I {}

/// New names of all parts after an exchange of units, by kind and old number.
#[derive(Debug, Clone)]
pub(crate) struct Renaming(Parts);

impl Renaming {
    /// Returns the renaming that changes nothing.
    pub(super) fn identity<R: Rules>(rules: &R) -> Self {
        let mut out = Renaming::of_system(rules.system());
        out.0[Part::Executor] = (0..rules.frame().executors()).collect();
        out.0[Part::Place] = (0..rules.places()).collect();
        out
    }

    /// Returns the renaming of the parts of a system that changes nothing, without what the rules number.
    pub(super) fn of_system(system: &TimedSystem) -> Self {
        let mut out = Parts::default();
        for (part, count) in [
            (Part::Task, system.tasks.len()),
            (Part::Automaton, system.automata.len()),
            (Part::Service, system.services.len()),
            (Part::Component, system.components.len()),
            (Part::Client, system.clients.len()),
            (Part::Machine, system.machines.len()),
            (Part::Codel, system.codels.len()),
        ] {
            out[part] = (0..count).collect();
        }
        Renaming(out)
    }

    /// Returns the new names of all parts of a kind.
    #[inline]
    pub(super) fn of(&self, part: Part) -> &[usize] {
        &self.0[part]
    }

    #[inline]
    pub(super) fn name<I: Id>(&self, part: Part, id: I) -> I {
        I::from(self.0[part][id.into()])
    }

    pub(super) fn of_mut(&mut self, part: Part) -> &mut [usize] {
        &mut self.0[part]
    }

    /// Returns the new names, by kind.
    pub(super) fn all(&self) -> impl Iterator<Item = &Vec<usize>> {
        self.0.lists().iter()
    }

    /// Renames the parts of one unit to those of another.
    pub(super) fn put(&mut self, from: &Parts, to: &Parts) {
        for ((names, from), to) in self.0.lists_mut().iter_mut().zip(from.lists()).zip(to.lists()) {
            for (&from, &to) in from.iter().zip(to) {
                names[from] = to;
            }
        }
    }

    fn map(&self, each: impl Fn(usize, &[usize]) -> Vec<usize>) -> Renaming {
        let mut out = Parts::default();
        for (kind, (to, from)) in out.lists_mut().iter_mut().zip(self.0.lists()).enumerate() {
            *to = each(kind, from);
        }
        Renaming(out)
    }

    pub(crate) fn inverse(&self) -> Renaming {
        self.map(|_, names| {
            let mut out = vec![0; names.len()];
            for (from, &to) in names.iter().enumerate() {
                out[to] = from;
            }
            out
        })
    }

    /// Returns the composition of two renamings, `first` before this one.
    pub(crate) fn after(&self, first: &Renaming) -> Renaming {
        self.map(|kind, then| first.0.lists()[kind].iter().map(|&index| then[index]).collect())
    }

    pub(crate) fn task(&self, task: usize) -> usize {
        self.0[Part::Task][task]
    }

    fn component(&self, component: ComponentId) -> ComponentId {
        self.name(Part::Component, component)
    }

    fn client(&self, client: ClientId) -> ClientId {
        self.name(Part::Client, client)
    }

    pub(crate) fn executor(&self, executor: usize) -> usize {
        self.0[Part::Executor][executor]
    }

    /// Renames an action.
    pub(crate) fn action(&self, action: Action) -> Action {
        let task = |index| self.task(index);
        let client = |index| self.client(index);
        let component = |index| self.component(index);
        let executor = |executor| self.executor(executor);
        match action {
            Action::Proceed { client: index, next } => {
                Action::Proceed { client: client(index), next }
            }
            Action::Release { task: index } => Action::Release { task: task(index) },
            Action::Grant { task: index } => Action::Grant { task: task(index) },
            Action::Tick { task: index } => Action::Tick { task: task(index) },
            Action::Acquire { executor: index } => Action::Acquire { executor: executor(index) },
            Action::Finish { executor: index, outcome } => {
                Action::Finish { executor: executor(index), outcome }
            }
            Action::Preempt { executor: index, by } => {
                Action::Preempt { executor: executor(index), by: executor(by) }
            }
            Action::Ready { executor: index } => Action::Ready { executor: executor(index) },
            Action::Begin { task: index } => Action::Begin { task: task(index) },
            Action::Wake { task: index } => Action::Wake { task: task(index) },
            Action::Ticket { executor: index } => Action::Ticket { executor: executor(index) },
            Action::Mark { executor: index, taken } => {
                Action::Mark { executor: index.map(executor), taken }
            }
            Action::Reply { component: index } => Action::Reply { component: component(index) },
            Action::Shut { component: index } => Action::Shut { component: component(index) },
            Action::Signal { component: index } => Action::Signal { component: component(index) },
            Action::Request { client: index, next } => {
                Action::Request { client: client(index), next }
            }
        }
    }

    /// Renames an atom of a predicate.
    pub(super) fn atom(&self, atom: &Atom) -> Atom {
        match *atom {
            Atom::Task(task, state) => {
                Atom::Task(TaskId::from(self.task(usize::from(task))), state)
            }
            Atom::State { machine, state, phase } => {
                Atom::State { machine: self.name(Part::Machine, machine), state, phase }
            }
            Atom::Slot(service, status) => Atom::Slot(self.name(Part::Service, service), status),
            Atom::Handling { service, codel, phase } => Atom::Handling {
                service: self.name(Part::Service, service),
                codel: codel.map(|codel| self.name(Part::Codel, codel)),
                phase,
            },
            Atom::ControlBusy(component) => Atom::ControlBusy(self.component(component)),
            Atom::Client(client, ref steps) => Atom::Client(self.client(client), steps.clone()),
            Atom::Tick(task) => Atom::Tick(TaskId::from(self.task(usize::from(task)))),
            Atom::Data { fact, negated } => Atom::Data { fact, negated },
            // An exchange keeps each predicate of the monitor.
            Atom::Violated(monitor) => Atom::Violated(monitor),
        }
    }
}
