//! Exported models, read back: the reader of `.xta` gives the verdicts and the greatest times of the
//! verifier.

use std::path::{Path, PathBuf};

use dotgen_export::{Format, export};
use dotgen_timing::explore::Limits as WatchLimits;
use dotgen_timing::report::{CheckReport, Soundness, Value, Verdict};
use dotgen_timing::verify::{Options, PreparedCheck};
use dotgen_xta::{Answer, Limits};

use crate::systems::System;

/// Every so many of the servers' cases are tried.
const EVERY: usize = 12;

/// Limit on symbolic states of a case; a query that needs more is left out.
const STATES: usize = 5_000;

/// Answers of one system, or of several.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Counts {
    pub(crate) equal: usize,
    /// Checks that are not exported.
    pub(crate) refused: usize,
    /// Queries that need more states.
    pub(crate) large: usize,
    /// A system with such a query is left.
    pub(crate) leaves: bool,
}

/// Limit on states of the verifier. What it has not found by then has no verdict.
const VERIFIER_STATES: usize = 300_000;

/// Compares the answers to all checks of a scenario. Returns the number of equal answers.
fn compare(path: &Path, states: usize) -> usize {
    let mut counts = Counts::default();
    compare_system(&System::read(path), &path.display().to_string(), states, &mut counts);
    counts.equal
}

/// Compares the answers to all checks of a system.
pub(crate) fn compare_system(system: &System, path: &str, states: usize, counts: &mut Counts) {
    let limits = WatchLimits { states: VERIFIER_STATES, ..WatchLimits::default() };
    let options = Options { limits, ..Options::default() };
    let (prepared, report) = (system.prepared(&options), system.report(&options));
    for check in &prepared.checks {
        let answer = report.checks.iter().find(|answer| answer.id == check.report.id);
        let Some(answer) = answer else { continue };
        let mut alone = prepared.clone();
        alone.checks = vec![check.clone()];
        let Ok(files) = export(&alone, &|_, _| None, Format::Uppaal) else {
            counts.refused += 1;
            continue;
        };
        let network = dotgen_xta::read(&files[0].text).expect("the model is UPPAAL's");
        let queries = dotgen_xta::queries(&files[1].text).expect("the queries are UPPAAL's");
        let mut greatest = None;
        for query in queries {
            let limits = Limits { states, ..Limits::default() };
            match network.answer(&query, &limits) {
                Answer::Holds { .. } => counts.equal += same(path, check, answer, true),
                Answer::Fails { .. } => counts.equal += same(path, check, answer, false),
                Answer::Values { values, .. } => {
                    let values = values.iter().filter_map(|extreme| match extreme.value {
                        Some(dotgen_xta::Value::Finite { value, .. }) => Some(value),
                        Some(dotgen_xta::Value::Infinite) => Some(i64::MAX),
                        None => None,
                    });
                    greatest = values.chain(greatest).max();
                }
                Answer::GaveUp { .. } => {
                    counts.large += 1;
                    if counts.leaves {
                        return;
                    }
                }
                other => panic!("{path}: {}: {other:?}", check.report.of),
            }
        }
        if let (Some(greatest), Some(Value::Time(value))) = (greatest, answer.value)
            && !matches!(answer.soundness, Soundness::UpperBound | Soundness::LowerBound)
        {
            let expected = (value / prepared.time(1)).round() as i64;
            assert_eq!(greatest, expected, "{path}: {}", check.report.of);
            counts.equal += 1;
        }
    }
}

fn same(path: &str, check: &PreparedCheck, answer: &CheckReport, holds: bool) -> usize {
    if matches!(answer.verdict, Verdict::Unknown | Verdict::Nothing) {
        return 0;
    }
    let subject = format!("{path}: {} {}", check.report.kind, check.report.of);
    assert_eq!(holds, answer.verdict.holds(), "{subject}");
    1
}

#[test]
fn pump() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/pump/pump.scn");
    assert_eq!(compare(&example, 200_000), 6);
}

#[test]
fn servers() {
    let Some(folder) = dotgen_loaders::shared("servers") else { return };
    let mut scenarios: Vec<PathBuf> = (std::fs::read_dir(folder).expect("the folder exists"))
        .map(|entry| entry.expect("the folder is readable").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "scn"))
        .collect();
    scenarios.sort();
    let every = if dotgen_loaders::times(1) > 1 { 1 } else { EVERY };
    let equal: usize = scenarios.iter().step_by(every).map(|path| compare(path, STATES)).sum();
    eprintln!("{equal} answers are equal");
    assert!(equal > scenarios.len() / every);
}
