//! Changes: of documents, files on disk, folders, settings, and the root in which a file is shown.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::Cancelled;
use dotgen_codegen::template::files::SCRIPT;
use serde_json::Value;

use super::{Event, State};
use crate::protocol::convert::uri;
use crate::protocol::messages::DocumentText;
use crate::protocol::types::*;
use crate::session::capabilities::is_watched;
use crate::workspace::codels;
use crate::workspace::documents::EditEffect;
use crate::workspace::snapshot::{DocumentKind, OpenFile};
use crate::workspace::templates;
use dotgen_platform::files::vfs;

/// Changes, by cause.
pub(crate) enum Mutation {
    /// `didOpen`
    Open(DidOpenTextDocumentParams),
    /// `didChange`
    Change(DidChangeTextDocumentParams),
    /// Half of a surrogate pair in the last change of a document was replaced.
    Mended(Uri),
    /// The client has sent the whole text of such a document.
    SentAgain(Uri, Option<DocumentText>),
    /// `didSave`
    Saved(Uri),
    /// `didClose`
    Close(DidCloseTextDocumentParams),
    /// `didChangeWatchedFiles`
    Watched(DidChangeWatchedFilesParams),
    /// Settings pushed with `didChangeConfiguration`.
    SettingsPushed(Value),
    /// Settings pulled with `workspace/configuration`: first the general ones, then by folder.
    SettingsPulled(Vec<Value>),
    /// `didChangeWorkspaceFolders`
    Folders(DidChangeWorkspaceFoldersParams),
    /// The files of the workspace were listed, for the listing of that number.
    Scanned(u64, Vec<Utf8PathBuf>),
    /// The includes of every root were read; true if that changes a result. `None`: a change has cancelled
    /// it.
    Indexed(Option<bool>),
    /// A file is to be shown as included by a root; `None` lets dotgen choose.
    Choose(Utf8PathBuf, Option<Utf8PathBuf>),
}

impl State {
    pub(super) fn mutate(&mut self, mutation: Mutation) {
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
                self.publisher.resend_diagnostics(&path);
                self.mended.remove(&path);
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
                if self.mended.contains(&path) {
                    self.ask_for_text(params.text_document.uri);
                }
                match self
                    .documents
                    .edit(&path, version, params.content_changes, encoding)
                {
                    EditEffect::Changed => self.touch(path),
                    EditEffect::Lost => {
                        tracing::error!(%path, version, "an edit does not fit; document dropped");
                        self.publisher.clear(&path, &self.outbox);
                        self.touch(path);
                    }
                    EditEffect::Ignored => tracing::warn!(%path, version, "edit ignored"),
                }
            }
            Mutation::Mended(uri) => self.mended(uri),
            Mutation::SentAgain(uri, sent) => self.receive_text(&uri, sent),
            Mutation::Saved(uri) => self.saved(&uri),
            Mutation::Close(params) => {
                let path = uri::to_path(&params.text_document.uri);
                self.mended.remove(&path);
                if self.documents.close(&path) {
                    self.pending.roots = true;
                    self.publisher.forget(&path);
                    self.pending.files.insert(path);
                    self.rest();
                }
            }
            Mutation::Watched(params) => self.watched(params.changes),
            Mutation::SettingsPushed(settings) => {
                // A client that supports pulling sends null here, or a part of the settings.
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
                self.chosen.retain(|entry| entry.0 != file);
                self.chosen.extend(root.map(|root| (file.clone(), root)));
                self.pending.chosen = true;
                self.pending.files.insert(file);
            }
            Mutation::Scanned(number, files) => {
                // A listing that began before the folders changed contains files of removed folders, and
                // lacks those of new ones.
                let counts = number == self.last_listing;
                if counts {
                    // Only requests about the whole workspace wait for the first listing.
                    if !std::mem::replace(&mut self.listed, true) {
                        self.pending.indexed = Some(false);
                    }
                    let configured = self.workspace.set_files(files);
                    self.pending.roots = true;
                    match configured {
                        true => self.reconfigure(),
                        false => self.register_documents(),
                    }
                }
                if !(counts && self.index()) {
                    self.settle_listing();
                }
            }
            Mutation::Indexed(found) => {
                if found.is_some() || !self.index() {
                    self.pending.indexed = Some(true);
                    self.publisher.refresh_wanted |= found.unwrap_or(true);
                    self.settle_listing();
                }
            }
        }
    }

    pub(super) fn touch(&mut self, path: Utf8PathBuf) {
        let is_specification = self.kind_of(&path) == DocumentKind::Specification;
        if is_specification && self.active.as_ref() != Some(&path) {
            self.active = Some(path.clone());
            self.pending.active = true;
        }
        self.pending.files.insert(path);
    }

    /// The kind of an open document.
    pub(super) fn kind_of(&self, path: &Utf8Path) -> DocumentKind {
        let open = self.documents.open_files().get(path);
        open.map_or(DocumentKind::Specification, |file| file.kind)
    }

    /// The kind of a document that is opened.
    fn kind(&self, path: &Utf8Path, language: &str) -> DocumentKind {
        if language == templates::LANGUAGE {
            return DocumentKind::Source;
        }
        let is_code = codels::is_code(path, Some(language));
        // Codels in a folder below a template are codels.
        let is_codel = || {
            let home = (self.config.codels_of(path)).and_then(|codel| codels::home(codel, path));
            home.is_some_and(|home| !vfs::specifications_in(&home).is_empty())
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
        let mut matters = false;
        for change in changes {
            let path = uri::to_path(&change.uri);
            if change.typ == FileChangeType::DELETED {
                matters |= self.gone(&path);
            }
            if !is_watched(&path) {
                continue;
            }
            matters = true;
            if path.file_name() == Some(crate::config::FILE_NAME) {
                self.workspace.reload_files(&path);
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
        self.publisher.refresh_wanted |= matters;
    }

    /// Handles the deletion of a file or folder. Returns true if it was known.
    fn gone(&mut self, path: &Utf8Path) -> bool {
        let mut known = self.host.known_at(path);
        known.retain(|path| self.documents.text(path).is_none());
        let found = self.workspace.remove(path) || !known.is_empty();
        self.pending.roots |= found;
        self.pending.files.extend(known);
        found
    }

    /// Reads the includes of every root on the blocking pool. Returns true if that has begun.
    fn index(&mut self) -> bool {
        let Some(events) = self.events.upgrade() else {
            return false;
        };
        self.flush();
        let analysis = self.host.analysis();
        self.outbox.runtime().spawn_blocking(move || {
            let looked = catch_unwind(AssertUnwindSafe(|| analysis.index()));
            drop(analysis);
            let found = match looked {
                Ok(Ok(found)) => Some(found),
                Ok(Err(Cancelled::PendingWrite)) => None,
                // After a panic, the request for the affected file reports it.
                _ => Some(true),
            };
            let _ = events.send(Event::Mutation(Mutation::Indexed(found)));
        });
        true
    }

    /// Handles the end of a listing: admits the waiting requests.
    fn settle_listing(&mut self) {
        self.listings = self.listings.saturating_sub(1);
        if self.listings == 0 {
            for read in std::mem::take(&mut self.waiting) {
                self.admit(read);
            }
        }
    }

    /// Lists the files of the workspace folders, with progress.
    pub(super) fn scan(&mut self) {
        self.last_listing += 1;
        let number = self.last_listing;
        let folders = self.workspace.scanned_folders();
        let Some(events) = self.events.upgrade().filter(|_| !folders.is_empty()) else {
            return;
        };
        self.listings += 1;
        let wants_progress = self.client.progress;
        self.outbox.run_conversation(move |client| async move {
            let progress =
                crate::protocol::progress::begin(&client, wants_progress, "Indexing").await;
            let listing = tokio::task::spawn_blocking(move || {
                let below =
                    |path: &Utf8PathBuf| vfs::files_below(path, &["gen", "scn", "tcl", "toml"]);
                folders.iter().flat_map(below).collect::<Vec<_>>()
            });
            let files = listing.await.unwrap_or_default();
            let specifications = files.iter().filter(|file| file.extension() == Some("gen"));
            let summary = match specifications.count() {
                1 => "1 specification".to_owned(),
                count => format!("{count} specifications"),
            };
            let _ = events.send(Event::Mutation(Mutation::Scanned(number, files)));
            crate::protocol::progress::end(progress, summary).await;
        });
    }
}
