//! `textDocument/documentSymbol`

use crate::protocol::convert::symbol::{self, Symbol};
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

pub(crate) fn handle(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &DocumentSymbolParams,
) -> Answer<Option<DocumentSymbolResponse>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let symbols = snapshot.analysis.document_symbols(&subject.path)?;
    let symbols = symbols.into_iter().map(Symbol::from);
    let nested = snapshot.client.hierarchical_symbols;
    Ok(Some(symbol::response(symbols, nested, &subject.uri, &lines)))
}
