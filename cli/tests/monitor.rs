//! `dotgen monitor`, and the traces of recorded runs, as users and scripts run them.

use std::io::{BufRead, BufReader, Write};
use std::process::{Output, Stdio};

use serde_json::Value;

#[cfg(target_os = "linux")]
use crate::directory::{Directory, status, stderr, stdout};

fn put(directory: &Directory, name: &str, text: &str) {
    directory.write(name, text.as_bytes());
}

fn dotgen(directory: &Directory, arguments: &[&str]) -> Output {
    directory.run(arguments)
}

fn json(output: &Output) -> Value {
    let text = stdout(output);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}{}", stderr(output)))
}

/// A recorded run of the example, in a directory with its sources.
fn recorded(arguments: &[&str]) -> Directory {
    let directory = Directory::new(&[]);
    for name in ["pump.gen", "pump.scn"] {
        let path = format!("{}/../examples/pump/{name}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("an example");
        put(&directory, name, &text);
    }
    let all = [&["run", "pump.scn", "--until", "5s", "--profile", "run.out"], arguments].concat();
    let output = dotgen(&directory, &all);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    directory
}

#[test]
fn a_run_is_held_to_its_model() {
    let directory = recorded(&[]);
    let clean = dotgen(&directory, &["monitor", "run.out", "pump.scn", "--format", "json"]);
    assert_eq!(status(&clean), 0, "{}", stderr(&clean));
    let report = json(&clean);
    assert_eq!(report["deviation-count"], 0);
    for task in report["tasks"].as_array().expect("a list") {
        assert!(task["greatest"].as_i64() <= task["bound"].as_i64(), "{task}");
        assert!(task["chains"].as_i64() > Some(200), "{task}");
    }
    let log = directory.read("run.out");
    let third = log.lines().nth(300).expect("a long log").replace("::pause::", "::");
    let lines = log.lines().enumerate();
    let log: String = lines
        .map(|(number, line)| format!("{}\n", if number == 300 { &third } else { line }))
        .collect();
    put(&directory, "run.out", &log);
    let wrong = dotgen(&directory, &["monitor", "run.out", "pump.scn", "--format", "json"]);
    assert_eq!(status(&wrong), 1, "{}", stderr(&wrong));
    let report = json(&wrong);
    assert_eq!(report["deviations"][0]["line"], 301);
    assert_eq!(report["deviations"][0]["kind"], "transition");
    assert_eq!(report["deviations"][0]["rule"], "a codel leads to one of its yields");
    let text = dotgen(&directory, &["monitor", "run.out", "pump.gen"]);
    assert_eq!(status(&text), 1);
    assert!(stdout(&text).contains("line 301, at "), "{}", stdout(&text));
    for wrong in [&["run.out"][..], &["pump.scn"], &["missing.out", "pump.scn"]] {
        let output = dotgen(&directory, &[&["monitor"], wrong].concat());
        assert_eq!(status(&output), 2, "{wrong:?}");
    }
}

#[test]
fn a_log_is_followed_while_it_is_written() {
    let directory = recorded(&[]);
    let log = directory.read("run.out");
    let mut command = directory.command(&["monitor", "--follow", "-", "pump.scn"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("the program runs");
    let mut input = child.stdin.take().expect("a pipe");
    let mut output = BufReader::new(child.stdout.take().expect("a pipe"));
    let (first, rest) = log.split_at(log.len() / 2);
    input.write_all(first.as_bytes()).expect("it reads");
    // In two pieces, cut within a line.
    let wrong = "\n3.000000000 3.000000000 3.100000000 pump report <permanent> nobody \
                 ::pump::start ::pump::ether\n";
    input.write_all(wrong.as_bytes()).expect("it reads");
    // It is told while the log goes on.
    let mut line = String::new();
    output.read_line(&mut line).expect("a line");
    assert!(line.contains("executed `nobody`"), "{line}");
    input.write_all(rest.as_bytes()).expect("it reads");
    drop(input);
    let mut all = String::new();
    std::io::Read::read_to_string(&mut output, &mut all).expect("text");
    assert_eq!(child.wait().expect("it ends").code(), Some(1));
    assert!(all.contains("tank: "), "{all}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_is_followed_through_its_socket() {
    use crate::running::{Listening, ended};

    let directory = recorded(&[]);
    let arguments = ["run", "pump.scn", "--clock", "real", "--simulate", "all"];
    let mut run = Listening::start(&directory, &[&arguments[..], &["--socket", "s"]].concat());
    // What another client hears is a log.
    let path = directory.path().join("s");
    let mut client = std::os::unix::net::UnixStream::connect(&path).expect("it listens");
    client.write_all(b"{\"id\": 7, \"profile\": null}\n").expect("it reads");
    let answers = BufReader::new(&client).lines().map(|line| {
        let answer: Value = serde_json::from_str(&line.expect("text")).expect("JSON");
        assert_eq!(answer["id"], 7);
        answer
    });
    let answers: Vec<Value> = answers.take(200).collect();
    assert_eq!(answers[0]["event"], "profiling");
    assert_eq!(answers[1]["line"], "# dotgen: times are measured");
    assert_eq!(
        answers[2]["line"].as_str().map(|line| line.starts_with("# dotgen: simulated ")),
        Some(true)
    );
    let lines = answers[1..].iter();
    let lines = lines.map(|line| format!("{}\n", line["line"].as_str().expect("a line")));
    put(&directory, "heard.out", &lines.collect::<String>());
    let clean = dotgen(&directory, &["monitor", "heard.out", "pump.scn"]);
    assert_eq!(status(&clean), 0, "{}{}", stdout(&clean), stderr(&clean));

    // A model that the run does not keep to.
    let other = directory.read("pump.gen").replace("wcet 3 ms", "wcet 100 us");
    put(&directory, "pump.gen", &other);
    let mut command = directory.command(&["monitor", "s", "pump.scn"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program runs");
    let mut output = BufReader::new(child.stdout.take().expect("a pipe"));
    let mut line = String::new();
    output.read_line(&mut line).expect("a line");
    assert!(line.contains("100 µs"), "{line}");
    // It ends with the run.
    run.signal("-TERM");
    ended(&mut run.0);
    let mut all = String::new();
    std::io::Read::read_to_string(&mut output, &mut all).expect("text");
    assert!(all.contains("runs of codels"), "{all}");
    assert_eq!(ended(&mut child).code(), Some(1));
}

/// A message of protocol buffers, taken apart without knowing what it means: fields with numbers or bytes.
fn fields(mut bytes: &[u8]) -> Vec<(u64, Field<'_>)> {
    let mut out = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let field = match key & 7 {
            0 => Field::Number(varint(&mut bytes)),
            1 => {
                let (number, rest) = bytes.split_at(8);
                bytes = rest;
                Field::Number(u64::from_le_bytes(number.try_into().expect("eight bytes")))
            }
            2 => {
                let length = varint(&mut bytes) as usize;
                let (value, rest) = bytes.split_at(length);
                bytes = rest;
                Field::Bytes(value)
            }
            other => panic!("wire type {other}"),
        };
        out.push((key >> 3, field));
    }
    out
}

fn varint(bytes: &mut &[u8]) -> u64 {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (first, rest) = bytes.split_first().expect("a number ends");
        *bytes = rest;
        value |= u64::from(first & 0x7f) << shift;
        if first & 0x80 == 0 {
            return value;
        }
    }
    panic!("a number is too long");
}

#[derive(Debug, Clone, Copy)]
enum Field<'f> {
    Number(u64),
    Bytes(&'f [u8]),
}

impl<'f> Field<'f> {
    fn number(self) -> u64 {
        match self {
            Field::Number(number) => number,
            Field::Bytes(_) => panic!("bytes"),
        }
    }

    fn bytes(self) -> &'f [u8] {
        match self {
            Field::Bytes(byte) => byte,
            Field::Number(_) => panic!("a number"),
        }
    }
}

#[test]
fn a_trace_has_a_slice_for_each_run() {
    let directory = recorded(&["--trace", "run.pftrace"]);
    let log = directory.read("run.out");
    let trace = std::fs::read(directory.path().join("run.pftrace")).expect("written");
    // The log gives the same trace.
    let monitor = ["monitor", "run.out", "pump.scn", "--trace", "again.pftrace"];
    assert_eq!(status(&dotgen(&directory, &monitor)), 0);
    let again = std::fs::read(directory.path().join("again.pftrace")).expect("written");
    assert!(trace == again);
    let get = |all: &[(u64, Field<'_>)], key: u64| {
        all.iter().find(|(of, _)| *of == key).map(|(_, field)| field.number())
    };
    let mut tracks = std::collections::BTreeMap::new();
    let mut open: std::collections::BTreeMap<u64, Vec<u64>> = std::collections::BTreeMap::new();
    let mut lasts = std::collections::BTreeMap::new();
    let (mut slices, mut flows) = (std::collections::BTreeMap::new(), 0);
    for (key, packet) in fields(&trace) {
        assert_eq!(key, 1);
        let packet = fields(packet.bytes());
        assert_eq!(get(&packet, 10), Some(1));
        for (key, field) in &packet {
            match key {
                60 => {
                    let track = fields(field.bytes());
                    let name = track.iter().find(|track| track.0 == 2).expect("a name").1;
                    let name = String::from_utf8(name.bytes().to_vec()).expect("text");
                    tracks.insert(get(&track, 1).expect("a number"), name);
                }
                11 => {
                    let time = get(&packet, 8).expect("a time");
                    let event = fields(field.bytes());
                    let track = get(&event, 11).expect("a track");
                    // Perfetto sorts packets of several tracks.
                    let last = lasts.insert(track, time);
                    assert!(last <= Some(time));
                    let name = tracks.get(&track).expect("a track that was described");
                    let stack = open.entry(track).or_default();
                    match get(&event, 9) {
                        Some(1) => {
                            assert!(stack.is_empty(), "slices of {name} overlap at {time}");
                            stack.push(time);
                            *slices.entry(name.clone()).or_insert(0) += 1;
                            flows += event.iter().filter(|event| event.0 == 47).count();
                        }
                        Some(2) => assert!(stack.pop().is_some(), "nothing ends on {name}"),
                        other => panic!("{other:?}"),
                    }
                }
                _ => {}
            }
        }
    }
    assert!(open.values().all(Vec::is_empty));
    let runs =
        |task: &str| log.lines().filter(|line| line.contains(&format!(" pump {task} "))).count();
    let waited = |task: &str| {
        let waits = |text: &&str| text.split(' ').next() != text.split(' ').nth(1);
        let of = log.lines().filter(|line| line.contains(&format!(" pump {task} ")));
        of.filter(waits).count()
    };
    for task in ["control", "report"] {
        assert_eq!(slices[&format!("task {task}")], runs(task) + waited(task), "{slices:?}");
    }
    let codels = log.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(slices["core 0"], codels.count(), "{slices:?}");
    assert!(slices["lock level"] > 200, "{slices:?}");
    assert!(slices["requests of fill"] >= 1, "{slices:?}");
    assert!(flows > slices["requests of fill"], "{slices:?}");
}

/// Checks of the lesson's components. Its phases of execution are in the log as they are in the run.
const CHECKS: &str = "
  check never (eye.look.find.exec and chase.steer.main.exec);
  check never chase.steer.stop;
  check within eye.look.grab.exec => eye.look.find.exec <= 10 ms;
  check within eye.look.grab.exec => eye.look.find.exec <= 3 ms;
  check always eye.look.find.exec => not eye.look.grab.exec;
  check eye.look.grab.exec precedes eye.look.find.exec;
  check chase.steer.main.exec precedes eye.look.start.exec;
  check absent chase.steer.main.exec after eye.look.grab.exec for 2 ms;
  check absent eye.look.start.exec after eye.look.grab.exec for 2 ms;
  check lasts eye.look.find.exec >= 1 ms;
  check reachable chase.steer.main.lock;
  check before eye.look.find.exec never eye.look.start.exec;
  check after eye.look.find.exec never eye.look.start.exec;
  check between eye.look.grab.exec and eye.look.find.exec never chase.steer.main.exec;
  check after eye.look.find.exec until eye.look.grab.exec always not eye.look.start.exec;
";

#[test]
fn a_log_answers_the_checks_of_its_run() {
    let directory = Directory::new(&[]);
    for name in ["eye.gen", "chase.gen", "ball.gen"] {
        let path = format!("{}/../examples/class/{name}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("an example");
        put(&directory, name, &text);
    }
    let parts = "use \"eye.gen\"; use \"chase.gen\"; cores 1; check schedulable *; check deadlock;
                 check age eye.ball -> chase.wheels;";
    put(&directory, "t.scn", &format!("scenario t {{ {parts}{CHECKS} }}"));
    for seed in ["1", "2", "3"] {
        let run = ["run", "t.scn", "--until", "3s", "--seed", seed, "--profile", "run.out"];
        let run = dotgen(&directory, &[&run[..], &["--format", "json"]].concat());
        let log = dotgen(&directory, &["monitor", "run.out", "t.scn", "--format", "json"]);
        assert_eq!(status(&log), 1, "{}", stderr(&log));
        let (run, log) = (json(&run), json(&log));
        // The run has also answered the checks of tasks and of deadlocks, which no log shows.
        let of_run = run["checks"].as_array().expect("checks").iter().skip(3);
        let of_log = log["checks"].as_array().expect("checks");
        assert_eq!(of_run.len(), of_log.len());
        for (expected, found) in of_run.zip(of_log) {
            assert_eq!(expected["of"], found["of"]);
            assert_eq!(expected["verdict"], found["verdict"], "seed {seed}: {}", found["of"]);
            let nanos = |value: &Value| value.as_f64().map(|time| (time * 1e6).round() as i64);
            assert_eq!(nanos(&expected["greatest"]), found["greatest"].as_i64(), "{}", found["of"]);
        }
        let violated = of_log.iter().filter(|check| check["verdict"] == "violated").count();
        assert_eq!(log["counts"]["check"], violated, "one deviation for each violated check");
        let unshown = log["not-checked"].as_array().expect("a list").iter();
        let unshown: Vec<_> = unshown.filter_map(|check| check["check"].as_str()).collect();
        assert_eq!(unshown.len(), 4, "{unshown:?}");
        assert!(unshown.contains(&"age eye.ball -> chase.wheels"), "{unshown:?}");
    }
}

/// Returns the verdict of a check along a log of the pump.
fn verdict(log: &str, check: &str) -> String {
    let directory = recorded(&[]);
    put(&directory, "t.scn", &format!("scenario t {{ use \"pump.gen\"; check {check}; }}"));
    put(&directory, "l.out", log);
    let output = dotgen(&directory, &["monitor", "l.out", "t.scn", "--format", "json"]);
    json(&output)["checks"][0]["verdict"].as_str().expect("a verdict").to_owned()
}

/// Codels without a duration end before what begins at the same moment.
#[test]
fn codels_of_one_moment_are_in_the_order_of_the_log() {
    let log = "\
0.040000000 0.040000000 0.040000000 pump control <permanent> control_start ::pump::start ::pump::pause::main
0.080000000 0.080000000 0.080000000 pump control <permanent> control_main ::pump::main ::pump::pause::main
0.080000000 0.080000000 0.084000000 pump report <permanent> report_start ::pump::start ::pump::pause::start
";
    let never = "never pump.control.main.exec and pump.report.start.exec";
    assert_eq!(verdict(log, never), "kept");
    // What the model does not have may have been what is asked for.
    let unknown = format!(
        "{log}0.090000000 0.090000000 0.091000000 pump control fill fill_wait ::pump::wait ::pump::ether\n"
    );
    assert_eq!(verdict(&unknown, "never pump.fill.wait"), "not-exercised");
    // The same of a time that goes backwards; a last line that is cut hides nothing before it.
    let step = "0.100000000 0.100000000 0.090000000 pump control <permanent> control_main ::pump::main x\n";
    assert_eq!(verdict(&format!("{log}{step}"), never), "not-exercised");
    assert_eq!(verdict(&format!("{log}0.1000"), never), "kept");
}
