//! Checks of predicates in time on a small system, read back.

use dotgen_timing::verify::Options;

use crate::read_back::{Counts, compare_system};
use crate::systems::System;

const SPECIFICATION: &str = "
component c {
 version \"1\"; email \"a@b\"; lang \"c\";
 ids { long f0; };
 task t0 { period 4 ms; codel<start> a(inout f0) yield pause::x wcet 1 ms;
   codel<x> b(inout f0) yield pause::start, y wcet 2 ms;
   codel<y> d() yield pause::start wcet 1 ms; };
 activity s0() { task t0; codel<start> e(in f0) yield pause::stop wcet 1 ms;
   codel<stop> g() yield ether wcet 1 ms; interrupts s0; };
};
";

/// Returns the system with its checks.
pub(crate) fn system() -> System {
    let x = ["c.t0.x.exec", "c.t0.y.exec", "c.s0.start.exec"];
    let mut checks = String::new();
    for (i, p) in x.iter().enumerate() {
        for (j, q) in x.iter().enumerate().filter(|(j, _)| *j != i) {
            let r = x[(i + j) % x.len()];
            checks += &format!(
                " check within {p} => {q} then {r};
                 check within {p} => {q} then {r} then {p} <= 9 ms;
                 check absent {q} after {p} for {} ms; check {p} precedes {q};
                 check before {p} never {q}; check after {p} always {q};
                 check between {p} and {q} eventually {r}; check between {p} and {q} never {r};
                 check after {p} until {q} never {r}; check lasts {p} >= 1 ms;\n",
                1 + i + j
            );
        }
    }
    let scenario = format!(
        "scenario s {{ semantics servers; unit 1 ms; durations interval;
         client k {{ delay [1,3] ms; send c.s0; delay 2 ms; send c.s0; }}\n{checks}
         check deadlock; check reachable c.running; check always not c.idle; }}"
    );
    let system = System::of_texts(&[SPECIFICATION.to_owned()], &scenario);
    let system = system.expect("the specification has no error");
    let prepared = system.prepared(&Options::default());
    let errors: Vec<_> = prepared.report.diagnostics.iter().map(|d| &d.message).collect();
    assert!(!prepared.report.has_errors(), "{errors:?}");
    system
}

#[test]
fn patterns_and_sequences() {
    let system = system();
    let mut counts = Counts::default();
    compare_system(&system, "c", 4_000, &mut counts);
    eprintln!("{counts:?}");
    assert_eq!(counts.refused, 0, "{counts:?}");
    assert!(counts.equal > 50, "{counts:?}");
}

/// Loops within a turn.
const LOOPS: &str = "
component c {
 version \"1\"; email \"a@b\"; lang \"c\";
 ids { long f0; };
 task t0 { period 12 ms; codel<start> a(inout f0) yield x, y wcet 1 ms;
   codel<x> b(inout f0) yield y, x, pause::x wcet 1 ms;
   codel<y> d() yield x, pause::start wcet 1 ms; };
 activity s0() { task t0; codel<start> h(in f0) yield start, ether wcet 1 ms; };
};
";

/// A task whose turns never end, where the limit counts rounds.
const ROUNDS: &str = "
component c {
 version \"1\"; email \"a@b\"; lang \"c\";
 ids { long f0; };
 task t0 { period 12 ms; codel<start> a(inout f0) yield x wcet 1 ms;
   codel<x> b(inout f0) yield pause::x wcet 1 ms; };
 task t1 { codel<start> e(in f0) yield y wcet 1 ms;
   codel<y> f() yield y, z wcet 2 ms;
   codel<z> g(out f0) yield y wcet 1 ms; };
};
";

/// Returns systems with limits of loops, each with its limits.
pub(crate) fn looping() -> Vec<(&'static str, System)> {
    let in_turns =
        "client k { delay 10 ms; send c.s0; } check schedulable c.t0; check response c.t0;
        check never c.s0.start.exec and c.t0.x.exec;";
    let in_rounds = "check never c.t1.start.exec and c.t0.x.exec; check reachable c.t1.z.exec;";
    let all = [
        (LOOPS, "loop once c.t0; loop once c.s0;", in_turns),
        (LOOPS, "loop 2 c.t0; loop 3 c.s0;", in_turns),
        (ROUNDS, "loop once c.t1;", in_rounds),
        (ROUNDS, "loop 2 c.t1;", in_rounds),
    ];
    let systems = all.into_iter().map(|(text, limits, checks)| {
        let scenario = format!(
            "scenario s {{ semantics servers; unit 1 ms; durations fixed; {limits} {checks}
             check lasts c.t0.x.exec <= 1 ms; check deadlock; }}"
        );
        let system = System::of_texts(&[text.to_owned()], &scenario);
        (limits, system.expect("the specification has no error"))
    });
    systems.collect()
}

#[test]
fn loops_with_limits() {
    for (limits, system) in looping() {
        let prepared = system.prepared(&Options::default());
        let errors: Vec<_> = prepared.report.diagnostics.iter().map(|d| &d.message).collect();
        assert!(!prepared.report.has_errors(), "{errors:?}");
        let mut counts = Counts::default();
        compare_system(&system, limits, 20_000, &mut counts);
        eprintln!("{counts:?}");
        assert!(counts.equal > 2 && counts.refused == 0, "{limits}: {counts:?}");
    }
}
