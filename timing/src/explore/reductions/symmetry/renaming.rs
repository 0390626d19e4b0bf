//! New names of the parts of a system.

use crate::explore::rules::{Action, Part, Parts, Rules};
use crate::property::Atom;
use crate::system::TimedSystem;

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

    pub(super) fn of_mut(&mut self, part: Part) -> &mut [usize] {
        &mut self.0[part]
    }

    /// Returns the new names, by kind.
    pub(super) fn all(&self) -> impl Iterator<Item = &Vec<usize>> {
        self.0.lists().iter()
    }

    /// Renames the parts of one unit to those of another.
    pub(super) fn put(&mut self, from: &Parts, to: &Parts) {
        for ((names, from), to) in self
            .0
            .lists_mut()
            .iter_mut()
            .zip(from.lists())
            .zip(to.lists())
        {
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

    /// Returns the inverse renaming.
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
        self.map(|kind, then| first.0.lists()[kind].iter().map(|&it| then[it]).collect())
    }

    pub(crate) fn task(&self, task: usize) -> usize {
        self.0[Part::Task][task]
    }

    fn component(&self, component: usize) -> usize {
        self.0[Part::Component][component]
    }

    fn client(&self, client: usize) -> usize {
        self.0[Part::Client][client]
    }

    pub(crate) fn executor(&self, executor: usize) -> usize {
        self.0[Part::Executor][executor]
    }

    /// Renames an action.
    pub(crate) fn action(&self, action: Action) -> Action {
        let task = |it| self.task(it);
        let client = |it| self.client(it);
        let component = |it| self.component(it);
        let executor = |it| self.executor(it);
        match action {
            Action::Proceed { client: it, next } => Action::Proceed {
                client: client(it),
                next,
            },
            Action::Release { task: it } => Action::Release { task: task(it) },
            Action::Grant { task: it } => Action::Grant { task: task(it) },
            Action::Tick { task: it } => Action::Tick { task: task(it) },
            Action::Acquire { executor: it } => Action::Acquire {
                executor: executor(it),
            },
            Action::Finish {
                executor: it,
                outcome,
            } => Action::Finish {
                executor: executor(it),
                outcome,
            },
            Action::Preempt { executor: it, by } => Action::Preempt {
                executor: executor(it),
                by: executor(by),
            },
            Action::Ready { executor: it } => Action::Ready {
                executor: executor(it),
            },
            Action::Begin { task: it } => Action::Begin { task: task(it) },
            Action::Wake { task: it } => Action::Wake { task: task(it) },
            Action::Ticket { executor: it } => Action::Ticket {
                executor: executor(it),
            },
            Action::Mark {
                executor: it,
                taken,
            } => Action::Mark {
                executor: it.map(executor),
                taken,
            },
            Action::Reply { component: it } => Action::Reply {
                component: component(it),
            },
            Action::Shut { component: it } => Action::Shut {
                component: component(it),
            },
            Action::Signal { component: it } => Action::Signal {
                component: component(it),
            },
            Action::Request { client: it, next } => Action::Request {
                client: client(it),
                next,
            },
        }
    }

    /// Renames an atom of a predicate.
    pub(super) fn atom(&self, atom: &Atom) -> Atom {
        match *atom {
            Atom::Task(task, state) => Atom::Task(self.task(task), state),
            Atom::State {
                machine,
                state,
                phase,
            } => Atom::State {
                machine: self.0[Part::Machine][machine],
                state,
                phase,
            },
            Atom::Slot(service, status) => Atom::Slot(self.0[Part::Service][service], status),
            Atom::Handling {
                service,
                codel,
                phase,
            } => Atom::Handling {
                service: self.0[Part::Service][service],
                codel: codel.map(|it| self.0[Part::Codel][it]),
                phase,
            },
            Atom::ControlBusy(component) => Atom::ControlBusy(self.component(component)),
            Atom::Client(client, ref steps) => Atom::Client(self.client(client), steps.clone()),
        }
    }
}
