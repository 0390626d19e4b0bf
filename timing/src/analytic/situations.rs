//! The situations of clients: positions with the requests that can be under way there.

use rustc_hash::FxHashSet;

use crate::scn::semantics::Slots;
use crate::system::{Client, ClientAction, ServiceId, TimedSystem};

/// Number of situations of a client above which its windows are not told apart.
const MAX_SITUATIONS: usize = 2_000;

/// Requests under way: the service, the trackers that follow the request, and the step that sent it.
pub(super) type UnderWay = Vec<(ServiceId, Vec<usize>, usize)>;

/// The situations of a client: positions with the requests that can be under way there. `None`: there are too
/// many.
pub(super) type Situations = Option<FxHashSet<(usize, UnderWay)>>;

/// Returns the situations of each client.
///
/// A request whose end is not awaited stays under way for ever, unless it is a function or attribute: these
/// have ended when the control task takes the next request.
pub(super) fn situations(system: &TimedSystem) -> Vec<Situations> {
    system.clients.iter().map(|client| situations_of(system, client)).collect()
}

fn situations_of(system: &TimedSystem, client: &Client) -> Situations {
    let mut stack: Vec<(usize, UnderWay)> =
        client.first.iter().map(|&index| (index, Vec::new())).collect();
    let mut seen: FxHashSet<(usize, UnderWay)> = stack.iter().cloned().collect();
    while let Some((at, under_way)) = stack.pop() {
        let Some(step) = client.steps.get(at) else {
            continue;
        };
        let mut after = under_way;
        match step.action {
            ClientAction::Send { service, ref trackers, .. } => {
                let component = system.services[service].component;
                after.retain(|(other, ..)| {
                    let other = &system.services[*other];
                    other.activity || other.component != component
                });
                for (_, known, _) in &mut after {
                    known.retain(|tracker| !trackers.contains(tracker));
                }
                let already = after.iter().filter(|entry| entry.0 == service).count();
                if already < places(system, service) {
                    after.push((service, trackers.clone(), at));
                } else {
                    // It has the place of one that is over, or is refused.
                    after.iter_mut().filter(|entry| entry.0 == service).for_each(|one| one.2 = at);
                }
                after.sort_unstable();
            }
            ClientAction::AwaitEnded(tracker) | ClientAction::AwaitOutcome(tracker, _) => {
                after.retain(|entry| !entry.1.contains(&tracker));
            }
            ClientAction::AwaitAccepted | ClientAction::AwaitAny | ClientAction::Delay(..) => {}
        }
        for &next in &step.next {
            let situation = (next, after.clone());
            if seen.len() > MAX_SITUATIONS {
                return None;
            }
            if seen.insert(situation.clone()) {
                stack.push(situation);
            }
        }
    }
    Some(seen)
}

/// Returns the number of requests of a service that can be under way at the same time.
fn places(system: &TimedSystem, service: ServiceId) -> usize {
    let slots = &system.services[service].slots;
    match slots.first() {
        Some(&slot) if system.platform.semantics.fixed().slots == Slots::OfTask => {
            system.tasks[system.automata[slot].task].places as usize
        }
        Some(_) => slots.len(),
        None => 1,
    }
}
