//! The table of patterns of the manual: for each row a check that holds and one that fails.

use super::*;

#[test]
fn each_pattern_has_a_check_that_holds_and_one_that_fails() {
    let unit = load(include_str!("patterns.gen"));
    let parsed = parse(include_str!("patterns.scn"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &parsed.scenario, &Options::default(), &Cancel::default());
    // An interval of time is two checks of one name, of which one fails.
    let mut verdicts: BTreeMap<&str, Vec<Verdict>> = BTreeMap::new();
    for check in &report.checks {
        let name = check.name.as_deref().expect("each check has a name");
        verdicts.entry(name).or_default().push(check.verdict);
        let run = check.counterexample.len();
        assert_eq!(
            run > 0,
            check.verdict == Verdict::Refuted && name != "fails_reachable",
            "{name}: {run}"
        );
    }
    for (name, verdicts) in verdicts {
        let holds = verdicts.iter().all(|verdict| *verdict == Verdict::Proved);
        let fails = verdicts.contains(&Verdict::Refuted);
        assert_eq!(
            (holds, fails),
            (name.starts_with("holds_"), name.starts_with("fails_")),
            "{name}"
        );
    }
}

/// With a tick at time 0, every search knows that nothing can come before it.
#[test]
fn random_search_begins_with_the_monitors_of_time_0() {
    let unit = load(
        r"
component c { task t0 { period 16 ms; codel<start> a() yield pause::start wcet 2 ms; }; };
component d {
  ids { long f0; };
  task t0 {
    period 8 ms;
    delay 3 ms;
    codel<start> b(inout f0) yield pause::x wcet 2 ms;
    codel<x> e(in f0) yield y wcet 2 ms;
    codel<y> f(in f0) yield pause::x wcet 0 ms;
  };
  task t1 { period 4 ms; codel<start> g() yield pause::start wcet 2 ms; };
};
",
    );
    let parsed = parse(
        "scenario s { cores free; policy any; durations interval;
           check order: c.t0.tick precedes d.t0.start.exec;
           check between d.t0.x.exec and d.t1.idle always d.t0.x.exec;
           check after c.t0.running until d.t1.running always c.t0.start.exec; }",
    );
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &parsed.scenario, &Options::default(), &Cancel::default());
    let verdicts: Vec<Verdict> = report.checks.iter().map(|check| check.verdict).collect();
    assert_eq!(verdicts, [Verdict::Proved, Verdict::Refuted, Verdict::Refuted]);
}

#[test]
fn an_interval_that_never_ends_proves_nothing() {
    let unit = load(
        r"
component c {
  ids { long f; };
  task t {
    period 8 ms;
    codel<start> a() yield pause::start wcet 2 ms;
    codel<stop> b() yield ether wcet 2 ms;
  };
};
",
    );
    let parsed = parse(
        "scenario s {
           check between c.t.start.exec and c.t.idle never c.t.stop.exec;
           check between c.t.start.exec and c.t.stop.exec never c.t.idle;
           check between c.t.start.exec and c.t.stop.exec eventually c.t.idle;
           check after c.t.start.exec until c.t.stop.exec never c.t.stop; }",
    );
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &parsed.scenario, &Options::default(), &Cancel::default());
    let verdicts: Vec<_> =
        report.checks.iter().map(|check| (check.verdict, check.note.as_deref())).collect();
    let never = Some("`c.t.stop.exec` never becomes true");
    assert_eq!(
        verdicts,
        [
            (Verdict::Proved, None),
            (Verdict::Vacuous, never),
            (Verdict::Vacuous, never),
            (Verdict::Proved, None),
        ]
    );
}
