//! `textDocument/foldingRange`

use dotgen_analysis::ide::{FoldKind, FoldingRange as Fold};

use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &FoldingRangeParams,
) -> Answer<Option<Vec<FoldingRange>>> {
    answer(snapshot, subject, &snapshot.analysis.folding_ranges(&subject.path)?)
}

/// The ranges with more than one line, as the client needs them.
pub(crate) fn answer(
    snapshot: &Snapshot,
    subject: &Subject,
    folds: &[Fold],
) -> Answer<Option<Vec<FoldingRange>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let whole_lines = snapshot.client.line_folding_only;
    let convert = folds.iter().filter_map(|folding_range| {
        let range = lines.range(&folding_range.range);
        // A client that folds whole lines would hide the text after the closing brace.
        let keep_last = whole_lines && folding_range.kind.is_none();
        let end_line = range.end.line - u32::from(keep_last && range.end.line > 0);
        (end_line > range.start.line).then(|| FoldingRange {
            start_line: range.start.line,
            start_character: (!whole_lines).then_some(range.start.character),
            end_line,
            end_character: (!whole_lines).then_some(range.end.character),
            kind: folding_range.kind.map(|kind| match kind {
                FoldKind::Comment => FoldingRangeKind::Comment,
                FoldKind::Imports => FoldingRangeKind::Imports,
                FoldKind::Region => FoldingRangeKind::Region,
            }),
            collapsed_text: None,
        })
    });
    Ok(Some(convert.collect()))
}
