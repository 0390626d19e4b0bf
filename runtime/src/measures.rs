//! Measures of a scenario: clients that wait for an event of the run.

use dotgen_timing::explore::{Seen, Stepper, Work};
use dotgen_timing::system::TimedSystem;
use dotgen_timing::system::indexed::{Built, Measure, MeasureEvent};

use crate::checker::{RunChecker, Violation};
use crate::port_writes::PortWrites;
use crate::watch::CodelViolation;

/// The measures of a run.
pub(crate) struct Measures<'p> {
    system: &'p TimedSystem,
    all: &'p [Measure],
    /// Whether each measure has begun.
    begun: Vec<bool>,
    /// Number of violations of the checker that were looked at.
    seen: usize,
}

impl<'p> Measures<'p> {
    pub(crate) fn new(built: &'p Built) -> Self {
        let all = &built.measures[..];
        Measures { system: &built.system, all, begun: vec![false; all.len()], seen: 0 }
    }

    /// The next run begins.
    pub(crate) fn next_run(&mut self) {
        self.begun.fill(false);
    }

    /// Returns whether a measure has begun, if the work is its wait for the event; `None` for other work.
    pub(crate) fn begun(&self, work: &Work) -> Option<bool> {
        let Work::Delay { client } = *work else { return None };
        let at = self.all.iter().position(|measure| measure.client == client)?;
        Some(self.begun[at])
    }

    /// Returns true if the run must end after a measure that is over.
    pub(crate) fn stop(&self, stepper: &Stepper) -> bool {
        let begun = self.all.iter().zip(&self.begun).filter(|pair| *pair.1);
        begun.into_iter().any(|(measure, _)| measure.stops && stepper.has_ended(measure.client))
    }

    pub(crate) fn on_event(&mut self, seen: &Seen) {
        if let Seen::Missed { task } = *seen {
            let path = self.system.task_path(task.into());
            self.begin(&|event| matches!(event, MeasureEvent::LateTask(of) if *of == path));
        }
    }

    pub(crate) fn on_violation(&mut self, violation: &CodelViolation) {
        match violation {
            CodelViolation::Overrun { codel, .. } => {
                let executes = |task: &str| self.executes(task, codel);
                let is_late = |event: &MeasureEvent| match event {
                    MeasureEvent::LateCodel(of) => of == codel,
                    MeasureEvent::LateTask(of) => executes(of),
                    _ => false,
                };
                let late: Vec<bool> =
                    self.all.iter().map(|measure| measure.events.iter().any(is_late)).collect();
                self.begun.iter_mut().zip(late).for_each(|(begun, late)| *begun |= late);
            }
            CodelViolation::Lost { component, .. } => {
                self.begin(&|event| matches!(event, MeasureEvent::Lost(of) if of == component));
            }
            CodelViolation::Undeclared { .. } => {}
        }
    }

    /// Looks at the violations of checks that are new.
    pub(crate) fn on_checked(&mut self, judge: &RunChecker<'_>) {
        while let Some((_, violation)) = judge.violations.get(self.seen) {
            self.seen += 1;
            if let Violation::Check(check) = *violation
                && let Some(name) = judge.name_of(check)
            {
                self.begin(&|event| matches!(event, MeasureEvent::Violation(of) if of == name));
            }
        }
    }

    /// Looks for ports that were not written for too long. `now` is the time of all runs, in base units.
    pub(crate) fn on_moment(&mut self, now: u64, ports: &PortWrites) {
        let unit = self.system.unit;
        self.begin(&|event| match *event {
            MeasureEvent::Stale { component, port, after } => {
                let units = (after / unit).ceil().to_integer();
                let age = ports.age(now, (component, port));
                age.is_some_and(|age| i128::from(age) > units)
            }
            _ => false,
        });
    }

    fn begin(&mut self, by: &dyn Fn(&MeasureEvent) -> bool) {
        for (measure, begun) in self.all.iter().zip(&mut self.begun) {
            *begun |= measure.events.iter().any(by);
        }
    }

    /// Returns true if a task executes a codel of this path.
    fn executes(&self, task: &str, codel: &str) -> bool {
        self.system.automata.iter().any(|automaton| {
            let states = &self.system.machines[automaton.machine].states;
            self.system.task_path(automaton.task) == task
                && states.iter().any(|state| *self.system.codels[state.codel].path == *codel)
        })
    }
}
