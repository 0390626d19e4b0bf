//! Components that run with their own codels, as users run them.
#![cfg(target_os = "linux")]

mod genomix;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{
    Listening, compilers, ended, hosts, installed, json_of, processes, talk, violation, with_body,
};

const TYPES: &str = include_str!("hosted/types.idl");
const ECHO: &str = include_str!("hosted/echo.gen");
const READER: &str = include_str!("hosted/reader.gen");

/// Two components in a language; one reads the ports of the other.
fn components(language: &str) -> Directory {
    let (echo, reader) = (ECHO.replace("LANG", language), READER.replace("LANG", language));
    let sources = match language {
        "c" => [
            ("echo/codels/echo.c", include_str!("hosted/echo.c")),
            ("reader/codels/reader.c", include_str!("hosted/reader.c")),
        ],
        _ => [
            ("echo/codels/echo.cc", include_str!("hosted/echo.cc")),
            ("reader/codels/reader.cc", include_str!("hosted/reader.cc")),
        ],
    };
    let files = [
        ("echo/echo.gen", echo.as_str()),
        ("echo/types.idl", TYPES),
        ("reader/reader.gen", reader.as_str()),
        ("reader/types.idl", TYPES),
    ];
    Directory::new(&[&files[..], &sources[..]].concat())
}

fn run_bad(directory: &Directory, more: &[&str]) -> Value {
    let mut arguments = vec!["run", "bad/bad.gen", "good/good.gen", "--format", "json"];
    arguments.extend(["--bounds", "none"]);
    arguments.extend(more);
    let output = directory.run(&arguments);
    let report = json_of(&output);
    // A codel that does not return is named, too.
    let expected = if report["unfinished"].is_null() { 1 } else { 4 };
    assert_eq!(status(&output), expected, "{report:#}");
    assert_eq!(processes(directory), Vec::<String>::new());
    report
}

fn jobs(report: &Value, task: &str) -> u64 {
    let tasks = report["tasks"].as_array().expect("a list");
    let found = tasks.iter().find(|candidate| candidate["task"] == task).expect("the task");
    found["jobs"].as_u64().expect("a number")
}

#[test]
fn codels_in_c_and_in_cxx_run_on_the_virtual_clock() {
    for language in ["c", "c++"] {
        if !compilers() {
            return;
        }
        let directory = components(language);
        let arguments = ["run", "echo/echo.gen", "reader/reader.gen", "--format", "json"];
        let run = || directory.run(&arguments);
        let (first, second) = (json_of(&run()), json_of(&run()));
        assert_eq!(first["executed-codels"], 9, "{first:#}");
        assert_eq!(first["simulated-codels"], 0);
        assert_eq!(first["violation-count"], 0, "{first:#}");
        assert!(jobs(&first, "echo.main") > 900);
        assert_eq!(first, second);
        assert_eq!(processes(&directory), Vec::<String>::new());
    }
}

#[test]
fn a_request_that_the_scenario_does_not_foresee_is_served_and_counted() {
    let specification = "component lamp {\n  version \"1.0\"; lang \"c\";\n  ids { long count; };\n\
        task exec { period 10 ms; };\n  activity blink(out long seen) {\n    task exec;\n\
        codel<start> blink_start(out seen) yield pause::main wcet 1 ms;\n\
        codel<main> blink_main(out seen) yield ether wcet 1 ms;\n  };\n};\n";
    let scenario = "scenario lamp { use \"lamp.gen\"; check response *; }\n";
    let directory = Directory::new(&[("lamp.gen", specification), ("lamp.scn", scenario)]);
    let options = "run lamp.scn --clock real --simulate all --bounds none --socket s --format json \
        --record run.mcap";
    let arguments: Vec<&str> = options.split_whitespace().collect();
    let file = std::fs::File::create(directory.path().join("report.json")).expect("a file");
    let mut run = Listening::begin_with_output(&mut directory.command(&arguments), file.into());
    for _ in 0..2 {
        let called = directory.run(&["call", "--socket", "s", "lamp", "blink"]);
        assert_eq!(status(&called), 0, "{}", stderr(&called));
    }
    run.signal("-INT");
    assert_eq!(ended(&mut run.0).code(), Some(3));
    let report: Value = serde_json::from_str(&directory.read("report.json")).expect("JSON");
    assert_eq!(report["requests-outside-model"], 2, "{report:#}");
    let blink = &report["services"][0];
    assert_eq!((&blink["requests"], &blink["ended"]), (&2.into(), &2.into()), "{report:#}");
    let codels = report["codels"].as_array().expect("a list");
    let main = codels.iter().find(|codel| codel["codel"] == "lamp.blink.main").expect("a codel");
    assert_eq!(main["runs"], 2, "{report:#}");
    // A replay serves them, too.
    let replayed = directory.run(&["replay", "run.mcap", "lamp.scn", "--format", "json"]);
    assert_eq!(status(&replayed), 0, "{}", stdout(&replayed));
    assert_eq!(json_of(&replayed)["from-outside"], 2);
}

#[test]
fn values_of_missing_packages_are_passed_on_by_the_client_in_python() {
    if !installed(&["python3"]) {
        return;
    }
    let directory = Directory::new(&[("unknown.gen", include_str!("hosted/unknown.gen"))]);
    let options = "run unknown.gen --clock real --simulate all --bounds none --socket s";
    let arguments: Vec<&str> = options.split(' ').collect();
    let run = Listening::start(&directory, &arguments);
    talk(&directory, "unknown.py");
    drop(run);
}

#[test]
fn values_cross_between_codels_ports_and_a_client_in_python() {
    if !installed(&["python3"]) || !compilers() {
        return;
    }
    for language in ["c", "c++"] {
        let directory = components(language);
        let options =
            "run echo/echo.gen reader/reader.gen --clock real --bounds none --until 60s --socket s";
        let arguments: Vec<&str> = options.split(' ').collect();
        let run = Listening::start(&directory, &arguments);
        talk(&directory, "talk.py");
        talk(&directory, "clients.py");

        let call = |service: &str, input: &str| {
            directory.run(&["call", "--socket", "s", "echo", service, input])
        };
        let counted = call("count", "{\"n\": 3}");
        assert_eq!((status(&counted), stdout(&counted).as_str()), (0, "{\"seen\":3}\n"));
        if language == "c" {
            let nonsense = call("count", "{\"n\": -1}");
            assert_eq!(status(&nonsense), 1, "{}", stdout(&nonsense));
            assert!(stderr(&nonsense).contains("::genom::bad_transition"));
        }
        let failed = call("fail", "{\"code\": 2}");
        assert_eq!(status(&failed), 1);
        assert!(stderr(&failed).contains("::echo::e_bad {\"code\":2}"));
        let unknown = call("count", "{\"m\": 3}");
        assert_eq!(status(&unknown), 2);
        assert!(
            stderr(&unknown).contains("`m` is not an input of the service; the only one is `n`"),
            "{}",
            stderr(&unknown)
        );
        assert!(stderr(&call("count", "3")).contains("as in `{\"n\":"));
        assert!(stderr(&call("cuont", "{}")).contains("did you mean `count`?"));
        let watched = directory.run(&["watch", "--socket", "s", "echo/each", "-n", "2"]);
        assert_eq!(stdout(&watched), "{\"a\":30}\n{\"a\":30}\n");
        drop(run);
    }
}

#[test]
fn a_component_whose_codel_crashes_ends_alone() {
    if !compilers() {
        return;
    }
    let directory = with_body("abort();");
    for clock in ["virtual", "real"] {
        let mut more = vec!["--until", "500ms", "--clock", clock];
        if clock == "real" {
            more.extend(["--socket", "s"]);
        }
        let report = run_bad(&directory, &more);
        let lost = violation(&report, "lost");
        assert_eq!(lost["component"], "bad");
        assert_eq!(lost["function"], "bad_again");
        assert_eq!(lost["why"], "was ended by signal 6 (SIGABRT)");
        assert!(jobs(&report, "good.main") > 0, "{report:#}");
    }
}

#[test]
fn what_a_codel_must_not_yield_is_told_with_its_state() {
    if !compilers() {
        return;
    }
    for (body, event) in [
        ("return bad_ether;", "::bad::ether"),
        ("return bad_start;", "::bad::start"),
        ("return NULL;", ""),
        ("return \"nonsense\";", ""),
        ("return (const char *)1;", ""),
    ] {
        let report = run_bad(&with_body(body), &["--until", "200ms"]);
        let undeclared = violation(&report, "undeclared");
        assert_eq!(undeclared["codel"], "bad.main.go", "{body}");
        assert_eq!(undeclared["function"], "bad_again", "{body}");
        assert_eq!(undeclared["event"], event, "{body}");
    }
}

#[test]
fn a_codel_that_never_ends_does_not_keep_a_run_from_ending() {
    if !compilers() {
        return;
    }
    let directory = with_body("for (;;) pause();");
    let more = ["--until", "3s", "--clock", "real", "--socket", "s"];
    let report = run_bad(&directory, &more);
    let tasks = report["tasks"].as_array().expect("a list");
    let bad = tasks.iter().find(|task| task["task"] == "bad.main");
    let missed = bad.and_then(|task| task["missed"].as_u64());
    assert!(missed >= Some(1), "{report:#}");
    assert_eq!(report["unfinished"], serde_json::json!(["bad.main.go"]), "{report:#}");
}

#[test]
fn a_codel_that_takes_too_long_is_told() {
    if !compilers() {
        return;
    }
    let body = "struct timespec t = { 0, 30000000 }; nanosleep(&t, NULL);";
    let directory = with_body(body);
    let path = "bad/codels/bad.c";
    let text = std::fs::read_to_string(directory.path().join(path)).expect("it is there");
    directory.write(path, format!("#include <time.h>\n{text}").as_bytes());
    let more = ["--until", "3s", "--clock", "real", "--socket", "s"];
    let report = run_bad(&directory, &more);
    let all = report["violations"].as_array().expect("a list");
    let overrun = |json: &&Value| json["kind"] == "overrun" && json["function"] == "bad_again";
    let found = all.iter().find(overrun).unwrap_or_else(|| panic!("{report:#}"));
    assert_eq!(found["limit"], 1.0);
    assert!(found["took"].as_f64() >= Some(30.0), "{found}");
    // On the virtual clock it takes what it states.
    let virtually = directory.run(&[
        "run",
        "bad/bad.gen",
        "--bounds",
        "none",
        "--until",
        "500ms",
        "--format",
        "json",
    ]);
    assert_eq!(json_of(&virtually)["violation-count"], 0);
}

/// Two tasks of which the second one has the shorter period.
const TASKS: &str = "component pair { version \"1\"; lang \"c\"; ids { long n; };
  task slow { period 50 ms; codel<start> pair_slow(inout n) yield pause::start wcet 1 ms; };
  task fast { period 5 ms; codel<start> pair_fast(inout n) yield pause::start wcet 1 ms; };
  attribute set(in n) { validate pair_set(local in n); }; };\n";

/// Real-time priorities of the threads of a process, by name.
fn priorities(process: u32) -> BTreeMap<String, u32> {
    let threads = std::fs::read_dir(format!("/proc/{process}/task"));
    let threads = threads.into_iter().flatten();
    let priority = |entry: std::fs::DirEntry| {
        let name = std::fs::read_to_string(entry.path().join("comm")).ok()?;
        let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        // After the name, which may contain blanks: the third field and those behind it.
        let mut fields = stat.rsplit_once(')')?.1.split_whitespace();
        let priority = fields.nth(37)?.parse().ok()?;
        Some((name.trim_end().to_owned(), priority))
    };
    threads.flatten().filter_map(priority).collect()
}

#[test]
fn a_task_of_shorter_period_has_the_higher_priority() {
    let granted = Command::new("chrt").args(["-f", "1", "true"]).status();
    if !granted.is_ok_and(|status| status.success()) {
        dotgen_loaders::skip("the system grants no real-time scheduling");
        return;
    }
    if !compilers() {
        return;
    }
    let source = ["slow", "fast"].map(|task| {
        format!(
            "genom_event pair_{task}(int32_t *n, const genom_context self) {{ return pair_pause_start; }}\n"
        )
    });
    let validate =
        "genom_event pair_set(int32_t n, const genom_context self) { return genom_ok; }\n";
    let source = format!(
        "#include \"acpair.h\"\n#include \"pair_c_types.h\"\n{}{validate}",
        source.concat()
    );
    let directory = Directory::new(&[("pair/pair.gen", TASKS), ("pair/codels/pair.c", &source)]);
    let arguments = ["run", "pair/pair.gen", "--clock", "real", "--bounds", "none"];
    let mut run = Listening::start(&directory, &arguments);
    let begin = Instant::now();
    let seen = loop {
        let hosts = hosts(&directory);
        let seen = hosts.first().map_or(BTreeMap::new(), |&host| priorities(host));
        let has = |task: &str| seen.get(task).is_some_and(|&priority| priority > 0);
        if has("slow") && has("fast") {
            break seen;
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "{seen:?}");
        std::thread::yield_now();
    };
    run.signal("-TERM");
    ended(&mut run.0);
    assert_eq!((seen["fast"], seen["slow"]), (48, 47));
}

#[test]
fn attributes_are_set_when_the_run_begins() {
    if !compilers() {
        return;
    }
    let specification = "component c { version \"1\"; lang \"c\"; ids { long n; };
      task main { period 10 ms; codel<start> c_main(in n) yield pause::start wcet 1 ms; };
      attribute set(in n); attribute get(out n); function go() { }; };\n";
    let source = "#include \"acc.h\"\n#include \"c_c_types.h\"\n\
        genom_event c_main(int32_t n, const genom_context self) { return c_pause_start; }\n";
    let directory = Directory::new(&[
        ("c.gen", specification),
        ("codels/c.c", source),
        ("right.json", r#"{ "c": { "set": { "n": 42 } } }"#),
    ]);
    let run = ["run", "c.gen", "--clock", "real", "--bounds", "none", "--until", "50ms"];
    for (wrong, said) in [
        (r#"{ "d": {} }"#, "`d` is not a component of this run"),
        (r#"{ "c": { "put": {} } }"#, "`c` has no attribute `put`"),
        (r#"{ "c": { "go": {} } }"#, "`c.go` is not an attribute"),
        (r#"{ "c": { "set": { "n": "x" } } }"#, "`c.set`"),
        ("[]", "is not a JSON object"),
    ] {
        directory.write("wrong.json", wrong.as_bytes());
        let output = directory.run(&[&run[..], &["--params", "wrong.json"]].concat());
        assert_eq!(status(&output), 2, "{wrong}");
        assert!(stderr(&output).contains(said), "{wrong}: {}", stderr(&output));
    }
    let arguments =
        ["run", "c.gen", "--clock", "real", "--bounds", "none", "--params", "right.json"];
    let socket = directory.path().join("run.sock");
    let socket = socket.to_str().expect("it is text");
    let mut run = Listening::start(&directory, &[&arguments[..], &["--socket", socket]].concat());
    let begin = Instant::now();
    loop {
        let got = directory.run(&["call", "c", "get", "--socket", socket]);
        if stdout(&got) == "{\"n\":42}\n" {
            break;
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "{}{}", stdout(&got), stderr(&got));
    }
    run.signal("-TERM");
    ended(&mut run.0);
}

#[test]
fn what_does_not_compile_does_not_run() {
    if !compilers() {
        return;
    }
    let directory = with_body("return nothing_of_the_kind;");
    let output = directory.run(&["run", "bad/bad.gen"]);
    assert_eq!(status(&output), 2);
    let said = stdout(&output) + &stderr(&output);
    assert!(said.contains("nothing_of_the_kind"), "{said}");
    assert!(said.contains("--simulate all"), "{said}");
    let simulated = directory.run(&["run", "bad/bad.gen", "--simulate", "all"]);
    assert_eq!(status(&simulated), 0, "{}", stdout(&simulated));
}

#[test]
fn what_no_longer_compiles_does_not_run_as_it_was() {
    if !compilers() {
        return;
    }
    let directory = Directory::new(&[]);
    assert_eq!(status(&directory.run(&["new", "lamp"])), 0);
    let source = directory.path().join("lamp/codels/lamp_exec_codels.c");
    let good = std::fs::read_to_string(&source).expect("a source");
    let run = |more: &[&str]| {
        let run = ["run", "lamp/lamp.scn", "--until", "100ms"];
        directory.run(&[&run[..], more].concat())
    };
    assert_eq!(status(&run(&[])), 0);
    // Again and again, on the other path of the debugger, and with a time before that of the object.
    for old in [false, true] {
        std::fs::write(&source, format!("{good}\nno_such_type broken;\n")).expect("written");
        if old {
            let file = std::fs::File::options().append(true).open(&source).expect("a source");
            file.set_modified(std::time::SystemTime::UNIX_EPOCH).expect("a time");
        }
        for more in [&[][..], &[], &["--debug"]] {
            let output = run(more);
            let said = stdout(&output) + &stderr(&output);
            assert_eq!(status(&output), 2, "{old} {more:?}: {said}");
            assert!(said.contains("no_such_type"), "{old} {more:?}: {said}");
            assert!(!directory.path().join("lamp/.dotgen/run/lamp/lamp-run.so").exists());
        }
        let built = directory.run(&["codels", "build", "lamp/lamp.gen"]);
        assert_eq!(status(&built), 1, "{}", stdout(&built));
        std::fs::write(&source, &good).expect("written");
        let output = run(&[]);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
    }
}

/// Copies a folder, without what was built in it.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder").filter_map(Result::ok) {
        let target = to.join(entry.file_name());
        match entry.path().is_dir() {
            true if entry.file_name() == ".dotgen" => {}
            true => copy(&entry.path(), &target),
            false => _ = std::fs::copy(entry.path(), target).expect("a file"),
        }
    }
}

#[test]
fn the_examples_run_with_their_stubs_on_both_clocks() {
    if !compilers() {
        return;
    }
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    for (example, files) in [
        ("motor", &["motor.gen"][..]),
        ("pump", &["pump.gen"]),
        ("outdoor", &["roblaser.gen", "robloco.gen", "robmap.gen", "robmotion.gen"]),
        ("maneuver", &["maneuver.gen"]),
    ] {
        // Components that lie in one folder share their codels; here each has its own.
        let directory = Directory::new(&[]);
        let mut paths = Vec::new();
        for file in files {
            let name = file.trim_end_matches(".gen");
            copy(&examples.join(example), &directory.path().join(name));
            let path = format!("{name}/{file}");
            let stubs = directory.run(&["codels", "stub", &path]);
            assert_eq!(status(&stubs), 0, "{path}: {}", stderr(&stubs));
            paths.push(path);
        }
        for clock in ["virtual", "real"] {
            let mut arguments = vec!["run"];
            arguments.extend(paths.iter().map(String::as_str));
            let options = "--bounds none --format json --until 300ms --clock";
            arguments.extend(options.split(' ').chain([clock]));
            if clock == "real" {
                arguments.extend(["--socket", "s"]);
            }
            let output = directory.run(&arguments);
            let report = json_of(&output);
            assert!(report["executed-codels"].as_u64() > Some(0), "{example}: {report:#}");
            assert_eq!(report["simulated-codels"], 0, "{example}");
            // What stubs yield is declared, and no component ends; whether they are in time is another
            // matter.
            for violation in report["violations"].as_array().expect("a list") {
                assert!(
                    violation["kind"] != "lost" && violation["kind"] != "undeclared",
                    "{example}: {violation}"
                );
            }
        }
        assert_eq!(processes(&directory), Vec::<String>::new());
    }
}

#[test]
fn whoever_watches_is_told_that_a_component_is_gone() {
    if !compilers() {
        return;
    }
    let directory = components("c");
    let path = "echo/codels/echo.c";
    let text = std::fs::read_to_string(directory.path().join(path)).expect("it is there");
    let crash = "(void)self;\n  if (n == 13) __builtin_trap();\n";
    let text = text.replace("if (n < 0) return", &format!("{crash}  if (n < 0) return"));
    directory.write(path, text.as_bytes());
    let options = "run echo/echo.gen reader/reader.gen --clock real --bounds none --socket s";
    let arguments: Vec<&str> = options.split(' ').collect();
    let run = Listening::start(&directory, &arguments);
    let crashed = directory.run(&["call", "--socket", "s", "echo", "count", "{\"n\": 13}"]);
    assert_eq!(status(&crashed), 1);
    assert!(stderr(&crashed).contains("::dotgen::lost"));
    let watched = directory.run(&["watch", "--socket", "s", "echo/each"]);
    assert_eq!(status(&watched), 1, "{}", stdout(&watched));
    assert!(stderr(&watched).contains("`echo` was ended by signal"), "{}", stderr(&watched));
    drop(run);
}

#[test]
fn a_signal_ends_a_simulated_run_with_its_report_and_profile() {
    let directory = with_body("");
    let arguments = [
        "run",
        "good/good.gen",
        "--clock",
        "real",
        "--simulate",
        "all",
        "--socket",
        "s",
        "--profile",
        "log",
    ];
    let mut run = Listening::start(&directory, &arguments);
    run.signal("-TERM");
    let status = ended(&mut run.0);
    assert!(matches!(status.code(), Some(1 | 3)), "{status}");
    // It has its name when it is complete.
    assert!(directory.path().join("log").exists());
    assert!(!directory.path().join("s").exists());
}

#[test]
fn data_of_ports_that_grows_is_seen_whole() {
    if !compilers() {
        return;
    }
    let task = |name: &str, ids: &str, port: &str, argument: &str, period: u32| {
        format!(
            "component {name} {{ version \"1\"; lang \"c\"; typedef sequence<octet> bytes; ids {{ {ids} }};
               port {port} bytes data;
               task main {{ period {period} ms;
                 codel<start> {name}_again({argument}, port {port} data) yield pause::start; }}; }};\n"
        )
    };
    let source = |name: &str, arguments: &str, body: &str| {
        format!(
            "#include \"ac{name}.h\"
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include \"{name}_c_types.h\"
genom_event {name}_again({arguments}, const {name}_data *data, const genom_context self) {{
  {body}
  return {name}_pause_start;
}}
"
        )
    };
    let write = "sequence_octet *it = data->data(self); uint32_t size = (++*n * 997) % 200000;
  if (genom_sequence_reserve(it, size)) abort();
  it->_length = size;
  memset(it->_buffer, size % 251, size);
  data->write(self);";
    let read = "sequence_octet *it; uint32_t i;
  data->read(self);
  it = data->data(self);
  if (it == NULL) return reads_pause_start;
  for (i = 0; i < it->_length; i++)
    if (it->_buffer[i] != it->_length % 251) abort();
  if (it->_length > 150000) creat(\"much\", 0600);
  (void)n;";
    let directory = Directory::new(&[
        ("w/writes.gen", &task("writes", "long n;", "out", "inout n", 1)),
        ("w/codels/writes.c", &source("writes", "int32_t *n", write)),
        ("r/reads.gen", &task("reads", "long n;", "in", "in n", 3)),
        ("r/codels/reads.c", &source("reads", "int32_t n", read)),
    ]);
    for clock in ["virtual", "real"] {
        let mut arguments = vec!["run", "w/writes.gen", "r/reads.gen", "--format", "json"];
        arguments.extend(["--bounds", "none", "--until", "1s", "--clock", clock]);
        arguments.extend(["--socket", "s"].iter().filter(|_| clock == "real"));
        let output = directory.run(&arguments);
        let report = json_of(&output);
        // On a busy machine a deadline may be missed.
        let violations = report["violations"].as_array().expect("a list");
        let lost = violations.iter().any(|violation| violation["kind"] != "check");
        assert!(!lost, "{report:#}");
        assert_eq!(report["simulated-codels"], 0, "{report:#}");
        assert!(directory.path().join("much").exists(), "{clock}");
        std::fs::remove_file(directory.path().join("much")).expect("it is there");
    }
}
