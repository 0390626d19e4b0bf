//! The quick fixes of a missed deadline: changes that were verified to meet it.

use dotgen_analysis::host::Cancellable;
use dotgen_codegen::codels::edit::Edit;
use dotgen_timing::advice::Change;

use crate::features::codels::judged_actions::JudgedActions;
use crate::protocol::types::{CodeAction, CodeActionKind, CodeActionOrCommand, Diagnostic};
use crate::workspace::snapshot::Snapshot;
use dotgen_views::verification::{Problem, changes};

/// The action for a change; `None` if the change is not an edit, or the judge refuses the edit.
pub(super) fn action(
    snapshot: &Snapshot,
    offers: &mut JudgedActions<'_, '_, '_>,
    problem: &Problem,
    change: &Change,
    diagnostic: Option<Diagnostic>,
) -> Cancellable<Option<CodeActionOrCommand>> {
    let Some(edit) = changes::edit(&snapshot.analysis, problem, change)? else {
        return Ok(None);
    };
    let Some(title) = changes::title(change) else {
        return Ok(None);
    };
    let action = CodeAction {
        title: format!("{title}, with which this holds"),
        kind: Some(CodeActionKind::QUICKFIX),
        diagnostics: diagnostic.map(|diagnostic| vec![diagnostic]),
        ..CodeAction::default()
    };
    offers.action(action, &Edit::of(&[edit]), None)
}
