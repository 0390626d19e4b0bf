//! `textDocument/documentLink`

use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentLinkParams,
) -> Answer<Option<Vec<DocumentLink>>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let links = snapshot.analysis.document_links(&subject.path)?;
    let convert = links.iter().map(|link| DocumentLink {
        range: lines.range(&link.range),
        target: snapshot.uri(&link.target),
        tooltip: Some(link.target.to_string()),
        data: None,
    });
    Ok(Some(convert.collect()))
}
