//! `textDocument/formatting`, `rangeFormatting` and `onTypeFormatting`

use crate::config::style;
use crate::features::convert::edit::text_edits;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

pub(crate) fn document(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentFormattingParams,
) -> Answer<Option<Vec<TextEdit>>> {
    let style = style::options(&snapshot.config.format, &subject.path, Some(&params.options));
    let edits = snapshot.analysis.format(&subject.path, None, &style)?;
    text_edits(snapshot, &subject.path, &edits)
}

pub(crate) fn range(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentRangeFormattingParams,
) -> Answer<Option<Vec<TextEdit>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let range = lines.clamped(params.range).ok_or(Stop::Nothing)?;
    let style = style::options(&snapshot.config.format, &subject.path, Some(&params.options));
    let edits = snapshot.analysis.format(&subject.path, Some(range), &style)?;
    text_edits(snapshot, &subject.path, &edits)
}

pub(crate) fn on_type(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentOnTypeFormattingParams,
) -> Answer<Option<Vec<TextEdit>>> {
    let position = params.text_document_position.position;
    let at = snapshot.at(subject, position)?;
    let typed = params.ch.chars().next().ok_or(Stop::Nothing)?;
    let style = style::options(&snapshot.config.format, &subject.path, Some(&params.options));
    let edits = snapshot.analysis.format_on_type(&at, typed, &style)?;
    text_edits(snapshot, &subject.path, &edits)
}
