//! Components as ROS 2 nodes, seen by peers that speak plain Zenoh and CDR.
#![cfg(all(target_os = "linux", feature = "zenoh"))]

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdout, Stdio};

use crate::directory::{Directory, status, stderr, stdout};
use crate::network::{echo, endpoint, reader, run};
use crate::python::python;
use crate::running::{compilers, ended, hosts, soon};

/// A script of `tests/ros2`, which prints a line for each part that it has done.
struct Script(Child, BufReader<ChildStdout>);

impl Script {
    /// Starts the script; `None` without its packages.
    fn start(name: &str, endpoint: &str) -> Option<Script> {
        let mut command = python(&["eclipse-zenoh"], "import zenoh.ext")?;
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ros2");
        command.arg(folder.join(name)).arg(endpoint);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let output = BufReader::new(child.stdout.take().expect("it is piped"));
        Some(Script(child, output))
    }

    /// Waits for the next line. All waits of a script have a bound.
    fn prints(&mut self, expected: &str) {
        let mut line = String::new();
        self.1.read_line(&mut line).expect("it is text");
        assert_eq!(line.trim_end(), expected);
    }
}

impl Drop for Script {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_peer_reads_topics_calls_services_and_sends_goals() {
    if !compilers() {
        return;
    }
    let (directory, endpoint) = (echo(), endpoint());
    let Some(mut script) = Script::start("echo.py", &endpoint) else {
        return;
    };
    script.prints("router");
    let connect = ["--ros2", "--ros-domain", "7", "--zenoh-connect", &endpoint];
    let run = run(&directory, "echo.gen", &connect);
    script.prints("seen");
    assert_eq!(hosts(&directory).len(), 1);
    // It is killed: neither a process nor a node stays.
    drop(run);
    soon("the end of the host", || hosts(&directory).is_empty().then_some(()));
    let mut input = script.0.stdin.take().expect("it is piped");
    input.write_all(b"\n").expect("the script reads");
    script.prints("gone");
    assert!(ended(&mut script.0).success());
}

#[test]
fn a_run_is_the_router_and_its_ports_read_topics() {
    if !compilers() {
        return;
    }
    let (directory, endpoint) = (reader(), endpoint());
    let listen = ["--ros2", "--ros-domain", "7", "--zenoh-listen", &endpoint];
    let run = run(&directory, "reader.gen", &listen);
    let Some(mut script) = Script::start("reader.py", &endpoint) else {
        return;
    };
    script.prints("seen");
    assert!(ended(&mut script.0).success());
    drop(run);
}

/// A component whose ports have common messages.
fn pom(settings: &str) -> Directory {
    Directory::new(&[
        ("pom.gen", include_str!("hosted/pom.gen")),
        ("dotgen.toml", settings),
        ("codels/pom.c", include_str!("hosted/pom.c")),
    ])
}

const COMMON: &str = include_str!("hosted/pom.toml");

#[test]
fn ports_have_common_messages() {
    if !compilers() {
        return;
    }
    let (directory, endpoint) = (pom(COMMON), endpoint());
    let listen = ["--ros2", "--ros-domain", "7", "--zenoh-listen", &endpoint];
    let run = run(&directory, "pom.gen", &listen);
    let Some(mut script) = Script::start("pom.py", &endpoint) else {
        return;
    };
    script.prints("seen");
    assert!(ended(&mut script.0).success());
    drop(run);
}

#[test]
fn wrong_settings_of_messages_are_told() {
    let wrong = |from: &str, to: &str| {
        let directory = pom(&COMMON.replace(from, to));
        let endpoint = endpoint();
        let words = ["run", "pom.gen", "--clock", "real", "--simulate", "all", "--socket", "s"];
        let output =
            directory.run(&[&words[..], &["--ros2", "--zenoh-listen", &endpoint]].concat());
        assert_eq!(status(&output), 2, "{}", stderr(&output));
        let check = directory.run(&["check", "pom.gen"]);
        let packages = directory.run(&["generate", "ros2-interfaces", "-o", "ros", "pom.gen"]);
        assert_eq!(status(&packages), 2);
        (stderr(&output), stderr(&packages), stdout(&check))
    };
    let (run, packages, _) = wrong("\"speed.vx\"", "\"speed.vy\"");
    let expected = "dotgen.toml:12: bad value for `ros2.messages.pom.odometry.fields.twist.twist.linear.x`: \
                    `speed` has no member `vy`; there are `vx`, `wz`\n";
    assert!(run.contains(expected), "{run}");
    assert!(packages.contains(expected), "{packages}");
    // An error that does not depend on the specification is one of the file itself.
    let (run, packages, check) = wrong("geometry_msgs/Twist", "geometry_msgs/Twst");
    let expected = "`ros2.messages.pom.wanted.type`: `geometry_msgs/Twst` is not a known message; did you \
                    mean `geometry_msgs/Twist`?";
    for told in [run, packages, check] {
        assert!(told.contains("dotgen.toml:19:") && told.contains(expected), "{told}");
    }
}

#[test]
fn names_are_remapped_before_the_run() {
    let directory = pom(COMMON);
    let run = |remaps: &[&str]| {
        let endpoint = endpoint();
        let mut words =
            vec!["run", "pom.gen", "--clock", "real", "--simulate", "all", "--until", "100ms"];
        words.extend(["--socket", "s", "--ros2", "--zenoh-listen", &endpoint]);
        words.extend(remaps.iter().flat_map(|remap| ["--remap", remap]));
        let output = directory.run(&words);
        (status(&output), stderr(&output))
    };
    let (code, told) = run(&["/pom/wanted:=/cmd_vel", "pom/odometry:=/odom"]);
    assert_eq!(code, 0, "{told}");
    let (code, told) = run(&["/pom/odometri:=/odom"]);
    assert_eq!(code, 2, "{told}");
    assert!(told.contains("did you mean `/pom/odometry`? There are `/pom/"), "{told}");
    let (code, told) = run(&["/pom/odometry:=/pom/wanted"]);
    assert_eq!(code, 2, "{told}");
    assert!(told.contains("geometry_msgs/msg/Twist"), "{told}");
}

#[test]
fn packages_lack_types_of_ports_with_common_messages() {
    let directory = pom(COMMON);
    let output = directory.run(&["generate", "ros2-interfaces", "-o", "ros", "pom.gen"]);
    assert_eq!(
        (status(&output), stderr(&output), stdout(&output)),
        (0, String::new(), String::new())
    );
}

#[test]
fn wrong_options_are_told() {
    let directory =
        Directory::new(&[("one.gen", "component one { version \"1\"; lang \"c\"; };" as &str)]);
    let wrong = |more: &[&str]| {
        let output = directory.run(&[&["run", "one.gen"], more].concat());
        assert_eq!(status(&output), 2);
        stderr(&output)
    };
    assert!(wrong(&["--ros2"]).contains("--clock real"));
    assert!(wrong(&["--ros-domain", "3"]).contains("--ros2"));
    assert!(wrong(&["--ros2", "--zenoh-read", "a.b=c"]).contains("cannot be used with"));
    assert!(wrong(&["--remap", "/one/a:=/b"]).contains("--ros2"));
    let relative = wrong(&["--clock", "real", "--ros2", "--remap", "/one/a:=b"]);
    assert!(relative.contains("the name `b` is not absolute"), "{relative}");
    let far = wrong(&["--clock", "real", "--ros2", "--ros-domain", "233"]);
    assert!(far.contains("0..=232"), "{far}");
}
