//! Lenses: one per task of a specification, one per check of a scenario. They say what was computed,
//! and nothing else.

use dotgen_analysis::host::Cancellable;
use dotgen_timing::report::{CheckReport, Soundness, Value, Verdict};
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::settings;

use super::{SHOW, argument, check_of, tasks};
use crate::proto::{CodeLens, Command, Uri};
use crate::snapshot::{Snapshot, Subject};
use crate::verification::summary::{self, Scale};
use crate::verifier::{Answer, Entry, Status, about};

/// Of what has no answer yet.
const VERIFYING: &str = "verifying …";

/// `R 7 ms of 10 ms · slack 30 % · proved, ≥ 2 cores` over every task.
pub(crate) fn lenses(snapshot: &Snapshot, subject: &Subject) -> Cancellable<Vec<CodeLens>> {
    let mut out = Vec::new();
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(out);
    };
    let about = about(snapshot, &subject.path);
    for (path, entry) in &about {
        let Some(uri) = snapshot.uri(path) else {
            continue;
        };
        for task in tasks(&entry.problem, &subject.path) {
            let Some(mut title) = of_task(entry, &task.name) else {
                continue;
            };
            if about.len() > 1 {
                title = format!("{}: {title}", entry.problem.scenario.name);
            }
            let check = shown(entry, &task.name);
            out.push(lens(snapshot, lines.range(&task.range), title, &uri, check));
        }
    }
    Ok(out)
}

/// The verdict over every check of a scenario, and where the whole stands over its name.
pub(crate) fn scenario_lenses(
    snapshot: &Snapshot,
    subject: &Subject,
) -> Cancellable<Option<Vec<CodeLens>>> {
    let (Some(lines), Some(entry)) = (
        snapshot.lines(&subject.path)?,
        snapshot.verification.get(&subject.path),
    ) else {
        return Ok(None);
    };
    let uri = &subject.uri;
    let heading = lines.range(&entry.problem.scenario.name_range);
    let mut out = vec![lens(snapshot, heading, whole(entry), uri, None)];
    if let Some(answer) = entry.known() {
        let scale = answer.scale();
        let mut titles: Vec<(std::ops::Range<usize>, Vec<String>, usize)> = Vec::new();
        for (i, report) in answer.report.checks.iter().enumerate() {
            let Some(check) = check_of(&entry.problem.scenario, report) else {
                continue;
            };
            let mut word = verdict(report);
            if let Some(value) = report.value {
                let least = match report.verdict {
                    Verdict::Unknown => "at least ",
                    _ => "",
                };
                word = format!("{least}{} · {word}", scale.show_value(value));
            }
            match titles.iter_mut().find(|it| it.0 == check.range) {
                Some(it) => it.1.push(format!("{} {word}", report.of)),
                None if check_is_of_all(check) => {
                    titles.push((
                        check.range.clone(),
                        vec![format!("{} {word}", report.of)],
                        i,
                    ));
                }
                None => titles.push((check.range.clone(), vec![word], i)),
            }
        }
        for (range, words, check) in titles {
            let title = words.join(" | ");
            out.push(lens(snapshot, lines.range(&range), title, uri, Some(check)));
        }
    }
    Ok(Some(out))
}

fn check_is_of_all(check: &dotgen_timing::scn::ast::Check) -> bool {
    use dotgen_timing::scn::ast::CheckKind::{NoOverdue, Response, Schedulable};
    matches!(
        check.kind,
        Schedulable(None) | NoOverdue(None) | Response(None, _)
    )
}

fn lens(
    snapshot: &Snapshot,
    range: crate::proto::Range,
    title: String,
    uri: &Uri,
    check: Option<usize>,
) -> CodeLens {
    // Text alone for clients without the panel.
    let command = match snapshot.client.verification_status {
        true => Command::new(title, SHOW.to_owned(), Some(vec![argument(uri, check)])),
        false => Command::new(title, String::new(), None),
    };
    CodeLens {
        range,
        command: Some(command),
        data: None,
    }
}

/// The check that shows most about a task: a refuted one, else its response.
fn shown(entry: &Entry, task: &str) -> Option<usize> {
    let checks = &entry.known()?.report.checks;
    let of_task = || {
        let all = checks.iter().enumerate();
        all.filter(|it| it.1.of == task && it.1.verdict != Verdict::Open)
    };
    let refuted = of_task().find(|it| it.1.verdict == Verdict::Refuted);
    let response = || of_task().find(|it| it.1.check == "response");
    refuted
        .or_else(response)
        .or_else(|| of_task().next())
        .map(|it| it.0)
}

/// Where a verification as a whole stands.
fn whole(entry: &Entry) -> String {
    let text = match entry.status {
        Status::Stale | Status::Running => VERIFYING.to_owned(),
        Status::Proved => "proved".to_owned(),
        Status::Refuted => "refuted".to_owned(),
        Status::GaveUp => "gave up".to_owned(),
        Status::Blocked => return "not verified: there are errors".to_owned(),
    };
    match (entry.settled(), entry.known()) {
        (Some(it), _) => format!(
            "{text} · {} states, {:.2} s",
            it.report.states, it.report.seconds
        ),
        (None, Some(it)) => format!("{text} · {}", it.report.how_far()),
        (None, None) => text,
    }
}

/// What is known of a task; `None` if the verification says nothing about it.
fn of_task(entry: &Entry, task: &str) -> Option<String> {
    let bound = entry.bounds.iter().find(|it| it.task == task);
    let bound = bound.filter(|_| entry.status == Status::Running);
    let bound = bound.map(|it| format!("R ≤ {}", scale_of(entry).show(it.bound)));
    let Some(answer) = entry.known().filter(|_| entry.status != Status::Blocked) else {
        let what = match entry.status {
            Status::Blocked => "not verified: there are errors",
            _ => VERIFYING,
        };
        return Some(match bound {
            Some(it) => format!("{it} · {what}"),
            None => what.to_owned(),
        });
    };
    let of_task = |kind: &str| {
        let mut checks = answer.report.checks.iter();
        checks.find(|it| it.check == kind && it.of == task)
    };
    let (deadline, response) = (of_task("schedulable"), of_task("response"));
    let all: Vec<&CheckReport> = (answer.report.checks.iter())
        .filter(|it| it.of == task)
        .collect();
    if all.is_empty() {
        return None;
    }
    let has = |verdict| all.iter().any(|it| it.verdict == verdict);
    let open = has(Verdict::Open);
    let mut parts = Vec::new();
    match deadline.map(|it| it.verdict) {
        Some(Verdict::Refuted) => parts.push("deadline missed".to_owned()),
        Some(Verdict::Proved) if open => parts.push("deadline met".to_owned()),
        _ => {}
    }
    match response.filter(|it| it.verdict != Verdict::Open) {
        Some(it) => parts.extend(measured(answer, it)),
        None => parts.extend(bound.filter(|_| open)),
    }
    if open {
        if has(Verdict::Refuted) {
            parts.push("refuted".to_owned());
        }
        parts.push(VERIFYING.to_owned());
        return Some(parts.join(" · "));
    }
    let mut word = if has(Verdict::Refuted) {
        "refuted".to_owned()
    } else if has(Verdict::Unknown) {
        let mut unknown = all.iter().filter(|it| it.verdict == Verdict::Unknown);
        let why = unknown.find_map(|it| it.gave_up);
        why.map_or("gave up".to_owned(), |it| it.to_string())
    } else {
        "proved".to_owned()
    };
    if let Some(cores) = answer.cores.as_ref().and_then(|it| it.cores) {
        word += &format!(", ≥ {cores} {}", if cores == 1 { "core" } else { "cores" });
    } else if let Some(cores) = settings(&answer.problem.scenario, &answer.options).cores {
        word += &format!(" on {cores} {}", if cores == 1 { "core" } else { "cores" });
    }
    parts.push(word);
    if !answer.problem.is_written() {
        parts.push("any client".to_owned());
    }
    Some(parts.join(" · "))
}

/// `R 7 ms of 10 ms`, `slack 30 %`
fn measured(answer: &Answer, check: &CheckReport) -> Vec<String> {
    let Some(value) = check.value.filter(|_| check.verdict != Verdict::Unknown) else {
        return Vec::new();
    };
    let scale = answer.scale();
    let specs = answer.problem.specs();
    let limit = summary::limit(check, &Names::new(&specs), scale);
    let (at_most, at_least) = match check.soundness {
        Soundness::UpperBound => ("≤ ", "≥ "),
        _ => ("", ""),
    };
    match (value, limit) {
        (Value::Time(time), Some(limit)) => vec![
            format!("R {at_most}{} of {}", scale.show(time), scale.show(limit)),
            format!(
                "slack {at_least}{}",
                summary::percent(summary::slack(time, limit))
            ),
        ],
        _ => vec![format!("R {at_most}{}", scale.show_value(value))],
    }
}

fn scale_of(entry: &Entry) -> Scale {
    Scale::of(&settings(&entry.problem.scenario, &Default::default()))
}

fn verdict(report: &CheckReport) -> String {
    match (report.verdict, report.gave_up) {
        (Verdict::Proved, _) => "proved".to_owned(),
        (Verdict::Refuted, _) => "refuted".to_owned(),
        (Verdict::Unknown, Some(why)) => why.to_string(),
        (Verdict::Unknown, None) => "gave up".to_owned(),
        (Verdict::Open, _) => VERIFYING.to_owned(),
    }
}

impl Answer {
    /// Of its times.
    pub(super) fn scale(&self) -> Scale {
        Scale::of(&settings(&self.problem.scenario, &self.options))
    }
}
