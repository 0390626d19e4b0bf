//! Interfaces that come with dotgen take the place of packages that are not installed.

use std::process::Output;

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::compilers;

/// What public components have: an interface from a package, its types in ports and the IDS, C++.
const FLY: &str = r#"#pragma require "openrobots2-idl >= 2.0"
#include "or/pose/pose_estimator.gen"
#include "or/robot/rotorcraft.gen"
component fly {
  version "1.0";
  lang "c++";
  require "genom3 >= 2.99.26";
  codels-require "openrobots2-idl";
  uses or_rotorcraft;
  port in or_pose_estimator::state pose;
  exception e_input { short code; };
  ids { or_pose_estimator::state last; sequence<double, 8> wanted; };
  task main {
    period 5 ms;
    codel<start> fly_start(out ::ids) yield control;
    codel<control> fly_control(in pose, inout last, port out rotor_input, in wanted)
      yield pause::control;
  };
  attribute set(in wanted);
};
"#;

fn run(directory: &Directory, arguments: &[&str]) -> Output {
    let mut command = directory.command(arguments);
    command.env("XDG_CACHE_HOME", directory.path().join("cache"));
    command.env("PKG_CONFIG_LIBDIR", directory.path().join("packages"));
    command.output().expect("it runs")
}

#[test]
fn a_fresh_clone_has_nothing_open() {
    let directory = Directory::new(&[("fly.gen", FLY)]);
    let output = run(&directory, &["check", "fly.gen"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let shown = stdout(&output);
    assert!(shown.contains("hint[pp-requires-own]"), "{shown}");
    assert!(!shown.contains("warning") && !shown.contains("error"), "{shown}");
    assert!(!shown.contains("wait for"), "{shown}");

    let listed = stdout(&run(&directory, &["deps", "fly.gen"]));
    let line = "include or/pose/pose_estimator.gen: <own interfaces>/or/pose/pose_estimator.gen\n";
    assert!(listed.contains(line), "{listed}");
    let listed = stdout(&run(&directory, &["deps", "--format", "json", "fly.gen"]));
    assert!(!listed.contains("<own interfaces>"), "{listed}");

    // For those who want what is installed only.
    let output = run(&directory, &["check", "--deny", "missing", "fly.gen"]);
    assert_eq!(status(&output), 1);
    assert!(stdout(&output).contains("error[pp-requires-unresolved]"));
    // GenoM3 knows nothing of them.
    let output = run(&directory, &["genom3", "-n", "fly.gen"]);
    assert_ne!(status(&output), 0);
}

/// A component of 2019, without a `dotgen.toml` around it.
#[test]
fn generate_finds_the_interfaces_of_both_versions() {
    let old = FLY.replace("openrobots2-idl >= 2.0", "openrobots-idl >= 1.1");
    let old = old.replace("codels-require \"openrobots2-idl\";", "");
    let directory = Directory::new(&[("fly.gen", FLY), ("old/fly.gen", &old)]);
    for (file, time) in [("fly.gen", " int32_t sec"), ("old/fly.gen", "uint32_t sec")] {
        let output = run(&directory, &["check", file]);
        assert_eq!(status(&output), 0, "{}", stdout(&output));
        let output = run(&directory, &["generate", "mappings", "--language=c", file]);
        assert_eq!(status(&output), 0, "{file}: {}", stderr(&output));
        assert!(stdout(&output).contains(time), "{file}: {}", stdout(&output));
    }
}

#[test]
fn the_installed_package_comes_first() {
    let directory = Directory::new(&[("fly.gen", FLY)]);
    let folder = directory.path().display();
    for (path, text) in [
        (
            "packages/openrobots2-idl.pc",
            format!("Name: p\nDescription: p\nVersion: 2.1\nCflags: -I{folder}/installed\n"),
        ),
        (
            "installed/or/pose/pose_estimator.gen",
            "interface or_pose_estimator { struct state { long mine; }; };\n".to_owned(),
        ),
    ] {
        directory.write(path, text.as_bytes());
    }
    let output = run(&directory, &["check", "fly.gen"]);
    let shown = stdout(&output);
    assert!(!shown.contains("pp-requires-own"), "{shown}");
    // The other file is not in that package, and dotgen does not mix the two.
    assert!(shown.contains("pp-include-not-found"), "{shown}");

    // One that is too old is no missing one.
    let old = format!("Name: p\nDescription: p\nVersion: 1.0\nCflags: -I{folder}/installed\n");
    directory.write("packages/openrobots2-idl.pc", old.as_bytes());
    let shown = stdout(&run(&directory, &["check", "fly.gen"]));
    assert!(shown.contains("pp-requires-unresolved"), "{shown}");
}

#[test]
fn its_codels_compile_and_run() {
    if !compilers() {
        return;
    }
    let directory = Directory::new(&[("fly.gen", FLY)]);
    assert_eq!(status(&run(&directory, &["codels", "stub", "fly.gen"])), 0);
    let output = run(&directory, &["codels", "check", "fly.gen"]);
    assert_eq!(status(&output), 0, "{}", stdout(&output));
    // The module `or` is an operator of C++.
    let output = run(&directory, &["run", "--until", "100ms", "fly.gen"]);
    let shown = format!("{}{}", stdout(&output), stderr(&output));
    assert_eq!(status(&output), 0, "{shown}");
}

#[test]
fn sources_of_another_component_beside_are_left_out() {
    if !compilers() {
        return;
    }
    let component = |name: &str| {
        format!(
            "component {name} {{\n  version \"1\"; lang \"c\";\n  ids {{ long n; }};\n  task main {{\n    \
             period 10 ms;\n    codel<start> {name}_main(inout n) yield pause::start;\n  }};\n}};\n"
        )
    };
    let (left, right) = (component("left"), component("right"));
    let directory = Directory::new(&[("left.gen", &left), ("right.gen", &right)]);
    for name in ["left.gen", "right.gen"] {
        assert_eq!(status(&run(&directory, &["codels", "stub", name])), 0);
    }
    let output = run(&directory, &["run", "--until", "50ms", "left.gen", "right.gen"]);
    let shown = format!("{}{}", stdout(&output), stderr(&output));
    assert_eq!(status(&output), 0, "{shown}");
}
