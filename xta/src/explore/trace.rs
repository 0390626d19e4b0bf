//! Counterexamples: the transitions to a state, with their earliest times.

use super::moves::Effect;
use super::search::{Search, State};
use crate::eval::Trap;
use crate::zone::{Constraint, INFINITE};
use crate::{Change, Step, Trace};

/// A transition of a trace, with the state before it.
struct Fired {
    state: State,
    outcome: Effect,
}

impl Search<'_, '_> {
    /// The trace to a node. `last` constrains the rows of the zone of its last state.
    pub(crate) fn trace(&mut self, node: u32, last: &[Constraint]) -> Result<Trace, Trap> {
        let mut path = vec![node];
        while let Some(parent) =
            path.last().and_then(|node| self.store.nodes[*node as usize].parent)
        {
            path.push(parent);
        }
        path.reverse();
        let mut fired = Vec::new();
        for pair in path.windows(2) {
            let state = self.state(pair[0]);
            let outcome = self.between(&state, pair[1])?;
            fired.push(Fired { state, outcome });
        }
        let end = self.state(node);
        let times = self.times(&fired, &end, last)?;
        let mut steps = Vec::new();
        for (number, Fired { state, outcome }) in fired.iter().enumerate() {
            let program = self.system.program;
            let processes = self.system.processes.len();
            let changed = |slot: &usize| state.discrete[*slot] != outcome.discrete[*slot];
            let changes = (processes..state.discrete.len()).filter(changed).map(|slot| Change {
                variable: program.slots[slot].0.clone(),
                before: state.discrete[slot],
                after: outcome.discrete[slot],
            });
            steps.push(Step {
                time: times[number + 1],
                transition: self.system.label(&outcome.step),
                channel: outcome
                    .step
                    .channel
                    .map(|channel| program.channels[channel as usize].name.clone()),
                changes: changes.collect(),
            });
        }
        let locations =
            self.system.processes.iter().zip(&end.discrete).map(|(process, location)| {
                format!("{}.{}", process.name, process.locations[*location as usize].name)
            });
        Ok(Trace {
            steps,
            locations: locations.collect(),
            time: times.last().copied().unwrap_or(0),
        })
    }

    /// The transition from a state to a node.
    fn between(&mut self, state: &State, to: u32) -> Result<Effect, Trap> {
        for outcome in self.system.outcomes(&state.discrete, &state.zone, &state.rows)? {
            if let Some((entry, zone)) = self.successor(state, &outcome)? {
                let node = &self.store.nodes[to as usize];
                if node.entry == entry && node.zone == zone {
                    return Ok(outcome);
                }
            }
        }
        Err("a transition of the trace was not found again".to_owned())
    }

    /// The earliest time of each transition of a run, from the start, which is time 0, to the end. The times
    /// are the least solution of a system of differences, whose strict bounds count as weak ones.
    fn times(
        &mut self,
        fired: &[Fired],
        end: &State,
        last: &[Constraint],
    ) -> Result<Vec<i64>, Trap> {
        let count = fired.len() + 2;
        // `(a, b, w)`: time `b` is at least time `a` plus `w`.
        let mut edges: Vec<(usize, usize, i64)> = Vec::new();
        let mut resets: Vec<(usize, i64)> = vec![(0, 0); self.system.program.clocks.len()];
        for number in 1..count {
            let fired = fired.get(number - 1);
            let state = fired.map_or(end, |fired| &fired.state);
            edges.push((number - 1, number, 0));
            if !state.can_delay {
                edges.push((number, number - 1, 0));
            }
            let mut constraints = self.system.invariants(&state.discrete)?.unwrap_or_default();
            match fired {
                Some(fired) => constraints.extend_from_slice(&fired.outcome.step.constraints),
                None => {
                    constraints
                        .extend(last.iter().map(|constraint| global(*constraint, &end.rows)));
                }
            }
            for Constraint { i, j, bound } in constraints {
                if bound == INFINITE {
                    continue;
                }
                // Time and value at the last reset. The constant 0 is reset now.
                let of = |row: u32| if row == 0 { (number, 0) } else { resets[row as usize - 1] };
                let ((time_i, value_i), (time_j, value_j)) = (of(i), of(j));
                edges.push((time_j, time_i, value_i - value_j - i64::from(bound >> 1)));
            }
            for (clock, value) in fired.iter().flat_map(|fired| &fired.outcome.resets) {
                resets[*clock as usize] = (number, i64::from(*value));
            }
        }
        let mut times = vec![0i64; count];
        for _ in 0..=count {
            let mut changed = false;
            for (a, b, weight) in &edges {
                let time = times[*a] + weight;
                if time > times[*b] {
                    times[*b] = time;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        Ok(times)
    }
}

/// A constraint on rows of a zone as a constraint on clocks.
fn global(constraint: Constraint, rows: &[u32]) -> Constraint {
    let clock = |row: u32| if row == 0 { 0 } else { rows[row as usize - 1] + 1 };
    Constraint { i: clock(constraint.i), j: clock(constraint.j), bound: constraint.bound }
}
