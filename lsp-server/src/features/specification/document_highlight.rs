//! `textDocument/documentHighlight`

use dotgen_analysis::host::Cancellable;

use crate::protocol::convert::symbol;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &DocumentHighlightParams,
) -> Cancellable<Option<Vec<DocumentHighlight>>> {
    let position = params.text_document_position_params.position;
    let (Some(at), Some(lines)) =
        (snapshot.cursor(subject, position)?, snapshot.lines(&subject.path)?)
    else {
        return Ok(None);
    };
    let highlights = snapshot.analysis.highlights(&at)?;
    let convert = highlights.iter().map(|highlight| DocumentHighlight {
        range: lines.range(&highlight.range),
        kind: Some(symbol::highlight(highlight.access)),
    });
    Ok(Some(convert.collect()))
}
