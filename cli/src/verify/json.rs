//! `--format json`: the format that `docs/cli.md` documents.

use dotgen_timing::report::{FORMAT, Value};
use serde_json::{Value as Json, json};

use super::{Answer, outputs, session};

/// One document: an object for one scenario, a list for several.
pub(super) fn print(answers: &[Answer]) -> anyhow::Result<()> {
    let documents = answers.iter().map(document).collect::<anyhow::Result<_>>()?;
    outputs::print_json(&outputs::one_or_all(documents))
}

fn document(answer: &Answer) -> anyhow::Result<Json> {
    let mut document = serde_json::to_value(&answer.report)?;
    document["file"] = json!(answer.file());
    document["format"] = json!(FORMAT);
    let checks = document["checks"].as_array_mut().into_iter().flatten();
    let answered = answer.report.checks.iter().zip(&answer.why);
    for (json, (check, why)) in checks.zip(answered) {
        if json.get("counterexample").is_none() {
            json["counterexample"] = json!([]);
        }
        if let (Some(Value::Time(_)), Some(limit)) = (check.value, check.limit) {
            json["limit"] = serde_json::to_value(Value::Time(limit.time()))?;
        }
        if let Some(slack) = check.slack() {
            json["slack"] = json!((slack * 1000.0).round() / 1000.0);
        }
        if let Some(why) = why {
            let unit = answer.report.unit;
            let mut why_json = serde_json::to_value(why)?;
            why_json["words"] = json!({ "cause": why.cause_in_words(unit) });
            if let Some(remedy) = why.remedy_in_words(unit) {
                why_json["words"]["remedy"] = json!(remedy);
            }
            json["why"] = why_json;
        }
    }
    document["diagnostics"] = answer.diagnostics.clone();
    if !answer.first.is_empty() {
        document["first-answers"] = serde_json::to_value(&answer.first)?;
    }
    if let Some(limits) = &answer.limits {
        if let Some(sensitivity) = &limits.sensitivity {
            document["sensitivity"] = serde_json::to_value(sensitivity)?;
        }
        let mut changes = Vec::new();
        for (repair, edit) in limits.repairs.all.iter().zip(&limits.edits) {
            let mut json = serde_json::to_value(&repair.change)?;
            json["words"] = json!(repair.words);
            if let Some(edit) = edit {
                json["edit"] = json!({
                    "file": session::display(&edit.path),
                    "range": [edit.range.start, edit.range.end],
                    "text": edit.new_text,
                });
            }
            changes.push(json);
        }
        document["repairs"] = json!({ "changes": changes });
        if limits.repairs.incomplete {
            document["repairs"]["incomplete"] = json!(true);
        }
    }
    Ok(document)
}
