//! Intermediate reports: answers as they are found.

use std::sync::Mutex;

use dotgen_timing::explore::Kind;
use dotgen_timing::verify::{Interrupt, verify_with_reports};

use super::*;

/// A robot, and an independent lamp that analysis answers; the checks of the robot come first.
const LAMP: &str = r#"
component lamp {
  version "1"; lang "c";
  ids { long light; };
  task blink { period 8 ms; codel <start> toggle(inout light) yield pause::start wcet 1 ms; };
};
"#;

/// Clients that may send any request at any time are explored in stages.
const ALL: &str =
    "client k { delay [0, *] ms; send sensor.record; delay [0, *] ms; send sensor.reset; }
  check response sensor.acquire <= 2 ms; check schedulable *; check no-overdue *; check response *;
  check within sensor.record.run => sensor.record.void <= 5 ms; check always not sensor.record.stop;
  check leadsto sensor.record.run => sensor.record.void; check eventually control.move;
  check response lamp.blink; check schedulable lamp.blink;";

/// Returns the intermediate reports of a system with a lamp, and the final report.
fn told(items: &str, options: &Options, cancel: &Cancel) -> (Vec<Report>, Report) {
    let unit = load(&format!("{ROBOT}{LAMP}"));
    let input = SystemInput { specs: vec![&unit.spec] };
    let parsed = parse(&format!("scenario robot {{ {items} }}"));
    assert_eq!(parsed.errors, []);
    let told = Mutex::new(Vec::new());
    let tell = |report: &Report| told.lock().unwrap().push(report.clone());
    let report = verify_with_reports(&input, &parsed.scenario, options, cancel, &tell);
    (told.into_inner().unwrap(), report)
}

/// Returns an answer with all its parts.
fn whole(report: &CheckReport) -> String {
    serde_json::to_string(report).unwrap()
}

#[test]
fn an_answer_that_was_told_is_final_and_the_same_as_without_telling() {
    let mut few = published();
    few.limits.states = 50;
    for options in [published(), few] {
        let (told, last) = told(ALL, &options, &Cancel::default());
        let untold = {
            let unit = load(&format!("{ROBOT}{LAMP}"));
            let input = SystemInput { specs: vec![&unit.spec] };
            let scenario = parse(&format!("scenario robot {{ {ALL} }}")).scenario;
            verify(&input, &scenario, &options, &Cancel::default())
        };
        let without_time = |report: &Report| Report { seconds: 0.0, ..report.clone() };
        assert_eq!(
            serde_json::to_string(&without_time(&last)).unwrap(),
            serde_json::to_string(&without_time(&untold)).unwrap()
        );
        assert_eq!(last.answered(), last.checks.len());
        let mut answered = 0;
        for (i, now) in told.iter().enumerate() {
            assert_eq!(now.checks.len(), last.checks.len());
            assert_eq!(now.assumptions, last.assumptions);
            // Each report has more answers; the first may have none.
            assert!(now.answered() > answered || i == 0, "told for nothing");
            answered = now.answered();
            for (check, last) in now.checks.iter().zip(&last.checks) {
                match check.verdict {
                    Verdict::Open => assert_eq!(
                        (&check.name, check.kind, &check.of, check.bound),
                        (&last.name, last.kind, &last.of, last.bound)
                    ),
                    _ => assert_eq!(whole(check), whole(last)),
                }
            }
        }
        assert_eq!(answered, last.checks.len(), "the last answers are told as well");
        assert!(told.len() > 3, "told {} times", told.len());
    }
}

#[test]
fn what_takes_little_is_answered_first_whatever_it_belongs_to() {
    let (told, _) = told(ALL, &published(), &Cancel::default());
    let mut known = vec![false; told[0].checks.len()];
    let mut new = |report: &Report| -> Vec<String> {
        let all = report.checks.iter().zip(&mut known);
        let new = all.filter(|(report, known)| report.verdict != Verdict::Open && !**known);
        new.map(|(report, known)| {
            *known = true;
            format!("{} {}", report.kind, report.of)
        })
        .collect()
    };
    insta::assert_debug_snapshot!(told.iter().map(&mut new).collect::<Vec<_>>());
}

#[test]
fn nothing_is_told_to_those_who_do_not_want_it_any_more() {
    let unit = load(ROBOT);
    let input = SystemInput { specs: vec![&unit.spec] };
    let scenario = parse("scenario x { check response *; check schedulable *; check deadlock; }");
    let (times, cancel) = (Mutex::new(0), Cancel::default());
    let tell = |_: &Report| {
        *times.lock().unwrap() += 1;
        cancel.abandon();
    };
    let options = published();
    verify_with_reports(&input, &scenario.scenario, &options, &cancel, &tell);
    assert_eq!(times.into_inner().unwrap(), 1);
}

#[test]
fn what_was_interrupted_says_so_and_the_rest_stands() {
    let interrupt = Interrupt::default();
    let cancel = Cancel::interrupted_by(&interrupt);
    interrupt.raise();
    let (_, report) = told(ALL, &published(), &cancel);
    let answer = |check, of| {
        let mut all = report.checks.iter();
        all.find(|report| report.kind.word() == check && report.of == of).unwrap()
    };
    assert_eq!(answer("schedulable", "lamp.blink").verdict, Verdict::Proved);
    let open = answer("leadsto", "sensor.record.run => sensor.record.void");
    assert_eq!(open.verdict, Verdict::Unknown);
    assert_eq!(open.gave_up.unwrap().reason, Stop::Interrupted);
    assert!(open.note.as_deref().unwrap().starts_with("interrupted at "));
}

#[test]
fn a_run_that_there_is_no_time_for_is_left_out() {
    // This is seen before the first poll of the clock, and then it is too late.
    let check = "check reachable control.move.idle; check always not control.move.idle;";
    let (_, report) = told(check, &published(), &Cancel::default());
    assert!(report.checks.iter().all(|check| check.note.is_none()));
    let cancel = Cancel::default();
    cancel.limit(Duration::ZERO);
    let (_, report) = told(check, &published(), &cancel);
    let [reachable, always] = &report.checks[..] else {
        panic!("{}", checks_in_words(&report));
    };
    assert_eq!(reachable.verdict, Verdict::Proved);
    assert_eq!(always.verdict, Verdict::Refuted);
    for report in [reachable, always] {
        let note = report.note.as_deref().unwrap_or_default();
        assert!(note.starts_with("the run that shows it is left out"), "{note}");
    }
}

#[test]
fn what_is_seen_in_an_exploration_is_told_while_it_goes_on() {
    let items = "client k { repeat * { delay [0, *] ms; choice { send sensor.record; } or { send sensor.reset; } } }
      check within control.move => control.move.idle; check reachable sensor.record.stop;";
    let mut some = published();
    some.limits.states = 20_000;
    let (told, last) = told(items, &some, &Cancel::default());
    let verdicts =
        |report: &Report| report.checks.iter().map(|check| check.verdict).collect::<Vec<_>>();
    let all: Vec<_> = told.iter().map(verdicts).collect();
    let expected = [
        [Verdict::Open, Verdict::Open],
        [Verdict::Open, Verdict::Proved],
        [Verdict::Unknown, Verdict::Proved],
    ];
    assert_eq!(all, expected);
    assert!(!last.checks[1].witness.is_empty());
    assert_eq!(whole(&told[1].checks[1]), whole(&last.checks[1]));
}

#[test]
fn what_was_caught_beside_an_exploration_is_told_while_it_goes_on() {
    let (unit, text) = beside::too_short_a_wait(5);
    let input = SystemInput { specs: vec![&unit.spec] };
    let holds = "check always not (f.claim1.cs and f.claim1.void); check always";
    let text = text.replace("check always", holds);
    let parsed = parse(&text);
    assert_eq!(parsed.errors, []);
    let mut some = published();
    some.limits.states = 150_000;
    some.limits.without = [Kind::Invariants].into_iter().collect();
    let told = Mutex::new(Vec::new());
    let tell = |report: &Report| told.lock().unwrap().push(report.clone());
    let cancel = Cancel::default();
    let last = verify_with_reports(&input, &parsed.scenario, &some, &cancel, &tell);
    let verdicts =
        |report: &Report| report.checks.iter().map(|check| check.verdict).collect::<Vec<_>>();
    let told = told.into_inner().unwrap();
    let all: Vec<_> = told.iter().map(verdicts).collect();
    let expected = [
        [Verdict::Open, Verdict::Open],
        [Verdict::Open, Verdict::Refuted],
        [Verdict::Unknown, Verdict::Refuted],
    ];
    assert_eq!(all, expected);
    // Reported long before the end, and the counterexample is nevertheless the shortest one.
    assert!(2 * told[1].states < last.states, "{} of {}", told[1].states, last.states);
    assert_eq!(last.checks[1].counterexample.last().unwrap().time, 2.0);
}
