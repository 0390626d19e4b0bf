//! `textDocument/documentLink`

use dotgen_analysis::host::Cancellable;

use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentLinkParams,
) -> Cancellable<Option<Vec<DocumentLink>>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    let links = snapshot.analysis.document_links(&subject.path)?;
    let convert = links.iter().map(|link| DocumentLink {
        range: lines.range(&link.range),
        target: snapshot.uri(&link.target),
        tooltip: Some(link.target.to_string()),
        data: None,
    });
    Ok(Some(convert.collect()))
}
