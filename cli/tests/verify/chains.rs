//! The causes of refuted chains and responses.

use serde_json::Value;

use super::json_of;
use crate::directory::{Directory, status, stdout};

const EYE: &str = "\
component eye {
  typedef long place;
  ids { place last; };
  port out place ball;
  task look {
    period 20 ms;
    codel<start> grab(out last) yield find wcet 2 ms;
    codel<find> find(inout last, port out ball) yield pause::start wcet 3 ms;
  };
};
";

/// `plan` hands the datum on to `move`. In the lock queue both wait behind `log`.
const DRIVE: &str = "\
component drive {
  typedef long place;
  port in place ball;
  port out place wheels;
  ids { place goal; place map; };
  task plan {
    period 30 ms;
    codel<start> aim(port in ball, out goal) yield pause::start wcet 6 ms;
  };
  task log {
    period 30 ms;
    codel<start> save(inout map) yield pause::start wcet 9 ms;
  };
  task move {
    period 10 ms;
    codel<start> steer(in goal, in map, port out wheels) yield pause::start wcet 1 ms;
  };
};
";

const ARM: &str = "\
component arm {
  typedef long place;
  port in place ball;
  port out place joint;
  ids { place goal; };
  task plan {
    period 10 ms;
    codel<start> read(port in ball, out goal) yield pause::refine wcet 1 ms;
    codel<refine> refine(inout goal) yield pause::refine, pause::send wcet 2 ms;
    codel<send> send(in goal, port out joint) yield pause::start wcet 1 ms;
  };
};
";

/// Returns the cause of a check that is refuted, in words and as data.
fn cause(specification: &str, component: &str, check: &str) -> (String, Value) {
    let scenario = format!(
        "scenario s {{\n  use \"eye.gen\"; use \"c.gen\";\n  connect {component}.ball to eye.ball;
  unit 1 ms; cores 4; durations fixed;\n  check {check};\n}}\n"
    );
    let directory =
        Directory::new(&[("eye.gen", EYE), ("c.gen", specification), ("s.scn", &scenario)]);
    let output = directory.run(&["verify", "s.scn"]);
    let text = stdout(&output);
    assert_eq!(status(&output), 1, "{text}");
    let lines = text.lines().skip_while(|line| !line.starts_with("  cause "));
    let mut lines = lines.map(|line| format!("{line}\n"));
    let first = lines.next().unwrap_or_else(|| panic!("a cause: {text}"));
    let rest = lines.take_while(|line| line.starts_with("    ") && !line.contains(" ms  "));
    let words = (first + &rest.collect::<String>()).replace("\n  ", "\n").trim_start().to_owned();
    let answer = json_of(&directory.run(&["verify", "--format", "json", "s.scn"]));
    (words, answer["checks"][0]["why"].clone())
}

/// Asserts that the parts of a cause add up to its time.
fn adds_up(why: &Value) {
    let parts = why["cause"]["parts"].as_array().expect("parts").iter();
    let sum: f64 = parts.map(|part| part["time"].as_f64().expect("a time")).sum();
    assert!((sum - why["cause"]["time"].as_f64().expect("a time")).abs() < 1e-6, "{why:#}");
}

#[test]
fn a_late_reaction_is_the_sum_of_what_two_tasks_do() {
    let slow = DRIVE.replace("period 10 ms", "period 40 ms");
    let (words, why) = cause(&slow, "drive", "reaction eye.ball -> drive.wheels <= 50 ms");
    expect_test::expect![["
          cause `drive.plan` is between its jobs for 24 ms; `drive.move` is between its jobs for 20 ms;
            `drive.plan` executes `aim` 2 times, for 7 ms: together 51 ms, more than the limit of 50 ms
    "]].assert_eq(&words);
    adds_up(&why);
}

#[test]
fn a_wait_for_a_lock_names_the_codel_that_holds_it() {
    let check = "reaction eye.ball -> drive.wheels <= 40 ms";
    let (words, why) = cause(DRIVE, "drive", check);
    expect_test::expect![["
          cause `drive.plan` is between its jobs for 24 ms; waits 9 ms for a lock, held by `save`; executes
            `aim` 2 times, for 7 ms; 1 ms in smaller parts: together 41 ms, more than the limit of 40 ms
    "]].assert_eq(&words);
    adds_up(&why);
    let wait = why["cause"]["parts"]
        .as_array()
        .and_then(|parts| parts.iter().find(|part| part["part"] == "waits").cloned());
    assert_eq!(wait.unwrap_or_default()["held-by"], "drive.log.start", "{why:#}");
}

#[test]
fn an_old_datum_is_the_sum_of_what_delays_the_next_one() {
    let (words, why) = cause(DRIVE, "drive", "age eye.ball -> drive.wheels <= 50 ms");
    expect_test::expect![["
          cause `drive.plan` is between its jobs for 19 ms; executes `aim` 2 times, for 12 ms; `drive.move`
            is between its jobs for 9 ms; 11 ms in smaller parts: together 51 ms, more than the limit of
            50 ms
    "]].assert_eq(&words);
    adds_up(&why);
}

#[test]
fn a_reaction_without_a_bound_names_the_loop_and_the_yields_that_leave_it() {
    let (words, why) = cause(ARM, "arm", "reaction eye.ball -> arm.joint");
    expect_test::expect![["
          cause `arm.plan` is between its jobs for 31 ms; executes `refine` 2 times, for 4 ms; executes
            `send` for 1 ms; 1 ms in smaller parts: together 37 ms; `plan` can execute `refine` for ever:
            `refine` need never yield `pause::send` (c.gen:9)
    "]].assert_eq(&words);
    assert_eq!(why["endless"]["codels"], serde_json::json!(["arm.plan.refine"]), "{why:#}");
    assert_eq!(why["endless"]["exits"][0]["yields"], "pause::send", "{why:#}");
}

#[test]
fn a_response_that_need_not_come_names_the_loop() {
    let check = "leadsto arm.plan.refine.exec => arm.plan.send.exec";
    let (words, _) = cause(ARM, "arm", check);
    expect_test::expect![["
          cause `plan` can execute `refine` for ever: `refine` need never yield `pause::send` (c.gen:9)
    "]].assert_eq(&words);
}
