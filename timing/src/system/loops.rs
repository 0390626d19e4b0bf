//! Cycles of codel states without pause, and the loop limit (sections 5 and 14).
//!
//! With a limit of *n*, one turn enters no state more than *n* times. A permanent activity from
//! which neither a pause nor `ether` can be reached has turns that never end; there the limit counts
//! *rounds*: when every yield of a state is used up, a new round begins with any of them but the
//! state itself.

use rustc_hash::FxHashSet;

use super::{Machine, Yield};

/// Cycles of states without a pause, one per strongly connected set of states, each beginning and ending with
/// the same state. They let a job take arbitrarily long.
pub fn pauseless_cycles(machine: &Machine) -> Vec<Vec<usize>> {
    let n = machine.states.len();
    let mut found = Vec::new();
    let mut covered = vec![false; n];
    for start in 0..n {
        if covered[start] {
            continue;
        }
        // Shortest way back, breadth first.
        let mut from = vec![usize::MAX; n];
        let mut queue = std::collections::VecDeque::from([start]);
        'search: while let Some(at) = queue.pop_front() {
            for it in &machine.states[at].yields {
                let &Yield::Next(next) = it else { continue };
                if next == start {
                    let mut path = vec![start];
                    let mut back = at;
                    while back != start {
                        path.push(back);
                        back = from[back];
                    }
                    path.push(start);
                    path.reverse();
                    for &state in &path {
                        covered[state] = true;
                    }
                    found.push(path);
                    break 'search;
                }
                if from[next] == usize::MAX {
                    from[next] = at;
                    queue.push_back(next);
                }
            }
        }
    }
    found
}

/// Whether a turn that begins in `state` can ever end.
pub(crate) fn can_pause(machine: &Machine, state: usize) -> bool {
    let mut seen = vec![false; machine.states.len()];
    let mut stack = vec![state];
    while let Some(at) = stack.pop() {
        if std::mem::replace(&mut seen[at], true) {
            continue;
        }
        for it in &machine.states[at].yields {
            match *it {
                Yield::Next(next) => stack.push(next),
                Yield::Pause(_) | Yield::End => return true,
            }
        }
    }
    false
}

/// The states that a machine can come to without being interrupted, if it can neither pause nor end in any of
/// them.
pub(crate) fn runs_for_ever(machine: &Machine) -> Option<Vec<usize>> {
    let mut found = vec![machine.start];
    let mut at = 0;
    while let Some(&state) = found.get(at) {
        at += 1;
        for it in &machine.states[state].yields {
            match *it {
                Yield::Next(next) if !found.contains(&next) => found.push(next),
                Yield::Next(_) => {}
                Yield::Pause(_) | Yield::End => return None,
            }
        }
    }
    Some(found)
}

/// More combinations of state and visits than this are not looked at.
const COMBINATIONS: usize = 20_000;

/// States in which a turn cannot go on under the loop limit of the machine. Where there are very many
/// combinations of states and visits, perhaps not all.
pub fn loop_contradictions(machine: &Machine) -> Vec<usize> {
    let limit = machine.loop_limit;
    limit.map_or(Vec::new(), |limit| stuck_states(machine, limit).0)
}

/// Whether `loop once` makes sense for the machine. If it does not, no limit does: the way on which a state
/// used up its yields enters no state twice, so the part of it that begins with the first of these can be
/// repeated as often as a limit allows.
pub(crate) fn can_be_limited(machine: &Machine) -> bool {
    stuck_states(machine, 1).0.is_empty()
}

/// States in which a turn cannot go on under a limit, and whether all combinations were looked at.
fn stuck_states(machine: &Machine, limit: u16) -> (Vec<usize>, bool) {
    let mut begins: Vec<usize> = vec![machine.start];
    begins.extend(machine.stop);
    for state in &machine.states {
        begins.extend(state.yields.iter().filter_map(|it| match *it {
            Yield::Pause(state) => Some(state),
            _ => None,
        }));
    }
    let mut found: Vec<usize> = Vec::new();
    let mut all = true;
    let mut seen = FxHashSet::default();
    let mut stack: Vec<Visited> = begins
        .into_iter()
        .map(|at| beginning(machine, Some(limit), at))
        .collect();
    while let Some((at, visits)) = stack.pop() {
        if seen.len() == COMBINATIONS {
            all = false;
            break;
        }
        if !seen.insert((at, visits.clone())) {
            continue;
        }
        let entered = within(machine, Some(limit), at, &visits);
        let round = begins_round(machine, at, &entered);
        let leaves = machine.states[at]
            .yields
            .iter()
            .any(|it| !matches!(it, Yield::Next(_)));
        let stuck = !leaves && entered.is_empty() && round.is_empty();
        stack.extend(entered);
        if stuck && !found.contains(&at) {
            found.push(at);
        }
    }
    found.sort_unstable();
    (found, all)
}

/// A state of a machine, and how often the turn has entered each state; nothing where there is no limit.
pub(crate) type Visited = (usize, Vec<u16>);

/// The beginning of a turn, or a round, in a state.
pub(crate) fn beginning(machine: &Machine, limit: Option<u16>, state: usize) -> Visited {
    let mut visits = Vec::new();
    if limit.is_some() {
        visits.resize(machine.states.len(), 0);
        visits[state] = 1;
    }
    (state, visits)
}

/// What a limit lets the turn go on with from a state.
fn within(machine: &Machine, limit: Option<u16>, at: usize, visits: &[u16]) -> Vec<Visited> {
    let yields = machine.states[at].yields.iter();
    let next = yields.filter_map(|it| match *it {
        Yield::Next(next) => Some(next),
        _ => None,
    });
    next.filter(|&next| limit.is_none_or(|limit| visits[next] < limit))
        .map(|next| {
            let mut visits = visits.to_vec();
            if let Some(it) = visits.get_mut(next) {
                *it += 1;
            }
            (next, visits)
        })
        .collect()
}

/// Where a new round begins, if there are rounds and this one is over.
fn begins_round(machine: &Machine, at: usize, within: &[Visited]) -> Vec<Visited> {
    let yields = &machine.states[at].yields;
    if !machine.rounds || !within.is_empty() {
        return Vec::new();
    }
    let next = yields.iter().filter_map(|it| match *it {
        Yield::Next(next) if next != at => Some(next),
        _ => None,
    });
    next.map(|next| beginning(machine, machine.loop_limit, next))
        .collect()
}

/// What can follow a state in the same turn.
pub(crate) fn followers(machine: &Machine, (at, visits): &Visited) -> Vec<Visited> {
    let mut out = within(machine, machine.loop_limit, *at, visits);
    out.extend(begins_round(machine, *at, &out));
    out
}
