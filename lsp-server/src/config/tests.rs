use serde_json::json;

use super::*;

fn problems(read: &LoadedSettings, text: &str) -> Vec<String> {
    let show = |problem: &Problem| {
        let at = problem.range.clone().map_or("-", |range| &text[range]);
        format!("{} `{at}`: {}", problem.kind.code(), problem.message)
    };
    read.problems.iter().map(show).collect()
}

#[test]
fn a_file_is_read_whole() {
    let read = from_toml(
        r#"
include-paths = ["idl", "/opt/robots/idl"]
package-paths = ["~/lib/pkgconfig"]

[defines]
ROBOT = "\"arm\""
AXES = 6
DEBUG = true
NDEBUG = false

[severity]
pp-redefined = "off"
list-duplicate-string = "error"
"#,
    );
    assert_eq!(read.problems, []);
    let config = Config::new(&read.settings, Utf8Path::new("/work/arm"), true);
    assert_eq!(config.include_paths, ["/work/arm/idl", "/opt/robots/idl"]);
    let defines: Vec<_> = config.defines.iter().map(|(n, b)| (&**n, &**b)).collect();
    assert_eq!(defines, [("AXES", "6"), ("DEBUG", "1"), ("ROBOT", "\"arm\"")]);
    assert_eq!(config.severity["pp-redefined"], Level::Off);
    assert!(config.packages.paths[0].is_absolute(), "the home directory");
}

#[test]
fn what_is_wrong_is_said_where_it_stands_and_the_rest_counts() {
    let text = r#"
include-path = ["a"]
package-paths = "b"
colour = 1

[defines]
GOOD = 1
BAD = [1]

[severity]
syntax = "fatal"
unknown-type = "hint"
"fsm/busy-lop" = "error"
"codel/orphan" = "off"
"timing/deadline-miss" = "error"
"fsm/busy-loop" = 1

[verification]
time-limit = "long"
enable = 1
tme-limit = 1
"#;
    let read = from_toml(text);
    expect_test::expect![[r#"
        config-unknown-key `include-path`: unknown setting `include-path`; did you mean `include-paths`?
        config-bad-value `"b"`: bad value for `package-paths`: expected a list of directories
        config-unknown-key `colour`: unknown setting `colour`
        config-bad-value `[1]`: bad value for `defines.BAD`: expected a string, a number, `true` or `false`
        config-bad-value `"fatal"`: bad value for `severity.syntax`: expected "error", "warning", "information", "hint" or "off"
        config-unknown-key `"fsm/busy-lop"`: there is no diagnostic `fsm/busy-lop`; did you mean `fsm/busy-loop`?
        config-bad-value `1`: bad value for `severity."fsm/busy-loop"`: expected "error", "warning", "information", "hint" or "off"
        config-bad-value `"long"`: bad value for `verification.time-limit`: expected a number
        config-bad-value `1`: bad value for `verification.enable`: expected `true` or `false`
        config-unknown-key `tme-limit`: unknown setting `verification.tme-limit`; did you mean `time-limit`?"#]].assert_eq(&problems(&read, text).join("\n"));
    assert_eq!(read.settings.defines["GOOD"], DefineValue::Number(1));
    assert_eq!(read.settings.severity["unknown-type"], Level::Hint);
}

#[test]
fn a_file_that_is_no_toml_says_so() {
    let text = "include-paths = [\n";
    let read = from_toml(text);
    assert_eq!(read.settings, Settings::default());
    assert_eq!(read.problems.len(), 1);
    assert_eq!(read.problems[0].kind, ProblemKind::Syntax);
    assert!(read.problems[0].message.starts_with("not a valid TOML file: "));
}

#[test]
fn every_shape_that_editors_send_is_read() {
    let expected = Settings {
        include_paths: vec!["idl".to_owned()],
        severity: BTreeMap::from([("syntax".to_owned(), Level::Warning)]),
        ..Settings::default()
    };
    for value in [
        // workspace/configuration with a section, VS Code
        json!({ "includePaths": ["idl"], "severity": { "syntax": "warning" }, "defines": {},
                "server": { "path": "" }, "trace": { "server": "off" } }),
        // didChangeConfiguration, most clients
        json!({ "dotgen": { "includePaths": ["idl"], "severity": { "syntax": "warning" } } }),
        // in the words of dotgen.toml
        json!({ "include-paths": ["idl"], "severity": { "syntax": "warning" } }),
        json!({ "include_paths": ["idl"], "severity": { "syntax": "warning" }, "defines": null }),
        // flattened
        json!({ "dotgen.includePaths": ["idl"], "dotgen.severity": { "syntax": "warning" },
                "editor.tabSize": 4 }),
        json!({ "dotgen.includePaths": ["idl"], "dotgen.severity.syntax": "warning" }),
    ] {
        let read = from_editor(&value);
        assert_eq!(read.problems, [], "{value}");
        assert_eq!(read.settings, expected, "{value}");
    }
    for nothing in [json!(null), json!([]), json!({}), json!({ "dotgen": null })] {
        assert_eq!(from_editor(&nothing), LoadedSettings::default(), "{nothing}");
    }
    for wrong in [json!("x"), json!(3), json!({ "dotgen": true })] {
        let problems = from_editor(&wrong).problems;
        let [problem] = problems.as_slice() else { panic!("{problems:?}") };
        assert!(problem.message.starts_with("bad value for `dotgen`: "), "{}", problem.message);
    }
}

#[test]
fn stronger_sources_win_and_lists_are_joined() {
    let file = from_toml("include-paths = ['a']\n[defines]\nX = 1\nY = 1\n").settings;
    let editor = from_editor(&json!({ "includePaths": [], "defines": { "X": 2 } })).settings;
    let mut line = Settings { include_paths: vec!["c".to_owned()], ..Settings::default() };
    line.define("X=3=4");
    line.define("Z");
    let all = line.over(editor).over(file);
    assert_eq!(all.include_paths, ["c", "a"]);
    let config = Config::new(&all, Utf8Path::new("/"), false);
    let defines: Vec<_> = config.defines.iter().map(|(n, b)| (&**n, &**b)).collect();
    assert_eq!(defines, [("X", "3=4"), ("Y", "1"), ("Z", "1")]);
}

#[test]
fn tables_are_joined_down_to_their_values() {
    let strong = "codels.extensions = ['c']\nconnections.a.p = 'b.q'\nverification.time-limit = 3\n\
                  [ros2.messages.pom.frame]\ntype = 'geometry_msgs/Pose'\nfields = { position = 'x' }\n";
    let weak = "codels = { extensions = ['cc'], folder = 'src' }\n\
                connections.a = { p = 'c.r', s = ['b.t'] }\n\
                verification = { time-limit = 5, max-states = 7 }\n\
                [ros2.messages.pom.frame]\ntype = 'geometry_msgs/Twist'\nfields = { linear = 'v' }\n\
                [ros2.messages.pom.speed]\ntype = 'geometry_msgs/Twist'\n";
    let settings = |text| from_toml(text).settings;
    let expected = settings(
        "codels = { extensions = ['c'], folder = 'src' }\n\
         connections.a = { p = 'b.q', s = ['b.t'] }\n\
         verification = { time-limit = 3, max-states = 7 }\n\
         [ros2.messages.pom.frame]\ntype = 'geometry_msgs/Pose'\nfields = { position = 'x' }\n\
         [ros2.messages.pom.speed]\ntype = 'geometry_msgs/Twist'\n",
    );
    assert_eq!(settings(strong).over(settings(weak)), expected);
    let config = |settings: &Settings| Config::new(settings, Utf8Path::new("/"), true);
    let joined = config(&settings(strong)).join(config(&settings(weak)));
    assert_eq!(joined.ros2, expected.ros2);
    assert_eq!(joined.verification, expected.verification);
}

#[test]
fn folders_are_joined_in_their_order() {
    let config = |text, base| Config::new(&from_toml(text).settings, Utf8Path::new(base), true);
    let first = config("include-paths = ['idl']\n[defines]\nX = 1\n", "/one");
    let second = config("include-paths = ['idl', '/one/idl']\n[defines]\nX = 2\n", "/two");
    let both = first.join(second);
    assert_eq!(both.include_paths, ["/one/idl", "/two/idl"]);
    assert_eq!(both.defines, [("X".to_owned(), "1".to_owned())]);
}

#[test]
fn placeholders_in_paths_are_replaced() {
    let base = Utf8Path::new("/work/arm");
    assert_eq!(resolve("../idl/./x", base), "/work/idl/x");
    assert_eq!(resolve("${workspaceFolder}/idl", base), "/work/arm/idl");
    assert_eq!(resolve("/x${env:DOTGEN_NO_SUCH_VARIABLE}/y", base), "/x/y");
    assert_eq!(resolve("/${env:unclosed", base), "/${env:unclosed");
}

#[test]
fn entries_of_tables_may_be_in_camel_case() {
    let read = from_editor(&json!({ "verification": { "timeLimit": 3, "max-states": 5 } }));
    assert_eq!(read.problems, []);
    assert_eq!(read.settings.verification.time_limit, Some(3.0));
    assert_eq!(read.settings.verification.max_states, Some(5));
    let read = from_editor(&json!({ "verification": { "tmeLimit": 3 } }));
    let message = &read.problems[0].message;
    assert_eq!(
        message,
        "unknown setting `dotgen.verification.tmeLimit`; did you mean `time-limit`?"
    );
}

#[test]
fn wrong_messages_of_ros_have_their_place() {
    let text = "[ros2.messages.pom.frame]\ntype = 'geometry_msgs/Pose'\n\
                fields = { position.q = 'x' }\nconstants.orientation.w = 'one'\n";
    let problems = from_toml(text).problems;
    let found: Vec<_> = problems
        .iter()
        .map(|problem| (&text[problem.range.clone().expect("a place")], problem.message.as_str()))
        .collect();
    assert_eq!(
        found,
        [
            (
                "'x'",
                "bad value for `ros2.messages.pom.frame.fields.position.q`: `position` has no field `q`; \
                 there are `x`, `y`, `z`"
            ),
            (
                "'one'",
                "bad value for `ros2.messages.pom.frame.constants.orientation.w`: expected a number, not \
                 \"one\""
            ),
        ]
    );
    let problems = from_toml("[ros2.messages.pom.frame]\nfields.x = 'x'\n").problems;
    assert!(problems[0].message.contains("a `type`"), "{problems:?}");
}
