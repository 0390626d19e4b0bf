//! The quick fixes of a missed deadline: changes with which it was verified to be met.

use dotgen_analysis::host::Cancellable;
use dotgen_timing::advice::Change;

use crate::features::convert::edit::{with_edit, workspace_edit};
use crate::protocol::types::{CodeAction, CodeActionKind, Diagnostic};
use crate::verification::{Problem, changes};
use crate::workspace::snapshot::Snapshot;

/// The action for a change; none where it is no edit.
pub(super) fn action(
    snapshot: &Snapshot,
    problem: &Problem,
    change: &Change,
    diagnostic: Option<Diagnostic>,
) -> Cancellable<Option<CodeAction>> {
    let Some(edit) = changes::edit(&snapshot.analysis, problem, change)? else {
        return Ok(None);
    };
    let Some(title) = changes::title(change) else {
        return Ok(None);
    };
    let action = CodeAction {
        title: format!("{title}, with which this holds"),
        kind: Some(CodeActionKind::QUICKFIX),
        diagnostics: diagnostic.map(|it| vec![it]),
        ..CodeAction::default()
    };
    let edited = workspace_edit(snapshot, &[edit])?;
    Ok(with_edit(snapshot, action, edited))
}
