//! Bounds under the semantics of the servers where cores are given and taken away (`policy priority` and
//! `policy fair`).
//!
//! At every moment of a job some thread holds it up: its own, or one of its component that is ahead in the
//! lock queue. If that thread executes, it does a part of the work that the job needs or waits for, which is
//! at most the length of a cycle with cores enough (see [`super::queue`]). If it does not, others have all
//! cores: under `priority` only those whose priority is not lower than that of all threads that can hold the
//! job up. So on *N* cores a job takes at most *S + W / N*, where *S* is the former and *W* what the others
//! do meanwhile (the work-conserving argument of response-time analysis for global fixed priorities: M.
//! Bertogna, M. Cirinei, RTSS 2007). Where tasks are tied to cores, others may idle: there it is *S + W*.
//!
//! What a periodic task does in a window of length *w*: a cycle for every tick in it, one that has begun
//! before, and one for a tick that was kept (from its start-up as well); a cycle that is late was released up
//! to its response time before, so that all ticks in *w + R* count. The bounds *R* are the least that follow
//! from each other; no job can be the first to exceed its own. Of other threads it is not known how much they
//! do: aperiodic tasks, and control tasks that are asked for ever. Each of them is taken to have a core of
//! its own for ever.
//!
//! Nothing here depends on when codels end: the bounds hold for any duration up to the longest, also where
//! that is no whole number of units.

use super::queue::{cycle, is_within_components, requests, work};
use crate::system::{Policy, Ticks, TimedSystem};

/// A thread as it is seen by others.
struct Thread {
    /// The lower number goes first.
    priority: u64,
    work: Work,
}

/// What a thread does at most.
enum Work {
    /// A task with its period: so much in each cycle.
    Cycles { task: usize, period: u64, each: u64 },
    /// A control task: so much in all.
    Total(u64),
    /// Nobody knows.
    Endless,
}

/// More rounds than this are not made; a quick bound must be quick.
const ROUNDS: usize = 1000;

/// A bound on the response time of every task; `None` where there is none.
pub(super) fn response_bounds(system: &TimedSystem) -> Vec<Option<Ticks>> {
    let none = || vec![None; system.tasks.len()];
    if !is_within_components(system) {
        return none();
    }
    let requests = requests(system);
    let priorities = system.priorities();
    let threads = threads(system, &priorities, &requests);
    let lengths: Vec<Option<Ticks>> = (0..system.tasks.len())
        .map(|task| cycle(system, task, &requests))
        .collect();
    let mut bounds: Vec<Option<u64>> = lengths.iter().map(|it| it.map(u64::from)).collect();
    for _ in 0..ROUNDS {
        let next: Vec<Option<u64>> = (0..system.tasks.len())
            .map(|task| {
                let others = delaying(system, &priorities, &threads, task);
                let others = meanwhile(system, &others, &bounds, bounds[task]?)?;
                let length = u64::from(lengths[task]?).checked_add(others.delay(system)?)?;
                let period = u64::from(system.tasks[task].period?);
                // A bound beyond the period helps nobody, and need not be followed any further.
                (length < period).then_some(length.max(bounds[task]?))
            })
            .collect();
        if next == bounds {
            let bound = |task: usize| {
                after_tick(system, &bounds, task)?;
                bounds[task].and_then(|it| Ticks::try_from(it).ok())
            };
            return (0..system.tasks.len()).map(bound).collect();
        }
        bounds = next;
    }
    none()
}

/// How long after a tick the cycle that serves it ends at most; `None` if a tick may be kept again and again.
/// A first cycle may begin between two ticks, except for the first task of a component; then the next cycle
/// begins late, and ends before the tick after that.
fn after_tick(system: &TimedSystem, bounds: &[Option<u64>], task: usize) -> Option<u64> {
    let it = &system.tasks[task];
    let first = system.components[it.component].tasks.first() == Some(&task);
    let most = if first {
        bounds[task]?
    } else {
        bounds[task]?.checked_mul(2)?
    };
    (most < u64::from(it.period?)).then_some(most)
}

/// What others do in a window of time.
struct Meanwhile {
    /// All that is known of.
    work: u64,
    /// How many may work for ever.
    endless: u32,
}

/// What some threads do at most in a window, with bounds on the response times of tasks.
fn meanwhile(
    system: &TimedSystem,
    threads: &[&Thread],
    bounds: &[Option<u64>],
    window: u64,
) -> Option<Meanwhile> {
    let mut out = Meanwhile {
        work: 0,
        endless: 0,
    };
    for it in threads {
        let work = match it.work {
            Work::Endless => {
                out.endless += 1;
                continue;
            }
            Work::Total(all) => all,
            Work::Cycles { task, period, each } => {
                let count = match after_tick(system, bounds, task) {
                    Some(response) => (window + response).div_ceil(period) + 1,
                    None => window / period + 3,
                };
                each.checked_mul(count)?
            }
        };
        out.work = out.work.checked_add(work)?;
    }
    Some(out)
}

impl Meanwhile {
    /// How long it can keep a thread from the cores.
    fn delay(&self, system: &TimedSystem) -> Option<u64> {
        let left = system.platform.cores?.checked_sub(self.endless)?;
        let tied = system.tasks.iter().any(|it| it.affinity.is_some());
        match (tied, self.endless) {
            // A core may be waited for while others idle.
            (true, 0) => Some(self.work),
            (true, _) => None,
            _ if left == 0 => None,
            _ => Some(self.work.div_ceil(u64::from(left))),
        }
    }
}

fn threads(system: &TimedSystem, priorities: &[u64], requests: &[Option<u32>]) -> Vec<Thread> {
    let requested: Vec<bool> = requests.iter().map(|it| *it != Some(0)).collect();
    let upper = |codel: usize| u64::from(system.codels[codel].upper);
    let mut out = Vec::new();
    for (task, it) in system.tasks.iter().enumerate() {
        let machines = it
            .permanent
            .iter()
            .chain(&it.slots)
            .map(|&a| system.machine_of(a));
        let idles = machines
            .flat_map(|it| &it.states)
            .all(|it| upper(it.codel) == 0);
        let each = work(system, task, requests, 0);
        let work = match (it.period, each) {
            _ if idles => continue,
            (Some(period), Some(each)) => Work::Cycles {
                task,
                period: u64::from(period),
                each: u64::from(each),
            },
            _ => Work::Endless,
        };
        if system.needs_core(task) {
            let priority = priorities[task];
            out.push(Thread { priority, work });
        }
    }
    for (component, it) in system.components.iter().enumerate() {
        let mut total = Some(0u64);
        for &service in it.services.iter().filter(|&&it| requested[it]) {
            let of = &system.services[service];
            let each: u64 = of
                .validate
                .iter()
                .chain(&of.simple)
                .map(|&it| upper(it))
                .sum();
            if each > 0 {
                let all = requests[service].and_then(|count| each.checked_mul(u64::from(count)));
                total = total.zip(all).and_then(|(sum, all)| sum.checked_add(all));
            }
        }
        if total != Some(0) {
            out.push(Thread {
                priority: priorities[system.tasks.len() + component],
                work: total.map_or(Work::Endless, Work::Total),
            });
        }
    }
    out
}

/// The threads that can have the cores while a job of a task could go on.
fn delaying<'t>(
    system: &TimedSystem,
    priorities: &[u64],
    threads: &'t [Thread],
    task: usize,
) -> Vec<&'t Thread> {
    let is_own = |it: &Thread| matches!(it.work, Work::Cycles { task: of, .. } if of == task);
    // Those of its component can hold it up, be it only at the head of the queue without a core.
    let own = system.components[system.tasks[task].component].tasks.iter();
    let last = own.map(|&it| priorities[it]).max().unwrap_or(u64::MAX);
    let any = system.platform.policy != Policy::Priority;
    let others = threads.iter().filter(|it| !is_own(it));
    others.filter(|it| any || it.priority <= last).collect()
}
