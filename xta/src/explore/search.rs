//! Breadth-first search over symbolic states.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;

use super::moves::{Effect, System, local};
use super::store::{Store, pack};
use crate::eval::Trap;
use crate::network::ceilings::Ceilings;
use crate::zone::{Constraint, Zone};
use crate::{Limits, Reason};

/// A symbolic state.
pub(crate) struct State {
    pub(crate) discrete: Vec<i32>,
    pub(crate) zone: Zone,
    /// Clocks of the rows of the zone, from row 1.
    pub(crate) rows: Vec<u32>,
    pub(crate) can_delay: bool,
}

/// Result of a visit of a state.
pub(crate) enum Visit {
    Continue,
    /// The search ends here, in the part of the zone with these constraints on rows.
    Stop(Vec<Constraint>),
}

/// End of a search.
pub(crate) enum End {
    Exhausted,
    /// A visit stopped the search at a node.
    Stopped(u32, Vec<Constraint>),
    GaveUp(Reason),
    /// The model has an error, at a successor of a node.
    Invalid(Option<u32>, Trap),
}

pub(crate) struct Search<'n, 's> {
    pub(crate) system: System<'n>,
    pub(crate) ceilings: &'s Ceilings,
    pub(crate) store: Store,
    waiting: VecDeque<u32>,
}

impl<'n, 's> Search<'n, 's> {
    pub(crate) fn new(system: System<'n>, ceilings: &'s Ceilings) -> Search<'n, 's> {
        Search { system, ceilings, store: Store::default(), waiting: VecDeque::new() }
    }

    /// The clocks that matter in a state, with the constants of their lower and upper bounds. The first
    /// constants belong to the constant 0.
    fn active(&self, discrete: &[i32]) -> (Vec<u32>, Vec<i32>, Vec<i32>) {
        let clocks = self.system.program.clocks.len();
        let mut of = vec![(-1, -1); clocks];
        for (table, location) in self.ceilings.of.iter().zip(discrete) {
            for (joined, constants) in of.iter_mut().zip(&table[*location as usize]) {
                *joined = (joined.0.max(constants.0), joined.1.max(constants.1));
            }
        }
        let (mut rows, mut lower, mut upper) = (Vec::new(), vec![0], vec![0]);
        for (clock, constants) in of.into_iter().enumerate() {
            if constants != (-1, -1) {
                rows.push(clock as u32);
                lower.push(constants.0);
                upper.push(constants.1);
            }
        }
        (rows, lower, upper)
    }

    /// The state of a node.
    pub(crate) fn state(&self, node: u32) -> State {
        let node = &self.store.nodes[node as usize];
        let discrete = self.store.discrete(node.entry);
        let (rows, ..) = self.active(&discrete);
        let can_delay = self.store.entries[node.entry as usize].can_delay;
        State { discrete, zone: node.zone.clone(), rows, can_delay }
    }

    /// The zone after a transition, with its entry. The zone is closed under delays and extrapolated.
    pub(crate) fn successor(
        &mut self,
        from: &State,
        outcome: &Effect,
    ) -> Result<Option<(u32, Zone)>, Trap> {
        let mut zone = from.zone.clone();
        if !zone.constrain_all(&local(&outcome.step.constraints, &from.rows)) {
            return Ok(None);
        }
        let (rows, lower, upper) = self.active(&outcome.discrete);
        let mut sources = vec![(0, 0)];
        for clock in &rows {
            let reset = outcome.resets.iter().rev().find(|(reset, _)| reset == clock);
            sources.push(match reset {
                Some((_, value)) => (0, *value),
                // A clock that becomes active without a reset was active before.
                None => (from.rows.iter().position(|row| row == clock).map_or(0, |row| row + 1), 0),
            });
        }
        let zone = zone.project(&sources);
        self.settle(&outcome.discrete, zone, &rows, &lower, &upper)
    }

    fn settle(
        &mut self,
        discrete: &[i32],
        mut zone: Zone,
        rows: &[u32],
        lower: &[i32],
        upper: &[i32],
    ) -> Result<Option<(u32, Zone)>, Trap> {
        let packed = pack(discrete);
        let entry = if let Some(entry) = self.store.find(&packed) {
            entry
        } else {
            let can_delay = self.system.can_delay(discrete)?;
            self.store.enter(packed, can_delay)
        };
        if self.store.entries[entry as usize].can_delay {
            zone.up();
        }
        let Some(invariants) = self.system.invariants(discrete)? else { return Ok(None) };
        if !zone.constrain_all(&local(&invariants, rows)) {
            return Ok(None);
        }
        zone.extrapolate(lower, upper);
        Ok(Some((entry, zone)))
    }

    fn initial(&mut self) -> Result<Option<(u32, Zone)>, Trap> {
        let discrete = self.system.program.initial.clone();
        let (rows, lower, upper) = self.active(&discrete);
        let zone = Zone::origin(rows.len() + 1);
        self.settle(&discrete, zone, &rows, &lower, &upper)
    }

    /// Visits all states, until a visit stops the search.
    pub(crate) fn run(
        &mut self,
        limits: &Limits,
        mut visit: impl FnMut(&mut System<'_>, &State) -> Result<Visit, Trap>,
    ) -> End {
        match self.initial() {
            Err(trap) => return End::Invalid(None, trap),
            Ok(None) => {
                return End::Invalid(None, "an invariant is false in the initial state".to_owned());
            }
            Ok(Some((entry, zone))) => {
                if let Some(end) = self.found(None, entry, zone, &mut visit) {
                    return end;
                }
            }
        }
        let mut steps = 0u32;
        while let Some(node) = self.waiting.pop_front() {
            steps += 1;
            if steps.is_multiple_of(64)
                && limits.cancel.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
            {
                return End::GaveUp(Reason::Cancelled);
            }
            if self.store.nodes[node as usize].covered {
                continue;
            }
            let state = self.state(node);
            let outcomes = match self.system.outcomes(&state.discrete, &state.zone, &state.rows) {
                Ok(outcomes) => outcomes,
                Err(trap) => return End::Invalid(Some(node), trap),
            };
            for outcome in &outcomes {
                let next = match self.successor(&state, outcome) {
                    Ok(next) => next,
                    Err(trap) => return End::Invalid(Some(node), trap),
                };
                let Some((entry, zone)) = next else { continue };
                if let Some(end) = self.found(Some(node), entry, zone, &mut visit) {
                    return end;
                }
            }
            if self.store.nodes.len() > limits.states {
                return End::GaveUp(Reason::States(limits.states));
            }
        }
        End::Exhausted
    }

    fn found(
        &mut self,
        parent: Option<u32>,
        entry: u32,
        zone: Zone,
        visit: &mut impl FnMut(&mut System<'_>, &State) -> Result<Visit, Trap>,
    ) -> Option<End> {
        let node = self.store.add(parent, entry, zone)?;
        self.waiting.push_back(node);
        let state = self.state(node);
        match visit(&mut self.system, &state) {
            Ok(Visit::Continue) => None,
            Ok(Visit::Stop(constraints)) => Some(End::Stopped(node, constraints)),
            Err(trap) => Some(End::Invalid(Some(node), trap)),
        }
    }
}
