//! The quadcopter of the examples flies to three points on the virtual clock, from its scenario alone.
#![cfg(target_os = "linux")]

use std::path::Path;

use serde_json::Value;

use crate::directory::{Directory, status, stderr};
use crate::running::{compilers, json_of};

const SCENARIO: &str = "quadcopter/flight.scn";

/// Positions of the tour in metres: the defaults of `maneuver.set_tour`.
const POINTS: [[f64; 3]; 3] = [[1.0, 0.5, 1.2], [-0.5, 1.0, 1.5], [0.0, -1.0, 1.0]];

/// Greatest distance from a point, in metres.
const TOLERANCE: f64 = 0.05;

/// Length of the interval before the next motion in which the position is checked, in seconds.
const WINDOW: f64 = 0.5;

/// A position in metres, and its simulated time in seconds.
struct Sample {
    time: f64,
    position: [f64; 3],
}

/// Writes the files below a folder of the examples to the directory.
fn copy(directory: &Directory, folder: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(folder);
    for entry in std::fs::read_dir(path).expect("an example") {
        let entry = entry.expect("an entry");
        let name = entry.file_name().into_string().expect("UTF-8");
        let inner = format!("{folder}/{name}");
        if entry.path().is_file() {
            directory.write(&inner, &std::fs::read(entry.path()).expect("a file"));
        } else if !name.starts_with('.') && name != "__pycache__" {
            copy(directory, &inner);
        }
    }
}

fn sample(state: &Value) -> Option<Sample> {
    let at = &state["pos"];
    let number = |value: &Value| value.as_f64();
    Some(Sample {
        time: number(&state["ts"]["sec"])? + number(&state["ts"]["nsec"])? * 1e-9,
        position: [number(&at["x"])?, number(&at["y"])?, number(&at["z"])?],
    })
}

/// Returns the desired and the true positions of a recording.
fn positions(recording: &[u8]) -> (Vec<Sample>, Vec<Sample>) {
    let (mut desired, mut body) = (Vec::new(), Vec::new());
    for message in mcap::MessageStream::new(recording).expect("a recording") {
        let message = message.expect("a message");
        let samples = match message.channel.topic.as_str() {
            "/maneuver/desired" => &mut desired,
            "/simulator/body" => &mut body,
            _ => continue,
        };
        let state: Value = serde_json::from_slice(&message.data).expect("JSON");
        samples.extend(sample(&state));
    }
    (desired, body)
}

fn distance(from: &[f64; 3], to: &[f64; 3]) -> f64 {
    let squares = from.iter().zip(to).map(|(from, to)| (from - to).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Asserts that the body is at each of these points at the end of the rest there, and, after all of them, on
/// the ground at last.
fn check(points: &[[f64; 3]], desired: &[Sample], body: &[Sample]) {
    for point in points {
        let arrived = |sample: &Sample| distance(&sample.position, point) < 1e-6;
        let last = desired.iter().rposition(arrived);
        let last = last.unwrap_or_else(|| panic!("{point:?} is never desired"));
        let (arrival, departure) = (desired[last].time, desired[last + 1].time);
        assert!(departure - arrival > 1.0, "no rest at {point:?}");
        let resting =
            body.iter().filter(|body| body.time >= departure - WINDOW && body.time < departure);
        let errors: Vec<f64> = resting.map(|body| distance(&body.position, point)).collect();
        assert!(errors.len() > 400, "{} samples", errors.len());
        let greatest = errors.iter().copied().fold(0.0, f64::max);
        assert!(greatest < TOLERANCE, "{greatest} m from {point:?}");
    }
    if points.len() < POINTS.len() {
        return;
    }
    let highest = body.iter().map(|body| body.position[2]).fold(0.0, f64::max);
    assert!(highest > 1.4, "{highest} m");
    let landed = body.last().expect("a position").position;
    let place = [POINTS[2][0], POINTS[2][1], 0.0];
    assert!(distance(&landed, &place) < TOLERANCE, "{landed:?}");
}

#[test]
fn the_quadcopter_flies_to_three_points_and_its_run_is_one_of_the_model() {
    if !compilers() {
        return;
    }
    // The whole flight takes some minutes in a debug build.
    let is_whole = dotgen_loaders::times(1) > 1;
    let (until, points, steps) =
        if is_whole { ("27s", &POINTS[..], 1_000_000) } else { ("2s", &POINTS[..0], 50_000) };
    let directory = Directory::new(&[]);
    copy(&directory, "quadcopter");
    copy(&directory, "maneuver/idl");
    let json = ["--format", "json"];
    let files = ["--record", "flight.mcap", "--profile", "flight.out"];
    let run = ["run", SCENARIO, "--until", until, "--bounds", "none"];
    let output = directory.run(&[&run[..], &files[..], &json[..]].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let report = json_of(&output);
    assert_eq!(report["violation-count"], 0, "{report:#}");
    assert_eq!(report["simulated-codels"], 0, "{report:#}");

    let recording = std::fs::read(directory.path().join("flight.mcap")).expect("a recording");
    let (desired, body) = positions(&recording);
    check(points, &desired, &body);

    let output = directory.run(&[&["replay", "flight.mcap", SCENARIO][..], &json[..]].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let report = json_of(&output);
    assert_eq!(report["difference-count"], 0, "{report:#}");
    assert_eq!(report["followed"], report["steps"]);
    assert!(report["steps"].as_u64() > Some(steps), "{report:#}");

    let output = directory.run(&[&["monitor", "flight.out", SCENARIO][..], &json[..]].concat());
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert_eq!(json_of(&output)["deviation-count"], 0);
}

/// A check that is violated in the air makes the robot land: the run ends on the ground.
#[test]
fn a_measure_lands_the_quadcopter() {
    if !compilers() {
        return;
    }
    let directory = Directory::new(&[]);
    copy(&directory, "quadcopter");
    copy(&directory, "maneuver/idl");
    let measure = "check calm: within maneuver.goto.run => maneuver.goto.void <= 400 ms;
  on violation of calm {
    send maneuver.land; await ended; delay 1 s; send mikrokopter.stop; await ended; stop;
  }
  check physics";
    let scenario = directory.read(SCENARIO).replace("check physics", measure);
    directory.write(SCENARIO, scenario.as_bytes());
    let run = ["run", SCENARIO, "--until", "9s", "--bounds", "none", "--record", "flight.mcap"];
    let output = directory.run(&[&run[..], &["--format", "json"]].concat());
    let report = json_of(&output);
    assert_eq!((status(&output), &report["end"]), (1, &"measure".into()), "{report:#}");
    let recording = std::fs::read(directory.path().join("flight.mcap")).expect("a recording");
    let (_, body) = positions(&recording);
    let highest = body.iter().map(|body| body.position[2]).fold(0.0, f64::max);
    let last = body.last().expect("a position").position[2];
    assert!(highest > 0.01 && last < highest / 2.0, "{last} of {highest} m");
}
