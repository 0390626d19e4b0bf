//! `textDocument/semanticTokens/full` and `range`

use dotgen_analysis::ide::SemanticToken as Token;

use crate::protocol::convert::semantic_tokens::encode;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot, Stop, Subject};

pub(crate) fn full(
    snapshot: &Snapshot,
    subject: &Subject,
    _: &SemanticTokensParams,
) -> Answer<Option<SemanticTokensResult>> {
    let tokens = snapshot.analysis.semantic_tokens(&subject.path, None)?;
    encoded(snapshot, subject, tokens)
}

pub(crate) fn range(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &SemanticTokensRangeParams,
) -> Answer<Option<SemanticTokensRangeResult>> {
    let lines = snapshot.text_lines(&subject.path)?;
    let range = lines.clamped(params.range).ok_or(Stop::Nothing)?;
    let tokens = (snapshot.analysis).semantic_tokens(&subject.path, Some(range))?;
    encoded(snapshot, subject, tokens)
}

/// The tokens of a document as the client wants them, in the form of the protocol.
pub(crate) fn encoded<R: From<SemanticTokens>>(
    snapshot: &Snapshot,
    subject: &Subject,
    mut tokens: Vec<Token>,
) -> Answer<Option<R>> {
    if snapshot.client.augments_syntax_tokens {
        tokens.retain(|token| !token.ty.is_lexical());
    }
    let data = encode(&tokens, &*snapshot.text_lines(&subject.path)?);
    Ok(Some(SemanticTokens { result_id: None, data }.into()))
}
