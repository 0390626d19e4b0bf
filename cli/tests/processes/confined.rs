//! The confinement of tclsh by the system, without the checks that the engine adds.

use std::fs::File;
use std::path::Path;
use std::process::Output;

use super::{confines, entries, tcl};
use crate::directory::{Directory, stderr, stdout};

/// Runs a Tcl script as `dotgen` confines tclsh, without the checks that the engine adds.
fn confined(directory: &Directory, script: &str) -> Output {
    let shell = ["/usr/bin/tclsh8.6", "/usr/bin/tclsh", "/usr/local/bin/tclsh8.6"];
    let shell = shell.iter().find(|shell| Path::new(shell).exists()).expect("tclsh");
    let path = |name: &str| directory.path().join(name).display().to_string();
    directory.write("read/script.tcl", script.as_bytes());
    let (read, write, script) = (path("read"), path("write"), path("read/script.tcl"));
    let options = ["confined", "--memory", "268435456", "--time", "20", "--file", "100000"];
    let paths = ["--confine", "--read", &read, "--write", &write, "--", shell, &script];
    directory.run(&[&options[..], &paths[..]].concat())
}

#[test]
fn the_system_keeps_a_template_from_the_rest() {
    if !tcl() || !confines() {
        return;
    }
    let directory = Directory::new(&[
        ("read/in.txt", "in"),
        ("write/own.txt", "own"),
        ("other/x.txt", "secret"),
    ]);
    let other = directory.path().join("other");
    let fine = "
        set root [file dirname [file dirname [info script]]]
        puts [clock format 0 -gmt 1 -format %Y]
        set f [open $root/read/in.txt]; puts [read $f]; close $f
        set f [open $root/write/new.txt w]; puts $f new; close $f
        file mkdir $root/write/sub
        file copy $root/read/in.txt $root/write/sub/copy.txt
        file rename $root/write/own.txt $root/write/sub/moved.txt
        file delete $root/write/new.txt
        puts [lsort [glob -directory $root/write/sub -tails *]]
        package require http
        puts ok
    ";
    let output = confined(&directory, fine);
    let expected = "1970\nin\ncopy.txt moved.txt\nok\n";
    assert_eq!((stdout(&output).as_str(), stderr(&output).as_str()), (expected, ""));
    let tried = [
        "open $root/other/x.txt",
        "open $root/other/x.txt a",
        "open $root/other/new.txt w",
        "open $root/read/in.txt a",
        "open /etc/passwd",
        "open /proc/self/environ",
        "glob -directory $root/other *",
        "file mkdir -- $root/other/made",
        "file copy -force -- $root/read/in.txt $root/other/copied.txt",
        "file copy $root/other/x.txt $root/write/stolen.txt",
        "file rename $root/other/x.txt $root/write/moved.txt",
        "file rename $root/write/sub/copy.txt $root/other/moved.txt",
        "file delete $root/other/x.txt",
        "file link -hard $root/write/linked.txt $root/other/x.txt",
        "file link -symbolic $root/write/to $root/other; open $root/write/to/new.txt w",
        "exec true",
        "exec /bin/sh -c true",
        "exec [info nameofexecutable] << exit",
        "open |true",
        "socket localhost 1",
        "socket -server x 0",
    ];
    let mut script = "set root [file dirname [file dirname [info script]]]\n".to_owned();
    for one in tried {
        script += &format!("puts [catch {{{one}}} message]\n");
    }
    // What Tcl takes for done has changed nothing.
    script += "file attributes $root/other/x.txt -permissions 0777\nfile mtime $root/other/x.txt 5\nputs end\n";
    let before = File::open(other.join("x.txt")).and_then(|file| file.metadata()).expect("a file");
    let output = confined(&directory, &script);
    let results: Vec<String> = stdout(&output).lines().map(str::to_owned).collect();
    assert_eq!(results.last().map(String::as_str), Some("end"), "{}", stderr(&output));
    for (one, result) in tried.iter().zip(&results) {
        assert_eq!(result, "1", "{one}");
    }
    assert_eq!(entries(&other), 1);
    let after = File::open(other.join("x.txt")).and_then(|file| file.metadata()).expect("a file");
    assert_eq!(before.permissions(), after.permissions());
    assert_eq!(before.modified().expect("a date"), after.modified().expect("a date"));
    assert!(!directory.path().join("write/stolen.txt").exists());
}

#[test]
fn memory_and_time_end() {
    if !tcl() || !confines() {
        return;
    }
    let directory = Directory::new(&[("write/x", "")]);
    let write = "set f [open [file dirname [file dirname [info script]]]/write/big w]; fconfigure $f \
        -buffering none;";
    for script in
        ["set x y; while 1 { append x $x }", &format!("{write} puts $f [string repeat x 200000]")]
    {
        let output = confined(&directory, &format!("{script}\nputs end"));
        assert!(!output.status.success(), "{script}");
        assert!(output.stdout.is_empty(), "{script}");
    }
    let size = std::fs::metadata(directory.path().join("write/big")).map(|metadata| metadata.len());
    assert!(size.expect("a file") <= 100_000);
}
