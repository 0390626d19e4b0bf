//! Weights of yields, and the probabilities that runs estimate.

use dotgen_runtime::checker::RunChecker;
use dotgen_runtime::decide::Durations;
use dotgen_runtime::estimate::Estimate;
use dotgen_runtime::profile::Profile;
use dotgen_runtime::simulation::{Plan, simulate};
use dotgen_runtime::weights::Weights;
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Options, Prepared, SystemInput, prepare};

use crate::random_systems::load;

const SPECIFICATION: &str = "component c {
  version \"1\"; lang \"c\"; exception bad;
  task t {
    period 10 ms; throw bad;
    codel<start> c_start() yield pause::start, pause::failed, ether wcet 1 ms;
    codel<failed> c_failed() yield pause::failed wcet 1 ms;
  };
};";

fn prepared() -> Prepared {
    let units = load(&[SPECIFICATION.to_owned()]).expect("no errors");
    let scenario = parse("scenario s { unit 1 ms; check never c.t.failed; }");
    assert_eq!(scenario.errors, []);
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    prepare(&input, &scenario.scenario, &Options::default())
}

/// Returns the number of runs of so many milliseconds in which the check is violated.
fn violated(prepared: &Prepared, weights: &Weights, runs: u64, until: u64, seed: u64) -> u64 {
    let plan = Plan {
        until: prepared.ticks(num_rational::Ratio::new(i128::from(until), 1000)),
        runs,
        seed,
        durations: Durations::Worst,
        weights: Some(weights),
        stop_at_violation: false,
        record: false,
    };
    let none: Option<&mut Profile<Vec<u8>>> = None;
    let bounds = vec![None; prepared.built.system.tasks.len()];
    let outcome = simulate(prepared, bounds, &plan, none, None, &|| false);
    let judge: &RunChecker = &outcome.judge;
    judge.answers[0].in_runs
}

fn weights(prepared: &Prepared, text: &str) -> Weights {
    let (weights, unknown) = Weights::parse(text, &prepared.built.system).expect("it is valid");
    assert_eq!(unknown, []);
    weights
}

#[test]
fn yields_without_weight_are_never_taken() {
    let prepared = prepared();
    let never =
        weights(&prepared, "t::c_start::c_pause_start 3 # stays\nt::c_start::c_pause_failed 0\n");
    assert_eq!(violated(&prepared, &never, 20, 200, 0), 0);
    let always = weights(&prepared, "t::c_start::c_pause_failed 1\n");
    assert_eq!(violated(&prepared, &always, 20, 200, 0), 20);
}

/// The probability of a failure in *k* of its periods is 1 - (1 - p)^k.
#[test]
fn estimates_contain_the_exact_probability_as_often_as_they_say() {
    let prepared = prepared();
    let mut contained = 0;
    for system in 0..20_u64 {
        let failures = 1 + system % 5;
        let text = format!(
            "t::c_start::c_pause_start {}\nt::c_start::c_pause_failed {failures}\n",
            20 - failures
        );
        let weights = weights(&prepared, &text);
        let (runs, drawn) = (200, 1 + system / 5);
        // A failure that is drawn shows in the next period.
        let found = violated(&prepared, &weights, runs, 10 * (drawn + 1) + 5, 1000 * system);
        let exact = 1.0 - (1.0 - failures as f64 / 20.0).powi(drawn as i32);
        let Estimate { low, high, .. } = Estimate::of(found, runs, 0.95);
        contained += u32::from(low <= exact && exact <= high);
    }
    assert!(contained >= 18, "{contained} of 20");
}

#[test]
fn lines_that_fit_nothing_are_told() {
    let prepared = prepared();
    let parse = |text: &str| Weights::parse(text, &prepared.built.system);
    let (_, unknown) = parse("\nt::c_start::c_other 1\n").expect("it is valid");
    assert_eq!(unknown.iter().map(|bad| bad.line).collect::<Vec<_>>(), [2]);
    for bad in ["t::c_start 1", "t::c_start::c_failed", "t::c_start::c_failed -1", "a b c"] {
        assert_eq!(parse(&format!("# weights\n{bad}\n")).expect_err(bad).line, 2, "{bad}");
    }
}
