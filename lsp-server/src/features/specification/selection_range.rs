//! `textDocument/selectionRange`

use dotgen_analysis::host::Cancellable;

use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SelectionRangeParams,
) -> Answer<Option<Vec<SelectionRange>>> {
    answer(snapshot, subject, params, |offsets| {
        snapshot.analysis.selection_ranges(&subject.path, offsets)
    })
}

/// The answer, from a function that returns the nested ranges around each of some offsets, the smallest
/// first.
pub(crate) fn answer(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SelectionRangeParams,
    ranges: impl FnOnce(&[usize]) -> Cancellable<Vec<Vec<std::ops::Range<usize>>>>,
) -> Answer<Option<Vec<SelectionRange>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let positions = params.positions.iter();
    let offsets = positions.map(|position| lines.offset(*position));
    let offsets = offsets.collect::<Option<Vec<_>>>().ok_or(Stop::Nothing)?;
    let chains = ranges(&offsets)?;
    // The protocol requires one answer per position.
    let answer = params.positions.iter().enumerate().map(|(at, position)| {
        let chain = chains.get(at).map_or(&[][..], Vec::as_slice);
        let outermost_first = chain.iter().rev();
        outermost_first
            .fold(None, |parent, range| {
                Some(SelectionRange { range: lines.range(range), parent: parent.map(Box::new) })
            })
            .unwrap_or(SelectionRange { range: Range::new(*position, *position), parent: None })
    });
    Ok(Some(answer.collect()))
}
