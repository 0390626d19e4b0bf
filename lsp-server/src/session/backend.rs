//! The protocol's methods. Each sends its message to the writer or to the dispatcher before its first
//! `await`, which keeps messages in order.

mod generation;
mod pull;

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use dotgen_analysis::host::Cancellable;
use serde_json::Value;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::sync::watch;

use crate::features::{codels, diagram, verification};
use crate::protocol::messages::DocumentParams;
use crate::protocol::outbox::Outbox;
use crate::protocol::types::*;
use crate::session::dispatch::{Dispatcher, RequestScope};
use crate::session::post::Post;
use crate::session::writer::{Event, Mutation, State};
use crate::workspace::snapshot::{Snapshot, Subject};

/// The state of a session, shared by all methods.
pub(crate) struct Backend {
    pub(crate) dispatch: Dispatcher,
    /// Keeps the writer alive.
    events: UnboundedSender<Event>,
    pub(super) revisions: watch::Receiver<u64>,
    /// True as soon as the client has closed its end.
    pub(super) closed: watch::Receiver<bool>,
    /// Parameters of `initialize` as JSON, before deserialization.
    pub(super) raw_initialize: Arc<OnceLock<Value>>,
    pub(super) shut_down: Arc<AtomicBool>,
    /// Pictures to show while a text has syntax errors.
    last_pictures: Arc<diagram::LastGood>,
    pub(crate) generation: generation::Generation,
}

impl Backend {
    /// Starts the writer. Must be called on the runtime.
    pub(crate) fn new(
        client: Client,
        raw_initialize: Arc<OnceLock<Value>>,
        shut_down: Arc<AtomicBool>,
        closed: watch::Receiver<bool>,
    ) -> Backend {
        let outbox = Outbox::new(client);
        let (events, queue) = unbounded_channel();
        let (revision, revisions) = watch::channel(0);
        let state = {
            let (outbox, events) = (outbox.clone(), events.downgrade());
            move || State::new(outbox, events, revision)
        };
        std::thread::Builder::new()
            .name("writer".to_owned())
            // Deep syntax trees are dropped on this thread.
            .stack_size(32 << 20)
            .spawn(move || state().run(queue))
            .expect("the operating system starts one more thread");
        Backend {
            dispatch: Dispatcher::new(Post::new(&events.downgrade()), outbox),
            events,
            revisions,
            closed,
            raw_initialize,
            shut_down,
            last_pictures: Arc::default(),
            generation: generation::Generation::default(),
        }
    }

    /// Sends an event to the writer.
    pub(super) fn send(&self, event: Event) {
        // Fails only after `exit`.
        let _ = self.events.send(event);
    }

    pub(super) fn mutate(&self, mutation: Mutation) {
        self.send(Event::Mutation(mutation));
    }

    /// Reports that the text of a document came with half of a surrogate pair, which was replaced; see
    /// `transport`.
    pub(crate) fn mended(&self, document: Uri) {
        self.mutate(Mutation::Mended(document));
    }

    /// Reports that a notification about a document cannot be read.
    pub(crate) fn unreadable(&self, document: Uri) {
        self.mutate(Mutation::Unreadable(document));
    }

    /// Changes a document, with a panic before the database has the change.
    #[cfg(test)]
    pub(crate) fn broken(&self, params: DidChangeTextDocumentParams) {
        self.mutate(Mutation::Broken(params));
    }

    /// Waits for a change. False if the client has closed its end.
    async fn changed(&self, revisions: &mut watch::Receiver<u64>) -> bool {
        let mut closed = self.closed.clone();
        tokio::select! {
            changed = revisions.changed() => changed.is_ok(),
            _ = closed.wait_for(|is_closed| *is_closed) => false,
        }
    }

    /// `dotgen/diagram`
    pub(crate) async fn diagram(&self, params: diagram::DiagramParams) -> Result<Option<Value>> {
        let uri = params.text_document.uri.clone();
        let last = self.last_pictures.clone();
        let question = diagram::Question { params, last };
        self.dispatch.document(uri, question, diagram::handle).await
    }

    /// The commands that return a picture as text.
    pub(super) async fn diagram_text(
        &self,
        form: dotgen_views::pictures::Form,
        argument: Value,
    ) -> Result<Option<Value>> {
        let mut params: diagram::DiagramParams = serde_json::from_value(argument)
            .map_err(|error| Error::invalid_params(error.to_string()))?;
        params.format = form;
        let uri = params.text_document.uri.clone();
        let last = self.last_pictures.clone();
        let question = diagram::Question { params, last };
        self.dispatch.document(uri, question, diagram::text).await
    }

    /// `dotgen/verification`
    pub(crate) async fn verification(
        &self,
        params: verification::VerificationParams,
    ) -> Result<Option<Value>> {
        self.verified(params, verification::present).await
    }

    /// `dotgen/trace`
    pub(crate) async fn trace(
        &self,
        params: verification::VerificationParams,
    ) -> Result<Option<verification::TraceResult>> {
        self.verified(params, verification::trace).await
    }

    /// Answers a request about a verification, with a function that makes the answer.
    async fn verified<R: Send + 'static>(
        &self,
        params: verification::VerificationParams,
        show: fn(&Snapshot, &Subject, &verification::Question) -> Cancellable<Option<R>>,
    ) -> Result<Option<R>> {
        let uri = params.text_document.uri.clone();
        let found = self.dispatch.document(uri.clone(), params.clone(), verification::prepare);
        let Some(prepared) = found.await? else {
            return Ok(None);
        };
        // A variation takes long. It runs without a snapshot, because a snapshot would delay edits.
        let question = verification::Question { shown: prepared.answer().await, params };
        self.dispatch.document(uri, question, show).await
    }

    /// `dotgen/sensitivity`
    pub(crate) async fn sensitivity(
        &self,
        params: verification::SensitivityParams,
    ) -> Result<Option<verification::SensitivityResult>> {
        let uri = params.text_document.uri.clone();
        let question = params.verification();
        let found = self.dispatch.document(uri.clone(), question, verification::prepare);
        let Some(prepared) = found.await? else {
            return Ok(None);
        };
        let token = params.work_done_token;
        let asked = verification::ask(prepared, token, self.dispatch.outbox()).await;
        let answer = self.dispatch.document(uri, asked, verification::shown);
        answer.await.map(Some)
    }

    /// `dotgen/exportModel`
    pub(crate) async fn export_model(
        &self,
        params: verification::ExportParams,
    ) -> Result<Option<Value>> {
        let uri = params.text_document.uri.clone();
        match self.dispatch.document(uri, params, verification::to_export).await? {
            Some(model) => model.export().await.map(Some),
            None => Ok(None),
        }
    }

    /// `dotgen/codelHeaders`
    pub(crate) async fn codel_headers(&self, params: DocumentParams) -> Result<Option<Value>> {
        let uri = params.text_document.uri.clone();
        let scope = RequestScope::default();
        let answer = self.dispatch.language(scope, uri, params, |_, snapshot, subject, params| {
            codels::headers::handle(snapshot, subject, params)
        });
        answer.await?.into_response()
    }
}

pub(crate) fn document_of(place: &TextDocumentPositionParams) -> Uri {
    place.text_document.uri.clone()
}

/// Sets the data of an error so that the client asks again for diagnostics that a change cancelled (LSP 3.17,
/// `DiagnosticServerCancellationData`).
pub(super) fn retriggered(mut error: Error) -> Error {
    if error.code == ErrorCode::ContentModified {
        error.code = ErrorCode::ServerError(-32802);
        error.data = Some(serde_json::json!({ "retriggerRequest": true }));
    }
    error
}
