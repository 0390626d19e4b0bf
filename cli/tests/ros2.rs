//! Components as ROS 2 nodes: a peer that speaks plain Zenoh and CDR.
#![cfg(all(target_os = "linux", feature = "ros2"))]

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::Stdio;

use crate::directory::{Directory, status, stderr};
use crate::network::{echo, endpoint, run};
use crate::python::python;
use crate::running::compilers;

#[test]
fn a_peer_reads_topics_calls_services_and_sends_goals() {
    let Some(mut peer) = python(&["eclipse-zenoh"], "import zenoh") else {
        return;
    };
    if !compilers() {
        return;
    }
    let directory = echo();
    let endpoint = endpoint();
    let listen = ["--ros2", "--ros-domain", "7", "--zenoh-listen", &endpoint];
    let run = run(&directory, "echo.gen", &listen);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ros2/peer.py");
    peer.arg(script).arg(&endpoint);
    peer.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut peer = peer.spawn().expect("it starts");
    let mut lines = BufReader::new(peer.stdout.take().expect("it is piped")).lines();
    let mut line = || lines.next().and_then(Result::ok).unwrap_or_default();
    assert_eq!(line(), "seen");
    drop(run);
    let mut input = peer.stdin.take().expect("it is piped");
    input.write_all(b"\n").expect("the peer reads");
    assert_eq!(line(), "gone");
    assert!(peer.wait().expect("it ends").success());
}

#[test]
fn wrong_options_are_told() {
    let directory = Directory::new(&[(
        "one.gen",
        "component one { version \"1\"; lang \"c\"; };" as &str,
    )]);
    let wrong = |more: &[&str]| {
        let output = directory.run(&[&["run", "one.gen"], more].concat());
        assert_eq!(status(&output), 2);
        stderr(&output)
    };
    assert!(wrong(&["--ros2"]).contains("--clock real"));
    assert!(wrong(&["--ros-domain", "3"]).contains("--ros2"));
    assert!(wrong(&["--ros2", "--zenoh-read", "a.b=c"]).contains("cannot be used with"));
    let far = wrong(&["--clock", "real", "--ros2", "--ros-domain", "233"]);
    assert!(far.contains("0..=232"), "{far}");
}
