//! What a run has recorded when it is killed, or finds no room: all but its last moment.
#![cfg(target_os = "linux")]

use std::process::{Command, Stdio};

use dotgen_recording::record;
use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};
use crate::running::{Listening, json_of, soon};

const LOG: &str = "run.out";
const RECORDING: &str = "run.mcap";
const TRACE: &str = "run.pftrace";

/// Number of the first words of [`RUN`], which record nothing.
const SIMULATED: usize = 6;

/// A run of the example that records everything.
const RUN: &[&str] = &[
    "run",
    "pump.scn",
    "--simulate",
    "all",
    "--bounds",
    "none",
    "--profile",
    LOG,
    "--record",
    RECORDING,
    "--trace",
    TRACE,
];

/// The example, in a directory of its own.
fn pump() -> Directory {
    let directory = Directory::new(&[]);
    for name in ["pump.gen", "pump.scn"] {
        let path = format!("{}/../examples/pump/{name}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read(path).expect("an example");
        directory.write(name, &text);
    }
    directory
}

/// What is in the directory, sorted.
fn names(directory: &Directory) -> Vec<String> {
    let entries = std::fs::read_dir(directory.path()).expect("a directory");
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

fn bytes(directory: &Directory, name: &str) -> Vec<u8> {
    std::fs::read(directory.path().join(name)).unwrap_or_default()
}

/// Number of whole lines of the log about codels.
fn lines(directory: &Directory) -> u64 {
    let text = directory.read(LOG);
    let whole = text.split_inclusive('\n').filter(|part| part.ends_with('\n'));
    whole.filter(|part| !part.starts_with('#')).count() as u64
}

/// Number of whole packets of the trace.
fn packets(trace: &[u8]) -> usize {
    let (mut rest, mut count) = (trace, 0);
    while let [0x0a, after @ ..] = rest {
        let Some(last) = after.iter().position(|byte| byte & 0x80 == 0) else {
            break;
        };
        let length = after[..=last].iter().rev();
        let length = length.fold(0, |length, byte| length << 7 | usize::from(byte & 0x7f));
        match after.get(last + 1 + length..) {
            Some(after) => rest = after,
            None => break,
        }
        count += 1;
    }
    count
}

/// Reads all that a run has left with the commands for it. Returns the report of the replay.
fn read_all(directory: &Directory) -> Value {
    let note = |text: &str, name: &str| {
        let told = format!("`{name}` breaks off after ");
        assert_eq!(text.matches(&told).count(), 1, "{text}");
    };
    let monitor = ["monitor", LOG, "pump.scn", "--bounds", "none", "--format", "json"];
    let output = directory.run(&monitor);
    assert!(status(&output) < 2, "{}", stderr(&output));
    note(&stderr(&output), LOG);
    assert_eq!(json_of(&output)["runs"], lines(directory));
    let output = directory.run(&["wcet", "stats", LOG]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    note(&stderr(&output), LOG);
    let output = directory.run(&["replay", RECORDING, "pump.scn", "--format", "json"]);
    assert!(status(&output) < 2, "{}", stderr(&output));
    note(&stderr(&output), RECORDING);
    let report = json_of(&output);
    assert_eq!(report["breaks-off"], true);
    assert_eq!(report["followed"], report["steps"], "{report:#}");
    report
}

/// Numbers that look random.
fn next(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}

/// The number of runs that are killed.
fn kills() -> u64 {
    dotgen_loaders::times(2)
}

#[test]
fn a_killed_run_has_recorded_all_but_its_last_moment() {
    let directory = pump();
    let mut state = u64::from(std::process::id()) << 20 | 1;
    let arguments = [RUN, &["--clock", "real", "--socket", "s"]].concat();
    for round in 0..kills() {
        for name in [LOG, RECORDING, TRACE] {
            let _ = std::fs::remove_file(directory.path().join(name));
        }
        let mut run = Listening::start(&directory, &arguments);
        // Until there is something in each file; then at some moment.
        let least = next(&mut state) % 3000 + 200;
        soon("recorded steps", || {
            let recorded = record::read(&bytes(&directory, RECORDING)).ok()?;
            let enough = bytes(&directory, LOG).len() as u64 > least;
            (enough && !recorded.steps.is_empty()).then_some(())
        });
        for _ in 0..next(&mut state) % 300_000 {
            std::thread::yield_now();
        }
        run.0.kill().expect("it runs");
        run.0.wait().expect("it was killed");
        let files = ["pump.gen", "pump.scn", RECORDING, LOG, TRACE, "s"];
        assert_eq!(names(&directory), files, "round {round}");
        assert!(lines(&directory) > 0);
        let report = read_all(&directory);
        assert!(report["steps"].as_u64() > Some(0), "{report:#}");
        assert!(packets(&bytes(&directory, TRACE)) > 4);
    }
}

#[test]
fn a_full_disk_ends_the_files_and_not_the_run() {
    let directory = pump();
    let command = directory.command(&[RUN, &["--until", "20s"]].concat());
    let mut shell = Command::new("sh");
    shell.current_dir(directory.path()).stdin(Stdio::null());
    shell.args(["-c", "ulimit -f 64; exec \"$0\" \"$@\""]);
    let output = shell.arg(command.get_program()).args(command.get_args());
    let output = output.output().expect("it runs");
    assert_eq!(status(&output), 2, "{}", stderr(&output));
    assert!(stdout(&output).contains("pump.report"), "the run is reported");
    for name in [LOG, RECORDING, TRACE] {
        let told = format!("cannot write `{name}`: ");
        assert_eq!(stderr(&output).matches(&told).count(), 1, "{}", stderr(&output));
        // It has what there was room for.
        assert!(bytes(&directory, name).len() > 30_000, "{name}");
        assert!(!stdout(&output).contains(name), "{}", stdout(&output));
    }
    assert_eq!(names(&directory), ["pump.gen", "pump.scn", RECORDING, LOG, TRACE]);
    let report = read_all(&directory);
    assert!(report["steps"].as_u64() > Some(100), "{report:#}");
    assert!(packets(&bytes(&directory, TRACE)) > 100);
    // No room from the first byte on.
    for (option, name) in [
        ("--profile", "log"),
        ("--record", "x.mcap"),
        ("--trace", "x.pftrace"),
        ("--trace", "x.json"),
    ] {
        let path = directory.path().join(name);
        std::os::unix::fs::symlink("/dev/full", &path).expect("a link");
        let run = [&RUN[..SIMULATED], &[option, name]].concat();
        let output = directory.run(&run);
        assert_eq!(status(&output), 2, "{}", stderr(&output));
        let told = format!("cannot write `{name}`: No space left on device");
        assert_eq!(stderr(&output).matches(&told).count(), 1, "{}", stderr(&output));
        assert!(stdout(&output).contains("pump.report"), "{}", stdout(&output));
        assert!(path.is_symlink());
    }
}
