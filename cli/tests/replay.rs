//! `dotgen run --record` and `dotgen replay`, as users and scripts run them.

use std::process::Output;

use dotgen_recording::record;
use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};

fn json(output: &Output) -> Value {
    let text = stdout(output);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}{}", stderr(output)))
}

/// A recorded run of the example, in a directory with its sources.
fn recorded(arguments: &[&str]) -> Directory {
    let directory = Directory::new(&[]);
    for name in ["pump.gen", "pump.scn"] {
        let path = format!("{}/../examples/pump/{name}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read(path).expect("an example");
        directory.write(name, &text);
    }
    let all = ["run", "pump.scn", "--record", "run.mcap", "--simulate", "all"];
    let output = directory.run(&[&all[..], arguments].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("run.mcap"), "{}", stdout(&output));
    directory
}

fn replayed(directory: &Directory, files: &[&str]) -> (i32, Value) {
    let output = directory.run(&[&["replay", "--format", "json"], files].concat());
    (status(&output), json(&output))
}

#[test]
fn a_recorded_run_is_one_of_the_model() {
    let directory = recorded(&["--until", "2s"]);
    let (status_of, report) = replayed(&directory, &["run.mcap", "pump.scn"]);
    assert_eq!(status_of, 0, "{report:#}");
    assert_eq!(report["difference-count"], 0);
    assert_eq!(report["followed"], report["steps"]);
    assert!(report["steps"].as_u64() > Some(1000), "{report:#}");
    let words = directory.run(&["replay", "run.mcap", "pump.scn"]);
    assert!(stdout(&words).contains("it is a run of the model"));
}

#[test]
fn what_another_model_does_not_do_is_named() {
    let directory = recorded(&["--until", "1s", "--durations", "worst"]);
    let specification = directory.read("pump.gen");
    let with = |old: &str, new: &str| {
        assert!(specification.contains(old));
        let changed = specification.replacen(old, new, 1);
        directory.write("pump.gen", changed.as_bytes());
        let (status_of, report) = replayed(&directory, &["run.mcap", "pump.scn"]);
        assert_eq!(status_of, 1, "{report:#}");
        let words = stdout(&directory.run(&["replay", "run.mcap", "pump.scn"]));
        // A late codel is a violation, as in the run, and all else is what the model does.
        let by_codels = report["difference-count"] == report["violation-count"];
        assert_eq!(words.contains("violations by codels"), by_codels, "{words}");
        assert_eq!(words.contains("it is not a run of the model"), !by_codels, "{words}");
        report
    };
    // Longer than declared: told each time, and followed to the end.
    let report = with("wcet 3 ms", "wcet 2 ms");
    assert_eq!(report["followed"], report["steps"]);
    assert!(report["difference-count"].as_u64() > Some(50), "{report:#}");
    assert_eq!(report["differences"][0]["kind"], "longer");
    assert_eq!(report["differences"][0]["rule"], "end");
    // Another period: the first tick is none.
    let report = with("period 10 ms", "period 15 ms");
    assert_eq!(report["difference-count"], 1, "{report:#}");
    assert_eq!(report["differences"][0]["rule"], "tick");
    assert!(report["followed"].as_u64() < report["steps"].as_u64());
}

#[test]
fn what_is_no_recording_is_refused() {
    let directory = recorded(&["--until", "100ms"]);
    let refused = |files: &[&str], why: &str| {
        let output = directory.run(&[&["replay"], files].concat());
        assert_eq!(status(&output), 2);
        assert!(stderr(&output).contains(why), "{}", stderr(&output));
    };
    refused(&["pump.scn"], "name one recording");
    refused(&["run.mcap"], "name the scenario");
    directory.write("text.mcap", b"some text, and no recording");
    refused(&["text.mcap", "pump.scn"], "no MCAP file");
    let whole = std::fs::read(directory.path().join("run.mcap")).expect("it is there");
    directory.write("cut.mcap", &whole[..20]);
    refused(&["cut.mcap", "pump.scn"], "breaks off before the first step");
    let output = directory.run(&["run", "pump.scn", "--record", "pump.scn"]);
    assert_eq!(status(&output), 2);
    let output = directory.run(&["run", "pump.scn", "--record", "x.mcap", "--runs", "2"]);
    assert_eq!(status(&output), 2, "{}", stdout(&output));
}

#[test]
#[cfg(target_os = "linux")]
fn what_codels_write_to_ports_is_in_the_recording() {
    if !crate::running::compilers() {
        return;
    }
    let echo = include_str!("hosted/echo.gen").replace("LANG", "c");
    let directory = Directory::new(&[
        ("echo.gen", &echo),
        ("types.idl", include_str!("hosted/types.idl")),
        ("codels/echo.c", include_str!("hosted/echo.c")),
    ]);
    for clock in ["virtual", "real"] {
        let file = format!("{clock}.mcap");
        let options = "run echo.gen --bounds none --until 500ms --record";
        let mut arguments: Vec<&str> = options.split(' ').collect();
        arguments.extend([file.as_str(), "--clock", clock]);
        if clock == "real" {
            arguments.extend(["--socket", "s"]);
        }
        let output = directory.run(&arguments);
        assert!(status(&output) < 2, "{}", stderr(&output));
        let bytes = std::fs::read(directory.path().join(&file)).expect("it is there");
        let read = record::read(&bytes).expect("it is one");
        assert_eq!(read.about.clock, clock);
        assert!(read.data > 20, "{}", read.data);
        let (status_of, report) = replayed(&directory, &[&file, "echo.gen"]);
        // Codels without a time take none in the model, and some on this machine.
        let allowed = |json: &Value| clock == "real" && json["kind"] == "longer";
        let differences = report["differences"].as_array().expect("a list");
        assert!(differences.iter().all(allowed), "{clock}: {report:#}");
        assert_eq!(status_of, i32::from(!differences.is_empty()));
        assert_eq!(report["followed"], report["steps"], "{clock}");
    }
}

#[test]
fn a_damaged_recording_is_not_called_a_wrong_run() {
    let directory = recorded(&["--until", "20s"]);
    let mut bytes = std::fs::read(directory.path().join("run.mcap")).expect("it is there");
    let is_step = |window: &[u8]| window.starts_with(b"\"time\":") && window[7].is_ascii_digit();
    let step = bytes.windows(8).rposition(is_step).expect("a step");
    // One digit of the last step, in the last chunk.
    bytes[step + 7] ^= 1;
    directory.write("damaged.mcap", &bytes);
    let (status_of, report) = replayed(&directory, &["damaged.mcap", "pump.scn"]);
    assert_eq!(status_of, 2, "{report:#}");
    assert_eq!((&report["difference-count"], &report["breaks-off"]), (&0.into(), &true.into()));
    let at = report["damaged-at"].as_u64().expect("a place");
    assert!(at > 0 && at < step as u64, "{report:#}");
    assert!(report["steps"].as_u64() > Some(1000), "the intact chunks are compared: {report:#}");
    assert_eq!(report["followed"], report["steps"]);
    let words = directory.run(&["replay", "damaged.mcap", "pump.scn"]);
    assert_eq!(status(&words), 2);
    assert!(stderr(&words).contains(&format!("is damaged at byte {at}: ")), "{}", stderr(&words));
    assert!(!stdout(&words).contains("run of the model"), "{}", stdout(&words));
}
