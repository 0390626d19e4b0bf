//! The values of atoms.

use super::Rules;
use super::points::Cycle;
use super::status::{control, slot};
use crate::explore::state::{State, TaskStatus, phase};
use crate::property::{Atom, SlotStatus, StatePhase, TaskState, monitor};
use crate::system::ServiceId;

impl Rules<'_> {
    /// Returns the value of an atom of a predicate.
    pub(crate) fn atom(&self, s: &State, atom: &Atom) -> bool {
        let l = &self.layout;
        match *atom {
            Atom::Task(task, state) => {
                let status = l.status(s, usize::from(task));
                match state {
                    TaskState::Idle => status == TaskStatus::Idle,
                    TaskState::Waiting => status == TaskStatus::Waiting,
                    TaskState::Running => status == TaskStatus::Running,
                    TaskState::Active => status != TaskStatus::Idle,
                }
            }
            Atom::State { machine, state, phase } => (0..l.threads).any(|executor| {
                self.slot_of(s, executor).is_some_and(|slot| {
                    l.at(s, slot) as usize == state
                        && (l.automaton(s, slot)).is_some_and(|automaton| {
                            self.system.automata[automaton].machine == machine
                        })
                        && self.is_in_phase(s, executor, phase)
                })
            }),
            Atom::Slot(service, status) => self.has_slots(s, service, status),
            Atom::Handling { service, codel, phase } => {
                let component = self.system.services[service].component;
                let executor = l.control_executor(component);
                (control::TICKET..=control::EXECUTING).contains(&l.control(s, component))
                    && l.handled(s, component) == Some(service)
                    && codel.is_none_or(|codel| self.codel(s, executor) == Some(codel))
                    && self.is_in_phase(s, executor, phase)
            }
            Atom::ControlBusy(component) => l.control(s, component) != control::READY,
            Atom::Client(client, ref steps) => steps.contains(&(l.position(s, client) as usize)),
            Atom::Tick(task) => {
                let period = self.system.tasks[task].period;
                self.next_tick(s, usize::from(task)).is_some_and(|(left, _)| Some(left) == period)
            }
            Atom::Data { fact, negated } => {
                self.frame().fact(s, fact).is_some_and(|holds| holds != negated)
            }
            Atom::Violated(monitor) => self.frame().monitor(s, monitor) == monitor::VIOLATED,
        }
    }

    /// Returns true if the activities of a service have a status.
    fn has_slots(&self, s: &State, service: ServiceId, status: SlotStatus) -> bool {
        let l = &self.layout;
        let tasks = &self.system.components[self.system.services[service].component].tasks;
        let mut statuses = (tasks.iter())
            .flat_map(|&task| l.slots(usize::from(task)))
            .filter(|&&slot| {
                l.activity(s, slot) != slot::VOID && self.service(s, slot) == Some(service)
            })
            .map(|&slot| match l.mode(s, slot) {
                // With jobs an interrupted activity counts as stopping at once.
                mode if mode & slot::MARK != 0 && self.points.cycle == Cycle::Jobs => slot::STOP,
                mode => mode & slot::STATUS,
            });
        match status {
            SlotStatus::Void => statuses.next().is_none(),
            SlotStatus::Wait => statuses.any(|status| status == slot::INIT),
            SlotStatus::Run => statuses.any(|status| status == slot::RUN),
            SlotStatus::Stop => statuses.any(|status| status == slot::STOP),
            SlotStatus::Active => statuses.next().is_some(),
        }
    }

    /// Returns true if an executor with a codel waits for locks, or executes, as the phase demands.
    fn is_in_phase(&self, s: &State, executor: usize, wanted: StatePhase) -> bool {
        if self.layout.is_executing(s, executor) {
            return wanted != StatePhase::Lock;
        }
        let at_rest = self.layout.phase(s, executor) == phase::REST;
        // With passes an executor without a phase has not taken its ticket yet.
        wanted != StatePhase::Exec && !(at_rest && self.points.cycle == Cycle::Jobs)
    }
}
