//! `textDocument/semanticTokens/full` and `range`

use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::SemanticToken as Token;

use crate::protocol::convert::semantic_tokens::encode;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

pub(crate) fn full(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &SemanticTokensParams,
) -> Cancellable<Option<SemanticTokensResult>> {
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
    encoded(snapshot, subject, tokens)
}

/// The tokens of a document as the client wants them, in the form of the protocol.
pub(crate) fn encoded<R: From<SemanticTokens>>(
    snapshot: &Snapshot,
    subject: &Subject,
    mut tokens: Vec<Token>,
) -> Cancellable<Option<R>> {
    if snapshot.client.augments_syntax_tokens {
        tokens.retain(|token| !token.ty.is_lexical());
    }
    let data = snapshot.lines(&subject.path)?.map(|lines| encode(&tokens, &lines));
    Ok(data.map(|data| SemanticTokens { result_id: None, data }.into()))
}
