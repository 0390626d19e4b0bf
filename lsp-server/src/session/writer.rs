//! The writer: one thread that owns the database, the open documents and the configuration.
//!
//! Events arrive in the order of the client's messages. Changes are applied to the documents at once. They
//! are applied to the database when the next reader needs it or the queue is empty, so that a burst of typing
//! costs one update. Each reader gets a snapshot in its turn and works on another thread.

mod changes;
mod flush;
mod listings;
mod readers;
mod session;
mod settings;
mod surrogates;
mod verification;

use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::AnalysisHost;
use serde_json::Value;
use tokio::sync::mpsc::{UnboundedReceiver, WeakUnboundedSender};
use tokio::sync::{oneshot, watch};

use crate::config::Config;
use crate::protocol::client::ClientCaps;
use crate::protocol::outbox::Outbox;
use crate::protocol::types::*;
use crate::session::capabilities::ForeignDocuments;
use crate::session::dispatch::ReadRequest;
use crate::session::post::Post;
use crate::session::publish::{self, Publisher};
use crate::session::verifier::{self, Verifier};
use crate::workspace::codels;
use dotgen_platform::files::vfs::Vfs;
use dotgen_platform::panic;

use crate::workspace::documents::Documents;
use crate::workspace::folders::Workspace;
use flush::Pending;
use listings::Listings;
use readers::Readers;
use session::Stale;
use settings::Reported;

pub(crate) use changes::Mutation;

/// The input of the writer.
pub(crate) enum Event {
    /// `initialize`, as typed parameters and as JSON.
    Initialize(Box<InitializeParams>, Value, oneshot::Sender<InitializeResult>),
    /// `initialized`
    Initialized,
    /// A change.
    Mutation(Mutation),
    ReadRequest(ReadRequest),
    /// A message of the computation of diagnostics.
    Diagnostics(publish::News),
    /// A message of the verification of open documents.
    Verification(verifier::News),
}

impl From<ReadRequest> for Event {
    fn from(request: ReadRequest) -> Event {
        Event::ReadRequest(request)
    }
}

impl From<publish::News> for Event {
    fn from(news: publish::News) -> Event {
        Event::Diagnostics(news)
    }
}

impl From<verifier::News> for Event {
    fn from(news: verifier::News) -> Event {
        Event::Verification(news)
    }
}

/// The document that the user works on, and choices about documents.
#[derive(Default)]
struct Focus {
    /// The last edited document.
    active: Option<Utf8PathBuf>,
    /// Files, and the including roots that the user chose to show them in.
    chosen: Vec<(Utf8PathBuf, Utf8PathBuf)>,
}

/// The state of the session, which only the writer changes.
pub(crate) struct State {
    host: AnalysisHost,
    vfs: Arc<Vfs>,
    documents: Documents,
    workspace: Workspace,
    client: Arc<ClientCaps>,
    config: Arc<Config>,
    roots: Arc<Vec<Utf8PathBuf>>,
    focus: Focus,
    pending: Pending,
    /// True once messages may be sent to the client.
    initialized: bool,
    reported: Reported,
    /// The number of the database's revision.
    revisions: watch::Sender<u64>,
    publisher: Publisher,
    verifier: Verifier,
    outbox: Outbox,
    events: WeakUnboundedSender<Event>,
    codels: Arc<codels::Cache>,
    readers: Readers,
    /// The registered documents in other languages.
    foreign: ForeignDocuments,
    listings: Listings,
}

impl State {
    /// Creates the state. It must not hold a strong sender of `events`: the writer ends when the server has
    /// dropped its sender.
    pub(crate) fn new(
        outbox: Outbox,
        events: WeakUnboundedSender<Event>,
        revisions: watch::Sender<u64>,
    ) -> State {
        let vfs = Arc::new(Vfs::for_editor());
        State {
            host: AnalysisHost::new(vfs.clone()),
            vfs,
            documents: Documents::default(),
            workspace: Workspace::default(),
            client: Arc::default(),
            config: Arc::default(),
            roots: Arc::default(),
            focus: Focus::default(),
            pending: Pending::default(),
            initialized: false,
            reported: Reported::default(),
            revisions,
            publisher: Publisher::default(),
            verifier: Verifier::default(),
            outbox,
            events,
            codels: Arc::default(),
            readers: Readers::default(),
            foreign: ForeignDocuments::default(),
            listings: Listings::default(),
        }
    }

    /// The number of the database's revision.
    fn revision(&self) -> u64 {
        *self.revisions.borrow()
    }

    /// Serves events until the server has ended.
    pub(crate) fn run(mut self, mut events: UnboundedReceiver<Event>) {
        while let Some(event) = events.blocking_recv() {
            self.serve(event);
            while let Ok(event) = events.try_recv() {
                self.serve(event);
            }
            self.isolate_panic(State::flush);
        }
    }

    fn serve(&mut self, event: Event) {
        self.isolate_panic(|state| match event {
            Event::Initialize(params, raw, reply) => {
                // The client may have disconnected.
                let _ = reply.send(state.initialize(&params, &raw));
            }
            Event::Initialized => state.initialized(),
            Event::Mutation(mutation) => state.mutate(mutation),
            Event::ReadRequest(read) => state.admit(read),
            Event::Diagnostics(news) => match news {
                publish::News::Due(revision) => state.publish(revision),
                publish::News::Step(run) => state.continue_run(*run),
                publish::News::Computed(computed) => {
                    let open = state.documents.open_files();
                    if state.publisher.publish(computed, open, &state.outbox) {
                        state.refresh(Stale::Meaning);
                    }
                }
            },
            Event::Verification(news) => match news {
                verifier::News::Due(revision) => state.verify(revision),
                verifier::News::VerificationRequest(wanted) => {
                    let (settings, post) = (&state.config.verification, Post::new(&state.events));
                    state.verifier.start(wanted, settings, &state.outbox, &post);
                    state.show_verification();
                }
                verifier::News::JobResult(job_result) => {
                    if state.verifier.finish(*job_result, &state.outbox) {
                        state.show_verification();
                    }
                }
            },
        });
    }

    /// Serves one event. A panic in it does not end the writer. The change may be half done: the database
    /// gets every file and setting again.
    fn isolate_panic(&mut self, work: impl FnOnce(&mut State)) {
        if let Err(message) = panic::isolate(|| work(self)) {
            tracing::error!("the writer panicked: {message}");
            let open = self.documents.open_files().keys().cloned();
            let files = self.host.known_at("".into()).into_iter().chain(open).collect();
            self.pending = Pending::everything(files, self.listings.is_listed);
        }
    }
}
