//! The clock of a component, as one timer for each periodic task.

use dotgen_timing::explore::Action;

use crate::model::{Edge, LocationKind, Process, Relation, Update};

use super::checks::Checks;
use super::layout::{Layout, TaskPart};

/// Returns the timer of a periodic task: ticks at D, D + P, … for a delay D above 0, else at P, 2 P, ….
pub(super) fn process(layout: &Layout, task: &TaskPart, checks: &Checks) -> Option<Process> {
    let period = task.period?;
    let delay = i64::from(layout.system.tasks[task.id].delay);
    let clock = task.timer();
    let mut out = Process::new(
        &format!("timer_{}", task.name),
        format!(
            "the ticks of {}: period {}, delay {}",
            layout.task_in_words(task.id),
            layout.time(period),
            layout.time(delay)
        ),
    );
    let add = |out: &mut Process, name: &str, most: i64, comment: &str| {
        out.location(name, LocationKind::Normal, comment);
        if let Some(location) = out.locations.last_mut() {
            location.invariant = Some((clock.clone(), most));
        }
        for (guard, updates, comment) in checks.at_tick(task) {
            let edge = Edge::new(name, "later", comment).when(guard);
            let edge = edge.when_clock(&clock, Relation::Equal, most);
            let edge = edge.begins(Action::Tick { task: task.id.into() });
            let tick = [task.due().set(1_usize), Update::Reset(clock.clone())];
            out.edges.push(edge.sends("step").with(updates).with(tick));
        }
    };
    if layout.jobs {
        // The timer starts with its task.
        out.location("off", LocationKind::Normal, "before the start of the task");
        let first = if delay > 0 { "first" } else { "later" };
        let start = Edge::new("off", first, "starts");
        let start = start.receives(&format!("start_{}", task.name));
        out.edge(start.with([Update::Reset(clock.clone())]));
        if delay > 0 {
            add(
                &mut out,
                "first",
                period + delay,
                "before the first tick, a period after the delay",
            );
        }
    } else if delay > 0 {
        add(&mut out, "first", delay, "before the first tick, which comes after the delay");
    }
    add(&mut out, "later", period, "before a tick, which comes one period after the last");
    Some(out)
}
