//! The writer: one thread that owns the database, the open documents and the configuration.
//!
//! Events arrive in the order of the client's messages. Changes are applied to the documents at
//! once and to the database when the next reader needs it or the queue is empty, so that a burst of
//! typing costs one update. Readers get a snapshot in their turn and work elsewhere.

mod documents;
mod workspace;

use std::collections::BTreeSet;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{AnalysisHost, Change};
use dotgen_codegen::template::files::SCRIPT;
use rustc_hash::FxHashSet;
use serde_json::Value;
use tokio::sync::mpsc::{UnboundedReceiver, WeakUnboundedSender};
use tokio::sync::{oneshot, watch};

use crate::caps::{self, ClientCaps, ForeignDocuments};
use crate::codels;
use crate::config::Config;
use crate::convert::uri;
use crate::dispatch::{Admission, Read};
use crate::outbox::Outbox;
use crate::panic;
use crate::proto::*;
use crate::publish::Publisher;
use crate::snapshot::{DocumentKind, OpenFile, Snapshot, Subject};
use crate::templates;
use crate::verifier::Verifier;
use crate::vfs::{self, Vfs};

use documents::{Documents, Edited};
use workspace::Workspace;

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
    /// It is time to compute diagnostics for this revision.
    PublishDue(u64),
    /// Diagnostics and regions of a file were computed.
    Computed(crate::publish::Computed),
    /// It is time to verify this revision.
    VerifyDue(u64),
    /// What is to be verified was worked out.
    Verify(Vec<crate::verifier::Wanted>),
    /// A verification has ended.
    Verified(Box<crate::verifier::Verified>),
}

/// Changes, by cause.
pub(crate) enum Mutation {
    /// `didOpen`
    Open(DidOpenTextDocumentParams),
    /// `didChange`
    Change(DidChangeTextDocumentParams),
    /// `didClose`
    Close(DidCloseTextDocumentParams),
    /// `didChangeWatchedFiles`
    Watched(DidChangeWatchedFilesParams),
    /// Settings pushed with `didChangeConfiguration`.
    SettingsPushed(Value),
    /// Settings pulled with `workspace/configuration`: for all, then by folder.
    SettingsPulled(Vec<Value>),
    /// `didChangeWorkspaceFolders`
    Folders(DidChangeWorkspaceFoldersParams),
    /// The files of the workspace were listed.
    Scanned(Vec<Utf8PathBuf>),
    /// A file is to be shown as included by a root; `None` lets dotgen choose.
    Choose(Utf8PathBuf, Option<Utf8PathBuf>),
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
    /// The documents in other languages that the client was asked to send.
    foreign: ForeignDocuments,
}

/// What the database does not know yet.
#[derive(Default)]
struct Pending {
    files: FxHashSet<Utf8PathBuf>,
    roots: bool,
    config: bool,
    packages: bool,
    active: bool,
    chosen: bool,
}

impl State {
    /// `events` must not keep the queue alive: the writer ends when the server has gone.
    pub(crate) fn new(
        outbox: Outbox,
        events: WeakUnboundedSender<Event>,
        revisions: watch::Sender<u64>,
    ) -> State {
        let vfs = Arc::new(Vfs::default());
        State {
            host: AnalysisHost::new(vfs.clone()),
            vfs,
            documents: Documents::default(),
            workspace: Workspace::default(),
            client: Arc::default(),
            config: Arc::default(),
            roots: Arc::default(),
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
            foreign: ForeignDocuments::default(),
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
            Event::PublishDue(revision) => state.publish(revision),
            Event::VerifyDue(revision) => state.verify(revision),
            Event::Verify(wanted) => {
                if let Some(events) = state.events.upgrade() {
                    let settings = &state.config.verification;
                    state
                        .verifier
                        .start(wanted, settings, &state.outbox, &events);
                    state.show_verification();
                }
            }
            Event::Verified(it) => {
                if state.verifier.finish(*it, &state.outbox) {
                    state.show_verification();
                }
            }
            Event::Computed(computed) => {
                let open = state.documents.open_files();
                if state.publisher.publish(computed, open, &state.outbox) {
                    state.refresh();
                }
            }
        });
    }

    /// The writer survives whatever one event does to it.
    fn guarded(&mut self, work: impl FnOnce(&mut State)) {
        if let Err(message) = panic::isolate(|| work(self)) {
            tracing::error!("the writer panicked: {message}");
        }
    }

    fn initialize(&mut self, params: &InitializeParams, raw: &Value) -> InitializeResult {
        self.client = Arc::new(ClientCaps::new(params, raw));
        self.settings_problems = self.workspace.initialize(params);
        self.publisher.initialize(&self.client);
        self.verifier.initialize(self.client.verification_status);
        self.reconfigure();
        InitializeResult {
            capabilities: caps::server_capabilities(&self.client),
            server_info: Some(ServerInfo {
                name: "dotgen".to_owned(),
                version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            }),
            offset_encoding: None,
        }
    }

    fn initialized(&mut self) {
        self.initialized = true;
        self.report_problems();
        self.show_settings_problems();
        let registrations = caps::registrations(&self.client);
        if !registrations.is_empty() {
            self.outbox.converse(|client| async move {
                if let Err(error) = client.register_capability(registrations).await {
                    tracing::warn!("the client refused a registration: {error}");
                }
            });
        }
        self.register_documents();
        self.pull_settings();
        self.scan();
    }

    /// Asks the client for sources of codels and files of templates, again when others are wanted.
    fn register_documents(&mut self) {
        if !self.initialized || !self.client.documents_registration {
            return;
        }
        let wanted = ForeignDocuments {
            codels: self.config.codels.as_ref().map(|it| it.folder.clone()),
            templates: self.workspace.templates.globs(),
        };
        if self.foreign == wanted {
            return;
        }
        let before = std::mem::replace(&mut self.foreign, wanted.clone());
        self.outbox.converse(|client| async move {
            let gone = before.unregistrations();
            if !gone.is_empty() {
                let _ = client.unregister_capability(gone).await;
            }
            let new = wanted.registrations();
            if !new.is_empty()
                && let Err(error) = client.register_capability(new).await
            {
                tracing::warn!("the client refused a registration: {error}");
            }
        });
    }

    fn mutate(&mut self, mutation: Mutation) {
        match mutation {
            Mutation::Open(params) => {
                let document = params.text_document;
                let path = uri::to_path(&document.uri);
                let file = OpenFile {
                    uri: document.uri,
                    version: document.version,
                    kind: self.kind(&path, &document.language_id),
                };
                self.documents.open(path.clone(), file, document.text);
                if self.workspace.adopt(&path) {
                    self.reconfigure();
                }
                self.pending.roots = true;
                self.touch(path);
            }
            Mutation::Change(params) => {
                let path = uri::to_path(&params.text_document.uri);
                let version = params.text_document.version;
                let encoding = self.client.encoding;
                match self
                    .documents
                    .edit(&path, version, params.content_changes, encoding)
                {
                    Edited::Changed => self.touch(path),
                    Edited::Lost => {
                        tracing::error!(%path, version, "an edit does not fit; document dropped");
                        self.publisher.clear(&path, &self.outbox);
                        self.touch(path);
                    }
                    Edited::Ignored => tracing::warn!(%path, version, "edit ignored"),
                }
            }
            Mutation::Close(params) => {
                let path = uri::to_path(&params.text_document.uri);
                if self.documents.close(&path) {
                    self.pending.roots = true;
                    self.publisher.forget(&path);
                    self.pending.files.insert(path);
                }
            }
            Mutation::Watched(params) => self.watched(params.changes),
            Mutation::SettingsPushed(settings) => {
                // A client that is asked for settings says null here, or repeats a part of them.
                if self.client.configuration {
                    self.pull_settings();
                } else {
                    self.set_editor_settings(&[settings]);
                }
            }
            Mutation::SettingsPulled(settings) => {
                self.set_editor_settings(&settings);
            }
            Mutation::Folders(params) => {
                self.workspace.change_folders(&params.event);
                self.reconfigure();
                self.pull_settings();
                self.scan();
            }
            Mutation::Choose(file, root) => {
                self.chosen.retain(|it| it.0 != file);
                self.chosen.extend(root.map(|root| (file.clone(), root)));
                self.pending.chosen = true;
                self.pending.files.insert(file);
            }
            Mutation::Scanned(files) => {
                self.workspace.set_files(files);
                self.pending.roots = true;
                self.register_documents();
            }
        }
    }

    fn touch(&mut self, path: Utf8PathBuf) {
        let is_specification = self.kind_of(&path) == DocumentKind::Specification;
        if is_specification && self.active.as_ref() != Some(&path) {
            self.active = Some(path.clone());
            self.pending.active = true;
        }
        self.pending.files.insert(path);
    }

    /// What an open document is.
    fn kind_of(&self, path: &Utf8Path) -> DocumentKind {
        let open = self.documents.open_files().get(path);
        open.map_or(DocumentKind::Specification, |it| it.kind)
    }

    /// What a document is that is being opened.
    fn kind(&self, path: &Utf8Path, language: &str) -> DocumentKind {
        if language == templates::LANGUAGE {
            return DocumentKind::Source;
        }
        let is_code = codels::is_code(path, Some(language));
        // Codels that lie below a template remain codels.
        let is_codel = || {
            let home = (self.config.codels.as_ref()).and_then(|it| codels::home(it, path));
            home.is_some_and(|it| !vfs::specifications_in(&it).is_empty())
        };
        if templates::is_template(&self.workspace.templates, path) && !(is_code && is_codel()) {
            return DocumentKind::Template;
        }
        match is_code {
            true => DocumentKind::Code,
            false => DocumentKind::Specification,
        }
    }

    fn watched(&mut self, changes: Vec<FileEvent>) {
        for change in changes {
            let path = uri::to_path(&change.uri);
            if path.file_name() == Some(crate::config::FILE_NAME) {
                self.workspace.reload_files();
                self.reconfigure();
                continue;
            }
            if path.file_name() == Some(SCRIPT) && self.workspace.contains(&path) {
                let templates = Arc::make_mut(&mut self.workspace.templates);
                if templates.add(&path) {
                    self.register_documents();
                }
            }
            match path.extension() {
                Some("pc") => self.pending.packages = true,
                Some("scn") if change.typ == FileChangeType::DELETED => {
                    Arc::make_mut(&mut self.workspace.scenarios).remove(&path);
                }
                Some("scn") if self.workspace.contains(&path) => {
                    Arc::make_mut(&mut self.workspace.scenarios).insert(path.clone());
                }
                Some("gen") if change.typ == FileChangeType::DELETED => {
                    self.pending.roots |= self.workspace.files.remove(&path);
                }
                Some("gen") if self.workspace.contains(&path) => {
                    self.pending.roots |= self.workspace.files.insert(path.clone());
                }
                _ => {}
            }
            if self.documents.text(&path).is_none() {
                self.pending.files.insert(path);
            }
        }
        self.publisher.refresh_wanted = true;
    }

    fn set_editor_settings(&mut self, settings: &[Value]) {
        let problems = self.workspace.set_editor_settings(settings);
        if self.settings_problems != problems {
            self.settings_problems = problems;
            self.show_settings_problems();
        }
        self.reconfigure();
    }

    fn show_settings_problems(&self) {
        for problem in &self.settings_problems {
            let message = format!("dotgen, editor settings: {problem}");
            self.outbox.show(MessageType::WARNING, message);
        }
    }

    /// Works the configuration out again, and reports what is wrong with its files.
    fn reconfigure(&mut self) {
        let config = self.workspace.config();
        self.pending.packages |= self.vfs.set_packages(&config.packages);
        if *self.config != config {
            self.config = Arc::new(config);
            self.pending.config = true;
            self.publisher.refresh_wanted = true;
        }
        if self.initialized {
            self.report_problems();
        }
        self.register_documents();
    }

    /// Shows what is wrong with configuration files, and takes back what no longer is.
    fn report_problems(&mut self) {
        let problems = self.workspace.problems(self.client.encoding);
        let mut gone = std::mem::take(&mut self.reported);
        for (path, diagnostics) in problems {
            gone.remove(&path);
            self.reported.insert(path.clone());
            self.outbox.publish(&path, diagnostics);
        }
        for path in gone {
            self.outbox.publish(&path, Vec::new());
        }
    }

    /// Asks the client for its settings, if it can be asked.
    fn pull_settings(&self) {
        let Some(events) = self.events.upgrade().filter(|_| self.client.configuration) else {
            return;
        };
        let scopes = std::iter::once(None).chain(self.workspace.folder_uris().map(Some));
        let items = scopes.map(|scope_uri| ConfigurationItem {
            scope_uri,
            section: Some("dotgen".to_owned()),
        });
        let items = items.collect();
        self.outbox.converse(|client| async move {
            match client.configuration(items).await {
                Ok(settings) => {
                    let _ = events.send(Event::Mutation(Mutation::SettingsPulled(settings)));
                }
                Err(error) => tracing::warn!("the client did not send its settings: {error}"),
            }
        });
    }

    /// Lists the files of the workspace folders, with progress.
    fn scan(&self) {
        let folders = self.workspace.scanned_folders();
        let Some(events) = self.events.upgrade().filter(|_| !folders.is_empty()) else {
            return;
        };
        let wants_progress = self.client.progress;
        self.outbox.converse(move |client| async move {
            let progress = crate::progress::begin(&client, wants_progress, "Indexing").await;
            let listing = tokio::task::spawn_blocking(move || {
                let below = |it: &Utf8PathBuf| vfs::files_below(it, &["gen", "scn", "tcl"]);
                folders.iter().flat_map(below).collect::<Vec<_>>()
            });
            let files = listing.await.unwrap_or_default();
            let specifications = files.iter().filter(|it| it.extension() == Some("gen"));
            let summary = match specifications.count() {
                1 => "1 specification".to_owned(),
                count => format!("{count} specifications"),
            };
            let _ = events.send(Event::Mutation(Mutation::Scanned(files)));
            crate::progress::end(progress, summary).await;
        });
    }

    /// Brings the database up to date.
    fn flush(&mut self) {
        let pending = std::mem::take(&mut self.pending);
        if !(pending.roots || pending.config || pending.packages || !pending.files.is_empty()) {
            return;
        }
        if pending.roots {
            let open = self.documents.open_files().keys();
            let open = open.filter(|it| {
                !self.documents.is_lost(it)
                    && it.extension() != Some(crate::verification::problem::EXTENSION)
                    && !self.kind_of(it).is_template()
            });
            let (code, open): (Vec<_>, Vec<_>) =
                open.partition(|it| self.kind_of(it) == DocumentKind::Code);
            let mut roots: Vec<_> = self.workspace.files.iter().chain(open).cloned().collect();
            // Without a folder that is searched, a source still finds its specification.
            let homes = self.config.codels.iter().flat_map(|config| {
                let home = |it: &&Utf8PathBuf| codels::home(config, it);
                code.iter().filter_map(home)
            });
            roots.extend(homes.flat_map(|it| vfs::specifications_in(&it)));
            roots.sort();
            roots.dedup();
            self.roots = Arc::new(roots);
        }
        let touched: Vec<Utf8PathBuf> = pending.files.iter().cloned().collect();
        if self.verifier.touched(&touched, &self.outbox) {
            self.show_verification();
        }
        let text = |path: &Utf8Path| match self.documents.text(path) {
            Some(text) => Some(text.to_string()),
            // Nothing true can be said about a document that is out of step.
            None => self.documents.is_lost(path).then(String::new),
        };
        let files = pending.files.into_iter().map(|it| (text(&it), it));
        let change = Change {
            files: files.map(|(text, path)| (path, text)).collect(),
            roots: pending.roots.then(|| self.roots.to_vec()),
            active: self.active.clone().filter(|_| pending.active),
            chosen: pending.chosen.then(|| self.chosen.clone()),
            config: pending.config.then(|| self.config.for_analysis()),
            reload_packages: pending.packages,
        };
        {
            let _span = tracing::debug_span!("apply", files = change.files.len()).entered();
            self.host.apply(change);
        }
        self.revision += 1;
        self.revisions.send_replace(self.revision);
        self.publisher
            .changed(self.revision, &self.outbox, &self.events);
        self.schedule_verification();
        if std::mem::take(&mut self.publisher.refresh_wanted) {
            self.refresh();
        }
    }

    /// Verifies after a pause.
    fn schedule_verification(&mut self) {
        if !self.config.verification.on_edit() {
            if self.verifier.stop() {
                self.show_verification();
            }
            return;
        }
        let (events, revision) = (self.events.clone(), self.revision);
        self.outbox.runtime().spawn(async move {
            tokio::time::sleep(crate::verifier::DEBOUNCE).await;
            if let Some(events) = events.upgrade() {
                let _ = events.send(Event::VerifyDue(revision));
            }
        });
    }

    /// Works out on the blocking pool what is to be verified.
    fn verify(&mut self, revision: u64) {
        self.flush();
        let Some(events) = self.events.upgrade().filter(|_| revision == self.revision) else {
            return;
        };
        let snapshot = self.snapshot();
        self.outbox.runtime().spawn_blocking(move || {
            let wanted = panic::isolate(|| crate::verifier::wanted(&snapshot));
            drop(snapshot);
            match wanted {
                Ok(Ok(wanted)) => {
                    let _ = events.send(Event::Verify(wanted));
                }
                // A change came in between: it has scheduled the next run.
                Ok(Err(_)) => {}
                Err(message) => tracing::error!("verification panicked: {message}"),
            }
        });
    }

    /// What verification has to say has changed: diagnostics, lenses.
    fn show_verification(&mut self) {
        self.publisher
            .changed(self.revision, &self.outbox, &self.events);
        let diagnostics = self.client.pull_diagnostics && self.client.diagnostic_refresh;
        let lenses = self.client.code_lens_refresh;
        self.outbox.converse(move |client| async move {
            if diagnostics {
                let _ = client.workspace_diagnostic_refresh().await;
            }
            if lenses {
                let _ = client.code_lens_refresh().await;
            }
        });
    }

    /// Asks the client to ask again: something else than the open document has changed.
    fn refresh(&self) {
        let diagnostics = self.client.pull_diagnostics && self.client.diagnostic_refresh;
        let tokens = self.client.semantic_tokens_refresh;
        let lenses = self.client.code_lens_refresh;
        self.outbox.converse(move |client| async move {
            // A client that refuses shows what it has until the next edit.
            if diagnostics {
                let _ = client.workspace_diagnostic_refresh().await;
            }
            if tokens {
                let _ = client.semantic_tokens_refresh().await;
            }
            if lenses {
                let _ = client.code_lens_refresh().await;
            }
        });
    }

    fn snapshot(&self) -> Snapshot {
        let mut snapshot = Snapshot::new(
            self.host.analysis(),
            self.documents.open_files().clone(),
            self.roots.clone(),
            Arc::new(self.workspace.scanned_folders()),
            self.config.clone(),
            self.client.clone(),
            self.revision,
            self.vfs.clone(),
            self.codels.clone(),
        );
        snapshot.verification = self.verifier.results().clone();
        snapshot.scenarios = self.workspace.scenarios.clone();
        snapshot.templates = self.workspace.templates.clone();
        snapshot
    }

    /// Admits a request in its turn and sends it to the blocking pool.
    fn admit(&mut self, read: Read) {
        if read.control.is_cancelled() {
            return;
        }
        let subject = read.subject.map(|uri| {
            let path = uri::to_path(&uri);
            let version = self.documents.open_files().get(&path).map(|it| it.version);
            Subject { path, uri, version }
        });
        if let Some(subject) = &subject {
            let unknown = match subject.version {
                Some(_) => self.documents.is_lost(&subject.path),
                None => !subject.path.is_file(),
            };
            // What is said of C and C++ is said by few; of templates, by none.
            let kind = self.kind_of(&subject.path);
            let unserved = kind.is_template() || !read.code && kind == DocumentKind::Code;
            if unknown || unserved {
                return (read.work)(Admission::UnknownDocument);
            }
            if read.expected.is_some_and(|it| it != subject.version) {
                return (read.work)(Admission::Outdated);
            }
        }
        self.flush();
        let snapshot = self.snapshot();
        read.control.attach(snapshot.analysis.cancellation_token());
        let work = read.work;
        self.outbox
            .runtime()
            .spawn_blocking(move || work(Admission::Admitted(Box::new(snapshot), subject)));
    }

    fn publish(&mut self, revision: u64) {
        self.flush();
        if self.publisher.is_due(revision, self.revision)
            && let Some(events) = self.events.upgrade()
        {
            let snapshot = self.snapshot();
            self.publisher
                .compute(snapshot, events, self.outbox.runtime());
        }
    }
}
