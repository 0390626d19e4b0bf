//! Lenses: one per task of a specification, one per check of a scenario. They show the verdict first. Details
//! are in the hovers of the lens and of the task.

use std::ops::Range;

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::markdown;
use dotgen_timing::explore::Stop;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::system::indexed::DeclaredTask;
use dotgen_timing::verify::settings;
use serde_json::Value;

use super::problems::about;
use super::{TaskLocation, argument, has_refuting_run, refuting_run, tasks};
use crate::features::commands::SHOW_VERIFICATION;
use crate::protocol::types::{CodeLens, CodeLensParams, Command};
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_timing::report::TimeUnit;
use dotgen_timing::report::Verdict;
use dotgen_timing::system::ground;
use dotgen_views::verification::advice;
use dotgen_views::verification::results::{Answer, Entry, Status};
use dotgen_views::verification::view::CheckView;

/// Shown until there is an answer.
const VERIFYING: &str = "verifying …";

/// `✓ 8 of 10 ms` over every task with a result, at the place of its name. If several scenarios contain a
/// task, the worst result is shown.
pub(crate) fn lenses(
    snapshot: &Snapshot,
    subject: &Subject,
) -> Cancellable<Vec<(usize, CodeLens)>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(Vec::new());
    };
    let about = about(snapshot, &subject.path);
    let mut worst: Vec<(Range<usize>, Mark, CodeLens)> = Vec::new();
    for (path, entry) in &about {
        let Some(uri) = snapshot.uri(path) else {
            continue;
        };
        for task in tasks(&entry.problem, &subject.path) {
            let Some((mark, mut title)) = verdict(entry, task.id) else {
                continue;
            };
            let mut details = details(entry, task.id);
            if about.len() > 1 {
                let name = &entry.problem.scenario.name;
                title += &format!(" · scenario {name}");
                details.insert(0, format!("scenario `{name}`"));
            }
            let mut argument = match shown(entry, task.id) {
                Some(check) if refutes(entry, check) => refuting_run(&uri, check),
                check => argument(&uri, check),
            };
            argument["tooltip"] = details.join("\n").into();
            let lens = lens(snapshot, lines.range(&task.range), title, argument);
            match worst.iter_mut().find(|entry| entry.0 == task.range) {
                Some(known) if known.1 <= mark => {}
                Some(known) => *known = (task.range, mark, lens),
                None => worst.push((task.range, mark, lens)),
            }
        }
    }
    Ok(worst.into_iter().map(|(range, _, lens)| (range.start, lens)).collect())
}

/// The results of the task whose name is at an offset, for its hover.
pub(crate) fn hover(
    snapshot: &Snapshot,
    subject: &Subject,
    offset: usize,
) -> Cancellable<Option<String>> {
    let mut out: Vec<String> = Vec::new();
    for (_, entry) in about(snapshot, &subject.path) {
        let mut tasks = tasks(&entry.problem, &subject.path).into_iter();
        let here = |location: &TaskLocation| {
            location.range.start <= offset && offset <= location.range.end
        };
        let Some((task, (mark, title))) =
            tasks.find(here).and_then(|task| Some((task.id, verdict(entry, task.id)?)))
        else {
            continue;
        };
        let scenario = &entry.problem.scenario.name;
        out.push(format!("**{title}** in scenario {}", markdown::code(scenario)));
        if mark != Mark::Open {
            let details = details(entry, task);
            out.extend(details.iter().map(|detail| format!("* {}", markdown::text(detail))));
        }
    }
    Ok((!out.is_empty()).then(|| out.join("\n")))
}

/// The verdict over every check of a scenario, and the state of the verification over its name.
pub(crate) fn scenario_lenses(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &CodeLensParams,
) -> Cancellable<Option<Vec<CodeLens>>> {
    if !snapshot.config.code_lens.verdicts {
        return Ok(Some(Vec::new()));
    }
    let (Some(lines), Some(entry)) =
        (snapshot.lines(&subject.path)?, snapshot.verification.get(&subject.path))
    else {
        return Ok(None);
    };
    let uri = &subject.uri;
    let heading = lines.range(&entry.problem.scenario.name_range);
    let mut out = vec![lens(snapshot, heading, whole(entry), argument(uri, None))];
    // A check has a lens before it has an answer: editors close menus when the number of lens lines changes.
    let written = entry.problem.scenario.checks();
    let mut titles: Vec<(Range<usize>, Vec<String>, Option<usize>)> =
        written.map(|check| (check.range.clone(), Vec::new(), None)).collect();
    let refuting = |check: usize| refutes(entry, check);
    if let Some(answer) = entry.known() {
        for (i, check) in answer.view().checks.iter().enumerate() {
            let Some(range) = check.written.clone() else {
                continue;
            };
            let mut word = outcome(check);
            if let Some(value) = &check.value {
                word = format!("{value} · {word}");
            }
            if check.is_one_of_all {
                word = format!("{} {word}", check.report.of);
            }
            match titles.iter_mut().find(|title| title.0 == range) {
                Some(title) => {
                    title.1.push(word);
                    if title.2.is_none_or(|shown| refuting(i) && !refuting(shown)) {
                        title.2 = Some(i);
                    }
                }
                None => titles.push((range, vec![word], Some(i))),
            }
        }
    }
    for (range, words, check) in titles {
        let title = match (words.is_empty(), entry.settled().is_some(), entry.status) {
            (false, ..) => words.join(" | "),
            (true, _, Status::Blocked) => "not verified".to_owned(),
            (true, true, _) => "nothing to verify".to_owned(),
            (true, false, _) => VERIFYING.to_owned(),
        };
        let argument = match check.filter(|check| refuting(*check)) {
            Some(check) => refuting_run(uri, check),
            None => argument(uri, check),
        };
        out.push(lens(snapshot, lines.range(&range), title, argument));
    }
    Ok(Some(out))
}

fn lens(
    snapshot: &Snapshot,
    range: crate::protocol::types::Range,
    title: String,
    argument: Value,
) -> CodeLens {
    // Clients without the panel get text alone.
    let command = if snapshot.client.verification_status {
        Command::new(title, SHOW_VERIFICATION.to_owned(), Some(vec![argument]))
    } else {
        Command::new(title, String::new(), None)
    };
    CodeLens { range, command: Some(command), data: None }
}

/// Returns true if a run refutes a check of an entry.
fn refutes(entry: &Entry, check: usize) -> bool {
    (entry.known()).is_some_and(|answer| has_refuting_run(&answer.report.checks[check]))
}

/// The check to show for a task: a refuted one, else its response time.
fn shown(entry: &Entry, task: DeclaredTask) -> Option<usize> {
    let view = entry.known()?.view();
    let of_task = || view.of_task(task).filter(|task| task.1.verdict != Verdict::Open);
    let refuted = of_task().find(|task| task.1.report.verdict == Verdict::Refuted);
    let response = || of_task().find(|task| task.1.report.kind == PropertyKind::Response);
    refuted.or_else(response).or_else(|| of_task().next()).map(|task| task.0)
}

/// The state of a verification as a whole.
fn whole(entry: &Entry) -> String {
    let text = match entry.status {
        Status::Stale | Status::Running => VERIFYING.to_owned(),
        Status::Proved => "proved".to_owned(),
        Status::Answered => "answered".to_owned(),
        Status::Conditional => "conditional".to_owned(),
        Status::Refuted => "refuted".to_owned(),
        Status::Nothing => "nothing to verify".to_owned(),
        Status::GaveUp => "gave up".to_owned(),
        Status::Blocked => return "not verified: there are errors".to_owned(),
    };
    match (entry.settled(), entry.known()) {
        (Some(answer), _) => {
            let states = match answer.report.states {
                0 => String::new(),
                1 => " · 1 state".to_owned(),
                states => format!(" · {states} states"),
            };
            format!("{text}{states} · {:.2} s", answer.report.seconds)
        }
        (None, Some(answer)) => format!("{text} · {}", answer.report.how_far()),
        (None, None) => text,
    }
}

/// Shown for a task of which no job is measured: it is never released, or has no period.
const NEVER: &str = "no job to verify";

/// The first sign of a verdict, the worst first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Mark {
    Fails,
    Unsettled,
    Open,
    Holds,
}

impl Mark {
    fn sign(self) -> &'static str {
        match self {
            Mark::Fails => "✗",
            Mark::Unsettled => "?",
            Mark::Open => "…",
            Mark::Holds => "✓",
        }
    }
}

/// The verdict on a task in a few words. `None` if there was nothing to verify, or if errors prevent the
/// verification.
fn verdict(entry: &Entry, task: DeclaredTask) -> Option<(Mark, String)> {
    let say = |mark: Mark, text: &str| Some((mark, format!("{} {text}", mark.sign())));
    if entry.status == Status::Blocked {
        return None;
    }
    // A task without a lens has none until there is an answer for the new text: the lines stay where they
    // are.
    if entry.known().or(entry.answer.as_ref()).is_some_and(|answer| is_empty(answer, task)) {
        return None;
    }
    let Some(answer) = entry.known() else {
        return say(Mark::Open, "verifying");
    };
    let view = answer.view();
    let all: Vec<&CheckView> = view.of_task(task).map(|task| task.1).collect();
    let first = |outcome| all.iter().copied().find(|task| task.verdict == outcome);
    let response = all.iter().find(|task| task.report.kind == PropertyKind::Response);
    let measured = response.and_then(|response| response.share.clone());
    let and_measured = |text: &str| match &measured {
        Some(share) => format!("{text}: {share}"),
        None => text.to_owned(),
    };
    if let Some(refuted) = first(Verdict::Refuted) {
        let late = matches!(
            refuted.report.kind,
            PropertyKind::Schedulable | PropertyKind::Response | PropertyKind::NoOverdue
        );
        let unit = answer.report.unit;
        let cause = refuted.why.map(|cause| cause.wait_in_words(unit).plain());
        return match (late, cause) {
            (true, Some(cause)) => say(Mark::Fails, &format!("can be late: {cause}")),
            (true, None) => say(Mark::Fails, &and_measured("can be late")),
            (false, _) => say(Mark::Fails, &format!("{} fails", refuted.report.kind)),
        };
    }
    if first(Verdict::Exceeds).is_some() {
        return say(Mark::Fails, &and_measured("later than its period"));
    }
    if let Some(open) = first(Verdict::Unknown) {
        return say(Mark::Unsettled, &and_measured(&undecided_causes(answer, open)));
    }
    if first(Verdict::Open).is_some() {
        return say(Mark::Open, "verifying");
    }
    if first(Verdict::Vacuous).is_some() {
        return say(Mark::Unsettled, NEVER);
    }
    if first(Verdict::Bounded).is_some() {
        return say(Mark::Unsettled, &and_measured("perhaps late"));
    }
    if let Some(check) = first(Verdict::Conditional) {
        return say(Mark::Unsettled, &and_measured(&ground::short(&check.report.conditions)));
    }
    let of_deadlines = |check: &&CheckView| check.report.kind == PropertyKind::Schedulable;
    let holds = if all.iter().any(of_deadlines) { "deadlines met" } else { "checks hold" };
    say(Mark::Holds, measured.as_deref().unwrap_or(holds))
}

/// True if an answer has nothing about a task: it is in no check, or has no execution times.
fn is_empty(answer: &Answer, task: DeclaredTask) -> bool {
    let view = answer.view();
    let mut all = view.of_task(task).map(|task| task.1.verdict).peekable();
    all.peek().is_none() || all.any(|verdict| verdict == Verdict::Nothing)
}

/// `not settled in 10 s, any client`: the causes that a user can change, not the progress of the search.
fn undecided_causes(answer: &Answer, check: &CheckView) -> String {
    let mut text = "not settled".to_owned();
    if let Some(seconds) = check.report.gave_up.and_then(|gave_up| match gave_up.reason {
        Stop::Time => gave_up.seconds,
        _ => None,
    }) {
        text += &format!(" in {seconds} s");
    }
    if !answer.problem.is_written() {
        text += ", any client";
    }
    text
}

/// Every result of a task, a line each.
fn details(entry: &Entry, task: DeclaredTask) -> Vec<String> {
    let mut out: Vec<String> = of_task(entry, task).into_iter().collect();
    if let Some(answer) = entry.known() {
        let view = answer.view();
        let reasons = view.of_task(task).flat_map(|(_, check)| {
            let first = [&check.condition, &check.cause, &check.remedy].into_iter().flatten();
            first.chain(&check.reason).cloned()
        });
        for reason in reasons {
            if !out.contains(&reason) {
                out.push(reason);
            }
        }
        let given_up = view.of_task(task).filter_map(|task| task.1.report.gave_up);
        let stops: Vec<Stop> = given_up.map(|task| task.reason).collect();
        if let Some(advice) = advice::of(stops, &answer.problem, advice::LimitNames::Settings) {
            out.push(format!("To settle it, {advice}."));
        }
    }
    out
}

/// The results of a task; `None` if the verification has none.
fn of_task(entry: &Entry, task: DeclaredTask) -> Option<String> {
    let bound = entry.bounds.iter().find(|bound| bound.id == task);
    let bound = bound.filter(|_| entry.status == Status::Running);
    let bound = bound.map(|bound| format!("R ≤ {}", unit_of(entry).show(bound.bound)));
    let Some(answer) = entry.known().filter(|_| entry.status != Status::Blocked) else {
        let what = match entry.status {
            Status::Blocked => "not verified: there are errors",
            _ => VERIFYING,
        };
        return Some(match bound {
            Some(bound) => format!("{bound} · {what}"),
            None => what.to_owned(),
        });
    };
    let view = answer.view();
    let all: Vec<&CheckView> = view.of_task(task).map(|task| task.1).collect();
    let of_kind = |kind: PropertyKind| all.iter().find(|task| task.report.kind == kind);
    let response = of_kind(PropertyKind::Response);
    if all.is_empty() {
        return None;
    }
    let has = |outcome| all.iter().any(|task| task.verdict == outcome);
    let open = has(Verdict::Open);
    if has(Verdict::Nothing) {
        return Some("nothing to verify: no execution times".to_owned());
    }
    let mut parts = Vec::new();
    match of_kind(PropertyKind::Schedulable).map(|kind| kind.verdict) {
        Some(Verdict::Refuted) => parts.push("deadline missed".to_owned()),
        Some(Verdict::Proved) if open => parts.push("deadline met".to_owned()),
        _ => {}
    }
    match response.filter(|response| response.verdict != Verdict::Open) {
        Some(response) => parts.extend(measured(response)),
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
    } else if let Some(task) = all.iter().find(|task| task.verdict == Verdict::Unknown) {
        outcome(task)
    } else if has(Verdict::Exceeds) {
        "later than its period".to_owned()
    } else if has(Verdict::Bounded) {
        "perhaps later than its period".to_owned()
    } else if has(Verdict::Vacuous) {
        NEVER.to_owned()
    } else if let Some(check) = all.iter().find(|task| task.verdict == Verdict::Conditional) {
        format!("conditional: {}", ground::short(&check.report.conditions))
    } else {
        "proved".to_owned()
    };
    if let Some(cores) = answer.cores.as_ref().and_then(|core| core.cores) {
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
fn measured(check: &CheckView) -> Vec<String> {
    let value = check.value.as_ref();
    let Some(value) = value.filter(|_| check.verdict != Verdict::Unknown) else {
        return Vec::new();
    };
    match (&check.limit, &check.slack) {
        (Some(limit), Some(slack)) => {
            vec![format!("R {value} of {limit}"), format!("slack {slack}")]
        }
        _ => vec![format!("R {value}")],
    }
}

fn unit_of(entry: &Entry) -> TimeUnit {
    TimeUnit::of(&settings(&entry.problem.scenario, &Default::default()))
}

fn outcome(check: &CheckView) -> String {
    match (check.verdict, check.report.gave_up) {
        (Verdict::Unknown, Some(why)) => why.to_string(),
        (Verdict::Open, _) => VERIFYING.to_owned(),
        (outcome, _) => outcome.counted().to_owned(),
    }
}
