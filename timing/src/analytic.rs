//! A quick bound on response times: response-time analysis with blocking.
//!
//! Never below the exact value, and there at once. It counts what other tasks can do at most in a
//! window of time:
//!
//! * while a codel waits for its locks, some codel that excludes it is executing; in a window of
//!   length *w* a periodic task does at most ⌈w/P⌉ + 2 turns (one carried in, or its start-up, and one on a
//!   pending tick), and ⌈w/P⌉ + 1 once it is known to meet its deadlines;
//! * while a task waits for a core, all cores are held by other jobs, each for at most its own bound
//!   counted from the grant; under FIFO only by jobs released before, at most one of each task. A cycle that
//!   never ends holds one core.
//!
//! Both windows are least fixed points.

use crate::system::{
    ClientAction, CodelSet, FOREVER, LockOrder, Machine, Policy, Ticks, TimedSystem, Yield,
};

/// A bound on the response time of every task; `None` where this method finds none.
pub fn response_bounds(system: &TimedSystem) -> Vec<Option<Ticks>> {
    let mut analysis = Analysis {
        system,
        excluded: excluded(system),
        punctual: vec![false; system.tasks.len()],
    };
    loop {
        let bounds = analysis.bounds();
        let meets = |task: usize| meets_deadlines(system, task, bounds[task]);
        let punctual: Vec<bool> = (0..bounds.len()).map(meets).collect();
        if punctual == analysis.punctual {
            return bounds;
        }
        analysis.punctual = punctual;
    }
}

/// Whether a bound on the response time of a task proves that it meets its deadlines. Where a tick is kept it may
/// be taken any time before the next one, so that nothing follows.
pub fn meets_deadlines(system: &TimedSystem, task: usize, bound: Option<Ticks>) -> bool {
    let it = &system.tasks[task];
    bound.is_some_and(|bound| !it.keep_idle_tick && Some(bound) < it.period)
}

/// Fixed points above this are given up.
const HORIZON: u64 = 1 << 31;

/// Fixed points that are not found in so many rounds are given up: a quick bound must be quick.
const ROUNDS: usize = 10_000;

struct Analysis<'s> {
    system: &'s TimedSystem,
    /// Tasks that are known to meet their deadlines: they never have a tick waiting.
    punctual: Vec<bool>,
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
    fn bounds(&self) -> Vec<Option<Ticks>> {
        let system = self.system;
        let waits: Vec<Option<u64>> = (0..system.codels.len())
            .map(|codel| self.lock_wait(codel))
            .collect();
        let cost = |codel: usize| -> Option<u64> {
            Some(waits[codel]? + finite(system.codels[codel].upper)?)
        };
        let held: Vec<Option<u64>> = (0..system.tasks.len())
            .map(|task| self.turns(task, &cost))
            .collect();
        (0..system.tasks.len())
            .map(|task| {
                let response = held[task]?.checked_add(self.core_wait(task, &held)?)?;
                u32::try_from(response).ok().filter(|&it| it < FOREVER)
            })
            .collect()
    }

    /// The work of a task that others may have to wait for.
    fn jobs(&self, task: usize, work: u64) -> Jobs {
        Jobs {
            period: self.system.tasks[task].period,
            carried: if self.punctual[task] { 1 } else { 2 },
            work,
        }
    }

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
        let mut jobs = Vec::new();
        for task in 0..self.system.tasks.len() {
            let cost = |other: usize| {
                if excluded.contains(other) {
                    finite(self.system.codels[other].upper)
                } else {
                    Some(0)
                }
            };
            let work = self.turns(task, &cost)?;
            if work > 0 {
                jobs.push(self.jobs(task, work));
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
        let mut cores = u64::from(cores);
        let mut jobs = Vec::new();
        for (other, it) in self.system.tasks.iter().enumerate() {
            if other == task || !self.system.needs_core(other) {
                continue;
            }
            if it.period.is_none() && self.never_ends(other) {
                // At worst it has its core before anybody else, and for ever.
                cores = cores.checked_sub(1).filter(|&left| left > 0)?;
                continue;
            }
            let work = held[other]?;
            if work > 0 {
                jobs.push(self.jobs(other, work));
            }
        }
        if self.system.platform.policy == Policy::Fifo {
            // Every other task has at most one job that was released before.
            let ahead: u64 = jobs.iter().map(|it| it.work).sum();
            let queue = ahead / cores;
            return Some(fixed_point(&jobs, 0, cores).map_or(queue, |it| it.min(queue)));
        }
        fixed_point(&jobs, 0, cores)
    }

    /// Whether the cycle of an aperiodic task goes on for ever, if it is given a core at all.
    fn never_ends(&self, task: usize) -> bool {
        let it = &self.system.tasks[task];
        it.slots.is_empty()
            && it.permanent.is_some_and(|a| {
                let states = &self.system.machine_of(a).states;
                let mut yields = states.iter().flat_map(|it| &it.yields);
                yields.all(|it| matches!(it, Yield::Next(_)))
            })
    }
}

/// Jobs of a task, as others see them.
struct Jobs {
    period: Option<Ticks>,
    /// Those that a window can begin with.
    carried: u64,
    /// What each can take of them.
    work: u64,
}

/// The least w with w = (once + Σ (⌈w/P⌉ + carried)·work) / servers.
fn fixed_point(jobs: &[Jobs], once: u64, servers: u64) -> Option<u64> {
    let mut window = 0u64;
    for _ in 0..ROUNDS {
        let mut demand = once;
        for it in jobs {
            let count = window.div_ceil(u64::from(it.period?)) + it.carried;
            demand = demand.checked_add(count.checked_mul(it.work)?)?;
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
