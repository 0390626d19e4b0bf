//! Documents with half of a surrogate pair, which is not valid text.
//!
//! An edit that splits a surrogate pair leaves `\ud83d` alone, and the next edit may add the other half. The
//! server stores U+FFFD for each half, at the right place. Only the client knows the character that both make
//! together. The server asks the client for the text. A client that cannot answer provides the text when it
//! saves the file.

use super::{Event, Mutation, State};
use crate::protocol::convert::uri;
use crate::protocol::messages::{DocumentText, DocumentTextRequest};
use crate::protocol::types::{TextDocumentContentChangeEvent, TextDocumentIdentifier, Uri};
use dotgen_analysis::host::FileContent;
use dotgen_platform::files::vfs;

impl State {
    /// Handles a replacement in the last change of a document.
    pub(super) fn mended(&mut self, uri: Uri) {
        let path = uri::to_path(&uri);
        // If the document is already marked, the change itself has asked for the text.
        if self.documents.open_files().contains_key(&path) && self.documents.mend(path) {
            self.ask_for_text(uri);
        }
    }

    /// Asks the client for the whole text of a document.
    pub(super) fn ask_for_text(&mut self, uri: Uri) {
        let Some(events) = self.events.upgrade().filter(|_| self.client.document_text) else {
            return;
        };
        self.outbox.run_conversation(move |client| async move {
            let params = TextDocumentIdentifier { uri: uri.clone() };
            let sent = client.send_request::<DocumentTextRequest>(params).await;
            let sent = sent.unwrap_or_else(|error| {
                tracing::warn!("the client does not send the text again: {error}");
                None
            });
            // Fails only after `exit`.
            let _ = events.send(Event::Mutation(Mutation::SentAgain(uri, sent)));
        });
    }

    /// Handles the client's whole text. The text is used if it belongs to the last change that arrived;
    /// otherwise the next change asks again.
    pub(super) fn receive_text(&mut self, uri: &Uri, sent: Option<DocumentText>) {
        let path = uri::to_path(uri);
        let open = self.documents.open_files().get(&path);
        let Some(sent) = sent.filter(|sent| open.is_some_and(|open| open.version == sent.version))
        else {
            return;
        };
        self.documents.restored(&path);
        self.replace_text(&path, sent.version, sent.text);
    }

    /// Uses the saved text.
    pub(super) fn saved(&mut self, uri: &Uri) {
        let path = uri::to_path(uri);
        if !self.documents.restored(&path) {
            return;
        }
        let version = self.documents.open_files().get(&path).map(|file| file.version);
        if let (Some(version), FileContent::Text(text)) = (version, vfs::read(&path)) {
            self.replace_text(&path, version, text);
        }
    }

    fn replace_text(&mut self, path: &camino::Utf8Path, version: i32, text: String) {
        let edit = TextDocumentContentChangeEvent { range: None, range_length: None, text };
        let encoding = self.client.encoding;
        self.documents.edit(path, version, vec![edit], encoding);
        self.touch(path.to_owned());
    }
}
