//! Recorded runs compared with the model: unchanged runs have no deviation, and planted deviations are found.

use std::collections::BTreeMap;

use dotgen_analysis::host::UnitResult;
use dotgen_recording::log;
use dotgen_recording::monitor::{Monitor, MonitorReport};
use dotgen_runtime::decide::Durations;
use dotgen_runtime::profile::{Profile, functions};
use dotgen_runtime::simulation::{Plan, simulate};
use dotgen_timing::analytic::response_bounds;
use dotgen_timing::report::Value;
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::{parse, parse_check};
use dotgen_timing::system::Ticks;
use dotgen_timing::verify::{Cancel, Options, Prepared, SystemInput, prepare, verify};

use crate::random_systems::{load, random, systems};

/// A scenario with its specifications.
struct Recorder {
    units: Vec<UnitResult>,
    scenario: String,
}

impl Recorder {
    /// Creates a scenario; `None` if a specification has errors, as machines are random.
    fn new(specifications: &[String], scenario: &str) -> Option<Recorder> {
        Some(Recorder { units: load(specifications)?, scenario: scenario.to_owned() })
    }

    fn prepared(&self) -> Option<Prepared> {
        let scenario = parse(&self.scenario).scenario;
        let prepared = prepare(&self.input(), &scenario, &Options::default());
        (!prepared.report.has_errors()).then_some(prepared)
    }

    fn input(&self) -> SystemInput<'_> {
        SystemInput { specs: self.units.iter().map(|unit| &*unit.spec).collect() }
    }

    fn record(&self, prepared: &Prepared, until: u64, seed: u64, durations: Durations) -> String {
        let system = &prepared.built.system;
        let input = self.input();
        let names = Names::new(&input.specs);
        let mut profile = Profile::new(system, functions(system, &names), Vec::new());
        let plan = Plan {
            until,
            runs: 1,
            seed,
            durations,
            weights: None,
            stop_at_violation: false,
            record: false,
        };
        let none = vec![None; system.tasks.len()];
        simulate(prepared, none, &plan, Some(&mut profile), None, &|| false);
        let (log, _) = profile.finish().expect("memory is written");
        String::from_utf8(log).expect("text")
    }

    /// Returns the bounds that verification proves.
    fn proved(&self, prepared: &Prepared) -> Vec<Option<Ticks>> {
        let options =
            Options { checks: parse_check("response *").expect("a check"), ..Options::default() };
        let scenario = parse(&self.scenario).scenario;
        let report = verify(&self.input(), &scenario, &options, &Cancel::default());
        let mut bounds = vec![None; prepared.built.system.tasks.len()];
        for check in &report.checks {
            let task = check.id.task.and_then(|task| prepared.built.tasks.get(&task));
            if let (Some(&task), Some(Value::Time(time))) = (task, check.value) {
                bounds[usize::from(task)] = Some((time / prepared.time(1)).round() as Ticks);
            }
        }
        bounds
    }

    fn monitor(&self, prepared: &Prepared, log: &str) -> MonitorReport {
        self.monitor_with(
            prepared,
            response_bounds(&prepared.built.system, &Cancel::default()).raw,
            log,
        )
    }

    fn monitor_with(
        &self,
        prepared: &Prepared,
        bounds: Vec<Option<Ticks>>,
        log: &str,
    ) -> MonitorReport {
        let system = &prepared.built.system;
        let input = self.input();
        let names = Names::new(&input.specs);
        let mut monitor = Monitor::new(system, &names, bounds);
        for (number, line) in (1..).zip(log.lines()) {
            monitor.line(number, line.as_bytes(), true);
        }
        monitor.report_so_far()
    }
}

/// Returns the least number of systems.
fn systems_to_run() -> u64 {
    dotgen_loaders::times(60)
}

#[test]
fn what_was_run_deviates_nowhere() {
    let (mut compared, mut seed, mut lines) = (0, 0, 0);
    while compared < systems_to_run() {
        assert!(seed < 20 * systems_to_run() + 100, "few systems are legal");
        let mut dice = systems::Dice::new(seed);
        let texts = match seed % 2 {
            0 => random::texts(&mut dice),
            _ => random::varied(&mut dice),
        };
        seed += 1;
        let Some(recorder) = Recorder::new(&texts.specifications, &texts.scenario) else {
            continue;
        };
        let Some(prepared) = recorder.prepared() else {
            continue;
        };
        for durations in [Durations::Worst, Durations::Random, Durations::Best] {
            let log = recorder.record(&prepared, 2_000, seed, durations);
            let report = recorder.monitor(&prepared, &log);
            assert_eq!(report.left.total(), 0);
            assert!(
                report.deviations.is_empty(),
                "seed {}, {durations:?}\n{:#?}\n{}\n{}\n{log}",
                seed - 1,
                report.deviations.first(),
                texts.specifications.join("\n"),
                texts.scenario,
            );
            assert_eq!(report.runs, log.lines().count() as u64, "seed {}\n{log}", seed - 1);
            lines += report.runs;
        }
        compared += 1;
    }
    assert!(lines > 100 * systems_to_run(), "{lines} lines say little");
}

const PLANT: &str = r#"
component plant {
  version "1.0"; lang "c";
  ids { long a, b, c; };
  exception e_full, e_other;
  task fast {
    period 10 ms;
    codel<start> fast_start(out a) yield pause::main wcet 1 ms;
    codel<main> fast_main(inout a) yield pause::main wcet 2 ms;
  };
  task slow {
    period 40 ms;
    codel<start> slow_start(in a) yield second wcet 1 ms;
    codel<second> slow_second(inout b) yield pause::start wcet 1 ms;
  };
  task side {
    period 20 ms;
    codel<start> side_start(inout c) yield pause::start wcet 2 ms;
  };
  activity go(in long x) {
    task fast;
    validate go_check(in x) wcet 1 ms;
    throw e_full;
    codel<start> go_start(in x, inout b) yield wait wcet 1 ms;
    codel<wait> go_wait(in x) yield pause::wait, ether wcet 1 ms;
  };
};
"#;

const SCENARIO: &str = r#"
scenario plant {
  use "plant.gen";
  cores 2;
  policy fifo;
  duration plant.slow.second [500,1000] us;
  client c { repeat * { delay [7,9] ms; send plant.go; await ended; } }
}
"#;

/// A line of a log, for changes.
#[derive(Debug, Clone)]
struct Row {
    times: [i64; 3],
    names: [String; 6],
}

impl Row {
    fn shift(&mut self, by: i64) {
        self.times.iter_mut().for_each(|time| *time += by);
    }

    fn is(&self, function: &str) -> bool {
        self.names[3] == function
    }
}

fn rows(log: &str) -> Vec<Row> {
    let row = |text: &str| {
        let line = log::line(text.as_bytes()).expect("a line");
        Row {
            times: [line.asked, line.began, line.ended],
            names: (line.names().expect("six"))
                .map(|name| String::from_utf8_lossy(name).into_owned()),
        }
    };
    log.lines().map(row).collect()
}

/// Returns the log in order of the ends, as a recorder writes it.
fn written(mut rows: Vec<Row>) -> String {
    rows.sort_by_key(|row| row.times[2]);
    let second = 1_000_000_000;
    let stamp = |number: &i64| format!("{}.{:09}", number / second, number % second);
    let line = |row: &Row| {
        let times: Vec<String> = row.times.iter().map(stamp).collect();
        format!("{} {}\n", times.join(" "), row.names.join(" "))
    };
    rows.iter().map(line).collect()
}

const MS: i64 = 1_000_000;

/// Returns the index of a run of a function, far from the start.
fn place(rows: &[Row], function: &str) -> usize {
    let places = rows.iter().enumerate().filter(|(_, row)| row.is(function));
    places.map(|place| place.0).nth(10).expect("it was executed often")
}

type Plant = (&'static str, &'static str, fn(&mut Vec<Row>));

/// Changes the runs of a permanent activity. `change` gets the number of the turn, from 0.
fn turns(rows: &mut [Row], function: &str, mut change: impl FnMut(i64, &mut Row)) {
    let all = rows.iter_mut().filter(|row| row.is(function));
    for (number, row) in (0..).zip(all) {
        change(number, row);
    }
}

const PLANTS: &[Plant] = &[
    ("an overrun", "longer", |rows| {
        let at = place(rows, "side_start");
        rows[at].times[2] = rows[at].times[1] + 3 * MS;
    }),
    ("an overrun of a codel of the control task", "longer", |rows| {
        let at = place(rows, "go_check");
        rows[at].times[2] = rows[at].times[1] + 2 * MS;
    }),
    ("a codel that was skipped over", "shorter", |rows| {
        let at = place(rows, "slow_second");
        rows[at].times[2] = rows[at].times[1];
    }),
    ("an undeclared transition", "transition", |rows| {
        let at = place(rows, "fast_main");
        "::plant::ether".clone_into(&mut rows[at].names[5]);
    }),
    ("a pause that is not declared", "transition", |rows| {
        let at = place(rows, "go_start");
        "::plant::pause::wait".clone_into(&mut rows[at].names[5]);
    }),
    ("an exception that is not declared", "transition", |rows| {
        let at = place(rows, "go_wait");
        "::plant::e_other".clone_into(&mut rows[at].names[5]);
    }),
    ("a request refused with another exception", "transition", |rows| {
        let at = place(rows, "go_check");
        "::plant::e_other".clone_into(&mut rows[at].names[5]);
    }),
    ("an unknown state", "unknown", |rows| {
        let at = place(rows, "fast_main");
        "::plant::nowhere".clone_into(&mut rows[at].names[4]);
    }),
    ("an unknown function", "unknown", |rows| {
        let at = place(rows, "fast_main");
        "somebody".clone_into(&mut rows[at].names[3]);
    }),
    ("an unknown task", "unknown", |rows| {
        let at = place(rows, "side_start");
        "back".clone_into(&mut rows[at].names[1]);
    }),
    ("an activity in another task", "unknown", |rows| {
        let at = place(rows, "go_wait");
        "side".clone_into(&mut rows[at].names[1]);
    }),
    ("a transition that is missing", "elsewhere", |rows| {
        let at = place(rows, "slow_second");
        rows.remove(at);
    }),
    ("a state before its time", "elsewhere", |rows| {
        let at = place(rows, "go_start");
        rows.remove(at);
    }),
    ("a start again", "elsewhere", |rows| {
        let at = place(rows, "fast_main");
        "fast_start".clone_into(&mut rows[at].names[3]);
        "::plant::start".clone_into(&mut rows[at].names[4]);
    }),
    ("two at once that share something", "together", |rows| {
        let at = place(rows, "fast_main");
        let began = rows[at].times[1];
        rows[at].times[2] = began + 2 * MS;
        let next = rows.iter().position(|row| row.is("slow_start") && row.times[0] >= began);
        let next = next.expect("it comes again");
        let length = rows[next].times[2] - rows[next].times[1];
        rows[next].times = [began + MS / 2, began + MS / 2, began + MS / 2 + length.max(MS / 4)];
    }),
    ("two codels of one task at once", "same-task", |rows| {
        let at = place(rows, "go_wait");
        let mut other = rows[at].clone();
        other.times = [other.times[1]; 3];
        rows[at].times[2] = rows[at].times[1] + MS;
        other.times = [other.times[0] + MS / 4, other.times[0] + MS / 4, other.times[0] + MS / 2];
        rows.push(other);
    }),
    ("more codels than cores", "cores", |rows| {
        let at = place(rows, "side_start");
        let began = rows[at].times[1];
        for function in ["side_start", "slow_second", "go_wait"] {
            let rows = rows.iter_mut().filter(|row| row.is(function));
            let nearest = rows.min_by_key(|row| (row.times[1] - began).abs());
            nearest.expect("it is executed").times = [began, began, began + MS / 2];
        }
    }),
    ("a period that drifts away", "late", |rows| {
        turns(rows, "side_start", |turn, row| row.shift(turn * MS / 2));
    }),
    ("a period that is too short", "early", |rows| {
        turns(rows, "side_start", |turn, row| row.shift(100 * MS - turn * MS / 3));
    }),
    ("a tick that is lost", "late", |rows| {
        let at = place(rows, "side_start");
        rows.remove(at);
    }),
    ("a tick too many", "early", |rows| {
        let at = place(rows, "side_start");
        let mut more = rows[at].clone();
        more.shift(3 * MS);
        rows.push(more);
    }),
    ("a response beyond its bound", "response", |rows| {
        let at = place(rows, "slow_second");
        rows[at].times[0] += 30 * MS;
        rows[at].times[1] += 30 * MS;
        rows[at].times[2] += 30 * MS;
    }),
    ("a lock out of turn", "overtaken", |rows| {
        let at = place(rows, "fast_main");
        let began = rows[at].times[1];
        rows[at].times = [began, began, began + MS];
        let next = rows.iter().position(|row| row.is("slow_start") && row.times[0] >= began);
        let next = next.expect("it comes again");
        // The codel asked first, and got its locks last.
        rows[next].times = [began - MS / 2, began + MS, began + 2 * MS];
    }),
];

#[test]
fn what_is_planted_is_found() {
    let recorder = Recorder::new(&[PLANT.to_owned()], SCENARIO).expect("it is legal");
    let prepared = recorder.prepared().expect("it is complete");
    let unit = prepared.ticks(num_rational::Ratio::from_integer(4));
    let bounds = recorder.proved(&prepared);
    for seed in 0..5 {
        let log = recorder.record(&prepared, unit, seed, Durations::Random);
        let clean = recorder.monitor_with(&prepared, bounds.clone(), &log);
        assert_eq!(clean.deviation_count, 0, "{:#?}", clean.deviations);
        assert!(clean.tasks.iter().all(|task| task.bound.is_some()), "{:#?}", clean.tasks);
        let clean_rows = rows(&log);
        let again = recorder.monitor_with(&prepared, bounds.clone(), &written(clean_rows.clone()));
        assert_eq!(again.deviation_count, 0, "{:#?}", again.deviations);
        for (name, kind, plant) in PLANTS {
            let mut rows = clean_rows.clone();
            plant(&mut rows);
            let report = recorder.monitor_with(&prepared, bounds.clone(), &written(rows));
            assert!(
                report.counts.contains_key(kind),
                "seed {seed}: {name} shows as {:?}",
                report.counts
            );
        }
    }
}

#[test]
fn transitions_never_taken_are_told() {
    let recorder = Recorder::new(&[PLANT.to_owned()], SCENARIO).expect("it is legal");
    let prepared = recorder.prepared().expect("it is complete");
    let until = prepared.ticks(num_rational::Ratio::from_integer(2));
    let log = recorder.record(&prepared, until, 1, Durations::Random);
    let never = |log: &str| -> Vec<String> {
        let report = recorder.monitor(&prepared, log);
        let all = report.never_taken.iter();
        all.map(|transition| {
            format!("{} {} {}", transition.machine, transition.from, transition.to)
        })
        .collect()
    };
    assert_eq!(never(&log), [""; 0]);
    let mut some = rows(&log);
    some.retain(|row| row.names[5] != "::plant::pause::wait");
    assert_eq!(never(&written(some)), ["plant.go wait pause::wait"]);
    let counts: BTreeMap<&str, u64> = recorder.monitor(&prepared, &log).counts;
    assert_eq!(counts, BTreeMap::new());
}

#[test]
fn a_thread_on_the_wrong_core_is_found() {
    let scenario = r#"
scenario plant {
  use "plant.gen";
  semantics servers;
  cores 2;
  policy priority;
  affinity plant.fast 1; affinity plant.slow 2; affinity plant.side 2;
  client c { repeat * { delay [7,9] ms; send plant.go; await ended; } }
}
"#;
    let long = PLANT.replace(
        "side_start(inout c) yield pause::start wcet 2 ms",
        "side_start(inout c) yield pause::start wcet 6 ms",
    );
    let long = long.replace(
        "slow_second(inout b) yield pause::start wcet 1 ms",
        "slow_second(inout b) yield pause::start wcet 20 ms",
    );
    let recorder = Recorder::new(&[long], scenario).expect("it is legal");
    let prepared = recorder.prepared().expect("it is complete");
    let unit = prepared.ticks(num_rational::Ratio::from_integer(4));
    let mut preempted = 0;
    for seed in 0..100 {
        let log = recorder.record(&prepared, unit, seed, Durations::Random);
        let clean = recorder.monitor(&prepared, &log);
        assert_eq!(clean.deviation_count, 0, "{:#?}", clean.deviations);
        let mut rows = rows(&log);
        // The task with the shorter period has priority, and preempts the other one.
        let inside = |a: &Row, b: &Row| {
            let long = b.times[1] + MS < b.times[2];
            a.times[1] + MS < b.times[1] && b.times[2] + MS < a.times[2] && long
        };
        let slow = rows.iter().enumerate().filter(|(_, row)| row.is("slow_second"));
        let side = || rows.iter().filter(|row| row.is("side_start"));
        let mut nested =
            slow.filter_map(|(at, row)| Some((at, side().find(|side| inside(row, side))?.times)));
        let Some((at, times)) = nested.next_back() else {
            continue;
        };
        preempted += 1;
        // On another core the codel would not have waited.
        rows[at].times[2] = i64::midpoint(times[1], times[2]);
        let report = recorder.monitor(&prepared, &written(rows));
        assert_eq!(report.counts.get("same-core"), Some(&1), "{:?}", report.counts);
    }
    assert!(preempted > 10, "{preempted}");
}

#[test]
fn the_line_of_an_end_is_the_one_that_readers_know() {
    assert_eq!(dotgen_runtime::profile::ENDING, dotgen_recording::log::ending());
}
