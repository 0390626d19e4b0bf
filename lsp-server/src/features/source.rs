//! C and C++ sources of codels: the features that dotgen adds to those of the C and C++ server.

use dotgen_analysis::host::Analysis;
use dotgen_analysis::ide::FilePosition;
use dotgen_analysis::source_map::Locations;
use dotgen_codegen::codels::origin::origin;
use dotgen_codegen::codels::returns::{ReturnValue, return_values, written_value};

use super::language::LanguageFeatures;
use crate::features::codels::{self, actions, lenses};
use crate::features::specification::{goto, hover, references};
use crate::protocol::types::{
    CompletionItem, CompletionItemKind, CompletionParams, CompletionResponse, CompletionTextEdit,
    GotoDefinitionParams, GotoDefinitionResponse, Hover, HoverParams, Location, Position, Range,
    ReferenceParams, TextEdit,
};
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

/// The features of sources of codels.
pub(crate) const FEATURES: LanguageFeatures = LanguageFeatures {
    diagnostics: codels::file_diagnostics,
    is_served: |snapshot, path| Ok(!codels::around(snapshot, path)?.is_empty()),
    definition,
    hover,
    references: mentions,
    completion,
    lenses: lenses::handle,
    actions: actions::handle,
    ..LanguageFeatures::NONE
};

/// A name in a source, and the places of its declarations in specifications.
struct DeclaredName {
    range: Option<Range>,
    places: Vec<FilePosition>,
}

/// The declarations of the name at a position of a source.
fn declared(snapshot: &Snapshot, subject: &Subject, position: Position) -> Answer<DeclaredName> {
    let at = snapshot.at(subject, position)?;
    let mut out: Option<DeclaredName> = None;
    for compared in codels::around(snapshot, &at.path)? {
        for folder in compared.folders() {
            for expected in folder.expected() {
                let Some(origin) = origin(&expected, &folder.sources, &at.path, at.offset) else {
                    continue;
                };
                let range =
                    snapshot.location(&at.path, &origin.range)?.map(|location| location.range);
                let places =
                    &mut out.get_or_insert(DeclaredName { range, places: Vec::new() }).places;
                for src in origin.declared {
                    let place = folder.unit.locations.locate(src).map(|location| FilePosition {
                        path: location.path,
                        offset: location.range.end,
                    });
                    places.extend(place.filter(|place| !places.contains(place)));
                }
            }
        }
    }
    out.ok_or(Stop::Nothing)
}

/// `textDocument/definition` in a source: the declaration in the specification.
pub(crate) fn definition(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &GotoDefinitionParams,
) -> Answer<Option<GotoDefinitionResponse>> {
    let position = params.text_document_position_params.position;
    let found = declared(snapshot, subject, position)?;
    let mut links = Vec::new();
    for at in &found.places {
        // The declaration of a codel's parameter is the declaration of the member or port that it passes.
        for link in goto::links(snapshot, at, Analysis::goto_definition)? {
            if !links.contains(&link) {
                links.push(link);
            }
        }
    }
    for link in &mut links {
        link.origin_selection_range = found.range;
    }
    Ok(goto::response(snapshot, links))
}

/// `textDocument/hover` in a source: the hover of the declaration in the specification.
pub(crate) fn hover(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &HoverParams,
) -> Answer<Option<Hover>> {
    let position = params.text_document_position_params.position;
    let found = declared(snapshot, subject, position)?;
    let at = found.places.first().ok_or(Stop::Nothing)?;
    let hover = snapshot.analysis.hover(at)?;
    Ok(hover.map(|hover| hover::response(snapshot, hover.info.markdown, found.range)))
}

/// `textDocument/references` in a source: the mentions in specifications and scenarios.
pub(crate) fn mentions(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &ReferenceParams,
) -> Answer<Option<Vec<Location>>> {
    let position = params.text_document_position.position;
    let found = declared(snapshot, subject, position)?;
    let mut locations: Vec<Location> = Vec::new();
    for at in &found.places {
        for specification in
            references::of_specifications(snapshot, at, params.context.include_declaration)?
        {
            if !locations.contains(&specification) {
                locations.push(specification);
            }
        }
    }
    Ok(Some(locations).filter(|location| !location.is_empty()))
}

/// `textDocument/completion` in a source: after `return`, the values that the codel may return.
fn completion(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &CompletionParams,
) -> Answer<Option<CompletionResponse>> {
    let position = params.text_document_position.position;
    let at = snapshot.at(subject, position)?;
    let lines = snapshot.text_lines(&subject.path)?;
    let written = written_value(lines.text(), at.offset).ok_or(Stop::Nothing)?;
    let mut values: Vec<ReturnValue> = Vec::new();
    for compared in codels::around(snapshot, &at.path)? {
        for folder in compared.folders() {
            for expected in folder.expected() {
                for value in return_values(&expected, &folder.sources, &at.path, at.offset) {
                    if !values.contains(&value) {
                        values.push(value);
                    }
                }
            }
        }
    }
    let range = lines.range(&written);
    let items = (0..).zip(values).map(|(order, value): (u32, ReturnValue)| CompletionItem {
        label: value.text.clone(),
        kind: Some(CompletionItemKind::ENUM_MEMBER),
        detail: Some(value.detail),
        // Before the proposals of the server for C and C++.
        sort_text: Some(format!("!{order:04}")),
        text_edit: Some(CompletionTextEdit::Edit(TextEdit { range, new_text: value.text })),
        ..CompletionItem::default()
    });
    Ok(Some(CompletionResponse::Array(items.collect())))
}
