//! A quick bound on response times: response-time analysis with blocking.
//!
//! Never below the exact value, and there at once. It counts what other tasks can do at most in a
//! window of time:
//!
//! * while a codel waits for its locks, some codel that excludes it is executing; in a window of
//!   length *w* a periodic task does at most ⌈w/P⌉ + 3 turns (one carried in, one on a pending tick,
//!   one in its start-up);
//! * while a task waits for a core, all cores are held by other jobs, each for at most its own bound
//!   counted from the grant.
//!
//! Both windows are least fixed points.

use crate::system::{
    ClientAction, CodelSet, FOREVER, LockOrder, Machine, Ticks, TimedSystem, Yield,
};

/// A bound on the response time of every task; `None` where this method finds none.
pub fn response_bounds(system: &TimedSystem) -> Vec<Option<Ticks>> {
    let analysis = Analysis {
        system,
        excluded: excluded(system),
    };
    let waits: Vec<Option<u64>> = (0..system.codels.len())
        .map(|codel| analysis.lock_wait(codel))
        .collect();
    let cost =
        |codel: usize| -> Option<u64> { Some(waits[codel]? + finite(system.codels[codel].upper)?) };
    let held: Vec<Option<u64>> = (0..system.tasks.len())
        .map(|task| analysis.turns(task, &cost))
        .collect();
    (0..system.tasks.len())
        .map(|task| {
            let response = held[task]?.checked_add(analysis.core_wait(task, &held)?)?;
            u32::try_from(response).ok().filter(|&it| it < FOREVER)
        })
        .collect()
}

/// Fixed points that are not found in so many rounds are given up: a quick bound must be quick.
const ROUNDS: usize = 10_000;

/// Fixed points above this are given up.
const HORIZON: u64 = 1 << 31;

struct Analysis<'s> {
    system: &'s TimedSystem,
    /// Codels whose execution can keep each codel waiting.
    excluded: Vec<CodelSet>,
}

fn finite(time: Ticks) -> Option<u64> {
    (time != FOREVER).then_some(u64::from(time))
}

/// With locks in order of arrival a codel also waits for what those before it wait for.
fn excluded(system: &TimedSystem) -> Vec<CodelSet> {
    let direct = || system.codels.iter().map(|it| it.conflicts.clone());
    if system.platform.locks == LockOrder::Free {
        return direct().collect();
    }
    let mut sets: Vec<CodelSet> = direct().collect();
    loop {
        let mut changed = false;
        for i in 0..sets.len() {
            let members: Vec<usize> = sets[i].iter().collect();
            for member in members {
                let more: Vec<usize> = sets[member].iter().collect();
                for it in more {
                    if !sets[i].contains(it) {
                        sets[i].insert(it);
                        changed = true;
                    }
                }
            }
        }
        if !changed {
            return sets;
        }
    }
}

impl Analysis<'_> {
    /// The longest that all turns of one job can be, with the cost of each codel.
    fn turns(&self, task: usize, cost: &dyn Fn(usize) -> Option<u64>) -> Option<u64> {
        let it = &self.system.tasks[task];
        let mut sum = 0u64;
        for &automaton in it.permanent.iter().chain(&it.slots) {
            sum = sum.checked_add(longest_turn(self.system.machine_of(automaton), cost)?)?;
        }
        Some(sum)
    }

    fn lock_wait(&self, codel: usize) -> Option<u64> {
        let excluded = &self.excluded[codel];
        if excluded.is_empty() {
            return Some(0);
        }
        // What each task can execute in one job, and what control tasks can execute at all.
        let mut jobs: Vec<(Option<Ticks>, u64)> = Vec::new();
        for (task, it) in self.system.tasks.iter().enumerate() {
            let cost = |other: usize| {
                if excluded.contains(other) {
                    finite(self.system.codels[other].upper)
                } else {
                    Some(0)
                }
            };
            let work = self.turns(task, &cost)?;
            if work > 0 {
                jobs.push((it.period, work));
            }
        }
        let once = self.control_work(excluded)?;
        fixed_point(&jobs, once, 1)
    }

    fn control_work(&self, excluded: &CodelSet) -> Option<u64> {
        let mut sum = 0u64;
        for client in &self.system.clients {
            for (at, step) in client.steps.iter().enumerate() {
                let ClientAction::Send { service, .. } = step.action else {
                    continue;
                };
                let service = &self.system.services[service];
                let mut work = 0u64;
                for &codel in service.validate.iter().chain(&service.simple) {
                    if excluded.contains(codel) {
                        work += finite(self.system.codels[codel].upper)?;
                    }
                }
                if work > 0 && on_cycle(client, at) {
                    return None;
                }
                sum += work;
            }
        }
        Some(sum)
    }

    fn core_wait(&self, task: usize, held: &[Option<u64>]) -> Option<u64> {
        let Some(cores) = self.system.platform.cores else {
            return Some(0);
        };
        if !self.system.needs_core(task) {
            return Some(0);
        }
        let mut jobs = Vec::new();
        for (other, it) in self.system.tasks.iter().enumerate() {
            if other == task || !self.system.needs_core(other) {
                continue;
            }
            let work = held[other]?;
            if work > 0 {
                jobs.push((it.period, work));
            }
        }
        fixed_point(&jobs, 0, u64::from(cores))
    }
}

/// The least w with w = (once + Σ (⌈w/P⌉ + 3)·work) / servers.
fn fixed_point(jobs: &[(Option<Ticks>, u64)], once: u64, servers: u64) -> Option<u64> {
    let mut window = 0u64;
    for _ in 0..ROUNDS {
        let mut demand = once;
        for &(period, work) in jobs {
            let count = window.div_ceil(u64::from(period?)) + 3;
            demand = demand.checked_add(count.checked_mul(work)?)?;
        }
        let next = demand.div_ceil(servers);
        if next == window {
            return Some(window);
        }
        if next > HORIZON {
            return None;
        }
        window = next;
    }
    None
}

/// The costliest way through states without a pause, from any state; with a loop limit, all states as
/// often as it allows.
fn longest_turn(machine: &Machine, cost: &dyn Fn(usize) -> Option<u64>) -> Option<u64> {
    let n = machine.states.len();
    let costs: Vec<u64> = machine
        .states
        .iter()
        .map(|it| cost(it.codel))
        .collect::<Option<_>>()?;
    let mut longest = costs.clone();
    for round in 0..=n {
        let mut changed = false;
        for at in 0..n {
            for it in &machine.states[at].yields {
                if let Yield::Next(next) = *it {
                    let through = costs[at].checked_add(longest[next])?;
                    if through > longest[at] {
                        longest[at] = through;
                        changed = true;
                    }
                }
            }
        }
        if !changed {
            return Some(longest.iter().copied().max().unwrap_or(0));
        }
        if round == n {
            break;
        }
    }
    // A cycle that costs time.
    match machine.loop_limit {
        Some(limit) if !machine.rounds => costs.iter().sum::<u64>().checked_mul(u64::from(limit)),
        _ => None,
    }
}

fn on_cycle(client: &crate::system::Client, at: usize) -> bool {
    let mut seen = vec![false; client.steps.len()];
    let mut stack: Vec<usize> = client.steps[at].next.clone();
    while let Some(it) = stack.pop() {
        if it == at {
            return true;
        }
        if it < client.steps.len() && !std::mem::replace(&mut seen[it], true) {
            stack.extend(&client.steps[it].next);
        }
    }
    false
}
