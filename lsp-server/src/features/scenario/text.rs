//! Features of scenarios that need only their text.

use std::ops::Range;

use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::ide::{FoldKind, FoldingRange as Fold};
use dotgen_timing::scn;
use dotgen_timing::scn::lexer::{Kind, lex};
use dotgen_timing::scn::selection;

use crate::features::convert::edit::text_edits;
use crate::features::specification::{folding_range, selection_range};
use crate::protocol::convert::position::touches;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

/// The edits that format a scenario.
pub(super) fn format(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentFormattingParams,
) -> Answer<Option<Vec<TextEdit>>> {
    formatted(snapshot, subject, None)
}

/// The edits that format the lines of a range.
pub(super) fn format_range(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentRangeFormattingParams,
) -> Answer<Option<Vec<TextEdit>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let range = lines.clamped(params.range).ok_or(Stop::Nothing)?;
    formatted(snapshot, subject, Some(&range))
}

/// The edits that format a scenario, or a part of it.
fn formatted(
    snapshot: &Snapshot,
    subject: &Subject,
    part: Option<&Range<usize>>,
) -> Answer<Option<Vec<TextEdit>>> {
    let text = snapshot.analysis.text(&subject.path)?.ok_or(Stop::Nothing)?;
    // The formatter writes `\n`. In a text with other line ends, blanks that differ only there stay.
    let edits = scn::format_edits(&text).ok_or(Stop::Nothing)?;
    let edits = edits.into_iter().filter(|(range, new)| {
        let touched = part.is_none_or(|part| touches(part, range));
        touched && text[range.clone()].replace("\r\n", "\n") != *new
    });
    let edits: Vec<FileEdit> = edits
        .map(|(range, new_text)| FileEdit { path: subject.path.clone(), range, new_text })
        .collect();
    if edits.is_empty() { Ok(None) } else { text_edits(snapshot, &subject.path, &edits) }
}

/// The nested ranges around places.
pub(super) fn selections(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SelectionRangeParams,
) -> Answer<Option<Vec<SelectionRange>>> {
    let text = snapshot.analysis.text(&subject.path)?.ok_or(Stop::Nothing)?;
    selection_range::answer(snapshot, subject, params, |offsets| {
        Ok(offsets.iter().map(|&offset| selection::selections(&text, offset)).collect())
    })
}

/// Ranges of braces with more than one line, and of comments.
pub(super) fn folds(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &FoldingRangeParams,
) -> Answer<Option<Vec<FoldingRange>>> {
    let text = snapshot.analysis.text(&subject.path)?.ok_or(Stop::Nothing)?;
    let mut open = Vec::new();
    let mut out = Vec::new();
    for token in lex(&text) {
        match token.kind {
            Kind::OpenBrace => open.push(token.range.end),
            Kind::CloseBrace => {
                let range = open.pop().map(|from| from..token.range.start);
                out.extend(range.map(|range| Fold { range, kind: None }));
            }
            Kind::BlockComment => {
                out.push(Fold { range: token.range, kind: Some(FoldKind::Comment) });
            }
            _ => {}
        }
    }
    folding_range::answer(snapshot, subject, &out)
}
