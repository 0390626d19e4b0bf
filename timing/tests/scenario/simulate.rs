//! Runs of a report that a user continues with other steps.

use dotgen_timing::explore::MomentKind;
use dotgen_timing::report::Event;
use dotgen_timing::verify::{Choice, Simulation};

use super::*;

const SCENARIO: &str = "scenario robot { cores 1;
  client k { delay [0, 9] ms; send sensor.record; await ended; }
  check response sensor.acquire <= 7 ms; check reachable sensor.record.run; }";

/// Calls a function with the checks of the robot that have a run.
fn with_runs(each: impl Fn(&SystemInput, &Report, &CheckReport)) {
    let unit = load(ROBOT);
    let input = SystemInput { specs: vec![&unit.spec] };
    let parsed = parse(SCENARIO);
    assert_eq!(parsed.errors, []);
    for options in [Options::default(), published()] {
        let report = verify(&input, &parsed.scenario, &options, &Cancel::default());
        let runs: Vec<_> = report.checks.iter().filter(|check| check.kept.is_some()).collect();
        assert_eq!(runs.len(), 2);
        for run in &runs {
            each(&input, &report, run);
        }
    }
}

fn told(report: &CheckReport, events: usize) -> Vec<(f64, String)> {
    let events = report.run().iter().take(events);
    events.map(|event| (event.time, event.what.clone())).collect()
}

/// Returns true if choices without events, and then one more, lead to an event.
fn leads_to(simulate: &dyn Fn(&[usize]) -> Simulation, take: &[usize], next: &Event) -> bool {
    let simulation = simulate(take);
    (0..).zip(&simulation.choices).any(|(choice, offered)| match offered {
        Choice::Step(thread, what) => {
            (next.time, &next.thread, &next.what) == (simulation.end, thread, what)
        }
        Choice::Wait(_) => next.time > simulation.end,
        Choice::Silent(_) => {
            take.len() < 6 && leads_to(simulate, &[take, &[choice]].concat(), next)
        }
    })
}

#[test]
fn at_each_event_the_step_of_the_run_itself_can_be_chosen() {
    with_runs(|input, report, check| {
        let run = check.kept.as_ref().unwrap();
        assert_eq!(run.impossible_step(), None);
        for after in 0..check.run().len() {
            let simulation = run.simulate(input, report.unit, after, &[]);
            let events: Vec<_> =
                simulation.events.iter().map(|event| (event.time, event.what.clone())).collect();
            // The limit that is exceeded is an event, but no step.
            let excess = check.run()[after].kind == MomentKind::Excess;
            assert!(events.len() > after || excess);
            // Committed steps without a choice follow at once.
            let shared = events.len().min(check.run().len());
            assert_eq!(told(check, shared), events[..shared]);
            if let Some(next) = check.run().get(events.len()) {
                let simulate = |take: &[usize]| run.simulate(input, report.unit, after, take);
                assert!(leads_to(&simulate, &[], next), "{next:?}\n{:?}", simulation.choices);
            }
        }
    });
}

#[test]
fn every_choice_goes_on_and_is_the_event_that_was_offered() {
    with_runs(|input, report, check| {
        let run = check.kept.as_ref().unwrap();
        let mut take = Vec::new();
        for round in 0..60 {
            let before = run.simulate(input, report.unit, 0, &take);
            assert_eq!(before.taken.len(), take.len());
            assert!(before.taken.is_sorted());
            let choice = round * 7 % before.choices.len();
            take.push(choice);
            let after = run.simulate(input, report.unit, 0, &take);
            match &before.choices[choice] {
                Choice::Step(_, what) => {
                    assert_eq!(after.events[before.events.len()].what, *what);
                }
                Choice::Wait(time) => {
                    assert!(after.end > before.end && after.end - before.end <= *time + before.end);
                }
                Choice::Silent(_) => {}
            }
        }
        // A number beyond the choices ends the continuation.
        take.truncate(5);
        take.extend([usize::MAX, 0]);
        let simulation = run.simulate(input, report.unit, 0, &take);
        assert_eq!(simulation.taken.len(), 5);
    });
}
