//! Counts of tasks and state machines, as data: for reports, and for the progress of a run.

use dotgen_timing::report::Value;
use dotgen_timing::system::{TaskId, Ticks, TimedSystem, Yield};
use dotgen_timing::verify::Prepared;
use serde::{Deserialize, Serialize};

use crate::tally::Tally;

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct TaskCounts {
    /// `component.task`
    pub task: String,
    /// Jobs that have ended.
    pub jobs: u64,
    /// Greatest response time, including that of a job that has not ended, in the unit of the report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest: Option<Value>,
    /// Sum of the response times of the jobs that have ended.
    pub total: Value,
    /// Mean response time of the jobs that have ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<Value>,
    /// Proved bound on the response time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<Value>,
    /// Ticks that came before the previous job had ended.
    pub missed: u64,
    /// Share of the time in which a codel of the activities held its locks, while it executed or waited for a
    /// core. `None` if no codel of the activities has an execution time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<f64>,
}

/// The counts of an output port.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct PortCounts {
    /// `component/port`
    pub port: String,
    /// Number of writes.
    pub writes: u64,
    /// Greatest age of its data: the longest time without a write after the first one, in the unit of the
    /// report. `None` if it was never written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest_age: Option<Value>,
}

/// The counts of a state machine.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MachineCounts {
    /// `component.owner`
    pub machine: String,
    pub transitions: Vec<Transition>,
}

/// The counts of a transition.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Transition {
    /// State.
    pub from: String,
    /// Yield of its codel: a state, with `pause::` before it, or `ether`.
    pub to: String,
    /// Number of times that the transition was taken.
    pub taken: u64,
    /// Greatest time of the codel before this transition; `None` if the transition was never taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub greatest: Option<Value>,
}

/// Returns true if a codel of the activities of a task has an execution time.
pub fn has_times(system: &TimedSystem, task: usize) -> bool {
    let machines = system.automata.iter().filter(|automaton| automaton.task == TaskId::from(task));
    let mut states = machines.flat_map(|machine| &system.machines[machine.machine].states);
    states.any(|state| system.codels[state.codel].upper > 0)
}

/// Returns the paths of codels without an execution time, without repetition.
pub fn codels_without_time(system: &TimedSystem) -> Vec<String> {
    let codels = system.codels.iter();
    let codels_without_time = codels.filter(|codel| codel.site.is_some() && codel.upper == 0);
    let mut out: Vec<String> = codels_without_time.map(|codel| codel.path.to_string()).collect();
    out.sort();
    out.dedup();
    out
}

/// Returns the counts of tasks after a time in base units.
pub(crate) fn tasks(
    prepared: &Prepared,
    tally: &Tally,
    bounds: &[Option<Ticks>],
    time: u64,
) -> Vec<TaskCounts> {
    let system = &prepared.built.system;
    let value = |ticks: Ticks| Value::Time(prepared.time(u64::from(ticks)));
    let tasks = system.tasks.iter().zip(&tally.tasks).enumerate();
    let tasks = tasks.map(|(task, (entry, counted))| TaskCounts {
        task: system.task_path(TaskId::from(task)),
        jobs: counted.jobs.count,
        greatest: counted.greatest.map(value),
        total: Value::Time(prepared.time(counted.jobs.total)),
        mean: mean(prepared.time(counted.jobs.total), counted.jobs.count),
        bound: bounds.get(task).copied().flatten().map(value),
        period: entry.period.map(value),
        missed: counted.missed,
        load: has_times(system, task).then(|| counted.executed as f64 / time.max(1) as f64),
    });
    tasks.collect()
}

/// Returns the mean of times with this sum.
pub(crate) fn mean(total: f64, count: u64) -> Option<Value> {
    (count > 0).then(|| Value::Time(total / count as f64))
}

/// Returns the counts of state machines, with their transitions.
pub(crate) fn machines(prepared: &Prepared, tally: &Tally) -> Vec<MachineCounts> {
    let machines = prepared.built.system.machines.iter();
    let machines = machines.zip(&tally.transitions);
    let machines = machines.map(|(machine, counts)| {
        let mut transitions = Vec::new();
        for (state, counts) in machine.states.iter().zip(counts) {
            for (outcome, times) in counts.iter().enumerate() {
                let taken = times.count;
                let name = |state: usize| machine.states[state].name.clone();
                let to = match state.yields.get(outcome) {
                    Some(&Yield::Next(to)) => name(to),
                    Some(&Yield::Pause(to)) => format!("pause::{}", name(to)),
                    Some(Yield::End) => "ether".to_owned(),
                    None if taken == 0 => continue,
                    None => "exception".to_owned(),
                };
                let from = state.name.clone();
                let greatest =
                    (taken > 0).then(|| Value::Time(prepared.time(u64::from(times.greatest))));
                transitions.push(Transition { from, to, taken, greatest });
            }
        }
        MachineCounts { machine: machine.name.clone(), transitions }
    });
    machines.collect()
}
