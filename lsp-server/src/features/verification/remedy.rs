//! The remedies of a missed deadline: changes that were verified to meet it, as quick fixes and as buttons.

use dotgen_analysis::host::Cancellable;
use dotgen_codegen::codels::edit::Edit;
use dotgen_timing::advice::Change;
use serde_json::{Value, json};

use crate::features::codels::judged_actions::{self, JudgedActions};
use crate::protocol::types::{CodeAction, CodeActionKind, CodeActionOrCommand, Diagnostic};
use crate::workspace::snapshot::{Snapshot, Subject};
use dotgen_views::verification::what_if::WhatIf;
use dotgen_views::verification::{Problem, changes};

/// The remedies among changes that are edits which the judge accepts, for a viewer of the run. `whatIf` is
/// the same change as a variation; it is `null` if a variation cannot say it.
pub(super) fn of_run(
    snapshot: &Snapshot,
    subject: &Subject,
    problem: &Problem,
    changes: &[Change],
) -> Cancellable<Vec<Value>> {
    if changes.is_empty() {
        return Ok(Vec::new());
    }
    judged_actions::offers(snapshot, &subject.path, |offers| {
        let mut out = Vec::new();
        for change in changes {
            let titled = |title| CodeAction { title, ..CodeAction::default() };
            let judged = judged(snapshot, offers, problem, change, titled)?;
            if let Some(CodeActionOrCommand::CodeAction(action)) = judged
                && let Some(edit) = action.edit
            {
                let what_if = WhatIf::of(change);
                out.push(json!({ "title": action.title, "edit": edit, "whatIf": what_if }));
            }
        }
        Ok(out)
    })
}

/// The action for a change; `None` if the change is not an edit, or the judge refuses the edit.
pub(super) fn action(
    snapshot: &Snapshot,
    offers: &mut JudgedActions<'_, '_, '_>,
    problem: &Problem,
    change: &Change,
    diagnostic: Option<Diagnostic>,
) -> Cancellable<Option<CodeActionOrCommand>> {
    judged(snapshot, offers, problem, change, |title| CodeAction {
        title: format!("{title}, with which this holds"),
        kind: Some(CodeActionKind::QUICKFIX),
        diagnostics: diagnostic.map(|diagnostic| vec![diagnostic]),
        ..CodeAction::default()
    })
}

/// The action for a change, with its edit, as the judge accepts it.
fn judged(
    snapshot: &Snapshot,
    offers: &mut JudgedActions<'_, '_, '_>,
    problem: &Problem,
    change: &Change,
    titled: impl FnOnce(String) -> CodeAction,
) -> Cancellable<Option<CodeActionOrCommand>> {
    let Some(edit) = changes::edit(&snapshot.analysis, problem, change)? else {
        return Ok(None);
    };
    let Some(title) = changes::title(change) else {
        return Ok(None);
    };
    offers.action(titled(title), &Edit::of(&[edit]), None)
}
