//! The values of predicates, and the ages of obligations.

use dotgen_timing::property::{Atom, Predicate, SlotStatus, StatePhase, TaskState};

use super::Brute;
use super::state::{Doing, Mode, State, Status};

impl Brute<'_> {
    /// Updates obligations. Every time the trigger becomes true an obligation begins, which proceeds from
    /// response to response.
    pub(super) fn watch(&self, before: Option<&State>, now: &mut State) {
        for (i, bound) in self.within.iter().enumerate() {
            let value = |predicate: &Predicate| self.predicate(before, now, predicate);
            let mut open = now.obligations[i].clone();
            let was =
                before.is_some_and(|before| self.predicate(Some(before), before, &bound.trigger));
            if value(&bound.trigger) && !was {
                open.insert((0, 0));
            }
            let moved = open.into_iter().map(|(mut stage, age)| {
                while bound.responses.get(stage).is_some_and(value) {
                    stage += 1;
                }
                (stage, age)
            });
            now.obligations[i] = moved.filter(|at| at.0 < bound.responses.len()).collect();
        }
    }

    pub(super) fn predicate(
        &self,
        before: Option<&State>,
        now: &State,
        predicate: &Predicate,
    ) -> bool {
        match predicate {
            Predicate::Atom(atom) => self.atom(now, atom),
            Predicate::Leave(atom) => {
                before.is_some_and(|before| self.atom(before, atom)) && !self.atom(now, atom)
            }
            Predicate::Not(predicate) => !self.predicate(before, now, predicate),
            Predicate::And(a, b) => {
                self.predicate(before, now, a) && self.predicate(before, now, b)
            }
            Predicate::Or(a, b) => self.predicate(before, now, a) || self.predicate(before, now, b),
        }
    }

    fn atom(&self, s: &State, atom: &Atom) -> bool {
        match *atom {
            Atom::Task(t, state) => match state {
                TaskState::Idle => s.tasks[usize::from(t)].status == Status::Idle,
                TaskState::Waiting => s.tasks[usize::from(t)].status == Status::Waiting,
                TaskState::Running => s.tasks[usize::from(t)].status == Status::Running,
                TaskState::Active => s.tasks[usize::from(t)].status != Status::Idle,
            },
            Atom::State { machine, state, phase } => s.automata.keys().any(|a| {
                self.system.automata[a].machine == machine
                    && s.automata[a].at == state
                    && match s.automata[a].doing {
                        Doing::Nothing => false,
                        Doing::Locking => phase != StatePhase::Exec,
                        Doing::Executing(_) => phase != StatePhase::Lock,
                    }
            }),
            Atom::Slot(service, status) => {
                let mut modes =
                    self.system.services[service].slots.iter().map(|&a| s.automata[a].mode);
                match status {
                    SlotStatus::Void => modes.all(|mode| mode == Mode::Void),
                    SlotStatus::Wait => modes.any(|mode| mode == Mode::Wait),
                    SlotStatus::Run => modes.any(|mode| mode == Mode::Run),
                    SlotStatus::Stop => modes.any(|mode| mode == Mode::Stop),
                    SlotStatus::Active => modes.any(|mode| mode != Mode::Void),
                }
            }
            Atom::Handling { .. }
            | Atom::ControlBusy(_)
            | Atom::Client(..)
            | Atom::Tick(_)
            | Atom::Data { .. }
            | Atom::Violated(_) => {
                unreachable!("not generated")
            }
        }
    }
}
