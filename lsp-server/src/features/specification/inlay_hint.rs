//! `textDocument/inlayHint`

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::InlayKind;

use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &InlayHintParams,
) -> Cancellable<Option<Vec<InlayHint>>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    let Some(range) = lines.clamped(params.range) else {
        return Ok(None);
    };
    let config = snapshot.config.inlay_hints;
    let hints = snapshot.analysis.inlay_hints(&subject.path, range, &config)?;
    let convert = hints.into_iter().map(|hint| InlayHint {
        position: lines.range(&(hint.at..hint.at)).start,
        label: InlayHintLabel::String(hint.label),
        kind: (hint.kind == InlayKind::Type).then_some(InlayHintKind::TYPE),
        text_edits: None,
        tooltip: (!hint.tooltip.is_empty()).then_some({
            InlayHintTooltip::MarkupContent(MarkupContent {
                kind: MarkupKind::Markdown,
                value: hint.tooltip,
            })
        }),
        padding_left: None,
        padding_right: None,
        data: None,
    });
    Ok(Some(convert.collect()))
}
