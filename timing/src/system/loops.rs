//! Cycles of codel states without a pause, and the loop limit (sections 5 and 14).
//!
//! With a limit of *n*, one turn enters each state at most *n* times. A permanent activity that can reach
//! neither a pause nor `ether` has turns that never end. There the limit counts *rounds*: when a state has
//! used up all of its yields, a new round begins with any of the yields, except the state itself.

use rustc_hash::FxHashSet;

use super::{Machine, State, Yield};

/// Returns cycles of states without a pause, one per strongly connected set of states. Each begins and ends
/// with the same state. Such a cycle lets a job take arbitrarily long.
pub fn pauseless_cycles(machine: &Machine) -> Vec<Vec<usize>> {
    let n = machine.states.len();
    let mut found = Vec::new();
    let mut covered = vec![false; n];
    for start in 0..n {
        if covered[start] {
            continue;
        }
        // Breadth-first search for the shortest way back.
        let mut from = vec![usize::MAX; n];
        let mut queue = std::collections::VecDeque::from([start]);
        'search: while let Some(at) = queue.pop_front() {
            for transition in &machine.states[at].yields {
                let &Yield::Next(next) = transition else {
                    continue;
                };
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

/// Returns true if a turn that begins in `state` can end.
pub(crate) fn can_pause(machine: &Machine, state: usize) -> bool {
    let mut seen = vec![false; machine.states.len()];
    let mut stack = vec![state];
    while let Some(at) = stack.pop() {
        if std::mem::replace(&mut seen[at], true) {
            continue;
        }
        for transition in &machine.states[at].yields {
            match *transition {
                Yield::Next(next) => stack.push(next),
                Yield::Pause(_) | Yield::End => return true,
            }
        }
    }
    false
}

/// Returns the states that a machine can reach without an interruption, if it can neither pause nor end in
/// any of them.
pub(crate) fn states_of_endless_run(machine: &Machine) -> Option<Vec<usize>> {
    let mut found = vec![machine.start];
    let mut at = 0;
    while let Some(&state) = found.get(at) {
        at += 1;
        for transition in &machine.states[state].yields {
            match *transition {
                Yield::Next(next) if !found.contains(&next) => found.push(next),
                Yield::Next(_) => {}
                Yield::Pause(_) | Yield::End => return None,
            }
        }
    }
    Some(found)
}

/// Upper limit on the combinations of state and visits that are examined.
const COMBINATIONS: usize = 20_000;

/// Returns the states in which a turn cannot go on under the loop limit of the machine. The list may be
/// incomplete for machines with very many combinations of states and visits.
pub fn loop_contradictions(machine: &Machine) -> Vec<usize> {
    let limit = machine.loop_limit;
    limit.map_or(Vec::new(), |limit| stuck_states(machine, limit).0)
}

/// Returns true if `loop once` is possible for the machine. If it is not, no limit is. The path on which a
/// state used up its yields enters no state twice. So the part of the path from the first of these yields can
/// be repeated as often as a limit allows.
pub(crate) fn can_be_limited(machine: &Machine) -> bool {
    stuck_states(machine, 1).0.is_empty()
}

/// Returns the states in which a turn cannot go on under a limit, and whether all combinations were examined.
fn stuck_states(machine: &Machine, limit: u16) -> (Vec<usize>, bool) {
    let mut begins: Vec<usize> = vec![machine.start];
    begins.extend(machine.stop);
    for state in &machine.states {
        begins.extend(state.yields.iter().filter_map(|transition| match *transition {
            Yield::Pause(state) => Some(state),
            _ => None,
        }));
    }
    let mut found: Vec<usize> = Vec::new();
    let mut all = true;
    let mut seen = FxHashSet::default();
    let mut stack: Vec<Visited> =
        begins.into_iter().map(|at| beginning(machine, Some(limit), at)).collect();
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
            .any(|transition| !matches!(transition, Yield::Next(_)));
        let stuck = !leaves && entered.is_empty() && round.is_empty();
        stack.extend(entered);
        if stuck && !found.contains(&at) {
            found.push(at);
        }
    }
    found.sort_unstable();
    (found, all)
}

/// Upper limit on the states of an unfolded machine.
const UNFOLDED: usize = 200;

/// Returns a machine without a loop limit that has the same runs: a state for each state of a machine and
/// each number of visits with which a turn can be there. The states of the machine come first, at the
/// beginning of a turn; those without yields are never entered. `None`: there are too many states.
pub fn unfolded(machine: &Machine) -> Option<Machine> {
    let limit = machine.loop_limit;
    let begin = |state: usize| beginning(machine, limit, state);
    let mut vertices: Vec<Visited> = (0..machine.states.len()).map(begin).collect();
    let mut out = Machine { loop_limit: None, rounds: false, ..machine.clone() };
    out.states.iter_mut().for_each(|state| state.yields.clear());
    let mut todo: Vec<usize> = [Some(machine.start), machine.stop].into_iter().flatten().collect();
    while let Some(at) = todo.pop() {
        if !out.states[at].yields.is_empty() {
            continue;
        }
        let (state, _) = vertices[at];
        let own = &machine.states[state].yields;
        let mut yields: Vec<Yield> =
            own.iter().copied().filter(|next| !matches!(next, Yield::Next(_))).collect();
        for next in followers(machine, &vertices[at]) {
            let known = vertices.iter().position(|vertex| *vertex == next);
            let number = known.unwrap_or_else(|| {
                let again = vertices.iter().filter(|vertex| vertex.0 == next.0).count() + 1;
                let mut copy = State { yields: Vec::new(), ..machine.states[next.0].clone() };
                copy.name = format!("{}_{again}", copy.name);
                out.states.push(copy);
                vertices.push(next);
                vertices.len() - 1
            });
            yields.push(Yield::Next(number));
        }
        if vertices.len() > UNFOLDED {
            return None;
        }
        todo.extend(yields.iter().filter_map(|next| match *next {
            Yield::Next(next) | Yield::Pause(next) => Some(next),
            Yield::End => None,
        }));
        out.states[at].yields = yields;
    }
    Some(out)
}

/// A state of a machine, and how often the turn has entered each state; empty without a limit.
pub(crate) type Visited = (usize, Vec<u16>);

/// Returns the beginning of a turn, or of a round, in a state.
pub(crate) fn beginning(machine: &Machine, limit: Option<u16>, state: usize) -> Visited {
    let mut visits = Vec::new();
    if limit.is_some() {
        visits.resize(machine.states.len(), 0);
        visits[state] = 1;
    }
    (state, visits)
}

/// Returns the successors of a state in the same turn that the limit allows.
fn within(machine: &Machine, limit: Option<u16>, at: usize, visits: &[u16]) -> Vec<Visited> {
    let yields = machine.states[at].yields.iter();
    let next = yields.filter_map(|transition| match *transition {
        Yield::Next(next) => Some(next),
        _ => None,
    });
    next.filter(|&next| limit.is_none_or(|limit| visits[next] < limit))
        .map(|next| {
            let mut visits = visits.to_vec();
            if let Some(number) = visits.get_mut(next) {
                *number += 1;
            }
            (next, visits)
        })
        .collect()
}

/// Returns the beginnings of the next round, if the limit counts rounds and this round is over.
fn begins_round(machine: &Machine, at: usize, within: &[Visited]) -> Vec<Visited> {
    let yields = &machine.states[at].yields;
    if !machine.rounds || !within.is_empty() {
        return Vec::new();
    }
    let next = yields.iter().filter_map(|transition| match *transition {
        Yield::Next(next) if next != at => Some(next),
        _ => None,
    });
    next.map(|next| beginning(machine, machine.loop_limit, next)).collect()
}

/// Returns the successors of a state in the same turn.
pub(crate) fn followers(machine: &Machine, (at, visits): &Visited) -> Vec<Visited> {
    let mut out = within(machine, machine.loop_limit, *at, visits);
    out.extend(begins_round(machine, *at, &out));
    out
}
