//! Checks that invariants answer.

use dotgen_timing::explore::Kind;
use dotgen_timing::report::{CheckReport, Layer, Soundness, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::scenario::load;

/// Returns the answers of a scenario about components whose two tasks share a datum. Nothing leads to
/// the state `stop` of `t`.
fn answers(components: usize, scenario: &str, options: &Options) -> Vec<CheckReport> {
    let units: Vec<_> = (0..components)
        .map(|number| {
            load(&format!(
                "component c{number} {{ version \"1\"; lang \"c\"; ids {{ long a; long b; }};
                   task t {{ period 10 ms;
                     codel <start> x(inout a) yield pause::start wcet 3 ms;
                     codel <stop> d(inout a) yield ether wcet 1 ms; }};
                   task u {{ period {} ms;
                     codel <start> y(inout a) yield then wcet 2 ms;
                     codel <then> z(inout b) yield pause::start wcet 1 ms; }}; }};",
                7 + number
            ))
        })
        .collect();
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    let text = format!("scenario s {{ unit 1 ms; {scenario} }}");
    let parsed = parse(&text);
    assert_eq!(parsed.errors, []);
    verify(&input, &parsed.scenario, options, &Cancel::default()).checks
}

#[test]
fn codels_with_common_data_are_never_executed_together() {
    let checks: String = (0..12)
        .map(|c| format!("check always not (c{c}.t.start.exec and c{c}.u.start.exec);"))
        .collect();
    // One core for all components, so that they are one system.
    let checks = answers(12, &format!("cores 1; policy any; {checks}"), &Options::default());
    assert_eq!(checks.len(), 12);
    for check in &checks {
        assert_eq!(check.verdict, Verdict::Proved, "{check:?}");
        assert_eq!(check.by, Some(Layer::Invariants), "{check:?}");
        assert_eq!(check.soundness, Soundness::Exact);
    }
}

#[test]
fn no_more_tasks_execute_than_there_are_cores() {
    let three = "c0.t.start and c1.t.start and c1.u.start";
    let text = |cores: usize| format!("cores {cores}; policy fifo; check always not ({three});");
    let two = answers(2, &text(2), &Options::default());
    assert_eq!((two[0].verdict, two[0].by), (Verdict::Proved, Some(Layer::Invariants)));
    let three = answers(2, &text(3), &Options::default());
    assert_eq!((three[0].verdict, three[0].by), (Verdict::Refuted, None));
}

#[test]
fn a_proof_about_what_never_happens_is_left_to_the_exploration() {
    let checks = answers(
        1,
        "check always not (c0.t.stop.exec and c0.u.start.exec); check reachable c0.t.start.exec and c0.u.start.exec;",
        &Options::default(),
    );
    assert_eq!((checks[0].verdict, checks[0].by), (Verdict::Vacuous, None));
    assert_eq!((checks[1].verdict, checks[1].by), (Verdict::Refuted, Some(Layer::Invariants)));
}

#[test]
fn what_does_not_exclude_each_other_is_explored() {
    let scenario = "check always not (c0.t.start.exec and c0.u.then.exec);";
    let checks = answers(1, scenario, &Options::default());
    assert_eq!((checks[0].verdict, checks[0].by), (Verdict::Refuted, None));
    let mut options = Options::default();
    options.limits.without = [Kind::Invariants].into_iter().collect();
    let scenario = "check always not (c0.t.start.exec and c0.u.start.exec);";
    let checks = answers(1, scenario, &options);
    assert_eq!((checks[0].verdict, checks[0].by), (Verdict::Proved, None));
}

/// An activity does not wait for codels of an activity that interrupts it; the other one waits for its
/// codels.
#[test]
fn a_wait_in_one_direction_excludes_nothing() {
    let unit = load(
        "component c { version \"1\"; lang \"c\"; ids { long a; };
           task t { period 10 ms; };
           task u { period 10 ms; };
           activity slow() { task t; codel <start> x(inout a) yield ether wcet 30 ms; };
           activity first() { task u; interrupts slow;
             codel <start> y(inout a) yield ether wcet 30 ms; }; };",
    );
    let text = "scenario s { unit 1 ms; durations fixed;
        client k { send c.first; delay 20 ms; send c.slow; await ended; }
        check always not (c.slow.start.exec and c.first.start.exec); }";
    let parsed = parse(text);
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &parsed.scenario, &Options::default(), &Cancel::default());
    let check = &report.checks[0];
    assert_eq!((check.verdict, check.by), (Verdict::Refuted, None), "{check:?}");
}
