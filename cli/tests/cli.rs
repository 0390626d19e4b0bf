//! The built program, run as users and scripts run it.

use std::process::Command;

use serde_json::{Value, json};

use crate::directory::{Directory, status, stderr, stdout};

const POSE: &str = "struct pose {\n  double x, y, theta;\n};\n";

const ARM: &str = "\
#include <pose.idl>

component arm {
  version \"1.0\";
  port in pose goal;
  ids { pose state; };

  task motion {
    period 5 ms;
    codel<start> init(port in gaol, out ::ids) yield ether;
  };

  attribute set_state(in state);
  attribute set_state2(in sate);
};
";

#[test]
fn a_specification_in_order() {
    let directory = Directory::new(&[("arm.gen", "#include \"pose.idl\"\n"), ("pose.idl", POSE)]);
    let output = directory.run(&["check", "arm.gen"]);
    assert_eq!(stdout(&output), "checked 1 file: no problems\n");
    assert_eq!(stderr(&output), "");
    assert_eq!(status(&output), 0);
}

#[test]
fn errors_as_text() {
    let directory = Directory::new(&[("arm.gen", ARM), ("idl/pose.idl", POSE)]);
    let output = directory.run(&["check", "-Iidl", "arm.gen"]);
    assert_eq!(status(&output), 1);
    insta::assert_snapshot!(stdout(&output));
}

#[test]
fn errors_as_json_count_as_the_lsp_does() {
    let text = "/* é😀 */ const long a = 1; const long a = 2;\n";
    let directory = Directory::new(&[("arm.gen", text)]);
    let output = directory.run(&["check", "--format", "json", "arm.gen"]);
    assert_eq!(status(&output), 1);
    let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let diagnostics = document["diagnostics"].as_array().expect("a list");
    assert_eq!(diagnostics.len(), 1);
    let found = &diagnostics[0];
    let range = |start: u32, end: u32| json!({ "start": { "line": 0, "character": start }, "end": { "line": 0, "character": end } });
    assert_eq!(found["file"], "arm.gen");
    assert_eq!(found["severity"], "error");
    assert_eq!(found["code"], "name-clash");
    assert_eq!(found["range"], range(39, 40));
    assert_eq!(found["related"][0]["file"], "arm.gen");
    assert_eq!(found["related"][0]["range"], range(21, 22));
    assert!(found["message"].is_string() && found["related"][0]["message"].is_string());
}

#[test]
fn errors_as_sarif() {
    let directory = Directory::new(&[("a dir/arm.gen", "const long a = 1;\nconst long a = 2;\n")]);
    let output = directory.run(&["check", "--format=sarif", "a dir"]);
    assert_eq!(status(&output), 1);
    let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!(document["version"], "2.1.0");
    let run = &document["runs"][0];
    let rule = &run["tool"]["driver"]["rules"][0];
    assert_eq!(rule["id"], "name-clash");
    let summary = rule["shortDescription"]["text"].as_str().expect("text");
    assert!(summary.ends_with('.') && !summary.contains('\n'), "{summary}");
    assert!(rule["help"]["markdown"].as_str().expect("text").starts_with("# name-clash"));
    // Where the manual is installed concerns no other machine.
    assert!(!stdout(&output).contains("file:"), "{}", stdout(&output));
    let result = &run["results"][0];
    assert_eq!(result["level"], "error");
    let place = &result["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "a%20dir/arm.gen");
    assert_eq!(place["region"]["startLine"], 2);
    assert_eq!(place["region"]["startColumn"], 12);
    assert!(result["relatedLocations"][0]["message"]["text"].is_string());
}

#[test]
fn a_directory_stands_for_its_specifications() {
    let directory = Directory::new(&[
        ("a/arm.gen", "#include \"part.gen\"\n"),
        // Makes sense only where it is included.
        ("a/part.gen", "#ifndef OK\n#define OK\n#endif\nconst long a = 1;\n"),
        ("b/leg.gen", "const long a = 1;\n"),
        ("b/not.idl", "const long a = 1\n"),
        (".git/x.gen", "const long a = 1\n"),
    ]);
    let output = directory.run(&["check", "."]);
    assert_eq!(stdout(&output), "checked 2 files: no problems\n");
    let output = directory.run(&["check", "a/part.gen", "a", "a/arm.gen"]);
    assert_eq!(stdout(&output), "checked 2 files: no problems\n");
}

#[test]
fn a_fault_in_a_shared_file_is_told_once() {
    let directory = Directory::new(&[
        ("a.gen", "#include \"pose.idl\"\n"),
        ("b.gen", "#include \"pose.idl\"\n"),
        ("pose.idl", "const long a = 1;\nconst long a = 1;\n"),
    ]);
    let output = directory.run(&["check", "."]);
    let text = stdout(&output);
    assert_eq!(text.matches("error[name-clash]").count(), 1, "{text}");
    assert!(text.ends_with("checked 2 files: 1 error\n"), "{text}");
}

#[test]
fn macros_and_include_directories_come_attached_or_not() {
    let text =
        "#include <pose.idl>\n#if N != 3 || !defined(FLAG) || FLAG != 1\n#error no\n#endif\n";
    let directory = Directory::new(&[("arm.gen", text), ("idl/pose.idl", POSE)]);
    for arguments in [
        &["check", "-Iidl", "-DN=3", "-DFLAG", "arm.gen"][..],
        &["check", "-I", "idl", "-D", "N=3", "-D", "FLAG", "arm.gen"],
        &["check", "arm.gen", "-I", "nowhere", "-Iidl", "-DN=2", "-DN=3", "-DFLAG=1"],
    ] {
        let output = directory.run(arguments);
        assert_eq!(status(&output), 0, "{arguments:?}: {}", stdout(&output));
    }
    assert_eq!(status(&directory.run(&["check", "arm.gen"])), 1);
}

#[test]
fn the_configuration_file_counts_below_the_command_line() {
    let text = "#include <pose.idl>\n#if N != 3\n#error no\n#endif\n";
    let directory = Directory::new(&[
        ("robot/arm/arm.gen", text),
        ("robot/idl/pose.idl", POSE),
        ("robot/dotgen.toml", "include-paths = ['idl']\ndefines = { N = 3 }\n"),
    ]);
    assert_eq!(status(&directory.run(&["check", "robot/arm/arm.gen"])), 0);
    assert_eq!(status(&directory.run(&["check", "-DN=4", "robot"])), 1);

    directory.write("robot/dotgen.toml", b"include-paths = ['idl']\ndefine = { N = 3 }\n");
    let output = directory.run(&["check", "robot"]);
    assert_eq!(status(&output), 1);
    insta::assert_snapshot!(stdout(&output));
}

#[test]
fn packages_are_found_by_the_program_or_without_it() {
    let directory = Directory::new(&[
        ("arm.gen", "#pragma requires \"pose-idl >= 1\"\n#include <pose.idl>\n"),
        ("inc/pose.idl", POSE),
        (
            "pc/pose-idl.pc",
            "Name: pose\nDescription: Poses\nVersion: 1.2\nCflags: -I${pcfiledir}/../inc\n",
        ),
    ]);
    let path = directory.path().join("pc");
    for program in ["pkg-config", "/no/such/program"] {
        let mut command = directory.command(&["check", "arm.gen"]);
        command.env("PKG_CONFIG", program).env("PKG_CONFIG_PATH", &path);
        let output = command.output().expect("the program runs");
        assert_eq!(status(&output), 0, "{program}: {}", stdout(&output));
    }
    let mut command = directory.command(&["check", "arm.gen", "--deny", "missing"]);
    let output = command.env("PKG_CONFIG", "false").output();
    let text = stdout(&output.expect("the program runs"));
    assert!(text.contains("error[pp-requires-unresolved]"), "{text}");
}

/// A package that is not installed is no error of the text, and hides nothing but what comes from there.
#[test]
fn a_missing_package_is_a_warning_and_hides_no_error() {
    let check = |text: &str, deny: &str| {
        let directory = Directory::new(&[("c.gen", text)]);
        let mut command = directory.command(&["check", "c.gen"]);
        command.env("PKG_CONFIG", "false").env("DOTGEN_DENY", deny);
        command.output().expect("the program runs")
    };
    let right = "\
#pragma require \"nav-idl\"
component c {
  uses nav;
  ids { nav_types::pose goal; long count; };
  task t { period 5 ms; codel<start> f(inout count, out goal) yield ether; };
};
";
    let output = check(right, "");
    let text = stdout(&output);
    assert_eq!(status(&output), 0, "{text}");
    assert!(text.contains("warning[pp-requires-unresolved]"), "{text}");
    assert!(text.contains("; 2 names wait for nav-idl"), "{text}");
    assert_eq!(status(&check(right, "missing")), 1);
    for (from, to, code) in [
        ("long count;", "int count;", "unknown-type"),
        ("inout count", "inout cuont", "param-unknown"),
        ("yield ether", "yield nowhere", "fsm/undefined-state"),
        ("out goal)", "out count.x)", "param-member"),
    ] {
        // What an interface may bring is not known while one is used that is not there.
        let text = right.replace("  uses nav;\n", "").replace(from, to);
        let output = check(&text, "");
        assert_eq!(status(&output), 1, "{to}: {}", stdout(&output));
        assert!(stdout(&output).contains(&format!("error[{code}]")), "{to}: {}", stdout(&output));
    }
}

#[test]
fn wrong_usage_and_files_that_cannot_be_read() {
    let directory = Directory::new(&[
        ("empty/readme", ""),
        ("two/a.gen", ""),
        ("two/b.gen", ""),
        ("codels.c", ""),
    ]);
    directory.write("latin.gen", b"// caf\xe9\n");
    for (arguments, message) in [
        (&["tree"][..], "required arguments were not provided"),
        (&["check", "--format", "xml", "x.gen"], "invalid value 'xml'"),
        (&["chekc", "x.gen"], "unrecognized subcommand"),
        (&["check", "missing.gen"], "cannot read `missing.gen`: no such file or directory"),
        (&["check", "empty"], "no .gen file below `empty`"),
        (&["tree", "empty"], "no .gen file below `empty`"),
        (&["model", "two"], "`two` has 2 specifications; name one: "),
        (
            &["check", "codels.c"],
            "`codels.c` is a source of codels, not a specification; `dotgen codels check`",
        ),
        (&["diagram", "fsm", "latin.gen", "-o", "x.jpg"], "there is no picture format `jpg`"),
        (&["check", "--fxi", "x.gen"], "'--fix'"),
        (&["wcet", "stats", "x.out"], "cannot read `x.out`: no such file or directory"),
        (&["model", "missing.gen"], "cannot read `missing.gen`"),
    ] {
        let output = directory.run(arguments);
        assert_eq!(status(&output), 2, "{arguments:?}");
        let text = stderr(&output);
        assert!(text.contains(message), "{arguments:?}: {text}");
        assert_eq!(stdout(&output), "");
    }
    // It is there, but no UTF-8: a diagnostic.
    let text = stdout(&directory.run(&["check", "latin.gen"]));
    assert!(text.contains("latin.gen:1:"), "{text}");
}

#[test]
fn includes_that_are_no_files_are_diagnostics() {
    let directory = Directory::new(&[
        ("arm.gen", "#include \"dir\"\n"),
        ("dir/x.idl", ""),
        ("self.gen", "#include \"self.gen\"\n"),
    ]);
    for file in ["arm.gen", "self.gen"] {
        let output = directory.run(&["check", "--deny", "missing", file]);
        assert_eq!(status(&output), 1, "{}", stdout(&output));
        assert!(stdout(&output).contains("error[pp-include-"), "{}", stdout(&output));
    }
}

#[test]
fn colours_only_where_they_are_wanted() {
    let directory = Directory::new(&[("arm.gen", "const long a = 1\n")]);
    let coloured = |command: &mut Command| {
        let output = command.output().expect("the program runs");
        stdout(&output).contains('\u{1b}')
    };
    assert!(!coloured(&mut directory.command(&["check", "arm.gen"])), "a pipe");
    let mut forced = directory.command(&["check", "arm.gen"]);
    assert!(coloured(forced.env("CLICOLOR_FORCE", "1")), "asked for");
    let mut refused = directory.command(&["check", "arm.gen"]);
    refused.env("CLICOLOR_FORCE", "1").env("NO_COLOR", "1");
    assert!(!coloured(&mut refused), "refused");
}

#[test]
fn tree_and_model_are_printed() {
    let directory = Directory::new(&[("pose.gen", POSE), ("bad.gen", "struct s { nope x; };\n")]);
    let output = directory.run(&["tree", "pose.gen"]);
    assert_eq!(status(&output), 0);
    assert!(stdout(&output).contains("STRUCT"), "{}", stdout(&output));
    let output = directory.run(&["model", "pose.gen"]);
    assert_eq!(status(&output), 0);
    let model: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert!(model["types"].is_array() || model["types"].is_object());
    let output = directory.run(&["model", "bad.gen"]);
    assert_eq!(status(&output), 1);
    assert!(stderr(&output).contains("error[unknown-type]"));
    assert!(serde_json::from_str::<Value>(&stdout(&output)).is_ok());
}

#[test]
fn the_version_is_known() {
    let directory = Directory::new(&[]);
    let output = directory.run(&["--version"]);
    let expected = format!("dotgen {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!((stdout(&output), status(&output)), (expected, 0));
}

#[test]
fn differences_of_codels_name_files_from_here() {
    let spec = "component c { ids { long x; }; task t { codel<start> f(in x) yield ether; }; };\n";
    let directory = Directory::new(&[("sub/c.gen", spec)]);
    let output = directory.run(&["codels", "stub", "--dry-run", "sub/c.gen"]);
    let diff = stdout(&output);
    let expected = "--- /dev/null\n+++ b/sub/codels/c_t_codels.c\n@@";
    assert!(diff.contains(expected), "{diff}{}", stderr(&output));
}

#[test]
fn formatting_in_place_and_as_a_check() {
    let ugly = "struct  a { long x ; } ;\n";
    let directory = Directory::new(&[("a.gen", ugly), ("sub/b.idl", "typedef  long t;\n")]);
    let check = directory.run(&["fmt", "--check"]);
    assert_eq!(status(&check), 1, "{}", stderr(&check));
    let diff = stdout(&check);
    assert!(diff.contains("--- a.gen\n+++ a.gen\n@@"), "{diff}");
    assert!(diff.contains("-typedef  long t;\n+typedef long t;\n"), "{diff}");
    let read = |name: &str| std::fs::read_to_string(directory.path().join(name)).expect("a file");
    assert_eq!(read("a.gen"), ugly, "--check changes nothing");

    let done = directory.run(&["fmt", "a.gen", "sub"]);
    assert_eq!((status(&done), stdout(&done).as_str()), (0, ""));
    assert_eq!(read("sub/b.idl"), "typedef long t;\n");
    assert_ne!(read("a.gen"), ugly);
    assert_eq!(status(&directory.run(&["fmt", "--check"])), 0);
}

#[test]
fn formatting_what_cannot_be_formatted() {
    let broken = "struct  a { long ; };\n";
    let directory = Directory::new(&[("a.gen", broken)]);
    directory.write("b.gen", b"typedef  long t; // \xe9\n");
    assert_eq!(status(&directory.run(&["fmt", "a.gen"])), 0);
    let text = std::fs::read_to_string(directory.path().join("a.gen")).expect("a file");
    assert_eq!(text, broken, "what does not parse stays");
    let output = directory.run(&["fmt", "b.gen"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let bytes = std::fs::read(directory.path().join("b.gen")).expect("a file");
    assert_eq!(bytes, b"typedef long t; // \xe9\n", "other bytes stay");
    assert_eq!(status(&directory.run(&["fmt", "missing.gen"])), 2);
}

#[test]
fn generating_heeds_the_configuration() {
    let spec = "#include \"pose.idl\"\n#ifdef REAL\ncomponent arm { version \"1.0\"; };\n#endif\n";
    let files = [
        ("p/arm.gen", spec),
        ("p/idl/pose.idl", POSE),
        (
            "p/dotgen.toml",
            "include-paths = [\"idl\"]\ntemplate-paths = [\"t\"]\n[defines]\nREAL = true\n",
        ),
        ("p/t/mine/template.tcl", "puts mine\n"),
    ];
    let directory = Directory::new(&files);
    let output = directory.run(&["generate", "json-schema", "p/arm.gen"]);
    assert_eq!(stdout(&output), "creating p/arm.schema.json\n");
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let list = |name: &str| {
        let mut command = directory.command(&[name, "-l"]);
        command.current_dir(directory.path().join("p"));
        let output = command.output().expect("the program runs");
        stdout(&output).lines().any(|line| line == "mine")
    };
    assert!(list("generate"));
    // Stands in for another program, which knows no dotgen.toml.
    assert!(!list("genom3"));
    let output = directory.run(&["genom3", "-n", "p/arm.gen"]);
    assert!(stderr(&output).contains("pose.idl"), "{}", stderr(&output));
}

#[test]
fn scenarios_are_checked_and_formatted() {
    let spec = "component c { task t { period 10 ms; codel<start> f() yield pause::start wcet 1 ms; }; };\n";
    let directory = Directory::new(&[
        ("c.gen", spec),
        ("good.scn", "scenario s {\n  use \"c.gen\";\n  check schedulable c.t;\n}\n"),
        ("bad.scn", "scenario s {\n  use \"c.gen\";\n  check schedulable c.u;\n}\n"),
        ("ugly.scn", "scenario  s {\nuse \"c.gen\" ;\n}\n"),
        ("broken.scn", "scenario  s {\nuse\n}\n"),
    ]);
    let output = directory.run(&["check", "good.scn"]);
    assert_eq!(stdout(&output), "checked 1 file: no problems\n");
    let output = directory.run(&["check", "bad.scn"]);
    assert!(stdout(&output).contains("error[scn-unknown-name]"), "{}", stdout(&output));
    assert_eq!(status(&output), 1);

    assert_eq!(status(&directory.run(&["fmt", "--check", "ugly.scn"])), 1);
    assert_eq!(status(&directory.run(&["fmt", "ugly.scn"])), 0);
    let text = std::fs::read_to_string(directory.path().join("ugly.scn")).expect("a file");
    assert_eq!(text, "scenario s {\n  use \"c.gen\";\n}\n");
    let output = directory.run(&["fmt", "broken.scn"]);
    assert!(stderr(&output).contains("left as it is"), "{}", stderr(&output));

    for command in [&["model"][..], &["tree"], &["diagram", "fsm"], &["codels", "check"]] {
        let output = directory.run(&[command, &["good.scn"]].concat());
        assert_eq!(status(&output), 2);
        let said = stderr(&output);
        assert!(said.contains("`dotgen verify good.scn` verifies it"), "{said}");
    }
}

#[test]
fn a_system_is_verified_with_the_configuration_of_each_part() {
    let part = |name: &str| {
        format!(
            "#include \"pose.idl\"\ncomponent {name} {{ task t {{ period 10 ms; codel<start> f() yield pause::start wcet 1 ms; }}; }};\n"
        )
    };
    let toml = "include-paths = [\"idl\"]\n";
    let directory = Directory::new(&[
        ("a/a.gen", &part("a")),
        ("a/idl/pose.idl", POSE),
        ("a/dotgen.toml", toml),
        ("b/b.gen", &part("b")),
        ("b/idl/pose.idl", POSE),
        ("b/dotgen.toml", toml),
    ]);
    let output = directory.run(&["verify", "a/a.gen", "b/b.gen"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("b.t"), "{}", stdout(&output));
}

#[test]
fn commands_say_that_there_was_nothing_to_do() {
    let spec = "component c { ids { long x; }; task t { codel<start> f(in x) yield ether; }; };\n";
    let directory = Directory::new(&[("c.gen", spec), ("open.gen", "component  c {\n")]);
    let output = directory.run(&["codels", "check", "c.gen"]);
    let said = stderr(&output);
    assert!(said.contains("nothing was compared; `dotgen codels stub c.gen`"), "{said}");
    assert_eq!(status(&output), 0);
    assert_eq!(stderr(&directory.run(&["codels", "stub", "c.gen"])), "");
    let again = stderr(&directory.run(&["codels", "stub", "c.gen"]));
    assert!(again.contains("every codel has a function"), "{again}");
    let sync = stderr(&directory.run(&["codels", "sync", "c.gen"]));
    assert!(sync.contains("nothing to mend"), "{sync}");
    assert_eq!(stderr(&directory.run(&["codels", "check", "c.gen"])), "");
    let format = stderr(&directory.run(&["fmt", "open.gen"]));
    assert!(format.contains("`open.gen` is left as it is"), "{format}");
}

#[test]
fn a_macro_must_have_a_name() {
    let directory = Directory::new(&[("c.gen", "")]);
    let output = directory.run(&["check", "-D", "1X=2", "c.gen"]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("1X"), "{}", stderr(&output));
    assert_eq!(status(&directory.run(&["check", "-DF(x)=x", "-DA", "c.gen"])), 0);
}

#[test]
fn the_manual_is_part_of_the_program() {
    let directory = Directory::new(&[]);
    let output = directory.run(&["explain", "fsm/busy-loop"]);
    assert_eq!(status(&output), 0);
    assert!(stdout(&output).starts_with("# fsm/busy-loop\n"), "{}", stdout(&output));
    let all = stdout(&directory.run(&["explain"]));
    assert!(all.lines().count() > 150 && all.lines().any(|line| line == "missing-semicolon"));
    let output = directory.run(&["explain", "fsm/bussy-loop"]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("did you mean `fsm/busy-loop`?"), "{}", stderr(&output));
}

#[test]
fn sources_that_are_being_written_lack_one_warning() {
    let function = |name: &str| format!("  function {name}() {{ codel c_{name}(); }};\n");
    let names = ["a", "b", "d", "e", "f"];
    let specification = |before: &str| {
        let functions = names.map(|name| format!("{before}{}", function(name)));
        format!("component c {{\n{}}};\n", functions.concat())
    };
    let source = "genom_event c_a(const genom_context self)\n{\n  return genom_ok;\n}\n";
    let directory = Directory::new(&[("c.gen", &specification("")), ("codels/c_codels.c", source)]);
    let severities = || {
        let output = directory.run(&["codels", "check", "--format", "json", "c.gen"]);
        let document: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
        let all = document["diagnostics"].as_array().expect("a list").clone();
        let severity = |found: &Value| found["severity"].as_str().unwrap_or_default().to_owned();
        let mut all: Vec<String> = all.iter().map(severity).collect();
        all.sort();
        all
    };
    assert_eq!(severities(), ["hint", "hint", "hint", "hint", "warning"]);
    let allowed = specification("  // dotgen: allow(codel/missing-definition) made by a script\n");
    directory.write("c.gen", allowed.as_bytes());
    assert_eq!(severities(), ["hint"], "the comment of the function that exists");
}
