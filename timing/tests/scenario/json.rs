//! The JSON form of reports.

use super::*;

/// The JSON form is an interface: names and units are strings there, in this order.
#[test]
fn names_and_units_are_strings_in_json() {
    let report = robot(
        "unit 10 us; cores 1; check schedulable control.move; check response control.move <= 5 ms;",
    );
    assert_eq!(json(&report.unit), "\"10 us\"");
    let run = report.checks[0].run();
    let begin = run.iter().find(|run| run.codel.is_some()).unwrap();
    insta::assert_snapshot!(json(begin));
    let delay = report.checks.iter().flat_map(|check| &check.reason).next().unwrap();
    insta::assert_snapshot!(json(delay));
}

fn json(serialize: &impl serde::Serialize) -> String {
    serde_json::to_string(serialize).unwrap()
}
