//! Response-time analysis under the semantics of the servers.
//!
//! A cycle is a sequence of codels, and before each of them its task takes a ticket. At that moment every
//! other thread of the component is ahead with at most one codel, in the queue or executing; its later
//! tickets come behind. The head of the queue waits for codels that execute, the next codel waits for the
//! head to begin, and so on. Until the task has its turn, at most one codel of each other thread has ended
//! for which a codel of a third thread or of the task waited. So a cycle takes at most the sum, over its
//! codels, of their times and of the longest such codel of each other thread ([`Window::cycle`]). Instead, a
//! thread may count with all such codels that it executes meanwhile: a codel that its activity executes only
//! once counts once for each instance, and a periodic task executes only so many cycles.
//!
//! With fewer cores than tasks, a job also waits for cores ([`cores`]). What a task can execute in a window
//! of time depends on the requests that play a part in it ([`super::windows`]): the bound is the greatest of
//! those of all windows. The bounds are the least fixed point of these equations; no job can be the first to
//! exceed its own bound.
//!
//! If a bound is less than the period, no tick comes during a cycle, and every measured job is one cycle,
//! which starts at its tick. The first cycle of a task begins at its first tick, or later with a kept tick:
//! when the first passes of the earlier tasks of the component have ended. A tick that comes during it is
//! kept, and the second cycle follows at once. So no tick comes during the second cycle if both together take
//! less than the period, or if the latest end of the first cycle and the length of the second one lie before
//! the next tick.
//!
//! Nothing here depends on the times at which codels end: the bounds hold for any duration up to the longest,
//! also if it is not a whole number of units.

use typed_index_collections::{TiVec, ti_vec};

use super::situations::situations;
use super::windows::{ClientWindow, windows};
use crate::cancel::Cancel;
use crate::system::{
    AutomatonId, CodelId, CodelSet, Machine, ServiceId, TaskId, Ticks, TimedSystem, Yield,
};

mod control;
mod cores;
mod jobs;
mod length;
mod turns;

pub(super) use self::turns::Turns;

/// Length of the windows of aperiodic tasks, in longest periods. Their bounds are shorter than a window.
const PERIODS: Ticks = 4;

/// Upper limit on the number of rounds: a quick bound must be quick.
const ROUNDS: usize = 1000;

/// The greatest times of a task, in base units. `None`: no bound below the period is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Bound {
    /// From the beginning of the first cycle, the start-up, to the end of its first pass.
    pass: Option<u64>,
    /// From the beginning of the first cycle to its end. An aperiodic task has none.
    first: Option<u64>,
    /// From the time at which the [leader](chain) of the task begins to the end of the first cycle.
    start_up: Option<u64>,
    /// From the tick of another cycle to its end.
    other: Option<u64>,
    /// From the beginning of the second cycle to its end, if a tick may have come before.
    second: Option<u64>,
}

impl Bound {
    const LEAST: Bound =
        Bound { pass: Some(0), first: Some(0), start_up: Some(0), other: Some(0), second: Some(0) };
}

/// A cycle, or a part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cycle {
    /// The first pass of the first cycle.
    FirstPass,
    First,
    /// The first cycle, and all that its component does since the [leader](chain) of the task has begun.
    StartUp,
    Other,
}

/// The times at which a task begins, and the bound that follows from them.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    /// The earliest beginning of the first cycle.
    begins: u64,
    /// The latest beginning of the first cycle.
    latest: Option<u64>,
    /// The earliest and the latest beginning of its [leader](chain).
    leader_begins: u64,
    leader_latest: Option<u64>,
    /// The first tick that can come after it: no measured job begins earlier.
    next: u64,
    /// The latest end of the first cycle.
    ends: Option<u64>,
    /// The greatest time from a tick to the end of the cycle that serves it, if the task meets its deadlines.
    after_tick: Option<u64>,
}

type Knowns = TiVec<TaskId, Known>;

/// Returns the tasks of the component, up to this one, of which each but the first begins as soon as the one
/// before has ended its first pass. The first of them, the leader, begins at a tick.
fn chain(system: &TimedSystem, task: TaskId) -> &[TaskId] {
    let all = &system.components[system.tasks[task].component].tasks;
    let (mut begins, mut leader) = (0, 0);
    for (number, &other) in all.iter().enumerate() {
        let first_tick = system.first_tick(other).unwrap_or(0);
        if first_tick > begins {
            (begins, leader) = (first_tick, number);
        }
        if other == task {
            return &all[leader..=number];
        }
    }
    &[]
}

/// The bounds of all tasks, and the times that follow from them.
struct Facts<'f> {
    bounds: &'f TiVec<TaskId, Bound>,
    known: &'f Knowns,
}

/// Returns the known times of each task.
fn known(system: &TimedSystem, bounds: &TiVec<TaskId, Bound>) -> Knowns {
    let mut out = ti_vec![Known::default(); system.tasks.len()];
    for component in &system.components {
        // The earliest and the latest beginning of a first cycle.
        let (mut begins, mut latest) = (0u64, Some(0u64));
        let (mut leader_begins, mut leader_latest) = (begins, latest);
        for &task in &component.tasks {
            let Bound { pass, first, start_up, other, second } = bounds[task];
            let period = system.tasks[task].period.map(u64::from);
            let first_tick = system.first_tick(task).unwrap_or(0);
            let is_leader = first_tick > begins;
            begins = begins.max(first_tick);
            latest = latest.map(|latest| latest.max(first_tick));
            if is_leader {
                (leader_begins, leader_latest) = (begins, latest);
            }
            let after = |time: Option<u64>| latest?.checked_add(time?);
            let ends = after(if period.is_some() { first } else { pass });
            let together = leader_latest.zip(start_up).map(|(begins, time)| begins + time);
            let ends = ends.into_iter().chain(together).min();
            let begins_by = latest;
            latest = after(pass).into_iter().chain(ends).min();
            // A task that begins late has an older tick, and the tick of that moment may come after it.
            let next = period.map_or(begins, |period| match begins - first_tick {
                0 => first_tick + period,
                late => first_tick + late.div_ceil(period) * period,
            });
            // A tick that comes during the first cycle is kept.
            let late = || match ends {
                Some(ends) if ends < next => Some(0),
                Some(ends) => Some((ends + second? - next).min(first? + second?)),
                None => Some(first? + second?),
            };
            let most = || Some(late()?.max(other?)).filter(|&most| Some(most) < period);
            out[task] = Known {
                begins,
                latest: begins_by,
                leader_begins,
                leader_latest,
                next,
                ends,
                after_tick: most(),
            };
        }
    }
    out
}

/// Returns a bound on the response time of every task; `None` if there is none.
pub(super) fn response_bounds(
    system: &TimedSystem,
    cancel: &Cancel,
) -> TiVec<TaskId, Option<Ticks>> {
    let none = || ti_vec![None; system.tasks.len()];
    if !is_within_components(system) {
        return none();
    }
    let Some(longest) = system.tasks.iter().filter_map(|task| task.period).max() else {
        return none();
    };
    let situations = situations(system);
    let turns = Turns::new(system, &situations);
    // The length of the windows of the jobs of each task, and the windows.
    let length =
        |task: TaskId| system.tasks[task].period.unwrap_or(longest.saturating_mul(PERIODS));
    let of_task = |task: TaskId| -> Vec<Window> {
        let all = windows(system, &situations, length(task)).into_iter();
        all.map(|client| Window::new(&turns, client, Some(length(task)))).collect()
    };
    let all: TiVec<TaskId, Vec<Window>> = system.tasks.keys().map(of_task).collect();
    let mut bounds: TiVec<TaskId, Bound> = ti_vec![Bound::LEAST; system.tasks.len()];
    for _ in 0..ROUNDS {
        let known = known(system, &bounds);
        let next: TiVec<TaskId, Bound> = all
            .iter_enumerated()
            .map(|(task, windows)| {
                let greatest = |cycle: Cycle, least: Option<u64>| {
                    // The first cycle is over before some windows begin.
                    let ends =
                        known[task].ends.filter(|_| cycle != Cycle::Other).unwrap_or(u64::MAX);
                    let windows = windows.iter().filter(|window| window.client.begins <= ends);
                    let each = windows.map(|window| {
                        let bound = window.response(task, cycle, least?, &known, None)?;
                        // A longer bound is useless, and is not followed any further.
                        (bound < u64::from(length(task))).then_some(bound)
                    });
                    let each: Option<Vec<u64>> = each.collect();
                    each?.into_iter().max()
                };
                let Bound { pass, first, start_up, other, .. } = bounds[task];
                let other = greatest(Cycle::Other, other);
                Bound {
                    pass: greatest(Cycle::FirstPass, pass),
                    first: greatest(Cycle::First, first),
                    start_up: greatest(Cycle::StartUp, start_up),
                    other,
                    second: other,
                }
            })
            .collect();
        if next == bounds {
            let bounds = jobs::improve(&turns, &situations, &all, bounds, cancel);
            let known = self::known(system, &bounds);
            let bound = |task: TaskId| {
                let Bound { other, second, .. } = bounds[task];
                let Known { next, ends, after_tick, .. } = known[task];
                after_tick?;
                let second = second.filter(|_| ends.is_none_or(|ends| ends >= next));
                Ticks::try_from(other?.max(second.unwrap_or(0))).ok()
            };
            return system.tasks.keys().map(bound).collect();
        }
        bounds = next;
    }
    none()
}

/// Returns true if codels wait only for codels of their component, as is the case if ports are copied.
pub(super) fn is_within_components(system: &TimedSystem) -> bool {
    system.codels.iter().all(|codel| {
        let mut others = codel.conflicts.iter();
        others.all(|conflict| system.codels[conflict].component == codel.component)
    })
}

/// A codel that a thread can execute in a window.
struct Rival {
    codel: CodelId,
    /// The greatest number of times that the thread executes it; `None`: no limit.
    often: Option<u32>,
    /// The threads with codels that wait for it.
    waiting: Vec<usize>,
    /// The task executes it in its first pass only.
    is_start: bool,
}

impl Rival {
    /// Returns true if a thread can execute the codel after a task of the component has begun.
    fn plays_part(&self, thread: usize, task: TaskId) -> bool {
        // The first passes of the tasks are in their order.
        !self.is_start || thread > usize::from(task)
    }
}

/// The work of the system in a window of time.
pub(super) struct Window<'s> {
    system: &'s TimedSystem,
    turns: &'s Turns<'s>,
    client: ClientWindow,
    /// Its length; `None`: the whole run.
    length: Option<Ticks>,
    /// By thread (tasks, then control tasks): its codels for which another thread can wait.
    rivals: Vec<Vec<Rival>>,
    /// By thread: it can execute a codel, and takes a ticket before.
    takes_tickets: Vec<bool>,
    priorities: Vec<u64>,
}

impl<'s> Window<'s> {
    pub(super) fn new(
        turns: &'s Turns<'s>,
        client: ClientWindow,
        length: Option<Ticks>,
    ) -> Window<'s> {
        let system = turns.system;
        let mut out = Window {
            system,
            turns,
            client,
            length,
            rivals: Vec::new(),
            takes_tickets: Vec::new(),
            priorities: system.priorities(),
        };
        let threads = out.codels_of_threads();
        out.takes_tickets = threads.iter().map(|codels| !codels.is_empty()).collect();
        let waits_for: Vec<CodelSet> = (threads.iter())
            .map(|codels| {
                let mut all = CodelSet::default();
                let conflicts = codels.iter().map(|(codel, _)| &system.codels[*codel].conflicts);
                conflicts.flat_map(CodelSet::iter).for_each(|codel| all.insert(codel));
                all
            })
            .collect();
        let permanent = system.tasks.iter().filter_map(|task| task.permanent);
        let starts: Vec<CodelId> =
            permanent.filter_map(|automaton| executed_once(system.machine_of(automaton))).collect();
        let rivals = threads.into_iter().enumerate().map(|(thread, codels)| {
            let rival = |(codel, often): (CodelId, Option<u32>)| {
                let waits = |&other: &usize| other != thread && waits_for[other].contains(codel);
                let waiting: Vec<usize> = (0..waits_for.len()).filter(waits).collect();
                let is_start = starts.contains(&codel);
                (!waiting.is_empty()).then_some(Rival { codel, often, waiting, is_start })
            };
            codels.into_iter().filter_map(rival).collect()
        });
        out.rivals = rivals.collect();
        out
    }

    /// Returns the codels that each thread can execute in the window, and how often, if there is a limit.
    fn codels_of_threads(&self) -> Vec<Vec<(CodelId, Option<u32>)>> {
        let system = self.system;
        let tasks = system.tasks.iter().map(|task| {
            let automata = task.permanent.iter().chain(&task.slots);
            automata.flat_map(|&automaton| self.codels_of(automaton)).collect()
        });
        let controls = system.components.iter().map(|component| {
            let services =
                component.services.iter().map(|&service| (service, self.client.requests[service]));
            let requested = services.filter(|(_, count)| *count != Some(0));
            let codels = requested.flat_map(|(service, count)| {
                self.control_codels(service).map(move |codel| (codel, count))
            });
            codels.collect()
        });
        tasks.chain(controls).collect()
    }

    fn codels_of(&self, automaton: AutomatonId) -> Vec<(CodelId, Option<u32>)> {
        let machine = self.system.machine_of(automaton);
        let service = self.system.automata[automaton].service;
        let count = service.map_or(Some(1), |service| self.client.requests[service]);
        if count == Some(0) {
            return Vec::new();
        }
        let after = |state: usize| {
            let mut states = following(machine, state);
            states.push(state);
            states
        };
        let before_stop = after(machine.start);
        let stop = self.turns.stop_of(automaton).map_or(Vec::new(), after);
        let states = machine.states.iter().enumerate();
        let states = states.filter_map(|(state, entry)| {
            let ways = [&before_stop, &stop].into_iter().filter(|states| states.contains(&state));
            let ways = u32::try_from(ways.count()).ok().filter(|ways| *ways > 0)?;
            let visits = if following(machine, state).contains(&state) {
                let round = self.shortest_round(machine, state).filter(|round| *round > 0);
                round.zip(self.length).map(|(round, length)| length / round + ways)
            } else {
                Some(ways)
            };
            let often = count.zip(visits).map(|(count, visits)| count.saturating_mul(visits));
            Some((entry.codel, often))
        });
        states.collect()
    }

    /// Returns the least execution time from the beginning of a state to its next beginning.
    fn shortest_round(&self, machine: &Machine, state: usize) -> Option<Ticks> {
        let lower = |at: usize| self.system.codels[machine.states[at].codel].lower;
        let mut least: Vec<Option<Ticks>> = vec![None; machine.states.len()];
        let mut queue = vec![(0, state)];
        let mut back: Option<Ticks> = None;
        while let Some((time, at)) = queue.pop() {
            let time = lower(at).saturating_add(time);
            for transition in &machine.states[at].yields {
                let (Yield::Next(next) | Yield::Pause(next)) = *transition else {
                    continue;
                };
                if next == state {
                    back = Some(back.map_or(time, |back| back.min(time)));
                } else if least[next].is_none_or(|known| time < known) {
                    least[next] = Some(time);
                    queue.push((time, next));
                }
            }
        }
        back
    }

    /// Returns the codels of another thread for which a task can wait before a codel.
    fn ahead(
        &self,
        task: TaskId,
        codel: CodelId,
        thread: usize,
    ) -> impl Iterator<Item = &Rival> + '_ {
        let conflicts = &self.system.codels[codel].conflicts;
        let waits = move |rival: &&Rival| {
            let by_third = || rival.waiting.iter().any(|thread| *thread != usize::from(task));
            conflicts.contains(rival.codel) || by_third()
        };
        let rivals = self.rivals[thread].iter();
        rivals.filter(move |rival| rival.plays_part(thread, task)).filter(waits)
    }

    /// Returns the greatest execution time of some codels.
    fn most<'r>(&self, rivals: impl Iterator<Item = &'r Rival>) -> Ticks {
        rivals.map(|rival| self.system.codels[rival.codel].upper).max().unwrap_or(0)
    }

    /// Returns the other threads of the component of a task.
    fn threads_beside(&self, task: TaskId) -> impl Iterator<Item = usize> + '_ {
        let component = self.system.tasks[task].component;
        let tasks = self.system.components[component].tasks.iter().map(|&other| usize::from(other));
        let control = self.system.tasks.len() + usize::from(component);
        tasks.chain([control]).filter(move |&thread| thread != usize::from(task))
    }

    /// Returns the codels that the control task executes for a request.
    fn control_codels(&self, service: ServiceId) -> impl Iterator<Item = CodelId> + 's {
        let service = &self.system.services[service];
        service.validate.iter().chain(&service.simple).copied()
    }
}

/// Returns the first codel of a permanent activity, if the machine does not return to it.
fn executed_once(machine: &Machine) -> Option<CodelId> {
    let start = machine.start;
    let mut ways = [Some(start), machine.stop].into_iter().flatten();
    let returns = ways.any(|state| following(machine, state).contains(&start));
    (!returns).then_some(machine.states[start].codel)
}

/// Returns the states that a machine can enter after a state, in the same turn or a later one.
fn following(machine: &Machine, state: usize) -> Vec<usize> {
    let mut found = Vec::new();
    let mut stack = vec![state];
    while let Some(at) = stack.pop() {
        for transition in &machine.states[at].yields {
            if let Yield::Next(next) | Yield::Pause(next) = *transition
                && !found.contains(&next)
            {
                found.push(next);
                stack.push(next);
            }
        }
    }
    found
}
