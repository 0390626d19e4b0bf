//! Vacuous answers: checks that hold only because nothing happens are marked.

use dotgen_timing::report::{CheckReport, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::scenario::load;

/// `poll` never releases its core.
const BUSY: &str = "component c {
  version \"1\"; lang \"c\";
  task poll { codel<start> p() yield start, wait wcet 1 ms; codel<wait> w() yield start wcet 1 ms; };
  task t { period 10 ms; codel<start> a() yield b wcet 1 ms; codel<b> b() yield pause::b wcet 1 ms; };
  task u { period 20 ms; codel<start> d() yield pause::start wcet 1 ms; };
};";

fn checks(items: &str) -> Vec<CheckReport> {
    let unit = load(BUSY);
    let parsed = parse(&format!("scenario s {{ unit 1 ms; durations fixed; {items} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let (options, cancel) = (Options::default(), Cancel::default());
    let report = verify(&input, &parsed.scenario, &options, &cancel);
    assert!(!report.has_errors(), "{:?}", report.diagnostics);
    report.checks
}

/// On one core neither `t` nor `u` ever has a cycle; two are enough.
#[test]
fn what_holds_of_tasks_that_are_never_released_is_vacuous() {
    let asked =
        "check schedulable c.t; check no-overdue c.t; check response c.t; check schedulable c.u;
        check always not (c.t.b.exec and c.u.start.exec); check within c.t.b.exec => c.u.running;
        check leadsto c.t.b.exec => c.u.running;";
    let of_t = "`c.t` is never released: the start-up of `c.t` never completes, because `c.poll` can hold a core for ever";
    let first = "the first predicate never becomes true";
    let reasons = [
        of_t,
        of_t,
        of_t,
        "`c.u` is never released: the start-up of `c.t` never completes, because `c.poll` can hold a core for ever",
        "`c.t.b.exec` never becomes true",
        first,
        first,
    ];
    for policy in ["fifo", "any"] {
        let found = checks(&format!("cores 1; policy {policy}; {asked}"));
        for (check, reason) in found.iter().zip(reasons) {
            let said = (check.verdict, check.note.as_deref());
            assert_eq!(said, (Verdict::Vacuous, Some(reason)), "{policy}");
        }
    }
    let found = checks(&format!("cores 2; policy fifo; {asked}"));
    assert!(found.iter().all(|check| check.verdict != Verdict::Vacuous), "{found:?}");
}

/// A claim that something never happens is not vacuous; nor is a check that holds for another reason.
#[test]
fn what_claims_that_something_never_happens_is_not_vacuous() {
    let found = checks(
        "cores 1; policy fifo; check always not c.t.b.exec; check always (c.u.idle or c.u.running);
         check always not (c.t.b.exec or c.u.running); check always not (c.poll.wait.exec and c.poll.start.exec);",
    );
    assert!(found.iter().all(|check| check.verdict == Verdict::Proved));
}

/// Also if only analysis has a bound: `t` would go first, but is started only after `low`, which `high` keeps
/// from the core for ever.
#[test]
fn a_bound_of_analysis_proves_nothing_of_a_task_without_jobs() {
    let unit = load(
        "component c { version \"1\"; lang \"c\";
           task low { period 10 ms; priority 9; codel<start> l() yield pause::start wcet 1 ms; };
           task t { period 10 ms; priority 1; codel<start> a() yield pause::start wcet 1 ms; };
         };
         component d { version \"1\"; lang \"c\";
           task high { priority 2; codel<start> p() yield wait wcet 1 ms; codel<wait> w() yield start wcet 1 ms; };
         };",
    );
    let text = "scenario s { unit 1 ms; durations fixed; cores 1; policy priority; check schedulable c.t; }";
    let input = SystemInput { specs: vec![&unit.spec] };
    let parsed = parse(text);
    let report = verify(&input, &parsed.scenario, &Options::default(), &Cancel::default());
    let check = &report.checks[0];
    assert_eq!(check.verdict, Verdict::Vacuous, "{check:?}");
    let json = serde_json::to_value(check).expect("it has a JSON form");
    assert_eq!(json["verdict"], "vacuous");
    let reason = "`c.t` is never released: the start-up of `c.low` never completes";
    assert_eq!(json["note"], reason);
}
