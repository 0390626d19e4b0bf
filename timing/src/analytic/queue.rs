//! Response-time analysis under the semantics of the servers, without preemption.
//!
//! A cycle is a sequence of codels, and before each of them its task takes a ticket. At that moment every
//! other thread of the component is ahead with at most one codel, in the queue or executing; its later
//! tickets come behind. The head of the queue waits for codels that execute, the next codel waits for the
//! head to begin, and so on. Until the task has its turn, at most one codel of each other thread has ended
//! for which another codel waited. So a cycle takes at most the sum, over its codels, of their times and of
//! the longest such codel of each other thread.
//!
//! If that is less than the period, no tick comes during a cycle, and every measured job is one cycle, which
//! starts at its tick. The first cycle of a later task of a component may begin between two ticks, with a
//! kept tick. Then a tick may come during the cycle, and the next cycle begins late. It ends before the tick
//! after that if twice the length is less than the period.
//!
//! With fewer cores than tasks, `policy fifo` gives the cores to the cycles in order of release. When a task
//! asks for a core, every other task has at most one cycle before it, waiting or under way; later ones come
//! behind, also if deadlines are missed. While the task waits, all cores work on these cycles, except cores
//! that may be held for ever. So it waits at most the sum of their lengths, divided by the number of other
//! cores. A cycle of an aperiodic task has no known length: each wake-up can prolong it.

use typed_index_collections::{TiSlice, TiVec, ti_vec};

use crate::system::loops::pauseless_cycles;
use crate::system::{
    ClientAction, CodelId, FOREVER, Machine, Policy, ServiceId, TaskId, Ticks, TimedSystem, Yield,
};

/// Returns a bound on the response time of every task; `None` if there is none.
pub(super) fn response_bounds(system: &TimedSystem) -> TiVec<TaskId, Option<Ticks>> {
    let requests = requests(system);
    let tasks = system.tasks.keys();
    let cycles: TiVec<TaskId, Option<Ticks>> =
        (tasks.clone()).map(|task| cycle(system, task, &requests)).collect();
    let bound = |task: TaskId| {
        let length = cycles[task]?.checked_add(core_wait(system, task, &cycles)?)?;
        let definition = &system.tasks[task];
        let first = system.components[definition.component].tasks.first() == Some(&task);
        let most = if first { length } else { length.checked_mul(2)? };
        (most < definition.period?).then_some(length)
    };
    let simple = is_within_components(system);
    tasks.map(|task| bound(task).filter(|_| simple)).collect()
}

/// Returns the longest time for which a task waits for a core, in base units. `cycles` are the lengths of the
/// cycles of all tasks, from the grant of a core on; `None`: a cycle may hold its core for ever.
fn core_wait(
    system: &TimedSystem,
    task: TaskId,
    cycles: &TiSlice<TaskId, Option<Ticks>>,
) -> Option<Ticks> {
    let needing = |index: &TaskId| system.needs_core(*index);
    let others = cycles.keys().filter(|cycle| *cycle != task && needing(cycle));
    // An aperiodic task that is woken continues its cycle, and may begin more in it.
    let is_bounded = |task: &TaskId| system.tasks[*task].period.is_some();
    let others: Vec<Option<Ticks>> =
        others.map(|cycle| cycles[cycle].filter(|_| is_bounded(&cycle))).collect();
    let cores = system.platform.cores.map(|core| core as usize);
    if !needing(&task) || cores.is_none_or(|cores| cores > others.len()) {
        return Some(0);
    }
    let tied = system.tasks.iter().any(|task| task.affinity.is_some());
    if system.platform.policy != Policy::Fifo || tied {
        return None;
    }
    let held = others.iter().filter(|cycle| cycle.is_none()).count();
    let left = cores?.checked_sub(held).filter(|&left| left > 0)?;
    let mut ahead = others.into_iter().flatten();
    let ahead = ahead.try_fold(0u32, u32::checked_add)?;
    Some(ahead / left as Ticks)
}

/// Returns true if codels wait only for codels of their component, as is the case if ports are copied.
pub(super) fn is_within_components(system: &TimedSystem) -> bool {
    system.codels.iter().all(|codel| {
        let mut others = codel.conflicts.iter();
        others.all(|conflict| system.codels[conflict].component == codel.component)
    })
}

/// Returns the greatest number of requests for each service; `None` if there is no limit.
pub(super) fn requests(system: &TimedSystem) -> TiVec<ServiceId, Option<u32>> {
    let mut out = ti_vec![Some(0u32); system.services.len()];
    for client in &system.clients {
        for (at, step) in client.steps.iter().enumerate() {
            if let ClientAction::Send { service, .. } = step.action {
                let again = client.comes_again(at);
                out[service] = out[service].filter(|_| !again).map(|number| number + 1);
            }
        }
    }
    out
}

/// Returns the longest time of a cycle, including its waits in the lock queue, in base units.
pub(super) fn cycle(
    system: &TimedSystem,
    task: TaskId,
    requests: &TiSlice<ServiceId, Option<u32>>,
) -> Option<Ticks> {
    let definition = &system.tasks[task];
    let component = &system.components[definition.component];
    let mut blocking: Ticks = 0;
    for &other in component.tasks.iter().filter(|&&other| other != task) {
        blocking = blocking.checked_add(longest_waited_for(system, &codels_of(system, other))?)?;
    }
    let control: Vec<CodelId> = (component.services.iter())
        .filter(|&&service| requests[service] != Some(0))
        .flat_map(|&service| {
            let service = &system.services[service];
            service.validate.iter().chain(&service.simple).copied()
        })
        .collect();
    blocking = blocking.checked_add(longest_waited_for(system, &control)?)?;
    work(system, task, requests, blocking)
}

/// Returns the longest time of the codels of a cycle, with this blocking for each.
pub(super) fn work(
    system: &TimedSystem,
    task: TaskId,
    requests: &TiSlice<ServiceId, Option<u32>>,
    blocking: Ticks,
) -> Option<Ticks> {
    let task = &system.tasks[task];
    let mut length: Ticks = 0;
    if let Some(permanent) = task.permanent {
        length = turn(system, system.machine_of(permanent), blocking)?;
    }
    // At most as many instances as places, and of each service at most as many as are requested.
    let mut instances: Vec<(Ticks, u32)> = Vec::new();
    for &a in &task.slots {
        let most = system.automata[a].service.and_then(|service| requests[service]);
        let time = turn(system, system.machine_of(a), blocking)?;
        instances.push((time, most.unwrap_or(task.places).min(task.places)));
    }
    instances.sort_unstable_by_key(|instance| std::cmp::Reverse(instance.0));
    let mut left = task.places;
    for (time, most) in instances {
        let count = most.min(left);
        length = length.checked_add(time.checked_mul(count)?)?;
        left -= count;
    }
    (length < FOREVER / 4).then_some(length)
}

fn codels_of(system: &TimedSystem, task: TaskId) -> Vec<CodelId> {
    let task = &system.tasks[task];
    let machines = task.permanent.iter().chain(&task.slots);
    let states = machines.flat_map(|&a| &system.machine_of(a).states);
    states.map(|state| state.codel).collect()
}

/// Returns the longest time of the given codels, among those for which some codel waits.
fn longest_waited_for(system: &TimedSystem, codels: &[CodelId]) -> Option<Ticks> {
    let waited_for = |id: CodelId| system.codels.iter().any(|codel| codel.conflicts.contains(id));
    let times = codels.iter().filter(|&&codel| waited_for(codel));
    let longest = times.map(|&time| system.codels[time].upper).max().unwrap_or(0);
    (longest != FOREVER).then_some(longest)
}

/// Returns the longest turn of a machine, from any resumed state to a pause or its end, with this blocking
/// for each codel.
fn turn(system: &TimedSystem, machine: &Machine, blocking: Ticks) -> Option<Ticks> {
    let time = |state: usize| {
        let upper = system.codels[machine.states[state].codel].upper;
        (upper != FOREVER).then(|| upper.checked_add(blocking)).flatten()
    };
    let times: Vec<Ticks> = (0..machine.states.len()).map(time).collect::<Option<_>>()?;
    if !pauseless_cycles(machine).is_empty() {
        // A turn enters every state at most this often; after an interruption another turn begins.
        let limit = machine.loop_limit.filter(|_| !machine.rounds)?;
        let once = times.iter().try_fold(0u32, |sum, &time| sum.checked_add(time))?;
        return once.checked_mul(2)?.checked_mul(u32::from(limit));
    }
    // After an interruption, the machine continues with `stop` between two codels.
    let mut longest = vec![None; machine.states.len()];
    let of_stop = match machine.stop {
        Some(stop) => way(machine, &times, 0, stop, &mut longest.clone())?,
        None => 0,
    };
    let mut most = 0;
    for state in 0..machine.states.len() {
        most = most.max(way(machine, &times, of_stop, state, &mut longest)?);
    }
    Some(most)
}

/// Returns the longest path from a state on; after each codel that continues, `stop` may come instead.
fn way(
    machine: &Machine,
    times: &[Ticks],
    of_stop: Ticks,
    state: usize,
    known: &mut [Option<Ticks>],
) -> Option<Ticks> {
    if let Some(tick) = known[state] {
        return Some(tick);
    }
    // An automaton that has paused may have to execute `stop` in a later pass of the same cycle.
    let mut rest = of_stop;
    for transition in &machine.states[state].yields {
        if let Yield::Next(next) = *transition {
            rest = rest.max(way(machine, times, of_stop, next, known)?);
        }
    }
    let out = times[state].checked_add(rest)?;
    known[state] = Some(out);
    Some(out)
}
