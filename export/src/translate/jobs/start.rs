//! The process that starts the tasks of a component, each after the first codel of the previous one.

use crate::model::{Edge, LocationKind, Process, all, var};

use super::super::layout::{Layout, Part, position, step};
use super::super::published::{BOOTED, permanent};

/// Returns the process of a component's start.
pub(super) fn process(layout: &Layout, part: &Part) -> Process {
    let name = format!("start_{}", part.name);
    let mut out = Process::new(&name, format!("the start of {}", part.name));
    out.location("starts", LocationKind::Committed, "starts the next task");
    out.location("waits", LocationKind::Normal, "waits for the end of the first codel");
    out.location("done", LocationKind::Normal, "all tasks are started");
    let starting = part.own("starting");
    // At time 0, components start one after the other.
    let may_start = var(BOOTED).at_least(usize::from(part.id));
    for (index, task) in part.tasks.iter().enumerate() {
        let here = all([starting.clone().is(index), may_start.clone()]);
        let idle = task.position().set(position::IDLE);
        let mut edge = Edge::new("starts", "", format!("starts {}", task.name));
        edge = edge.when(here).with([idle]);
        if task.period.is_some() {
            let timed = format!("times_{index}");
            out.location(&timed, LocationKind::Committed, "after the start of the timer");
            edge.target.clone_from(&timed);
            out.edge(edge.sends(&format!("start_{}", task.name)));
            edge = Edge::new(&timed, "", format!("goes on with {}", task.name));
        }
        let Some(activity) = layout.system.tasks[task.id].permanent else {
            "starts".clone_into(&mut edge.target);
            out.edge(edge.with([starting.clone().set(index + 1)]));
            continue;
        };
        "waits".clone_into(&mut edge.target);
        let start = layout.system.machine_of(activity).start;
        let updates =
            [layout.mode(activity).set(permanent::FIRST_CODEL), layout.state(activity).set(start)];
        out.edge(edge.sends(&layout.turn(activity)).with(updates));
    }
    let last = Edge::new("starts", "done", "all tasks are started: it accepts requests");
    let last = last.when(all([starting.clone().is(part.tasks.len()), may_start]));
    let ready = part.step().set(step::READY);
    out.edges.extend(layout.ends_step(last.with([ready])));
    let next = Edge::new("waits", "starts", "the first codel has ended");
    let next = next.receives(&format!("started_{}", part.name));
    out.edge(next.with([starting.clone().set(starting.plus(1))]));
    out
}
