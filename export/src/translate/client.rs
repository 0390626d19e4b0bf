//! The process of a client.

use dotgen_timing::explore::Action;
use dotgen_timing::system::{ClientAction, ClientId, FOREVER};

use crate::model::{Edge, Guard, LocationKind, Process, Relation, Update, any};

use super::layout::{Layout, tracked};

/// Returns the process of a client. A location is a step; the last one has no edges.
pub(super) fn process(layout: &Layout, id: ClientId) -> Process {
    let client = &layout.system.clients[id];
    let name = layout.client_name(id);
    let clock = format!("x_{name}");
    let mut out = Process::new(&format!("client_{name}"), format!("client {name}"));
    out.location("starts", LocationKind::Normal, "before its first step");
    let location = |step: usize| {
        if step == client.done() { "done".to_owned() } else { format!("step_{step}") }
    };
    let arrive = |edge: Edge, next: usize| {
        let mut edge = edge.with([layout.client_step(id).set(next)]);
        if let Some(ClientAction::Delay(..)) = client.steps.get(next).map(|step| &step.action) {
            edge.updates.push(Update::Reset(clock.clone()));
        }
        edge
    };
    for &next in &client.first {
        let edge = Edge::new("starts", &location(next), "begins").receives("proceed");
        out.edge(arrive(edge.begins(Action::Proceed { client: id, next }), next));
    }
    for (at, step) in client.steps.iter().enumerate() {
        let here = location(at);
        match step.action {
            ClientAction::Send { service, .. } => {
                let comment = format!("requests {}", layout.system.service_path(service));
                out.location(&here, LocationKind::Normal, comment);
            }
            ClientAction::Delay(lower, upper) => {
                let comment = format!("lets time pass: {}", layout.interval(lower, upper));
                let most = (upper != FOREVER).then_some(i64::from(upper));
                out.bounded(&here, &clock, most, comment);
            }
            _ => out.location(&here, LocationKind::Normal, "waits"),
        }
        for &next in &step.next {
            let edge = |comment: &str| Edge::new(&here, &location(next), comment);
            out.edge(match &step.action {
                ClientAction::Send { service, trackers, .. } => {
                    let outstanding = layout.outstanding(id);
                    let edge = edge("the control task takes the request")
                        .when(outstanding.clone().is(0_usize))
                        .sends(layout.request(id, *service))
                        .begins(Action::Request { client: id, next })
                        .with([outstanding.set(1_usize)]);
                    let follow = trackers
                        .iter()
                        .map(|&tracker| layout.tracker(id, tracker).set(tracked::HANDLED));
                    arrive(edge.with(follow), next)
                }
                ClientAction::Delay(lower, _) => {
                    let executor = layout.client_executor(id);
                    let edge = edge("the delay ends").sends("step");
                    let edge = edge.begins(Action::Finish { executor, outcome: next });
                    arrive(edge.when_clock(&clock, Relation::AtLeast, *lower), next)
                }
                ClientAction::AwaitAny => {
                    let edge = edge("the outcome is known").receives("proceed");
                    let guard = waits_for(layout, id, next).unwrap_or(any([]));
                    arrive(edge.when(guard).begins(Action::Proceed { client: id, next }), next)
                }
                _ => {
                    let edge = edge("what it waits for has happened").receives("proceed");
                    let guard = waits_for(layout, id, at).unwrap_or(any([]));
                    arrive(edge.when(guard).begins(Action::Proceed { client: id, next }), next)
                }
            });
        }
    }
    out.location("done", LocationKind::Normal, "after its last step");
    out
}

/// Returns the condition that ends the wait of a step; `None` unless it waits for the control task.
fn waits_for(layout: &Layout, id: ClientId, step: usize) -> Option<Guard> {
    match layout.system.clients[id].steps[step].action {
        ClientAction::AwaitAccepted => Some(layout.outstanding(id).is(0_usize)),
        ClientAction::AwaitEnded(tracker) => {
            let fails = layout.asks_outcome(id, tracker);
            let tracker = layout.tracker(id, tracker);
            let failed = fails.then(|| tracker.clone().is(tracked::FAILED));
            Some(any(std::iter::once(tracker.is(tracked::NOTHING)).chain(failed)))
        }
        ClientAction::AwaitOutcome(tracker, success) => {
            let value = if success { tracked::NOTHING } else { tracked::FAILED };
            Some(layout.tracker(id, tracker).is(value))
        }
        ClientAction::AwaitAny => {
            let next = layout.system.clients[id].steps[step].next.iter();
            Some(any(next.filter_map(|&next| waits_for(layout, id, next))))
        }
        ClientAction::Send { .. } | ClientAction::Delay(..) => None,
    }
}

/// Returns the condition under which a client can proceed without any other action.
pub(super) fn proceeds(layout: &Layout, id: ClientId) -> Guard {
    let client = &layout.system.clients[id];
    let at = |step: usize| layout.client_step(id).is(step);
    let waits = (0..client.done()).filter_map(|step| {
        let guard = waits_for(layout, id, step)?;
        Some(crate::model::all([at(step), guard]))
    });
    any(waits.chain([at(client.done() + 1)]))
}
