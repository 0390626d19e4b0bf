//! Open documents, synchronized with the client.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::protocol::convert::{Encoding, Lines};
use crate::protocol::types::TextDocumentContentChangeEvent;
use crate::workspace::snapshot::OpenFile;

/// The texts of open documents.
#[derive(Default)]
pub(crate) struct Documents {
    texts: FxHashMap<Utf8PathBuf, Text>,
    open: Arc<FxHashMap<Utf8PathBuf, OpenFile>>,
    /// Open documents in which half of a surrogate pair was replaced.
    mended: FxHashSet<Utf8PathBuf>,
}

/// The text of an open document.
enum Text {
    Known(Arc<str>),
    /// The client sent an edit that does not fit; the text is unknown until the client sends it whole.
    Lost,
}

#[derive(Debug, PartialEq, Eq)]
pub(crate) enum EditEffect {
    /// The text has changed.
    Changed,
    /// An edit did not fit: the document is dropped.
    Lost,
    /// The document is not open, or was dropped before.
    Ignored,
}

impl Documents {
    /// Opens a document.
    pub(crate) fn open(&mut self, path: Utf8PathBuf, file: OpenFile, text: String) {
        self.mended.remove(&path);
        self.texts.insert(path.clone(), Text::Known(text.into()));
        Arc::make_mut(&mut self.open).insert(path, file);
    }

    /// Closes a document. Returns true if it was open.
    pub(crate) fn close(&mut self, path: &Utf8Path) -> bool {
        self.mended.remove(path);
        Arc::make_mut(&mut self.open).remove(path);
        self.texts.remove(path).is_some()
    }

    /// Applies the edits of one `didChange`, in order.
    pub(crate) fn edit(
        &mut self,
        path: &Utf8Path,
        version: i32,
        edits: Vec<TextDocumentContentChangeEvent>,
        encoding: Encoding,
    ) -> EditEffect {
        let (Some(text), Some(open)) =
            (self.texts.get_mut(path), Arc::make_mut(&mut self.open).get_mut(path))
        else {
            return EditEffect::Ignored;
        };
        open.version = version;
        let known_before = matches!(text, Text::Known(_));
        for edit in edits {
            match (&*text, edit.range) {
                (_, None) => *text = Text::Known(edit.text.into()),
                (Text::Lost, Some(_)) => {}
                (Text::Known(old), Some(range)) => {
                    let lines = Lines::new(old.clone(), encoding);
                    *text = match lines.bytes(range) {
                        Some(bytes) => {
                            let mut new = String::with_capacity(old.len() + edit.text.len());
                            new.push_str(&old[..bytes.start]);
                            new.push_str(&edit.text);
                            new.push_str(&old[bytes.end..]);
                            Text::Known(new.into())
                        }
                        None => Text::Lost,
                    };
                }
            }
        }
        match text {
            Text::Known(_) => EditEffect::Changed,
            Text::Lost if known_before => EditEffect::Lost,
            Text::Lost => EditEffect::Ignored,
        }
    }

    /// Drops the text of an open document. Returns true if the text was known.
    pub(crate) fn lose(&mut self, path: &Utf8Path) -> bool {
        let Some(text) = self.texts.get_mut(path) else { return false };
        // The saved text, or an answer of the client, restores the document.
        self.mended.insert(path.to_owned());
        matches!(std::mem::replace(text, Text::Lost), Text::Known(_))
    }

    /// The text of an open document.
    pub(crate) fn text(&self, path: &Utf8Path) -> Option<&Arc<str>> {
        match self.texts.get(path) {
            Some(Text::Known(text)) => Some(text),
            _ => None,
        }
    }

    /// True if a document was dropped.
    pub(crate) fn is_lost(&self, path: &Utf8Path) -> bool {
        matches!(self.texts.get(path), Some(Text::Lost))
    }

    /// Records that half of a surrogate pair was replaced in a document. Returns false if that is known.
    pub(crate) fn mend(&mut self, path: Utf8PathBuf) -> bool {
        self.mended.insert(path)
    }

    /// True if half of a surrogate pair was replaced in a document.
    pub(crate) fn is_mended(&self, path: &Utf8Path) -> bool {
        self.mended.contains(path)
    }

    /// Records that a document has the client's text again. Returns true if it was mended.
    pub(crate) fn restored(&mut self, path: &Utf8Path) -> bool {
        self.mended.remove(path)
    }

    /// URIs and versions.
    pub(crate) fn open_files(&self) -> &Arc<FxHashMap<Utf8PathBuf, OpenFile>> {
        &self.open
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::types::{Position, Range};
    use dotgen_analysis::language::Language;

    fn edit(range: Option<(u32, u32, u32, u32)>, text: &str) -> TextDocumentContentChangeEvent {
        TextDocumentContentChangeEvent {
            range: range.map(|(a, b, c, d)| Range::new(Position::new(a, b), Position::new(c, d))),
            range_length: None,
            text: text.to_owned(),
        }
    }

    fn documents(text: &str) -> (Documents, Utf8PathBuf) {
        let mut documents = Documents::default();
        let path = Utf8PathBuf::from("/a.gen");
        let uri = "file:///a.gen".parse().expect("a URI");
        let file = OpenFile {
            uri,
            version: 1,
            language: Language::Specification,
            is_template_source: false,
        };
        documents.open(path.clone(), file, text.to_owned());
        (documents, path)
    }

    #[test]
    fn each_edit_applies_to_the_result_of_the_one_before() {
        let (mut documents, path) = documents("ab\r\n😀c\n");
        let edits = vec![
            edit(Some((1, 2, 1, 3)), "xy"),
            edit(Some((0, 2, 1, 0)), "\n"),
            edit(Some((1, 3, 1, 4)), ""),
        ];
        assert_eq!(documents.edit(&path, 2, edits, Encoding::Utf16), EditEffect::Changed);
        assert_eq!(documents.text(&path).map(|text| &**text), Some("ab\n😀x\n"));
        assert_eq!(documents.open_files()[&path].version, 2);
    }

    #[test]
    fn an_edit_that_does_not_fit_drops_the_document_until_the_whole_text_comes() {
        let (mut documents, path) = documents("ab\n");
        let encoding = Encoding::Utf16;
        let bad = vec![edit(Some((7, 0, 7, 0)), "x")];
        assert_eq!(documents.edit(&path, 2, bad, encoding), EditEffect::Lost);
        let good = vec![edit(Some((0, 0, 0, 0)), "x")];
        assert_eq!(documents.edit(&path, 3, good, encoding), EditEffect::Ignored);
        assert!(documents.is_lost(&path));
        let whole = vec![edit(None, "new")];
        assert_eq!(documents.edit(&path, 4, whole, encoding), EditEffect::Changed);
        assert_eq!(documents.text(&path).map(|text| &**text), Some("new"));
    }
}
