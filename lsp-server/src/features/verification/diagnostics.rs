//! Diagnostics of verifications: at the task in the specification, at the check in the scenario.

use std::ops::Range;
use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::codes;
use dotgen_analysis::diagnostic::{Diagnostic, Related, Severity};
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::language;
use dotgen_timing::advice::Change;
use dotgen_timing::diagnostic::remark::together;
use dotgen_timing::explore::MomentKind;
use dotgen_timing::property::PropertyKind;
use dotgen_timing::report::{CheckReport, Value};

use super::problems::about;
use super::{has_refuting_run, place, tasks};
use crate::config::Level;
use crate::protocol::convert::position::touches;
use crate::protocol::types::Uri;
use crate::workspace::snapshot::Snapshot;
use dotgen_timing::report::Verdict;
use dotgen_views::verification::Problem;
use dotgen_views::verification::advice::{self, LimitNames};
use dotgen_views::verification::problem;
use dotgen_views::verification::results::{Answer, Entry};
use dotgen_views::verification::view::CheckView;

const MISS: &str = "timing/deadline-miss";
const EXCEEDED: &str = "timing/response-exceeded";
const FAILED: &str = "timing/check-failed";
const VACUOUS: &str = "timing/vacuous-proof";
pub(super) const GAVE_UP: &str = "timing/gave-up";

/// Maximum number of places of a run in a diagnostic. The last places are the most useful.
const RELATED: usize = 8;

/// A diagnostic and its check.
pub(super) struct AboutCheck {
    /// Changes that fix it, as far as they are known.
    pub(super) changes: Vec<Change>,
    /// The verified problem.
    pub(super) problem: Arc<Problem>,
    pub(super) diagnostic: Diagnostic,
    pub(super) check: usize,
    /// A run refutes the check. A state that is never reached has none.
    pub(super) refuting_run: bool,
}

/// The diagnostics at a place, each with its document.
pub(super) fn at(
    snapshot: &Snapshot,
    path: &Utf8Path,
    range: &Range<usize>,
) -> Cancellable<Vec<(Uri, AboutCheck)>> {
    let mut out = Vec::new();
    for (of, entry) in about(snapshot, path) {
        let found = if language::is_scenario(path) {
            scenario(snapshot, entry, path)
        } else {
            specification(snapshot, entry, path)
        };
        if let Some(uri) = snapshot.uri(of) {
            let here = found.into_iter().filter(|check| touches(&check.diagnostic.range, range));
            out.extend(here.map(|check| (uri.clone(), check)));
        }
    }
    Ok(out)
}

/// Missed deadlines and exceeded bounds, at the tasks of a specification.
pub(crate) fn in_specification(
    snapshot: &Snapshot,
    path: &Utf8Path,
) -> Cancellable<Vec<Diagnostic>> {
    let mut out = Vec::new();
    for (_, entry) in about(snapshot, path) {
        let found = specification(snapshot, entry, path);
        out.extend(found.into_iter().map(|specification| specification.diagnostic));
        out.extend(of_model(entry, path));
    }
    Ok(out)
}

/// The errors that prevent the verification of a specification without a scenario. Analysis reports its
/// warnings, and the scenario reports its own errors.
fn of_model(entry: &Entry, path: &Utf8Path) -> Vec<Diagnostic> {
    let answer = entry.known().filter(|_| !entry.problem.is_written());
    let found = answer.iter().flat_map(|answer| &answer.report.diagnostics);
    let found = found.filter(|diagnostic| diagnostic.remark.is_none());
    let found = found.map(|diagnostic| entry.problem.diagnostic(diagnostic));
    found.filter(|diagnostic| diagnostic.path == path).collect()
}

fn specification(snapshot: &Snapshot, entry: &Entry, path: &Utf8Path) -> Vec<AboutCheck> {
    // Results of an earlier version say nothing about this one.
    let Some(answer) = entry.known() else {
        return Vec::new();
    };
    let mut out = Vec::new();
    let view = answer.view();
    for task in tasks(&entry.problem, path) {
        // A task that is late gets one diagnostic, with all that is known about the lateness.
        let late = view.of_task(task.id).filter(|(_, view)| {
            let of_time = match view.report.kind {
                PropertyKind::Schedulable => true,
                PropertyKind::Response => view.report.bound.is_some(),
                _ => false,
            };
            of_time && view.verdict == Verdict::Refuted
        });
        let facts = late.filter_map(|(check, view)| Some((check, view, fact(answer, view)?)));
        let mut facts = facts.filter(|(.., (code, _))| severity(snapshot, code).is_some());
        if let Some((check, first, _)) = facts.next() {
            let others = facts.map(|(.., (_, fact))| fact).collect();
            let found = diagnostic(snapshot, entry, answer, first, path, &task.range, others);
            out.extend(found.map(|found| about_check(entry, answer, (check, first), found)));
        }
        for (check, view) in view.of_task(task.id) {
            // Several checks that gave up get one diagnostic: the same change helps all of them.
            let given_up = view.verdict == Verdict::Unknown
                && view.report.kind == PropertyKind::Schedulable
                && !entry.problem.is_written()
                && !out.iter().any(|check: &AboutCheck| check.diagnostic.code == GAVE_UP);
            let vacuous =
                view.verdict == Verdict::Vacuous && view.report.kind == PropertyKind::Schedulable;
            if given_up || vacuous {
                let found =
                    diagnostic(snapshot, entry, answer, view, path, &task.range, Vec::new());
                out.extend(found.map(|found| about_check(entry, answer, (check, view), found)));
            }
        }
    }
    out
}

fn about_check(
    entry: &Entry,
    answer: &Answer,
    (check, view): (usize, &CheckView),
    diagnostic: Diagnostic,
) -> AboutCheck {
    AboutCheck {
        changes: changes(answer, view),
        problem: entry.places().clone(),
        diagnostic,
        check,
        refuting_run: has_refuting_run(view.report),
    }
}

/// The results of a scenario, at its checks and names.
pub(crate) fn in_scenario(snapshot: &Snapshot, path: &Utf8Path) -> Vec<Diagnostic> {
    let Some(entry) = snapshot.verification.get(path) else {
        return Vec::new();
    };
    let mut out: Vec<Diagnostic> = Vec::new();
    if let Some(answer) = entry.known() {
        let of_model = together(&answer.report.diagnostics);
        let of_model = of_model.iter().map(|model| at_use(&entry.problem, model));
        out.extend(of_model.filter_map(|model| Level::apply(&snapshot.config.severity, model)));
    }
    let checks = scenario(snapshot, entry, path).into_iter();
    out.extend(checks.map(|check| check.diagnostic));
    out
}

/// A diagnostic about a specification, at the `use` of that specification, with a link to it.
fn at_use(problem: &Problem, entry: &dotgen_timing::diagnostic::Diagnostic) -> Diagnostic {
    let mut out = problem.diagnostic(entry);
    if let Some(place) = entry.places.first().filter(|_| out.path != problem.path) {
        let uses = problem::used(&problem.scenario, &problem.path);
        let range = uses.get(place.spec).map(|usage| usage.range.clone());
        let related = Related {
            path: std::mem::replace(&mut out.path, problem.path.clone()),
            range: std::mem::replace(&mut out.range, range.unwrap_or_default()),
            message: place.what.as_str().into(),
        };
        out.related.insert(0, related);
    }
    out
}

fn scenario(snapshot: &Snapshot, entry: &Entry, path: &Utf8Path) -> Vec<AboutCheck> {
    let Some(answer) = entry.known() else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for (check, view) in answer.view().checks.iter().enumerate() {
        let Some(written) = &view.written else {
            continue;
        };
        let found = diagnostic(snapshot, entry, answer, view, path, written, Vec::new());
        out.extend(found.map(|found| about_check(entry, answer, (check, view), found)));
    }
    out
}

/// The changes that fix a check: first those found for it, then those that repair the whole system.
pub(super) fn changes(answer: &Answer, view: &CheckView) -> Vec<Change> {
    let mut out: Vec<Change> =
        view.why.and_then(|cause| cause.remedy.clone()).into_iter().collect();
    if view.why.is_some() && view.report.task.is_some() {
        for repair in &answer.repairs.all {
            if !out.contains(&repair.change) {
                out.push(repair.change.clone());
            }
        }
    }
    out
}

/// Returns the code and the fact of a check that fails or was given up; `None` if there is nothing to report.
fn fact(answer: &Answer, view: &CheckView) -> Option<(&'static str, String)> {
    let unit = answer.unit();
    let check = view.report;
    let of = &check.of;
    Some(match (view.verdict, check.kind) {
        (Verdict::Proved | Verdict::Bounded | Verdict::Exceeds | Verdict::Open, _) => return None,
        // Missing items are reported at their own place.
        (Verdict::Nothing | Verdict::Conditional, _) => return None,
        (Verdict::Vacuous, kind) => {
            let why = check.note.as_deref().unwrap_or_default();
            (VACUOUS, format!("`{kind} {of}` says nothing: {why}"))
        }
        (Verdict::Unknown, kind) => (GAVE_UP, {
            let reason = check.gave_up.map(|gave_up| gave_up.reason);
            let advice = advice::of(reason, &answer.problem, LimitNames::Settings);
            let advice = advice.map_or(String::new(), |advice| format!("; {advice}"));
            let why = match (&check.gave_up, &check.note) {
                (Some(gave_up), _) => format!(" {}", advice::within(gave_up)),
                (None, Some(note)) => format!(": {note}"),
                (None, None) => String::new(),
            };
            let any = !answer.problem.is_written() && advice::has_clients(&answer.problem.scenario);
            let client = if any { ": any client may send anything at any time" } else { "" };
            format!("`{kind} {of}` is not settled{why}{client}{advice}")
        }),
        (_, PropertyKind::Schedulable) => {
            let last = check.run().last();
            let at = last.map_or(String::new(), |run| format!("at {} ", unit.show(run.time)));
            let what = format!("{at}its next period begins before the job has ended");
            (MISS, format!("`{of}` can miss its deadline: {what}"))
        }
        (_, kind) if kind.is_time() => {
            let what = match kind {
                PropertyKind::Response => format!("the response time of `{of}`"),
                _ => format!("the time of `{of}`"),
            };
            let message = match (check.value, check.bound) {
                (Some(Value::Unbounded), _) => format!("{what} has no bound"),
                // A run exceeds the limit, and the longest time was not looked for.
                (None, Some(bound)) => {
                    format!("{what} can be more than {}", unit.show_value(bound))
                }
                (Some(value), Some(bound)) => format!(
                    "{what} can be {}, more than {}",
                    unit.show_value(value),
                    unit.show_value(bound)
                ),
                (_, None) => return None,
            };
            (EXCEEDED, message)
        }
        (_, kind) => (FAILED, format!("`{kind} {of}` does not hold")),
    })
}

/// The diagnostic of a check at a place. `others` are further facts about the same lateness.
fn diagnostic(
    snapshot: &Snapshot,
    entry: &Entry,
    answer: &Answer,
    view: &CheckView,
    path: &Utf8Path,
    range: &Range<usize>,
    others: Vec<String>,
) -> Option<Diagnostic> {
    let (unit, check) = (answer.unit(), view.report);
    let (code, mut message) = fact(answer, view)?;
    for other in others {
        message += &format!("; {other}");
    }
    if let Some(why) = view.why {
        message += &format!("; {}", why.in_words(unit));
    } else if let Some(why) = view.reason.last() {
        message += &format!("; {why}");
    }
    if !language::is_scenario(path) && view.verdict != Verdict::Unknown {
        message += &if entry.problem.is_written() {
            format!(" (scenario `{}`)", answer.report.scenario)
        } else {
            " (no scenario: any client, at any time)".to_owned()
        };
    }
    let severity = severity(snapshot, code)?;
    Some(Diagnostic {
        related: related(entry, answer, check),
        ..Diagnostic::new(code, severity, message, path.to_owned(), range.clone())
    })
}

/// The configured severity; `None` for off.
fn severity(snapshot: &Snapshot, code: &str) -> Option<Severity> {
    if let Some(level) = snapshot.config.severity.get(code) {
        return Level::severity(*level);
    }
    let known = codes::all().find(|candidate| candidate.id == code);
    Some(known.map_or(Severity::Warning, |code| code.severity))
}

/// The last places of the run.
fn related(entry: &Entry, answer: &Answer, check: &CheckReport) -> Vec<Related> {
    let unit = answer.unit();
    let mut related: Vec<Related> = Vec::new();
    for event in check.run().iter().rev() {
        if related.len() < RELATED
            && matches!(event.kind, MomentKind::Wait | MomentKind::Begin)
            && let Some((path, range)) = place(entry.places(), event.src)
        {
            let message = format!("{}: {}", unit.show(event.time), event.what).into();
            related.push(Related { path, range, message });
        }
    }
    related.reverse();
    related
}
