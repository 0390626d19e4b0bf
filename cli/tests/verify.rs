//! `dotgen verify`, run as users and scripts run it.

mod assumptions;
mod certificate;
mod chains;

use std::process::Output;

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};

/// `sense` has to wait while `steer` executes.
const LIFT: &str = "\
component lift {
  version \"1.0\";
  ids { long position; };

  task sense {
    period 10 ms;
    codel<start> read(out position) yield pause::start wcet 2 ms;
  };
  task move {
    period 20 ms;
    codel<start> steer(in position) yield pause::start wcet WCET;
  };
};
";

const SCENARIO: &str = "\
scenario ride {
  use \"../spec/lift.gen\"; semantics published;
  unit 1 ms;
  cores 2;
  policy edf;
  durations fixed;

  check schedulable *;
  check quick: response lift.sense <= 8 ms;
  check always not (lift.sense.start.exec and lift.move.start.exec);
}
";

fn lift(wcet: &str) -> Directory {
    Directory::new(&[
        ("spec/lift.gen", &LIFT.replace("WCET", wcet)),
        ("scenarios/ride.scn", SCENARIO),
    ])
}

/// Without times and sizes of the run itself.
fn stable(text: &str) -> String {
    let lines = text.lines().map(|line| match line.rsplit_once('(') {
        Some((before, rest)) if rest.contains(" states in ") => format!("{before}(…)"),
        Some((before, rest)) if rest.starts_with("by analysis in ") => {
            format!("{before}(by analysis …)")
        }
        _ => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn json_of(output: &Output) -> Value {
    serde_json::from_str(&stdout(output)).expect("one JSON document")
}

#[test]
fn a_scenario_that_holds() {
    let directory = lift("5 ms");
    let output = directory.run(&["verify", "scenarios/ride.scn"]);
    assert_eq!(stderr(&output), "");
    assert_eq!(status(&output), 0);
    insta::assert_snapshot!(stable(&stdout(&output)));
}

#[test]
fn a_missed_deadline_is_told_as_a_timeline() {
    let directory = lift("17 ms");
    let output = directory.run(&[
        "verify",
        "--check",
        "check schedulable lift.sense;",
        "scenarios/ride.scn",
    ]);
    assert_eq!(stderr(&output), "");
    assert_eq!(status(&output), 1);
    insta::assert_snapshot!(stable(&stdout(&output)));
}

#[test]
fn json_has_the_promised_shape() {
    let directory = lift("17 ms");
    let output = directory.run(&["verify", "--format", "json", "scenarios/ride.scn"]);
    assert_eq!(status(&output), 1);
    let mut document = json_of(&output);
    assert!(document["states"].as_u64() > Some(0));
    assert!(document["seconds"].is_f64());
    for measured in ["states", "steps", "memory", "seconds"] {
        document[measured] = Value::from(0);
    }
    insta::assert_json_snapshot!(document);
}

#[test]
fn options_override_the_scenario() {
    let directory = lift("5 ms");
    let response = ["--check", "check response lift.sense;", "--format", "json"];
    let run = |more: &[&str]| {
        let arguments = [&["verify", "scenarios/ride.scn"], &response[..], more].concat();
        let document = json_of(&directory.run(&arguments));
        assert_eq!(document["checks"].as_array().map(Vec::len), Some(1));
        document["checks"][0]["value"].clone()
    };
    assert_eq!(run(&[]), 2);
    assert_eq!(run(&["--durations", "interval"]), 7);
    assert_eq!(run(&["--durations", "open", "--cores", "free"]), 7);
    assert_eq!(run(&["--durations", "interval", "--cores", "1", "--policy", "any"]), 7);
}

#[test]
fn without_a_scenario_a_client_may_do_anything() {
    let directory = lift("5 ms");
    let output = directory.run(&["verify", "spec/lift.gen"]);
    assert_eq!(stderr(&output), "");
    assert_eq!(status(&output), 0);
    insta::assert_snapshot!(stable(&stdout(&output)));
}

#[test]
fn giving_up_is_an_answer_of_its_own() {
    let directory = lift("5 ms");
    for limit in [["--max-states", "1"], ["--max-memory", "0"]] {
        let mut arguments = vec!["verify", "--durations", "interval", "--without", "invariants"];
        arguments.extend(limit);
        arguments.push("scenarios/ride.scn");
        let output = directory.run(&arguments);
        assert_eq!(status(&output), 3, "{limit:?}");
        assert!(stdout(&output).contains("gave up at "), "{}", stdout(&output));
    }
}

#[test]
fn what_repeats_itself_is_told_once() {
    let directory = Directory::new(&[
        (
            "busy.gen",
            "component busy {\n  ids { long x; };\n  task spin { period 5 ms;\n    codel<start> f(out x) yield go wcet 20 us;\n    codel<go> g(out x) yield start, pause::start wcet 80 us;\n  };\n};\n",
        ),
        (
            "busy.scn",
            "scenario busy {\n  use \"busy.gen\"; semantics published;\n  durations fixed;\n  check schedulable *;\n}\n",
        ),
    ]);
    let output = directory.run(&["verify", "busy.scn"]);
    assert_eq!(status(&output), 1);
    let text = stable(&stdout(&output));
    let start = text.find("refuted schedulable").expect("the run");
    let run = text[start..].split("\n\n").next().unwrap_or_default();
    insta::assert_snapshot!(run);
}

#[test]
fn of_a_long_run_the_beginning_and_the_end_are_shown() {
    let directory = lift("9 ms");
    directory.write(
        "scenarios/long.scn",
        b"scenario long {\n  use \"../spec/lift.gen\"; semantics published;\n  durations fixed;\n  client late { delay 200 ms; send lift.f; }\n  check always not lift.f;\n}\n",
    );
    directory.write(
        "spec/lift.gen",
        LIFT.replace("WCET", "3 ms")
            .replace("10 ms", "7 ms")
            .replace("20 ms", "11 ms")
            .replace("};\n};\n", "};\n  function f() { codel g(in position) wcet 1 ms; };\n};\n")
            .as_bytes(),
    );
    let arguments = ["verify", "scenarios/long.scn"];
    let output = directory.run(&arguments);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    insta::assert_snapshot!(stable(&stdout(&output)));
    let output = directory.run(&[&arguments[..], &["--format", "json"]].concat());
    let run = &json_of(&output)["checks"][0]["counterexample"];
    assert!(run.as_array().map(Vec::len) > Some(100));
}

#[test]
fn what_was_given_up_says_why_and_what_helps() {
    let directory = lift("5 ms");
    let mut told = String::new();
    let run = |limit: [&str; 2]| {
        let exploring = ["verify", "--durations", "interval", "--without", "invariants"];
        let arguments = [&exploring[..], &limit].concat();
        let text = directory.run(&[&arguments[..], &["scenarios/ride.scn"]].concat());
        let json =
            directory.run(&[&arguments[..], &["--format", "json", "scenarios/ride.scn"]].concat());
        assert_eq!((status(&text), status(&json)), (3, 3), "{limit:?}");
        assert_eq!(stderr(&text), "", "no progress where nobody looks");
        let checks = json_of(&json)["checks"].clone();
        let checks = checks.as_array().expect("a list").clone();
        let reasons = checks.iter().map(|check| check["gave-up"]["reason"].clone());
        (stable(&stdout(&text)), reasons.collect::<Vec<_>>())
    };
    for (limit, reason) in [
        (["--max-states", "1"], "states"),
        (["--max-memory", "0"], "memory"),
        (["--timeout", "0"], "time"),
    ] {
        let (text, reasons) = run(limit);
        assert_eq!(reasons[3], reason);
        told.push_str(&format!("$ dotgen verify {}\n{text}\n", limit.join(" ")));
    }
    insta::assert_snapshot!(told);
}

#[test]
fn reductions_are_explained_and_can_be_switched_off() {
    let directory = lift("3 ms");
    let run = |more: &[&str]| {
        let output = directory.run(&[&["verify", "scenarios/ride.scn"], more].concat());
        let text = stdout(&output);
        let (before, after) = text.split_once("\nreductions\n").unwrap_or((&text, ""));
        let table: Vec<String> = (before.lines().filter(|line| !line.contains(" states in ")))
            .map(str::to_owned)
            .collect();
        let line = |name: &str| -> String {
            let line = after.lines().find_map(|line| line.trim_start().strip_prefix(name));
            line.unwrap_or_default().trim().to_owned()
        };
        (status(&output), table, line("window-union"), line("resting-loops"))
    };
    let (code, table, union, resting) = run(&["--explain"]);
    assert_eq!(union, "used");
    assert!(resting.starts_with("not used"), "{resting}");
    let (other_code, other_table, union, _) = run(&["--explain", "--without", "window-union"]);
    assert_eq!(union, "not used: switched off");
    assert_eq!((other_code, other_table), (code, table));
    assert_eq!(run(&[]).2, "", "only where it is asked for");
    let wrong = directory.run(&["verify", "--without", "luck", "scenarios/ride.scn"]);
    assert_eq!(status(&wrong), 2);
    assert!(stderr(&wrong).contains("give one of persistent-sets, "));
}

#[test]
fn a_timeout_ends_the_search_for_limits_as_well() {
    let directory = lift("3 ms");
    let output =
        directory.run(&["verify", "--sensitivity", "--timeout", "0", "scenarios/ride.scn"]);
    let text = stdout(&output);
    assert!(text.contains("time is up"), "{text}");
    assert!(!text.contains("largest WCET"), "{text}");
    for wrong in ["soon", "inf", "NaN"] {
        let output = directory.run(&["verify", "--timeout", wrong, "scenarios/ride.scn"]);
        assert_eq!(status(&output), 2, "{wrong}");
        assert!(stderr(&output).contains("give a number of seconds"));
    }
}

#[test]
fn what_cannot_be_verified_is_explained() {
    let directory = lift("5 ms");
    directory.write(
        "broken.scn",
        b"scenario s {\n  use \"lost.gen\"; semantics published;\n  coers 4;\n}\n",
    );
    directory
        .write("bad.gen", b"component c { task t { period 1 ms; codel<start> f( yield; }; };\n");
    directory.write(
        "bad.scn",
        b"scenario s { use \"bad.gen\"; semantics published; check schedulable *; }\n",
    );
    let mut told = String::new();
    for arguments in [
        &["broken.scn"][..],
        &["bad.scn"],
        &["scenarios/ride.scn", "--check", "response lift.sence"],
        &["scenarios/ride.scn", "--check", "respons lift.sense"],
        &["scenarios/ride.scn", "--cores", "0"],
        &["nowhere.scn"],
        &["ride.txt"],
    ] {
        let output = directory.run(&[&["verify"], arguments].concat());
        assert_eq!(status(&output), 2, "{arguments:?}");
        assert_eq!(stdout(&output), "", "{arguments:?}");
        told.push_str(&format!("$ dotgen verify {}\n{}\n", arguments.join(" "), stderr(&output)));
    }
    insta::assert_snapshot!(told);
}

/// Nobody has measured anything, and `spin` can go round in three ways.
const VAGUE: &str = "\
component vague {
  version \"1.0\";
  ids { long x; };

  task spin {
    period 10 ms;
    codel<start> begin(out x) yield a;
    codel<a> one(out x) yield a, b, pause::a;
    codel<b> two(out x) yield a, c;
    codel<c, d> three(out x) yield a, d;
  };
  task poll {
    period 20 ms;
    codel<start> look(in x) yield pause::start;
  };
  function f() { codel g(in x) wcet 1 ms; codel h(in x); };
};
";

#[test]
fn what_cannot_be_verified_does_not_stop_the_others() {
    let directory = lift("5 ms");
    directory.write("broken.scn", b"scenario s {\n  coers 4;\n}\n");
    let output = directory.run(&[
        "verify",
        "--format",
        "json",
        "broken.scn",
        "nowhere.scn",
        "scenarios/ride.scn",
    ]);
    assert_eq!(status(&output), 2);
    assert_eq!(json_of(&output)["scenario"], "ride");
    let told = stderr(&output);
    assert!(told.contains("broken.scn") && told.contains("nowhere.scn"), "{told}");
    // Without one of its parts, a system is another one.
    let output = directory.run(&["verify", "nowhere.gen", "spec/lift.gen", "scenarios/ride.scn"]);
    assert_eq!(status(&output), 2);
    assert!(!stdout(&output).contains("spec/lift.gen"), "{}", stdout(&output));
    assert!(stdout(&output).contains("ride"), "{}", stdout(&output));
}

#[test]
fn how_far_a_system_is_from_missing_a_deadline() {
    let directory = lift("3 ms");
    let output = directory.run(&["verify", "--sensitivity", "scenarios/ride.scn"]);
    let text = stdout(&output);
    let start = text.find("with every deadline met").expect("the table");
    let table = text[start..].split("\n\n").next().unwrap_or_default();
    expect_test::expect![[r"
        with every deadline met
          smallest number of cores: 1
          smallest period lift.sense        4 ms (now 10 ms, not known to be the limit)
          largest WCET    lift.sense.start  8 ms (now 2 ms, not known to be the limit)
          smallest period lift.move         5 ms (now 20 ms, not known to be the limit)
          largest WCET    lift.move.start   15 ms (now 3 ms, not known to be the limit)
          next to break: the period of lift.sense, below 4 ms (now 10 ms)"]]
    .assert_eq(table);

    let output =
        directory.run(&["verify", "--sensitivity", "--format", "json", "scenarios/ride.scn"]);
    let answer: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let sensitivity = &answer["sensitivity"];
    assert_eq!(sensitivity["minimum-cores"]["cores"], 1);
    let steer = &sensitivity["wcet"][1];
    assert_eq!(steer["of"], "lift.move.start");
    // A value that the verifier itself accepts, and the next one, which it refuses.
    let most = steer["extreme"].as_f64().expect("a time");
    for (wcet, verdict) in [(most, "proved"), (most + 1.0, "refuted")] {
        let directory = lift(&format!("{} us", (wcet * 1000.0).round()));
        let arguments = ["verify", "--format", "json", "--check", "schedulable *"];
        let output = directory.run(&[&arguments[..], &["scenarios/ride.scn"]].concat());
        let answer: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
        let refuted = answer["checks"]
            .as_array()
            .expect("checks")
            .iter()
            .any(|check| check["verdict"] == "refuted");
        assert_eq!(refuted, verdict == "refuted", "{wcet} ms: {answer:#}");
    }
}

/// On one core, `high` keeps the core for ever, and `low` never completes its start-up: no job of `t` is
/// late, because there is none.
#[test]
fn deadlines_of_jobs_that_never_come_are_not_met_with_fewer_cores() {
    let directory = Directory::new(&[
        (
            "c.gen",
            "component c {\n  task low { period 10 ms; priority 9; codel<start> l() yield pause::start wcet 1 ms; };\n  task t { period 10 ms; priority 1; codel<start> a() yield pause::start wcet 1 ms; };\n};\n",
        ),
        (
            "d.gen",
            "component d {\n  task high { priority 2; codel<start> p() yield wait wcet 1 ms; codel<wait> w() yield start wcet 1 ms; };\n};\n",
        ),
        (
            "s.scn",
            "scenario s { use \"c.gen\"; use \"d.gen\"; unit 1 ms; durations fixed; cores 2; policy priority; check schedulable c.t; }\n",
        ),
    ]);
    let output = directory.run(&["verify", "--sensitivity", "--format", "json", "s.scn"]);
    let cores = &json_of(&output)["sensitivity"]["minimum-cores"];
    assert_eq!(cores["cores"], 2, "{cores}");
    assert_eq!(cores["tried"][0][1], "refuted", "{cores}");
}

#[test]
fn a_reason_that_checks_share_is_said_once() {
    let directory = Directory::new(&[
        (
            "m/m.gen",
            "component m {\n  ids { long a; };\n  task t { period 10 ms; codel<start> f(inout a) yield ether; };\n  task u { period 20 ms; codel<start> g(inout a) yield ether; };\n  activity go() { task t; codel<start> h(in a) yield ether; };\n};\n",
        ),
        ("m/m.scn", "scenario m { use \"m.gen\"; check schedulable *; }\n"),
    ]);
    let output = directory.run(&["verify", "m"]);
    let told = stderr(&output);
    assert!(told.contains("note: `m/m.scn` is not used; name it to use its checks"), "{told}");
    insta::assert_snapshot!(stable(&stdout(&output)));
    let output = directory.run(&["verify", "m", "m/m.scn"]);
    assert!(!stderr(&output).contains("is not used"), "it is named");
}

#[test]
fn a_specification_alone_is_answered_step_by_step() {
    let directory = Directory::new(&[(
        "lift.gen",
        "component lift {\n  ids { long position; };\n  task sense { period 10 ms; codel<start> look(in position) yield pause::start wcet 2 ms; };\n  task move { period 20 ms; };\n  activity go() { task move; codel<start> go_start(out position) yield pause::start, ether wcet 15 ms; };\n  activity rest() { task move; codel<start> rest_start() yield ether wcet 1 ms; };\n};\n",
    )]);
    let published = ["--semantics", "published"];
    let output =
        directory.run(&["verify", "--format", "json", published[0], published[1], "lift.gen"]);
    let document = json_of(&output);
    let first = document["first-answers"].as_array().expect("a list").iter();
    let first: Vec<String> =
        first.map(|json| format!("{}: {}", json["assuming"], json["outcome"])).collect();
    assert_eq!(
        first,
        [
            r#""permanent activities only, no requests": "vacuous""#,
            r#""lift.go alone, requested again at any time after it has ended": "refuted""#,
            r#""lift.rest alone, requested again at any time after it has ended": "proved""#,
        ]
    );
    let text = stdout(&directory.run(&["verify", "lift.gen"]));
    let (told, _) = text.split_once("any client:").expect("what is assumed");
    assert!(
        told.lines().any(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            words.join(" ") == "permanent activities only, no requests proved"
        }),
        "{told}"
    );
}

#[test]
fn without_execution_times_nothing_was_verified() {
    let directory = lift("5 ms");
    directory.write(
        "spec/lift.gen",
        LIFT.replace(" wcet WCET", "").replace(" wcet 2 ms", "").as_bytes(),
    );
    let output = directory.run(&["verify", "spec/lift.gen"]);
    assert_eq!(status(&output), 3, "{}", stdout(&output));
    let text = stdout(&output);
    assert!(text.contains("6 nothing to verify") && !text.contains("proved"), "{text}");
    assert!(!text.contains('%'), "{text}");
}

#[test]
fn each_step_names_its_rule() {
    let directory = lift("17 ms");
    let check = ["--check", "schedulable lift.sense", "--explain"];
    let arguments = [&["verify"][..], &check, &["scenarios/ride.scn"]].concat();
    let text = stdout(&directory.run(&arguments));
    for step in [
        "lift.sense.start begins  [begin]",
        "released  [release]",
        "lift.sense.start waits for lift.move.start  [wait]",
        "tick before the job has ended: kept  [tick]",
    ] {
        assert!(text.contains(step), "{step}: {text}");
    }
}

/// No place that shows the answer says that it is proved.
#[test]
fn a_proof_without_all_execution_times_is_conditional() {
    let text = "component lamp {
  ids { long light; };
  task t { period 10 ms;
    codel<start> dim(out light) yield go wcet 1 ms;
    codel<go> glow(inout light) yield pause::go;
  };
  activity never() { task t; codel<start> idle(in light) yield ether; };
};
";
    let scenario = "scenario s { use \"lamp.gen\"; check schedulable *; check response *; }\n";
    let directory = Directory::new(&[("lamp.gen", text), ("s.scn", scenario)]);
    let output = directory.run(&["verify", "s.scn"]);
    assert_eq!(status(&output), 3);
    let said = stdout(&output);
    assert!(!said.contains("proved") && said.contains("2 conditional ("), "{said}");
    let condition = "conditional: lamp.t.go has no `wcet` and counts as taking no time";
    assert!(said.contains(condition), "{said}");
    // The codel of an activity that nothing requests is not named.
    assert!(!said.contains("lamp.never"), "{said}");
    let answer = json_of(&directory.run(&["verify", "s.scn", "--format", "json"]));
    for check in answer["checks"].as_array().expect("checks") {
        assert_eq!(check["verdict"], "conditional", "{check}");
        assert_eq!(
            check["conditional"],
            serde_json::json!([{ "missing": "wcet", "codel": "lamp.t.go" }])
        );
    }
}
