//! `textDocument/references`

use dotgen_analysis::host::Cancellable;

use crate::features::codels::navigation;
use crate::features::scenario;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &ReferenceParams,
) -> Cancellable<Option<Vec<Location>>> {
    let position = params.text_document_position.position;
    let at = match scenario::is(&subject.path) {
        true => scenario::declared_at(snapshot, subject, position)?.map(|it| it.0),
        false => snapshot.cursor(subject, position)?,
    };
    let Some(at) = at else {
        return Ok(None);
    };
    let declaration = params.context.include_declaration;
    let references = match snapshot.is_code(&at.path) {
        true => None,
        false => snapshot.analysis.references(&at, declaration)?,
    };
    let elsewhere = navigation::references(snapshot, &at.path, at.offset)?;
    if references.is_none() && elsewhere.is_empty() {
        return Ok(None);
    }
    let mut locations = Vec::new();
    for it in references.unwrap_or_default() {
        locations.extend(snapshot.location(&it.place.path, &it.place.range)?);
    }
    for (path, range) in scenario::mentions(snapshot, &at)? {
        locations.extend(snapshot.location(&path, &range)?);
    }
    for it in elsewhere {
        locations.extend(snapshot.location(&it.path, &it.range)?);
    }
    Ok(Some(locations))
}
