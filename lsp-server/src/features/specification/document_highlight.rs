//! `textDocument/documentHighlight`

use crate::protocol::convert::symbol;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentHighlightParams,
) -> Answer<Option<Vec<DocumentHighlight>>> {
    let position = params.text_document_position_params.position;
    let at = snapshot.at(subject, position)?;
    let lines = snapshot.text_lines(&subject.path)?;
    let highlights = snapshot.analysis.highlights(&at)?;
    let convert = highlights.iter().map(|highlight| DocumentHighlight {
        range: lines.range(&highlight.range),
        kind: Some(symbol::highlight(highlight.access)),
    });
    Ok(Some(convert.collect()))
}
