//! Measures: what follows an event of a run is part of the model.

use dotgen_timing::diagnostic::Diagnostic;
use dotgen_timing::report::{Report, Value, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use super::load;

const DRIVE: &str = "struct speed { double v; };
component d { version \"1\"; lang \"c\"; ids { double v; }; port out speed out_speed; port in speed in_speed;
  task main { period 10 ms; };
  task sense { period 20 ms; codel<start> d_look(out v) yield pause::start wcet 2 ms; };
  activity drive() { task main;
    codel<start> d_start(port out out_speed) yield main wcet 1 ms;
    codel<main> d_main(port out out_speed) yield pause::main, ether wcet 1 ms;
    codel<stop> d_stop(port out out_speed) yield ether wcet 1 ms; };
  function halt() { codel d_halt(inout v) wcet 1 ms; };
};";

fn report_of(specification: &str, scenario: &str) -> Report {
    let unit = load(specification);
    let input = SystemInput { specs: vec![&unit.spec] };
    verify(&input, &parse(scenario).scenario, &Options::default(), &Cancel::default())
}

fn scenario(items: &str) -> String {
    format!("scenario s {{ cores 2; client a {{ send d.drive; }} {items} }}")
}

#[test]
fn the_time_from_an_event_to_the_end_of_its_measure_is_a_check() {
    let measure = "on late d.sense <= 50 ms { abort d.drive; send d.halt; await ended; stop; }";
    let report = report_of(DRIVE, &scenario(&format!("{measure} check schedulable *;")));
    let check = &report.checks[0];
    assert_eq!(check.of, "on late d.sense", "{check:?}");
    assert_eq!(check.verdict, Verdict::Proved, "{check:?}");
    let Some(Value::Time(longest)) = check.value else { panic!("{check:?}") };
    // The next tick of its task, then its `stop` codel.
    assert!((11.0..=50.0).contains(&longest), "{longest}");
    // The measure is part of what else is checked.
    assert!(report.checks[1..].iter().all(|check| check.verdict == Verdict::Proved));
    // Without the activity, the measure ends at once.
    let alone = measure.replace("abort d.drive; ", "");
    let alone = report_of(DRIVE, &format!("scenario s {{ cores 2; {alone} }}"));
    let Some(Value::Time(shorter)) = alone.checks[0].value else { panic!("{alone:?}") };
    assert!(shorter < longest, "{shorter} {longest}");
}

#[test]
fn what_a_measure_names_is_checked() {
    let cases = [
        ("on late d { stop; }", "scn-wrong-kind", "is no codel or task"),
        ("on lost d.sense { stop; }", "scn-wrong-kind", "is no component"),
        ("on violation of v { stop; }", "scn-wrong-kind", "is no named check"),
        ("on stale d.main after 1 s { stop; }", "scn-wrong-kind", "is no output port"),
        ("on stale d.in_speed after 1 s { stop; }", "scn-wrong-kind", "is no output port"),
        ("on late d.sense { abort d.halt; }", "scn-wrong-kind", "is no activity"),
        ("on late d.sense { stop; send d.halt; }", "scn-stop", "only be the last step"),
        ("client b { stop; }", "scn-stop", "only be the last step"),
    ];
    for (items, code, said) in cases {
        let text = scenario(items);
        let parsed = parse(&text).errors.into_iter();
        let report = report_of(DRIVE, &text);
        let found: Vec<_> = parsed.chain(report.diagnostics).collect();
        let is_expected =
            |found: &Diagnostic| found.code == code && found.message.to_string().contains(said);
        assert!(found.iter().any(is_expected), "{items}: {found:?}");
    }
}

/// Components without a connection are verified apart.
#[test]
fn a_measure_may_follow_an_event_of_another_component() {
    let units = [DRIVE.to_owned(), DRIVE.replace("component d", "component e").replace("d_", "e_")];
    let units = units.map(|text| load(&text));
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    for event in ["stale e.out_speed after 1 s", "late e.sense", "lost e"] {
        let text =
            format!("scenario s {{ cores 4; on {event} {{ send d.halt; }} check schedulable *; }}");
        let report =
            verify(&input, &parse(&text).scenario, &Options::default(), &Cancel::default());
        assert!(report.diagnostics.is_empty(), "{event}: {:?}", report.diagnostics);
        assert!(report.checks.iter().all(|check| check.verdict == Verdict::Proved), "{report:?}");
    }
}
