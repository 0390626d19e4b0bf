//! `dotgen run`, as users and scripts run it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::directory::{Directory, status, stderr, stdout};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name)
}

fn pump(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dotgen"));
    command.args(["run", "pump.scn"]).args(arguments);
    command.current_dir(example("pump"));
    command.output().expect("the program runs")
}

fn json_of(output: &Output) -> Value {
    let text = stdout(output);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}{}", stderr(output)))
}

/// The number of cycles of a task.
fn cycles() -> u64 {
    dotgen_loaders::times(20_000)
}

#[test]
fn response_times_come_close_to_what_is_proved_and_never_exceed_it() {
    // A run of 10 s has a thousand cycles of 10 ms.
    let runs = (cycles() / 1_000).max(1).to_string();
    let options =
        ["--check", "schedulable *", "--semantics", "servers", "--format", "json", "--runs", &runs];
    for durations in ["worst", "random", "best"] {
        let output = pump(&[&options[..], &["--durations", durations]].concat());
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let report = json_of(&output);
        assert_eq!(report["violation-count"], 0);
        for task in report["tasks"].as_array().expect("a list") {
            let number = |key: &str| task[key].as_f64().unwrap_or_else(|| panic!("{key}: {task}"));
            let (greatest, bound) = (number("greatest"), number("bound"));
            assert!(greatest <= bound, "{task}");
            assert!(durations != "worst" || greatest >= 0.9 * bound, "{task}");
            assert!(durations != "best" || greatest == 0.0, "{task}");
            assert_eq!(task["missed"], 0, "{task}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let run = |seed: &str| stdout(&pump(&["--seed", seed, "--format", "json", "--until", "2s"]));
    assert_eq!(run("7"), run("7"));
    let times = |seed: &str| -> Value {
        let report: Value = serde_json::from_str(&run(seed)).expect("JSON");
        report["tasks"].clone()
    };
    assert_ne!(times("7"), times("8"));
}

#[test]
fn a_response_time_beyond_the_period_exceeds_it() {
    let directory = Directory::new(&[
        (
            "late.gen",
            "component late {\n  task t { period 10 ms; codel<start> f() yield pause::start wcet 15 ms; };\n};\n",
        ),
        ("late.scn", "scenario late { use \"late.gen\"; check response *; }\n"),
    ]);
    let run = ["run", "late.scn", "--simulate", "all", "--durations", "worst"];
    let words = stdout(&directory.run(&run));
    let row = words.lines().find(|line| line.contains("response late.t"));
    let row: Vec<&str> = row.unwrap_or_default().split_whitespace().collect();
    assert_eq!(row[..3], ["exceeds", "response", "late.t"], "{words}");
    assert_eq!(row[row.len() - 2..], ["10", "ms"], "{words}");
    let output = directory.run(&[&run[..], &["--format", "json"]].concat());
    let report: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let check = &report["checks"][0];
    assert_eq!(check["verdict"], "simulated");
    assert_eq!((&check["limit"], &check["exceeded"]), (&10.into(), &true.into()));
}

#[test]
fn a_run_in_words() {
    let output = pump(&["--until", "1s", "--semantics", "servers", "--durations", "worst"]);
    assert_eq!(stderr(&output), "");
    insta::assert_snapshot!(stdout(&output));
}

const TIGHT: &str = "\
component tight {
  version \"1.0\"; lang \"c\";
  ids { long it; };
  task fast {
    period 10 ms;
    codel<start> read(out it) yield pause::start wcet 2 ms;
  };
  task slow {
    period 40 ms;
    codel<start> work(inout it) yield pause::start wcet 25 ms;
  };
};
";

const HELD: &str = "\
scenario held {
  use \"tight.gen\";
  cores 2;
  check late: schedulable tight.fast;
  check quick: response tight.fast <= 20 ms;
  check never: always not tight.slow.start.exec;
  check ever: reachable tight.slow.start.exec;
}
";

#[test]
fn what_is_violated_is_told_with_its_moment() {
    let directory = Directory::new(&[("tight.gen", TIGHT), ("held.scn", HELD)]);
    let arguments = ["run", "held.scn", "--durations", "worst", "--until", "1s"];
    let output = directory.run(&arguments);
    assert_eq!(status(&output), 1, "{}", stderr(&output));
    insta::assert_snapshot!(stdout(&output));
    // The same violations are proved to be possible.
    let proved = directory.run(&["verify", "held.scn", "--format", "json"]);
    let proved: Value = serde_json::from_str(&stdout(&proved)).expect("JSON");
    let verdicts = |json: &Value| -> Vec<String> {
        let checks = json["checks"].as_array().expect("a list");
        let verdict = |json: &Value| json["verdict"].as_str().expect("a word").to_owned();
        checks.iter().map(verdict).collect()
    };
    assert_eq!(verdicts(&proved), ["refuted", "refuted", "refuted", "proved"]);
    let stopped =
        directory.run(&[&arguments[..], &["--on-violation", "stop", "--format", "json"]].concat());
    assert_eq!(status(&stopped), 1);
    let report = json_of(&stopped);
    assert_eq!((&report["end"], &report["violation-count"]), (&"stopped".into(), &1.into()));
}

#[test]
fn every_run_of_a_codel_is_a_line_of_the_profile() {
    let directory = Directory::new(&[("tight.gen", TIGHT), ("held.scn", HELD)]);
    let arguments =
        ["run", "held.scn", "--until", "400ms", "--profile", "run.out", "--format", "json"];
    let report = json_of(&directory.run(&arguments));
    let text = std::fs::read_to_string(directory.path().join("run.out")).expect("the profile");
    let mut counted = std::collections::BTreeMap::new();
    let first = text.lines().next();
    assert_eq!(first, Some("# dotgen: times are simulated"));
    assert!(text.ends_with("\n# dotgen: end of the run\n"));
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let columns: Vec<&str> = line.split(' ').collect();
        assert_eq!(columns.len(), 9, "{line}");
        let times: Vec<f64> =
            columns[..3].iter().map(|column| column.parse().expect("seconds")).collect();
        assert!(times.is_sorted(), "{line}");
        let decimals = columns[0].split_once('.').expect("a fraction").1;
        assert_eq!(decimals.len(), 9, "{line}");
        *counted.entry(columns[3..].join(" ")).or_insert(0) += 1;
    }
    let runs = |codel: usize| report["codels"][codel]["runs"].as_u64().expect("a number");
    let expected = [
        ("tight fast <permanent> read ::tight::start ::tight::pause::start", runs(0)),
        ("tight slow <permanent> work ::tight::start ::tight::pause::start", runs(1)),
    ];
    let expected = expected.map(|(text, count)| (text.to_owned(), count));
    assert_eq!(counted, expected.into_iter().collect());
    assert!(runs(0) > 10 && runs(1) > 5);
}

#[test]
fn time_that_stands_still_ends_a_run() {
    let spin = "\
component spin {
  version \"1.0\"; lang \"c\";
  task round {
    codel<start> a() yield other;
    codel<other> b() yield start;
  };
};
";
    let directory = Directory::new(&[("spin.gen", spin)]);
    let output = directory.run(&["run", "spin.gen", "--bounds", "none", "--until", "1s"]);
    assert_eq!(status(&output), 3, "{}", stdout(&output));
    assert!(stdout(&output).contains("time stands still"), "{}", stdout(&output));
}

#[test]
fn what_cannot_be_run_is_said() {
    let directory = Directory::new(&[("tight.gen", TIGHT), ("held.scn", HELD)]);
    for (arguments, what) in [
        (&["run", "held.scn", "--until", "soon"][..], "10s"),
        (&["run", "nowhere.scn"], "nowhere.scn"),
        (&["run", "held.scn", "--profile", "none/run.out"], "none/run.out"),
        (&["run", "held.scn", "tight.gen", "--profile", "run.out"], "one scenario at a time"),
        (&["run", "held.scn", "--check", "response tight.nobody"], "nobody"),
    ] {
        let output = directory.run(arguments);
        assert_eq!(status(&output), 2, "{arguments:?}");
        assert!(stderr(&output).contains(what), "{arguments:?}: {}", stderr(&output));
    }
    let files: Vec<_> = std::fs::read_dir(directory.path()).expect("a folder").flatten().collect();
    assert_eq!(files.len(), 2, "nothing stays behind: {files:?}");
}

/// Runs a published component without its codels, with definitions below a directory.
fn simulated(main: &Path, definitions: &Path) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dotgen"));
    let words = "run --simulate all --bounds none --until 200ms --format json -I";
    command.args(words.split(' ')).arg(definitions).arg(main);
    // Packages are not installed; their definitions stand in for them.
    command.env("PKG_CONFIG", "true");
    let output = command.output().expect("the program runs");
    let code = output.status.code();
    let why = String::from_utf8_lossy(&output.stderr);
    assert_eq!(code, Some(0), "{}: {why}", main.display());
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!(report["end"], "done", "{}", main.display());
    assert_eq!(report["executed-codels"], 0, "{}", main.display());
    assert!(report["simulated-codels"].as_u64() > Some(0), "{}", main.display());
}

#[test]
fn published_components_run() {
    let Some(corpus) = dotgen_loaders::shared("corpus") else {
        return;
    };
    let mut ran = 0;
    for (folder, definitions) in
        [("components", "components/standins"), ("quadcopter", "quadcopter"), ("robnav", "robnav")]
    {
        let definitions = corpus.join(definitions);
        let entries = std::fs::read_dir(corpus.join(folder)).expect("a directory");
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let main = format!("{}.gen", name.trim_end_matches("-genom3"));
            let main = entry.path().join(main);
            if main.is_file() {
                simulated(&main, &definitions);
                ran += 1;
            }
        }
    }
    assert!(ran >= 10, "{ran} components ran");
}

#[test]
fn chains_that_are_not_followed_are_named() {
    let specification = "typedef long number;
         component c {
           version \"1\"; lang \"c\";
           port in number raw; port out number clean;
           task t {
             period 10 ms;
             codel<start> go(port in raw, port out clean) yield pause::start wcet 1 ms;
           };
         };";
    let scenario = "scenario s { use \"c.gen\"; check reaction c.raw -> c.clean <= 1 ms; check schedulable \
        *; }";
    let directory = Directory::new(&[("c.gen", specification), ("s.scn", scenario)]);
    let output = directory.run(&["run", "s.scn", "--until", "1s", "--format", "json"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let report = json_of(&output);
    let notes = report["notes"].as_array().expect("a list");
    let named = |value: &Value| {
        let text = value.as_str().unwrap_or_default();
        text.starts_with("not checked along runs: `reaction c.raw -> c.clean`")
    };
    assert!(notes.iter().any(named), "{notes:?}");
    assert_eq!(report["checks"].as_array().map(Vec::len), Some(1));
}

#[test]
fn what_is_read_is_not_written() {
    let text = "component c { task t { period 10 ms; codel<start> f() yield pause::start wcet 1 ms; }; };\n";
    let directory = Directory::new(&[
        ("c.gen", text),
        ("c.scn", "scenario s { use \"c.gen\"; check schedulable *; }\n"),
        ("codel.c", "int f;\n"),
    ]);
    let before = |name: &str| std::fs::read(directory.path().join(name)).expect("it is there");
    let (specification, scenario) = (before("c.gen"), before("c.scn"));
    std::fs::hard_link(directory.path().join("c.gen"), directory.path().join("also.json"))
        .expect("a link");
    for (arguments, why) in [
        (&["run", "c.scn", "--profile", "./c.gen"][..], "would be lost"),
        (&["run", "c.scn", "--profile", "c.scn"], "would be lost"),
        (&["run", "c.scn", "--trace", "also.json"], "would be lost"),
        (&["verify", "c.scn", "--trace", "c.scn"], "FILE.json"),
        (&["run", "c.scn", "--profile", "codel.c"], "would be lost"),
        (&["run", "c.scn", "--socket", "s"], "--clock real"),
        (&["run", "c.scn", "--seed", "-1"], "invalid"),
        (&["run", "c.scn", "--profile", "x.json", "--trace", "./x.json"], "two contents"),
        (&["run", "c.scn", "--profile", "."], "a directory"),
        (&["run", "c.scn", "--trace", "x"], "pftrace"),
    ] {
        let output = directory.run(arguments);
        assert_eq!(status(&output), 2, "{arguments:?}");
        assert!(stderr(&output).contains(why), "{}", stderr(&output));
    }
    assert_eq!(before("c.gen"), specification);
    assert_eq!(before("c.scn"), scenario);
}

#[test]
fn without_execution_times_there_is_neither_load_nor_bound() {
    let spec = TIGHT.lines().map(|line| match line.find(" wcet ") {
        Some(at) => format!("{};\n", &line[..at]),
        None => format!("{line}\n"),
    });
    let spec: String = spec.collect();
    let directory = Directory::new(&[("tight.gen", &spec)]);
    let words = "run tight.gen --simulate all --until 400ms --format json";
    let virtually: Vec<&str> = words.split(' ').collect();
    let socket = ["--clock", "real", "--socket", "s"];
    for more in [&[][..], &socket] {
        let output = directory.run(&[&virtually[..], more].concat());
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let report = json_of(&output);
        for task in report["tasks"].as_array().expect("a list") {
            assert_eq!((task.get("load"), task.get("bound")), (None, None), "{task}");
        }
        let notes = report["notes"].to_string();
        assert!(notes.contains("no execution times: this run shows the order"), "{notes}");
    }
    directory.run(&[&virtually[..], &["--profile", "run.out"]].concat());
    let output = directory.run(&["monitor", "run.out", "tight.gen"]);
    assert_eq!(status(&output), 0, "{}", stdout(&output));
    assert!(
        stderr(&output).contains("no bounds, because no execution time: tight.fast.start"),
        "{}",
        stderr(&output)
    );
}

/// Ten tasks that share a datum on one core. Their exact response times need far too many states for a short
/// verification.
fn ten_tasks() -> String {
    let periods = [5, 10, 20, 25, 40, 50, 80, 100, 125, 200];
    let task = |(i, period): (usize, u32)| {
        format!(
            "task t{i} {{ period {period} ms; codel <start> c{i}(inout x) yield pause::start wcet {} us; \
             }};\n",
            period * 9
        )
    };
    let tasks: String = periods.into_iter().enumerate().map(task).collect();
    format!("component ten {{\nversion \"1\"; lang \"c\";\nids {{ long x; }};\n{tasks}}};\n")
}

/// The run ends long before its verification would, so it cannot have waited for the verification.
#[test]
fn a_run_does_not_wait_for_its_verification() {
    let directory = Directory::new(&[("ten.gen", &ten_tasks())]);
    let run = |arguments: &[&str]| {
        let all = ["run", "ten.gen", "--cores", "1", "--simulate", "all"];
        let all = [&all[..], &["--format", "json"]].concat();
        let output = directory.run(&[&all[..], arguments].concat());
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        json_of(&output)
    };
    let is_cancelled = |report: &Value| {
        let notes = report["notes"].as_array().expect("a list");
        let told = |value: &&Value| value.as_str().is_some_and(|text| text.contains("cancelled"));
        notes.iter().filter(told).count() == 1
    };
    let real = ["--clock", "real", "--until", "100ms"];
    let report = run(&real);
    assert!(is_cancelled(&report), "{report}");
    let analysed = run(&[&real[..], &["--bounds", "analysed"]].concat());
    assert!(!is_cancelled(&analysed), "{analysed}");
    // On the virtual clock there is no verification that a fast machine would complete.
    let virtually = run(&["--until", "100ms"]);
    assert!(!is_cancelled(&virtually), "{virtually}");
    assert_eq!(virtually, run(&["--until", "100ms"]));
}

/// A component as `dotgen new` writes it: its task may stop by itself.
const LAMP: &str = "\
component lamp {
  version \"1.0\"; lang \"c\";
  ids { long count; };
  task exec {
    period 10 ms;
    codel<start> begin(out count) yield main wcet 1 ms;
    codel<main> go_on(inout count) yield pause::main, stop wcet 1 ms;
    codel<stop> end(in count) yield ether wcet 1 ms;
  };
  task idle { period 10 ms; };
  activity blink() {
    task idle;
    codel<start> blink_it(in count) yield ether wcet 1 ms;
  };
};
";

#[test]
fn what_nothing_exercised_is_not_kept() {
    let checks = "check schedulable *; check response *; check reachable lamp.blink.start.exec; \
        check leadsto lamp.blink.start.exec => lamp.exec.main.exec; check always not lamp.blink.start.exec;";
    let scenario = format!("scenario lamp {{ use \"lamp.gen\"; {checks} }}\n");
    let directory = Directory::new(&[("lamp.gen", LAMP), ("lamp.scn", &scenario)]);
    for seed in ["0", "1", "2", "3"] {
        let run = ["run", "lamp.scn", "--simulate", "all", "--until", "1s", "--seed", seed];
        let output = directory.run(&run);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        let words = stdout(&output);
        assert!(words.starts_with("lamp: simulated, "), "{words}");
        assert!(
            words.ends_with("simulated: nothing violated; 4 checks not exercised\n"),
            "{words}"
        );
        assert!(words.contains("schedulable lamp.idle: lamp.idle executed no codel\n"), "{words}");
        let report = json_of(&directory.run(&[&run[..], &["--format", "json"]].concat()));
        let checks = report["checks"].as_array().expect("a list");
        let of =
            |check: &Value| format!("{} {}", check["check"], check["verdict"]).replace('"', "");
        let verdicts: Vec<String> = checks.iter().map(of).collect();
        let expected = [
            "schedulable simulated",
            "schedulable not-exercised",
            "response simulated",
            "response not-exercised",
            "reachable not-seen",
            "leadsto not-exercised",
            "always simulated",
        ];
        assert_eq!(verdicts, expected, "{report:#}");
        assert!(
            checks
                .iter()
                .all(|check| check["why"].is_string() != (check["verdict"] == "simulated"))
        );
        // The task does not stop by chance: it is busy in each of its cycles.
        let codels = report["codels"].as_array().expect("a list");
        let runs = |name: &str| {
            let codel = codels.iter().find(|codel| codel["codel"] == name).expect("a codel");
            codel["runs"].as_u64().expect("a number")
        };
        assert_eq!(runs("lamp.exec.stop"), 0);
        assert!(runs("lamp.exec.main") >= 98, "{report:#}");
    }
}

#[test]
fn the_reports_of_parts_merge_into_the_report_of_the_whole() {
    let specification = "component late {
               exception oops;
               task t { period 10 ms;
                 codel<start> f() yield pause::main wcet 2 ms;
                 codel<main> g() yield pause::main, slow wcet 8 ms;
                 codel<slow> h() yield pause::main wcet 4 ms; };
               activity go() { task t; codel<start> k() yield ether wcet 1 ms; throw oops; }; };
            ";
    let with_longer_codel = specification.replace("4 ms", "5 ms");
    let directory = Directory::new(&[
        ("late.gen", specification),
        (
            "late.scn",
            "scenario late { use \"late.gen\"; client c { repeat * { delay 30 ms; send late.go; } }
               check schedulable late.t; }",
        ),
    ]);
    let run = |options: &[&str]| {
        let words =
            ["run", "late.scn", "--simulate", "all", "--until", "200ms", "--format", "json"];
        directory.run(&[&words[..], options].concat())
    };
    let run_until = |options: &[&str]| {
        let words = ["run", "late.scn", "--simulate", "all", "--format", "json"];
        directory.run(&[&words[..], options].concat())
    };
    let runs = ["--runs", "100", "--seed", "5"];
    let whole = run(&runs);
    assert_eq!(status(&whole), 1, "{}", stderr(&whole));
    for number in 1..=3 {
        let part = run(&[&runs[..], &["--shard", &format!("{number}/3")]].concat());
        directory.write(&format!("{number}.json"), &part.stdout);
    }
    let merge = |words: &str| {
        let words: Vec<&str> = ["run", "merge"].into_iter().chain(words.split(' ')).collect();
        directory.run(&words)
    };
    let merged = merge("3.json 1.json 2.json --format json");
    assert_eq!(status(&merged), 1, "{}", stderr(&merged));
    assert_eq!(stdout(&merged), stdout(&whole));
    let check = &json_of(&whole)["checks"][0];
    assert!(check["probability"]["low"].as_f64() > Some(0.0), "{check}");
    // A part is missing.
    let gap = stdout(&merge("3.json 1.json"));
    assert!(gap.contains("the seeds of the runs have gaps"), "{gap}");
    // A run counts once, and only with runs of the same system.
    let twice = merge("1.json 1.json");
    assert_eq!(status(&twice), 2);
    assert!(stderr(&twice).contains("two reports contain the run with the seed 5"));
    directory.write("other.json", &run(&["--cores", "1"]).stdout);
    let longer = [&runs[..], &["--shard", "2/3", "--until", "300ms"]].concat();
    directory.write("longer.json", &run_until(&longer).stdout);
    let longer = merge("1.json longer.json");
    assert!(stderr(&longer).contains("different durations of a run"), "{}", stderr(&longer));
    let limit = [&runs[..], &["--shard", "2/3", "--check", "response late.t <= 9 ms"]].concat();
    directory.write("limit.json", &run(&limit).stdout);
    assert!(stderr(&merge("1.json limit.json")).contains("different checks"));
    directory.write("late.proba", b"# weights\n");
    let weights = [&runs[..], &["--shard", "2/3", "--weights", "late.proba"]].concat();
    directory.write("weights.json", &run(&weights).stdout);
    let weights = merge("1.json weights.json");
    assert!(stderr(&weights).contains("different assumptions"), "{}", stderr(&weights));
    let real = run(&["--clock", "real", "--runs", "9", "--shard", "1/3"]);
    assert!(stderr(&real).contains("are for `--clock virtual`"), "{}", stderr(&real));
    let text = stdout(&whole).replace("\"seed\": 5,", "\"seed\": 18446744073709551615,");
    directory.write("far.json", text.as_bytes());
    assert!(stderr(&merge("far.json")).contains("are not part"), "{}", stderr(&merge("far.json")));
    let other = merge("1.json other.json");
    assert_eq!(status(&other), 2);
    assert!(stderr(&other).contains("different clocks, platforms"), "{}", stderr(&other));
    directory.write("late.gen", with_longer_codel.as_bytes());
    directory.write("times.json", &run(&[&runs[..], &["--shard", "2/3"]].concat()).stdout);
    let times = merge("1.json times.json");
    assert!(stderr(&times).contains("different systems, execution times"), "{}", stderr(&times));
    assert_eq!(status(&merge("late.scn")), 2);
}

#[test]
fn a_run_that_a_measure_ends_is_the_last_one_and_no_sample() {
    let directory = Directory::new(&[
        (
            "late.gen",
            "component late { task t { period 10 ms;
               codel<start> f() yield pause::start, pause::slow wcet 2 ms;
               codel<slow> g() yield pause::start wcet 30 ms; }; };\n",
        ),
        (
            "late.scn",
            "scenario late { use \"late.gen\"; on late late.t { stop; } check schedulable late.t; }\n",
        ),
    ]);
    // With few runs, each is a part; with many, a part has several.
    for runs in ["20", "500"] {
        let words = ["run", "late.scn", "--simulate", "all", "--durations", "worst", "--format"];
        let output = directory.run(&[&words[..], &["json", "--runs", runs]].concat());
        let report = json_of(&output);
        assert_eq!((&report["runs"], &report["end"]), (&1.into(), &"measure".into()), "{report}");
        assert_eq!(report["is-sample"], false);
    }
}

#[test]
fn a_width_chooses_the_number_of_runs() {
    let options = ["--simulate", "all", "--until", "50ms", "--format", "json", "--width", "0.1"];
    let report = json_of(&pump(&options));
    assert_eq!(report["runs"], 738);
    for (options, words) in [
        (&["--width", "0"][..], "give a number from 0.001 to 1"),
        (&["--width", "0.1", "--runs", "3"], "cannot be used with"),
        (&["--runs", "2", "--shard", "3/3"], "at least as many as parts"),
        (&["--shard", "0/3"], "for example 3/8"),
        (&["--runs", "9", "--seed", "18446744073709551612"], "`--seed` is too large"),
    ] {
        let output = pump(options);
        assert_eq!(status(&output), 2);
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    }
}
