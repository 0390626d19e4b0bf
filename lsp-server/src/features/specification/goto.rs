//! `textDocument/definition`, `declaration`, `typeDefinition` and `implementation`

use dotgen_analysis::host::{Analysis, Cancellable};
use dotgen_analysis::ide::{FilePosition, NavTarget, RangeInfo};

use crate::features::codels::navigation;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

type Targets = Cancellable<Option<RangeInfo<Vec<NavTarget>>>>;

pub(crate) fn definition(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoDefinitionParams,
) -> Answer<Option<GotoDefinitionResponse>> {
    goto(snapshot, subject, params, Analysis::goto_definition)
}

pub(crate) fn declaration(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoDeclarationParams,
) -> Answer<Option<GotoDeclarationResponse>> {
    goto(snapshot, subject, params, Analysis::goto_declaration)
}

pub(crate) fn type_definition(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoTypeDefinitionParams,
) -> Answer<Option<GotoTypeDefinitionResponse>> {
    goto(snapshot, subject, params, Analysis::goto_type_definition)
}

pub(crate) fn implementation(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoImplementationParams,
) -> Answer<Option<GotoImplementationResponse>> {
    let found = goto(snapshot, subject, params, Analysis::goto_implementation)?;
    let position = params.text_document_position_params.position;
    let at = snapshot.at(subject, position)?;
    let mut functions = Vec::new();
    for implementation in navigation::implementations(snapshot, &at.path, at.offset)? {
        functions.extend(snapshot.location(&implementation.path, &implementation.range)?);
    }
    if functions.is_empty() {
        return Ok(found);
    }
    let found = match found {
        Some(GotoDefinitionResponse::Scalar(location)) => vec![location],
        Some(GotoDefinitionResponse::Array(all)) => all,
        Some(GotoDefinitionResponse::Link(all)) => {
            let convert =
                |link: LocationLink| Location::new(link.target_uri, link.target_selection_range);
            all.into_iter().map(convert).collect()
        }
        None => Vec::new(),
    };
    functions.extend(found);
    Ok(Some(GotoDefinitionResponse::Array(functions)))
}

fn goto(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoDefinitionParams,
    question: fn(&Analysis, &FilePosition) -> Targets,
) -> Answer<Option<GotoDefinitionResponse>> {
    let position = params.text_document_position_params.position;
    let at = snapshot.at(subject, position)?;
    Ok(response(snapshot, links(snapshot, &at, question)?))
}

/// The links from a place of a specification that a query of analysis returns.
pub(crate) fn links(
    snapshot: &Snapshot,
    at: &FilePosition,
    question: fn(&Analysis, &FilePosition) -> Targets,
) -> Cancellable<Vec<LocationLink>> {
    let mut links = Vec::new();
    let Some(found) = question(&snapshot.analysis, at)? else {
        return Ok(links);
    };
    let origin = snapshot.location(&at.path, &found.range)?.map(|location| location.range);
    for target in found.info {
        let whole = snapshot.location(&target.path, &target.full_range)?;
        let focus = snapshot.location(&target.path, &target.focus_range)?;
        if let (Some(whole), Some(focus)) = (whole, focus) {
            links.push(LocationLink {
                origin_selection_range: origin,
                target_uri: whole.uri,
                target_range: whole.range,
                target_selection_range: focus.range,
            });
        }
    }
    Ok(links)
}

/// Links in the form that the client supports; `None` without links.
pub(crate) fn response(
    snapshot: &Snapshot,
    links: Vec<LocationLink>,
) -> Option<GotoDefinitionResponse> {
    if links.is_empty() {
        return None;
    }
    Some(if snapshot.client.definition_link {
        GotoDefinitionResponse::Link(links)
    } else {
        GotoDefinitionResponse::Array(
            links
                .into_iter()
                .map(|link| Location::new(link.target_uri, link.target_selection_range))
                .collect(),
        )
    })
}
