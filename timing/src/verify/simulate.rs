//! Runs of a report that a user continues with other steps.

use std::sync::Arc;

use super::group::Group;
use super::{SystemInput, events};
use crate::explore::{Action, NextStep, Run, SystemRun};
use crate::report::{Event, TimeUnit};
use crate::scn::names::Names;
use crate::system::{ComponentId, TaskId, ThreadName, TimedSystem};

/// A run up to one of its events, continued by chosen steps.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The run in words.
    pub events: Vec<Event>,
    /// End of the run, in the unit of the report.
    pub end: f64,
    /// The possible next steps. Any of them may be chosen.
    pub choices: Vec<Choice>,
    /// Number of events before each chosen step.
    pub taken: Vec<usize>,
}

/// A possible next step.
#[derive(Debug, Clone)]
pub enum Choice {
    /// An action: its thread, and its first event in words.
    Step(ThreadName, String),
    /// An action without an event, in words.
    Silent(String),
    /// Time passes, in the unit of the report, until something may happen.
    Wait(f64),
}

impl Group<'_> {
    /// Keeps a run, to be continued.
    pub(super) fn kept(&self, run: &Run) -> Option<Arc<SystemRun>> {
        let arc = SystemRun { system: self.built.shared(), run: run.clone() };
        (!run.left_out).then(|| Arc::new(arc))
    }
}

impl SystemRun {
    /// Returns the first step whose action is not possible at its time; `None` if the run is one of the
    /// system.
    pub fn impossible_step(&self) -> Option<usize> {
        self.run.impossible_step(&self.system)
    }

    /// Continues the run after one of its events, or from its beginning if there is no such event. Each
    /// number in `take` is an index into the choices at that point.
    pub fn simulate(
        &self,
        input: &SystemInput,
        unit: TimeUnit,
        after: usize,
        take: &[usize],
    ) -> Simulation {
        let names = Names::new(&input.specs);
        let system = &self.system;
        let (_, ends) = self.run.moments_by_step(system);
        // An event belongs to the step after which the list is longer than its index.
        let steps = ends.partition_point(|&end| end <= after);
        let continued = self.run.continued(system, steps, take);
        let time = |ticks: u64| unit.from_seconds(system.seconds(ticks));
        let (_, ends) = continued.run.moments_by_step(system);
        let events = events::told(&names, system, unit, &continued.run);
        let choices = continued.next.iter().map(|(next, first)| match (next, first) {
            (NextStep::Wait(ticks), _) => Choice::Wait(time(u64::from(*ticks))),
            (NextStep::Action(_), Some(moment)) => {
                Choice::Step(events::thread(system, moment), moment.what.clone())
            }
            (NextStep::Action(action), None) => Choice::Silent(silent(system, *action)),
        });
        Simulation {
            choices: choices.collect(),
            taken: continued.before.iter().map(|&before| ends[before]).collect(),
            end: time(continued.run.end),
            events,
        }
    }
}

/// Describes an action without an event.
fn silent(system: &TimedSystem, action: Action) -> String {
    let executor = |index: usize| match index.checked_sub(system.tasks.len()) {
        None => system.task_path(TaskId::from(index)),
        Some(component) => (system.components.get(ComponentId::from(component)))
            .map_or_else(String::new, |component| component.name.clone()),
    };
    let component = |component: ComponentId| &system.components[component].name;
    match action {
        Action::Ticket { executor: index } => format!("{} queues for its locks", executor(index)),
        Action::Ready { executor: index } => format!("{} becomes ready", executor(index)),
        Action::Begin { task } => format!("{} begins a pass", system.task_path(task.into())),
        Action::Wake { task } => {
            format!("{} wakes the other tasks of its component", system.task_path(task.into()))
        }
        Action::Signal { component: index } => {
            format!("{} handles the ends of activities", component(index))
        }
        Action::Reply { component: index } => format!("{} replies", component(index)),
        Action::Shut { component: index } => {
            format!("{} goes on with its shutdown", component(index))
        }
        Action::Proceed { client, .. } => format!("{} goes on", system.clients[client].name),
        _ => "a step inside the system".to_owned(),
    }
}
