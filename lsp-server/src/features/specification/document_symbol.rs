//! `textDocument/documentSymbol`

use dotgen_analysis::host::Cancellable;

use crate::protocol::convert::symbol::{self, Symbol};
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentSymbolParams,
) -> Cancellable<Option<DocumentSymbolResponse>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    let symbols = snapshot.analysis.document_symbols(&subject.path)?;
    let symbols = symbols.into_iter().map(Symbol::from);
    let nested = snapshot.client.hierarchical_symbols;
    Ok(Some(symbol::response(symbols, nested, &subject.uri, &lines)))
}
