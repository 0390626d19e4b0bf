//! Largest constants that clocks are compared with after each location, before the clocks are reset.

use super::edges::{Bound, Guard, Process, Update};
use super::scope::Program;
use crate::code::range;
use crate::zone::LARGEST_BOUND;

/// For each process, location and clock, the largest constants of lower and upper bounds. -1 is none.
#[derive(Debug, Clone)]
pub(crate) struct Ceilings {
    pub(crate) of: Vec<Vec<Vec<(i32, i32)>>>,
}

/// Computes the constants. If `both`, a bound counts for both sides, as needed where guards are negated.
/// `more` gives the constant of a query for a process, location and clock.
pub(crate) fn ceilings(
    program: &Program,
    processes: &[Process],
    both: bool,
    more: impl Fn(usize, usize, usize) -> i32,
) -> Ceilings {
    let clocks = program.clocks.len();
    let owners = owners(processes, clocks);
    let mut of = Vec::new();
    for (index, process) in processes.iter().enumerate() {
        let mut table = seeds(program, process, clocks, both);
        for (location, constants) in table.iter_mut().enumerate() {
            for (clock, (lower, upper)) in constants.iter_mut().enumerate() {
                let constant = more(index, location, clock);
                *lower = (*lower).max(constant);
                *upper = (*upper).max(constant);
            }
        }
        propagate(process, &mut table, &owners, index);
        of.push(table);
    }
    Ceilings { of }
}

/// The only process that resets or compares a clock, if there is one.
pub(crate) fn owners(processes: &[Process], clocks: usize) -> Vec<Option<usize>> {
    let mut users: Vec<Vec<usize>> = vec![Vec::new(); clocks];
    for (index, process) in processes.iter().enumerate() {
        let bounds = process.locations.iter().flat_map(|location| &location.invariant.bounds);
        let guards = process.edges.iter().flat_map(|edge| &edge.guard.bounds);
        let compared = bounds.chain(guards).map(|bound| bound.clock);
        let reset =
            process.edges.iter().flat_map(|edge| &edge.updates).filter_map(|update| match update {
                Update::Reset(clock, _) => Some(*clock),
                Update::Run(_) => None,
            });
        for clock in compared.chain(reset) {
            let users = &mut users[clock as usize];
            if users.last() != Some(&index) {
                users.push(index);
            }
        }
    }
    users
        .iter()
        .map(|users| match users[..] {
            [owner] => Some(owner),
            _ => None,
        })
        .collect()
}

/// The constants of the edges and the invariant of each location.
fn seeds(program: &Program, process: &Process, clocks: usize, both: bool) -> Vec<Vec<(i32, i32)>> {
    let mut table = vec![vec![(-1, -1); clocks]; process.locations.len()];
    let raise = |constants: &mut Vec<(i32, i32)>, bound: &Bound, both: bool| {
        let highest = range(&bound.value, &program.functions).1.clamp(-1, LARGEST_BOUND);
        let (lower, upper) = &mut constants[bound.clock as usize];
        if both || !bound.upper {
            *lower = (*lower).max(highest);
        }
        if both || bound.upper {
            *upper = (*upper).max(highest);
        }
    };
    let all = |constants: &mut Vec<(i32, i32)>, guard: &Guard, both: bool| {
        guard.bounds.iter().for_each(|bound| raise(constants, bound, both));
    };
    for (location, constants) in process.locations.iter().zip(&mut table) {
        all(constants, &location.invariant, both);
    }
    for edge in &process.edges {
        // A receiver of a broadcast takes part if it can, so that its guard is negated too.
        let negated = edge.sync.as_ref().is_some_and(|sync| sync.broadcast && !sync.sends);
        all(&mut table[edge.source as usize], &edge.guard, both || negated);
        // The invariant of the target restricts the edge.
        let target = &process.locations[edge.target as usize];
        for bound in &target.invariant.bounds {
            let resets = |update: &Update| matches!(update, Update::Reset(clock, _) if *clock == bound.clock);
            if !edge.updates.iter().any(resets) {
                raise(&mut table[edge.source as usize], bound, both);
            }
        }
    }
    table
}

/// Carries constants back over edges that do not reset the clock, until nothing changes. The constants of a
/// clock of several processes hold in all locations.
fn propagate(
    process: &Process,
    table: &mut [Vec<(i32, i32)>],
    owners: &[Option<usize>],
    index: usize,
) {
    for (clock, owner) in owners.iter().enumerate() {
        if *owner != Some(index) {
            let join = |a: (i32, i32), b: (i32, i32)| (a.0.max(b.0), a.1.max(b.1));
            let all = table.iter().map(|constants| constants[clock]).fold((-1, -1), join);
            for constants in table.iter_mut() {
                constants[clock] = all;
            }
            continue;
        }
        let keeps: Vec<(usize, usize)> = process
            .edges
            .iter()
            .filter(|edge| {
                let resets = |update: &Update| match update {
                    Update::Reset(reset, _) => *reset as usize == clock,
                    Update::Run(_) => false,
                };
                !edge.updates.iter().any(resets)
            })
            .map(|edge| (edge.source as usize, edge.target as usize))
            .collect();
        loop {
            let mut changed = false;
            for (source, target) in &keeps {
                let after = table[*target][clock];
                let before = &mut table[*source][clock];
                let joined = (before.0.max(after.0), before.1.max(after.1));
                changed |= joined != *before;
                *before = joined;
            }
            if !changed {
                break;
            }
        }
    }
}
