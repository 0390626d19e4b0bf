//! `textDocument/selectionRange`

use dotgen_analysis::host::Cancellable;

use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SelectionRangeParams,
) -> Cancellable<Option<Vec<SelectionRange>>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    let positions = params.positions.iter();
    let Some(offsets) = positions
        .map(|it| lines.offset(*it))
        .collect::<Option<Vec<_>>>()
    else {
        return Ok(None);
    };
    let chains = snapshot
        .analysis
        .selection_ranges(&subject.path, &offsets)?;
    // The protocol requires one answer per position.
    let answer = params.positions.iter().enumerate().map(|(at, position)| {
        let chain = chains.get(at).map_or(&[][..], Vec::as_slice);
        let outermost_first = chain.iter().rev();
        outermost_first
            .fold(None, |parent, range| {
                Some(SelectionRange {
                    range: lines.range(range),
                    parent: parent.map(Box::new),
                })
            })
            .unwrap_or(SelectionRange {
                range: Range::new(*position, *position),
                parent: None,
            })
    });
    Ok(Some(answer.collect()))
}
