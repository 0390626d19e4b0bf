//! Response-time analysis under the semantics of the servers with preemption (`policy priority` and `policy
//! fair`).
//!
//! At every moment of a job some thread delays it: its own, or a thread of its component that is ahead in the
//! lock queue. If that thread executes, it does a part of the work that the job needs or waits for. This work
//! is at most the length of a cycle with enough cores (see [`super::queue`]). If that thread does not
//! execute, other threads have all cores: under `priority` only threads whose priority is not lower than that
//! of all threads that can delay the job. So on *N* cores a job takes at most *S + W / N*, where *S* is the
//! former work and *W* the work of the other threads meanwhile (the work-conserving argument of response-time
//! analysis for global fixed priorities: M. Bertogna, M. Cirinei, RTSS 2007). If tasks are bound to cores,
//! other cores may idle: there the bound is *S + W*.
//!
//! In a window of length *w*, a periodic task does the following work: a cycle for every tick in the window,
//! one that has begun before, and one for a kept tick (also from its start-up). A late cycle was released up
//! to its response time before, so that all ticks in *w + R* count. The bounds *R* are the least fixed point
//! of these equations; no job can be the first to exceed its own bound. The work of other threads is not
//! known: aperiodic tasks, and control tasks with unlimited requests. Each of them is assumed to hold a core
//! of its own for ever.
//!
//! Nothing here depends on the times at which codels end: the bounds hold for any duration up to the longest,
//! also if it is not a whole number of units.

use typed_index_collections::{TiSlice, TiVec, ti_vec};

use super::queue::{cycle, is_within_components, requests, work};
use crate::system::{CodelId, Policy, ServiceId, TaskId, Ticks, TimedSystem};

/// A thread, as a demand on others.
struct Thread {
    /// Priority; the lower number goes first.
    priority: u64,
    work: Work,
}

/// The greatest work of a thread.
enum Work {
    /// A task with a period: greatest work of each cycle.
    Cycles { task: TaskId, period: u64, each: u64 },
    /// A control task: greatest work in total.
    Total(u64),
    /// Not known.
    Endless,
}

/// Upper limit on the number of rounds: a quick bound must be quick.
const ROUNDS: usize = 1000;

/// Returns a bound on the response time of every task; `None` if there is none.
pub(super) fn response_bounds(system: &TimedSystem) -> TiVec<TaskId, Option<Ticks>> {
    let none = || ti_vec![None; system.tasks.len()];
    if !is_within_components(system) {
        return none();
    }
    let requests = requests(system);
    let priorities = system.priorities();
    let threads = threads(system, &priorities, &requests);
    let lengths: TiVec<TaskId, Option<Ticks>> =
        system.tasks.keys().map(|task| cycle(system, task, &requests)).collect();
    let mut bounds: TiVec<TaskId, Option<u64>> =
        lengths.iter().map(|length| length.map(u64::from)).collect();
    for _ in 0..ROUNDS {
        let next: TiVec<TaskId, Option<u64>> = system
            .tasks
            .keys()
            .map(|task| {
                let others = delaying(system, &priorities, &threads, task);
                let others = meanwhile(system, &others, &bounds, bounds[task]?)?;
                let length = u64::from(lengths[task]?).checked_add(others.delay(system)?)?;
                let period = u64::from(system.tasks[task].period?);
                // A bound beyond the period is useless, and is not followed any further.
                (length < period).then_some(length.max(bounds[task]?))
            })
            .collect();
        if next == bounds {
            let bound = |task: TaskId| {
                after_tick(system, &bounds, task)?;
                bounds[task].and_then(|bound| Ticks::try_from(bound).ok())
            };
            return system.tasks.keys().map(bound).collect();
        }
        bounds = next;
    }
    none()
}

/// Returns the greatest time, in base units, from a tick to the end of the cycle that serves the tick; `None`
/// if a tick may be kept again and again. A first cycle may begin between two ticks, except for the first
/// task of a component. Then the next cycle begins late, and ends before the tick after that.
fn after_tick(
    system: &TimedSystem,
    bounds: &TiSlice<TaskId, Option<u64>>,
    task: TaskId,
) -> Option<u64> {
    let definition = &system.tasks[task];
    let first = system.components[definition.component].tasks.first() == Some(&task);
    let most = if first { bounds[task]? } else { bounds[task]?.checked_mul(2)? };
    (most < u64::from(definition.period?)).then_some(most)
}

/// The work of other threads in a window of time.
struct WindowWork {
    /// All known work.
    work: u64,
    /// Number of threads that may work for ever.
    endless: u32,
}

/// Returns the greatest work of some threads in a window, given bounds on the response times of tasks.
fn meanwhile(
    system: &TimedSystem,
    threads: &[&Thread],
    bounds: &TiSlice<TaskId, Option<u64>>,
    window: u64,
) -> Option<WindowWork> {
    let mut out = WindowWork { work: 0, endless: 0 };
    for thread in threads {
        let work = match thread.work {
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

impl WindowWork {
    /// Returns the longest time for which this work can keep a thread from the cores.
    fn delay(&self, system: &TimedSystem) -> Option<u64> {
        let left = system.platform.cores?.checked_sub(self.endless)?;
        let tied = system.tasks.iter().any(|task| task.affinity.is_some());
        match (tied, self.endless) {
            // A thread may wait for its core while other cores idle.
            (true, 0) => Some(self.work),
            (true, _) => None,
            _ if left == 0 => None,
            _ => Some(self.work.div_ceil(u64::from(left))),
        }
    }
}

fn threads(
    system: &TimedSystem,
    priorities: &[u64],
    requests: &TiSlice<ServiceId, Option<u32>>,
) -> Vec<Thread> {
    let requested = |service: ServiceId| requests[service] != Some(0);
    let upper = |codel: CodelId| u64::from(system.codels[codel].upper);
    let mut out = Vec::new();
    for (task, entry) in system.tasks.iter_enumerated() {
        let machines = entry.permanent.iter().chain(&entry.slots).map(|&a| system.machine_of(a));
        let idles =
            machines.flat_map(|machine| &machine.states).all(|state| upper(state.codel) == 0);
        let each = work(system, task, requests, 0);
        let work = match (entry.period, each) {
            _ if idles => continue,
            (Some(period), Some(each)) => {
                Work::Cycles { task, period: u64::from(period), each: u64::from(each) }
            }
            _ => Work::Endless,
        };
        if system.needs_core(task) {
            let priority = priorities[usize::from(task)];
            out.push(Thread { priority, work });
        }
    }
    for (component, entry) in system.components.iter_enumerated() {
        let mut total = Some(0u64);
        for &service in entry.services.iter().filter(|&&service| requested(service)) {
            let of = &system.services[service];
            let each: u64 =
                of.validate.iter().chain(&of.simple).map(|&validate| upper(validate)).sum();
            if each > 0 {
                let all = requests[service].and_then(|count| each.checked_mul(u64::from(count)));
                total = total.zip(all).and_then(|(sum, all)| sum.checked_add(all));
            }
        }
        if total != Some(0) {
            out.push(Thread {
                priority: priorities[system.tasks.len() + usize::from(component)],
                work: total.map_or(Work::Endless, Work::Total),
            });
        }
    }
    out
}

/// Returns the threads that can have the cores while a job of a task could continue.
fn delaying<'t>(
    system: &TimedSystem,
    priorities: &[u64],
    threads: &'t [Thread],
    task: TaskId,
) -> Vec<&'t Thread> {
    let is_own =
        |thread: &Thread| matches!(thread.work, Work::Cycles { task: of, .. } if of == task);
    // Threads of the same component can delay the task, even at the head of the queue without a core.
    let own = system.components[system.tasks[task].component].tasks.iter();
    let last = own.map(|&task| priorities[usize::from(task)]).max().unwrap_or(u64::MAX);
    let any = system.platform.policy != Policy::Priority;
    let others = threads.iter().filter(|thread| !is_own(thread));
    others.filter(|thread| any || thread.priority <= last).collect()
}
