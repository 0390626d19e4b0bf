//! The interpreter of the servers gives the answers that an explorer independent of this project computed for
//! small systems, each about one point of the semantics. Skipped without these answers.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::host::{AnalysisHost, BatchInput, Input, UnitResult};
use dotgen_loaders::Disk;
use dotgen_timing::scn::ast::{Check, CheckKind, Item, Scenario};
use dotgen_timing::scn::parse;
use serde_json::{Value as Json, json};

use crate::agreement::servers::model::{System, read};
use crate::agreement::servers::patterns::Pattern;
use crate::agreement::servers::{CAP, Interpreter, Predicate, Results, Sequence, predicate};

fn cases() -> Option<PathBuf> {
    dotgen_loaders::shared("servers")
}

fn load(folder: &Path, case: &str) -> (Scenario, Vec<UnitResult>) {
    let text = std::fs::read_to_string(folder.join(format!("{case}.scn"))).expect("a scenario");
    // The interpreter knows no other semantics.
    let text = text.replace("semantics servers;", "");
    let parsed = parse(&text);
    assert_eq!(parsed.errors, [], "{case}");
    let folder = Utf8Path::from_path(folder).expect("UTF-8");
    let files = parsed.scenario.items.iter().filter_map(|item| match item {
        Item::Use(file) => Some(folder.join(&file.value)),
        _ => None,
    });
    let host = AnalysisHost::new(Arc::new(Disk));
    let units = files.map(|file| {
        let input = BatchInput {
            inputs: vec![Input::File(file)],
            include_dirs: vec![folder.to_owned()],
            defines: Vec::new(),
        };
        host.analysis().batch(&input).expect("nobody cancels")
    });
    let units = units.collect();
    (parsed.scenario, units)
}

/// Returns the answers of the interpreter to the checks of a scenario: verdicts and values as in
/// `expected.json`.
pub(crate) fn answers(
    system: &System,
    scenario: &Scenario,
    limit: usize,
) -> Option<Vec<(String, Json)>> {
    let checks: Vec<&Check> = scenario.checks().collect();
    let (mut within, mut reach): (Vec<Sequence>, Vec<Predicate>) = Default::default();
    let mut patterns = Vec::new();
    for check in &checks {
        match &check.kind {
            CheckKind::Within(p, list, _) => {
                let list = list.iter().map(|operand| predicate(system, operand));
                within.push((predicate(system, p), list.collect()));
            }
            CheckKind::Reachable(p) | CheckKind::Always(p) => reach.push(predicate(system, p)),
            CheckKind::Pattern(pattern) => patterns.push(Pattern::new(system, pattern)),
            _ => {}
        }
    }
    let interpreter = Interpreter::new(system, &within, &reach).with_patterns(&patterns);
    let found = interpreter.explore(limit)?;
    let (mut withins, mut reached) = (found.within.iter(), found.reached.iter());
    let mut violated = found.violated.iter();
    let mut out = Vec::new();
    for check in checks {
        let name = check.name.as_ref().map(|name| name.value.clone());
        let verdict = |holds: bool| json!({ "verdict": if holds { "proved" } else { "refuted" } });
        match &check.kind {
            CheckKind::Within(..) => {
                let longest = withins.next().copied().flatten();
                let mut answer = verdict(longest != Some(CAP));
                answer["value"] = value(longest);
                out.push((name.unwrap_or_default(), answer));
            }
            CheckKind::Reachable(_) => {
                let holds = reached.next().copied().unwrap_or(false);
                out.push((name.unwrap_or_default(), verdict(holds)));
            }
            CheckKind::Pattern(_) => {
                let holds = !violated.next().copied().unwrap_or(false);
                out.push((name.unwrap_or_default(), verdict(holds)));
            }
            CheckKind::Schedulable(None) => {
                of_tasks(system, &mut out, "schedulable", |c, t| verdict(!found.missed[c][t]));
            }
            CheckKind::NoOverdue(None) => {
                of_tasks(system, &mut out, "no-overdue", |c, t| verdict(!found.overdue[c][t]));
            }
            CheckKind::Response(None, None) => {
                of_tasks(system, &mut out, "response", |c, t| response(&found, c, t));
            }
            CheckKind::Deadlock => out.push(("deadlock ".to_owned(), verdict(!found.deadlock))),
            other => panic!("{other:?} is not asked"),
        }
    }
    Some(out)
}

fn response(found: &Results, c: usize, t: usize) -> Json {
    let longest = found.response[c][t];
    let verdict = match longest {
        Some(CAP) => "refuted",
        _ => "proved",
    };
    json!({ "verdict": verdict, "value": value(longest) })
}

fn value(longest: Option<u32>) -> Json {
    match longest {
        Some(CAP) => json!("unbounded"),
        Some(number) => json!(number),
        None => Json::Null,
    }
}

fn of_tasks(
    system: &System,
    out: &mut Vec<(String, Json)>,
    kind: &str,
    answer: impl Fn(usize, usize) -> Json,
) {
    for (c, component) in system.components.iter().enumerate() {
        for (t, task) in component.tasks.iter().enumerate() {
            if task.period.is_some() {
                let name = format!("{kind} {}.{}", component.name, task.name);
                out.push((name, answer(c, t)));
            }
        }
    }
}

#[test]
fn the_interpreter_of_the_servers_answers_as_expected() {
    let Some(folder) = cases() else { return };
    let text = std::fs::read_to_string(folder.join("expected.json")).expect("the answers");
    let expected: serde_json::Map<String, Json> = serde_json::from_str(&text).expect("JSON");
    let only = std::env::var("DOTGEN_TIMING_CASE").unwrap_or_default();
    let mut compared = 0;
    let mut wrong = Vec::new();
    for (case, json) in expected.iter().filter(|(case, _)| case.contains(&only)) {
        let (scenario, units) = load(&folder, case);
        let specs: Vec<_> = units.iter().map(|unit| &*unit.spec).collect();
        let system = read(&specs, &scenario);
        let Some(found) = answers(&system, &scenario, 3_000_000) else {
            wrong.push(format!("{case}: too large"));
            continue;
        };
        for (check, want) in json["checks"].as_object().expect("checks") {
            let Some((_, got)) = found.iter().find(|entry| entry.0 == *check) else {
                wrong.push(format!("{case}: {check} is not answered"));
                continue;
            };
            compared += 1;
            let value = match &want["value"] {
                Json::Null => &Json::Null,
                _ => &got["value"],
            };
            if want["verdict"] != got["verdict"] || want["value"] != *value {
                wrong.push(format!("{case}: {check}: {got} instead of {want}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(compared > 0 || expected.is_empty(), "nothing was compared");
    eprintln!("{compared} answers are as expected");
}
