//! `dotgen wcet`, as users and scripts run it.

use std::process::Output;

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};

const SPEC: &str = "\
component cell {
  version \"1.0\"; lang \"c\";
  ids { long it, other; };
  task beat {
    period 10 ms;
    codel<start> beat_start(out it) yield pause::main;
    codel<main, again> beat_main(inout it)
      yield pause::main, again wcet 2 ms;
  };
  task rest {
    period 40 ms;
    codel<start> common(inout other) yield second;
    async codel<second> rest_second(inout other) yield pause::start;
  };
  task last {
    period 80 ms;
    codel<start> common(inout other) yield pause::start;
  };
  activity go(in long x) {
    task beat;
    validate go_check(in x);
    codel<start> go_start(in x) yield ether;
    codel<stop> go_stop(in x) yield ether;
  };
};
";

const SCENARIO: &str = "\
scenario cell {
  use \"cell.gen\"; // the one
  duration cell.beat.start [5,100] us; // measured once
  check schedulable *;
}
";

/// A line: when it began, how long it took (both in microseconds), and its names.
fn line(began: u64, took: u64, names: &str) -> String {
    let stamp = |number: u64| format!("{}.{:06}000", number / 1_000_000, number % 1_000_000);
    let (began, ended) = (stamp(began), stamp(began + took));
    format!("{began} {began} {ended} cell {names}\n")
}

fn log() -> String {
    [
        line(10_000, 100, "beat <permanent> beat_start ::cell::start ::cell::pause::main"),
        line(20_000, 1_500, "beat <permanent> beat_main ::cell::main ::cell::again"),
        line(22_000, 2_500, "beat <permanent> beat_main ::cell::again ::cell::pause::main"),
        line(40_000, 300, "rest <permanent> common ::cell::start ::cell::second"),
        line(41_000, 410, "rest <permanent> rest_second ::cell::second ::cell::pause::start"),
        line(45_000, 250, "last <permanent> common ::cell::start ::cell::pause::start"),
        line(50_000, 7, "<control> go go_check validate ::genom::ok"),
        line(51_000, 20, "beat go go_start ::cell::start ::cell::ether"),
        line(52_000, 90_000, "beat go genom_prof_record profiling wakeup"),
        "9.000000000 9.000000000 9.100000000 genom profiling writer prof_writer wakeup sleep\n"
            .to_owned(),
        "9.000000000 9.000000000 8.000000000 cell beat go go_start ::cell::start ::cell::ether\n"
            .to_owned(),
        "rubbish\n".to_owned(),
        line(60_000, 60_000_000, "beat <permanent> beat_main ::cell::main")[..40].to_owned(),
    ]
    .concat()
}

fn files() -> Directory {
    Directory::new(&[("cell.gen", SPEC), ("cell.scn", SCENARIO), ("run.out", &log())])
}

fn put(directory: &Directory, name: &str, text: &str) {
    directory.write(name, text.as_bytes());
}

fn dotgen(directory: &Directory, arguments: &[&str]) -> Output {
    directory.run(arguments)
}

fn json(output: &Output) -> Value {
    let text = stdout(output);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}{}", stderr(output)))
}

fn import(directory: &Directory, arguments: &[&str]) -> Value {
    let all = [&["wcet", "import", "--format", "json"], arguments].concat();
    let output = dotgen(directory, &all);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    json(&output)
}

/// The offset of a position of the protocol, in a text without wide characters.
fn offset(text: &str, position: &Value) -> usize {
    let number = |key: &str| position[key].as_u64().expect("a number") as usize;
    let before = text.split_inclusive('\n').take(number("line"));
    before.map(str::len).sum::<usize>() + number("character")
}

/// A text with edits of a report.
fn edited(text: &str, edits: &Value) -> String {
    let mut out = text.to_owned();
    for edit in edits.as_array().expect("a list").iter().rev() {
        let range = offset(text, &edit["range"]["start"])..offset(text, &edit["range"]["end"]);
        out.replace_range(range, edit["text"].as_str().expect("a text"));
    }
    out
}

#[test]
fn measured_times_become_clauses() {
    let directory = files();
    let report = import(&directory, &["run.out", "cell.gen"]);
    let expected = SPEC
        .replace("yield pause::main;", "yield pause::main wcet 120 us;")
        .replace("again wcet 2 ms", "again wcet 3 ms")
        .replace("yield second;", "yield second wcet 360 us;")
        .replace(
            "second(inout other) yield pause::start;",
            "second(inout other) yield pause::start wcet 500 us;",
        )
        .replace(
            "common(inout other) yield pause::start;",
            "common(inout other) yield pause::start wcet 300 us;",
        )
        .replace("go_check(in x);", "go_check(in x) wcet 9 us;")
        .replace("go_start(in x) yield ether;", "go_start(in x) yield ether wcet 24 us;");
    assert_eq!(directory.read("cell.gen"), expected);
    assert_eq!(edited(SPEC, &report["edits"]), expected);
    let of = |path: &str, key: &str| -> Value {
        let codels = report["codels"].as_array().expect("a list");
        let codel = codels.iter().find(|codel| codel["codel"] == path);
        codel.unwrap_or_else(|| panic!("{path}"))[key].clone()
    };
    // One declaration for two states: the greatest of both.
    assert_eq!(of("cell.beat.main", "greatest"), 1_500_000);
    assert_eq!(of("cell.beat.main", "proposed"), 3_000_000);
    assert_eq!(of("cell.beat.again", "decision"), "raised");
    assert_eq!(of("cell.beat.again", "line"), 3);
    assert_eq!(of("cell.beat.start", "decision"), "new");
    let place = of("cell.beat.start", "place");
    assert!(place["file"].as_str().is_some_and(|file| file.ends_with("cell.gen")));
    let start = offset(SPEC, &place["range"]["start"]);
    assert!(SPEC[start..].starts_with("<start> beat_start("), "{place}");
    assert_eq!(report["never-seen"], serde_json::json!(["cell.go.stop"]));
    let left = serde_json::json!({
        "recorder": 1, "overloads": 1, "clock-steps": 1, "cut": 1, "garbage": 1,
    });
    assert_eq!(report["left"], left);
    assert_eq!(report["unknown"], serde_json::json!([]));
    // Once more: nothing is left to do.
    let again = import(&directory, &["run.out", "cell.gen"]);
    assert_eq!(again["changed"], serde_json::json!([]));
    assert_eq!(directory.read("cell.gen"), expected);
    assert_eq!(status(&dotgen(&directory, &["check", "cell.gen"])), 0);
}

#[test]
fn nothing_is_lowered_unasked() {
    let directory = files();
    let declared = SPEC.replace("again wcet 2 ms", "again wcet 20 ms");
    put(&directory, "cell.gen", &declared);
    import(&directory, &["run.out", "cell.gen"]);
    assert!(directory.read("cell.gen").contains("wcet 20 ms"));
    import(&directory, &["run.out", "cell.gen", "--replace", "--margin", "1"]);
    let text = directory.read("cell.gen");
    assert!(text.contains("again wcet 2500 us;"), "{text}");
    // What was written with a greater margin is lowered as well.
    assert!(text.contains("yield second wcet 300 us;"), "{text}");
}

#[test]
fn a_pragma_is_about_all_uses_of_a_function() {
    let directory = files();
    let without = SPEC.replace(" wcet 2 ms", "");
    put(&directory, "cell.gen", &without);
    import(&directory, &["run.out", "cell.gen", "--as", "pragma"]);
    let text = directory.read("cell.gen");
    assert!(text.contains("\n#pragma wcet common 360 us\n    codel<start> common("), "{text}");
    assert_eq!(text.matches("#pragma wcet").count(), 6, "{text}");
    let rest: String = (text.lines().filter(|line| !line.starts_with("#pragma")))
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(rest, without);
    assert_eq!(status(&dotgen(&directory, &["check", "cell.gen"])), 0);
    // They stay pragmas.
    import(&directory, &["run.out", "cell.gen", "--margin", "2"]);
    let text = directory.read("cell.gen");
    assert!(text.contains("\n#pragma wcet common 600 us\n"), "{text}");
    assert_eq!(text.matches("wcet").count(), 6, "{text}");
}

#[test]
fn an_interface_that_two_specifications_include_is_edited_once() {
    let interface = "interface port {\n  task io { period 10 ms; };\n  \
                     function ping() { codel do_ping(); };\n  \
                     function pong() { codel do_pong(); };\n};\n";
    let component = |name: &str| {
        format!(
            "#include \"port.gen\"\ncomponent {name} {{\n  version \"1.0\"; lang \"c\";\n  provides port;\n}};\n"
        )
    };
    let of = |name: &str, took: u64, service: &str| {
        let names = format!("<control> {service} do_{service} codel ::genom::ok");
        line(10_000, took, &names).replace(" cell ", &format!(" {name} "))
    };
    let log = [of("one", 500, "ping"), of("two", 1_000, "ping"), of("two", 100, "pong")];
    for (form, ping) in
        [("clause", "codel do_ping() wcet 1200 us;"), ("pragma", "#pragma wcet do_ping 1200 us")]
    {
        let directory = Directory::new(&[
            ("port.gen", interface),
            ("one.gen", &component("one")),
            ("two.gen", &component("two")),
            ("both.scn", "scenario both { use \"one.gen\"; use \"two.gen\"; }\n"),
            ("run.out", &log.concat()),
        ]);
        import(&directory, &["run.out", "both.scn", "--as", form]);
        let text = directory.read("port.gen");
        assert!(text.contains(ping), "{text}");
        assert_eq!(text.matches("wcet do_ping").count() + text.matches("() wcet 1200").count(), 1);
        assert_eq!(directory.read("one.gen"), component("one"));
        let again = import(&directory, &["run.out", "both.scn", "--as", form]);
        assert_eq!(again["changed"], serde_json::json!([]), "{again:#}");
        assert_eq!(directory.read("port.gen"), text);
    }
}

#[test]
fn bytes_that_are_no_utf8_and_line_ends_stay() {
    for form in ["clause", "pragma"] {
        let directory = files();
        let without = SPEC.replace(" wcet 2 ms", "");
        let mut bytes = without.replace('\n', "\r\n").into_bytes();
        bytes.extend_from_slice(b"// caf\xe9 \xff\r\n/* no end of line */");
        let path = directory.path().join("cell.gen");
        std::fs::write(&path, &bytes).expect("written");
        import(&directory, &["run.out", "cell.gen", "--as", form]);
        let new = std::fs::read(&path).expect("read");
        assert_ne!(new, bytes);
        // What was inserted is all that differs.
        let mut old = bytes.iter().peekable();
        for byte in &new {
            old.next_if_eq(&byte);
        }
        assert_eq!(old.next(), None, "{}", String::from_utf8_lossy(&new));
        assert!(new.ends_with(b"// caf\xe9 \xff\r\n/* no end of line */"));
        let alone = new.windows(2).filter(|window| window[1] == b'\n' && window[0] != b'\r');
        assert_eq!(alone.count(), 0);
    }
}

#[test]
fn what_comes_from_a_macro_is_left_to_people() {
    let directory = files();
    let text = SPEC
        .replacen(
            "component",
            "#define TIME wcet 2 ms\n#define BODY go_start(in x) yield ether\ncomponent",
            1,
        )
        .replace("wcet 2 ms;", "TIME;")
        .replace("codel<start> go_start(in x) yield ether;", "codel<start> BODY;");
    put(&directory, "cell.gen", &text);
    let output = dotgen(&directory, &["wcet", "import", "run.out", "cell.gen"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    let told = stdout(&output);
    assert!(told.contains("not written: the time of beat_main"), "{told}");
    let new = directory.read("cell.gen");
    assert!(new.contains("again TIME;"), "{new}");
    assert!(new.contains("yield pause::main wcet 120 us;"), "{new}");
}

#[test]
fn comments_within_a_time_are_left_to_people() {
    let directory = files();
    let text = SPEC.replace("wcet 2 ms;", "wcet /* by hand */ 2 us;");
    put(&directory, "cell.gen", &text);
    let output = dotgen(&directory, &["wcet", "import", "run.out", "cell.gen"]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    assert!(stdout(&output).contains("a comment stands within"));
    assert!(directory.read("cell.gen").contains("wcet /* by hand */ 2 us;"));

    let text = SPEC.replace("component", "#pragma wcet beat_main 2 us /* by hand */\ncomponent");
    put(&directory, "cell.gen", &text.replace(" wcet 2 ms;", ";"));
    let output = dotgen(&directory, &["wcet", "import", "run.out", "cell.gen"]);
    assert!(directory.read("cell.gen").contains("/* by hand */"), "{}", stdout(&output));

    let files = files();
    let text = SCENARIO.replace("[5,100] us;", "[5,100] /* a; b */ us;");
    put(&files, "cell.scn", &text);
    let arguments = ["wcet", "import", "run.out", "cell.scn", "--as", "sidecar", "--replace"];
    let output = dotgen(&files, &arguments);
    assert_eq!(status(&output), 2, "{}", stdout(&output));
    assert_eq!(files.read("cell.scn"), text);
}

#[test]
fn a_log_without_runs_is_an_error() {
    let directory = files();
    put(&directory, "empty.out", "");
    put(&directory, "garbage.out", "no\nlog\n");
    for (log, why) in [("empty.out", "it is empty"), ("garbage.out", "2 lines not of a log")] {
        let output = dotgen(&directory, &["wcet", "stats", log]);
        assert_eq!(status(&output), 2, "{log}");
        assert!(stderr(&output).contains(why), "{}", stderr(&output));
    }
}

#[test]
fn a_scenario_can_have_the_times() {
    let directory = files();
    import(&directory, &["run.out", "cell.scn", "--as", "sidecar"]);
    let expected = "\
scenario cell {
  use \"cell.gen\"; // the one
  duration cell.beat.start [5,120] us; // measured once
  check schedulable *;
}
";
    let text = directory.read("cell.scn");
    let lines: Vec<&str> = text.lines().filter(|line| !expected.contains(*line)).collect();
    let fresh = [
        "  duration cell.beat.start [5,120] us;",
        "  duration cell.beat.again [0,3000] us;",
        "  duration cell.rest.start [0,360] us;",
        "  duration cell.rest.second [0,500] us;",
        "  duration cell.last.start [0,300] us;",
        "  duration cell.go.go_check [0,9] us;",
        "  duration cell.go.start [0,24] us;",
    ];
    for name in fresh {
        assert!(text.contains(name), "{name}\n{text}");
    }
    assert!(lines.len() <= fresh.len(), "{text}");
    assert_eq!(directory.read("cell.gen"), SPEC);
    let verified = dotgen(&directory, &["verify", "cell.scn"]);
    assert!(!stderr(&verified).contains("error"), "{}", stderr(&verified));
    let again = import(&directory, &["run.out", "cell.scn", "--as", "sidecar"]);
    assert_eq!(again["changed"], serde_json::json!([]));
    // Without a scenario there is no place for them.
    let output = dotgen(&directory, &["wcet", "import", "run.out", "cell.gen", "--as", "sidecar"]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("name one (.scn)"), "{}", stderr(&output));
}

#[test]
fn a_diff_writes_nothing() {
    let directory = files();
    for option in ["--diff", "--dry-run"] {
        let output = dotgen(&directory, &["wcet", "import", "run.out", option]);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let diff = stdout(&output);
        assert!(diff.starts_with("--- cell.gen\n+++ cell.gen\n"), "{diff}");
        assert!(diff.contains("\n+      yield pause::main, again wcet 3 ms;\n"), "{diff}");
        assert!(stderr(&output).contains("would change cell.gen"), "{}", stderr(&output));
        assert_eq!(directory.read("cell.gen"), SPEC);
    }
}

#[test]
fn logs_of_others_are_named() {
    let directory = files();
    let strange = line(1_000, 1, "beat go go_start ::cell::nowhere ::cell::ether")
        + &line(2_000, 1, "beat go other ::cell::start ::cell::ether");
    put(&directory, "run.out", &(log().replace("rubbish\n", &strange)));
    let report = import(&directory, &["run.out"]);
    let whys: Vec<&Value> =
        (report["unknown"].as_array().expect("a list").iter()).map(|json| &json["why"]).collect();
    assert_eq!(whys, ["state", "function"]);
    // What a control task executes is known by its service: the server may have another name.
    let others: String = (log().lines().filter(|line| !line.contains("<control>")))
        .map(|line| format!("{line}\n"))
        .collect();
    put(&directory, "run.out", &others.replace("cell", "bell"));
    let output = dotgen(&directory, &["wcet", "import", "run.out"]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("of other components"), "{}", stderr(&output));
    put(&directory, "run.out", "");
    let output = dotgen(&directory, &["wcet", "import", "run.out"]);
    assert!(stderr(&output).contains("the log is empty"), "{}", stderr(&output));
    for wrong in [&["missing.out", "cell.gen"][..], &["cell.gen"], &["run.out", "--margin", "0.5"]]
    {
        let output = dotgen(&directory, &[&["wcet", "import"], wrong].concat());
        assert_eq!(status(&output), 2, "{wrong:?}");
    }
}

#[test]
fn statistics_for_people() {
    let directory = files();
    let output = dotgen(&directory, &["wcet", "stats", "run.out"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    insta::assert_snapshot!(stdout(&output));
}

#[test]
fn only_measured_times_are_imported() {
    let directory = Directory::new(&[("cell.gen", SPEC)]);
    let arguments = ["run", "cell.gen", "--simulate", "all", "--until", "1s"];
    let output = dotgen(&directory, &[&arguments[..], &["--profile", "run.out"]].concat());
    assert!(matches!(status(&output), 0 | 3), "{}", stderr(&output));
    for more in [&[][..], &["--diff", "--format", "json"]] {
        let import = ["wcet", "import", "run.out", "cell.gen"];
        let output = dotgen(&directory, &[&import[..], more].concat());
        assert_eq!(status(&output), 2, "{}", stdout(&output));
        let said = stderr(&output);
        assert!(said.contains("simulated, not measured: nothing to import"), "{said}");
        assert!(said.contains("--clock real"), "{said}");
        assert_eq!(stdout(&output), "");
    }
    assert_eq!(directory.read("cell.gen"), SPEC);

    // Codels without a function in a run on the real clock.
    let head = "# dotgen: times are measured\n# dotgen: simulated cell.beat.start\n";
    put(&directory, "run.out", &format!("{head}{}", log()));
    let output = dotgen(&directory, &["wcet", "import", "run.out", "cell.gen"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(
        stdout(&output).contains("simulated, not measured: cell.beat.start\n"),
        "{}",
        stdout(&output)
    );
    let text = directory.read("cell.gen");
    assert!(text.contains("beat_start(out it) yield pause::main;"), "{text}");
    assert!(text.contains("again wcet 3 ms"), "{text}");
}
