//! `textDocument/references`

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::FilePosition;

use crate::features::codels::navigation;
use crate::features::mentions;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &ReferenceParams,
) -> Answer<Option<Vec<Location>>> {
    let position = params.text_document_position.position;
    let at = snapshot.at(subject, position)?;
    Ok(of(snapshot, &at, params.context.include_declaration)?)
}

/// The mentions of the declaration at a place of a specification, in specifications, scenarios and sources.
/// The place is the declaration or one of its mentions.
pub(crate) fn of(
    snapshot: &Snapshot,
    at: &FilePosition,
    declaration: bool,
) -> Cancellable<Option<Vec<Location>>> {
    let mut locations = of_specifications(snapshot, at, declaration)?;
    for reference in navigation::references(snapshot, &at.path, at.offset)? {
        locations.extend(snapshot.location(&reference.path, &reference.range)?);
    }
    Ok(Some(locations).filter(|location| !location.is_empty()))
}

/// The mentions in specifications and scenarios only.
pub(crate) fn of_specifications(
    snapshot: &Snapshot,
    at: &FilePosition,
    declaration: bool,
) -> Cancellable<Vec<Location>> {
    let mut locations = Vec::new();
    let references = snapshot.analysis.references(at, declaration)?;
    for reference in references.unwrap_or_default() {
        locations.extend(snapshot.location(&reference.place.path, &reference.place.range)?);
    }
    for (path, range) in mentions::mentions(snapshot, at)? {
        locations.extend(snapshot.location(&path, &range)?);
    }
    Ok(locations)
}
