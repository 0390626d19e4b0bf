//! Agreement of the explorer with an independent brute-force interpreter, on random small systems.

mod against;
mod brute;
mod certificates;
mod chains;
mod expected;
mod invariants;
mod rounding;
mod sensitivity;
mod sequences;
mod servers;
mod systems;
mod walks;

use std::sync::atomic::{AtomicUsize, Ordering};

use self::brute::{Brute, CAP, Results};
use dotgen_timing::abstraction::{Budget, abstract_bounds};
use dotgen_timing::analytic::{meets_deadlines, response_bounds};
use dotgen_timing::explore::{
    Bound, Kind, Limits, Measured, ResponseTime, Run, Stop, Watch, Within, explore, search_once,
};
use dotgen_timing::property::Predicate;
use dotgen_timing::system::{TaskId, TimedSystem};
use dotgen_timing::verify::Cancel;

/// Returns limits for an exploration. One of every four systems is explored with all reductions; for the
/// others, random reductions are switched off.
fn limits(seed: u64) -> Limits {
    let mut dice = systems::Dice::new(seed ^ 0x5eed);
    let off = |_: &Kind| !seed.is_multiple_of(4) && dice.in_ten(3);
    Limits {
        states: 400_000,
        bytes: 1 << 28,
        threads: 1,
        without: Kind::ALL.into_iter().filter(off).collect(),
        ..Limits::default()
    }
}

/// Compares all results for the system of one seed; `None` if the system is too large for brute force.
fn compare(seed: u64) -> Option<Result<(), String>> {
    let (system, within) = systems::random(&mut systems::Dice::new(seed));
    let all: Vec<usize> = (0..system.tasks.len()).collect();
    compare_system(seed, &system, &withins(within), &all, 1)
}

fn withins(pairs: Vec<(Predicate, Predicate)>) -> Vec<Within> {
    let within = |(trigger, response)| Within { trigger, responses: vec![response], limit: None };
    pairs.into_iter().map(within).collect()
}

/// Compares all results for a system, with only the response times of `measured` tasks. Limits differ from
/// task to task, unless `vary` is 0.
fn compare_system(
    seed: u64,
    system: &TimedSystem,
    within: &[Within],
    measured: &[usize],
    vary: usize,
) -> Option<Result<(), String>> {
    let brute = Brute { system, within, reach: &[] };
    let expected = brute.explore(30_000)?;
    let all: Vec<usize> = (0..system.tasks.len()).collect();
    // Limits that are never, sometimes, or soon exceeded.
    let limit = |i: usize, longest: Option<u32>| match (seed as usize + i * vary) % 4 {
        0 => None,
        1 => longest,
        2 => longest.map(|number| number.saturating_sub(1)),
        _ => longest.map(|number| number / 2),
    };
    let watch = Watch {
        schedulable: all.iter().map(|&task| TaskId::from(task)).collect(),
        overdue: all.iter().map(|&task| TaskId::from(task)).collect(),
        response: (measured.iter().enumerate())
            .map(|(i, &task)| ResponseTime {
                task: TaskId::from(task),
                limit: limit(i, expected.response[task]),
                most: None,
            })
            .collect(),
        within: (within.iter().enumerate())
            .map(|(i, bound)| Within { limit: limit(i + 1, expected.within[i]), ..bound.clone() })
            .collect(),
        deadlock: true,
        ..Watch::default()
    };
    let found = explore(system, &watch, limits(seed), &Cancel::default());
    // After all questions are answered, the exploration stops.
    let answered = found.stopped == Some(Stop::Answered);
    if found.stopped.is_some() && !answered {
        return Some(Err(format!(
            "seed {seed}: gave up {:?}; brute force has {} states: {expected:?}\n{system:#?}",
            found.stopped, expected.states
        )));
    }
    let check = || -> Result<(), String> {
        let replay = |found: &Run| {
            brute.replay(&found.steps, found.end).map_err(|why| format!("{why}: {found:?}"))
        };
        let agree = |what: &str, i: usize, one: bool, other: bool| {
            if one == other {
                Ok(())
            } else {
                Err(format!("{what} {i}: brute {one}, found {other}"))
            }
        };
        for t in 0..system.tasks.len() {
            agree("missed", t, expected.missed[t], found.missed[t].is_some())?;
            agree("overdue", t, expected.overdue[t], found.overdue[t].is_some())?;
            for (list, pick) in [
                (
                    &found.missed,
                    (|results: &Results| &results.missed) as fn(&Results) -> &Vec<bool>,
                ),
                (&found.overdue, |results: &Results| &results.overdue),
            ] {
                if let Some(found) = &list[t]
                    && !pick(&replay(found)?)[t]
                {
                    return Err(format!("run of task {t} shows nothing: {found:?}"));
                }
            }
        }
        for (asked, response) in watch.response.iter().zip(&found.response) {
            let t = asked.task;
            let age = |found: &Run| Ok(replay(found)?.response[usize::from(t)]);
            bound("response", usize::from(t), expected.response[usize::from(t)], response, age)?;
            let first = &expected.response_at[usize::from(t)];
            excess("response", usize::from(t), asked.limit, first, response, age)?;
        }
        for (i, asked) in watch.within.iter().enumerate() {
            let age = |found: &Run| Ok(replay(found)?.within[i]);
            bound("within", i, expected.within[i], &found.within[i], age)?;
            let first = &expected.within_at[i];
            excess("within", i, asked.limit, first, &found.within[i], age)?;
        }
        let quick = response_bounds(system, &Cancel::default());
        for (&t, response) in measured.iter().zip(&found.response) {
            if let (Some(quick), Some(exact)) = (quick[TaskId::from(t)], response)
                && exact.bound > Bound::Finite(quick)
            {
                return Err(format!(
                    "response {t} is {:?}, the quick bound says {quick}",
                    exact.bound
                ));
            }
        }
        for t in 0..system.tasks.len() {
            if meets_deadlines(system, TaskId::from(t), quick[TaskId::from(t)])
                && expected.missed[t]
            {
                return Err(format!("task {t} misses a deadline, its quick bound is {quick:?}"));
            }
        }
        abstracted(system, Budget::default(), &expected)?;
        // With busy windows from the start.
        let batches = Budget { before_coarse: 0, ..Budget::default() };
        abstracted(system, batches, &expected)?;
        // With a coarser model from the start.
        let coarse = Budget { batches: false, ..batches };
        abstracted(system, coarse, &expected)?;
        agree("deadlock", 0, expected.deadlock, found.deadlock.is_some())?;
        if let Some(deadlock) = &found.deadlock
            && !replay(deadlock)?.deadlock
        {
            return Err("no deadlock at the end of the run".to_owned());
        }
        knowing_bounds(seed, system, measured, &expected.response)?;
        chased(seed, &brute, &expected)?;
        let refused: Vec<bool> =
            (system.services.keys()).map(|service| found.refused.contains(&service)).collect();
        if !answered && refused != expected.refused {
            return Err(format!("refused: brute {:?}, found {refused:?}", expected.refused));
        }
        Ok(())
    };
    Some(check().map_err(|why| format!("seed {seed}: {why}\n{system:#?}\n{within:#?}")))
}

/// Checks that no run exceeds a bound of the middle tier, and that no deadline is missed.
fn abstracted(system: &TimedSystem, budget: Budget, expected: &Results) -> Result<(), String> {
    let bounds = abstract_bounds(system, budget, &Cancel::default());
    if bounds.iter().all(Result::is_err) {
        return Ok(());
    }
    ABSTRACTED.fetch_add(1, Ordering::Relaxed);
    for (task, bound) in bounds.into_iter().enumerate() {
        let Ok(bound) = bound else {
            continue;
        };
        let exact = expected.response[task];
        if exact.is_some_and(|response| response > bound) {
            return Err(format!("response {task} is {exact:?}, the middle tier says {bound}"));
        }
        REACHED.fetch_add(usize::from(exact == Some(bound)), Ordering::Relaxed);
        let meets = meets_deadlines(system, TaskId::from(task), Some(bound));
        if meets && (expected.missed[task] || expected.overdue[task]) {
            return Err(format!("task {task} is late, but for the middle tier"));
        }
    }
    Ok(())
}

/// Number of systems for which the middle tier has bounds.
static ABSTRACTED: AtomicUsize = AtomicUsize::new(0);

/// Number of bounds that are the exact values.
static REACHED: AtomicUsize = AtomicUsize::new(0);

fn compare_periodic(seed: u64) -> Option<Result<(), String>> {
    let system = systems::periodic::periodic(&mut systems::Dice::new(seed));
    compare_system(seed, &system, &[], &measured(seed, &system), 1)
}

#[test]
fn the_middle_tier_is_never_below_brute_force() {
    all_agree(first(), cases(), 3, compare_periodic);
    let (abstracted, reached) =
        (ABSTRACTED.load(Ordering::Relaxed), REACHED.load(Ordering::Relaxed));
    eprintln!("{abstracted} systems have bounds, {reached} of which are reached");
    assert!(abstracted as u64 >= cases() / 5, "bounds are compared");
}

/// Checks that an exploration with known bounds ends as soon as a job takes as long, with equal results.
fn knowing_bounds(
    seed: u64,
    system: &TimedSystem,
    measured: &[usize],
    longest: &[Option<u32>],
) -> Result<(), String> {
    let known = |task: usize| longest[task].filter(|&number| number < CAP);
    let tasks: Vec<usize> = measured.iter().copied().filter(|&ty| known(ty).is_some()).collect();
    let response = tasks.iter().map(|&task| ResponseTime {
        task: TaskId::from(task),
        limit: None,
        most: known(task),
    });
    let watch = Watch { response: response.collect(), ..Watch::default() };
    let found = explore(system, &watch, limits(seed), &Cancel::default());
    for (&task, response) in tasks.iter().zip(&found.response) {
        let bound = response.as_ref().map(|measurement| measurement.bound);
        if bound != known(task).map(Bound::Finite) {
            return Err(format!("response of {task}, known to be {:?}, is {bound:?}", known(task)));
        }
    }
    Ok(())
}

/// Checks that depth-first searches in all orders, if they are complete, find everything.
fn chased(seed: u64, brute: &Brute, expected: &Results) -> Result<(), String> {
    let all: Vec<usize> = (0..brute.system.tasks.len()).collect();
    let watch = Watch {
        schedulable: all.iter().map(|&task| TaskId::from(task)).collect(),
        overdue: all.iter().map(|&task| TaskId::from(task)).collect(),
        ..Watch::default()
    };
    for number in 0..5 {
        let cancel = Cancel::default();
        let found = search_once(brute.system, &watch, (number, 1_000_000), limits(seed), &cancel);
        if found.stopped.is_some() {
            return Err(format!("search {number} gave up"));
        }
        let shows = |found: &Run, pick: fn(&Results) -> &Vec<bool>, task: usize| {
            let last = brute.replay(&found.steps, found.end);
            last.map(|replay| pick(&replay)[task])
                .map_err(|why| format!("search {number}: {why}: {found:?}"))
        };
        let lists = [
            (&found.missed, (|results| &results.missed) as fn(&Results) -> &Vec<bool>),
            (&found.overdue, |results| &results.overdue),
        ];
        for (found_in, pick) in lists {
            for (task, found) in found_in.iter().enumerate() {
                // A search with longest times is not complete.
                let complete = number % 3 != 2;
                let wrong = match found {
                    Some(check) => !shows(check, pick, task)?,
                    None => complete && pick(expected)[task],
                };
                if wrong {
                    return Err(format!("search {number}: task {task}, found {found:?}"));
                }
            }
        }
    }
    Ok(())
}

fn bound(
    what: &str,
    i: usize,
    expected: Option<u32>,
    found: &Option<Measured>,
    replay: impl Fn(&Run) -> Result<Option<u32>, String>,
) -> Result<(), String> {
    let value = found.as_ref().map(|measurement| match measurement.bound {
        Bound::Unbounded => CAP,
        Bound::Finite(value) => value.min(CAP),
    });
    if value != expected {
        return Err(format!("{what} {i}: brute {expected:?}, found {value:?}"));
    }
    let Some(found) = found else {
        return Ok(());
    };
    let longest = &found.longest;
    let reached = replay(longest)?;
    match found.bound {
        Bound::Finite(value) if reached != Some(value.min(CAP)) => {
            Err(format!("{what} {i} is {value}, its run reaches {reached:?}: {longest:?}"))
        }
        _ => Ok(()),
    }
}

/// Checks that a run that exceeds a limit does so at its end, and no run does so earlier (`first`: earliest
/// time of each age). There must be such a run if and only if the limit can be exceeded.
fn excess(
    what: &str,
    i: usize,
    limit: Option<u32>,
    first: &[u64],
    found: &Option<Measured>,
    replay: impl Fn(&Run) -> Result<Option<u32>, String>,
) -> Result<(), String> {
    let expected = limit.and_then(|limit| first.get(limit as usize + 1));
    let run = found.as_ref().and_then(|measurement| measurement.excess.as_ref());
    let (Some(limit), Some(run)) = (limit, run) else {
        // Brute force knows nothing beyond the cap.
        let unknown = limit == Some(CAP) && expected.is_none();
        return if expected.is_some() == run.is_some() || unknown {
            Ok(())
        } else {
            Err(format!(
                "{what} {i}, limit {limit:?}: brute exceeds it at {expected:?}, found {run:?}"
            ))
        };
    };
    let reached = replay(run)?;
    let unbounded = found.as_ref().is_some_and(|measurement| measurement.bound == Bound::Unbounded);
    let as_early =
        expected.is_none_or(|&it_ends| run.end == it_ends || (unbounded && run.end > it_ends));
    if reached <= Some(limit).min(Some(CAP - 1)) || !as_early {
        return Err(format!(
            "{what} {i}, limit {limit}: brute exceeds it at {expected:?}, this run reaches {reached:?} \
             at {}: {:?}",
            run.end, run
        ));
    }
    Ok(())
}

/// Returns the number of systems that are compared with brute force.
fn cases() -> u64 {
    dotgen_loaders::times(40)
}

/// Returns the first seed, which the environment can set to repeat a system.
fn first() -> u64 {
    let given = std::env::var("DOTGEN_TIMING_SEED").ok();
    given.and_then(|variable| variable.parse().ok()).unwrap_or(0)
}

/// Compares systems from seed `first` on; at least one in `share` must be small enough for brute force.
fn all_agree(
    first: u64,
    cases: u64,
    share: u64,
    compare: impl Fn(u64) -> Option<Result<(), String>>,
) {
    let mut compared = 0;
    for seed in first..first + cases {
        match compare(seed) {
            Some(Ok(())) => compared += 1,
            Some(Err(why)) => panic!("{why}"),
            None => {}
        }
    }
    assert!(compared * share >= cases, "only {compared} of {cases} systems were small enough");
}

/// Returns all tasks, or only periodic ones: some reductions apply only if no response time of an aperiodic
/// task is measured.
fn measured(seed: u64, system: &TimedSystem) -> Vec<usize> {
    (0..system.tasks.len())
        .filter(|&t| seed.is_multiple_of(2) || system.tasks[TaskId::from(t)].period.is_some())
        .collect()
}

#[test]
fn explorer_agrees_with_brute_force() {
    all_agree(first(), cases(), 2, compare);
}

fn compare_competing(seed: u64) -> Option<Result<(), String>> {
    let system = systems::competing(&mut systems::Dice::new(seed));
    compare_system(seed, &system, &[], &measured(seed, &system), 1)
}

#[test]
fn codels_that_need_no_core_keep_jobs_on_the_only_one_waiting() {
    // A rare case as well.
    all_agree(333_659, 1, 1, compare);
}

#[test]
fn explorer_agrees_when_tasks_compete() {
    all_agree(first(), cases(), 3, compare_competing);
}

#[test]
fn a_tick_that_waits_for_the_start_up_of_its_task_keeps_others_waiting() {
    // A rare case: one of some ten thousand systems.
    all_agree(77671, 1, 1, compare_competing);
}

#[test]
fn explorer_agrees_on_polling_loops() {
    all_agree(0, cases() / 8, 4, |seed| {
        let system = systems::polling(&mut systems::Dice::new(seed));
        // The job of the polling task has no end, and measuring its response time would rule out reductions.
        let periodic: Vec<usize> = (1..system.tasks.len()).collect();
        compare_system(seed, &system, &[], &periodic, 1)
    });
}

#[test]
fn explorer_agrees_on_any_requests() {
    all_agree(first(), cases(), 4, |seed| {
        let system = systems::requests::requests(&mut systems::Dice::new(seed));
        compare_system(seed, &system, &[], &measured(seed, &system), 1)
    });
}

/// Compares predicates, deadlocks and refused requests.
fn compare_reachable(seed: u64) -> Option<Result<(), String>> {
    let (system, goals) = systems::aperiodic(&mut systems::Dice::new(seed));
    let brute = Brute { system: &system, within: &[], reach: &goals };
    let expected = brute.explore(30_000)?;
    let refused =
        (system.services.keys()).filter(|&service| expected.refused[usize::from(service)]);
    let refused: Vec<_> = refused.collect();
    let watch = Watch { reach: goals.clone(), deadlock: true, ..Watch::default() };
    let check = || -> Result<(), String> {
        let found = explore(&system, &watch, limits(seed), &Cancel::default());
        let answered = found.stopped == Some(Stop::Answered);
        if found.stopped.is_some() && !answered {
            return Err("gave up".to_owned());
        }
        let reached: Vec<bool> = found.reached.iter().map(Option::is_some).collect();
        let deadlock = found.deadlock.is_some();
        // After all questions are answered, the exploration stops.
        if (&reached, deadlock) != (&expected.reached, expected.deadlock)
            || !answered && found.refused != refused
        {
            return Err(format!("brute {expected:?}, found {found:?}"));
        }
        for (i, run) in found.reached.iter().enumerate() {
            if let Some(run) = run
                && !brute.replay(&run.steps, run.end)?.reached[i]
            {
                return Err(format!("run to {i} shows nothing: {run:?}"));
            }
        }
        Ok(())
    };
    Some(check().map_err(|why| format!("seed {seed}: {why}\n{system:#?}\n{goals:#?}")))
}

#[test]
fn explorer_agrees_without_periods() {
    all_agree(first(), cases() / 4, 3, compare_reachable);
}
