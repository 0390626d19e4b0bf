//! Files of worst cases, as laboratories keep them beside a specification.

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};

const SPEC: &str = "\
component rover {
  version \"1.0\"; lang \"c\";
  ids { double speed; };
  task track {
    period 100 ms;
    codel<start> rover_InitIDS(out speed) yield pause::main;
    codel<main> rover_ComputeWheelWhenLost(inout speed) yield pause::main;
  };
};
";

const TIMES: &str = "\
rover_InitIDS 0.004
rover_ComputeSpeedWhenLost 0.0125
rover_genom_kill_codel 0.001
";

fn right() -> String {
    TIMES.replace("ComputeSpeed", "ComputeWheel")
}

fn assumptions(directory: &Directory, arguments: &[&str]) -> (String, Vec<String>) {
    let run = directory.run(&[&["verify", "--format", "json"], arguments].concat());
    let report: Value = serde_json::from_str(&stdout(&run)).expect("JSON");
    let all = report["assumptions"].as_array().expect("a list").iter();
    let all = all.filter_map(Value::as_str).filter(|text| text.starts_with("times"));
    (report["checks"][0]["verdict"].to_string(), all.map(str::to_owned).collect())
}

#[test]
fn a_file_beside_the_specification_gives_the_times_and_is_named() {
    let directory = Directory::new(&[("rover.gen", SPEC)]);
    let (without, none) = assumptions(&directory, &["rover.gen"]);
    assert_eq!((without.as_str(), none), ("\"nothing\"", Vec::new()));
    directory.write("rover.wcet", right().as_bytes());
    let (verdict, times) = assumptions(&directory, &["rover.gen"]);
    let expected = "times: 2 codels have their worst case from `rover.wcet`";
    assert_eq!((verdict.as_str(), &times[..]), ("\"proved\"", &[expected.to_owned()][..]));
}

#[test]
fn a_scenario_names_a_file_whose_names_are_checked() {
    let scenario = "scenario s { use \"rover.gen\"; times \"all.wcet\"; check schedulable *; }\n";
    let directory = Directory::new(&[("rover.gen", SPEC), ("s.scn", scenario)]);
    let run = directory.run(&["check", "s.scn"]);
    assert_eq!(status(&run), 1);
    assert!(stdout(&run).contains("cannot read `all.wcet`"), "{}", stdout(&run));
    directory.write("all.wcet", TIMES.as_bytes());
    let run = directory.run(&["check", "s.scn"]);
    let text = stdout(&run);
    assert!(text.contains("no codel has the function `rover_ComputeSpeedWhenLost`"), "{text}");
    assert!(text.contains("there is `rover_ComputeWheelWhenLost`"), "{text}");
    assert!(text.contains("all.wcet:2"), "{text}");
    assert!(!text.contains("genom_kill"), "{text}");
    directory.write("all.wcet", b"rover_InitIDS soon\n");
    let run = directory.run(&["verify", "s.scn"]);
    assert_eq!(status(&run), 2);
    assert!(stderr(&run).contains("no time in seconds"), "{}", stderr(&run));
}

#[test]
fn a_malformed_file_that_nobody_named_prevents_nothing() {
    let directory = Directory::new(&[("rover.gen", SPEC), ("rover.wcet", "notes of last week\n")]);
    let run = directory.run(&["verify", "rover.gen"]);
    assert!(stderr(&run).contains("the file is left out"), "{}", stderr(&run));
    assert_eq!(status(&run), 3, "its codels have no time");
    directory.write("rover.wcet", b"\xff\xfe\xfd 1\n");
    let run = directory.run(&["verify", "rover.gen"]);
    assert!(stderr(&run).contains("the file is left out"), "{}", stderr(&run));
}

#[test]
fn worst_cases_become_clauses_without_a_margin() {
    let directory = Directory::new(&[("rover.gen", SPEC), ("rover.wcet", TIMES)]);
    let run = directory.run(&["wcet", "import", "rover.wcet", "rover.gen"]);
    let text = stdout(&run);
    assert!(text.contains("`rover.wcet`: read as worst cases in seconds"), "{text}");
    assert!(text.contains("there is `rover_ComputeWheelWhenLost`"), "{text}");
    assert!(text.contains("1 line of codels that GenoM3 adds"), "{text}");
    assert!(directory.read("rover.gen").contains("yield pause::main wcet 4 ms;"));
    directory.write("rover.wcet", right().as_bytes());
    let run = directory.run(&["wcet", "import", "rover.wcet", "rover.gen", "--format", "json"]);
    let report: Value = serde_json::from_str(&stdout(&run)).expect("JSON");
    assert_eq!(report["given"], serde_json::json!({ "unknown": [], "internal": 1 }));
    assert!(directory.read("rover.gen").contains("yield pause::main wcet 12500 us;"));
}

#[test]
fn logs_become_the_files_of_published_templates() {
    let log = "\
0.000000000 0.000000000 0.002000000 rover track <permanent> rover_InitIDS ::rover::start ::rover::pause::main
0.100000000 0.100000000 0.101000000 rover track <permanent> rover_ComputeWheelWhenLost ::rover::main ::rover::pause::main
0.200000000 0.200000000 0.202500000 rover track <permanent> rover_ComputeWheelWhenLost ::rover::main ::rover::pause::main
0.300000000 0.300000000 0.301000000 rover track go rover_Go ::rover::start ::rover::ether
";
    let directory = Directory::new(&[("run.out", log)]);
    let text = |format| stdout(&directory.run(&["wcet", "stats", "run.out", "--format", format]));
    assert_eq!(
        text("wcet"),
        "rover_ComputeWheelWhenLost 0.0025\nrover_Go 0.001\nrover_InitIDS 0.002\n"
    );
    assert_eq!(
        text("proba"),
        "track::rover_main::rover_pause_main 2\n\
         track::rover_start::rover_pause_main 1\n\
         go::rover_start::rover_ether 1\n"
    );
}
