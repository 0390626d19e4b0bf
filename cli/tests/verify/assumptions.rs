//! Assumptions, and checks that need execution times.

use super::{VAGUE, json_of};
use crate::directory::{Directory, stderr};

#[test]
fn what_is_assumed_is_told_once_where_it_stands() {
    let directory = Directory::new(&[
        ("vague.gen", VAGUE),
        (
            "vague.scn",
            "scenario vague {\n  use \"vague.gen\"; semantics published;\n  loop free vague.spin;\n  duration vague.poll.start [0,1] ms;\n  check always not vague.spin.d;\n}\n",
        ),
        (
            "stuck.scn",
            "scenario stuck {\n  use \"vague.gen\"; semantics published;\n  loop 2;\n  check schedulable *;\n}\n",
        ),
        (
            "long.scn",
            "scenario long {\n  use \"vague.gen\"; semantics published;\n  duration vague.poll.start [1,9000000000] s;\n  duration vague.spin.b [1,1] us;\n  check schedulable *;\n}\n",
        ),
    ]);
    directory.write("zero.gen", VAGUE.replace("20 ms", "0 ms").as_bytes());
    let mut told = String::new();
    for file in ["vague.gen", "vague.scn", "stuck.scn", "long.scn", "zero.gen"] {
        let output = directory.run(&["verify", "--max-states", "10", file]);
        told.push_str(&format!("$ dotgen verify {file}\n{}\n", stderr(&output)));
    }
    insta::assert_snapshot!(told);
}

#[test]
fn programs_are_told_everything_in_the_document() {
    let directory = Directory::new(&[("vague.gen", VAGUE)]);
    let output = directory.run(&["verify", "--max-states", "10", "--format", "json", "vague.gen"]);
    assert_eq!(stderr(&output), "");
    let document = json_of(&output);
    let all = document["diagnostics"].as_array().expect("a list");
    let said: Vec<String> = all
        .iter()
        .map(|diagnostic| {
            let start = &diagnostic["range"]["start"];
            format!(
                "{}:{}:{} {}: {}",
                diagnostic["file"].as_str().unwrap_or_default(),
                start["line"],
                start["character"],
                diagnostic["code"].as_str().unwrap_or_default(),
                diagnostic["message"].as_str().unwrap_or_default()
            )
        })
        .collect();
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn what_is_assumed_has_the_severity_that_is_set() {
    let severity = "[severity]\ntiming-no-wcet = \"off\"\ntiming-state-cycle = \"hint\"\n";
    let directory = Directory::new(&[("vague.gen", VAGUE), ("dotgen.toml", severity)]);
    let run = ["verify", "--max-states", "10", "vague.gen"];
    let told = stderr(&directory.run(&run));
    assert!(!told.contains("no-wcet"), "{told}");
    assert!(told.contains("hint[timing-state-cycle]"), "{told}");
    let output = directory.run(&[&run[..], &["--format", "json"]].concat());
    let document = json_of(&output);
    let all = document["diagnostics"].as_array().expect("a list").iter();
    let all: Vec<_> =
        all.map(|diagnostic| (&diagnostic["code"], &diagnostic["severity"])).collect();
    assert!(!all.is_empty());
    for pair in all {
        assert_eq!(pair, (&"timing-state-cycle".into(), &"hint".into()));
    }
}
