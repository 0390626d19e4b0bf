//! Many runs in parts: on several processors, or on several machines.

use std::io::Sink;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use dotgen_timing::system::Ticks;
use dotgen_timing::verify::Prepared;

use crate::simulation::{Plan, SimulationResult, simulate};

/// Greatest number of parts. It does not depend on the number of processors, so that reports do not either.
const PARTS: u64 = 64;

/// One of several parts of a set of runs, all of about the same size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Its number, from 0.
    pub index: u64,
    /// The number of parts.
    pub of: u64,
}

impl Part {
    /// Returns the plan of this part of the runs, which may have none.
    pub fn plan<'w>(self, plan: &Plan<'w>) -> Plan<'w> {
        let runs = u128::from(plan.runs);
        let before = |index: u64| (runs * u128::from(index) / u128::from(self.of)) as u64;
        let first = before(self.index);
        Plan {
            seed: plan.seed.wrapping_add(first),
            runs: before(self.index + 1) - first,
            record: plan.record && first == 0,
            ..*plan
        }
    }
}

/// Runs a system in parts, on all processors. Returns the plan and the result of each part, in order, up to
/// the first one that ended early. `bounds` are the known bounds on the response times of its tasks, in base
/// units.
pub fn simulate_in_parts<'p, 'w>(
    prepared: &'p Prepared,
    bounds: &[Option<Ticks>],
    plan: &Plan<'w>,
    interrupted: &(dyn Fn() -> bool + Sync),
) -> Vec<(Plan<'w>, SimulationResult<'p>)> {
    let of = plan.runs.clamp(1, PARTS);
    let plans: Vec<Plan> = (0..of).map(|index| Part { index, of }.plan(plan)).collect();
    let results: Vec<Mutex<Option<SimulationResult>>> =
        plans.iter().map(|_| Mutex::new(None)).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        for (plan, place) in numbers.map_while(|number| plans.get(number).zip(results.get(number)))
        {
            let result = simulate::<Sink>(prepared, bounds.to_vec(), plan, None, None, interrupted);
            *place.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(plans.len());
    std::thread::scope(|scope| {
        (1..threads).for_each(|_| {
            scope.spawn(work);
        });
        work();
    });
    let results = results.into_iter();
    let results =
        results.filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner));
    let mut ended = false;
    let whole = plans
        .into_iter()
        .zip(results)
        .take_while(|(_, result)| !std::mem::replace(&mut ended, result.end.ends_all()));
    whole.collect()
}
