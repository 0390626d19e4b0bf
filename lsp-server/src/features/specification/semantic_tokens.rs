//! `textDocument/semanticTokens/full` and `range`

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::SemanticToken as Token;

use crate::protocol::convert::semantic_tokens::encode;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn full<P>(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &P,
) -> Cancellable<Option<Vec<SemanticToken>>> {
    let tokens = snapshot.analysis.semantic_tokens(&subject.path, None)?;
    encoded(snapshot, subject, tokens)
}

pub(crate) fn range(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SemanticTokensRangeParams,
) -> Cancellable<Option<SemanticTokensRangeResult>> {
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    let Some(range) = lines.clamped(params.range) else {
        return Ok(None);
    };
    let tokens = (snapshot.analysis).semantic_tokens(&subject.path, Some(range))?;
    let data = encoded(snapshot, subject, tokens)?;
    Ok(data.map(|data| SemanticTokensRangeResult::Tokens(SemanticTokens { result_id: None, data })))
}

/// The tokens of a document as the client wants them, in the form of the protocol.
pub(crate) fn encoded(
    snapshot: &Snapshot,
    subject: &Subject,
    mut tokens: Vec<Token>,
) -> Cancellable<Option<Vec<SemanticToken>>> {
    if snapshot.client.augments_syntax_tokens {
        tokens.retain(|token| !token.ty.is_lexical());
    }
    let lines = snapshot.lines(&subject.path)?;
    Ok(lines.map(|lines| encode(&tokens, &lines)))
}
