//! `textDocument/semanticTokens/full`, `full/delta` and `range`

use camino::Utf8Path;
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
    let Some(lines) = snapshot.lines(&subject.path)? else {
        return Ok(None);
    };
    Ok(Some(encode(
        &tokens(snapshot, &subject.path, None)?,
        &lines,
    )))
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
    let data = encode(&tokens(snapshot, &subject.path, Some(range))?, &lines);
    Ok(Some(SemanticTokensRangeResult::Tokens(SemanticTokens {
        result_id: None,
        data,
    })))
}

fn tokens(
    snapshot: &Snapshot,
    path: &Utf8Path,
    range: Option<std::ops::Range<usize>>,
) -> Cancellable<Vec<Token>> {
    let mut tokens = snapshot.analysis.semantic_tokens(path, range)?;
    if snapshot.client.augments_syntax_tokens {
        tokens.retain(|token| !token.ty.is_lexical());
    }
    Ok(tokens)
}
