//! Specifications without the packages and files that they need, and what stands in for these.

use serde_json::{Value, json};

use crate::directory::{Directory, status, stderr, stdout};

const CLONE: &str = "\
#pragma require \"acme-idl >= 2.0\"
#include \"or/pose/pose_estimator.gen\"
component c {
  uses or_pose_estimator;
  ids { or::t3d::pos at; };
  exception e_bad {};
  function f(in long n) { codel c_f(in n); };
  function g(in long n) { codel c_g(in n, inout at); throw e_bad; };
  task t { codel<start> c_t(in at.x, in pose) yield ether; };
};
";

/// Without the packages that it requires, a specification is compared, and the result says how far.
#[test]
fn codels_of_a_fresh_clone_are_compared() {
    let source = "#include \"c_c_types.h\"\n\n\
        genom_event c_f(int32_t n, int32_t more, const genom_context self) { return genom_ok; }\n\
        genom_event c_g(int32_t n, or_t3d_pos *at, const genom_context self) { return c_e_bad(self); }\n\
        genom_event c_t(double x, const c_pose *pose, const genom_context self) { return c_nowhere; }\n";
    let directory = Directory::new(&[("c.gen", CLONE), ("codels/c_codels.c", source)]);
    let check = |format: &str| {
        let mut command = directory.command(&["codels", "check", "--format", format, "c.gen"]);
        let output = command.env("PKG_CONFIG", "false").output();
        output.expect("the program runs")
    };
    let output = check("json");
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let mut found: Vec<_> = document["diagnostics"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|diagnostic| diagnostic["code"].as_str().unwrap_or_default())
        .collect();
    found.sort_unstable();
    assert_eq!(
        found,
        ["codel/never-yielded", "codel/signature-mismatch", "codel/undeclared-yield"]
    );
    let expected = json!([{
        "file": "c.gen",
        "component": "c",
        "codels": 3,
        "judged": 3,
        "compared": 2,
        "faulty": 0,
        "waiting": [{ "for": "or_pose_estimator", "codels": 1 }],
        "assumed": ["or"],
    }]);
    assert_eq!(document["codels"], expected);
    let text = stdout(&check("text"));
    let said = "c.gen: c: 2 of 3 codels compared; 1 waits for or_pose_estimator";
    assert!(text.contains(said), "{text}");
}

/// Whatever a specification with errors of its own hides, it is not in step.
#[test]
fn codels_of_a_specification_with_errors_are_not_in_step() {
    let text = "component c {\n  function f(in long n) { codel c_f(in n) };\n};\n";
    let source = "#include \"c_c_types.h\"\n";
    let directory = Directory::new(&[("c.gen", text), ("codels/c_codels.c", source)]);
    let output = directory.run(&["codels", "check", "c.gen"]);
    assert_eq!(status(&output), 1, "{}", stdout(&output));
    assert!(stderr(&output).contains("`dotgen check c.gen` shows"));
}

#[test]
fn what_a_specification_needs_and_what_stands_in_for_it() {
    let directory = Directory::new(&[("c.gen", CLONE)]);
    let deps = |arguments: &[&str]| {
        let mut command = directory.command(&[&["deps"][..], arguments, &["c.gen"]].concat());
        let output = command.env("PKG_CONFIG", "false").output();
        output.expect("the program runs")
    };
    let output = deps(&["--format", "json"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!(document["version"], 2);
    let needs = &document["specifications"][0];
    let package = &needs["packages"][0];
    assert_eq!(package["requirement"], "acme-idl >= 2.0");
    assert_eq!(package["brought-by"][0]["robotpkg"], "interfaces/acme-idl");
    assert_eq!(needs["includes"][0]["found"], Value::Null);
    assert_eq!(needs["includes"][0]["searched"], json!(["."]));
    assert_eq!(needs["interfaces"][0]["name"], "or_pose_estimator");
    assert_eq!(needs["unknown"][0]["name"], "or::t3d::pos");

    let output = deps(&["--stand-ins"]);
    assert!(stdout(&output).contains("\n    looked in .\n"));
    let path = directory.path().join(".dotgen/standins/or/pose/pose_estimator.gen");
    let standin = std::fs::read_to_string(path).expect("it was written");
    assert!(standin.contains("interface or_pose_estimator"), "{standin}");
    assert!(standin.contains("port out pose_data pose;"), "{standin}");
    assert!(standin.contains("double x;"), "{standin}");
    let ignored = std::fs::read_to_string(directory.path().join(".dotgen/.gitignore"));
    assert_eq!(ignored.expect("it was written"), "*\n");
    assert!(stdout(&output).contains("created .dotgen/standins/or/pose/pose_estimator.gen"));
    // From now on only the package is missing.
    let mut command =
        directory.command(&["check", "--deny", "missing", "--format", "json", "c.gen"]);
    let output = command.env("PKG_CONFIG", "false").output();
    let text = stdout(&output.expect("the program runs"));
    let document: Value = serde_json::from_str(&text).expect("JSON");
    let errors = document["diagnostics"].as_array().expect("a list").iter();
    let errors: Vec<_> =
        errors.filter(|error| error["severity"] == "error").map(|error| &error["code"]).collect();
    assert_eq!(errors, ["pp-requires-unresolved"]);
}

/// Tasks, services and local variables that only an interface can have.
#[test]
fn a_stand_in_has_the_tasks_and_services_that_are_named() {
    let text = "\
#include \"nav/nav.gen\"
component c {
  version \"1\"; lang \"c\";
  provides nav;
  function halt() { interrupts track; codel c_halt(); };
  activity go(in long n) {
    task motion;
    codel<start> c_go(in n, local inout plan) yield ether;
    interrupts go;
  };
};
";
    let directory = Directory::new(&[("c.gen", text)]);
    let output = directory.run(&["deps", "--stand-ins", "c.gen"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let path = directory.path().join(".dotgen/standins/nav/nav.gen");
    let standin = std::fs::read_to_string(path).expect("it was written");
    insta::assert_snapshot!(standin);
    let output = directory.run(&["check", "--format", "json", "c.gen"]);
    let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let errors = document["diagnostics"].as_array().expect("a list").iter();
    let errors: Vec<_> = errors.filter(|error| error["severity"] == "error").collect();
    assert!(errors.is_empty(), "{errors:#?}");
    let output = directory.run(&["deps", "c.gen"]);
    assert_eq!(status(&output), 0, "{}", stdout(&output));
}

/// Templates of GenoM3 parse a file of their own first.
#[test]
fn each_input_has_its_own_stand_ins() {
    let text = "#include \"x/y.idl\"\ncomponent b { version \"1\"; lang \"c\"; email \"a@b.c\"; ids { x::t v; }; };\n";
    let directory = Directory::new(&[
        ("first/a.gen", "component a { version \"1\"; lang \"c\"; email \"a@b.c\"; };\n"),
        ("second/b.gen", text),
        ("second/.dotgen/standins/x/y.idl", "module x { typedef long t; };\n"),
    ]);
    let output = directory.run(&["generate", "-n", "first/a.gen", "second/b.gen"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
}
