//! The values of atoms under the published rules.

use super::Published;
use super::layout::{control, slot};
use crate::explore::state::{State, TaskStatus, phase};
use crate::property::{Atom, SlotStatus, StatePhase, TaskState};

impl Published<'_> {
    /// Returns the value of an atom.
    pub(super) fn value_of(&self, s: &State, atom: &Atom) -> bool {
        let l = &self.layout;
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
            } => self.automata_of[machine]
                .iter()
                .any(|&a| l.at(s, a) as usize == state && in_phase(l.phase(s, a), phase)),
            Atom::Slot(service, status) => {
                let mut modes = self.system.services[service]
                    .slots
                    .iter()
                    .map(|&a| l.mode(s, a));
                match status {
                    SlotStatus::Void => modes.all(|mode| mode == slot::VOID),
                    SlotStatus::Wait => modes.any(|mode| mode == slot::WAIT),
                    SlotStatus::Run => modes.any(|mode| mode == slot::RUN),
                    SlotStatus::Stop => {
                        modes.any(|mode| matches!(mode, slot::STOP | slot::STOPPING))
                    }
                    SlotStatus::Active => modes.any(|mode| mode != slot::VOID),
                }
            }
            Atom::Handling {
                service,
                codel,
                phase,
            } => {
                let component = self.system.services[service].component;
                l.request(s, component)
                    .is_some_and(|request| request.0 == service)
                    && codel.is_none_or(|codel| {
                        self.codel(s, l.control_executor(component)) == Some(codel)
                    })
                    && in_phase(l.phase(s, l.control_executor(component)), phase)
            }
            Atom::ControlBusy(component) => l.control(s, component) != control::READY,
            Atom::Client(client, ref steps) => steps.contains(&(l.position(s, client) as usize)),
        }
    }
}

fn in_phase(now: u16, wanted: StatePhase) -> bool {
    match now & !phase::ASYNC {
        phase::LOCKING => wanted != StatePhase::Exec,
        phase::EXECUTING => wanted != StatePhase::Lock,
        _ => false,
    }
}
