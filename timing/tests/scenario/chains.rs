//! Checks of chains, and of sequences of responses, against values that were worked out by hand.

use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{Report, Value, Verdict};
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::scn::{format, parse};
use dotgen_timing::verify::{Cancel, Options, SystemInput, prepare, verify};

use super::load;

/// A sensor every 10 ms, and a filter every 20 ms with two paths of the data: at once, or through its own
/// data.
const TWO: &str = r#"
typedef long number;
component sensor {
  version "1"; lang "c";
  port out number raw;
  port out number other;
  task t {
    period 10 ms;
    codel <start> sense(port out raw) yield pause::start wcet 1 ms;
  };
};
component filter {
  version "1"; lang "c";
  ids { long kept; };
  port in number raw;
  port out number clean;
  task t {
    period 20 ms;
    codel <start> keep(port in raw, out kept) yield pass wcet 1 ms;
    codel <pass> pass(in kept, port out clean) yield pause::start wcet 1 ms;
  };
};
"#;

fn two(semantics: Preset, items: &str) -> Report {
    let unit = load(TWO);
    let parsed = parse(&std::format!("scenario two {{ {items} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let options = Options { semantics: Some(semantics), ..Options::default() };
    verify(&input, &parsed.scenario, &options, &Cancel::default())
}

fn values(report: &Report) -> Vec<(Verdict, Option<Value>)> {
    let checks = report.checks.iter();
    checks.map(|check| (check.verdict, check.value)).collect()
}

#[test]
fn reaction_and_age_are_those_worked_out_by_hand() {
    // The sensor writes at 11, 21, 31, …; the filter reads at 20, 40, … and writes at 22, 42, …. The datum
    // written at 21 comes out at 42. The datum that came out at 22 was written at 11, and is visible until
    // 42.
    let report = two(
        Preset::Servers,
        "durations fixed; check reaction sensor.raw -> filter.clean; check age sensor.raw -> filter.clean;
         check reaction sensor.raw -> filter.clean <= 20 ms; check age sensor.raw -> filter.raw;",
    );
    let time = |number| Some(Value::Time(number));
    assert_eq!(
        values(&report),
        [
            (Verdict::Proved, time(21.0)),
            (Verdict::Proved, time(31.0)),
            (Verdict::Refuted, time(21.0)),
            // Visible until the next write.
            (Verdict::Proved, time(10.0)),
        ]
    );
    let first = &report.checks[0];
    assert_eq!(first.kind, PropertyKind::Reaction);
    assert_eq!(first.of, "sensor.raw -> filter.clean");
    assert_eq!(first.note.as_deref(), Some("by filter.t.start → filter.t.pass"));
    let last = report.checks[2].counterexample.last();
    assert_eq!(last.map(|counterexample| counterexample.time), Some(42.0));
}

#[test]
fn an_input_that_nobody_writes_is_new_at_any_moment() {
    let items = "durations fixed; connect filter.raw to none;
         check reaction filter.raw -> filter.clean; check age filter.raw -> filter.clean;";
    // Reaction: from just after the filter has read at 20 until it writes at 42. Age: read at 20, and visible
    // until 42.
    let report = two(Preset::Servers, items);
    let time = |number| (Verdict::Proved, Some(Value::Time(number)));
    assert_eq!(values(&report), [time(22.0), time(22.0)]);
    // The published models begin at 0, and the timer with them.
    let report = two(Preset::Published, items);
    assert_eq!(values(&report), [time(22.0), time(22.0)]);
}

#[test]
fn shorter_durations_make_older_data() {
    // Written between 10 and 21; read at 20, or at 40 and written at 42 at the latest.
    let report = two(
        Preset::Servers,
        "check reaction sensor.raw -> filter.clean; check age sensor.raw -> filter.clean;",
    );
    let time = |number| (Verdict::Proved, Some(Value::Time(number)));
    // Written at 20 just after the filter has begun, until 42; or written at 10, come out at 20, visible
    // until 42.
    assert_eq!(values(&report), [time(22.0), time(32.0)]);
}

#[test]
fn what_cannot_be_followed_is_said() {
    let errors = |check: &str| -> Vec<&'static str> {
        let report = two(Preset::Servers, &std::format!("check {check};"));
        report.diagnostics.iter().map(|diagnostic| diagnostic.code).collect()
    };
    assert_eq!(errors("reaction sensor.other -> filter.clean"), ["scn-no-way"]);
    assert_eq!(errors("age filter.clean -> sensor.raw"), ["scn-no-way"]);
    assert_eq!(errors("reaction sensor.raw -> filter.clean via filter.t.start"), ["scn-no-way"]);
    assert_eq!(errors("reaction sensor.t -> filter.clean"), ["scn-wrong-kind"]);
    assert_eq!(
        errors("reaction sensor.raw -> filter.clean via filter.t, sensor.raw"),
        [] as [&str; 0]
    );
}

#[test]
fn chains_are_written_in_one_form() {
    let text = "scenario x{check age a.b->c.d via c.t.go,c.e<=5 ms;check within a=>b or c then d;}";
    let formatted = format(text).unwrap();
    assert_eq!(
        formatted,
        "scenario x {\n  check age a.b -> c.d via c.t.go, c.e <= 5 ms;\n  check within a => b or c then d;\n}\n"
    );
    assert_eq!(format(&formatted).unwrap(), formatted);
}

#[test]
fn responses_follow_one_after_the_other() {
    // A job of the filter from its tick at 20: `start` ends at 21, `pass` at 22.
    let check = |check: &str| {
        let items = std::format!("durations fixed; check {check};");
        values(&two(Preset::Servers, &items))
    };
    let time = |number| vec![(Verdict::Proved, Some(Value::Time(number)))];
    let begins = "filter.t.start.exec";
    assert_eq!(check(&std::format!("within {begins} => leave {begins}")), time(1.0));
    let pass = "leave filter.t.pass.exec";
    assert_eq!(check(&std::format!("within {begins} => leave {begins} then {pass}")), time(2.0));
    // The end of `start` comes only in the next job after that of `pass`.
    assert_eq!(check(&std::format!("within {begins} => {pass} then leave {begins}")), time(21.0));
}

#[test]
fn runs_say_which_chains_they_do_not_follow() {
    let notes = |check: &str| {
        let unit = load(TWO);
        let parsed = parse(&std::format!("scenario two {{ check {check}; }}"));
        let input = SystemInput { specs: vec![&unit.spec] };
        prepare(&input, &parsed.scenario, &Options::default()).report.notes
    };
    assert_eq!(
        notes("age sensor.raw -> filter.clean <= 5 ms"),
        [
            "not checked along runs: `age sensor.raw -> filter.clean`; runs follow no data, `dotgen verify` \
                answers these checks"
        ]
    );
    assert_eq!(notes("schedulable *"), [] as [&str; 0]);
}
