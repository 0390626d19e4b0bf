//! Published and computed results on the shared corpus. Skipped without the corpus.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::host::{AnalysisHost, BatchInput, Input, UnitResult};
use dotgen_loaders::Disk;
use dotgen_timing::report::{CheckReport, Report, Value, Verdict};
use dotgen_timing::scn::ast::{Durations, Item, Policy, Scenario};
use dotgen_timing::scn::parse;
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};
use serde_json::Value as Json;

/// The options of these tests: the published models.
fn published() -> Options {
    Options { semantics: Some(Preset::Published), ..Options::default() }
}

fn shared() -> Option<PathBuf> {
    dotgen_loaders::shared("")
}

fn load(path: &Path) -> (Scenario, UnitResult) {
    let text = std::fs::read_to_string(path).unwrap();
    let parsed = parse(&text);
    assert_eq!(parsed.errors, []);
    let folder = Utf8Path::from_path(path.parent().unwrap()).unwrap().to_owned();
    let inputs = parsed
        .scenario
        .items
        .iter()
        .filter_map(|item| match item {
            Item::Use(file) => Some(Input::File(folder.join(&file.value))),
            _ => None,
        })
        .collect();
    let input = BatchInput {
        inputs,
        include_dirs: vec![folder.join("idl"), folder.join("../maneuver/idl"), folder],
        defines: Vec::new(),
    };
    let host = AnalysisHost::new(Arc::new(Disk));
    let unit = host.analysis().batch(&input).unwrap();
    let errors: Vec<String> = unit
        .diagnostics
        .iter()
        .filter(|diagnostic| diagnostic.severity == dotgen_analysis::diagnostic::Severity::Error)
        .map(|diagnostic| diagnostic.message.to_string())
        .collect();
    assert_eq!(errors, Vec::<String>::new());
    (parsed.scenario, unit)
}

/// Describes a report, for failures.
fn in_words(report: &Report) -> String {
    let checks = report.checks.iter().map(|check| {
        let value = check.value.map(|value| value.to_string()).unwrap_or_default();
        let note = check.note.as_deref().unwrap_or_default();
        format!("{:?} {} {} {value} {note}", check.verdict, check.kind, check.of)
    });
    checks.collect::<Vec<_>>().join("\n")
}

fn run(path: &Path, options: &Options) -> Report {
    let (scenario, unit) = load(path);
    let input = SystemInput { specs: vec![&unit.spec] };
    verify(&input, &scenario, options, &Cancel::default())
}

#[test]
fn ground_truth() {
    let Some(shared) = shared() else { return };
    let text = std::fs::read_to_string(shared.join("ground-truth.json")).unwrap();
    let truth: Json = serde_json::from_str(&text).unwrap();
    let mut failures = Vec::new();
    for case in truth["cases"].as_array().unwrap() {
        let id = case["id"].as_str().unwrap();
        let options = Options {
            cores: case["with"]["cores"].as_u64().map(|number| Some(number as u32)),
            policy: case["with"]["policy"].as_str().map(|policy| match policy {
                "edf" => Policy::Edf,
                "any" => Policy::Any,
                _ => Policy::Fifo,
            }),
            durations: case["with"]["durations"].as_str().map(|duration| match duration {
                "fixed" => Durations::Fixed,
                "open" => Durations::Open,
                _ => Durations::Interval,
            }),
            ..published()
        };
        let report = run(&shared.join(case["scenario"].as_str().unwrap()), &options);
        println!("{id}\n{}", in_words(&report));
        let found: BTreeMap<(&str, &str), _> = report
            .checks
            .iter()
            .map(|check| ((check.kind.word(), check.of.as_str()), check))
            .collect();
        for (kind, key) in
            [("schedulable", "schedulable"), ("no-overdue", "no_overdue"), ("response", "response")]
        {
            for (task, expected) in case[key].as_object().into_iter().flatten() {
                let check = &found[&(kind, task.as_str())];
                let same = match expected {
                    Json::Bool(holds) => {
                        check.verdict == if *holds { Verdict::Proved } else { Verdict::Refuted }
                    }
                    Json::String(_) => check.value == Some(Value::Unbounded),
                    _ => check.value == expected.as_f64().map(Value::Time),
                };
                if !same {
                    failures.push(format!(
                        "{id}: {kind} {task}: expected {expected}, found {:?} {:?}",
                        check.verdict, check.value
                    ));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// On enough cores, the polling task alone can keep another one from its deadline: it takes their locks again
/// and again. All others are bounded, whatever the plan of the client makes the aperiodic tasks do.
#[test]
fn the_published_take_off_is_answered_without_exploring_it() {
    let Some(shared) = shared() else { return };
    let mut options = Options { cores: Some(None), ..published() };
    options.limits.states = 50_000;
    let report = run(&shared.join("corpus/quadcopter/flight.scn"), &options);
    for check in &report.checks {
        let expected = match check.of.as_str() {
            "mikrokopter.main" => Verdict::Refuted,
            _ => Verdict::Proved,
        };
        assert_eq!(check.verdict, expected, "{}", in_words(&report));
    }
}

/// The scenarios of the examples hold for the servers and for the published models.
#[test]
fn the_scenarios_of_the_examples_hold_under_both_semantics() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut checks = 0;
    for folder in std::fs::read_dir(examples).unwrap() {
        for file in std::fs::read_dir(folder.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "scn") {
                continue;
            }
            for preset in [Preset::Servers, Preset::Published] {
                let options = Options { semantics: Some(preset), ..published() };
                let report = run(&path, &options);
                // The published models have no `abort`.
                let foreign = report.diagnostics.iter().any(|found| found.code == "scn-semantics");
                if foreign && preset == Preset::Published {
                    continue;
                }
                let proved = |report: &CheckReport| report.verdict == Verdict::Proved;
                assert!(
                    report.checks.iter().all(proved) && !report.has_errors(),
                    "{} under {}\n{}",
                    path.display(),
                    preset.name(),
                    in_words(&report)
                );
                checks += report.checks.len();
            }
        }
    }
    assert!(checks >= 24, "only {checks} checks");
}

/// Not a test: prints the results for a scenario given by the environment.
#[test]
#[ignore = "for looking at one scenario: SCN=path CORES=n DURATIONS=fixed"]
fn look() {
    let Ok(path) = std::env::var("SCN") else {
        return;
    };
    let options = Options {
        cores: std::env::var("CORES").ok().map(|variable| variable.parse().ok()),
        durations: match std::env::var("DURATIONS").as_deref() {
            Ok("fixed") => Some(Durations::Fixed),
            Ok("interval") => Some(Durations::Interval),
            _ => None,
        },
        ..published()
    };
    let report = run(Path::new(&path), &options);
    println!("{}", in_words(&report));
}
