//! The process that decides what follows an action at once, and when time may pass.

use dotgen_timing::system::ClientAction;

use crate::model::{Edge, Guard, LocationKind, Process, all, any, var};

use super::checks::{CALM, Checks, SCHEDULER};
use super::client::proceeds;
use super::layout::{Layout, position, step};

/// Returns the scheduler, with the observers and goals of the checks.
pub(super) fn process(layout: &Layout, checks: &Checks) -> Process {
    let mut out = Process::new(SCHEDULER, "what follows an action at once, and when time may pass");
    let first = checks.first_location();
    out.location("prepares", LocationKind::Committed, "before time 0");
    let mut edge = Edge::new("prepares", &first, "the state at time 0");
    if layout.jobs {
        edge = edge.when(layout.has_booted());
    }
    out.edge(edge.with(layout.beginning()));
    checks.observe(&mut out);
    let comment = "clients proceed, then tasks ask for a core, then cores are granted";
    out.location("settles", LocationKind::Committed, comment);
    out.location("busy", LocationKind::Urgent, "time does not pass");
    out.location(CALM, LocationKind::Normal, "time may pass");
    let proceeds = any(layout.system.clients.keys().map(|client| proceeds(layout, client)));
    let [asks, begins] = if layout.jobs {
        layout.releases()
    } else {
        let asks = layout.parts.iter().flat_map(|part| {
            let tasks = part.tasks.iter().filter(|task| task.needs_core);
            tasks.map(|task| all([task.begins(), task.could_run(part)]))
        });
        [any(asks), any([])]
    };
    let grants = grants(layout);
    if !layout.system.clients.is_empty() {
        let edge = Edge::new("settles", &first, "a client proceeds").sends("proceed");
        out.edge(edge);
    }
    if layout.cores().is_some() {
        let edge = Edge::new("settles", &first, "a task asks for a core").sends("ask");
        out.edge(edge.when(proceeds.negated()));
        let edge = Edge::new("settles", "busy", "a task gets a core").sends("grant");
        let ready = [proceeds.negated(), asks.negated(), begins.negated(), grants.clone()];
        out.edge(edge.when(all(ready)));
    }
    if layout.jobs {
        let edge = Edge::new("settles", "busy", "a task begins a cycle").sends("begin");
        out.edge(edge.when(proceeds.negated()));
    }
    let edge = Edge::new("settles", "busy", "nothing more follows at once");
    let settled = [proceeds, asks, begins, grants].map(|guard| guard.negated());
    out.edge(edge.when(all(settled)));
    let edge = Edge::new("busy", CALM, "no action must happen before time passes");
    out.edge(edge.when(urgent(layout).negated()));
    for source in ["busy", CALM] {
        out.edge(Edge::new(source, &first, "after an action").receives("step"));
    }
    checks.goals(&mut out);
    out
}

/// Returns the condition under which a core can be granted.
fn grants(layout: &Layout) -> Guard {
    let Some(cores) = layout.cores() else {
        return any([]);
    };
    let free = var("cores_used").below(cores);
    let waits = if layout.queues_for_cores() {
        var("core_waiting").at_least(1_usize)
    } else {
        let tasks = layout.parts.iter().flat_map(|part| &part.tasks);
        let tasks = tasks.filter(|task| task.needs_core);
        any(tasks.map(|task| task.position().is(position::WAITS)))
    };
    all([free, waits])
}

/// Returns the condition under which an action must happen before time passes, except those of urgent
/// locations and those that invariants enforce.
fn urgent(layout: &Layout) -> Guard {
    let mut out = Vec::new();
    if layout.jobs {
        out.push(layout.must_act());
    }
    for part in layout.parts.iter().filter(|_| !layout.jobs) {
        out.extend(part.tasks.iter().map(super::layout::TaskPart::begins));
        if part.queue {
            out.push(layout.first_can_begin(part));
        }
        if part.control {
            out.push(all([part.step().is(step::READY), part.own("ended").is(1_usize)]));
        }
    }
    for (id, client) in layout.system.clients.iter_enumerated() {
        for (at, client_step) in client.steps.iter().enumerate() {
            let ClientAction::Send { service, .. } = client_step.action else {
                continue;
            };
            let part = layout.part(layout.system.services[service].component);
            out.push(all([
                layout.client_step(id).is(at),
                layout.outstanding(id).is(0_usize),
                if layout.jobs { part.takes_requests() } else { part.step().is(step::READY) },
            ]));
        }
    }
    any(out)
}
