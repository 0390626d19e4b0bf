//! `dotgen/verification`: the complete result for a document, or for a variation of it. `docs/protocol.md`
//! describes it for clients.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::phrase::Phrase;
use dotgen_timing::diagnostic::Severity;
use dotgen_timing::diagnostic::remark::together;
use dotgen_timing::report::TimeUnit;
use dotgen_timing::verify::{Cancel, Options, settings};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::place;
use super::problems::{self, about};
use crate::protocol::types::{Location, TextDocumentIdentifier, Uri};
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_views::verification::advice;
use dotgen_views::verification::blocking::{self, CodelLocation};
use dotgen_views::verification::fold_repetitions::{Part, fold_repetitions, words as again};
use dotgen_views::verification::results::{Answer, Status};
use dotgen_views::verification::run::{self, Interim};
use dotgen_views::verification::runs;
use dotgen_views::verification::summary;
use dotgen_views::verification::view::CheckView;
use dotgen_views::verification::what_if::WhatIf;
use dotgen_views::verification::{Problem, TaskBound};

/// Parameters of `dotgen/verification`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct VerificationParams {
    /// A scenario or a specification.
    pub(crate) text_document: TextDocumentIdentifier,
    /// Number of the check whose run is shown. The default is the first refuted check.
    #[serde(default)]
    check: Option<usize>,
    /// The event of the run after which the chosen steps follow.
    #[serde(default)]
    pub(super) after: Option<usize>,
    /// The chosen steps, each an index into the list of possible steps at that point.
    #[serde(default)]
    pub(super) take: Vec<usize>,
    /// A variation.
    #[serde(default)]
    what_if: WhatIf,
}

impl VerificationParams {
    /// The complete result for a document, with a variation.
    pub(super) fn about(text_document: TextDocumentIdentifier, what_if: WhatIf) -> Self {
        VerificationParams { text_document, check: None, after: None, take: Vec::new(), what_if }
    }

    /// True if the request is about a variation.
    pub(super) fn is_varied(&self) -> bool {
        !self.what_if.is_nothing()
    }

    /// The check whose run is shown.
    pub(super) fn check(&self) -> Option<usize> {
        self.check
    }
}

/// The verification of a document, copied from a snapshot.
pub(crate) struct Prepared {
    uri: Option<Uri>,
    version: Option<i32>,
    status: Status,
    earlier: bool,
    problem: Arc<Problem>,
    places: Arc<Problem>,
    bounds: Arc<Vec<TaskBound>>,
    /// The known answer. `None`: it has to be computed.
    known: Option<Option<Arc<Answer>>>,
    what_if: WhatIf,
    options: Options,
    limit: Duration,
}

/// Finds the verification of a document.
pub(crate) fn prepare(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &VerificationParams,
) -> Cancellable<Option<Prepared>> {
    let settings = &snapshot.config.verification;
    let found = about(snapshot, &subject.path).into_iter().next();
    let blank = |problem: Problem| {
        let problem = Arc::new(problem);
        Prepared {
            uri: Some(subject.uri.clone()),
            version: subject.version,
            status: Status::Running,
            earlier: false,
            places: problem.clone(),
            problem,
            bounds: Arc::default(),
            known: None,
            what_if: params.what_if.clone(),
            options: settings.options(),
            limit: settings.time_limit(),
        }
    };
    let Some((path, entry)) = found else {
        // Verification on edit is off, or the document has no timing: verify on request all the same.
        let problem = problems::problem_of(snapshot, &subject.path)?;
        return Ok(problem.map(blank));
    };
    let known = params.what_if.is_nothing();
    Ok(Some(Prepared {
        uri: snapshot.uri(path),
        version: entry.version,
        status: entry.status,
        earlier: known && entry.answer.is_some() && entry.known().is_none(),
        problem: entry.problem.clone(),
        places: entry.places().clone(),
        bounds: entry.bounds.clone(),
        known: known.then(|| entry.answer.clone()),
        ..blank((*entry.problem).clone())
    }))
}

/// An answer to be shown.
pub(crate) struct PreparedAnswer {
    prepared: Prepared,
    answer: Option<Arc<Answer>>,
    errors: Vec<String>,
}

impl PreparedAnswer {
    pub(super) fn found(&self) -> Option<&Arc<Answer>> {
        self.answer.as_ref()
    }

    /// The problem with the places of the answer.
    pub(super) fn places(&self) -> &Problem {
        &self.prepared.places
    }
}

/// Cancels work when its result is no longer awaited.
pub(super) struct CancelOnDrop(pub(super) Arc<Cancel>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.abandon();
    }
}

impl Prepared {
    /// Version of the document.
    pub(super) fn version(&self) -> Option<i32> {
        self.version
    }

    /// The verified problem.
    pub(super) fn problem(&self) -> Arc<Problem> {
        self.problem.clone()
    }

    fn errors(&self) -> Vec<String> {
        let errors = self.problem.errors.iter();
        errors.map(|error| error.message.to_string()).collect()
    }

    /// The problem and options to verify, or the errors that prevent it.
    pub(super) fn varied(&self) -> Result<(Problem, Options), Vec<String>> {
        let mut errors = self.errors();
        let varied = self.what_if.apply(&self.problem);
        let options = self.what_if.options(self.options.clone());
        match (varied, options) {
            (Ok(problem), Ok(options)) if errors.is_empty() => return Ok((problem, options)),
            (Err(why), _) | (_, Err(why)) => errors.push(why),
            _ => {}
        }
        Err(errors)
    }

    /// The answer, verified first if it is not known. Dropping the future cancels the work.
    pub(crate) async fn answer(mut self) -> PreparedAnswer {
        let failures = self.errors();
        if let Some(answer) = self.known.clone() {
            return PreparedAnswer { prepared: self, answer, errors: failures };
        }
        let (problem, options) = match self.varied() {
            Ok(varied) => varied,
            Err(errors) => {
                self.status = Status::Blocked;
                return PreparedAnswer { prepared: self, answer: None, errors };
            }
        };
        let cancel = Arc::new(Cancel::default());
        let _guard = CancelOnDrop(cancel.clone());
        let (problem, limit) = (Arc::new(problem), self.limit);
        let work = tokio::task::spawn_blocking(move || {
            let last: Mutex<Option<Arc<Answer>>> = Mutex::default();
            let tell = |found: Interim| {
                if let Interim::Answer(answer) = found {
                    *last.lock().unwrap_or_else(PoisonError::into_inner) = Some(answer);
                }
            };
            run::run(problem, options, limit, &cancel, tell);
            last.into_inner().unwrap_or_else(PoisonError::into_inner)
        });
        let answer = match work.await {
            Ok(answer) => answer,
            Err(error) => {
                tracing::error!("verification panicked: {error}");
                None
            }
        };
        if let Some(answer) = &answer {
            self.status = answer.status();
            self.places = answer.problem.clone();
            self.bounds = answer.bounds.clone();
        }
        PreparedAnswer { prepared: self, answer, errors: Vec::new() }
    }
}

/// An answer to be shown, and its document.
pub(crate) struct Question {
    pub(crate) shown: PreparedAnswer,
    /// The parameters of the request.
    pub(crate) params: VerificationParams,
}

/// The answer for a client.
pub(crate) fn present(
    snapshot: &Snapshot,
    _: &Subject,
    question: &Question,
) -> Cancellable<Option<Value>> {
    let Question { shown, params } = question;
    let PreparedAnswer { prepared, answer, errors } = shown;
    let options = answer.as_ref().map_or(&prepared.options, |answer| &answer.options);
    let problem = answer.as_ref().map_or(&prepared.problem, |answer| &answer.problem);
    let settings = settings(&problem.scenario, options);
    let unit = TimeUnit::of(&settings);
    let (codels, blocking) = codels(snapshot, prepared, problem, options, unit)?;
    let bounds = prepared.bounds.iter();
    let bounds = bounds.map(|bound| json!({ "task": bound.task, "bound": unit.show(bound.bound) }));
    let mut out = json!({
        "uri": prepared.uri,
        "version": prepared.version,
        "status": prepared.status,
        "earlier": prepared.earlier,
        "howFar": null,
        "scenario": problem.scenario.name,
        "written": prepared.problem.is_written(),
        "platform": summary::platform(&settings),
        "cores": settings.cores,
        "policy": settings.policy().name(),
        "durations": settings.durations.name(),
        "errors": errors,
        "warnings": [],
        "advice": null,
        "checks": [],
        "bounds": bounds.collect::<Vec<_>>(),
        "minimumCores": null,
        "repairs": [],
        "assumptions": [],
        "notes": [],
        "blocking": blocking,
        "codels": codels,
        "run": null,
        "states": 0,
        "seconds": 0.0,
        "whatIf": !params.what_if.is_nothing(),
    });
    let Some(answer) = answer else {
        return Ok(Some(out));
    };
    let report = &answer.report;
    let mut errors = errors.clone();
    let mut warnings = Vec::new();
    for diagnostic in together(&report.diagnostics) {
        if diagnostic.severity == Severity::Error {
            errors.push(diagnostic.message.to_string());
            continue;
        }
        let at = prepared.places.diagnostic(&diagnostic);
        let location = snapshot.location(&at.path, &at.range)?;
        warnings.push(json!({ "message": at.message, "location": location }));
    }
    out["errors"] = json!(errors);
    out["warnings"] = json!(warnings);
    if report.answered() < report.checks.len() && !prepared.earlier {
        out["howFar"] = json!(report.how_far());
    }
    out["advice"] = json!(advice::of_report(report, problem, advice::LimitNames::Settings));
    out["minimumCores"] = json!(answer.cores.as_ref().and_then(|core| core.cores));
    let repairs = answer.repairs.all.iter();
    out["repairs"] = repairs.map(|repair| repair.words.clone()).collect();
    out["assumptions"] = json!(report.assumptions);
    out["notes"] = json!(report.notes);
    out["states"] = json!(report.states);
    out["seconds"] = json!(report.seconds);
    let checks = answer.view().checks;
    let checks = checks.iter().map(|check| shown_check(snapshot, prepared, check));
    out["checks"] = checks.collect::<Cancellable<_>>()?;
    if let Some(chosen) = runs::chosen(report, params.check) {
        out["run"] = shown_run(snapshot, prepared, answer, chosen)?;
    }
    Ok(Some(out))
}

/// The codels of a system, and those that wait for others.
fn codels(
    snapshot: &Snapshot,
    prepared: &Prepared,
    problem: &Problem,
    options: &Options,
    unit: TimeUnit,
) -> Cancellable<(Vec<Value>, Vec<Value>)> {
    let location = |at: &CodelLocation| locate(snapshot, &prepared.places, at.src);
    let mut blocked = Vec::new();
    let mut codels = Vec::new();
    for row in &blocking::table(problem, options) {
        let (path, place) = (row.codel.path.to_string(), location(&row.codel)?);
        codels.push(json!({ "path": path, "wcet": row.codel.micros, "location": place }));
        let mut by = Vec::new();
        for blocker in &row.by {
            by.push(json!({
                "codel": blocker.codel.path.to_string(),
                "location": location(&blocker.codel)?,
                "time": blocker.codel.upper.map_or("no end".to_owned(), |number| unit.show(number)),
                "through": Phrase::joined(&blocker.through, ", ").to_string(),
            }));
        }
        if !by.is_empty() {
            blocked.push(json!({ "codel": path, "location": place, "by": by }));
        }
    }
    Ok((codels, blocked))
}

/// A place of a specification for a client.
pub(super) fn locate(
    snapshot: &Snapshot,
    places: &Problem,
    src: Option<(usize, dotgen_analysis::model::Src)>,
) -> Cancellable<Option<Location>> {
    match place(places, src) {
        Some((path, range)) => snapshot.location(&path, &range),
        None => Ok(None),
    }
}

fn shown_check(snapshot: &Snapshot, prepared: &Prepared, view: &CheckView) -> Cancellable<Value> {
    let check = view.report;
    let location = match &view.written {
        Some(range) => snapshot.location(&prepared.places.path, range)?,
        None => None,
    };
    Ok(json!({
        "name": check.name,
        "check": check.kind.word(),
        "of": check.of,
        "verdict": view.verdict.word(),
        "worth": view.worth,
        "value": view.value,
        "limit": view.limit,
        "slack": view.slack,
        "note": check.note,
        "condition": view.condition,
        "cause": view.cause,
        "remedy": view.remedy,
        "reason": view.reason,
        "hasRun": !check.run().is_empty(),
        "location": location,
    }))
}

/// Number of events shown of a long run: its last ones. The trace has all of them.
const MAX_EVENTS: usize = 500;

/// The run of a check as text, with repeated parts once.
fn shown_run(
    snapshot: &Snapshot,
    prepared: &Prepared,
    answer: &Answer,
    number: usize,
) -> Cancellable<Value> {
    let check = &answer.report.checks[number];
    let unit = answer.unit();
    let omitted = check.run().len().saturating_sub(MAX_EVENTS);
    let events = &check.run()[omitted..];
    let cycle = check.cycle.and_then(|cycle| cycle.checked_sub(omitted));
    let mut lines = Vec::new();
    let mut line = |text: String, location: Option<Location>| {
        lines.push(json!({ "text": text, "location": location }));
    };
    if omitted > 0 {
        line(format!("… {omitted} steps before are not shown"), None);
    }
    for part in fold_repetitions(events, cycle) {
        match part {
            Part::Steps(range) => {
                for step in range {
                    if cycle == Some(step) {
                        line("from here on for ever:".to_owned(), None);
                    }
                    let event = &events[step];
                    let at = unit.show(event.time);
                    let text = format!("{at}  {}  {}", event.thread, event.what);
                    line(text, locate(snapshot, &prepared.places, event.src)?);
                }
            }
            Part::Again { steps, times, last } => {
                let until = unit.show(events[last].time);
                line(format!("… {}, until {until} …", again(steps, times)), None);
            }
        }
    }
    Ok(json!({
        "check": number,
        "title": runs::title(check),
        "shows": runs::shows(check),
        "events": lines,
    }))
}
