//! Checks that compare the data of ports: executed codels are checked, the model and simulations are not.

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::json_of;

const TANK: &str = r#"
enum mode { IDLE, FILLING };
struct levels { double level; mode now; };
component tank {
  version "1"; lang "c";
  ids { double raw; };
  port out levels state;
  task keep {
    period 10 ms;
    codel<start> begin(out raw) yield pause::fill wcet 1 ms;
    codel<fill> pour(inout raw, port out state) yield pause::fill wcet 1 ms;
  };
};
"#;

/// The level rises by a quarter each 10 ms, from the second cycle.
const CODELS: &str = r#"
#include "actank.h"
#include "tank_c_types.h"

genom_event begin(double *raw, const genom_context self)
{
  (void)self;
  *raw = 0.;
  return tank_pause_fill;
}

genom_event pour(double *raw, const tank_state *state, const genom_context self)
{
  *raw += .25;
  state->data(self)->level = *raw;
  state->data(self)->now = *raw > 1. ? FILLING : IDLE;
  state->write(self);
  return tank_pause_fill;
}
"#;

const SCENARIO: &str = "scenario s {
  use \"tank.gen\";
  check deadlines: schedulable *;
  check low: never tank.state.level > 3;
  check high: never tank.state.level > 30.5;
  check grows: always tank.state.now == FILLING => tank.state.level > 1;
  check soon: within tank.state.level >= 1 => tank.state.now == FILLING <= 15 ms;
  check order: tank.state.level == 1 precedes tank.state.now == FILLING;
  check empty: reachable tank.state.level < 0;
}
";

fn tank() -> Directory {
    Directory::new(&[("tank.gen", TANK), ("codels/tank.c", CODELS), ("s.scn", SCENARIO)])
}

fn verdicts(report: &Value) -> Vec<String> {
    let checks = report["checks"].as_array().expect("a list").iter();
    let word = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    checks.map(|check| format!("{} {}", word(&check["name"]), word(&check["verdict"]))).collect()
}

/// The results of the checks that compare data.
const RESULTS: &[&str] =
    &["low violated", "high kept", "grows kept", "soon kept", "order kept", "empty not-seen"];

#[test]
#[cfg(target_os = "linux")]
fn data_are_checked_in_a_run_and_in_its_replay() {
    if !crate::running::compilers() {
        return;
    }
    let directory = tank();
    let options = "run s.scn --bounds none --until 1s --format json --record run.mcap";
    let output = directory.run(&options.split(' ').collect::<Vec<_>>());
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let report = json_of(&output);
    assert_eq!(verdicts(&report)[1..], *RESULTS, "{report:#}");
    // The level is 3.25 at the end of the 13th codel, which begins at 140 ms.
    let at = report["checks"][1]["at"]["time"].as_f64().expect("a time");
    assert!((140.0..=141.0).contains(&at), "{at}");
    let output = directory.run(&["replay", "run.mcap", "s.scn", "--format", "json"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let replayed = json_of(&output);
    assert_eq!(replayed["difference-count"], 0, "{replayed:#}");
    assert_eq!(verdicts(&replayed)[0], verdicts(&report)[0]);
    assert_eq!(verdicts(&replayed)[1..], *RESULTS, "{replayed:#}");
    assert_eq!(replayed["checks"][1]["at"].as_f64(), Some(at), "{replayed:#}");
    let words = stdout(&directory.run(&["replay", "run.mcap", "s.scn"]));
    assert!(words.contains("violated at 140 ms low: always"), "{words}");
}

#[test]
fn without_data_nothing_is_said_of_them() {
    let directory = tank();
    let output = directory.run(&["verify", "s.scn", "--format", "json"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert_eq!(verdicts(&json_of(&output)), ["deadlines proved"]);
    let told = stderr(&directory.run(&["verify", "s.scn"]));
    assert_eq!(told.matches("scn-data").count(), 6, "{told}");
    assert!(told.contains("s.scn:4:20"), "{told}");

    let options = "run s.scn --simulate all --until 1s --format json --record run.mcap";
    let output = directory.run(&options.split(' ').collect::<Vec<_>>());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let report = json_of(&output);
    let why = "tank.state has no data: no codel that writes it is executed";
    for check in report["checks"].as_array().expect("a list").iter().skip(1) {
        assert_eq!(check["verdict"], "not-exercised", "{check:#}");
        assert_eq!(check["why"], why);
    }
    let output = directory.run(&["replay", "run.mcap", "s.scn", "--format", "json"]);
    let replayed = json_of(&output);
    assert_eq!(status(&output), 0, "{replayed:#}");
    // Simulated codels show nothing about the program.
    assert_eq!(verdicts(&replayed)[0], "deadlines simulated");
    assert_eq!(replayed["checks"][1]["why"], why);
}

#[test]
fn a_replay_tells_the_end_in_which_nothing_is_left() {
    let directory = Directory::new(&[
        (
            "lamp.gen",
            "component lamp { task t { codel<start> on() yield ether wcet 1 ms; };
               function flash() { codel f() wcet 1 ms; }; };\n",
        ),
        (
            "s.scn",
            "scenario s { use \"lamp.gen\"; client k { send lamp.flash; }
               check deadlock; check eventually lamp.t.start.lock and lamp.t.idle; }\n",
        ),
    ]);
    let words = ["run", "s.scn", "--simulate", "all", "--format", "json", "--record", "run.mcap"];
    let report = json_of(&directory.run(&words));
    assert_eq!(report["end"], "nothing-left", "{report:#}");
    let output = directory.run(&["replay", "run.mcap", "s.scn", "--format", "json"]);
    let replayed = json_of(&output);
    let of = |report: &Value, key: &str| -> Vec<Value> {
        let checks = report["checks"].as_array().expect("a list").iter();
        checks.map(|check| check[key].clone()).collect()
    };
    assert_eq!(of(&replayed, "verdict"), of(&report, "verdict"), "{replayed:#}");
    assert_eq!(of(&replayed, "violations"), of(&report, "violations"));
    assert!(of(&replayed, "verdict").contains(&"violated".into()), "{replayed:#}");
}

#[test]
fn weights_of_the_scenario_are_those_of_the_option_and_the_option_goes_first() {
    let weights = |main: u32| {
        format!("t::lamp_start::lamp_pause_start {main}\nt::lamp_start::lamp_dark {}\n", 9 - main)
    };
    let scenario =
        "scenario s { use \"lamp.gen\"; weights \"a.proba\"; check schedulable lamp.t; }\n";
    let directory = Directory::new(&[
        (
            "lamp.gen",
            "component lamp { task t { period 10 ms;
               codel<start> on() yield pause::start, dark wcet 1 ms;
               codel<dark> off() yield pause::start wcet 1 ms; }; };\n",
        ),
        ("a.proba", &weights(9)),
        ("b.proba", &weights(0)),
        ("s.scn", scenario),
        ("plain.scn", &scenario.replace("weights \"a.proba\";", "")),
    ]);
    let dark = |words: &[&str]| {
        let all = ["run", "--simulate", "all", "--until", "1s", "--format", "json"];
        let output = directory.run(&[&all[..], words].concat());
        let report = json_of(&output);
        let codels = report["codels"].as_array().expect("a list").iter();
        let runs = codels.filter(|codel| codel["codel"] == "lamp.t.dark");
        runs.map(|codel| codel["runs"].as_u64().expect("a number")).sum::<u64>()
    };
    assert_eq!(dark(&["s.scn"]), 0);
    assert!(dark(&["s.scn", "--weights", "b.proba"]) > 90);
    let without = dark(&["plain.scn"]);
    assert!((1..90).contains(&without), "{without}");
}

/// By name of a check: what is said of it. An interval of time is two checks of one name.
fn said(report: &Value) -> std::collections::BTreeMap<String, Vec<String>> {
    let mut out = std::collections::BTreeMap::<_, Vec<String>>::new();
    for check in report["checks"].as_array().expect("a list") {
        let word = |key: &str| check[key].as_str().unwrap_or_default().to_owned();
        out.entry(word("name")).or_default().push(word("verdict"));
    }
    out
}

#[test]
fn runs_and_replays_follow_each_pattern_as_it_is_verified() {
    let read = |name: &str| {
        let path = format!("{}/../timing/tests/scenario/{name}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(path).expect("the file")
    };
    let (genom, scenario) = (read("patterns.gen"), read("patterns.scn"));
    let directory = Directory::new(&[("patterns.gen", &genom), ("patterns.scn", &scenario)]);
    let options =
        "run patterns.scn --simulate all --bounds none --until 1s --format json --record run.mcap";
    let output = directory.run(&options.split(' ').collect::<Vec<_>>());
    let report = json_of(&output);
    let output = directory.run(&["replay", "run.mcap", "patterns.scn", "--format", "json"]);
    let replayed = json_of(&output);
    assert_eq!(said(&replayed), said(&report), "{replayed:#}");
    assert_eq!(said(&report)["fails_leadsto"], ["not-exercised"]);
    // The missing end of a run cannot be seen.
    let endless = ["fails_eventually", "fails_reachable", "fails_leadsto", "holds_deadlock"];
    for (name, verdicts) in said(&report) {
        if !endless.contains(&&*name) {
            let expected = name.starts_with("fails_");
            assert_eq!(verdicts.contains(&"violated".to_owned()), expected, "{name}: {verdicts:?}");
        }
    }
}
