//! `workspace/diagnostic`, file by file: open files first, in parts, so that changes and other requests run
//! in between.

use std::collections::VecDeque;
use std::sync::Arc;

use camino::Utf8PathBuf;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{Backend, retriggered};
use crate::features::diagnostics::{self, Listing, Part};
use crate::protocol::convert::uri;
use crate::protocol::messages::{PartialDiagnostics, PartialDiagnosticsParams};
use crate::protocol::types::*;
use crate::session::dispatch::RequestScope;

/// Files of one part.
const BATCH: usize = 32;

impl Backend {
    /// Answers `workspace/diagnostic`. A client that supports partial results gets each part when it is
    /// ready, and a part that a change cancelled again. Other clients get one answer.
    pub(in crate::session) async fn diagnose(
        &self,
        params: WorkspaceDiagnosticParams,
    ) -> Result<WorkspaceDiagnosticReport> {
        let token = params.partial_result_params.partial_result_token;
        // A client that has results asks again at once. That request waits for a change.
        let has_results = !params.previous_result_ids.is_empty();
        let mut known: FxHashMap<Utf8PathBuf, PreviousResultId> = FxHashMap::default();
        for previous_result_id in params.previous_result_ids {
            known.insert(uri::to_path(&previous_result_id.uri), previous_result_id);
        }
        let mut revisions = self.revisions.clone();
        let mut told = false;
        loop {
            revisions.mark_unchanged();
            let Listing { open, rest } = self.listing().await?;
            let mut queue: VecDeque<Utf8PathBuf> = open.into_iter().chain(rest).collect();
            let there: FxHashSet<&Utf8PathBuf> = queue.iter().collect();
            let gone = known.extract_if(|path, _| !there.contains(path));
            let mut items: Vec<_> = gone.map(|(_, known)| diagnostics::gone(known)).collect();
            while !queue.is_empty() || !items.is_empty() && token.is_some() {
                let paths = queue.drain(..BATCH.min(queue.len())).collect();
                let ids = known.iter().map(|(path, id)| (path.clone(), id.value.clone()));
                let part = Part { paths, known: Arc::new(ids.collect()) };
                let reports = self.dispatch.anywhere(RequestScope::BULK, part, diagnostics::part);
                items.extend(reports.await.map_err(retriggered)?);
                let Some(token) = &token else { continue };
                let mut news = std::mem::take(&mut items);
                news.retain(|news| !diagnostics::is_unchanged(news));
                for news in &news {
                    if let WorkspaceDocumentDiagnosticReport::Full(report) = news
                        && let Some(value) =
                            report.full_document_diagnostic_report.result_id.clone()
                    {
                        let uri = report.uri.clone();
                        known.insert(uri::to_path(&uri), PreviousResultId { uri, value });
                    }
                }
                if !news.is_empty() {
                    told = true;
                    let value = WorkspaceDiagnosticReport { items: news };
                    let token = token.clone();
                    let part = PartialDiagnosticsParams { token, value };
                    // Sent before the answer, outside the order of other notifications.
                    let client = self.dispatch.client();
                    client.send_notification::<PartialDiagnostics>(part).await;
                }
                if revisions.has_changed().unwrap_or(false) {
                    revisions.mark_unchanged();
                    // The results may be out of date now. These files come last, except open ones, so that
                    // the other files are reached however fast the user types.
                    let left: FxHashSet<Utf8PathBuf> = queue.drain(..).collect();
                    let Listing { open, rest } = self.listing().await?;
                    let (left, done): (Vec<_>, Vec<_>) =
                        rest.into_iter().partition(|path| left.contains(path));
                    queue.extend(open.into_iter().chain(left).chain(done));
                }
            }
            let news = told || items.iter().any(|report| !diagnostics::is_unchanged(report));
            if news || !has_results || !self.changed(&mut revisions).await {
                return Ok(WorkspaceDiagnosticReport { items });
            }
        }
    }

    async fn listing(&self) -> Result<Listing> {
        let listing = self.dispatch.anywhere(RequestScope::BULK, (), diagnostics::listing);
        listing.await.map_err(retriggered)
    }
}
