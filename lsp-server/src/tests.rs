//! Tests of the server over its protocol: JSON through an in-memory pipe, with a client that fails on
//! unexpected messages. No test sleeps; each waits for messages.

mod client;
mod clients;
mod codels;
mod component;
mod configuration;
mod diagnostics;
mod editing;
mod export;
mod features;
mod generate;
mod harmless;
mod lifecycle;

mod ordering;
mod pictures;
mod random;
mod runs;
mod scenario;
mod system;
mod templates;
mod verification;
mod why;

use dotgen_analysis::host::Cancellable;
use tower_lsp::LspServiceBuilder;

use crate::protocol::messages::DocumentParams;
use crate::protocol::types::{DidChangeTextDocumentParams, Result};
use crate::session::backend::Backend;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Requests for tests, with behaviour that no real request has.
pub(crate) fn custom_methods(builder: LspServiceBuilder<Backend>) -> LspServiceBuilder<Backend> {
    builder
        .custom_method("test/text", Backend::test_text)
        .custom_method("test/panic", Backend::test_panic)
        .custom_method("test/broken", Backend::test_broken)
        .custom_method("test/forever", Backend::test_forever)
        .custom_method("test/second", Backend::test_second)
        .custom_method("test/everywhere", Backend::test_everywhere)
}

impl Backend {
    /// The text of a document in analysis.
    async fn test_text(&self, params: DocumentParams) -> Result<Option<String>> {
        fn handle(
            snapshot: &Snapshot,
            subject: &Subject,
            _: &DocumentParams,
        ) -> Cancellable<Option<String>> {
            let text = snapshot.analysis.text(&subject.path)?;
            Ok(text.map(|text| text.to_string()))
        }
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, handle).await
    }

    async fn test_panic(&self, params: DocumentParams) -> Result<()> {
        fn handle(_: &Snapshot, _: &Subject, _: &DocumentParams) -> Cancellable<()> {
            panic!("on purpose")
        }
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, handle).await
    }

    /// A panic in the writer, in the middle of a change.
    #[expect(clippy::unused_async, reason = "the library calls handlers that are asynchronous")]
    async fn test_broken(&self, params: DidChangeTextDocumentParams) {
        self.broken(params);
    }

    /// Works until it is cancelled.
    async fn test_forever(&self, params: DocumentParams) -> Result<()> {
        fn handle(snapshot: &Snapshot, subject: &Subject, _: &DocumentParams) -> Cancellable<()> {
            loop {
                snapshot.analysis.line_index(&subject.path)?;
                std::thread::yield_now();
            }
        }
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, handle).await
    }

    /// Does a quarter of its work, and would do the rest only if it were not cancelled, which never happens.
    async fn test_everywhere(&self, params: DocumentParams) -> Result<()> {
        fn handle(
            snapshot: &Snapshot,
            subject: Option<&Subject>,
            _: &DocumentParams,
        ) -> Cancellable<()> {
            snapshot.progress.expect(4);
            snapshot.progress.step();
            loop {
                if let Some(subject) = subject {
                    snapshot.analysis.line_index(&subject.path)?;
                }
                std::thread::yield_now();
            }
        }
        let uri = params.text_document.uri.clone();
        let uri = Some(uri);
        self.dispatch.everywhere("Testing", uri, params, handle).await
    }

    /// While some document has its first version: works until it is cancelled.
    async fn test_second(&self, params: DocumentParams) -> Result<bool> {
        fn handle(snapshot: &Snapshot, subject: &Subject, _: &DocumentParams) -> Cancellable<bool> {
            while snapshot.open.values().any(|file| file.version == 1) {
                snapshot.analysis.line_index(&subject.path)?;
                std::thread::yield_now();
            }
            Ok(true)
        }
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, handle).await
    }
}
