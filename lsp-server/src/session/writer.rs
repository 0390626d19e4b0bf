//! The writer: one thread that owns the database, the open documents and the configuration.
//!
//! Events arrive in the order of the client's messages. Changes are applied to the documents at
//! once and to the database when the next reader needs it or the queue is empty, so that a burst of
//! typing costs one update. Readers get a snapshot in their turn and work elsewhere.

mod changes;
mod flush;
mod mended;
mod readers;
mod session;
mod settings;
mod verification;

use std::collections::BTreeSet;
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::AnalysisHost;
use rustc_hash::FxHashSet;
use serde_json::Value;
use tokio::sync::mpsc::{UnboundedReceiver, WeakUnboundedSender};
use tokio::sync::{oneshot, watch};

use crate::config::Config;
use crate::files::vfs::Vfs;
use crate::panic;
use crate::protocol::client::ClientCaps;
use crate::protocol::outbox::Outbox;
use crate::protocol::types::*;
use crate::session::capabilities::ForeignDocuments;
use crate::session::dispatch::Read;
use crate::session::post::Post;
use crate::session::publish::{self, Publisher};
use crate::session::verifier::{self, Verifier};
use crate::workspace::codels;

use crate::workspace::documents::Documents;
use crate::workspace::folders::Workspace;
use flush::Pending;
use session::Stale;

pub(crate) use changes::Mutation;

/// Everything that reaches the writer.
pub(crate) enum Event {
    /// `initialize`, typed and as it came.
    Initialize(
        Box<InitializeParams>,
        Value,
        oneshot::Sender<InitializeResult>,
    ),
    /// `initialized`
    Initialized,
    /// Something changed.
    Mutation(Mutation),
    /// Something is asked.
    Read(Read),
    /// Of the computation of diagnostics.
    Diagnostics(publish::News),
    /// Of the verification of open documents.
    Verification(verifier::News),
}

impl From<Read> for Event {
    fn from(it: Read) -> Event {
        Event::Read(it)
    }
}

impl From<publish::News> for Event {
    fn from(it: publish::News) -> Event {
        Event::Diagnostics(it)
    }
}

impl From<verifier::News> for Event {
    fn from(it: verifier::News) -> Event {
        Event::Verification(it)
    }
}

/// See the module.
pub(crate) struct State {
    host: AnalysisHost,
    vfs: Arc<Vfs>,
    documents: Documents,
    workspace: Workspace,
    client: Arc<ClientCaps>,
    config: Arc<Config>,
    roots: Arc<Vec<Utf8PathBuf>>,
    /// Open documents whose text had to be mended.
    mended: FxHashSet<Utf8PathBuf>,
    /// The document edited last.
    active: Option<Utf8PathBuf>,
    /// Files and the roots they are to be shown as included by.
    chosen: Vec<(Utf8PathBuf, Utf8PathBuf)>,
    pending: Pending,
    /// Messages may be sent to the client.
    initialized: bool,
    /// Configuration files that something was said about.
    reported: FxHashSet<Utf8PathBuf>,
    /// What is wrong with the editor's settings.
    settings_problems: BTreeSet<String>,
    revision: u64,
    revisions: watch::Sender<u64>,
    publisher: Publisher,
    verifier: Verifier,
    outbox: Outbox,
    events: WeakUnboundedSender<Event>,
    codels: Arc<codels::Cache>,
    /// Every snapshot has one more of it.
    readers: Arc<()>,
    /// Much was asked since memory was last given back.
    worked: bool,
    /// The documents in other languages that the client was asked to send.
    foreign: ForeignDocuments,
    /// How many times the files of the workspace are being listed.
    listings: usize,
    /// They were listed once.
    listed: bool,
    /// The number of the listing that was asked for last.
    last_listing: u64,
    /// Requests that wait until they are listed.
    waiting: Vec<Read>,
}

impl State {
    /// `events` must not keep the queue alive: the writer ends when the server has gone.
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
            mended: FxHashSet::default(),
            active: None,
            chosen: Vec::new(),
            pending: Pending::default(),
            initialized: false,
            reported: FxHashSet::default(),
            settings_problems: BTreeSet::new(),
            revision: 0,
            revisions,
            publisher: Publisher::default(),
            verifier: Verifier::default(),
            outbox,
            events,
            codels: Arc::default(),
            readers: Arc::default(),
            worked: false,
            foreign: ForeignDocuments::default(),
            listings: 0,
            listed: false,
            last_listing: 0,
            waiting: Vec::new(),
        }
    }

    /// Serves events until the server has gone.
    pub(crate) fn run(mut self, mut events: UnboundedReceiver<Event>) {
        while let Some(event) = events.blocking_recv() {
            self.serve(event);
            while let Ok(event) = events.try_recv() {
                self.serve(event);
            }
            self.guarded(State::flush);
        }
    }

    fn serve(&mut self, event: Event) {
        self.guarded(|state| match event {
            Event::Initialize(params, raw, reply) => {
                // The client may have gone meanwhile.
                let _ = reply.send(state.initialize(&params, &raw));
            }
            Event::Initialized => state.initialized(),
            Event::Mutation(mutation) => state.mutate(mutation),
            Event::Read(read) => state.admit(read),
            Event::Diagnostics(news) => match news {
                publish::News::Due(revision) => state.publish(revision),
                publish::News::Step(run) => state.go_on(*run),
                publish::News::Computed(computed) => {
                    let open = state.documents.open_files();
                    if state.publisher.publish(computed, open, &state.outbox) {
                        state.refresh(Stale::Meaning);
                    }
                }
            },
            Event::Verification(news) => match news {
                verifier::News::Due(revision) => state.verify(revision),
                verifier::News::Wanted(wanted) => {
                    let (settings, post) = (&state.config.verification, Post::new(&state.events));
                    state.verifier.start(wanted, settings, &state.outbox, &post);
                    state.show_verification();
                }
                verifier::News::Verified(it) => {
                    if state.verifier.finish(*it, &state.outbox) {
                        state.show_verification();
                    }
                }
            },
        });
    }

    /// The writer survives whatever one event does to it.
    fn guarded(&mut self, work: impl FnOnce(&mut State)) {
        if let Err(message) = panic::isolate(|| work(self)) {
            tracing::error!("the writer panicked: {message}");
        }
    }
}
