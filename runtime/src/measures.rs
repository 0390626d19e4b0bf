//! Measures of a scenario: clients that wait for an event of the run.

use dotgen_timing::explore::{Seen, Stepper, Work};
use dotgen_timing::system::TimedSystem;
use dotgen_timing::system::indexed::{Built, Measure, MeasureEvent};

use crate::checker::RunChecker;
use crate::port_writes::PortWrites;
use crate::watch::CodelViolation;

/// The measures of a run.
pub(crate) struct Measures<'p> {
    system: &'p TimedSystem,
    all: &'p [Measure],
    /// The measures that have begun in the present run.
    begun: Vec<bool>,
    /// The violations seen so far in all runs, by check.
    seen: Vec<u64>,
    /// The number of all violations when they were last compared.
    compared: u64,
}

impl<'p> Measures<'p> {
    pub(crate) fn new(built: &'p Built) -> Self {
        let all = &built.measures[..];
        Measures {
            system: &built.system,
            all,
            begun: vec![false; all.len()],
            seen: Vec::new(),
            compared: 0,
        }
    }

    /// Prepares for the next run.
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
        let mut begun = self.all.iter().zip(&self.begun).filter(|(_, begun)| **begun);
        begun.any(|(measure, _)| measure.stops && stepper.has_ended(measure.client))
    }

    pub(crate) fn on_event(&mut self, seen: &Seen) {
        if let Seen::Missed { task } = *seen {
            let path = self.system.task_path(task.into());
            self.begin(|event| matches!(event, MeasureEvent::LateTask(of) if *of == path));
        }
    }

    pub(crate) fn on_violation(&mut self, violation: &CodelViolation) {
        match violation {
            CodelViolation::Overrun { codel, .. } => {
                let system = self.system;
                self.begin(|event| match event {
                    MeasureEvent::LateCodel(of) => of == codel,
                    MeasureEvent::LateTask(of) => executes(system, of, codel),
                    _ => false,
                });
            }
            CodelViolation::Lost { component, .. } => {
                self.begin(|event| matches!(event, MeasureEvent::Lost(of) if of == component));
            }
            CodelViolation::Undeclared { .. } => {}
        }
    }

    /// Begins measures of checks that were violated since the last call.
    pub(crate) fn on_checked(&mut self, judge: &RunChecker<'_>) {
        if judge.count == self.compared {
            return;
        }
        self.compared = judge.count;
        self.seen.resize(judge.answers.len(), 0);
        for (check, answer) in judge.answers.iter().enumerate() {
            let before = std::mem::replace(&mut self.seen[check], answer.violations);
            if answer.violations > before
                && let Some(name) = judge.name_of(check)
            {
                self.begin(|event| matches!(event, MeasureEvent::Violation(of) if of == name));
            }
        }
    }

    /// Begins measures of ports that were not written for too long. `now` is in base units.
    pub(crate) fn on_moment(&mut self, now: u64, ports: &PortWrites) {
        let unit = self.system.unit;
        self.begin(|event| match *event {
            MeasureEvent::Stale { component, port, after } => {
                let units = (after / unit).ceil().to_integer();
                let age = ports.age(now, (component, port));
                age.is_some_and(|age| i128::from(age) > units)
            }
            _ => false,
        });
    }

    fn begin(&mut self, is_event: impl Fn(&MeasureEvent) -> bool) {
        for (measure, begun) in self.all.iter().zip(&mut self.begun) {
            *begun |= measure.events.iter().any(&is_event);
        }
    }
}

/// Returns true if a task executes a codel of this path.
fn executes(system: &TimedSystem, task: &str, codel: &str) -> bool {
    system.automata.iter().any(|automaton| {
        let states = &system.machines[automaton.machine].states;
        system.task_path(automaton.task) == task
            && states.iter().any(|state| *system.codels[state.codel].path == *codel)
    })
}
