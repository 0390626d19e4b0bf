//! Input ports of a run, which clients write.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::net::UnixStream;
use std::process::{Output, Stdio};

use serde_json::{Value, json};

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{Listening, compilers, ended, installed, json_of, soon, talk};

const TYPES: &str = include_str!("hosted/types.idl");

/// `reader`, whose port `seen` is its input port `trail` backwards, and whose port `sum` is one more than the
/// instance `a` of its input port `each`; and `echo`, which has output ports of these names.
fn components() -> Directory {
    let echo = include_str!("hosted/echo.gen").replace("LANG", "c");
    let reader = include_str!("hosted/reader.gen").replace("LANG", "c");
    Directory::new(&[
        ("types.idl", TYPES),
        ("echo.gen", &echo),
        ("reader.gen", &reader),
        ("codels/echo.c", include_str!("hosted/echo.c")),
        ("codels/reader.c", include_str!("hosted/reader.c")),
        ("alone/types.idl", TYPES),
        ("alone/reader.gen", &reader),
        ("alone/codels/reader.c", include_str!("hosted/reader.c")),
    ])
}

fn run(directory: &Directory, files: &[&str], more: &[&str]) -> Listening {
    let options = ["--clock", "real", "--bounds", "none", "--socket", "s"];
    Listening::start(directory, &[&["run"], files, &options, more].concat())
}

/// `reader` alone: nothing writes its input ports.
fn alone() -> Option<(Directory, Listening)> {
    if !compilers() {
        return None;
    }
    let directory = components();
    let run = run(&directory, &["alone/reader.gen"], &[]);
    Some((directory, run))
}

fn write(directory: &Directory, words: &[&str]) -> Output {
    directory.run(&[&["write", "--socket", "s"], words].concat())
}

fn written(directory: &Directory, words: &[&str]) {
    let output = write(directory, words);
    assert_eq!(status(&output), 0, "{words:?}: {}", stderr(&output));
    assert_eq!(stdout(&output) + &stderr(&output), "");
}

/// The message for what cannot be written.
fn refused(directory: &Directory, words: &[&str]) -> String {
    let output = write(directory, words);
    assert_eq!(status(&output), 2, "{words:?}: {}", stdout(&output));
    stderr(&output)
}

/// Waits until an output port has a value.
fn reads(directory: &Directory, port: &str, value: &Value) {
    soon(&format!("{port} is {value}"), || {
        let answers = ask(directory, &[json!({"id": 1, "read": port})]);
        (answers[0]["value"] == *value).then_some(())
    });
}

/// The answers to requests, one for each.
fn ask(directory: &Directory, requests: &[Value]) -> Vec<Value> {
    let mut client = UnixStream::connect(directory.path().join("s")).expect("it listens");
    let mut lines = BufReader::new(client.try_clone().expect("a copy")).lines();
    let mut answer = |request: &Value| {
        writeln!(client, "{request}").expect("it reads");
        let line = lines.next().expect("an answer").expect("text");
        serde_json::from_str(&line).expect("JSON")
    };
    requests.iter().map(&mut answer).collect()
}

#[test]
fn codels_read_what_clients_write() {
    let Some((directory, _run)) = alone() else {
        return;
    };
    let trail = r#"[{"x": 1, "y": 2}, {"x": 3}]"#;
    written(&directory, &["reader/trail", trail]);
    reads(&directory, "reader/seen", &json!([{"x": 3.0, "y": 0.0}, {"x": 1.0, "y": 2.0}]));
    written(&directory, &["reader/each", "--instance", "a", "-43"]);
    reads(&directory, "reader/sum", &json!(-42));
    // Data that is longer than before.
    let long: Vec<Value> = (0..1000).map(|number| json!({"x": 0.5, "y": number})).collect();
    let request = json!({"id": "a", "write": "reader/trail", "value": long});
    let answers = ask(&directory, &[request]);
    assert_eq!(answers, [json!({"id": "a", "event": "written", "version": 1})]);
    let backwards: Vec<Value> =
        (0..1000).rev().map(|number| json!({"x": 0.5, "y": f64::from(number)})).collect();
    reads(&directory, "reader/seen", &json!(backwards));
    // Thousands that nobody has read are none but the last.
    let many: Vec<Value> = (0..5000)
        .map(|number| json!({"id": number, "write": "reader/each", "instance": "a", "value": number}))
        .collect();
    let answers = ask(&directory, &many);
    assert!(answers.iter().all(|answer| answer["event"] == "written"));
    reads(&directory, "reader/sum", &json!(5000));
    let described = &ask(&directory, &[json!({"describe": null})])[0];
    let each = &described["components"][0]["ports"][1];
    let known = json!([each["name"], each["direction"], each["multiple"], each["schema"]["type"]]);
    assert_eq!(known, json!(["each", "in", true, "integer"]));
}

#[test]
fn the_client_in_python_writes_input_ports() {
    if !installed(&["python3"]) {
        return;
    }
    let Some((directory, _run)) = alone() else {
        return;
    };
    talk(&directory, "inputs.py");
}

#[test]
fn what_does_not_fit_an_input_port_is_named() {
    let Some((directory, _run)) = alone() else {
        return;
    };
    let told = |words: &[&str], what: &str| {
        let told = refused(&directory, words);
        assert!(told.contains(what), "{words:?}: {told}");
    };
    told(&["raeder/trail", "[]"], "did you mean `reader`?");
    told(&["reader/trial", "[]"], "did you mean `trail`?");
    told(&["reader/seen", "[]"], "`reader/seen` is an output port");
    told(&["reader", "[]"], "write COMPONENT/PORT");
    told(&["reader/trail", "5"], "the value has to be a list");
    told(&["reader/trail", r#"[{"x": "far"}]"#], "`[0].x` has to be a number");
    told(&["reader/trail", r#"[{"z": 1}]"#], "`[0].z` is not a member");
    told(&["reader/each", "1"], "give the `instance`");
    told(&["reader/trail", "[]", "--instance", "a"], "it is not `multiple`");
    told(&["reader/trail", "here"], "the value is not valid JSON");
    told(&["reader/trail", "[]", "--rate", "0"], "values per second");
    told(&["reader/trail"], "<JSON>");
    let wrong = [
        json!({"id": 1, "write": "reader/trail"}),
        json!({"id": 2, "write": "reader/each", "value": 1, "instance": 5}),
    ];
    let answers = ask(&directory, &wrong);
    assert_eq!(answers[0]["message"], "`write` needs a `value` for `reader/trail`");
    assert_eq!(answers[1]["message"], "the instance 5 of `reader/each` is not text");
    let many: Vec<Value> = (0..257)
        .map(|number| json!({"id": number, "write": "reader/each", "instance": format!("i{number}"), "value": 1}))
        .collect();
    let answers = ask(&directory, &many);
    assert!(answers[..256].iter().all(|answer| answer["event"] == "written"));
    assert_eq!(answers[256]["message"], "`reader/each` has 256 instances; write one of them");
}

#[test]
fn an_input_port_that_an_output_port_feeds_is_refused() {
    if !compilers() {
        return;
    }
    let directory = components();
    let run = run(&directory, &["echo.gen", "reader.gen"], &[]);
    let told = refused(&directory, &["reader/trail", "[]"]);
    assert!(told.contains("`reader/trail` is connected to `echo/trail`"), "{told}");
    assert!(told.contains("connect_port"), "{told}");
    let told = refused(&directory, &["reader/each", "1", "--instance", "new"]);
    assert!(told.contains("connected to `echo/each`"), "{told}");
    drop(run);
    // The same with a component that is simulated.
    let words = ["run", "reader.gen", "--clock", "real", "--simulate", "all", "--socket", "s"];
    let _run = Listening::start(&directory, &words);
    let told = refused(&directory, &["reader/trail", "[]"]);
    assert!(told.contains("`reader` is simulated"), "{told}");
}

#[test]
fn a_client_connects_an_input_port_and_so_ends_its_writing() {
    if !compilers() {
        return;
    }
    let directory = Directory::new(&[]);
    for name in ["first", "second"] {
        let specification = "typedef long NAME_data;
component NAME { version \"1\"; lang \"c\"; ids { long n; };
  port in NAME_data NAME_in;
  port out NAME_data NAME_out;
  task main { period 5 ms;
    codel<start> NAME_go(port in NAME_in, port out NAME_out) yield pause::start wcet 1 ms; }; };";
        let source = "#include \"acNAME.h\"
#include \"NAME_c_types.h\"
genom_event NAME_go(const NAME_NAME_in *from, const NAME_NAME_out *to, const genom_context self) {
  if (from->read(self) == genom_ok && from->data(self)) *to->data(self) = *from->data(self);
  to->write(self);
  return NAME_pause_start;
}
";
        let path = format!("{name}/{name}.gen");
        directory.write(&path, specification.replace("NAME", name).as_bytes());
        let path = format!("{name}/codels/{name}.c");
        directory.write(&path, source.replace("NAME", name).as_bytes());
    }
    let run = run(&directory, &["first/first.gen", "second/second.gen"], &["--record", "run.mcap"]);
    written(&directory, &["first/first_in", "7"]);
    written(&directory, &["second/second_in", "8"]);
    reads(&directory, "second/second_out", &json!(8));
    let connect = r#"{"local": "second_in", "remote": "first/first_out"}"#;
    let output = directory.run(&["call", "--socket", "s", "second", "connect_port", connect]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    reads(&directory, "second/second_out", &json!(7));
    let told = refused(&directory, &["second/second_in", "8"]);
    assert!(told.contains("is connected to `first/first_out`"), "{told}");
    let mut run = run;
    run.signal("-INT");
    ended(&mut run.0);
    // The recording is one of the model, whatever was written meanwhile.
    let files = ["replay", "run.mcap", "first/first.gen", "second/second.gen", "--format", "json"];
    let report = json_of(&directory.run(&files));
    assert!(report["steps"].as_u64() > Some(10), "{report:#}");
    assert_eq!(report["followed"], report["steps"]);
    let longer = report["differences"].as_array().expect("a list");
    assert!(longer.iter().all(|difference| difference["kind"] == "longer"), "{report:#}");
}

#[test]
fn a_recording_is_played_into_input_ports() {
    if !compilers() {
        return;
    }
    let directory = components();
    let recorded = "run echo.gen --bounds none --until 300ms --record run.mcap";
    let recorded: Vec<&str> = recorded.split(' ').collect();
    let output = directory.run(&recorded);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let _run = run(&directory, &["alone/reader.gen"], &[]);
    let play =
        |words: &[&str]| directory.run(&[&["play", "run.mcap", "--socket", "s"], words].concat());
    let output = play(&["--speed", "10"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    insta::assert_snapshot!(stdout(&output));
    // The newest data of the other run, backwards.
    let recorded = std::fs::read(directory.path().join("run.mcap")).expect("it is there");
    let data = dotgen_recording::record::read_data(&recorded).expect("a recording");
    let newest = |topic: &str| -> Value {
        let mut all = data.messages.iter();
        let last = all.rfind(|message| data.topics[&message.channel] == topic);
        let last: Value = serde_json::from_slice(&last.expect("data").text).expect("JSON");
        last["value"].clone()
    };
    let mut last = newest("/echo/trail").as_array().expect("a list").clone();
    last.reverse();
    let number = newest("/echo/each/a").as_i64().expect("a number");
    reads(&directory, "reader/sum", &json!(number + 1));
    reads(&directory, "reader/seen", &json!(last));
    // Another instance; what does not fit is told.
    let output = play(&[
        "--topic",
        "echo/each/a=reader/each/b",
        "--topic",
        "/echo/trail=reader/each/t",
        "--speed",
        "10",
    ]);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    insta::assert_snapshot!(stdout(&output));
    let told = |words: &[&str], what: &str| {
        let output = play(words);
        assert_eq!(status(&output), 2, "{}", stdout(&output));
        assert!(stderr(&output).contains(what), "{}", stderr(&output));
    };
    told(&["--topic", "echo/trial=reader/trail"], "did you mean `echo/trail`?");
    told(&["--topic", "echo/trail=reader/trial"], "did you mean `reader/trail`?");
    told(&["--topic", "echo/trail"], "write FROM=TO");
    told(&["--speed", "0"], "write a number from");
    directory.write("text.mcap", b"some text");
    let output = directory.run(&["play", "text.mcap", "--socket", "s"]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("no MCAP file"), "{}", stderr(&output));
}

#[test]
fn lines_are_values() {
    let Some((directory, mut run)) = alone() else {
        return;
    };
    written(&directory, &["reader/trail", "[]"]);
    // Each line is a value when it comes.
    let words = ["write", "--socket", "s", "reader/each", "--instance", "a", "-"];
    let mut command = directory.command(&words);
    let mut child =
        command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut input = child.stdin.take().expect("it is piped");
    for value in [4, 9] {
        writeln!(input, "{value}").expect("it reads");
        reads(&directory, "reader/sum", &json!(value + 1));
    }
    writeln!(input, "\nnine\n1.5\n12").expect("it reads");
    drop(input);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    reads(&directory, "reader/sum", &json!(13));
    let told = stderr(&output);
    assert!(told.contains("line 4 was not written: the value is not valid JSON"), "{told}");
    assert!(told.contains("line 5 was not written: `reader/each`: the value has to be"), "{told}");
    // The same value until the run ends.
    let words = ["write", "--socket", "s", "reader/each", "--instance", "a", "--rate", "200", "20"];
    let mut repeating = directory.command(&words).spawn().expect("it starts");
    reads(&directory, "reader/sum", &json!(21));
    // It is written again after another value.
    written(&directory, &["reader/each", "30", "--instance", "a"]);
    reads(&directory, "reader/sum", &json!(21));
    run.signal("-INT");
    ended(&mut run.0);
    assert!(ended(&mut repeating).success());
}
