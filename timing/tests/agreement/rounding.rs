//! Agreement of answers that were looked for with rounded times with those of the exact times alone.

use std::sync::atomic::{AtomicUsize, Ordering};

use dotgen_loaders::unit;
use dotgen_timing::explore::Limits;
use dotgen_timing::report::{CheckReport, Report, Soundness, Value, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use super::servers::random::{Texts, chained, periodic, quiet, requests, texts, varied};
use super::{all_agree, first, systems};

/// Replaces execution times by times that are no multiples of a millisecond.
fn off_the_unit(dice: &mut systems::Dice, texts: &mut Texts) {
    for specification in &mut texts.specifications {
        let parts: Vec<String> = specification.split("wcet ").map(str::to_owned).collect();
        let mut out = parts[0].clone();
        for part in &parts[1..] {
            let (number, rest) = part.split_once(' ').expect("a unit");
            let time: u32 = number.parse().expect("a whole number");
            let off = dice.pick(&["05", "25", "5", "85"]);
            let time = if time == 0 { "0".to_owned() } else { format!("{}.{off}", time - 1) };
            out += &format!("wcet {time} {rest}");
        }
        *specification = out;
    }
}

fn report(texts: &Texts, unit_item: &str) -> Option<Report> {
    let units: Result<Vec<_>, _> = texts.specifications.iter().map(|file| unit(file)).collect();
    let units = units.ok()?;
    let parsed = parse(&texts.scenario.replace("unit 1 ms;", unit_item));
    assert!(parsed.errors.is_empty(), "{:?}", parsed.errors);
    let limits = Limits { states: 60_000, bytes: 1 << 28, threads: 1, ..Limits::default() };
    let options = Options { limits, ..Options::default() };
    let input = SystemInput { specs: units.iter().map(|unit| &*unit.spec).collect() };
    Some(verify(&input, &parsed.scenario, &options, &Cancel::default()))
}

/// Checks that what a late job did takes no longer than the job.
fn beyond_its_parts(check: &CheckReport) -> Option<String> {
    let job = check.job.as_ref()?;
    let executed: f64 = job.executed.iter().map(|work| work.time + work.preempted).sum();
    let waited: f64 = check.reason.iter().map(|delay| delay.until - delay.from).sum();
    let (parts, whole) = (executed + waited + job.begun - job.from, job.until - job.from);
    LATE.fetch_add(1, Ordering::Relaxed);
    let name = format!("{} {}", check.kind, check.of);
    (parts > whole + 1e-6)
        .then(|| format!("{name}: parts of {parts} in {whole}: {job:?} {:?}", check.reason))
}

fn compare(name: &str, texts: &Texts) -> Option<Result<(), String>> {
    let shown = || format!("{name}\n{}\n{}", texts.specifications.join("\n"), texts.scenario);
    let (rounded, exact) = (report(texts, "unit 1 ms;")?, report(texts, "")?);
    // A chain that no data go along, as chains are random.
    if exact.has_errors() {
        return None;
    }
    let mut wrong = Vec::new();
    for (one, other) in rounded.checks.iter().zip(&exact.checks) {
        let known = [one, other].iter().all(|check| check.verdict != Verdict::Unknown);
        if known && one.verdict != other.verdict {
            wrong.push(format!(
                "{} {}: {:?}, exactly {:?}",
                one.kind, one.of, one.verdict, other.verdict
            ));
        }
        ROUNDED.fetch_add(usize::from(one.rounded), Ordering::Relaxed);
        wrong.extend(beyond_its_parts(other));
        if let (Some(Value::Time(one_time)), Some(Value::Time(time))) = (one.value, other.value) {
            let exact = other.soundness == Soundness::Exact && known;
            if exact && one.soundness == Soundness::Safe && one_time < time / 1000.0 - 1e-9 {
                wrong.push(format!("{} {}: {one_time} ms bounds {time} µs", one.kind, one.of));
            }
        }
        if let Some(step) = one.kept.as_ref().and_then(|run| run.impossible_step()) {
            wrong.push(format!("{} {}: step {step} is impossible", one.kind, one.of));
        }
    }
    Some(if wrong.is_empty() { Ok(()) } else { Err(format!("{}\n{}", wrong.join("\n"), shown())) })
}

/// Number of answers with rounded times.
static ROUNDED: AtomicUsize = AtomicUsize::new(0);

/// Number of late jobs.
static LATE: AtomicUsize = AtomicUsize::new(0);

#[test]
fn rounded_times_change_no_verdict() {
    let agree = |seed: u64| {
        let dice = &mut systems::Dice::new(seed);
        let draw = [texts, varied, requests, chained, quiet, periodic][seed as usize % 6];
        let mut texts = draw(dice);
        if seed.is_multiple_of(4) {
            texts.scenario = texts.scenario.replace("semantics servers", "semantics published");
        }
        off_the_unit(dice, &mut texts);
        compare(&format!("seed {seed}"), &texts)
    };
    all_agree(first(), dotgen_loaders::times(40), 2, agree);
    // A task that is never released, in a search that is given up.
    all_agree(168, 1, 1, agree);
    // A job that waits for a core while the start-up of its task still executes.
    all_agree(930_100, 1, 1, agree);
    let (rounded, late) = (ROUNDED.load(Ordering::Relaxed), LATE.load(Ordering::Relaxed));
    assert!(rounded > 0 && late > 0, "{rounded} rounded answers, {late} late jobs");
}
