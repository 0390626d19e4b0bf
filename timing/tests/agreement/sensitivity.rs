//! Agreement of the limits of `sensitivity` with bisection by whole verifications.

use dotgen_loaders::unit;
use dotgen_timing::derive::{Extreme, largest_wcet};
use dotgen_timing::explore::Limits;
use dotgen_timing::report::{Value, Verdict};
use dotgen_timing::scn::ast::Path;
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use super::servers::random::{Texts, periodic, quiet};
use super::{all_agree, first, systems};

/// Times are whole numbers of this part of a millisecond.
const PARTS: u32 = 100;

/// The longest time that is tried, in milliseconds.
const LONGEST: u32 = 64;

fn options() -> Options {
    // Each verification has a twentieth of the states.
    let limits = Limits { states: 800_000, threads: 1, ..Limits::default() };
    Options { limits, ..Options::default() }
}

/// The same platform, with the deadlines of all tasks as the only check.
fn deadlines(texts: &Texts) -> String {
    let kept = texts.scenario.lines().filter(|line| !line.trim_start().starts_with("check"));
    let kept = kept.map(|line| line.replace("durations fixed", "durations interval"));
    let text = kept.collect::<Vec<_>>().join("\n");
    let (items, end) = text.rsplit_once('}').expect("a scenario ends");
    format!("{items}check schedulable *;\n}}{end}")
}

fn with<T>(texts: &Texts, scenario: &str, ask: impl FnOnce(&SystemInput, &str) -> T) -> Option<T> {
    let units: Result<Vec<_>, _> = texts.specifications.iter().map(|file| unit(file)).collect();
    let units = units.ok()?;
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    Some(ask(&input, scenario))
}

/// Whether all deadlines are met if the codel takes up to this time; `None` if that is not known.
fn holds(texts: &Texts, scenario: &str, codel: &str, time: u32) -> Option<bool> {
    let (items, end) = scenario.rsplit_once('}').expect("a scenario ends");
    let time = time * (1000 / PARTS);
    let scenario = format!("{items}duration {codel} [0, {time}] us;\n}}{end}");
    with(texts, &scenario, |input, scenario| {
        let parsed = parse(scenario);
        assert!(parsed.errors.is_empty(), "{:?}\n{scenario}", parsed.errors);
        let report = verify(input, &parsed.scenario, &options(), &Cancel::default());
        let mut verdicts = report.checks.iter().map(|check| check.verdict);
        let unknown = |verdict: Verdict| verdict == Verdict::Unknown;
        if verdicts.clone().any(unknown) || report.has_errors() {
            None
        } else {
            Some(verdicts.all(|verdict| verdict == Verdict::Proved))
        }
    })?
}

/// Finds the largest time that holds by bisection; `None` if some time is not decided.
fn bisected(texts: &Texts, scenario: &str, codel: &str) -> Option<u32> {
    let (mut good, mut bad) = (0, LONGEST * PARTS);
    if !holds(texts, scenario, codel, good)? || holds(texts, scenario, codel, bad)? {
        return None;
    }
    while bad - good > 1 {
        let middle = good.midpoint(bad);
        if holds(texts, scenario, codel, middle)? { good = middle } else { bad = middle }
    }
    Some(good)
}

fn compare(name: &str, codel: &str, texts: &Texts) -> Option<Result<(), String>> {
    let scenario = deadlines(texts);
    let found: Extreme = with(texts, &scenario, |input, scenario| {
        let parsed = parse(scenario);
        largest_wcet(input, &parsed.scenario, &options(), &Path::of(codel), &Cancel::default()).ok()
    })??;
    let Some(Value::Time(largest)) = found.extreme.filter(|_| found.exact && !found.incomplete)
    else {
        return None;
    };
    let bisected = f64::from(bisected(texts, &scenario, codel)?) / f64::from(PARTS);
    let distance = bisected - largest;
    let step = 1.0 / f64::from(PARTS);
    let near = -step / 2.0 <= distance && distance < found.resolution + step / 2.0;
    Some(if near {
        Ok(())
    } else {
        let texts = texts.specifications.join("\n");
        Err(format!("{name}, {codel}: {found:?}, by bisection {bisected} ms\n{texts}\n{scenario}"))
    })
}

#[test]
fn the_largest_time_is_that_of_bisection() {
    all_agree(first(), dotgen_loaders::times(12), 3, |seed| {
        let dice = &mut systems::Dice::new(seed);
        let draw = [quiet, periodic][seed as usize % 2];
        let texts = draw(dice);
        let codel = dice.pick(&["c.t0.start", "c.t1.start", "d.t0.start"]);
        compare(&format!("seed {seed}"), codel, &texts)
    });
}
