//! The explorer agrees with an independent brute-force interpreter on random small systems.

mod brute;
mod systems;

use std::sync::atomic::AtomicBool;

use brute::{Brute, CAP, Results};
use dotgen_timing::analytic::response_bounds;
use dotgen_timing::explore::{Bound, Found, Limits, Watch, explore};
use dotgen_timing::property::Predicate;
use dotgen_timing::system::TimedSystem;

/// Compares everything on the system of one seed; `None` if it was too large for brute force.
fn compare(seed: u64) -> Option<Result<(), String>> {
    let (system, within) = systems::random(&mut systems::Dice::new(seed));
    let all: Vec<usize> = (0..system.tasks.len()).collect();
    compare_system(seed, &system, &within, &all)
}

/// The same for a given system; only the response times of `measured` tasks are asked for.
fn compare_system(
    seed: u64,
    system: &TimedSystem,
    within: &[(Predicate, Predicate)],
    measured: &[usize],
) -> Option<Result<(), String>> {
    let brute = Brute { system, within };
    let expected = brute.explore(30_000)?;
    let all: Vec<usize> = (0..system.tasks.len()).collect();
    let watch = Watch {
        schedulable: all.clone(),
        overdue: all,
        response: measured.to_vec(),
        within: within.to_vec(),
        deadlock: true,
        ..Watch::default()
    };
    let found = explore(
        system,
        &watch,
        Limits {
            states: 400_000,
            bytes: 1 << 28,
        },
        &AtomicBool::new(false),
    );
    if found.stopped.is_some() {
        return Some(Err(format!(
            "seed {seed}: gave up; brute force has {} states: {expected:?}\n{system:#?}",
            expected.states
        )));
    }
    let check = || -> Result<(), String> {
        let replay = |it: &Found| {
            brute
                .replay(&it.run.steps, it.run.end)
                .map_err(|why| format!("{why}: {:?}", it.run))
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
            agree(
                "overdue",
                t,
                expected.overdue[t],
                found.overdue[t].is_some(),
            )?;
            for (list, pick) in [
                (
                    &found.missed,
                    (|it: &Results| &it.missed) as fn(&Results) -> &Vec<bool>,
                ),
                (&found.overdue, |it: &Results| &it.overdue),
            ] {
                if let Some(it) = &list[t]
                    && !pick(&replay(it)?)[t]
                {
                    return Err(format!("run of task {t} shows nothing: {:?}", it.run));
                }
            }
        }
        for (&t, response) in measured.iter().zip(&found.response) {
            bound("response", t, expected.response[t], response, |it| {
                Ok(replay(it)?.response[t])
            })?;
        }
        for i in 0..within.len() {
            bound("within", i, expected.within[i], &found.within[i], |it| {
                Ok(replay(it)?.within[i])
            })?;
        }
        let quick = response_bounds(system);
        for (&t, response) in measured.iter().zip(&found.response) {
            if let (Some(quick), Some((exact, _))) = (quick[t], response)
                && *exact > Bound::Finite(quick)
            {
                return Err(format!(
                    "response {t} is {exact:?}, the quick bound says {quick}"
                ));
            }
        }
        agree("deadlock", 0, expected.deadlock, found.deadlock.is_some())?;
        if let Some(it) = &found.deadlock
            && !replay(it)?.deadlock
        {
            return Err("no deadlock at the end of the run".to_owned());
        }
        let refused: Vec<bool> = (0..system.services.len())
            .map(|it| found.refused.contains(&it))
            .collect();
        if refused != expected.refused {
            return Err(format!(
                "refused: brute {:?}, found {refused:?}",
                expected.refused
            ));
        }
        Ok(())
    };
    Some(check().map_err(|why| format!("seed {seed}: {why}\n{system:#?}\n{within:#?}")))
}

fn bound(
    what: &str,
    i: usize,
    expected: Option<u32>,
    found: &Option<(Bound, Found)>,
    replay: impl Fn(&Found) -> Result<Option<u32>, String>,
) -> Result<(), String> {
    let value = found.as_ref().map(|(bound, _)| match *bound {
        Bound::Unbounded => CAP,
        Bound::Finite(value) => value.min(CAP),
    });
    if value != expected {
        return Err(format!("{what} {i}: brute {expected:?}, found {value:?}"));
    }
    let Some((bound, it)) = found else {
        return Ok(());
    };
    let reached = replay(it)?;
    match *bound {
        Bound::Finite(value) if reached != Some(value.min(CAP)) => Err(format!(
            "{what} {i} is {value}, its run reaches {reached:?}: {:?}",
            it.run
        )),
        _ => Ok(()),
    }
}

/// Number of systems, more on demand.
fn cases() -> u64 {
    std::env::var("DOTGEN_TIMING_CASES")
        .ok()
        .and_then(|it| it.parse().ok())
        .unwrap_or(2000)
}

/// The first seed, to look at one system again.
fn first() -> u64 {
    let given = std::env::var("DOTGEN_TIMING_SEED").ok();
    given.and_then(|it| it.parse().ok()).unwrap_or(0)
}

#[test]
fn explorer_agrees_with_brute_force() {
    let mut compared = 0;
    let first = first();
    for seed in first..first + cases() {
        match compare(seed) {
            Some(Ok(())) => compared += 1,
            Some(Err(why)) => panic!("{why}"),
            None => {}
        }
    }
    assert!(
        compared * 2 > cases(),
        "only {compared} systems were small enough"
    );
}

#[test]
fn explorer_agrees_when_tasks_compete() {
    let mut compared = 0;
    let first = first();
    for seed in first..first + cases() {
        let system = systems::competing(&mut systems::Dice::new(seed));
        // Some reductions need that nobody asks how long an aperiodic job is.
        let all = 0..system.tasks.len();
        let measured: Vec<usize> = all
            .filter(|&t| seed % 2 == 0 || system.tasks[t].period.is_some())
            .collect();
        match compare_system(seed, &system, &[], &measured) {
            Some(Ok(())) => compared += 1,
            Some(Err(why)) => panic!("{why}"),
            None => {}
        }
    }
    assert!(
        compared * 3 > cases(),
        "only {compared} systems were small enough"
    );
}

#[test]
fn explorer_agrees_on_polling_loops() {
    let mut compared = 0;
    let cases = cases() / 20;
    for seed in 0..cases {
        let system = systems::polling(&mut systems::Dice::new(seed));
        // The job of the polling task has no end; asking for its length would forbid to reduce it.
        let periodic: Vec<usize> = (1..system.tasks.len()).collect();
        match compare_system(seed, &system, &[], &periodic) {
            Some(Ok(())) => compared += 1,
            Some(Err(why)) => panic!("{why}"),
            None => {}
        }
    }
    assert!(
        compared * 4 > cases,
        "only {compared} of {cases} systems were small enough"
    );
}
