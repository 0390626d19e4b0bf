//! Random walks that reach the bounds of schedule abstraction.

use std::fmt::Write;

use dotgen_timing::report::{Report, Soundness, Value, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use super::load;

/// Verifies ten components on one core, each with one task. The last one has this period, in milliseconds.
fn ten_tasks(period: u32) -> Report {
    let periods = [20, 24, 30, 40, 48, 60, 80, 120, 240];
    let tasks = periods.map(|period: u32| (period, (period * 3 / 40).clamp(1, 6)));
    let mut specification = String::new();
    for (number, (period, longest)) in tasks.into_iter().chain([(period, 1)]).enumerate() {
        let _ = write!(
            specification,
            "component c{number} {{ version \"1\"; lang \"c\";
               task t {{ period {period} ms;
                 codel<start> s{number}() yield pause::main wcet 0 ms;
                 codel<main> m{number}() yield pause::main wcet {longest} ms; }}; }};"
        );
    }
    let unit = load(&specification);
    let scenario =
        "scenario x { semantics servers; cores 1; policy edf; unit 1 ms; durations interval;
                    check schedulable *; check response *; }";
    let parsed = parse(scenario);
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    verify(&input, &parsed.scenario, &Options::default(), &Cancel::default())
}

#[test]
fn response_times_whose_bounds_are_reached_are_exact() {
    let report = ten_tasks(20);
    for check in &report.checks {
        assert_eq!(
            (check.verdict, check.soundness),
            (Verdict::Proved, Soundness::Exact),
            "{}",
            check.of
        );
    }
    let longest = report.checks.last().and_then(|check| check.value);
    assert!(matches!(longest, Some(Value::Time(time)) if time > 1.0), "{longest:?}");
}

#[test]
fn a_task_that_is_late_has_a_bound_and_so_have_the_others() {
    let report = ten_tasks(5);
    let (deadlines, responses) = report.checks.split_at(10);
    let late: Vec<&str> = (deadlines.iter())
        .filter(|check| check.verdict == Verdict::Refuted)
        .map(|check| &*check.of)
        .collect();
    assert_eq!(late, ["c9.t"]);
    assert!(deadlines.iter().all(|check| check.verdict != Verdict::Unknown));
    for check in responses {
        let expected = if check.of == "c9.t" { Verdict::Bounded } else { Verdict::Proved };
        assert_eq!(check.verdict, expected, "{}", check.of);
    }
    let of_late = responses.last().and_then(|check| check.value);
    assert!(matches!(of_late, Some(Value::Time(time)) if time >= 5.0), "{of_late:?}");
}

#[test]
fn a_rare_job_that_is_very_late_is_not_forgotten() {
    // It takes more periods than schedule abstraction follows a late job.
    let unit = load(
        "component c { version \"1\"; lang \"c\";
           task t { period 10 ms;
             codel<start> s() yield pause::main wcet 1 ms;
             codel<main> m() yield pause::main, pause::rare wcet 1 ms;
             codel<rare> r() yield pause::main wcet 700 ms; }; };",
    );
    for semantics in ["servers", "published"] {
        let scenario = format!(
            "scenario x {{ semantics {semantics}; cores 2; policy edf; unit 1 ms;
                           check schedulable *; check response c.t <= 10 ms; }}"
        );
        let parsed = parse(&scenario);
        assert_eq!(parsed.errors, []);
        let input = SystemInput { specs: vec![&unit.spec] };
        let report = verify(&input, &parsed.scenario, &Options::default(), &Cancel::default());
        for check in &report.checks {
            assert_eq!(check.verdict, Verdict::Refuted, "{semantics}: {}", check.of);
        }
    }
}

#[test]
fn a_walk_finds_a_deadline_that_is_missed_late() {
    // Until two requests meet after a second, hundreds of thousands of states come first.
    let mut specification = String::from(
        "component arm { version \"1\"; lang \"c\"; ids { long a; };
           exception oops;
           task move { period 10 ms; };
           activity go() { task move; codel <start> g(out a) yield ether wcet 6 ms; throw oops; };
           activity grasp() { task move; codel <start> h(out a) yield ether wcet 5 ms; throw oops; }; };",
    );
    for number in 0..6 {
        let _ = write!(
            specification,
            "component c{number} {{ version \"1\"; lang \"c\";
               task t {{ period {} ms;
                 codel<start> s{number}() yield pause::main wcet 1 ms;
                 codel<main> m{number}() yield pause::main, pause::other wcet 1 ms;
                 codel<other> o{number}() yield pause::main wcet 1 ms; }}; }};",
            10 + number
        );
    }
    let unit = load(&specification);
    let scenario =
        "scenario x { semantics servers; cores 2; policy fifo; unit 1 ms; durations interval;
                    client a { delay 1 s; send arm.go; send arm.grasp; }
                    check schedulable arm.move; }";
    let parsed = parse(scenario);
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let mut options = Options::default();
    options.limits.states = 200_000;
    let report = verify(&input, &parsed.scenario, &options, &Cancel::default());
    let check = &report.checks[0];
    assert_eq!(check.verdict, Verdict::Refuted);
    // The first deadline after the requests.
    assert_eq!(check.counterexample.last().map(|event| event.time), Some(1010.0));
}
