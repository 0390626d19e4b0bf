//! The rules of the published models (sections 3 to 9 of the timed semantics): jobs, and control tasks that
//! handle a message at once.
//!
//! There is one process for each permanent activity and each place of an activity, besides those of tasks,
//! timers, control tasks and clients, and one that starts the tasks of a component. A task gives turns to its
//! activities, one after the other. An activity whose turn is over gives the word back.

mod activity;
mod control;
mod cycle;
mod start;

use crate::model::Network;

use super::checks::Checks;
use super::layout::Layout;

/// Adds the processes of all components.
pub(super) fn add(layout: &Layout, checks: &Checks, network: &mut Network) {
    for part in &layout.parts {
        network.processes.push(start::process(layout, part));
        for task in &part.tasks {
            network.processes.extend(super::timer::process(layout, task, checks));
            network.processes.push(cycle::process(layout, part, task, checks));
            for automaton in layout.automata(task.id) {
                network.processes.push(activity::process(layout, part, automaton));
            }
        }
        if part.control {
            network.processes.push(control::process(layout, part));
        }
    }
}
