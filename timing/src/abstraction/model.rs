//! The model of the middle tier, and the systems that it refuses.

use typed_index_collections::{TiSlice, TiVec, ti_vec};

use super::activities::activities;
use super::cycle_automaton::{Activity, CycleAutomaton, cycle_automaton};
use super::order::chain;
use super::others::{Interference, OtherThread, interference, others, waits};
use super::refusal::Refusal;
use super::thread::{Start, Thread};
use crate::scn::semantics::{Cycle, LockRule, Semantics};
use crate::system::{
    CodelId, CodelSet, FOREVER, Machine, Policy, TaskId, Ticks, TimedSystem, Yield,
    pauseless_cycles,
};

/// Number of jobs in a hyperperiod above which a system is refused.
const JOBS: i64 = 20_000;

/// Number of combinations of initial places of tasks above which a system is refused.
const MAX_INITIAL_COMBINATIONS: usize = 64;

/// The tasks of a part of a system, and its model or the reason for a refusal.
pub(super) type Part<'s> = (Vec<TaskId>, Result<Model<'s>, Refusal>);

/// Tasks that are analysed together.
#[derive(Debug, Clone)]
pub(super) struct Model<'s> {
    pub(super) system: &'s TimedSystem,
    pub(super) threads: Vec<Thread>,
    /// Number of cores, if there are fewer cores than tasks.
    pub(super) cores: Option<usize>,
    /// Number of cores that other threads may hold at any time.
    pub(super) lent: usize,
    /// Interference by other threads, by group.
    pub(super) interference: Vec<Option<Interference>>,
    pub(super) policy: Policy,
    /// Codels wait in a queue. Otherwise any waiting codel may be next.
    pub(super) queue: bool,
    /// Codels for which some codel waits, by codel.
    pub(super) waited_for: TiVec<CodelId, bool>,
    /// Number of groups of tasks whose codels wait for each other.
    pub(super) groups: usize,
    /// Time after which all ticks repeat, in base units.
    pub(super) hyperperiod: i64,
}

impl Model<'_> {
    pub(super) fn cycle_automaton(&self, thread: usize) -> Option<&CycleAutomaton> {
        self.threads[thread].cycle_automaton.as_ref()
    }
}

/// Returns the parts of a system that can be analysed separately, each with its tasks, or the reason for a
/// refusal. `left` are the tasks that are not followed, with the reason. More tasks are added.
pub(super) fn models<'s>(
    system: &'s TimedSystem,
    left: &mut TiSlice<TaskId, Option<Refusal>>,
) -> Result<Vec<Part<'s>>, Refusal> {
    let platform = &system.platform;
    let servers = platform.semantics == Semantics::SERVERS;
    if !servers && platform.semantics.fixed().cycle == Cycle::Passes {
        return Err(Refusal::Semantics);
    }
    let asked = system.requested().contains(&true);
    if (asked && !servers) || system.has_builtin(|_| true) {
        return Err(Refusal::Requests);
    }
    let activities = activities(system, left);
    let codels: TiVec<TaskId, CodelSet> =
        activities.iter().map(|activity| codels(system, activity)).collect();
    let needing = system.tasks.keys().filter(|&task| system.needs_core(task)).count();
    let enough = platform.cores.is_none_or(|core| core as usize >= needing);
    let tied = system.tasks.iter().any(|task| task.affinity.is_some());
    // Under preemption, control tasks take cores as well.
    let controls = if asked { system.components.len() } else { 0 };
    let all = system.tasks.len() + controls;
    let alone = platform.cores.is_none_or(|core| core as usize >= all);
    if system.preempts() && (!alone || tied) {
        return Err(Refusal::Preemption);
    }
    let mut threads: Vec<Thread> = Vec::new();
    for (task, entry) in system.tasks.iter_enumerated() {
        if servers && system.runs_apart(task) {
            return Err(Refusal::Apart);
        }
        let made = match (entry.period, left[task]) {
            (_, Some(refusal)) => Err(refusal),
            (Some(period), None) => thread(system, task, period, &activities[task], servers),
            (None, None) => Err(Refusal::Aperiodic),
        };
        match made {
            Ok(refusal) => threads.push(refusal),
            Err(refusal) if servers => left[task] = Some(refusal),
            Err(refusal) => return Err(refusal),
        }
    }
    let followed = |task: TaskId| left[task].is_none();
    let others = others(system, &codels, followed);
    let groups = group(system, &mut threads, (&codels, &others), servers);
    if !servers
        && platform.semantics.locks != LockRule::Free
        && threads.iter().any(|thread| thread.contends)
    {
        return Err(Refusal::Semantics);
    }
    if servers {
        chain(system, &mut threads, enough);
    }
    let whole = |threads: Vec<Thread>, cores: Option<usize>, groups: usize| {
        let hyperperiod = hyperperiod(&threads)?;
        let mut interference = Vec::new();
        for group in 0..groups {
            let own = |thread: &&Thread| thread.group == group && thread.contends;
            let component = threads.iter().find(own);
            let component = component.map(|component| system.tasks[component.task].component);
            let of_group = others.iter().filter(|thread| Some(thread.component) == component);
            let of_group: Vec<OtherThread> = of_group.cloned().collect();
            interference.push(self::interference(system, &of_group));
        }
        // A task without work asks for a core once, and holds it for no time.
        let lends =
            |&task: &TaskId| !followed(task) && system.needs_core(task) && !codels[task].is_empty();
        let lent = system.tasks.keys().filter(lends).count();
        if cores.is_some_and(|cores| cores <= lent) {
            // The reason that counts is that of a task with a period, if there is one.
            let mut periodic =
                system.tasks.keys().filter(|&task| system.tasks[task].period.is_some());
            return Err(periodic.find_map(|task| left[task]).unwrap_or(Refusal::Aperiodic));
        }
        Ok(Model {
            system,
            threads,
            cores,
            lent: cores.map_or(0, |_| lent),
            interference,
            policy: platform.policy,
            queue: servers,
            waited_for: waited_for(system),
            groups,
            hyperperiod,
        })
    };
    if !enough {
        let tasks: Vec<TaskId> = threads.iter().map(|thread| thread.task).collect();
        for thread in &mut threads {
            let number = |next: TaskId| tasks.iter().position(|&task| task == next);
            thread.successor = thread.next_task.and_then(number);
        }
        let cores = platform.cores.map(|core| core as usize);
        return Ok(vec![(tasks, whole(threads, cores, groups))]);
    }
    // Without shared cores, tasks interact only in their groups, and where one starts another.
    let parts = parts(&threads);
    let models = parts.into_iter().map(|part| {
        let all = std::mem::take(&mut threads).into_iter();
        let (mut own, rest): (Vec<Thread>, Vec<Thread>) =
            all.partition(|thread| part.contains(&thread.task));
        threads = rest;
        let mut numbers: Vec<usize> = own.iter().map(|thread| thread.group).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let tasks: Vec<TaskId> = own.iter().map(|thread| thread.task).collect();
        for thread in &mut own {
            thread.group = numbers.binary_search(&thread.group).unwrap_or(0);
            thread.successor =
                thread.next_task.and_then(|next| tasks.iter().position(|&task| task == next));
        }
        (tasks, whole(own, None, numbers.len()))
    });
    Ok(models.collect())
}

/// Returns the codels of some activities.
fn codels(system: &TimedSystem, activities: &[Activity]) -> CodelSet {
    let mut all = CodelSet::default();
    for activity in activities {
        let states = system.machines[activity.machine].states.iter();
        states.for_each(|state| all.insert(state.codel));
    }
    all
}

fn thread(
    system: &TimedSystem,
    task: TaskId,
    period: Ticks,
    activities: &[Activity],
    servers: bool,
) -> Result<Thread, Refusal> {
    let definition = &system.tasks[task];
    let period = i64::from(period);
    if definition.keep_idle_tick && !servers {
        return Err(Refusal::KeepsTicks);
    }
    if system.runs_apart(task) {
        return Err(Refusal::Apart);
    }
    for activity in activities {
        let machine = &system.machines[activity.machine];
        if machine.loop_limit.is_none() && !pauseless_cycles(machine).is_empty() {
            return Err(Refusal::WithoutPause);
        }
        let upper = |state: &crate::system::State| system.codels[state.codel].upper;
        if machine.states.iter().any(|state| upper(state) == FOREVER) {
            return Err(Refusal::Endless { task });
        }
    }
    let cycle_automaton = match activities {
        [] => None,
        _ => Some(cycle_automaton(system, activities)?),
    };
    let first = match system.first_tick(task).filter(|_| servers) {
        Some(first) => i64::try_from(first).unwrap_or(i64::MAX),
        None => period + i64::from(definition.delay),
    };
    let paused = match (servers, activities, &cycle_automaton) {
        (true, ..) => Vec::new(),
        (false, [only], Some(cycle_automaton)) => {
            let paused = after_start_up(system, &system.machines[only.machine])?;
            let paused = paused
                .into_iter()
                .filter_map(|after_start_up| cycle_automaton.paused_at(after_start_up));
            paused.collect()
        }
        (false, ..) => return Err(Refusal::Ends),
    };
    Ok(Thread {
        task,
        period,
        first,
        cycle_automaton,
        group: 0,
        contends: false,
        paused,
        next_task: None,
        successor: None,
        started: false,
        start: Start::AT_ONCE,
        early: None,
    })
}

/// Published models: returns the states at which a machine can pause first, if that takes no time.
fn after_start_up(system: &TimedSystem, machine: &Machine) -> Result<Vec<usize>, Refusal> {
    let ends = |state: &crate::system::State| {
        system.codels[state.codel].throws || state.yields.contains(&Yield::End)
    };
    if machine.states.iter().any(ends) {
        return Err(Refusal::Ends);
    }
    let mut paused = Vec::new();
    let mut seen = vec![false; machine.states.len()];
    let mut todo = vec![machine.start];
    while let Some(at) = todo.pop() {
        if std::mem::replace(&mut seen[at], true) {
            continue;
        }
        let state = &machine.states[at];
        if system.codels[state.codel].upper > 0 {
            return Err(Refusal::StartUp);
        }
        for transition in &state.yields {
            match *transition {
                Yield::Next(next) => todo.push(next),
                Yield::Pause(next) if !paused.contains(&next) => paused.push(next),
                _ => {}
            }
        }
    }
    Ok(paused)
}

fn waited_for(system: &TimedSystem) -> TiVec<CodelId, bool> {
    let mut out = ti_vec![false; system.codels.len()];
    for codel in &system.codels {
        codel.conflicts.iter().for_each(|other| out[other] = true);
    }
    out
}

/// Puts tasks whose codels wait for each other into groups. With a queue, all tasks of a component with any
/// conflict belong to one group, because they share the queue.
fn group(
    system: &TimedSystem,
    threads: &mut [Thread],
    (codels, others): (&TiSlice<TaskId, CodelSet>, &[OtherThread]),
    servers: bool,
) -> usize {
    let component = |task: TaskId| system.tasks[task].component;
    let tasks: Vec<TaskId> = threads.iter().map(|thread| thread.task).collect();
    // True if others of its component wait for a task, or the task for them, or others for each other.
    let disturbed = |thread: usize| {
        let own = component(tasks[thread]);
        let others: Vec<&OtherThread> =
            others.iter().filter(|thread| thread.component == own).collect();
        let mut all = others.iter().enumerate();
        all.any(|(number, candidate)| {
            candidate.meets(system, &codels[tasks[thread]])
                || others[..number].iter().any(|other| candidate.meets(system, &other.codels))
        })
    };
    let waits = |one: usize, other: usize| {
        (servers && component(tasks[one]) == component(tasks[other]) && disturbed(one))
            || waits(system, &codels[tasks[one]], &codels[tasks[other]])
    };
    let mut of: Vec<usize> = (0..threads.len()).collect();
    for one in 0..threads.len() {
        for other in (0..threads.len()).filter(|&thread| thread != one) {
            if !waits(one, other) {
                continue;
            }
            let of_component = |thread: usize| component(tasks[thread]) == component(tasks[one]);
            let joined = |thread: usize| {
                thread == one || thread == other || (servers && of_component(thread))
            };
            let joined: Vec<usize> = (0..threads.len()).filter(|&thread| joined(thread)).collect();
            let old: Vec<usize> = joined.iter().map(|&thread| of[thread]).collect();
            let into = of[one];
            for thread in &mut of {
                if old.contains(thread) {
                    *thread = into;
                }
            }
            for thread in joined {
                threads[thread].contends = true;
            }
        }
    }
    for (thread, entry) in threads.iter_mut().enumerate() {
        entry.contends |= servers && disturbed(thread);
    }
    let mut numbers = of.clone();
    numbers.sort_unstable();
    numbers.dedup();
    for (thread, of) in threads.iter_mut().zip(of) {
        thread.group = numbers.binary_search(&of).unwrap_or(0);
    }
    numbers.len()
}

/// Returns sets of tasks that are connected by groups or by starting one another, as numbers in the system.
fn parts(threads: &[Thread]) -> Vec<Vec<TaskId>> {
    let mut of: Vec<usize> = (0..threads.len()).collect();
    let mut join = |one: usize, other: usize| {
        let (from, to) = (of[one].max(of[other]), of[one].min(of[other]));
        of.iter_mut().filter(|thread| **thread == from).for_each(|thread| *thread = to);
    };
    for (one, thread) in threads.iter().enumerate() {
        if let Some(next) = thread.next_task
            && let Some(next) = threads.iter().position(|thread| thread.task == next)
        {
            join(one, next);
        }
        let same = |other: &usize| threads[*other].group == thread.group;
        (0..one).filter(same).for_each(|other| join(one, other));
    }
    let mut out: Vec<Vec<TaskId>> = Vec::new();
    for first in 0..threads.len() {
        if of[first] == first {
            let own = (0..threads.len()).filter(|&thread| of[thread] == first);
            out.push(own.map(|thread| threads[thread].task).collect());
        }
    }
    out
}

/// Returns the least common multiple of all periods.
fn hyperperiod(threads: &[Thread]) -> Result<i64, Refusal> {
    let mut all: i64 = 1;
    for thread in threads {
        all = all / gcd(all, thread.period) * thread.period;
        if all > 1 << 40 {
            return Err(Refusal::Hyperperiod);
        }
    }
    let jobs: i64 = threads.iter().map(|thread| all / thread.period).sum();
    let beginnings = |thread: &Thread| {
        let after = thread.start.after.filter(|_| !thread.started);
        let ticks =
            after.map_or(0, |after| (after.to - thread.first).div_euclid(thread.period) + 1);
        let started = ticks.max(0) as usize + 1 + usize::from(thread.start.fails);
        thread.paused.len().max(started)
    };
    let beginnings =
        threads.iter().try_fold(1usize, |all, thread| all.checked_mul(beginnings(thread)));
    match jobs > JOBS {
        true => Err(Refusal::Hyperperiod),
        false if beginnings.is_none_or(|beginning| beginning > MAX_INITIAL_COMBINATIONS) => {
            Err(Refusal::StartUp)
        }
        false => Ok(all),
    }
}

fn gcd(one: i64, other: i64) -> i64 {
    match other {
        0 => one,
        _ => gcd(other, one % other),
    }
}
