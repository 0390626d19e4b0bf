//! `workspace/symbol`

use dotgen_analysis::host::Cancellable;

use crate::protocol::convert::symbol;
use crate::protocol::types::*;
use crate::workspace::snapshot::Snapshot;

/// Maximum number of symbols in an answer.
const LIMIT: usize = 256;

pub(crate) fn handle(
    snapshot: &Snapshot,
    params: &WorkspaceSymbolParams,
) -> Cancellable<Vec<WorkspaceSymbol>> {
    let mut symbols = Vec::new();
    for symbol in snapshot.analysis.workspace_symbols(&params.query, LIMIT)? {
        if let Some(location) = snapshot.location(&symbol.target.path, &symbol.target.range)? {
            symbols.push(WorkspaceSymbol {
                name: symbol.name.into(),
                kind: symbol::kind(symbol.kind),
                tags: None,
                container_name: symbol.container.map(Into::into),
                location: OneOf::Left(location),
                data: None,
            });
        }
    }
    Ok(symbols)
}
