//! The release of GenoM3: who says it, that all commands follow it, and what changes between two.

use crate::directory::{Directory, status, stderr, stdout};

const ARM: &str = "interface i {\n  typedef double d;\n  port out d pose;\n  exception lost;\n};\n\
                   component arm {\n  requires \"genom3 >= 2.99.26\";\n  provides i;\n\
                   struct box { sequence<long, 4> sizes; };\n  ids { box b; };\n\
                   task t { codel<start> armStart(out b, port out pose) yield ether; };\n\
                   function stop(in double speed) { throw i::lost; codel armStop(); };\n};\n";

fn directory() -> Directory {
    Directory::new(&[("arm.gen", ARM)])
}

/// What `dotgen check --verbose` says of the release.
fn said(directory: &Directory, arguments: &[&str], environment: &[(&str, &str)]) -> String {
    let mut command = directory.command(&["check", "--verbose"]);
    command.args(arguments).arg("arm.gen");
    // Whatever is installed here does not count.
    command.env("PKG_CONFIG_LIBDIR", "/nowhere").env("PKG_CONFIG", "/nowhere/pkg-config");
    command.envs(environment.iter().copied());
    let output = command.output().expect("the program runs");
    let text = stderr(&output);
    let line = text.lines().find(|line| line.contains("GenoM3"));
    line.unwrap_or(&text).to_owned()
}

/// `/opt/robot/bin/pkg-config` looks in `/opt/robot/lib/pkgconfig`: the release is read there without
/// running it.
#[test]
fn the_release_beside_the_package_tool_counts() {
    let directory = directory();
    let package = b"Name: genom3\nDescription: G\nVersion: 2.99.41\n";
    directory.write("robot/lib/pkgconfig/genom3.pc", package);
    directory.write("robot/bin/none", b"");
    let bin = directory.path().join("robot/bin");
    // Machine code that gives no answer.
    std::os::unix::fs::symlink("/bin/false", bin.join("pkg-config")).expect("a link");
    let mut command = directory.command(&["check", "--verbose", "arm.gen"]);
    let output = command.env("PATH", bin).output().expect("the program runs");
    let text = stderr(&output);
    assert!(text.contains("GenoM3 2.99.41 (installed: package `genom3`)"), "{text}");
}

#[test]
fn the_strongest_word_counts() {
    let directory = directory();
    let required = said(&directory, &[], &[]);
    assert_eq!(
        required,
        "arm.gen: GenoM3 2.99.39 (the specifications require `genom3 >= 2.99.26`)"
    );
    directory.write("lib/genom3.pc", b"Name: genom3\nDescription: G\nVersion: 2.99.43\n");
    let package = ("PKG_CONFIG_PATH", directory.path().join("lib"));
    let package = (package.0, package.1.to_str().expect("UTF-8"));
    assert_eq!(
        said(&directory, &[], &[package]),
        "arm.gen: GenoM3 2.99.43 (installed: package `genom3`; not verified)"
    );
    let version = b"package provide genom-engine 2.99.41\n";
    directory.write("share/engines/tcl/version.tcl", version);
    directory.write("share/templates/x/template.tcl", b"");
    let templates = directory.path().join("share/templates");
    let templates = ("GENOM_TMPL_PATH", templates.to_str().expect("UTF-8"));
    assert!(said(&directory, &[], &[package, templates]).contains("GenoM3 2.99.41 (installed: /"));
    directory.write("dotgen.toml", b"release = \"2.99.40\"\n");
    let file = said(&directory, &[], &[package, templates]);
    assert!(file.contains("GenoM3 2.99.40 (given by /") && file.contains("dotgen.toml"), "{file}");
    let environment = ("DOTGEN_GENOM_RELEASE", "3.1");
    assert_eq!(
        said(&directory, &[], &[environment]),
        "arm.gen: GenoM3 3.1 (given by `DOTGEN_GENOM_RELEASE`; not verified)"
    );
    assert_eq!(
        said(&directory, &["--release", "2.99.39"], &[environment]),
        "arm.gen: GenoM3 2.99.39 (given by `--release`)"
    );
}

#[test]
fn what_is_no_release_is_refused() {
    let directory = directory();
    let output = directory.run(&["check", "--release", "latest", "arm.gen"]);
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("2.99.41"), "{}", stderr(&output));
    let mut command = directory.command(&["check", "arm.gen"]);
    let output = command.env("DOTGEN_GENOM_RELEASE", "new").output().expect("it runs");
    assert_eq!(status(&output), 2);
    assert!(stderr(&output).contains("DOTGEN_GENOM_RELEASE: `new` is not a release"));
    directory.write("dotgen.toml", b"release = 2.99\n");
    let output = directory.run(&["check", "arm.gen"]);
    assert!(
        stdout(&output).contains("config-bad-value")
            || stderr(&output).contains("config-bad-value")
    );
}

#[test]
fn generated_files_follow_the_release() {
    let directory = directory();
    let mappings = |release: &str| {
        let output = directory.run(&[
            "generate",
            "--release",
            release,
            "mappings",
            "--signature",
            "arm.gen",
        ]);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        stdout(&output)
    };
    let (old, new) = (mappings("2.99.39"), mappings("2.99.41"));
    assert!(
        old.contains("Generated by genom 2.99.39.") && new.contains("Generated by genom 2.99.41.")
    );
    assert!(
        old.contains("const uint32_t _maximum;")
            && new.contains("uint32_t _maximum, _length;\n  int32_t")
    );
    assert!(old.contains("const arm_pose *pose") && new.contains("const i_pose *pose"));
    assert!(new.contains("typedef i_pose arm_pose;"));
    let version = directory.run(&["genom3", "--release=3.1", "--version"]);
    assert_eq!(stdout(&version), "3.1\n");
}
