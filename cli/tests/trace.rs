//! `--trace` of `dotgen verify` and `dotgen run`: runs for the trace viewer, and what the JSON of a
//! verification says of causes and remedies.

use serde_json::{Value, json};

use crate::directory::{Directory, status, stderr, stdout};

const LIFT: &str = "\
component lift {
  ids { double level; };
  task control { period 10 ms;
    codel<start> steer(inout level) yield pause::start wcet 3 ms;
  };
  task report { period 20 ms;
    codel<start> tell(in level) yield pause::start wcet 8 ms;
  };
  activity rise() { task control;
    codel<start> up(inout level) yield ether wcet 1 ms;
  };
};
";

const SCENARIO: &str = "\
scenario ride {
  use \"lift.gen\"; semantics SEMANTICS; cores CORES;
  client user { delay [30, 30] ms; send lift.rise; }
  check schedulable *;
}
";

fn lift(semantics: &str, cores: &str) -> Directory {
    let scenario = SCENARIO.replace("SEMANTICS", semantics);
    Directory::new(&[("lift.gen", LIFT), ("ride.scn", &scenario.replace("CORES", cores))])
}

fn trace(folder: &Directory) -> Value {
    let text = std::fs::read_to_string(folder.path().join("out.json")).expect("it was written");
    serde_json::from_str(&text).expect("JSON")
}

/// Whatever an entry refers to is there, times are in order, and what overlaps has rows of its own.
fn consistent(trace: &Value) {
    let list = |name: &str| trace[name].as_array().cloned().expect("a list");
    let (lanes, spans, steps) = (list("lanes"), list("spans"), list("steps"));
    let number = |value: &Value| value.as_f64().expect("a number");
    let index = |value: &Value| value.as_u64().expect("an index") as usize;
    let mut ends = std::collections::BTreeMap::new();
    for span in &spans {
        let key = (index(&span["lane"]), index(&span["row"]));
        assert!(key.1 < index(&lanes[key.0]["rows"]), "{span}");
        assert!(number(&span["from"]) <= number(&span["to"]) && index(&span["step"]) < steps.len());
        let before = ends.insert(key, number(&span["to"]));
        assert!(before.is_none_or(|before| before <= number(&span["from"])), "{span}");
        for holder in span["by"].as_array().into_iter().flatten() {
            assert!(number(&holder["from"]) < number(&span["to"]), "{span}");
        }
    }
    for window in steps.windows(2) {
        assert!(number(&window[0]["at"]) <= number(&window[1]["at"]));
    }
    for step in &steps {
        assert!(trace["rules"][step["rule"].as_str().expect("a word")].is_string());
        assert!(index(&step["lane"]) < lanes.len());
        assert!(
            step.get("place").is_none_or(|place| trace["places"][index(place)]["uri"].is_string())
        );
    }
    for name in ["marks", "arrows"] {
        for json in list(name) {
            assert!(json["step"].is_null() || index(&json["step"]) < steps.len());
        }
    }
}

fn kinds<'t>(trace: &'t Value, of: &str) -> Vec<&'t str> {
    let all = trace[of].as_array().into_iter().flatten();
    all.filter_map(|trace| trace["kind"].as_str()).collect()
}

#[test]
fn a_counterexample_is_written_with_waits_and_the_moment_of_failure() {
    for (semantics, cores) in
        [("published", "2"), ("published", "1"), ("servers", "2"), ("servers", "1")]
    {
        let folder = lift(semantics, cores);
        let out = folder.run(&["verify", "ride.scn", "--trace", "out.json"]);
        assert_eq!(status(&out), 1, "{}", stderr(&out));
        let trace = trace(&folder);
        consistent(&trace);
        let spans = kinds(&trace, "spans");
        // A server asks for its core after its locks.
        let waits =
            if (semantics, cores) == ("published", "1") { "wait-core" } else { "wait-lock" };
        assert!(spans.contains(&waits) && spans.contains(&"hold"), "{semantics} {cores} {spans:?}");
        assert!(kinds(&trace, "marks").contains(&"miss"));
        let all = trace["spans"].as_array().into_iter().flatten();
        let named =
            all.filter(|span| span["kind"] == waits).all(|span| span["by"][0]["name"].is_string());
        assert!(named, "{trace}");
    }
}

#[test]
fn a_recorded_run_has_the_same_form() {
    let folder = lift("servers", "2");
    let arguments = ["run", "ride.scn", "--until", "100ms", "--trace", "out.json"];
    let out = folder.run(&arguments);
    assert!(stdout(&out).contains("steps to out.json"), "{}", stdout(&out));
    let trace = trace(&folder);
    consistent(&trace);
    assert_eq!(trace["end"].as_f64().map(|number| number > 60.0), Some(true));
    // The request goes from the client to the control task, and from there to the task.
    let lanes = |arrow: &Value, end: &str| {
        let lane = arrow[end].as_u64().expect("a lane") as usize;
        trace["lanes"][lane]["kind"].as_str().expect("a word").to_owned()
    };
    let arrows = trace["arrows"].as_array().into_iter().flatten();
    let arrows: Vec<_> = arrows.map(|arrow| (lanes(arrow, "from"), lanes(arrow, "to"))).collect();
    let wanted = [("client", "control"), ("control", "task")];
    for (from, to) in wanted {
        assert!(arrows.contains(&(from.to_owned(), to.to_owned())), "{arrows:?}");
    }
}

#[test]
fn without_a_run_nothing_is_written() {
    let folder = lift("servers", "2");
    let check = [
        "verify",
        "ride.scn",
        "--check",
        "always not lift.rise.start.exec",
        "--durations",
        "fixed",
    ];
    let out =
        folder.run(&[&check[..], &["--cores", "free", "--trace", "/nowhere/out.json"]].concat());
    assert_eq!(status(&out), 2, "{}", stderr(&out));
    let fine = Directory::new(&[
        (
            "a.gen",
            "component a { task t { period 5 ms; codel<start> f() yield pause::start wcet 1 ms; }; };\n",
        ),
        ("a.scn", "scenario a { use \"a.gen\"; check schedulable *; }\n"),
    ]);
    let out = fine.run(&["verify", "a.scn", "--trace", "out.json"]);
    assert_eq!(status(&out), 2);
    assert!(stderr(&out).contains("no check has a run"), "{}", stderr(&out));
    assert!(!fine.path().join("out.json").exists());
}

#[test]
fn json_has_cause_and_remedy_and_the_remedy_holds() {
    let folder = lift("published", "2");
    let ask = || {
        let out = folder.run(&["verify", "ride.scn", "--format", "json"]);
        serde_json::from_str::<Value>(&stdout(&out)).expect("JSON")
    };
    let answer = ask();
    let why = &answer["checks"][0]["why"];
    let parts = why["cause"]["parts"].as_array().expect("parts");
    assert_eq!(
        (&parts[0]["for"], &parts[0]["held-by"]),
        (&json!("lock"), &json!("lift.report.start"))
    );
    let sum: f64 = parts.iter().filter_map(|part| part["time"].as_f64()).sum();
    assert_eq!(json!(sum), why["cause"]["time"], "{why}");
    assert_eq!(why["remedy"]["codel"], "lift.report.start", "{why}");
    let most = why["remedy"]["at-most"].as_f64().expect("a time");
    // That time holds, and the next one does not.
    for (time, verdict) in [(most, "proved"), (most + 1.0, "refuted")] {
        let text = LIFT.replace("wcet 8 ms", &format!("wcet {time} ms"));
        std::fs::write(folder.path().join("lift.gen"), text).expect("it can be written");
        assert_eq!(ask()["checks"][0]["verdict"], verdict, "{time}");
    }
}

#[test]
fn limits_are_looked_for_downwards_where_deadlines_are_missed() {
    let folder = lift("published", "2");
    let out = folder.run(&["verify", "ride.scn", "--sensitivity"]);
    let text = stdout(&out);
    let line = |what: &str| {
        let found = text.lines().find(|line| line.contains(what));
        found.unwrap_or_else(|| panic!("{what}: {text}")).to_owned()
    };
    assert!(
        line("largest WCET    lift.report.start")
            .contains("holds up to 5.8 ms (now 8 ms, to 200 µs)")
    );
    assert!(line("largest WCET    lift.rise.start").ends_with("missed already (now 1 ms)"));
    assert!(line("smallest period lift.control").contains("holds from 1"));
    assert!(
        text.contains("cause `control` waits 8 ms for `level` of the ids, held by `tell`"),
        "{text}"
    );
    assert!(text.contains("help it holds if `tell` takes at most 5.8 ms"), "{text}");
}

/// The edits of the changes that repair it, each made alone by a program that knows nothing but the JSON.
#[test]
fn changes_that_repair_a_system_carry_edits_that_do() {
    let check = |folder: &Directory, more: &[&str]| {
        let arguments = [&["verify", "ride.scn", "--format", "json"], more].concat();
        serde_json::from_str::<Value>(&stdout(&folder.run(&arguments))).expect("JSON")
    };
    let found = check(&lift("published", "2"), &["--sensitivity"]);
    let changes = found["repairs"]["changes"].as_array().expect("a list");
    let mut kinds = Vec::new();
    for change in changes {
        let Some(edit) = change["edit"].as_object() else {
            continue;
        };
        let folder = lift("published", "2");
        let name = std::path::Path::new(edit["file"].as_str().expect("a file"));
        let path = folder.path().join(name.file_name().expect("a name"));
        let mut text = std::fs::read_to_string(&path).expect("it can be read");
        let place = |at: usize| edit["range"][at].as_u64().expect("a place") as usize;
        let new = edit["text"].as_str().expect("text");
        text.replace_range(place(0)..place(1), new);
        std::fs::write(&path, text).expect("it can be written");
        let after = check(&folder, &[]);
        let checks = after["checks"].as_array().expect("checks");
        assert!(
            !checks.is_empty() && checks.iter().all(|check| check["verdict"] == "proved"),
            "{change}: {after:#}"
        );
        kinds.push(change["change"].as_str().unwrap_or_default().to_owned());
    }
    for kind in ["wcet", "period"] {
        assert!(kinds.iter().any(|candidate| candidate == kind), "{kinds:?}");
    }
    let locks = changes.iter().find(|change| change["change"] == "lock");
    let lock = locks.expect("the codels can be separated");
    assert_eq!(lock["through"], json!(["`level` of the ids"]));
}
