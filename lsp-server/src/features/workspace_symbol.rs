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
    for it in snapshot.analysis.workspace_symbols(&params.query, LIMIT)? {
        if let Some(location) = snapshot.location(&it.target.path, &it.target.range)? {
            symbols.push(WorkspaceSymbol {
                name: it.name.into(),
                kind: symbol::kind(it.kind),
                tags: None,
                container_name: it.container.map(Into::into),
                location: OneOf::Left(location),
                data: None,
            });
        }
    }
    Ok(symbols)
}
