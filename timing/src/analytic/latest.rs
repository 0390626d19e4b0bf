//! The latest times at which clients leave their steps, and at which their requests are over.
//!
//! Clients act at once: only delays, control tasks and the requests that they await hold them up. So if it is
//! known when each request is over, latest times of all later steps follow.

use super::situations::Situations;
use crate::system::{Client, ClientAction, ServiceId};

/// The time of what may never happen.
pub(super) const NEVER: u64 = u64::MAX;

/// The latest times of a client, in base units; [`NEVER`] if none is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Latest {
    /// By position: the client is there no longer.
    pub(super) left: Vec<u64>,
    /// By step: its request plays no part any more.
    pub(super) over: Vec<u64>,
}

/// The latest times of requests, by service and by the latest time at which the client sends the request.
pub(super) trait Requested {
    /// The control task has handled the request.
    fn handled(&self, service: ServiceId, sent: u64) -> u64;
    /// The client has seen the end.
    fn over(&self, service: ServiceId, handled: u64) -> u64;
}

/// Returns the latest times of a client with certain situations.
pub(super) fn latest(
    client: &Client,
    situations: &Situations,
    requested: &dyn Requested,
) -> Latest {
    let count = client.steps.len();
    let never = Latest { left: vec![NEVER; count + 1], over: vec![NEVER; count] };
    let (Some(situations), None) = (situations, client.awaits_event) else {
        return never;
    };
    let handled = |step: usize, arrives: &[u64]| match client.steps[step].requests() {
        Some(service) => requested.handled(service, arrives[step]),
        None => arrives[step],
    };
    let over = |step: usize, arrives: &[u64]| match client.steps[step].requests() {
        Some(service) => requested.over(service, handled(step, arrives)),
        None => NEVER,
    };
    // The time at which the client goes on, if it does.
    let leaves = |at: usize, arrives: &[u64]| match client.steps[at].action {
        ClientAction::Delay(_, upper) => arrives[at].saturating_add(u64::from(upper)),
        ClientAction::Send { .. } => handled(at, arrives),
        ClientAction::AwaitAccepted => arrives[at],
        ClientAction::AwaitAny => NEVER,
        ClientAction::AwaitEnded(tracker) | ClientAction::AwaitOutcome(tracker, _) => {
            let here = situations.iter().filter(|situation| situation.0 == at);
            let tracked = here.flat_map(|(_, requests)| requests.iter());
            let tracked = tracked.filter(|request| request.1.contains(&tracker));
            tracked.map(|request| over(request.2, arrives)).fold(arrives[at], u64::max)
        }
    };
    // Least fixed point: longest paths, and no time for what follows a loop that lets time pass.
    let mut arrives = vec![0; count + 1];
    for round in 0.. {
        let mut next = arrives.clone();
        for (at, step) in client.steps.iter().enumerate() {
            let leaves = leaves(at, &arrives);
            step.next.iter().for_each(|&to| next[to] = next[to].max(leaves));
        }
        if next == arrives {
            break;
        }
        if round > count {
            let grown = next.iter_mut().zip(&arrives).filter(|(next, before)| **next > **before);
            grown.for_each(|(next, _)| *next = NEVER);
        }
        arrives = next;
    }
    let left = |at: usize| match client.steps.get(at).map(|step| &step.action) {
        // It goes on with one outcome only.
        None | Some(ClientAction::AwaitOutcome(..)) => NEVER,
        Some(_) => leaves(at, &arrives),
    };
    Latest {
        left: (0..=count).map(left).collect(),
        over: (0..count).map(|step| over(step, &arrives)).collect(),
    }
}
