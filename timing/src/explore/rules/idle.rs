//! Tasks between two cycles, and their work at the next tick if nothing else happens before.

use super::Rules;
use super::points::Cycle;
use super::status::{flag, permanent, slot, thread};
use super::work::IdleTurn;
use crate::explore::state::{State, phase};

impl Rules<'_> {
    /// Returns the work of the next cycle of a task, if the task is between two cycles, is periodic, needs no
    /// core, has no tick left, and if exactly one automaton has work: it is paused, and not interrupted.
    pub(in crate::explore) fn idle_turn(&self, s: &State, task: usize) -> Option<IdleTurn> {
        let l = &self.layout;
        let busy = flag::TICK | flag::WAKE | flag::FIRST | flag::CORE | flag::LATE;
        let is_idle = l.thread_of(s, task) == thread::IDLE && !l.has(s, task, busy);
        if !is_idle || !self.is_periodic(task) || self.system.platform.cores.is_some() {
            return None;
        }
        let mut only = None;
        for &path in l.slots(task) {
            if self.is_paused(s, path)? && only.replace(path).is_some() {
                return None;
            }
        }
        let slot = only?;
        let state = l.at(s, slot) as usize;
        let automaton = l.automaton(s, slot)?;
        self.system.machine_of(automaton).states.get(state)?;
        let executor = match self.points.cycle {
            Cycle::Jobs => slot,
            Cycle::Passes => task,
        };
        let tick = l.timer(s, task);
        Some(IdleTurn { executor, slot, automaton, state, tick })
    }

    /// Returns true if the automaton in a slot is paused, and false if it has no work. `None`: it may do
    /// something else than to continue from its pause.
    fn is_paused(&self, s: &State, path: usize) -> Option<bool> {
        let l = &self.layout;
        let mode = l.mode(s, path);
        if self.points.cycle == Cycle::Jobs {
            let automaton = l.automaton(s, path)?;
            if self.system.automata[automaton].service.is_none() {
                return match mode {
                    permanent::NORMAL => (l.phase(s, path) == phase::REST).then_some(true),
                    permanent::ENDED => Some(false),
                    _ => None,
                };
            }
        }
        match mode & slot::STATUS {
            slot::VOID | slot::ETHER => Some(false),
            slot::RUN | slot::STOP if mode & slot::MARK == 0 => match self.points.cycle {
                Cycle::Jobs => (l.phase(s, path) == phase::REST).then_some(true),
                Cycle::Passes => (mode & slot::PAUSED != 0).then_some(true),
            },
            _ => None,
        }
    }
}
