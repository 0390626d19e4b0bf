//! Every end of a run is orderly: activities, then tasks execute their `stop` codels.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::net::UnixStream;
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{
    Listening, compilers, ended, installed, processes, soon, talk, violation, with_body,
};

const DRIVE: &str = r#"
struct speed_s { double v; };
component drive {
  version "1"; lang "LANG";
  ids { long n; };
  port out speed_s speed;
  task main {
    period 10 ms;
    codel<start> drive_init(out n) yield main wcet 9 ms;
    codel<main> drive_tick(inout n) yield pause::main wcet 9 ms;
    codel<stop> drive_end(inout n) yield ether wcet 9 ms;
  };
  activity go(in double v) {
    task main;
    codel<start> drive_go(in v, out speed) yield pause::start wcet 9 ms;
    codel<stop> drive_halt(out speed) yield ether wcet 9 ms;
  };
};
"#;

/// Functions for both languages. If the speed is more than 8, the codel of the activity sleeps.
const HELPERS: &str = r#"
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
static void note(const char *what) { FILE *f = fopen("notes", "a"); fprintf(f, "%s\n", what); fclose(f); }
static void go(double v) { static int first = 1; if (first) note("go"); first = 0; if (v > 8) usleep(60000); }
static void halt(void) { note("activity"); while (getenv("HANG")) pause(); }
"#;

const IN_C: &str = r#"
genom_event drive_init(int32_t *n, const genom_context self)
{ (void)self; *n = 0; return drive_main; }
genom_event drive_tick(int32_t *n, const genom_context self)
{ (void)self; *n += 1; return drive_pause_main; }
genom_event drive_end(int32_t *n, const genom_context self)
{ (void)n; (void)self; note("task"); return drive_ether; }
genom_event drive_go(double v, const drive_speed *speed, const genom_context self)
{ speed->data(self)->v = v; speed->write(self); go(v); return drive_pause_start; }
genom_event drive_halt(const drive_speed *speed, const genom_context self)
{ speed->data(self)->v = 0; speed->write(self); halt(); return drive_ether; }
"#;

const IN_CXX: &str = r#"
genom::event drive_init(int32_t &n) { n = 0; return drive::main; }
genom::event drive_tick(int32_t &n) { n += 1; return drive::pause::main; }
genom::event drive_end(int32_t &n) { (void)n; note("task"); return drive::ether; }
genom::event drive_go(double v, drive::speed &speed)
{ speed.data().v = v; speed.write(); go(v); return drive::pause::start; }
genom::event drive_halt(drive::speed &speed)
{ speed.data().v = 0; speed.write(); halt(); return drive::ether; }
"#;

/// The component in a language.
fn drive(language: &str) -> Directory {
    let (name, types, codels) = match language {
        "c" => ("codels/drive.c", "drive_c_types.h", IN_C),
        _ => ("codels/drive.cc", "drive_cxx_types.h", IN_CXX),
    };
    let source = format!("#include \"acdrive.h\"\n#include \"{types}\"\n{HELPERS}{codels}");
    let specification = DRIVE.replace("LANG", language);
    Directory::new(&[("drive.gen", specification.as_str()), (name, source.as_str())])
}

/// Starts a run on the real clock, with the activity under way.
fn begin(directory: &Directory, speed: u32, hangs: bool, options: &[&str]) -> Listening {
    begin_with(directory, "drive.gen", speed, hangs, options)
}

/// The same, of a file.
fn begin_with(
    directory: &Directory,
    file: &str,
    speed: u32,
    hangs: bool,
    options: &[&str],
) -> Listening {
    let mut arguments = vec!["run", file, "--clock", "real", "--socket", "s"];
    arguments.extend(["--bounds", "none", "--format", "json", "--record", "run.mcap"]);
    arguments.extend(options);
    let report = std::fs::File::create(directory.path().join("report.json")).expect("a file");
    let mut command = directory.command(&arguments);
    if hangs {
        command.env("HANG", "1");
    }
    let run = Listening::begin_with_output(&mut command, report.into());
    let input = format!("{{\"v\": {speed}}}");
    let mut call = directory.command(&["call", "--socket", "s", "drive", "go", &input]);
    call.stdout(Stdio::null()).stderr(Stdio::null());
    let mut call = call.spawn().expect("a call");
    std::thread::spawn(move || call.wait());
    soon("the activity", || notes(directory).starts_with("go\n").then_some(()));
    run
}

/// The notes of the codels, in order.
fn notes(directory: &Directory) -> String {
    std::fs::read_to_string(directory.path().join("notes")).unwrap_or_default()
}

fn report(directory: &Directory) -> Value {
    serde_json::from_str(&directory.read("report.json")).expect("JSON")
}

const IN_ORDER: &str = "go\nactivity\ntask\n";

#[test]
fn every_end_executes_the_stop_codels() {
    if !compilers() {
        return;
    }
    for language in ["c", "c++"] {
        let directory = drive(language);
        for end in ["-INT", "-TERM", "-HUP"] {
            directory.write("notes", b"");
            let mut run = begin(&directory, 5, false, &[]);
            run.signal(end);
            let code = ended(&mut run.0).code();
            assert_eq!(notes(&directory), IN_ORDER, "{language} {end}");
            let report = report(&directory);
            let violated = report["violation-count"] != 0;
            assert_eq!(code, Some(if violated { 1 } else { 3 }), "{report:#}");
            assert_eq!(
                (&report["end"], &report["unfinished"]),
                (&json!("interrupted"), &Value::Null)
            );
        }
        // A run that ends by itself, and the end in its recording.
        directory.write("notes", b"");
        let mut run = begin(&directory, 5, false, &["--until", "2s"]);
        assert!(matches!(ended(&mut run.0).code(), Some(0 | 1)));
        assert_eq!(notes(&directory), IN_ORDER, "{language}");
        let replayed = directory.run(&["replay", "run.mcap", "drive.gen", "--format", "json"]);
        let replayed: Value = serde_json::from_str(&stdout(&replayed)).expect("JSON");
        assert_eq!(replayed["difference-count"], replayed["violation-count"], "{replayed:#}");
        assert_eq!(processes(&directory), Vec::<String>::new());
    }
}

#[test]
fn a_late_codel_ends_its_activity_or_the_run_in_order() {
    if !compilers() {
        return;
    }
    let directory = drive("c");
    for action in ["stop-activity", "stop"] {
        directory.write("notes", b"");
        let mut run = begin(&directory, 9, false, &["--on-violation", action]);
        // The violation is reported before the codel has returned.
        run.told("violated the execution time of drive.go.start");
        if action == "stop-activity" {
            // The run goes on without it.
            soon("its stop codel", || notes(&directory).contains("activity").then_some(()));
            run.signal("-INT");
        }
        assert_eq!(ended(&mut run.0).code(), Some(1));
        assert_eq!(notes(&directory), IN_ORDER, "{action}");
        let report = report(&directory);
        assert_eq!(violation(&report, "overrun")["function"], "drive_go", "{report:#}");
    }
}

/// A measure interrupts the activity whose codel is late, and ends the run.
#[test]
fn a_measure_of_the_scenario_is_taken() {
    if !compilers() {
        return;
    }
    let directory = drive("c");
    // At this speed, the codel and so the next write of the port take 60 ms.
    for event in ["on late drive.go.start", "on stale drive.speed after 30 ms"] {
        let measure = format!("{event} {{ abort drive.go; stop; }}");
        let scenario = format!("scenario drive {{ use \"drive.gen\"; {measure} }}\n");
        directory.write("drive.scn", scenario.as_bytes());
        directory.write("notes", b"");
        let mut run = begin_with(&directory, "drive.scn", 9, false, &[]);
        assert_eq!(ended(&mut run.0).code(), Some(1));
        assert_eq!(notes(&directory), IN_ORDER);
        let report = report(&directory);
        assert_eq!(report["end"], "measure", "{report:#}");
        assert_eq!(report["checks"][0]["of"], event, "{report:#}");
    }
    let replayed = directory.run(&["replay", "run.mcap", "drive.scn"]);
    let said = stdout(&replayed);
    assert!(said.contains("drive.go.start") && !said.contains("no run of"), "{said}");
}

#[test]
fn violations_are_told_while_they_happen() {
    if !installed(&["python3"]) || !compilers() {
        return;
    }
    let directory = drive("c");
    let mut run = begin(&directory, 9, false, &[]);
    let mut client = UnixStream::connect(directory.path().join("s")).expect("it listens");
    client.write_all(b"{\"id\": 9, \"violations\": null}\n").expect("it reads");
    let mut events = BufReader::new(&client)
        .lines()
        .map(|line| -> Value { serde_json::from_str(&line.expect("a line")).expect("JSON") });
    let first = events.next().expect("an answer");
    assert_eq!((&first["id"], &first["event"]), (&json!(9), &json!("following")));
    let mut overruns = events.filter(|event| event["violation"]["kind"] == "overrun");
    let first = overruns.next().expect("the run goes on");
    assert_eq!(first["event"], "violation");
    assert_eq!(first["violation"]["function"], "drive_go", "{first:#}");
    let again = overruns.next().expect("the run goes on");
    assert_eq!(first["number"], again["number"]);
    assert!(again["violation"]["times"].as_u64() > first["violation"]["times"].as_u64());
    talk(&directory, "violations.py");
    run.told("again, ");
    run.signal("-INT");
    assert_eq!(ended(&mut run.0).code(), Some(1));
    let report = report(&directory);
    let number = first["number"].as_u64().and_then(|number| usize::try_from(number).ok());
    let reported = &report["violations"][number.expect("a number")];
    assert_eq!(reported["at"], first["violation"]["at"], "{report:#}");
    assert!(reported["times"].as_u64() >= again["violation"]["times"].as_u64(), "{report:#}");
}

#[test]
fn a_stop_codel_that_does_not_return_is_named() {
    if !compilers() {
        return;
    }
    let directory = drive("c");
    for (options, signals) in [(&["--stop-within", "1s"][..], 1), (&[][..], 2)] {
        directory.write("notes", b"");
        let mut run = begin(&directory, 5, true, options);
        run.signal("-INT");
        soon("the stop codel", || notes(&directory).contains("activity").then_some(()));
        if signals > 1 {
            run.signal("-INT");
        }
        assert_eq!(ended(&mut run.0).code(), Some(4));
        assert_eq!(report(&directory)["unfinished"], json!(["drive.go.stop"]));
        assert_eq!(processes(&directory), Vec::<String>::new());
    }
}

#[test]
fn nobody_drives_alone() {
    if !compilers() {
        return;
    }
    for language in ["c", "c++"] {
        let directory = drive(language);
        for (signal, why) in [
            ("-KILL", "its channel to the engine has ended"),
            ("-STOP", "the engine gave no sign of life for 0.5 s"),
        ] {
            directory.write("notes", b"");
            let mut run = begin(&directory, 5, false, &["--engine-within", "500ms"]);
            run.signal(signal);
            soon("the end of the host", || processes(&directory).is_empty().then_some(()));
            assert_eq!(notes(&directory), IN_ORDER, "{language} {signal}");
            let told = format!("`drive` is left alone: {why}; stopped: drive.go, drive.main");
            run.told(&told);
            if signal == "-STOP" {
                run.signal("-CONT");
                run.told("violated that components run: `drive` had no engine");
                run.signal("-INT");
                assert_eq!(ended(&mut run.0).code(), Some(1));
                assert_eq!(notes(&directory), IN_ORDER);
            }
        }
    }
}

#[test]
fn a_host_that_is_left_alone_does_not_wait_for_ever() {
    if !compilers() {
        return;
    }
    let directory = drive("c");
    let run = begin(&directory, 5, true, &["--stop-within", "1s"]);
    run.signal("-KILL");
    run.told("stopped: drive.main; not stopped in time: drive.go");
    soon("the end of the host", || processes(&directory).is_empty().then_some(()));
    assert_eq!(notes(&directory), IN_ORDER);
}

#[test]
fn a_run_on_the_virtual_clock_ends_in_order() {
    if !compilers() {
        return;
    }
    let directory = drive("c");
    let arguments = ["run", "drive.gen", "--until", "100ms", "--bounds", "none"];
    assert!(matches!(status(&directory.run(&arguments)), 0 | 1));
    assert!(notes(&directory).ends_with("task\n"), "{}", notes(&directory));
}

#[test]
fn a_unit_for_systemd_starts_the_same_run() {
    let directory = Directory::new(&[("c.gen", "component c { task main { period 10 ms; }; };\n")]);
    let output = directory.run(&["run", "c.gen", "--clock", "real", "--systemd", "--seed", "3"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let unit = stdout(&output);
    let command = " run c.gen --clock real --seed 3\n";
    assert!(unit.contains("\nExecStart=/") && unit.contains(command), "{unit}");
    assert!(unit.contains("\nLimitRTPRIO=49\n"), "{unit}");
    // A run that ended after a violation is not started again.
    assert!(unit.contains("\nRestartPreventExitStatus=1 2 4\n"), "{unit}");
    assert!(unit.contains("\nTimeoutStopSec=7\n"), "{unit}");
}

#[test]
fn a_run_that_is_ended_leaves_nothing_behind() {
    if !compilers() {
        return;
    }
    let directory = with_body("");
    let arguments = ["run", "good/good.gen", "--clock", "real", "--socket", "s"];
    let socket = directory.path().join("s");
    let mut run = Listening::start(&directory, &arguments);
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::metadata(&socket).expect("it is there").permissions();
        assert_eq!(mode.mode() & 0o777, 0o600);
    }
    let taken = directory.run(&arguments);
    assert_eq!(status(&taken), 2);
    assert!(stderr(&taken).contains("another run listens"), "{}", stderr(&taken));
    run.signal("-TERM");
    let status = ended(&mut run.0);
    // It was interrupted; on a busy machine it may have missed a deadline before.
    assert!(matches!(status.code(), Some(1 | 3)), "{status}");
    assert!(!socket.exists());
    assert_eq!(processes(&directory), Vec::<String>::new());

    let run = Listening::start(&directory, &arguments);
    run.signal("-KILL");
    let begin = Instant::now();
    while !processes(&directory).is_empty() {
        assert!(begin.elapsed() < Duration::from_secs(20), "a host is left");
        std::thread::yield_now();
    }
    // A killed run leaves its socket, and the next run takes the same path.
    assert!(socket.exists());
    drop(Listening::start(&directory, &arguments));
}
