//! Ports between machines, by Zenoh: two runs that know of each other by an endpoint only.
#![cfg(all(target_os = "linux", feature = "zenoh"))]

use std::net::{Ipv4Addr, TcpListener};

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{Listening, compilers, soon};

const TYPES: &str = include_str!("hosted/types.idl");

/// Somewhere nobody listens.
pub(crate) fn endpoint() -> String {
    let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port is free");
    let address = free.local_addr().expect("it has an address");
    format!("tcp/{address}")
}

fn component(name: &str, specification: &str, source: &str) -> Directory {
    Directory::new(&[
        (
            &format!("{name}.gen"),
            &specification.replace("LANG", "c") as &str,
        ),
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
    soon("the instance", || {
        (newest(&reads, "reader/sum") == "71\n").then_some(())
    });
    soon("structures", || {
        let seen = newest(&reads, "reader/seen");
        seen.contains("\"x\":").then_some(())
    });
    // Who was there goes: the other keeps what it has.
    drop(first);
    assert_eq!(newest(&reads, "reader/sum"), "71\n");
    drop(second);
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
    assert!(
        told.contains("`reader` has no input port `nothing`"),
        "{told}"
    );
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
