//! `dotgen query`.

use serde_json::Value;

use crate::directory::Directory;

const PUMP: &str = include_str!("../../examples/pump/pump.gen");

fn query(arguments: &[&str]) -> (String, String, Option<i32>) {
    let directory = Directory::new(&[("pump.gen", PUMP)]);
    let output = directory.run(&[&["query"], arguments].concat());
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (text(output.stdout), text(output.stderr), output.status.code())
}

fn json(name: &str) -> Value {
    let (text, _, code) = query(&[name, "--format", "json"]);
    assert_eq!(code, Some(0), "{name}");
    let mut answer: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(answer["version"], 1);
    answer["declarations"].take()
}

#[test]
fn a_declaration_is_described() {
    insta::assert_snapshot!(query(&["fill"]).0);
}

#[test]
fn a_state_of_an_activity_has_the_uses_in_the_activity() {
    let all = json("start");
    let one = json("pump.fill.start");
    assert_eq!(all[0]["name"], one[0]["name"]);
    let lines = |json: &Value| -> Vec<u64> {
        let uses = json[0]["uses"].as_array().expect("uses");
        uses.iter().filter_map(|usage| usage["line"].as_u64()).collect()
    };
    assert_eq!(lines(&one), [33]);
    assert!(lines(&all).len() > 1, "{all}");
}

#[test]
fn the_end_of_a_qualified_name_is_enough() {
    for name in ["control", "pump.control", "pump::control"] {
        assert_eq!(json(name)[0]["name"], "pump.control");
    }
}

#[test]
fn an_unknown_name_is_an_error_with_a_suggestion() {
    let (out, error, code) = query(&["pump.contrl"]);
    assert_eq!((out.as_str(), code), ("", Some(1)));
    assert_eq!(error, "error: nothing is named `pump.contrl`; did you mean `control`?\n");
}

#[test]
fn a_name_without_letters_is_refused() {
    for name in ["", ".", "::"] {
        let (out, error, code) = query(&[name]);
        assert_eq!((out.as_str(), code), ("", Some(2)), "{name}");
        assert_eq!(error, format!("error: `{name}` is not a name\n"));
    }
}

#[test]
fn a_file_that_folders_share_is_described_once() {
    let user = |name: &str| {
        format!("#include \"../types.idl\"\ncomponent {name} {{ ids {{ pos at; }}; }};\n")
    };
    let directory = Directory::new(&[
        ("types.idl", "struct pos { double x; };\n"),
        ("a/a.gen", &user("a")),
        ("a/dotgen.toml", ""),
        ("b/b.gen", &user("b")),
        ("b/dotgen.toml", ""),
    ]);
    let output = directory.run(&["query", "pos", "--format", "json"]);
    let answer: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let declarations = answer["declarations"].as_array().expect("a list");
    assert_eq!(declarations.len(), 1, "{answer}");
    let uses = declarations[0]["uses"].as_array().expect("uses");
    let files: Vec<&str> = uses.iter().filter_map(|usage| usage["file"].as_str()).collect();
    assert_eq!(files, ["a/a.gen", "b/b.gen"]);
}
