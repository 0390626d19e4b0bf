//! The values of atoms under the rules of the servers.

use super::Servers;
use super::layout::{control, slot, thread};
use crate::explore::state::State;
use crate::property::{Atom, SlotStatus, StatePhase, TaskState};

impl Servers<'_> {
    /// Returns the value of an atom.
    pub(super) fn holds(&self, s: &State, atom: &Atom) -> bool {
        let l = &self.layout;
        match *atom {
            Atom::Task(task, state) => {
                let (waiting, active) = match l.thread_of(s, task) {
                    thread::WAITING => (true, true),
                    thread::AGAIN..=thread::EXECUTING => (false, true),
                    _ => (false, false),
                };
                match state {
                    TaskState::Idle => !active,
                    TaskState::Waiting => waiting,
                    TaskState::Running => active && !waiting,
                    TaskState::Active => active,
                }
            }
            Atom::State {
                machine,
                state,
                phase,
            } => (0..l.tasks).any(|task| {
                let now = match l.thread_of(s, task) {
                    thread::TICKET | thread::QUEUED => StatePhase::Lock,
                    thread::EXECUTING => StatePhase::Exec,
                    _ => return false,
                };
                let slot = l.turn(s, task);
                let automaton = l.automaton(s, slot).checked_sub(1);
                let same = automaton.is_some_and(|automaton| {
                    self.system.automata[automaton as usize].machine == machine
                });
                same && l.at(s, slot) as usize == state
                    && (phase == StatePhase::Any || phase == now)
            }),
            Atom::Slot(service, status) => {
                let tasks = &self.system.components[self.system.services[service].component].tasks;
                let mut modes = tasks
                    .iter()
                    .flat_map(|&task| l.slots(task))
                    .filter(|&slot| self.service(s, slot) == Some(service))
                    .map(|slot| l.mode(s, slot) & slot::STATUS);
                match status {
                    SlotStatus::Void => modes.next().is_none(),
                    SlotStatus::Wait => modes.any(|mode| mode == slot::INIT),
                    SlotStatus::Run => modes.any(|mode| mode == slot::RUN),
                    SlotStatus::Stop => modes.any(|mode| mode == slot::STOP),
                    SlotStatus::Active => modes.next().is_some(),
                }
            }
            Atom::Handling {
                service,
                codel,
                phase,
            } => {
                let component = self.system.services[service].component;
                let now = match l.control(s, component) {
                    control::TICKET | control::QUEUED => StatePhase::Lock,
                    control::EXECUTING => StatePhase::Exec,
                    _ => return false,
                };
                l.handled(s, component) == Some(service)
                    && codel.is_none_or(|codel| {
                        self.codel(s, l.control_executor(component)) == Some(codel)
                    })
                    && (phase == StatePhase::Any || phase == now)
            }
            Atom::ControlBusy(component) => l.control(s, component) != control::READY,
            Atom::Client(client, ref steps) => steps.contains(&(l.position(s, client) as usize)),
        }
    }
}
