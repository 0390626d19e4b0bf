//! The order in which the tasks of a component are started, each after the first pass of the one before.
//!
//! The first pass of a task that is not followed takes a bounded time if the task waits for no core, and its
//! codel is bounded. Otherwise the next task is started at any time, or never.

use super::others::{OtherThread, interference};
use super::span::Span;
use super::thread::{Start, Thread};
use crate::system::{CodelSet, FOREVER, TaskId, TimedSystem};

/// Sets the starts and successors of all tasks, and the interference with their first passes.
/// `enough`: no task waits for a core.
pub(super) fn chain(system: &TimedSystem, threads: &mut [Thread], enough: bool) {
    let periodic = system.tasks.keys().filter(|&task| system.tasks[task].period.is_some());
    let first_tick = periodic.filter_map(|task| system.first_tick(task)).min();
    let first_tick = first_tick.and_then(|tick| i64::try_from(tick).ok());
    for component in &system.components {
        let mut before: Option<usize> = None;
        let mut start = Start::AT_ONCE;
        let mut earlier: Vec<(OtherThread, bool)> = Vec::new();
        for &task in &component.tasks {
            let number = threads.iter().position(|thread| thread.task == task);
            if let Some(number) = number {
                let others = earlier.iter().filter(|(_, on)| !on).map(|(one, _)| one.clone());
                let thread = &mut threads[number];
                thread.early = interference(system, &others.collect::<Vec<_>>());
                thread.start = start;
                thread.started = before.is_some() && start.after.is_some();
                if let Some(before) = before.filter(|_| start.after.is_some()) {
                    threads[before].next_task = Some(task);
                }
                (before, start) = (Some(number), Start::AT_ONCE);
            } else {
                // Until the first tick, tasks without a period have the cores to themselves.
                let alone = before.is_none()
                    && (start.after)
                        .is_some_and(|span| first_tick.is_none_or(|tick| span.to < tick));
                let has_core = enough || alone || !system.needs_core(task);
                let others = earlier.iter().map(|(other, _)| other.clone());
                start = start.then(first_pass(system, task, &others.collect::<Vec<_>>(), has_core));
            }
            let mut codels = CodelSet::default();
            if let Some(automaton) = system.tasks[task].permanent {
                let states = system.machine_of(automaton).states.iter();
                states.for_each(|state| codels.insert(state.codel));
            }
            let component = system.tasks[task].component;
            earlier.push((OtherThread { component, codels }, number.is_some()));
        }
    }
}

/// Returns the length of the first pass of a task that is not followed. `others` are the tasks before it.
fn first_pass(system: &TimedSystem, task: TaskId, others: &[OtherThread], has_core: bool) -> Start {
    let unknown = Start { after: None, fails: true };
    let task = &system.tasks[task];
    if task.period.is_some() || !has_core {
        return unknown;
    }
    let machine = task.permanent.map(|automaton| system.machine_of(automaton));
    let Some(state) = machine.and_then(|machine| machine.states.get(machine.start)) else {
        return Start::AT_ONCE;
    };
    let codel = &system.codels[state.codel];
    let waits = interference(system, others)
        .map_or(Some(0), |interference| interference.longest[state.codel]);
    match waits.filter(|_| codel.upper != FOREVER) {
        None => unknown,
        Some(waits) => Start {
            after: Some(Span { from: i64::from(codel.lower), to: waits + i64::from(codel.upper) }),
            fails: codel.throws,
        },
    }
}
