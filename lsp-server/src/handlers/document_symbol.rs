//! `textDocument/documentSymbol`

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide;

use crate::convert::{Lines, symbol};
use crate::proto::*;
use crate::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentSymbolParams,
) -> Cancellable<Option<DocumentSymbolResponse>> {
    if super::scenario::is(&subject.path) {
        return super::scenario::symbols(snapshot, subject);
    }
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    let symbols = snapshot.analysis.document_symbols(&subject.path)?;
    if snapshot.client.hierarchical_symbols {
        let nested = symbols.into_iter().map(|it| nested(it, &lines)).collect();
        return Ok(Some(DocumentSymbolResponse::Nested(nested)));
    }
    let mut flat = Vec::new();
    for it in symbols {
        flatten(it, None, &subject.uri, &lines, &mut flat);
    }
    Ok(Some(DocumentSymbolResponse::Flat(flat)))
}

fn nested(it: ide::DocumentSymbol, lines: &Lines) -> DocumentSymbol {
    let children = it.children.into_iter().map(|it| nested(it, lines));
    #[allow(deprecated, reason = "the field has to be given")]
    DocumentSymbol {
        children: Some(children.collect()),
        name: it.name,
        detail: it.detail,
        kind: symbol::kind(it.kind),
        tags: None,
        deprecated: None,
        range: lines.range(&it.range),
        selection_range: lines.range(&it.selection_range),
    }
}

fn flatten(
    it: ide::DocumentSymbol,
    container: Option<&str>,
    uri: &Uri,
    lines: &Lines,
    out: &mut Vec<SymbolInformation>,
) {
    #[allow(deprecated, reason = "the field has to be given")]
    out.push(SymbolInformation {
        name: it.name.clone(),
        kind: symbol::kind(it.kind),
        tags: None,
        deprecated: None,
        location: Location::new(uri.clone(), lines.range(&it.range)),
        container_name: container.map(str::to_owned),
    });
    for child in it.children {
        flatten(child, Some(&it.name), uri, lines, out);
    }
}
