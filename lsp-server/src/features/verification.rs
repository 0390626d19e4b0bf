//! Verification in documents: lenses on tasks, diagnostics, code actions, and `dotgen/verification` with
//! everything in one answer.

mod answer;
mod diagnostics;
mod export;
mod lens;
pub(crate) mod problems;
mod remedy;
mod sensitivity;
mod trace;

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::language;
use dotgen_analysis::source_map::Locations;
use dotgen_timing::report::{CheckReport, Verdict};
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::indexed::DeclaredTask;
use serde_json::{Value, json};

use crate::features::codels::judged_actions::JudgedActions;
use crate::features::commands::SHOW_VERIFICATION;
use crate::protocol::convert::position::touches;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_views::verification::{Problem, problem};

pub(crate) use answer::{Question, VerificationParams, prepare, present};
pub(crate) use diagnostics::{in_scenario, in_specification};
pub(crate) use export::{ExportParams, to_export};
pub(crate) use lens::{hover, lenses, scenario_lenses};
pub(crate) use sensitivity::{SensitivityParams, SensitivityResult, ask, shown};
pub(crate) use trace::{TraceResult, trace};

/// A task of a document: its name and place.
struct TaskLocation {
    id: DeclaredTask,
    range: Range<usize>,
}

/// The tasks that a file of a problem declares.
fn tasks(problem: &Problem, path: &Utf8Path) -> Vec<TaskLocation> {
    let mut out: Vec<TaskLocation> = Vec::new();
    let specs = problem.specs();
    for (c, member) in Names::new(&specs).components.iter().enumerate() {
        let unit = &problem.units[member.spec_index];
        for (t, task) in member.component.tasks.iter_enumerated() {
            let place = unit.locations.locate(task.src);
            if let Some(place) = place.filter(|place| place.path == path) {
                out.push(TaskLocation {
                    id: DeclaredTask { component: c, index: t },
                    range: place.range,
                });
            }
        }
    }
    out
}

/// The place of an item in the specifications of a problem.
fn place(
    problem: &Problem,
    src: Option<(usize, dotgen_analysis::model::Src)>,
) -> Option<(Utf8PathBuf, Range<usize>)> {
    let (spec, src) = src?;
    problem.place(spec, src)
}

/// Returns true if a run refutes a check.
fn has_refuting_run(check: &CheckReport) -> bool {
    check.verdict == Verdict::Refuted && !check.run().is_empty()
}

/// The kind of the action that writes the default scenario to a file. Editors ask for the action by this
/// kind.
const WRITE_SCENARIO: CodeActionKind = CodeActionKind::new("refactor.rewrite.scenario");

/// The title of the action at a refuted check.
const SHOW_RUN: &str = "Step through the run that shows it";

/// The argument of [`SHOW_VERIFICATION`].
fn argument(uri: &Uri, check: Option<usize>) -> Value {
    json!({ "uri": uri, "check": check })
}

/// The argument of [`SHOW_VERIFICATION`] that shows the run by which a check is refuted.
fn refuting_run(uri: &Uri, check: usize) -> Value {
    json!({ "uri": uri, "check": check, "run": true })
}

/// Code actions: open the run of a diagnostic; write the default scenario to a file.
pub(crate) fn actions(
    snapshot: &Snapshot,
    subject: &Subject,
    range: &Range<usize>,
    offers: &mut JudgedActions<'_, '_, '_>,
) -> Cancellable<Vec<CodeActionOrCommand>> {
    let mut out = Vec::new();
    if snapshot.client.verification_status {
        for (uri, found) in diagnostics::at(snapshot, &subject.path, range)? {
            let diagnostic =
                crate::features::convert::diagnostic::to_proto(snapshot, &found.diagnostic)?;
            for change in &found.changes {
                let of = diagnostic.clone();
                out.extend(remedy::action(snapshot, offers, &found.problem, change, of)?);
            }
            if found.diagnostic.code == diagnostics::GAVE_UP {
                // Without a run to show, the action that helps is the one that writes a scenario.
                let scenario = write_out(snapshot, subject, range, diagnostic)?;
                out.extend(scenario.map(CodeActionOrCommand::CodeAction));
                continue;
            }
            if !found.refuting_run {
                continue;
            }
            let arguments = Some(vec![refuting_run(&uri, found.check)]);
            out.push(CodeActionOrCommand::CodeAction(CodeAction {
                title: SHOW_RUN.to_owned(),
                kind: Some(CodeActionKind::QUICKFIX),
                diagnostics: diagnostic.map(|diagnostic| vec![diagnostic]),
                command: Some(Command::new(
                    SHOW_RUN.to_owned(),
                    SHOW_VERIFICATION.to_owned(),
                    arguments,
                )),
                ..CodeAction::default()
            }));
        }
    }
    let scenario = write_out(snapshot, subject, range, None)?;
    out.extend(scenario.map(CodeActionOrCommand::CodeAction));
    Ok(out)
}

/// The action that writes the default scenario to a file next to the specification. Offered on the heading of
/// a component, and at a check that gave up because there is no scenario.
fn write_out(
    snapshot: &Snapshot,
    subject: &Subject,
    range: &Range<usize>,
    given_up: Option<Diagnostic>,
) -> Cancellable<Option<CodeAction>> {
    let path = &subject.path;
    if !snapshot.client.creates_files || !language::is_specification(path) {
        return Ok(None);
    }
    let unit = snapshot.analysis.root_unit(path)?;
    let heading = problem::components(&unit.spec).any(|component| {
        let place = unit.locations.locate(component.src);
        place.is_some_and(|place| place.path == *path && touches(&place.range, range))
    });
    let target = path.with_extension(language::SCENARIO);
    if !(heading || given_up.is_some()) || target.exists() || snapshot.open.contains_key(&target) {
        return Ok(None);
    }
    let (Some(problem), Some(uri)) = (problems::problem_of(snapshot, path)?, snapshot.uri(&target))
    else {
        return Ok(None);
    };
    if !problem.errors.is_empty() {
        return Ok(None);
    }
    let file = target.file_name().unwrap_or_default();
    let create = CreateFile {
        uri: uri.clone(),
        options: Some(CreateFileOptions { overwrite: Some(false), ignore_if_exists: Some(false) }),
        annotation_id: None,
    };
    let fill = TextDocumentEdit {
        text_document: OptionalVersionedTextDocumentIdentifier { uri, version: None },
        edits: vec![OneOf::Left(TextEdit::new(
            crate::protocol::types::Range::default(),
            problem.text,
        ))],
    };
    Ok(Some(CodeAction {
        title: format!("Write the verification scenario to {file}"),
        kind: Some(match given_up {
            Some(_) => CodeActionKind::QUICKFIX,
            None => WRITE_SCENARIO,
        }),
        diagnostics: given_up.map(|diagnostic| vec![diagnostic]),
        edit: Some(WorkspaceEdit {
            document_changes: Some(DocumentChanges::Operations(vec![
                DocumentChangeOperation::Op(ResourceOp::Create(create)),
                DocumentChangeOperation::Edit(fill),
            ])),
            ..WorkspaceEdit::default()
        }),
        ..CodeAction::default()
    }))
}
