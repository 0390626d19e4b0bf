//! Paths through the states of a machine, and their greatest cost.

use rustc_hash::FxHashMap;

use crate::system::loops::{Visited, beginning, followers};
use crate::system::{Machine, Yield};

/// Upper limit on the combinations of states and visits of a machine with loop limits: a quick bound must be
/// quick.
const COMBINATIONS: usize = 2_000;

/// Returns the states in which a new turn of a machine can begin, except the first one.
pub(super) fn resumed(machine: &Machine) -> impl Iterator<Item = usize> + '_ {
    let yields = machine.states.iter().flat_map(|state| &state.yields);
    yields.filter_map(|transition| match *transition {
        Yield::Pause(state) => Some(state),
        _ => None,
    })
}

/// Paths through states of a machine.
#[derive(Debug)]
pub(super) struct Ways {
    /// State, by vertex.
    at: Vec<usize>,
    /// Successors, by vertex.
    next: Vec<Vec<usize>>,
    /// There were too many vertices. Instead, each state has one vertex, and this is the number of times that
    /// a path can enter a state.
    often: Option<Option<u16>>,
}

impl Ways {
    /// Returns the turns that begin in one of some states.
    pub(super) fn turns(machine: &Machine, from: impl IntoIterator<Item = usize>) -> Self {
        Self::new(machine, from, &|_| true, false)
    }

    /// Returns paths that begin anywhere, continue beyond pauses, and only lead through some states.
    pub(super) fn stretches(machine: &Machine, through: &dyn Fn(usize) -> bool) -> Self {
        Self::new(machine, 0..machine.states.len(), through, true)
    }

    fn new(
        machine: &Machine,
        from: impl IntoIterator<Item = usize>,
        through: &dyn Fn(usize) -> bool,
        beyond_pauses: bool,
    ) -> Self {
        let begin = |state| beginning(machine, machine.loop_limit, state);
        let mut vertices: Vec<Visited> = Vec::new();
        let mut known: FxHashMap<Visited, usize> = FxHashMap::default();
        let mut number = |vertices: &mut Vec<Visited>, visited: Visited| {
            *known.entry(visited.clone()).or_insert_with(|| {
                vertices.push(visited);
                vertices.len() - 1
            })
        };
        for state in from.into_iter().filter(|&index| through(index)) {
            number(&mut vertices, begin(state));
        }
        let mut next = Vec::new();
        while let Some(vertex) = vertices.get(next.len()) {
            let mut following = followers(machine, vertex);
            if beyond_pauses {
                let yields = machine.states[vertex.0].yields.iter();
                following.extend(yields.filter_map(|transition| match *transition {
                    Yield::Pause(state) => Some(begin(state)),
                    _ => None,
                }));
            }
            following.retain(|follower| through(follower.0));
            let numbers = following.into_iter().map(|follower| number(&mut vertices, follower));
            next.push(numbers.collect());
            if vertices.len() > COMBINATIONS {
                let limit = machine.loop_limit;
                return Ways {
                    at: (0..machine.states.len()).filter(|&state| through(state)).collect(),
                    next: Vec::new(),
                    often: Some(limit.filter(|_| !machine.rounds && !beyond_pauses)),
                };
            }
        }
        Ways { at: vertices.into_iter().map(|vertex| vertex.0).collect(), next, often: None }
    }

    /// Returns the states on the paths.
    pub(super) fn states(&self) -> impl Iterator<Item = usize> + '_ {
        self.at.iter().copied()
    }

    /// Returns the greatest cost of a path; `None` if there is none, or it is not found.
    pub(super) fn costliest(&self, cost: &dyn Fn(usize) -> Option<u64>) -> Option<u64> {
        let costs: Vec<u64> = self.states().map(cost).collect::<Option<_>>()?;
        let sum = costs.iter().try_fold(0u64, |sum, &cost| sum.checked_add(cost));
        if sum == Some(0) {
            return sum;
        }
        if let Some(often) = self.often {
            return sum?.checked_mul(u64::from(often?));
        }
        // Longest paths, round by round: with n vertices they are stable after n rounds, unless some cycle
        // has a cost.
        let mut longest = costs.clone();
        for _ in 0..=costs.len() {
            let mut changed = false;
            for vertex in (0..costs.len()).rev() {
                for &following in &self.next[vertex] {
                    let through = costs[vertex].checked_add(longest[following])?;
                    if through > longest[vertex] {
                        longest[vertex] = through;
                        changed = true;
                    }
                }
            }
            if !changed {
                return longest.into_iter().max();
            }
        }
        None
    }
}
