//! `textDocument/hover`

use dotgen_analysis::host::Cancellable;
use dotgen_codegen::lang::prototypes as prototypes_of;

use crate::proto::*;
use crate::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &HoverParams,
) -> Cancellable<Option<Hover>> {
    let position = params.text_document_position_params.position;
    if super::scenario::is(&subject.path) {
        return super::scenario::hover(snapshot, subject, position);
    }
    let Some(at) = snapshot.cursor(subject, position)? else {
        return Ok(None);
    };
    let Some(hover) = snapshot.analysis.hover(&at)? else {
        return Ok(None);
    };
    let kind = match snapshot.client.markdown_hover {
        true => MarkupKind::Markdown,
        false => MarkupKind::PlainText,
    };
    let mut markdown = hover.info.markdown;
    for (component, codel) in &hover.info.codels {
        if let Some(prototypes) = prototypes(snapshot, subject, component, codel)? {
            markdown = format!("{markdown}\n\n{prototypes}");
        }
    }
    if let Some(image) = super::diagram::hover_image(snapshot, subject, &at)? {
        markdown = format!("{markdown}\n\n{image}");
    }
    let location = snapshot.location(&at.path, &hover.range)?;
    Ok(Some(Hover {
        contents: HoverContents::Markup(MarkupContent {
            kind,
            value: markdown,
        }),
        range: location.map(|it| it.range),
    }))
}

/// What a codel looks like in C and in C++.
fn prototypes(
    snapshot: &Snapshot,
    subject: &Subject,
    component: &str,
    codel: &str,
) -> Cancellable<Option<String>> {
    let unit = snapshot.analysis.unit(&subject.path)?;
    let mut components = (0..).zip(&unit.spec.components);
    let found = components.find(|(_, it)| it.name.as_str() == component);
    let codel = found.and_then(|(index, component)| {
        let mut codels = component.all_codels().map(|it| component.codel(it));
        Some((index, codels.find(|it| it.name.as_str() == codel)?))
    });
    let Some((index, codel)) = codel else {
        return Ok(None);
    };
    let blocks: Vec<String> = prototypes_of(&unit.spec, index, codel)
        .into_iter()
        .map(|(language, text)| {
            let fence = if language == "c++" { "cpp" } else { language };
            format!("```{fence}\n{text};\n```")
        })
        .collect();
    Ok((!blocks.is_empty()).then(|| blocks.join("\n\n")))
}
