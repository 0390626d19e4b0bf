//! Fixes that `dotgen check` makes, shows and reports.

use serde_json::{Value, json};

use crate::directory::{Directory, status, stderr, stdout};

/// Slips with one plain repair each, and one that can only be guessed.
const SLIPS: &str = "\
component c {
  version \"1\"
  ids { bool on; };
  tsak t {
    period 100 Hz;
    codel<start> f(out on) yield ether, ether;
  };
  activity a() { task t; codel<start> g(in onn) yield ether; };
};
";

fn text_of(directory: &Directory) -> String {
    std::fs::read_to_string(directory.path().join("c.gen")).expect("it is there")
}

#[test]
fn plain_repairs_are_made_and_the_rest_is_reported() {
    let directory = Directory::new(&[("c.gen", SLIPS)]);
    let diff = directory.run(&["check", "--diff", "c.gen"]);
    assert_eq!(status(&diff), 1);
    let shown = stdout(&diff);
    for line in ["-  tsak t {\n", "+  task t {\n", "-    period 100 Hz;\n", "+    period 10 ms;\n"]
    {
        assert!(shown.contains(line), "{shown}");
    }
    assert_eq!(text_of(&directory), SLIPS, "--diff changes nothing");

    let fixed = directory.run(&["check", "--fix", "--format", "json", "c.gen"]);
    assert_eq!(status(&fixed), 1);
    let told = stderr(&fixed);
    assert!(told.contains("note: fixed `c.gen`: "), "{told}");
    assert!(told.contains("insert `;`"), "{told}");
    let right = SLIPS
        .replace("version \"1\"", "version \"1\";")
        .replace("bool", "boolean")
        .replace("tsak", "task")
        .replace("100 Hz", "10 ms")
        .replace("ether, ether", "ether");
    assert_eq!(text_of(&directory), right);
    let document: Value = serde_json::from_str(&stdout(&fixed)).expect("JSON");
    assert_eq!(document["version"], 1);
    let left = document["diagnostics"].as_array().expect("a list");
    let errors: Vec<&Value> =
        left.iter().filter(|diagnostic| diagnostic["severity"] == "error").collect();
    assert_eq!(errors.len(), 1, "{errors:#?}");
    assert_eq!(errors[0]["code"], "param-unknown");
    let fix = &errors[0]["fixes"][0];
    assert_eq!((&fix["title"], &fix["safe"]), (&json!("Change to `on`"), &json!(false)));
    assert_eq!(fix["edits"][0]["newText"], "on");

    let again = directory.run(&["check", "--diff", "c.gen"]);
    assert_eq!((status(&again), stdout(&again).as_str()), (0, ""));
}

#[test]
fn misspelt_words_and_names_of_a_scenario_are_corrected() {
    let specification = "component c { task main { period 10 ms; }; };\n";
    let wrong = "scenario s {\n  use \"c.gen\";\n  coers 2;\n  check schedulable c.mian;\n  check quick c.main;\n}\n";
    let directory = Directory::new(&[("c.gen", specification), ("s.scn", wrong)]);
    let text = || std::fs::read_to_string(directory.path().join("s.scn")).expect("it is there");
    let diff = directory.run(&["check", "--diff", "s.scn"]);
    assert_eq!(status(&diff), 1);
    assert!(stdout(&diff).contains("+  cores 2;\n"), "{}", stdout(&diff));
    assert_eq!(text(), wrong, "--diff changes nothing");
    let fixed = directory.run(&["check", "--fix", "s.scn"]);
    // No check is near to this word.
    assert_eq!(status(&fixed), 1);
    assert_eq!(text(), wrong.replace("coers", "cores"), "{}", stderr(&fixed));
    let right = wrong.replace("  check quick c.main;\n", "");
    directory.write("s.scn", right.as_bytes());
    // A name is a guess: the scenario would check another task.
    let fixed = directory.run(&["check", "--fix", "s.scn"]);
    assert_eq!(status(&fixed), 1);
    assert_eq!(text(), right.replace("coers", "cores"));
    assert_eq!(status(&directory.run(&["check", "--unsafe-fixes", "s.scn"])), 2);
    directory.write("s.scn", right.as_bytes());
    let fixed = directory.run(&["check", "--fix", "--unsafe-fixes", "s.scn"]);
    assert_eq!(status(&fixed), 0, "{}", stderr(&fixed));
    assert_eq!(text(), right.replace("coers", "cores").replace("mian", "main"));
    assert!(stderr(&fixed).contains("note: fixed `s.scn`: "), "{}", stderr(&fixed));
}

#[test]
fn sarif_has_the_fixes() {
    let directory = Directory::new(&[("c.gen", SLIPS)]);
    let output = directory.run(&["check", "--format", "sarif", "c.gen"]);
    let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let results = document["runs"][0]["results"].as_array().expect("a list");
    let fixes = results.iter().find_map(|json| json.get("fixes")).expect("fixes");
    assert_eq!(fixes[0]["properties"]["safe"], true);
    let change = &fixes[0]["artifactChanges"][0];
    assert_eq!(change["artifactLocation"]["uri"], "c.gen");
    assert!(change["replacements"][0]["deletedRegion"]["startLine"].is_u64());
}
