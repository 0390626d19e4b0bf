//! Changes: of documents, files on disk, folders, settings, and the root in which a file is shown.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::language::{self, Language, SCENARIO, SPECIFICATION};
use dotgen_codegen::template::files::SCRIPT;
use serde_json::Value;

use super::State;
use crate::protocol::convert::uri;
use crate::protocol::messages::DocumentText;
use crate::protocol::types::*;
use crate::session::capabilities::is_watched;
use crate::workspace::codels;
use crate::workspace::documents::EditEffect;
use crate::workspace::snapshot::OpenFile;
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
    /// A notification about a document cannot be read: the client's text is unknown.
    Unreadable(Uri),
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
    /// A change of a document, and a panic before the database has it.
    #[cfg(test)]
    Broken(DidChangeTextDocumentParams),
}

impl State {
    pub(super) fn mutate(&mut self, mutation: Mutation) {
        match mutation {
            Mutation::Open(params) => {
                self.reread_without_watchers();
                let document = params.text_document;
                let path = uri::to_path(&document.uri);
                let file = OpenFile {
                    uri: document.uri,
                    version: document.version,
                    language: self.language_of_opened(&path, &document.language_id),
                    is_template_source: document.language_id == templates::LANGUAGE,
                };
                self.documents.open(path.clone(), file, document.text);
                self.publisher.resend_diagnostics(&path);
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
                if self.documents.is_mended(&path) {
                    self.ask_for_text(params.text_document.uri);
                }
                match self.documents.edit(&path, version, params.content_changes, encoding) {
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
            Mutation::Unreadable(uri) => {
                let path = uri::to_path(&uri);
                if self.documents.lose(&path) {
                    tracing::error!(%path, "document dropped until its whole text is sent");
                    self.publisher.clear(&path, &self.outbox);
                    self.touch(path);
                    self.ask_for_text(uri);
                }
            }
            Mutation::SentAgain(uri, sent) => self.receive_text(&uri, sent),
            Mutation::Saved(uri) => {
                self.saved(&uri);
                self.reread_without_watchers();
            }
            Mutation::Close(params) => {
                self.reread_without_watchers();
                let path = uri::to_path(&params.text_document.uri);
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
                self.pending.roots = true;
                for folder in &params.event.removed {
                    let folder = uri::to_path(&folder.uri);
                    let outside = |path: &Utf8Path| !self.workspace.contains(path);
                    self.publisher.clear_below(&folder, outside, &self.documents, &self.outbox);
                }
                self.reconfigure();
                self.pull_settings();
                self.scan();
            }
            Mutation::Choose(file, root) => {
                self.focus.chosen.retain(|entry| entry.0 != file);
                self.focus.chosen.extend(root.map(|root| (file.clone(), root)));
                self.pending.chosen = true;
                self.pending.files.insert(file);
            }
            #[cfg(test)]
            Mutation::Broken(params) => {
                let (path, version) = (uri::to_path(&params.text_document.uri), 2);
                self.documents.edit(&path, version, params.content_changes, self.client.encoding);
                panic!("on purpose");
            }
            Mutation::Scanned(number, files) => {
                // A listing that began before the folders changed contains files of removed folders, and
                // lacks those of new ones.
                let counts = number == self.listings.last;
                if counts {
                    self.set_listed(files);
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
        let language = self.language_of(&path);
        let leads = matches!(language, Language::Specification | Language::Scenario);
        if leads && self.focus.active.as_ref() != Some(&path) {
            self.focus.active = Some(path.clone());
            self.pending.active = true;
        }
        self.pending.files.insert(path);
    }

    /// The language of an open document.
    pub(super) fn language_of(&self, path: &Utf8Path) -> Language {
        let open = self.documents.open_files().get(path);
        open.map_or(Language::Specification, |file| file.language)
    }

    /// The language of a document that is opened.
    fn language_of_opened(&self, path: &Utf8Path, language: &str) -> Language {
        if language == templates::LANGUAGE {
            return Language::Template;
        }
        let is_code = codels::is_code(path, Some(language));
        // Codels in a folder below a template are codels.
        let is_codel = || {
            let home = (self.config.codels_of(path)).and_then(|codel| codels::home(codel, path));
            home.is_some_and(|home| !vfs::specifications_in(&home).is_empty())
        };
        if templates::is_template(&self.workspace.templates, path) && !(is_code && is_codel()) {
            return Language::Template;
        }
        match is_code {
            true => Language::Codel,
            false if language::is_scenario(path) => Language::Scenario,
            false => Language::Specification,
        }
    }

    /// Reads files again that changed on disk, for a client that does not watch files.
    fn reread_without_watchers(&mut self) {
        if !self.client.watched_files {
            self.reread_changed();
        }
    }

    /// Reads files again that changed on disk.
    pub(super) fn reread_changed(&mut self) {
        let changes = self.vfs.changed().into_iter();
        let changes = changes.map(|change| {
            let kind = match (change.existed, change.exists) {
                (false, _) => FileChangeType::CREATED,
                (true, true) => FileChangeType::CHANGED,
                (true, false) => FileChangeType::DELETED,
            };
            (change.path, kind)
        });
        let changes: Vec<_> = changes.collect();
        if !changes.is_empty() {
            tracing::info!(files = changes.len(), "files changed on disk");
            self.changed_on_disk(changes);
        }
    }

    fn watched(&mut self, changes: Vec<FileEvent>) {
        let changes = changes.into_iter().map(|change| (uri::to_path(&change.uri), change.typ));
        self.changed_on_disk(changes.collect());
    }

    fn changed_on_disk(&mut self, changes: Vec<(Utf8PathBuf, FileChangeType)>) {
        let mut matters = false;
        for (path, typ) in changes {
            if typ == FileChangeType::DELETED {
                matters |= self.gone(&path);
            }
            if !is_watched(&path) {
                continue;
            }
            matters = true;
            if path.file_name() == Some(crate::config::FILE_NAME) {
                self.workspace.reload_files(&path);
                self.reconfigure();
                if self.documents.text(&path).is_none() {
                    self.pending.files.insert(path);
                }
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
                Some(SCENARIO) if typ == FileChangeType::DELETED => {
                    Arc::make_mut(&mut self.workspace.scenarios).remove(&path);
                }
                Some(SCENARIO) if self.workspace.contains(&path) => {
                    Arc::make_mut(&mut self.workspace.scenarios).insert(path.clone());
                }
                Some(SPECIFICATION) if typ == FileChangeType::DELETED => {
                    self.pending.roots |= self.workspace.files.remove(&path);
                }
                Some(SPECIFICATION) if self.workspace.contains(&path) => {
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
}
