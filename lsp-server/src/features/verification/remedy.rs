//! The quick fix of a missed deadline: the execution time with which it was verified to be met.

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::model::Seconds;
use dotgen_timing::derive::Remedy;
use num_rational::Ratio;

use super::place;
use super::problems::about;
use crate::features::convert::edit::{with_edit, workspace_edit};
use crate::protocol::types::{CodeAction, CodeActionKind, Diagnostic};
use crate::workspace::snapshot::{Snapshot, Subject};

/// The action for a remedy; none where there is no time to be replaced in the text.
pub(super) fn action(
    snapshot: &Snapshot,
    subject: &Subject,
    remedy: &Remedy,
    diagnostic: Option<Diagnostic>,
) -> Cancellable<Option<CodeAction>> {
    let Remedy::Wcet {
        codel,
        seconds,
        src,
        ..
    } = remedy
    else {
        return Ok(None);
    };
    for (_, entry) in about(snapshot, &subject.path) {
        let Some((path, range)) = place(entry.places(), *src) else {
            continue;
        };
        let time = written(*seconds);
        let edit = snapshot.analysis.with_execution_time(&path, range, &time)?;
        let Some(edit) = edit else {
            continue;
        };
        let action = CodeAction {
            title: format!("Set the execution time of `{codel}` to {time}, with which this holds"),
            kind: Some(CodeActionKind::QUICKFIX),
            diagnostics: diagnostic.map(|it| vec![it]),
            ..CodeAction::default()
        };
        let edited = workspace_edit(snapshot, &[edit])?;
        return Ok(with_edit(snapshot, action, edited));
    }
    Ok(None)
}

/// A time as specifications write it: whole, in the largest unit in which it is.
fn written(time: Seconds) -> String {
    let whole = |per_second: i128| {
        let count = time * Ratio::from_integer(per_second);
        count.is_integer().then(|| count.to_integer())
    };
    match (whole(1_000), whole(1_000_000)) {
        (Some(it), _) => format!("{it} ms"),
        (_, Some(it)) => format!("{it} us"),
        _ => {
            let micros = *time.numer() as f64 * 1e6 / *time.denom() as f64;
            format!("{micros:.3} us")
        }
    }
}
