//! `textDocument/inlayHint`

use dotgen_analysis::ide::InlayKind;

use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &InlayHintParams,
) -> Answer<Option<Vec<InlayHint>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let range = lines.clamped(params.range).ok_or(Stop::Nothing)?;
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
