//! Snapshots of a run under way.

use std::collections::BTreeMap;

use dotgen_timing::explore::{Seen, Stepper, Work};
use dotgen_timing::report::{TimeUnit, Value};
use dotgen_timing::system::{AutomatonId, Ticks, TimedSystem, Yield};
use dotgen_timing::verify::Prepared;
use serde::Serialize;

use crate::counts::{MachineCounts, TaskCounts, machines, tasks};
use crate::tally::Tally;

/// Receives snapshots of a run under way.
pub trait ProgressReceiver {
    /// Returns true if a snapshot is due. The run waits while a snapshot is made.
    fn is_due(&mut self) -> bool;

    /// Receives a snapshot.
    fn receive(&mut self, progress: Progress);
}

/// A snapshot of a run.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Progress {
    pub unit: TimeUnit,
    /// Time since the start of the run.
    pub time: Value,
    /// Tasks, in order of declaration.
    pub tasks: Vec<TaskCounts>,
    /// State machines, with counts of their transitions.
    pub machines: Vec<MachineCounts>,
    /// States of permanent activities, and of activities under way.
    pub activities: Vec<ActivityState>,
    /// Number of violations so far.
    pub violation_count: u64,
}

/// An activity under way.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ActivityState {
    /// Name of its machine.
    pub machine: String,
    pub state: String,
    /// A codel of the state executes or waits for its locks. Otherwise the activity pauses before the state.
    pub executes: bool,
}

/// The present states of activities.
#[derive(Debug, Default)]
pub(crate) struct ActivityStates {
    /// By automaton and place: the state, and whether a codel of the state has begun.
    at: BTreeMap<(AutomatonId, usize), (usize, bool)>,
}

impl ActivityStates {
    /// Records an event.
    pub(crate) fn on_event(&mut self, system: &TimedSystem, seen: &Seen) {
        match *seen {
            Seen::Asked { work: Work::State { automaton, state, slot, .. }, .. } => {
                self.at.insert((automaton, slot), (state, true));
            }
            Seen::Ended { work, outcome, .. } => {
                let Work::State { automaton, slot, .. } = work else {
                    return;
                };
                match crate::decide::yield_of_outcome(system, &work, outcome) {
                    Some(Yield::Next(to) | Yield::Pause(to)) => {
                        self.at.insert((automaton, slot), (to, false));
                    }
                    Some(Yield::End) | None => {
                        self.at.remove(&(automaton, slot));
                    }
                }
            }
            _ => {}
        }
    }

    /// Returns a snapshot of a run.
    pub(crate) fn progress(
        &self,
        prepared: &Prepared,
        stepper: &Stepper,
        tally: &Tally,
        bounds: &[Option<Ticks>],
        violation_count: u64,
    ) -> Progress {
        let system = &prepared.built.system;
        let activities = self.at.iter().filter_map(|(&(number, slot), &(state, executes))| {
            let automaton = &system.automata[number];
            // An activity that was interrupted before its first codel has ended without a codel.
            if automaton.service.is_some() && stepper.activity(slot) != Some(number) {
                return None;
            }
            let machine = &system.machines[automaton.machine];
            Some(ActivityState {
                machine: machine.name.clone(),
                state: machine.states[state].name.clone(),
                executes,
            })
        });
        Progress {
            unit: prepared.report.unit,
            time: Value::Time(prepared.time(stepper.now())),
            tasks: tasks(prepared, tally, bounds, stepper.now()),
            machines: machines(prepared, tally),
            activities: activities.collect(),
            violation_count,
        }
    }
}
