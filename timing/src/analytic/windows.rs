//! The requests that can play a part in a window of time, according to the order and the delays of the
//! clients.
//!
//! A request plays a part from the moment at which the control task takes it until a client has seen its end.
//! A window begins in some situation of each client: a position, and the requests under way. In the window, a
//! client gets as far as its delays allow; everything else that it waits for may take no time.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rustc_hash::FxHashSet;
use typed_index_collections::{TiVec, ti_vec};

use super::latest::{Latest, NEVER};
use super::situations::{Situations, UnderWay};
use crate::scn::semantics::StartUp;
use crate::system::{
    Automaton, AutomatonId, Client, ClientAction, ClientStep, ComponentId, Machine, ServiceId,
    Ticks, TimedSystem,
};

/// The greatest number of requests of each service in a window; `None`: no limit is known.
pub(super) type Requests = TiVec<ServiceId, Option<u32>>;

/// A window of time, by the requests that can play a part in it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct ClientWindow {
    pub(super) requests: Requests,
    /// The earliest time at which it can begin, in base units.
    pub(super) begins: u64,
    /// The latest time at which it can begin.
    pub(super) until: u64,
}

impl ClientWindow {
    /// A window at any time.
    pub(super) fn any_time(requests: Requests) -> ClientWindow {
        ClientWindow { requests, begins: 0, until: NEVER }
    }
}

/// Number of windows above which they are not told apart.
const MAX_WINDOWS: usize = 24;

/// Returns the windows of a length. For each window of the system, one of them has at least as many requests
/// and does not begin later.
pub(super) fn windows(
    system: &TimedSystem,
    situations: &[Situations],
    length: Ticks,
) -> Vec<ClientWindow> {
    let clients = system.clients.iter().zip(situations);
    let of_clients = clients
        .map(|(client, situations)| of_client(system, client, situations.as_ref(), length, None));
    together(system, of_clients)
}

/// Returns the windows of a length of each client that begins when its latest times allow it.
pub(super) fn timed_windows(
    system: &TimedSystem,
    situations: &[Situations],
    length: Ticks,
    latest: &[Latest],
) -> Vec<Vec<ClientWindow>> {
    let clients = system.clients.iter().zip(situations).zip(latest);
    let windows = clients.map(|((client, situations), latest)| {
        of_client(system, client, situations.as_ref(), length, Some(latest))
    });
    windows.collect()
}

/// Returns the greatest requests in a window that begins at a time.
pub(super) fn requests_at(
    system: &TimedSystem,
    of_clients: &[Vec<ClientWindow>],
    time: u64,
) -> Vec<Requests> {
    let at = |window: &&ClientWindow| (window.begins..=window.until).contains(&time);
    let of_clients = of_clients.iter().map(|windows| {
        let requests = windows.iter().filter(at).map(|window| window.requests.clone());
        greatest(requests.map(ClientWindow::any_time).collect())
    });
    together(system, of_clients).into_iter().map(|window| window.requests).collect()
}

/// Returns the windows of all clients together.
fn together(
    system: &TimedSystem,
    of_clients: impl Iterator<Item = Vec<ClientWindow>>,
) -> Vec<ClientWindow> {
    let mut out = vec![ClientWindow::any_time(ti_vec![Some(0); system.services.len()])];
    for of_client in of_clients {
        let both = |one: &ClientWindow, other: &ClientWindow| ClientWindow {
            requests: sum(&one.requests, &other.requests),
            begins: one.begins.max(other.begins),
            until: one.until.min(other.until),
        };
        let all = out.iter().flat_map(|one| of_client.iter().map(move |other| both(one, other)));
        out = greatest(all.collect());
        if out.len() > MAX_WINDOWS {
            out = vec![hull(&out)];
        }
    }
    out
}

/// Returns the greatest number of requests in the whole run.
pub(super) fn whole_run(system: &TimedSystem) -> Requests {
    let none = ti_vec![Some(0); system.services.len()];
    system.clients.iter().fold(none, |all, client| sum(&all, &of_whole_run(system, client)))
}

fn of_whole_run(system: &TimedSystem, client: &Client) -> Requests {
    let mut out = ti_vec![Some(0u32); system.services.len()];
    for (at, step) in client.steps.iter().enumerate() {
        if let ClientAction::Send { service, .. } = step.action {
            let again = client.comes_again(at);
            out[service] = out[service].filter(|_| !again).map(|number| number + 1);
        }
    }
    out
}

fn of_client(
    system: &TimedSystem,
    client: &Client,
    situations: Option<&FxHashSet<(usize, UnderWay)>>,
    length: Ticks,
    latest: Option<&Latest>,
) -> Vec<ClientWindow> {
    let Some(situations) = situations else {
        return vec![ClientWindow::any_time(of_whole_run(system, client))];
    };
    // The delay of a position may be over only after its time.
    let times = reached(client, &client.first, false, &|service| accepts_from(system, service));
    // The least time from a request to the same request.
    let rounds: Vec<Option<u64>> = (client.steps.iter().enumerate())
        .map(|(at, step)| reached(client, &step.next, false, &|_| 0)[at])
        .collect();
    let of_situation = |(at, under_way): &(usize, UnderWay)| {
        let begins = times[*at].unwrap_or(0);
        let mut out = ti_vec![Some(0u32); system.services.len()];
        for (step, elapsed) in reached(client, &[*at], true, &|_| 0).into_iter().enumerate() {
            // A job is over before the end of the window.
            let left = elapsed.and_then(|elapsed| u64::from(length).checked_sub(elapsed + 1));
            let requests = client.steps.get(step).and_then(ClientStep::requests);
            let (Some(left), Some(service)) = (left, requests) else {
                continue;
            };
            let count = match rounds[step] {
                None => Some(1),
                Some(0) => None,
                Some(round) => u32::try_from(left / round + 1).ok(),
            };
            out[service] = out[service].zip(count).map(|(sum, count)| sum + count);
        }
        // A window that begins long before the client can go on does not reach its next step.
        let goes_on = match client.steps.get(*at).map(|step| &step.action) {
            Some(ClientAction::Delay(lower, _)) => begins + u64::from(*lower),
            Some(ClientAction::Send { service, .. }) => begins.max(accepts_from(system, *service)),
            _ => begins,
        };
        // Requests that are over play no part any more.
        let over = |step: usize| latest.map_or(NEVER, |latest| latest.over[step]);
        let left = latest.map_or(NEVER, |latest| latest.left[*at]);
        let mut ends: Vec<u64> =
            under_way.iter().map(|request| over(request.2).min(left)).collect();
        ends.push(left);
        ends.sort_unstable();
        ends.dedup();
        let (mut since, mut windows) = (0, Vec::new());
        for until in ends {
            let mut requests = ti_vec![Some(0u32); system.services.len()];
            for (service, ..) in under_way.iter().filter(|request| over(request.2) >= until) {
                requests[*service] = requests[*service].map(|number| number + 1);
            }
            let begins = begins.max(since);
            let full = ClientWindow {
                requests: sum(&requests, &out),
                begins: begins.max(goes_on.saturating_sub(u64::from(length))),
                until,
            };
            windows.extend([ClientWindow { requests, begins, until }, full]);
            since = until;
        }
        windows
    };
    let mut all: FxHashSet<ClientWindow> = situations.iter().flat_map(of_situation).collect();
    all.retain(|window| window.begins <= window.until);
    greatest(all.drain().collect())
}

/// Returns the time before which a component takes no request: with the semantics of the servers, the last of
/// the first ticks of its tasks.
fn accepts_from(system: &TimedSystem, service: ServiceId) -> u64 {
    if system.platform.semantics.fixed().start_up == StartUp::FirstCodel {
        return 0;
    }
    let tasks = system.components[system.services[service].component].tasks.iter();
    tasks.filter_map(|&task| system.first_tick(task)).max().unwrap_or(0)
}

/// Returns the least time after which each step, and the end, can be reached from some steps. `over`: their
/// own delays may be over. `accepts`: the time before which a request is not taken.
fn reached(
    client: &Client,
    from: &[usize],
    over: bool,
    accepts: &dyn Fn(ServiceId) -> u64,
) -> Vec<Option<u64>> {
    let mut out: Vec<Option<u64>> = vec![None; client.done() + 1];
    let mut heap: BinaryHeap<Reverse<(u64, bool, usize)>> =
        from.iter().map(|&step| Reverse((0, !over, step))).collect();
    while let Some(Reverse((time, is_ahead, at))) = heap.pop() {
        if out[at].is_some() {
            continue;
        }
        out[at] = Some(time);
        let Some(step) = client.steps.get(at) else {
            continue;
        };
        let left = match step.action {
            ClientAction::Delay(lower, _) if is_ahead => time + u64::from(lower),
            ClientAction::Send { service, .. } => time.max(accepts(service)),
            _ => time,
        };
        heap.extend(step.next.iter().map(|&next| Reverse((left, true, next))));
    }
    out
}

/// Returns, by automaton, whether it can be interrupted, or stop because its component shuts down: a codel of
/// a permanent activity throws. An activity marks only instances that are under way at the same time.
pub(super) fn stops(system: &TimedSystem, situations: &[Situations]) -> TiVec<AutomatonId, bool> {
    let services = system.services.len();
    // By service: those that can be under way at the same time as another request.
    let mut together: TiVec<ServiceId, TiVec<ServiceId, bool>> =
        ti_vec![ti_vec![false; services]; services];
    let requested: Vec<Vec<ServiceId>> = (system.clients.iter())
        .map(|client| client.steps.iter().filter_map(ClientStep::requests).collect())
        .collect();
    for (number, situations) in situations.iter().enumerate() {
        let mut meet = |one: ServiceId, other: ServiceId| {
            together[one][other] = true;
            together[other][one] = true;
        };
        let own = &requested[number];
        if let Some(all) = situations {
            for (_, under_way) in all {
                for (at, (one, ..)) in under_way.iter().enumerate() {
                    under_way[at + 1..].iter().for_each(|(other, ..)| meet(*one, *other));
                }
            }
        } else {
            pairs(own, own).for_each(|(one, other)| meet(one, other));
        }
        for others in &requested[..number] {
            pairs(own, others).for_each(|(one, other)| meet(one, other));
        }
    }
    let stops = |automaton: &Automaton| {
        let interrupted = automaton.service.is_some_and(|service| {
            let mut others = system.services.iter_enumerated();
            others.any(|(other, entry)| {
                entry.interrupts.contains(&service) && together[other][service]
            })
        });
        interrupted || shuts_down(system, system.tasks[automaton.task].component)
    };
    system.automata.iter().map(stops).collect()
}

/// Returns true if a component can shut down because a codel of a permanent activity throws.
pub(super) fn shuts_down(system: &TimedSystem, component: ComponentId) -> bool {
    let throws =
        |machine: &Machine| machine.states.iter().any(|state| system.codels[state.codel].throws);
    let mut tasks = system.components[component].tasks.iter();
    tasks.any(|&task| system.tasks[task].permanent.is_some_and(|a| throws(system.machine_of(a))))
}

fn pairs<'r>(
    own: &'r [ServiceId],
    others: &'r [ServiceId],
) -> impl Iterator<Item = (ServiceId, ServiceId)> + 'r {
    own.iter().flat_map(move |&one| others.iter().map(move |&other| (one, other)))
}

fn sum(one: &Requests, other: &Requests) -> Requests {
    let pairs = one.iter().zip(other);
    pairs
        .map(|(one, other)| one.zip(*other).map(|(one, other)| one.saturating_add(other)))
        .collect()
}

/// Returns a window with the greatest number of requests of each service.
fn hull(all: &[ClientWindow]) -> ClientWindow {
    let services = all[0].requests.keys();
    let requests = services.map(|service| {
        let counts = all.iter().map(|window| window.requests[service]);
        let counts: Option<Vec<u32>> = counts.collect();
        counts.map(|counts| counts.into_iter().max().unwrap_or(0))
    });
    let begins = all.iter().map(|window| window.begins).min().unwrap_or(0);
    let until = all.iter().map(|window| window.until).max().unwrap_or(NEVER);
    ClientWindow { requests: requests.collect(), begins, until }
}

/// Leaves out the windows for which another one counts.
fn greatest(mut all: Vec<ClientWindow>) -> Vec<ClientWindow> {
    let within = |one: &ClientWindow, other: &ClientWindow| {
        let mut pairs = one.requests.iter().zip(&other.requests);
        other.begins <= one.begins
            && one.until <= other.until
            && pairs
                .all(|(one, other)| other.is_none() || one.is_some_and(|one| Some(one) <= *other))
    };
    all.sort();
    all.dedup();
    let mut out: Vec<ClientWindow> = Vec::new();
    for window in all {
        if out.iter().any(|other| within(&window, other)) {
            continue;
        }
        out.retain(|other| !within(other, &window));
        out.push(window);
    }
    out
}
