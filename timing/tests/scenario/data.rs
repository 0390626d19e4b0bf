//! Comparisons of the data of ports.

use dotgen_timing::explore::{Possible, Seen, Stepper};
use dotgen_timing::scn::complete::{Completions, complete};
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::{Prepared, prepare};
use serde_json::json;

use super::*;

const TANK: &str = r#"
typedef double height;
enum mode { IDLE, FILLING };
struct flow { double rate; };
struct levels { double level; long long count; boolean full; mode now; flow inflow; sequence<long> past; };
component tank {
  version "1"; lang "c";
  ids { long raw; };
  port out levels state;
  port out height height;
  port in levels other;
  port multiple out height each;
  task keep { period 10 ms; codel <start> go(port out state, port out height) yield pause::start wcet 1 ms; };
};
"#;

fn tank(items: &str) -> (Report, Prepared) {
    let unit = load(TANK);
    let parsed = parse(&format!("scenario tank {{ {items} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let options = Options::default();
    let report = verify(&input, &parsed.scenario, &options, &Cancel::default());
    (report, prepare(&input, &parsed.scenario, &options))
}

#[test]
fn comparisons_are_not_verified_and_the_other_checks_are() {
    let (report, prepared) =
        tank("check schedulable *; check full: never tank.state.level > -0.5 and tank.keep;");
    assert_eq!(
        summary(&report),
        "scn-data: not verified: `tank.state.level` is data, which the timed model does not have; `dotgen run` \
         and `dotgen replay` check this\nschedulable tank.keep Proved\n"
    );
    assert_eq!(prepared.report.diagnostics, []);
    let shown = |check: usize| &prepared.checks[check].report.of;
    assert_eq!(shown(1), "not (tank.state.level > -0.5 and tank.keep)");
}

#[test]
fn what_cannot_be_compared_is_told() {
    let mut out = String::new();
    for comparison in [
        "tank.ids.raw > 1",
        "tank.keep.start > 1",
        "tank.keep <= 5",
        "tank.other.level > 1",
        "tank.each > 1",
        "tank.state > 1",
        "tank.state.past > 1",
        "tank.state.levl > 1",
        "tank.state.inflow.flow > 1",
        "tank.state.level == FILLING",
        "tank.state.full == 1",
        "tank.state.full < true",
        "tank.state.now == FILLIN",
        "tank.state.now == 1",
    ] {
        let (report, prepared) = tank(&format!("check never {comparison};"));
        assert!(report.checks.is_empty());
        assert_eq!(report.diagnostics, prepared.report.diagnostics, "{comparison}");
        out.push_str(&format!("{comparison}\n  {}", summary(&report)));
    }
    insta::assert_snapshot!(out);
}

#[test]
fn a_limit_of_time_is_no_comparison() {
    for (check, text) in [
        (
            "within tank.keep => tank.state.full == true <= 5 ms",
            "tank.keep => tank.state.full == true",
        ),
        ("within tank.height <= 5 => tank.keep <= 5 ms", "tank.height <= 5 => tank.keep"),
        ("lasts tank.height >= 2.5 >= 2 ms", "lasts tank.height >= 2.5 >= 2 ms"),
        ("lasts tank.keep <= 2 ms", "tank.keep => not tank.keep"),
        ("tank.height > 1 precedes tank.keep", "tank.height > 1 precedes tank.keep"),
    ] {
        let (_, prepared) = tank(&format!("check {check};"));
        assert_eq!(prepared.report.diagnostics, [], "{check}");
        assert_eq!(prepared.checks[0].report.of, text);
    }
}

#[test]
fn values_are_compared_by_their_type() {
    let data = json!({
        "level": 0.1, "count": 9_007_199_254_740_993_i64, "full": false, "now": "FILLING",
        "inflow": {"rate": null}, "past": [],
    });
    for (comparison, holds) in [
        ("level < 0.2", true),
        ("level <= 0.1", true),
        ("level == 0", false),
        // Doubles have no such number.
        ("count == 9007199254740993", true),
        ("count > 9007199254740992", true),
        ("count >= 9007199254740994", false),
        ("full == true", false),
        ("full != true", true),
        ("now == FILLING", true),
        ("now != FILLING", false),
        // Not finite.
        ("inflow.rate > 0", false),
        ("inflow.rate <= 0", false),
    ] {
        let (_, prepared) = tank(&format!("check never tank.state.{comparison};"));
        let facts = prepared.built.data.expect("a run has data");
        assert_eq!(facts[0].holds(&data), holds, "{comparison}");
    }
}

/// Performs actions of a run, with the values of the comparison from each on. Returns what is violated at
/// which action.
fn violations(check: &str, values: &[Option<bool>]) -> Vec<usize> {
    let (_, prepared) = tank(&format!("check {check};"));
    let (watched, _) = prepared.watched();
    let mut stepper = Stepper::new(&prepared.built.system, &watched);
    let (mut possible, mut seen) = (Possible::default(), Vec::new());
    stepper.begin(&mut seen);
    let mut out = Vec::new();
    for (number, value) in values.iter().enumerate() {
        stepper.possible(&mut possible);
        while possible.actions().is_empty() {
            stepper.pass(stepper.next_moment().expect("a task that goes on"), &mut seen);
            stepper.possible(&mut possible);
        }
        if let Some(value) = *value {
            stepper.set_fact(0, value);
        }
        stepper.perform(possible.actions()[0], &mut seen);
        let violated = |seen: &Seen| matches!(seen, Seen::Reached { .. } | Seen::Violated { .. });
        out.extend(seen.drain(..).any(|seen| violated(&seen)).then_some(number));
    }
    out
}

#[test]
fn before_a_port_is_written_no_comparison_holds() {
    let values = [None, None, Some(true), None, Some(false), Some(false), Some(true)];
    for (check, violated) in [
        ("never tank.height > 1", vec![2, 6]),
        ("always tank.height > 1", vec![4]),
        ("always not (tank.keep.idle and not tank.keep.idle) => tank.height > 1", vec![4]),
        ("after tank.height > 1 always tank.height > 1", vec![4, 6]),
    ] {
        let found = violations(check, &values);
        assert_eq!(found.first(), violated.first(), "{check}: {found:?}");
    }
}

#[test]
fn members_are_proposed_one_name_at_a_time() {
    let unit = load(TANK);
    let names = Names::new(&[&unit.spec]);
    let proposed = |check: &str| {
        let text = format!("scenario s {{ check never {check}");
        let parsed = parse(&text);
        let Completions::Of { items, .. } = complete(&text, &parsed.scenario, &names, text.len())
        else {
            return String::new();
        };
        items.iter().map(|item| item.label.clone()).collect::<Vec<_>>().join(" ")
    };
    let shown: Vec<String> = [
        "tank.state.",
        "tank.state.inflow.",
        "tank.",
        "tank.state.level ",
        "tank.state.full ",
        "tank.keep ",
    ]
    .into_iter()
    .map(|check| format!("{check}| {}", proposed(check)))
    .collect();
    insta::assert_snapshot!(shown.join("\n"), @r"
    tank.state.| level count full now inflow
    tank.state.inflow.| rate
    tank.| keep state height idle
    tank.state.level | == != < <= > >=
    tank.state.full | == !=
    tank.keep | and or
    ");
}
