//! Ports between machines, by Zenoh: two runs that know of each other by an endpoint only.
#![cfg(all(target_os = "linux", feature = "zenoh"))]

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{Ipv4Addr, TcpListener};
use std::os::unix::net::UnixStream;
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{Listening, compilers, soon};

/// Maximum time until another machine is reported as gone: a second by the manual, and as much for a slow
/// machine.
const GONE_TIMEOUT: Duration = Duration::from_secs(2);

const TYPES: &str = include_str!("hosted/types.idl");

/// Somewhere nobody listens.
pub(crate) fn endpoint() -> String {
    let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
    let address = free.local_addr().expect("it has an address");
    format!("tcp/{address}")
}

fn component(name: &str, specification: &str, source: &str) -> Directory {
    Directory::new(&[
        (&format!("{name}.gen"), &specification.replace("LANG", "c") as &str),
        ("types.idl", TYPES),
        (&format!("codels/{name}.c"), source),
    ])
}

pub(crate) fn echo() -> Directory {
    let specification = include_str!("hosted/echo.gen");
    component("echo", specification, include_str!("hosted/echo.c"))
}

pub(crate) fn reader() -> Directory {
    let specification = include_str!("hosted/reader.gen");
    component("reader", specification, include_str!("hosted/reader.c"))
}

pub(crate) fn run(directory: &Directory, file: &str, more: &[&str]) -> Listening {
    let mut arguments = vec!["run", file, "--clock", "real", "--bounds", "none"];
    arguments.extend(["--until", "60s", "--socket", "s"]);
    arguments.extend(more);
    Listening::start(directory, &arguments)
}

/// The newest data of a port.
fn newest(directory: &Directory, port: &str) -> String {
    let output = directory.run(&["watch", "--socket", "s", port, "-n", "1"]);
    stdout(&output)
}

#[test]
fn a_port_of_another_machine_is_read_by_its_name() {
    if !compilers() {
        return;
    }
    let (writes, reads) = (echo(), reader());
    let endpoint = endpoint();
    let first = run(&writes, "echo.gen", &["--zenoh-listen", &endpoint]);
    let second = run(&reads, "reader.gen", &["--zenoh-connect", &endpoint]);
    // The instance `a` of a port that is `multiple` holds 70, and the reader adds one.
    soon("the instance", || (newest(&reads, "reader/sum") == "71\n").then_some(()));
    soon("structures", || {
        let seen = newest(&reads, "reader/seen");
        seen.contains("\"x\":").then_some(())
    });
    // The data stays when its source is gone.
    drop(first);
    second.told("`echo` of the machine");
    second.told("has disappeared");
    assert_eq!(newest(&reads, "reader/sum"), "71\n");
}

/// A value of several batches of Zenoh, which crosses whole or not at all.
#[test]
fn a_large_value_arrives() {
    if !compilers() {
        return;
    }
    let part = |name: &str, ports: &str, codel: &str, body: &str| {
        let specification = format!(
            "module m {{ struct image {{ octet data[200000]; }}; typedef octet pixel; }};
             component {name} {{ version \"1\"; lang \"c\"; {ports}
               task main {{ period 500 ms; codel<start> {codel} yield pause::start; }}; }};\n"
        );
        let source = format!(
            "#include \"ac{name}.h\"\n#include \"{name}_c_types.h\"\n{body}\n\
             return {name}_pause_start; }}\n"
        );
        let directory = Directory::new(&[]);
        directory.write(&format!("{name}.gen"), specification.as_bytes());
        directory.write(&format!("codels/{name}.c"), source.as_bytes());
        directory
    };
    let writes = part(
        "camera",
        "port out m::image image;",
        "camera_take(port out image)",
        "genom_event camera_take(const camera_image *image, const genom_context self) {
           image->data(self)->data[199999] = 42; image->write(self);",
    );
    let reads = part(
        "viewer",
        "port in m::image image; port out m::pixel last;",
        "viewer_show(port in image, port out last)",
        "genom_event viewer_show(const viewer_image *image, const viewer_last *last,
                                 const genom_context self) {
           if (image->read(self) == genom_ok && image->data(self) != NULL) {
             *last->data(self) = image->data(self)->data[199999]; last->write(self); }",
    );
    let endpoint = endpoint();
    let _first = run(&writes, "camera.gen", &["--zenoh-listen", &endpoint]);
    let _second = run(&reads, "viewer.gen", &["--zenoh-connect", &endpoint]);
    soon("the image", || (newest(&reads, "viewer/last") == "42\n").then_some(()));
}

/// The next report of progress.
fn progress(directory: &Directory) -> Value {
    let mut stream = UnixStream::connect(directory.path().join("s")).expect("it listens");
    stream.write_all(b"{\"progress\": null}\n").expect("it reads");
    let lines = BufReader::new(stream).lines().map_while(Result::ok);
    let mut values = lines.map(|line| serde_json::from_str::<Value>(&line).expect("it is JSON"));
    let progress = values.find(|value| value["event"] == "progress");
    progress.expect("it goes on")
}

/// The components of other machines.
fn remote(directory: &Directory) -> Value {
    progress(directory)["remote"].take()
}

#[test]
fn a_machine_that_goes_away_is_reported_and_ends_nothing_else() {
    if !compilers() {
        return;
    }
    let (stays, leaves) = (echo(), reader());
    let endpoint = endpoint();
    let stay = run(&stays, "echo.gen", &["--zenoh-listen", &endpoint]);
    let leave = run(&leaves, "reader.gen", &["--zenoh-connect", &endpoint]);
    stay.told("has appeared");
    leave.told("has appeared");
    let there = remote(&stays);
    assert_eq!(there[0]["component"], "reader");
    assert_eq!(there[0]["present"], true);
    let host = there[0]["host"].as_str().expect("a name");
    let begin = Instant::now();
    leave.signal("-KILL");
    let told = stay.told(&format!("`reader` of the machine `{host}` has disappeared"));
    let took = told.duration_since(begin);
    eprintln!("a killed run was reported as gone after {took:?}");
    assert!(took < GONE_TIMEOUT, "{took:?}");
    assert_eq!(remote(&stays)[0]["present"], false);
    let called = stays.run(&["call", "--socket", "s", "echo", "get_gain"]);
    assert_eq!(status(&called), 0, "{}", stderr(&called));
    // A later run is seen again.
    let _again = run(&leaves, "reader.gen", &["--zenoh-connect", &endpoint]);
    soon("it appears again", || (remote(&stays)[0]["present"] == true).then_some(()));
}

#[test]
fn the_key_can_be_chosen_and_nonsense_is_told() {
    if !compilers() {
        return;
    }
    let directory = reader();
    let wrong = |more: &[&str]| {
        let mut arguments = vec!["run", "reader.gen", "--bounds", "none"];
        arguments.extend(more);
        let output = directory.run(&arguments);
        assert_eq!(status(&output), 2, "{}", stdout(&output));
        stderr(&output)
    };
    let real = ["--clock", "real", "--until", "1s", "--socket", "s"];
    let endpoint = endpoint();
    let connect = ["--zenoh-connect", endpoint.as_str()];
    let with = |more: &[&str]| wrong(&[&real[..], &connect, more].concat());
    let told = with(&["--zenoh-read", "reader.nothing=echo/trail"]);
    assert!(told.contains("`reader` has no input port `nothing`"), "{told}");
    let told = with(&["--zenoh-read", "nobody.trail=echo/trail"]);
    assert!(told.contains("no component `nobody` runs"), "{told}");
    let told = with(&["--zenoh-read", "trail"]);
    assert!(told.contains("COMPONENT.PORT=KEY"), "{told}");
    let told = wrong(&[&real[..], &["--zenoh-listen", "nonsense"]].concat());
    assert!(told.contains("nonsense"), "{told}");
    let told = wrong(&["--zenoh-read", "reader.trail=echo/trail"]);
    assert!(told.contains("--zenoh-listen"), "{told}");
    let output = directory.run(&["run", "reader.gen", "--zenoh-listen", &endpoint]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("--clock real"));
}

#[test]
fn services_of_another_machine_are_requested() {
    if !compilers() {
        return;
    }
    let directory = echo();
    let endpoint = endpoint();
    let run = run(&directory, "echo.gen", &["--zenoh-listen", &endpoint]);
    let call = |more: &[&str]| {
        let mut arguments = vec!["call", "--zenoh-connect", &endpoint];
        arguments.extend(more);
        let output = directory.run(&arguments);
        (status(&output), stdout(&output) + &stderr(&output))
    };
    let fine = |text: &str| (0, text.to_owned());
    assert_eq!(call(&["echo", "set_gain", "{\"gain\": 9}"]), fine("{}\n"));
    assert_eq!(call(&["echo", "get_gain"]), fine("{\"gain\":9}\n"));
    let counted = call(&["echo", "count", "{\"n\": 3}"]);
    assert_eq!(counted, fine("{\"seen\":3}\n"));
    assert_eq!(call(&["--ack", "echo", "count"]), fine(""));
    let (code, told) = call(&["echo", "fail", "{\"code\": 1}"]);
    assert_eq!((code, told.contains("echo::e_")), (1, true), "{told}");
    for (wrong, why) in [
        (["echo", "set_gain", "{\"gain\": \"much\"}"], "`echo.set_gain`"),
        (["echo", "set_gain", "{\"loss\": 1}"], "loss"),
        (["echo", "set_gain", "[1]"], "not an object"),
        (["echo", "nothing", "{}"], "no run there provides `echo.nothing`"),
        (["*", "get_gain", "{}"], "request one service"),
    ] {
        let (code, told) = call(&wrong);
        assert_eq!((code, told.contains(why)), (2, true), "{wrong:?}: {told}");
    }
    // The request ends with the run.
    let mut waits = directory.command(&["call", "--zenoh-connect", &endpoint, "echo", "count"]);
    let waits = waits.arg("{\"n\": 1000000}").stderr(Stdio::piped());
    let waits = waits.spawn().expect("the program starts");
    soon("the activity", || {
        let activities = progress(&directory)["activities"].to_string();
        activities.contains("echo.count").then_some(())
    });
    run.signal("-KILL");
    let output = waits.wait_with_output().expect("it ends");
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("run has ended"), "{}", stderr(&output));
    let (code, told) = call(&["echo", "get_gain"]);
    assert_eq!((code, told.contains("cannot connect")), (2, true), "{told}");
}
