//! Components whose codels are looked at in a debugger.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::directory::{status, stderr};
use crate::running::{
    Lines, Listening, compilers, ended, hosts, installed, processes, soon, with_body,
};

#[test]
fn a_component_waits_for_a_debugger_which_stops_in_a_codel() {
    if !compilers() || !installed(&["gdb"]) {
        return;
    }
    let directory = with_body("");
    let arguments = ["run", "bad/bad.gen", "--debug", "--until", "1s", "--format", "json"];
    let mut command = directory.command(&arguments);
    let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut run = command.spawn().expect("the program starts");
    let mut said = BufReader::new(run.stdout.take().expect("it is piped"));
    let mut line = String::new();
    said.read_line(&mut line).expect("it is text");
    let waiting: Value = serde_json::from_str(&line).expect("it is JSON");
    assert_eq!(waiting["format"], 1);
    assert_eq!(waiting["component"], "bad");
    let process = waiting["process"].as_u64().expect("a number").to_string();
    // It stops where the codel begins, and knows what was handed to it: nothing is optimized out.
    let steps =
        ["break bad_again", "continue", "print *n", "next", "print *n", "delete", "continue"];
    let steps = steps.iter().flat_map(|step| ["-ex", step]);
    let gdb = Command::new("gdb")
        .args(["-nx", "-batch", "-p", &process])
        .args(steps)
        .output()
        .expect("gdb runs");
    let told = String::from_utf8_lossy(&gdb.stdout);
    assert!(told.contains("bad.c:"), "{told}");
    assert!(told.contains("$1 = 0") && told.contains("$2 = 1"), "{told}");
    // The run goes on to its end, and nothing was late: the virtual clock stood still meanwhile.
    let mut report = String::new();
    said.read_to_string(&mut report).expect("it is text");
    let report: Value = serde_json::from_str(&report).expect("it is JSON");
    assert_eq!(report["end"], "done", "{report:#}");
    assert_eq!(report["violation-count"], 0, "{report:#}");
    assert!(ended(&mut run).success());
    assert_eq!(processes(&directory), Vec::<String>::new());
}

#[test]
fn a_run_that_waits_for_a_debugger_can_be_ended() {
    if !compilers() {
        return;
    }
    let directory = with_body("");
    let mut command = directory.command(&["run", "bad/bad.gen", "--debug"]);
    let run = command.stderr(Stdio::piped()).spawn().expect("it starts");
    // It ends with the test, whatever comes of that.
    let mut run = Listening(run, Lines::default());
    let mut said = BufReader::new(run.0.stderr.take().expect("it is piped"));
    let mut text = String::new();
    while !text.contains("`bad` waits for a debugger: gdb -p ") {
        assert_ne!(said.read_line(&mut text).expect("it is text"), 0, "{text}");
    }
    run.signal("-INT");
    assert_eq!(ended(&mut run.0).code(), Some(3));
    assert_eq!(processes(&directory), Vec::<String>::new());
}

#[test]
fn a_debugger_is_for_one_run_of_codels() {
    let directory = with_body("");
    for (more, why) in [
        (&["--runs", "2"][..], "without `--runs`"),
        (&["--simulate", "all"][..], "leave `--simulate all` out"),
    ] {
        let output = directory.run(&[&["run", "bad/bad.gen", "--debug"], more].concat());
        assert_eq!(status(&output), 2);
        assert!(stderr(&output).contains(why), "{}", stderr(&output));
    }
}

#[test]
fn processes_and_threads_have_the_names_of_components_and_tasks() {
    if !compilers() {
        return;
    }
    let directory = with_body("");
    let arguments = ["run", "bad/bad.gen", "good/good.gen", "--clock", "real", "--socket", "s"];
    let _run = Listening::start(&directory, &arguments);
    let name = |path: &Path| {
        let name = std::fs::read_to_string(path.join("comm")).unwrap_or_default();
        name.trim().to_owned()
    };
    let names = || {
        let of_host = |host: u32| {
            let path = PathBuf::from(format!("/proc/{host}"));
            let threads = std::fs::read_dir(path.join("task")).into_iter().flatten();
            let mut threads: Vec<String> =
                threads.flatten().map(|thread| name(&thread.path())).collect();
            threads.sort();
            (name(&path), threads)
        };
        let mut found: Vec<_> = hosts(&directory).into_iter().map(of_host).collect();
        found.sort();
        found
    };
    let is = |component: &str| {
        (component.to_owned(), [component, "main", "watch"].map(str::to_owned).to_vec())
    };
    let wanted = [is("bad"), is("good")];
    soon("their names", || (names() == wanted).then_some(()));
}
