//! Recorded runs replayed step by step: every run is one of the model, and a changed rule is named.

use dotgen_analysis::host::UnitResult;
use dotgen_recording::replay::{
    DifferenceKind, Observed, Replay, ReplayReport, Rule, Step, with_any_exception,
};
use dotgen_runtime::decide::Durations;
use dotgen_runtime::profile::Profile;
use dotgen_runtime::simulation::{Plan, Record, simulate_recorded};
use dotgen_runtime::watch::PortUpdate;
use dotgen_timing::explore::{Action, Stepper, Watched};
use dotgen_timing::scn::parse;
use dotgen_timing::scn::semantics::LockRule;
use dotgen_timing::system::{FOREVER, Policy, TimedSystem, Yield};
use dotgen_timing::verify::{Options, Prepared, SystemInput, prepare};

use crate::random_systems::{load, random, systems};

/// Steps, by name.
pub(crate) struct Recording<'s> {
    system: &'s TimedSystem,
    pub(crate) steps: Vec<Step>,
    /// Time of the end, in base units.
    pub(crate) end: u64,
}

impl<'s> Recording<'s> {
    pub(crate) fn new(system: &'s TimedSystem) -> Self {
        Recording { system, steps: Vec::new(), end: 0 }
    }
}

impl Record for Recording<'_> {
    fn on_action(&mut self, stepper: &Stepper, action: Action, executed: Option<u64>) {
        self.steps.push(Step { executed, ..Step::new(self.system, stepper, action) });
    }

    fn interrupt(&mut self, stepper: &Stepper, place: usize) {
        self.steps.push(Step::abort(self.system, stepper, place));
    }

    fn on_ending(&mut self, stepper: &Stepper) {
        self.steps.push(Step::stop(stepper));
    }

    fn on_port_update(&mut self, _: &Stepper, _: &PortUpdate) {}

    fn end(&mut self, stepper: &Stepper) {
        self.end = stepper.now();
    }
}

fn record(prepared: &Prepared, until: u64, seed: u64, durations: Durations) -> (Vec<Step>, u64) {
    let system = &prepared.built.system;
    let plan = Plan {
        until,
        runs: 1,
        seed,
        durations,
        weights: None,
        stop_at_violation: false,
        record: false,
    };
    let mut recording = Recording::new(system);
    let none: Option<&mut Profile<Vec<u8>>> = None;
    let bounds = vec![None; system.tasks.len()];
    simulate_recorded(prepared, bounds, &plan, none, Some(&mut recording), None, &|| false);
    (recording.steps, recording.end)
}

pub(crate) fn replay(verified: &TimedSystem, steps: &[Step], end: u64) -> ReplayReport {
    let system = with_any_exception(verified);
    let mut ignore = |_: &Stepper, _: Observed| {};
    let mut replay = Replay::new(&system, verified, None, &Watched::default(), &mut ignore);
    for step in steps {
        replay.step(step);
    }
    replay.end(end)
}

fn prepared(units: &[UnitResult], scenario: &str) -> Option<Prepared> {
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    let prepared = prepare(&input, &parse(scenario).scenario, &Options::default());
    (!prepared.report.has_errors()).then_some(prepared)
}

/// Returns the least number of steps.
fn steps_to_replay() -> u64 {
    dotgen_loaders::times(100_000)
}

#[test]
fn every_run_is_one_of_the_model() {
    let (mut compared, mut seed, mut all) = (0, 0, 0);
    let (mut changed, mut found) = (0u64, 0u64);
    while all < steps_to_replay() {
        assert!(seed < 20 * compared + 100, "few systems are legal");
        let mut dice = systems::Dice::new(seed);
        let texts = match seed % 2 {
            0 => random::texts(&mut dice),
            _ => random::varied(&mut dice),
        };
        seed += 1;
        let Some(units) = load(&texts.specifications) else {
            continue;
        };
        let Some(prepared) = prepared(&units, &texts.scenario) else {
            continue;
        };
        let system = &prepared.built.system;
        for durations in [Durations::Worst, Durations::Random, Durations::Best] {
            let (steps, end) = record(&prepared, 1_000, seed, durations);
            let report = replay(system, &steps, end);
            let shown = || {
                format!(
                    "seed {}, {durations:?}\n{:#?}\n{}\n{}\n{}",
                    seed - 1,
                    report.differences.first(),
                    (steps.iter().take(report.followed as usize + 1))
                        .map(|step| format!("{} {}", step.time, step.describe()))
                        .collect::<Vec<_>>()
                        .join("\n"),
                    texts.specifications.join("\n"),
                    texts.scenario
                )
            };
            assert_eq!(report.difference_count, 0, "{}", shown());
            assert_eq!(report.followed, steps.len() as u64, "{}", shown());
            assert_eq!(report.time, end);
            all += report.steps;
            // An outcome that no rule allows.
            let ends: Vec<usize> = (0..steps.len())
                .filter(|&step| steps[step].rule == Rule::End && steps[step].to != "ok")
                .collect();
            if ends.is_empty() {
                continue;
            }
            let at = ends[dice.below(ends.len() as u32) as usize];
            let mut wrong = steps.clone();
            wrong[at].to = "nowhere".to_owned();
            let report = replay(system, &wrong, end);
            let first = report.differences.first().expect("it is found");
            assert_eq!((first.number, first.rule), (at as u64 + 1, Rule::End));
            // An omitted step: later steps show it, unless the system would have done without it.
            let mut wrong = steps.clone();
            wrong.remove(at);
            changed += 1;
            found += u64::from(replay(system, &wrong, end).difference_count > 0);
        }
        compared += 1;
    }
    println!("{all} steps of {compared} random systems, in three runs of each");
    assert!(all > 100 * compared, "{all} steps say little");
    assert!(found * 10 > changed * 9, "{found} of {changed} are found");
}

const PLANT: &str = r#"
component plant {
  version "1.0"; lang "c";
  ids { long a, b; };
  exception e_full;
  task fast {
    period 10 ms;
    codel<start> fast_start(out a) yield pause::main wcet 1 ms;
    codel<main> fast_main(inout a) yield pause::main, pause::other wcet 2 ms;
    codel<other> fast_other(inout a) yield pause::main wcet 2 ms;
  };
  task late {
    period 10 ms;
    codel<start> late_start(inout a) yield pause::start wcet 1 ms;
  };
  task side {
    period 10 ms;
    codel<start> side_start(inout b) yield pause::start wcet 1 ms;
  };
  task slow {
    period 30 ms; delay 5 ms;
    codel<start> slow_start(inout a) yield pause::start wcet 3 ms;
  };
  activity go(in long x) {
    task fast;
    validate go_check(in x) wcet 1 ms;
    throw e_full;
    codel<start> go_start(in x, inout b) yield pause::start, ether wcet 1 ms;
  };
};
"#;

const SCENARIO: &str = r#"
scenario plant {
  use "plant.gen";
  cores 1;
  policy fifo;
  duration plant.slow.start [1,3] ms;
  client c { repeat * { delay [7,9] ms; send plant.go; await ended; } }
}
"#;

type Change = (&'static str, &'static [Rule], fn(&mut TimedSystem));

fn codel<'s>(system: &'s mut TimedSystem, path: &str) -> &'s mut dotgen_timing::system::Codel {
    let mut all = system.codels.iter_mut();
    all.find(|codel| *codel.path == *path).expect("it is there")
}

/// The change for which the activity declares no exception. A permanent activity throws none by chance.
const UNDECLARED: &str = "an exception that is not declared";

/// Systems with one changed rule.
const CHANGES: &[Change] = &[
    ("a longer period", &[Rule::Tick], |system| {
        let period = system.tasks.raw[0].period.as_mut().expect("periodic");
        *period += *period / 2;
    }),
    ("a shorter period", &[Rule::Tick], |system| {
        let period = system.tasks.raw[1].period.as_mut().expect("periodic");
        *period /= 2;
    }),
    ("a codel that takes longer", &[Rule::End], |system| {
        codel(system, "plant.fast.main").upper *= 2;
        codel(system, "plant.fast.main").lower = codel(system, "plant.fast.main").upper;
    }),
    ("a codel that takes less", &[Rule::End], |system| {
        codel(system, "plant.slow.start").lower = 0;
        codel(system, "plant.slow.start").upper = 0;
    }),
    ("a codel without limit", &[Rule::End], |system| {
        codel(system, "plant.go.start").upper = FOREVER;
        codel(system, "plant.go.start").lower = 20_000;
    }),
    ("another yield", &[Rule::End], |system| {
        let machine = system.machines.iter_mut().find(|machine| machine.name == "plant.fast");
        let machine = machine.expect("a permanent activity");
        let other = machine.states.iter().position(|state| state.name == "other");
        let start = machine.states.iter_mut().find(|state| state.name == "start");
        start.expect("a state").yields = vec![Yield::Pause(other.expect("a state"))];
    }),
    ("a pause that is none", &[Rule::End], |system| {
        let machine = system.machines.iter_mut().find(|machine| machine.name == "plant.fast");
        let states = &mut machine.expect("a permanent activity").states;
        let main = states.iter().position(|state| state.name == "main").expect("a state");
        let other = states.iter_mut().find(|state| state.name == "other").expect("a state");
        other.yields = vec![Yield::Next(main)];
    }),
    ("more cores", &[Rule::Grant], |system| {
        system.platform.cores = Some(2);
    }),
    ("a lock that no codel needs", &[Rule::Locks], |system| {
        system.platform.cores = None;
        for codel in &mut system.codels {
            codel.conflicts = Default::default();
        }
    }),
    ("locks as they come, for which no codel waits in order", &[Rule::Locks], |system| {
        system.platform.cores = None;
        system.platform.semantics.locks = LockRule::Free;
    }),
    ("another policy", &[Rule::Release], |system| {
        system.platform.policy = Policy::Priority;
    }),
    ("a client that does not wait", &[Rule::Delay], |system| {
        for step in system.clients.iter_mut().flat_map(|client| &mut client.steps) {
            if let dotgen_timing::system::ClientAction::Delay(least, _) = &mut step.action {
                *least = 0;
            }
        }
    }),
    (UNDECLARED, &[Rule::End], |system| {
        let machine = system.machines.iter_mut().find(|machine| machine.name == "plant.go");
        let start = &mut machine.expect("an activity").states[0];
        // Next to `ether`, an exception makes no difference.
        start.yields.retain(|transition| *transition != Yield::End);
    }),
];

#[test]
fn a_rule_that_was_another_one_is_named() {
    let units = load(&[PLANT.to_owned()]).expect("it is legal");
    let prepared = prepared(&units, SCENARIO).expect("it is complete");
    let until = prepared.ticks(num_rational::Ratio::from_integer(2));
    for (name, rules, change) in CHANGES {
        let mut other = prepared.clone();
        change(&mut other.built.system);
        for seed in 0..3 {
            let (steps, end) = record(&other, until, seed, Durations::Random);
            let mut verified = prepared.built.system.clone();
            // Otherwise there is one core, and no codel waits for a lock.
            if *rules == [Rule::Locks] {
                verified.platform.cores = None;
            }
            if *name == UNDECLARED {
                codel(&mut verified, "plant.go.start").throws = false;
            }
            let report = replay(&verified, &steps, end);
            let first = report.differences.first();
            let rule = first.map(|difference| difference.rule);
            assert!(rule.is_some_and(|rule| rules.contains(&rule)), "{name}: {rule:?} {first:#?}");
        }
    }
}

#[test]
fn a_run_is_followed_beyond_a_wrong_time_and_not_beyond_what_is_impossible() {
    let units = load(&[PLANT.to_owned()]).expect("it is legal");
    let prepared = prepared(&units, SCENARIO).expect("it is complete");
    let system = &prepared.built.system;
    let until = prepared.ticks(num_rational::Ratio::from_integer(2));
    let mut slower = prepared.clone();
    let upper = codel(&mut slower.built.system, "plant.slow.start").upper;
    codel(&mut slower.built.system, "plant.slow.start").upper = upper + 1;
    let (steps, end) = record(&slower, until, 1, Durations::Worst);
    let report = replay(system, &steps, end);
    assert_eq!(report.followed, steps.len() as u64);
    assert!(report.difference_count > 50, "{}", report.difference_count);
    for difference in &report.differences {
        let (took, limit) = (u64::from(upper) + 1, upper);
        assert_eq!(difference.what, DifferenceKind::Longer { took, limit });
        assert!(difference.step.what.starts_with("plant.slow.start"), "{difference:?}");
    }
    let (steps, end) = record(&prepared, until, 1, Durations::Worst);
    let ticks = |step: &Step| step.rule == Rule::Tick && step.of == "plant.slow";
    let tick = steps.iter().position(|step| ticks(step) && step.time > end / 2);
    let (before, after) = steps.split_at(tick.expect("it is periodic"));
    let due = after[0].clone();
    // A task that stops at some moment.
    let others = after.iter().filter(|step| step.of != "plant.slow");
    let steps: Vec<Step> = before.iter().chain(others).cloned().collect();
    let report = replay(system, &steps, end);
    assert_eq!(report.difference_count, 1);
    let first = &report.differences[0];
    assert_eq!(first.rule, Rule::Tick, "{first:?}");
    assert_eq!(first.what, DifferenceKind::Omitted { due }, "{first:?}");
    assert!(report.followed < report.steps);
}
