//! Predicates as conditions over integers.

use dotgen_timing::property::predicate::{Atom, Predicate, SlotStatus, StatePhase, TaskState};
use dotgen_timing::system::CodelId;

use crate::model::{Guard, all, any, var};

use super::layout::{Layout, executed, number, position, status, step, wanted};
use super::published::has_status;

/// Predicates as conditions of a network in which variables hold the values before the last action.
pub(super) struct Conditions<'c> {
    pub(super) layout: &'c Layout<'c>,
    /// Atoms with a variable for their value before.
    pub(super) left: &'c [&'c Atom],
}

impl Conditions<'_> {
    /// Returns a predicate as a condition after an action.
    pub(super) fn after(&self, predicate: &Predicate) -> Guard {
        condition(self.layout, predicate, &|of| {
            let index = self.left.iter().position(|left| *left == of);
            let before = index.map(|index| var(&format!("held_before_{index}")).is(1_usize));
            all([before.unwrap_or(any([])), atom(self.layout, of).negated()])
        })
    }

    /// Returns a predicate as a condition while time passes.
    pub(super) fn still(&self, predicate: &Predicate) -> Guard {
        condition(self.layout, predicate, &|_| any([]))
    }
}

/// Returns a predicate as a condition. `leave` gives the condition that an atom has just stopped holding.
fn condition(layout: &Layout, predicate: &Predicate, leave: &dyn Fn(&Atom) -> Guard) -> Guard {
    let inner = |predicate: &Predicate| condition(layout, predicate, leave);
    match predicate {
        Predicate::Atom(of) => atom(layout, of),
        Predicate::Leave(of) => leave(of),
        Predicate::Not(of) => inner(of).negated(),
        Predicate::And(one, other) => all([inner(one), inner(other)]),
        Predicate::Or(one, other) => any([inner(one), inner(other)]),
    }
}

/// Returns the atoms of a predicate that are left.
pub(super) fn left<'p>(predicate: &'p Predicate, out: &mut Vec<&'p Atom>) {
    match predicate {
        Predicate::Atom(_) => {}
        Predicate::Leave(atom) => {
            if !out.contains(&atom) {
                out.push(atom);
            }
        }
        Predicate::Not(of) => left(of, out),
        Predicate::And(one, other) | Predicate::Or(one, other) => {
            left(one, out);
            left(other, out);
        }
    }
}

/// Returns an atom as a condition.
pub(super) fn atom(layout: &Layout, atom: &Atom) -> Guard {
    match atom {
        Atom::Task(task, state) => {
            let at = layout.task(*task).position();
            match state {
                TaskState::Idle => at.below(position::WAITS),
                TaskState::Waiting => at.is(position::WAITS),
                TaskState::Running => at.is(position::CYCLE),
                TaskState::Active => at.at_least(position::WAITS),
            }
        }
        Atom::State { machine, state, phase } => {
            let codel = layout.system.machines[*machine].states[*state].codel;
            in_phase(layout, codel, *phase)
        }
        Atom::Slot(service, of) if layout.jobs => has_status(layout, *service, *of),
        Atom::Slot(service, of) => {
            let Some((part, kind)) = layout.kind_of(*service) else {
                return if *of == SlotStatus::Void { Guard::always() } else { any([]) };
            };
            let task = part.task(kind.task);
            let places = task.base..task.base + task.count;
            let is_of_kind = |place: usize| part.kind(place).is(kind.number);
            let has = |value: usize| {
                let has = |place: usize| all([is_of_kind(place), part.status(place).is(value)]);
                any(places.clone().map(has))
            };
            match of {
                SlotStatus::Void => any(places.map(is_of_kind)).negated(),
                SlotStatus::Active => any(places.map(is_of_kind)),
                SlotStatus::Wait => has(status::ACCEPTED),
                SlotStatus::Run => has(status::RUNS),
                SlotStatus::Stop => has(status::STOPS),
            }
        }
        Atom::Handling { service, codel: Some(codel), phase } => {
            let requested = layout.system.requested();
            if requested[*service] { in_phase(layout, *codel, *phase) } else { any([]) }
        }
        Atom::Handling { service, codel: None, phase } => {
            let part = layout.part(layout.system.services[*service].component);
            let own = part.services.iter().filter(|(id, _)| id == service);
            let codels = own.flat_map(|(_, codels)| codels);
            any(codels.map(|&codel| in_phase(layout, codel, *phase)))
        }
        Atom::ControlBusy(component) => {
            let part = layout.part(*component);
            if part.control || layout.jobs {
                part.step().is_not(step::READY)
            } else if part.tasks.is_empty() {
                any([])
            } else {
                part.own("starting").is_not(part.tasks.len())
            }
        }
        // Refused before.
        Atom::Tick(_) | Atom::Data { .. } | Atom::Violated(_) => any([]),
        Atom::Client(client, steps) => {
            let at = layout.client_step(*client);
            any(steps.iter().map(|&step| at.clone().is(step)))
        }
    }
}

/// Returns the condition that an executor has a codel: waiting, executing, or either.
fn in_phase(layout: &Layout, codel: CodelId, phase: StatePhase) -> Guard {
    let number = number(codel);
    any(layout.executors(codel).iter().map(|executor| match phase {
        StatePhase::Exec => executed(executor).is(number),
        StatePhase::Any => wanted(executor).is(number),
        StatePhase::Lock => all([wanted(executor).is(number), executed(executor).is_not(number)]),
    }))
}
