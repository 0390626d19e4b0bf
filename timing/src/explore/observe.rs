//! Evaluation of predicates on states, and observers of bounded response.

use super::state::{State, TaskStatus, control, phase, slot};
use super::step::Stepper;
use crate::property::{Atom, Predicate, SlotStatus, StatePhase, TaskState};

/// Whenever `trigger` becomes true, `response` is awaited.
#[derive(Debug, Clone)]
pub(crate) struct Observer {
    pub(crate) trigger: Predicate,
    pub(crate) response: Predicate,
}

/// The value of an atom.
pub(crate) fn atom(stepper: &Stepper, s: &State, atom: &Atom) -> bool {
    let l = &stepper.layout;
    match *atom {
        Atom::Task(task, state) => {
            let status = l.status(s, task);
            match state {
                TaskState::Idle => status == TaskStatus::Idle,
                TaskState::Waiting => status == TaskStatus::Waiting,
                TaskState::Running => status == TaskStatus::Running,
                TaskState::Active => status != TaskStatus::Idle,
            }
        }
        Atom::State {
            machine,
            state,
            phase,
        } => stepper.automata_of[machine]
            .iter()
            .any(|&a| l.at(s, a) as usize == state && in_phase(l.phase(s, a), phase)),
        Atom::Slot(service, status) => {
            let mut modes = stepper.system.services[service]
                .slots
                .iter()
                .map(|&a| l.mode(s, a));
            match status {
                SlotStatus::Void => modes.all(|it| it == slot::VOID),
                SlotStatus::Wait => modes.any(|it| it == slot::WAIT),
                SlotStatus::Run => modes.any(|it| it == slot::RUN),
                SlotStatus::Stop => modes.any(|it| matches!(it, slot::STOP | slot::STOPPING)),
                SlotStatus::Active => modes.any(|it| it != slot::VOID),
            }
        }
        Atom::Handling { service, phase } => {
            let component = stepper.system.services[service].component;
            matches!(l.control(s, component), control::VALIDATE | control::SIMPLE)
                && l.handled(s, component) as usize == service
                && in_phase(l.phase(s, l.control_executor(component)), phase)
        }
        Atom::ControlBusy(component) => l.control(s, component) != control::READY,
        Atom::Client(client, ref steps) => steps.contains(&(l.position(s, client) as usize)),
    }
}

fn in_phase(now: u16, wanted: StatePhase) -> bool {
    match now & !phase::ASYNC {
        phase::LOCKING => wanted != StatePhase::Exec,
        phase::EXECUTING => wanted != StatePhase::Lock,
        _ => false,
    }
}

/// A predicate in a state entered from `before` (`None`: the initial state).
pub(crate) fn predicate(
    stepper: &Stepper,
    before: Option<&State>,
    now: &State,
    it: &Predicate,
) -> bool {
    match before {
        Some(before) => it.eval(&|a, is_now| atom(stepper, if is_now { now } else { before }, a)),
        None => it.eval_still(&|a| atom(stepper, now, a)),
    }
}

/// Opens and closes the obligations of observers after a step.
pub(crate) fn observe(
    stepper: &Stepper,
    observers: &[Observer],
    before: Option<&State>,
    now: &mut State,
) {
    let l = &stepper.layout;
    for (i, observer) in observers.iter().enumerate() {
        let open = l.open(now, i) != 0;
        let reset = |now: &mut State, value| {
            l.set_open(now, i, value);
            if let Some(clock) = l.observer_clock[i] {
                now.t[clock] = 0;
            }
        };
        if open {
            if predicate(stepper, before, now, &observer.response) {
                reset(now, 0);
            }
        } else if predicate(stepper, before, now, &observer.trigger)
            && !before
                .is_some_and(|before| observer.trigger.eval_still(&|a| atom(stepper, before, a)))
            && !predicate(stepper, before, now, &observer.response)
        {
            reset(now, 1);
        }
    }
}
