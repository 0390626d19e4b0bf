//! The semantic tokens of the client, from which deltas are computed.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::protocol::convert::semantic_tokens::delta;
use crate::protocol::types::*;

/// The last tokens sent for each document, for deltas.
#[derive(Default)]
pub(in crate::session) struct TokenResults {
    next: AtomicU64,
    last: Mutex<VecDeque<(Uri, SemanticTokens)>>,
}

impl TokenResults {
    /// Maximum number of stored documents; tokens of other documents are sent whole.
    const CAPACITY: usize = 64;

    pub(in crate::session) fn remember(
        &self,
        uri: Uri,
        data: Vec<SemanticToken>,
    ) -> SemanticTokens {
        let id = self.next.fetch_add(1, Ordering::Relaxed);
        let tokens = SemanticTokens { result_id: Some(id.to_string()), data };
        self.forget(&uri);
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.push_back((uri, tokens.clone()));
        if last.len() > TokenResults::CAPACITY {
            last.pop_front();
        }
        tokens
    }

    /// The changes since the result `known`, or all tokens if that result is not stored.
    pub(in crate::session) fn remember_changes(
        &self,
        uri: Uri,
        known: Option<Vec<SemanticToken>>,
        data: Vec<SemanticToken>,
    ) -> SemanticTokensFullDeltaResult {
        let edits = known.map(|known| delta(&known, &data));
        let tokens = self.remember(uri, data);
        match edits {
            Some(edits) => SemanticTokensDelta { result_id: tokens.result_id, edits }.into(),
            None => tokens.into(),
        }
    }

    pub(in crate::session) fn recall(
        &self,
        uri: &Uri,
        result_id: &str,
    ) -> Option<Vec<SemanticToken>> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let (_, tokens) = last.iter().find(|entry| entry.0 == *uri)?;
        (tokens.result_id.as_deref() == Some(result_id)).then(|| tokens.data.clone())
    }

    pub(in crate::session) fn forget(&self, uri: &Uri) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.retain(|entry| entry.0 != *uri);
    }
}
