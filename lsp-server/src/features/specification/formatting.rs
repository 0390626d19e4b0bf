//! `textDocument/formatting`, `rangeFormatting` and `onTypeFormatting`

use dotgen_analysis::host::Cancellable;

use crate::config::style;
use crate::features::convert::edit::text_edits;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn document(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentFormattingParams,
) -> Cancellable<Option<Vec<TextEdit>>> {
    let style = style::options(&snapshot.config.format, &subject.path, Some(&params.options));
    let edits = snapshot.analysis.format(&subject.path, None, &style)?;
    text_edits(snapshot, &subject.path, &edits)
}

pub(crate) fn range(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentRangeFormattingParams,
) -> Cancellable<Option<Vec<TextEdit>>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    let Some(range) = lines.clamped(params.range) else {
        return Ok(None);
    };
    let style = style::options(&snapshot.config.format, &subject.path, Some(&params.options));
    let edits = snapshot.analysis.format(&subject.path, Some(range), &style)?;
    text_edits(snapshot, &subject.path, &edits)
}

pub(crate) fn on_type(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentOnTypeFormattingParams,
) -> Cancellable<Option<Vec<TextEdit>>> {
    let position = params.text_document_position.position;
    let (Some(at), Some(typed)) = (snapshot.cursor(subject, position)?, params.ch.chars().next())
    else {
        return Ok(None);
    };
    let style = style::options(&snapshot.config.format, &subject.path, Some(&params.options));
    let edits = snapshot.analysis.format_on_type(&at, typed, &style)?;
    text_edits(snapshot, &subject.path, &edits)
}
