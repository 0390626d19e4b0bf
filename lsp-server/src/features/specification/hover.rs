//! `textDocument/hover`

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::model::system::{System, listed, parts};
use dotgen_analysis::model::{CodelRef, Component, ParamSource};
use dotgen_codegen::lang::{Language, Mapper, NoPlaces};

use crate::features::verification;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &HoverParams,
) -> Answer<Option<Hover>> {
    let position = params.text_document_position_params.position;
    let at = snapshot.at(subject, position)?;
    let hover = snapshot.analysis.hover(&at)?.ok_or(Stop::Nothing)?;
    let mut markdown = hover.info.markdown;
    for (component, codel) in &hover.info.codels {
        if let Some(excluded) = remote_exclusions(snapshot, subject, component, codel)? {
            // The exclusions follow the other facts.
            markdown = format!("{markdown}\n{excluded}");
        }
        if let Some(prototype) = prototype(snapshot, subject, component, codel)? {
            markdown = format!("{markdown}\n\n{prototype}");
        }
    }
    if let Some(verdict) = verification::hover(snapshot, subject, at.offset)? {
        markdown = format!("{markdown}\n\n{verdict}");
    }
    let location = snapshot.location(&at.path, &hover.range)?;
    let range = location.map(|location| location.range);
    Ok(Some(response(snapshot, markdown, range)))
}

/// A hover in the form that the client supports.
pub(crate) fn response(snapshot: &Snapshot, markdown: String, range: Option<Range>) -> Hover {
    let kind =
        if snapshot.client.markdown_hover { MarkupKind::Markdown } else { MarkupKind::PlainText };
    Hover { contents: HoverContents::Markup(MarkupContent { kind, value: markdown }), range }
}

/// Maximum number of codels of other components in a hover.
const MAX_CODELS: usize = 6;

/// The codels of other components that a codel excludes.
fn remote_exclusions(
    snapshot: &Snapshot,
    subject: &Subject,
    component: &str,
    codel: &str,
) -> Cancellable<Option<String>> {
    // Most codels use no port and exclude no codel of another component.
    let unit = snapshot.analysis.unit(&subject.path)?;
    let own = unit.spec.components.iter();
    let own = own.filter(|candidate| candidate.name.as_str() == component);
    let mut params =
        own.flat_map(|component| uses(component, codel).flat_map(|at| &component.codel(at).params));
    if !params.any(|param| matches!(param.source, ParamSource::Port(_))) {
        return Ok(None);
    }
    let units = snapshot.system_units(&subject.path)?;
    let specs = units.iter().map(|unit| &*unit.spec);
    let connections = snapshot.config.connections_of(&subject.path);
    let system = System::new(parts(specs), &connections);
    let Some(part) = system.part(component) else {
        return Ok(None);
    };
    let mut names: Vec<String> = Vec::new();
    for at in uses(system.parts[part].component, codel) {
        for exclusion in system.exclusions(part, at) {
            let name = system.describe(&exclusion);
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    let text = || format!("* excludes in other components {}", listed(&names, MAX_CODELS));
    Ok((!names.is_empty()).then(text))
}

/// The uses of a codel name in a component.
fn uses<'a>(component: &'a Component, codel: &'a str) -> impl Iterator<Item = CodelRef> + 'a {
    let all = component.all_codels();
    all.filter(move |at| component.codel(*at).name.as_str() == codel)
}

/// The prototype of a codel in the language of its component.
fn prototype(
    snapshot: &Snapshot,
    subject: &Subject,
    component: &str,
    codel: &str,
) -> Cancellable<Option<String>> {
    let unit = snapshot.analysis.unit(&subject.path)?;
    let mut components = unit.spec.components.iter_enumerated();
    let found = components.find(|(_, candidate)| candidate.name.as_str() == component);
    let Some((index, component)) = found else {
        return Ok(None);
    };
    let mut codels = component.all_codels().map(|codel| component.codel(codel));
    let Some(codel) = codels.find(|candidate| candidate.name.as_str() == codel) else {
        return Ok(None);
    };
    let language = Language::of(component);
    let fence = if language == Language::Cxx { "cpp" } else { "c" };
    let text = Mapper::new(&unit.spec, &NoPlaces, language).prototype(index, codel, " ");
    Ok(text.ok().map(|text| dotgen_analysis::markdown::block(fence, &format!("{text};"))))
}
