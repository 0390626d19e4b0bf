//! `--format json`: the shape that `docs/cli.md` promises.

use std::io::Write;

use dotgen_timing::report::Value as Time;
use dotgen_timing::scn::names::Names;
use serde_json::{Value, json};

use super::Answer;
use crate::verification::summary::{self, Scale};

/// One document: an object for one scenario, a list for several.
pub(super) fn print(answers: &[Answer]) -> anyhow::Result<()> {
    let mut documents = Vec::new();
    for answer in answers {
        documents.push(document(answer)?);
    }
    let document = match documents.len() {
        1 => documents.remove(0),
        _ => Value::Array(documents),
    };
    let mut out = serde_json::to_string_pretty(&document)?;
    out.push('\n');
    std::io::stdout().write_all(out.as_bytes())?;
    Ok(())
}

fn document(answer: &Answer) -> anyhow::Result<Value> {
    let mut document = serde_json::to_value(&answer.report)?;
    document["file"] = json!(answer.file());
    let specs = answer.problem.specs();
    let (names, scale) = (Names::new(&specs), Scale::of(&answer.settings()));
    let checks = document["checks"].as_array_mut().into_iter().flatten();
    for (json, check) in checks.zip(&answer.report.checks) {
        if json.get("counterexample").is_none() {
            json["counterexample"] = json!([]);
        }
        if let (Some(Time::Time(value)), Some(limit)) =
            (check.value, summary::limit(check, &names, scale))
        {
            json["limit"] = match limit.fract() == 0.0 {
                true => json!(limit as i64),
                false => json!(limit),
            };
            json["slack"] = json!((summary::slack(value, limit) * 1000.0).round() / 1000.0);
        }
    }
    document["diagnostics"] = answer.diagnostics.clone();
    if let Some(sensitivity) = &answer.sensitivity {
        document["sensitivity"] = serde_json::to_value(sensitivity)?;
    }
    Ok(document)
}
