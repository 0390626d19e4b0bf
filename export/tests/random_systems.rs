//! Exported models of random systems, read back.

use crate::read_back::{Counts, compare_system};
use crate::systems::{Dice, System};

#[allow(dead_code, reason = "shared with the tests of verification")]
#[path = "../../timing/tests/agreement/servers/random.rs"]
pub(crate) mod random;

use self::random::Texts;

/// Limit on symbolic states of a query.
const STATES: usize = 2_000;

/// Compares random systems with the verifier. `times` many of them have no error and are exported.
fn compare_all(times: u64, first: u64, draw: fn(&mut Dice) -> Texts) -> Counts {
    let mut counts = Counts { leaves: true, ..Counts::default() };
    let only: Option<u64> = std::env::var("DOTGEN_SEED").ok().and_then(|seed| seed.parse().ok());
    let (mut seed, mut done) = (first, 0);
    while done < dotgen_loaders::times(times) {
        seed += 1;
        if only.is_some_and(|only| only < seed) {
            break;
        }
        if only.is_some_and(|only| only != seed) {
            continue;
        }
        let texts = draw(&mut Dice::new(seed));
        let Some(system) = System::of_texts(&texts.specifications, &texts.scenario) else {
            continue;
        };
        if only.is_some() {
            eprintln!("{}\n{}", texts.specifications.join("\n"), texts.scenario);
        }
        let before = counts.equal;
        compare_system(&system, &format!("DOTGEN_SEED={seed}"), STATES, &mut counts);
        done += u64::from(counts.equal > before);
    }
    eprintln!("{counts:?} up to seed {seed}");
    counts
}

#[test]
fn systems() {
    let counts = compare_all(10, 0, random::texts);
    assert!(counts.equal > 20 || std::env::var_os("DOTGEN_SEED").is_some(), "{counts:?}");
}

#[test]
fn patterns() {
    let counts = compare_all(8, 1000, random::patterned);
    assert!(counts.equal > 20 || std::env::var_os("DOTGEN_SEED").is_some(), "{counts:?}");
}

/// Returns such a system under the semantics of the published models, with or without patterns.
pub(crate) fn published(dice: &mut Dice) -> Texts {
    let mut out = if dice.in_ten(3) { random::patterned(dice) } else { random::texts(dice) };
    let lines = out.scenario.lines().map(|line| match line.trim_start().split(' ').next() {
        Some("semantics") => "  semantics published;",
        // Points of the servers, and their policies.
        Some("ticks" | "turns" | "locks" | "ports" | "pause") => "",
        _ => line,
    });
    out.scenario = lines.collect::<Vec<_>>().join("\n");
    out
}

#[test]
fn published_systems() {
    let counts = compare_all(20, 2000, published);
    assert!(counts.equal > 40 || std::env::var_os("DOTGEN_SEED").is_some(), "{counts:?}");
}

/// Returns such a system with clients that depend on the outcomes of their requests.
fn outcomes(dice: &mut Dice) -> Texts {
    let mut out = random::requests(dice);
    let is_kept = |line: &&str| {
        let first = line.trim_start().split(' ').next().unwrap_or_default();
        !matches!(first, "abort" | "kill" | "connect" | "ticks" | "turns" | "locks" | "pause")
    };
    out.scenario = out.scenario.lines().filter(is_kept).collect::<Vec<_>>().join("\n");
    out
}

#[test]
fn systems_with_outcomes() {
    let counts = compare_all(10, 3000, outcomes);
    assert!(counts.equal > 20 || std::env::var_os("DOTGEN_SEED").is_some(), "{counts:?}");
}
