//! How far a run has come, for whoever looks on while it goes on.

use std::collections::BTreeMap;

use dotgen_timing::explore::{Seen, Stepper, Work};
use dotgen_timing::report::Value;
use dotgen_timing::system::{Ticks, TimedSystem, Yield};
use dotgen_timing::verify::Prepared;
use serde::Serialize;

use crate::counted::{OfMachine, OfTask, machines, tasks};
use crate::tally::Tally;

/// Whoever looks on.
pub trait Follow {
    /// Whether to be told now: telling takes time, in which nothing of the run happens.
    fn wants(&mut self) -> bool;

    /// How far the run has come.
    fn hear(&mut self, progress: Progress);
}

/// How far a run has come.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Progress {
    /// Unit of all times.
    pub unit: String,
    /// Time since its start.
    pub time: Value,
    /// Tasks, in order of declaration.
    pub tasks: Vec<OfTask>,
    /// State machines, with how often their transitions were taken.
    pub machines: Vec<OfMachine>,
    /// Where they are: permanent activities, and activities that are under way.
    pub activities: Vec<OfActivity>,
    /// Violations so far.
    pub violation_count: u64,
}

/// An activity that is under way.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct OfActivity {
    /// The name of its machine.
    pub machine: String,
    /// Its state.
    pub state: String,
    /// A codel of that is executed now, or waits for its locks; else it pauses before that state.
    pub executes: bool,
}

/// The states that activities are in.
#[derive(Debug, Default)]
pub(crate) struct States {
    /// By automaton and place: the state, and whether a codel of it has begun.
    at: BTreeMap<(usize, usize), (usize, bool)>,
}

impl States {
    /// Something was seen.
    pub(crate) fn see(&mut self, system: &TimedSystem, seen: &Seen) {
        match *seen {
            Seen::Asked {
                work:
                    Work::State {
                        automaton,
                        state,
                        slot,
                        ..
                    },
                ..
            } => {
                self.at.insert((automaton, slot), (state, true));
            }
            Seen::Ended { work, outcome, .. } => {
                let Work::State {
                    automaton, slot, ..
                } = work
                else {
                    return;
                };
                match crate::decide::yielded(system, &work, outcome) {
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

    /// How far a run has come.
    pub(crate) fn progress(
        &self,
        prepared: &Prepared,
        stepper: &Stepper,
        tally: &Tally,
        bounds: &[Option<Ticks>],
        violation_count: u64,
    ) -> Progress {
        let system = &prepared.built.system;
        let activities = self
            .at
            .iter()
            .filter_map(|(&(number, slot), &(state, executes))| {
                let automaton = &system.automata[number];
                // One that was interrupted before it began anything has ended without a codel.
                if automaton.service.is_some() && stepper.activity(slot) != Some(number) {
                    return None;
                }
                let machine = &system.machines[automaton.machine];
                Some(OfActivity {
                    machine: machine.name.clone(),
                    state: machine.states[state].name.clone(),
                    executes,
                })
            });
        Progress {
            unit: prepared.report.unit.clone(),
            time: Value::Time(prepared.time(stepper.now())),
            tasks: tasks(prepared, tally, bounds, stepper.now()),
            machines: machines(prepared, tally),
            activities: activities.collect(),
            violation_count,
        }
    }
}
