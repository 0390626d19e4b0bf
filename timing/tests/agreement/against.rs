//! The verifier agrees with the interpreter of the servers on random specifications and scenarios.

use std::sync::Arc;

use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{
    AnalysisHost, BatchInput, FileContent, Input, Loader, PackageFlags, UnitResult,
};
use dotgen_timing::explore::Limits;
use dotgen_timing::report::{CheckReport, Value, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};
use serde_json::{Value as Json, json};

use crate::expected::answers;
use crate::servers::CAP;
use crate::servers::model::read;
use crate::servers::random::{Texts, texts};
use crate::{all_agree, first, systems};

struct Nothing;

impl Loader for Nothing {
    fn read(&self, _: &camino::Utf8Path) -> FileContent {
        FileContent::Missing
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

fn load(host: &AnalysisHost, text: &str) -> Result<UnitResult, String> {
    let input = BatchInput {
        inputs: vec![Input::Text {
            name: "test.gen".into(),
            text: text.into(),
        }],
        ..BatchInput::default()
    };
    let unit = host.analysis().batch(&input).expect("nobody cancels");
    let mut errors = unit.diagnostics.iter();
    match errors.find(|it| it.severity == Severity::Error) {
        Some(it) => Err(it.message.clone()),
        None => Ok(unit),
    }
}

/// What is compared of an answer.
fn answer(it: &CheckReport) -> Json {
    let value = match it.value {
        Some(Value::Time(time)) if time >= f64::from(CAP) => json!("unbounded"),
        Some(Value::Time(time)) => json!(time as u32),
        Some(Value::Unbounded) => json!("unbounded"),
        None => Json::Null,
    };
    // Of response times the value counts.
    let verdict = match it.verdict {
        Verdict::Proved => "proved",
        Verdict::Refuted => "refuted",
        other => return json!(format!("{other:?}: {:?}", it.note)),
    };
    match it.kind.is_time() {
        true => value,
        false => json!(verdict),
    }
}

fn compare(seed: u64) -> Option<Result<(), String>> {
    let Texts {
        specifications,
        scenario,
    } = texts(&mut systems::Dice::new(seed));
    let shown = || format!("seed {seed}\n{}\n{scenario}", specifications.join("\n"));
    let host = AnalysisHost::new(Arc::new(Nothing));
    let units: Result<Vec<UnitResult>, String> =
        specifications.iter().map(|it| load(&host, it)).collect();
    let units = match units {
        Ok(it) => it,
        // Machines are drawn at random: not every one of them is a legal specification.
        Err(_) => return None,
    };
    let specs: Vec<_> = units.iter().map(|it| &*it.spec).collect();
    let parsed = parse(&scenario);
    if !parsed.errors.is_empty() {
        return Some(Err(format!("{:?}: {}", parsed.errors, shown())));
    }
    let system = read(&specs, &parsed.scenario);
    let expected = answers(&system, &parsed.scenario, 40_000)?;
    let options = Options {
        limits: Limits {
            states: 400_000,
            bytes: 1 << 28,
            threads: 1,
            ..Limits::default()
        },
        ..Options::default()
    };
    let input = SystemInput { specs };
    let report = verify(&input, &parsed.scenario, &options, &Cancel::default());
    if report.has_errors() {
        return Some(Err(format!("{:?}: {}", report.diagnostics, shown())));
    }
    let mut wrong = Vec::new();
    for (check, want) in expected {
        let found = report.checks.iter().find(|it| {
            let name = format!("{} {}", it.kind, it.of);
            it.name.as_ref().map_or(name == check, |it| *it == check)
        });
        let Some(found) = found else {
            wrong.push(format!("{check} is not answered"));
            continue;
        };
        // Without execution times there is nothing to say; what was given up says nothing.
        if matches!(found.verdict, Verdict::Nothing | Verdict::Unknown) {
            continue;
        }
        let want = match found.kind.is_time() {
            true => want["value"].clone(),
            false => want["verdict"].clone(),
        };
        let got = answer(found);
        if want != got {
            wrong.push(format!("{check}: expected {want}, found {got}"));
        }
    }
    Some(match wrong.is_empty() {
        true => Ok(()),
        false => Err(format!("{}\n{}", wrong.join("\n"), shown())),
    })
}

/// Number of systems, more on demand.
fn cases() -> u64 {
    let given = std::env::var("DOTGEN_TIMING_CASES").ok();
    given.and_then(|it| it.parse().ok()).unwrap_or(500)
}

#[test]
fn the_verifier_agrees_with_the_interpreter_of_the_servers() {
    all_agree(first(), cases(), 2, compare);
}
