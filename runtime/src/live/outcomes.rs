//! The outcomes in the model that results of codels stand for.

use dotgen_timing::explore::Work;
use dotgen_timing::system::Yield;

use super::Live;
use crate::hosts::{CodelEnd, CodelResult};
use crate::watch::CodelViolation;

impl Live<'_> {
    /// Returns the outcome of a codel that a host has executed, as an index in a list of possible outcomes.
    /// `None`: the outcome is drawn.
    pub fn outcome(&mut self, executor: usize, outcomes: &[usize]) -> Option<usize> {
        let running = self.running.get(executor)?.as_ref()?;
        if !running.real {
            return None;
        }
        let (work, ran) = (running.work, running.ran.as_ref()?);
        let wanted = self.outcome_of_result(&work, ran);
        let Some(wanted) = wanted else {
            let codel = work.codel()?;
            self.broken.push(CodelViolation::Undeclared {
                codel: self.system.codels[codel].path.to_string(),
                function: self.parts.function(codel),
                event: ran.name.clone(),
            });
            // Servers end an activity that has yielded an undeclared event, as after an exception.
            if let Some(Some(running)) = self.running.get_mut(executor) {
                running.undeclared = true;
            }
            return Some(self.exception_index(&work, outcomes));
        };
        match outcomes.iter().position(|&outcome| outcome == wanted) {
            Some(place) => Some(place),
            None => Some(self.exception_index(&work, outcomes)),
        }
    }

    /// Returns the index of an exception among outcomes; if exceptions make no difference, that of the end.
    fn exception_index(&self, work: &Work, outcomes: &[usize]) -> usize {
        let Work::State { automaton, state, .. } = *work else {
            return outcomes.iter().position(|&outcome| outcome == 1).unwrap_or(0);
        };
        let yields = &self.system.machine_of(automaton).states[state].yields;
        let exception = outcomes.iter().position(|&outcome| outcome == yields.len());
        let end = || outcomes.iter().position(|&outcome| yields.get(outcome) == Some(&Yield::End));
        exception.or_else(end).unwrap_or(0)
    }

    /// Returns the outcome that an event stands for; `None` if the event is not declared.
    fn outcome_of_result(&self, work: &Work, ran: &CodelResult) -> Option<usize> {
        let codel = work.codel()?;
        match (*work, ran.how) {
            (_, CodelEnd::Other) => None,
            (Work::Control { .. }, CodelEnd::Event) => ran.name.is_empty().then_some(0),
            (Work::Control { .. }, CodelEnd::Exception) => Some(1),
            (Work::State { automaton, state, .. }, how) => {
                let machine = self.system.machine_of(automaton);
                let yields = &machine.states.get(state)?.yields;
                if how == CodelEnd::Exception {
                    return Some(yields.len());
                }
                let wanted = self.parts.yield_of(codel, machine, &ran.name)?;
                yields.iter().position(|transition| *transition == wanted)
            }
            (Work::Delay { .. }, _) => None,
        }
    }
}
