//! On random systems with all features of the servers, runs show only what verification allows.

use std::sync::atomic::{AtomicU64, Ordering};

use dotgen_runtime::checker::Verdict as Held;
use dotgen_runtime::decide::Durations;
use dotgen_runtime::engine::End;
use dotgen_runtime::simulation::{Plan, simulate};
use dotgen_timing::explore::Limits;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{Value, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, Question, SystemInput, prepare, verify};

use crate::random_systems::{load, random, systems};

/// Adds a measure that interrupts an activity after a violated check, and the check. `None` if there is no
/// activity.
fn with_measure(texts: &mut random::Texts) -> Option<()> {
    let activity = texts.specifications[0].split("activity ").nth(1)?.split('(').next()?;
    let items = format!(
        "check slow: response c.t0 <= 1 ms; on m: violation of slow {{ abort c.{activity}; }}"
    );
    let (before, end) = texts.scenario.rsplit_once('}')?;
    texts.scenario = format!("{before}{items}\n}}{end}");
    Some(())
}

/// Returns the number of checks compared; `None` if the system is invalid or too large.
fn compare(seed: u64, texts: &random::Texts) -> Option<usize> {
    let units = load(&texts.specifications)?;
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    let shown = || format!("seed {seed}\n{}\n{}", texts.specifications.join("\n"), texts.scenario);
    let scenario = parse(&texts.scenario).scenario;
    let options = Options {
        limits: Limits { states: 100_000, threads: 1, ..Limits::default() },
        ..Options::default()
    };
    let proved = verify(&input, &scenario, &options, &Cancel::default());
    if proved.has_errors() || proved.unknown() {
        return None;
    }
    let prepared = prepare(&input, &scenario, &options);
    assert_eq!(prepared.checks.len(), proved.checks.len(), "{}", shown());
    let tasks = prepared.built.system.tasks.len();
    for durations in [Durations::Worst, Durations::Random, Durations::Best] {
        let plan = Plan {
            until: 400,
            runs: 4,
            seed,
            durations,
            weights: None,
            stop_at_violation: false,
            record: false,
        };
        let none: Option<&mut dotgen_runtime::profile::Profile<Vec<u8>>> = None;
        let outcome = simulate(&prepared, vec![None; tasks], &plan, none, None, &|| false);
        assert!(
            matches!(outcome.end, End::Done | End::NothingLeft | End::Standstill),
            "{:?}",
            outcome.end
        );
        for (i, check) in proved.checks.iter().enumerate() {
            let (asked, answer) = (&prepared.checks[i], &outcome.judge.answers[i]);
            let about =
                || format!("{} {}: {answer:?}, {check:?}\n{}", check.kind, check.of, shown());
            assert_eq!(asked.report.id, check.id, "{}", about());
            match asked.question {
                Question::Reachable(_) => {
                    let contradicts =
                        answer.verdict == Held::Seen && check.verdict == Verdict::Refuted;
                    assert!(!contradicts, "{}", about());
                }
                Question::Response(..) | Question::Within(..) => {
                    if let (Some(seen), Some(Value::Time(most))) = (answer.greatest, check.value) {
                        assert!(prepared.time(u64::from(seen)) <= most, "{}", about());
                        TAKEN.fetch_add(u64::from(check.of.starts_with("on ")), Ordering::Relaxed);
                    }
                }
                _ => {
                    let contradicts = answer.verdict == Held::Violated && check.verdict.holds();
                    let violated =
                        answer.verdict == Held::Violated && check.kind == PropertyKind::Pattern;
                    VIOLATED.fetch_add(u64::from(violated), Ordering::Relaxed);
                    assert!(!contradicts, "{}", about());
                }
            }
        }
    }
    Some(proved.checks.len())
}

/// Returns the least number of systems.
fn systems_to_compare() -> u64 {
    dotgen_loaders::times(20)
}

/// Number of measures that runs have taken.
static TAKEN: AtomicU64 = AtomicU64::new(0);

/// Number of patterns that runs have violated.
static VIOLATED: AtomicU64 = AtomicU64::new(0);

fn compare_all(systems: u64, draw: fn(&mut systems::Dice) -> Option<random::Texts>) {
    let mut compared = 0;
    let mut seed = 0;
    while compared < systems {
        let texts = draw(&mut systems::Dice::new(seed));
        let checks = texts.and_then(|texts| compare(seed, &texts));
        compared += u64::from(checks.is_some_and(|checks| checks > 0));
        seed += 1;
        assert!(seed < 40 * systems + 100, "few systems are legal and small");
    }
}

#[test]
fn nothing_is_seen_that_verification_excludes() {
    compare_all(systems_to_compare(), |dice| Some(random::texts(dice)));
}

#[test]
fn no_pattern_is_violated_that_is_proved() {
    compare_all(systems_to_compare() / 2, |dice| Some(random::patterned(dice)));
    assert!(VIOLATED.load(Ordering::Relaxed) > 0, "no pattern was violated");
}

#[test]
fn no_measure_takes_longer_than_verified() {
    compare_all(systems_to_compare() / 2, |dice| {
        let mut texts = random::texts(dice);
        with_measure(&mut texts)?;
        Some(texts)
    });
    assert!(TAKEN.load(Ordering::Relaxed) > 0, "no measure was taken");
}

#[test]
fn refused_requests_are_counted_whatever_refuses_them() {
    let specification = "component a { version \"1.0\"; lang \"c\"; ids { long x; };\n\
        task t { period 10 ms; };\n\
        function init() { codel a_init(out x) wcet 1 ms; };\n\
        function go() { after init; codel a_go(in x) wcet 1 ms; };\n\
        activity act() { task t; before init; codel<start> a_s(out x) yield pause::start wcet 1 ms; };\n\
        };";
    let units = load(&[specification.to_owned()]).expect("a specification");
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    let counts = |client: &str, service: &str| {
        let text =
            format!("scenario s {{ use \"a.gen\"; semantics servers; client c {{ {client} }} }}");
        let prepared = prepare(&input, &parse(&text).scenario, &Options::default());
        let plan = Plan {
            until: 1000,
            runs: 1,
            seed: 0,
            durations: Durations::Worst,
            weights: None,
            stop_at_violation: false,
            record: false,
        };
        let none: Option<&mut dotgen_runtime::profile::Profile<Vec<u8>>> = None;
        let outcome = simulate(&prepared, vec![None; 1], &plan, none, None, &|| false);
        let services = &prepared.built.system.services;
        let found = services.iter_enumerated().find(|(_, other)| other.name.ends_with(service));
        let counts = outcome.tally.services[found.expect("a service").0];
        (counts.requests, counts.refused)
    };
    // By `after`, by `before`, and for lack of a slot.
    assert_eq!(counts("send a.go; send a.go;", "go"), (2, 2));
    assert_eq!(counts("send a.init; send a.go;", "go"), (1, 0));
    assert_eq!(counts("send a.init; send a.act;", "act"), (1, 1));
    let many = "send a.act; ".repeat(40);
    let (requests, refused) = counts(&many, "act");
    assert_eq!(requests, 40);
    assert!(refused > 0 && refused < 40, "{refused}");
}

/// Each of several runs takes its measures.
#[test]
fn each_run_takes_its_measures() {
    let specification = "component a { version \"1.0\"; lang \"c\"; ids { long x; };\n\
        task t { period 10 ms; codel<start> a_s(out x) yield pause::start wcet 2 ms; };\n\
        function go() { codel a_go(in x) wcet 1 ms; };\n\
        };";
    let units = load(&[specification.to_owned()]).expect("a specification");
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    let text = "scenario s { use \"a.gen\"; check slow: response a.t <= 1 ms;\n\
        on violation of slow { send a.go; } }";
    let prepared = prepare(&input, &parse(text).scenario, &Options::default());
    let durations = Durations::Worst;
    let plan = Plan {
        until: 100,
        runs: 3,
        seed: 0,
        durations,
        weights: None,
        stop_at_violation: false,
        record: false,
    };
    let none: Option<&mut dotgen_runtime::profile::Profile<Vec<u8>>> = None;
    let outcome = simulate(&prepared, vec![None; 1], &plan, none, None, &|| false);
    let services = prepared.built.system.services.iter_enumerated();
    let go = services.into_iter().find(|(_, service)| service.name == "go").expect("a service").0;
    assert_eq!(outcome.tally.services[go].requests, 3);
}
