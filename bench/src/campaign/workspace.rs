//! A copy of a workspace with a server over it, and the texts of its open documents.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use super::compare::{Finding, Findings};
use super::sets::{Copy, Set};
use crate::bench::client::Editor;

/// A copy with its server.
pub(super) struct Workspace {
    pub(super) copy: Copy,
    editor: Editor,
    /// Texts of the open documents.
    pub(super) texts: BTreeMap<PathBuf, String>,
    version: i32,
}

impl Workspace {
    /// Copies a set, starts a server and opens all documents.
    pub(super) fn open(dotgen: &Path, set: &Set) -> Result<Workspace> {
        let copy = set.copy()?;
        let capabilities = json!({
            "general": { "positionEncodings": ["utf-8"] },
            "textDocument": {
                "diagnostic": { "relatedInformation": true },
                "codeAction": { "codeActionLiteralSupport": {
                    "codeActionKind": { "valueSet": ["quickfix", "refactor", "source"] } } },
            },
            "workspace": { "workspaceEdit": {
                "documentChanges": true, "resourceOperations": ["create"] } },
        });
        let editor = Editor::start(dotgen, &copy.root, capabilities)?;
        let documents = set.documents(&copy.root);
        let mut out = Workspace { copy, editor, texts: BTreeMap::new(), version: 1 };
        for path in documents {
            // A file in another encoding cannot be compared byte for byte.
            if let Ok(text) = std::fs::read_to_string(&path) {
                out.set(&path, text)?;
            }
        }
        // Answered when all files are known: findings about sources before that are incomplete.
        out.editor.answer("workspace/symbol", json!({ "query": "" }))?;
        Ok(out)
    }

    /// Ends the server.
    pub(super) fn end(self) -> Result<()> {
        self.editor.end()
    }

    /// Gives a document a new text, and opens the document if it is not open.
    pub(super) fn set(&mut self, path: &Path, text: String) -> Result<()> {
        self.version += 1;
        let uri = uri(path);
        if self.texts.contains_key(path) {
            let params = json!({ "textDocument": { "uri": uri, "version": self.version },
                "contentChanges": [{ "text": text }] });
            self.editor.notify("textDocument/didChange", params)?;
        } else {
            let language = match path.extension().and_then(|extension| extension.to_str()) {
                Some("gen" | "idl") => "genom3",
                Some("c" | "h") => "c",
                _ => "cpp",
            };
            let document = json!({ "uri": uri, "languageId": language, "version": self.version,
                "text": text });
            let params = json!({ "textDocument": document });
            self.editor.notify("textDocument/didOpen", params)?;
        }
        self.texts.insert(path.to_owned(), text);
        Ok(())
    }

    /// Writes a file that an edit creates, or changes while it is not open; `None` removes the file.
    pub(super) fn write(&mut self, path: &Path, text: Option<&str>) -> Result<()> {
        let existed = path.exists();
        let kind = match text {
            Some(text) => {
                std::fs::create_dir_all(path.parent().unwrap_or(path))?;
                std::fs::write(path, text)?;
                if existed { 2 } else { 1 }
            }
            None => {
                let removed = std::fs::remove_file(path);
                removed.with_context(|| format!("cannot remove {}", path.display()))?;
                3
            }
        };
        let changes = json!({ "changes": [{ "uri": uri(path), "type": kind }] });
        self.editor.notify("workspace/didChangeWatchedFiles", changes)
    }

    /// The text of a file, open or not.
    pub(super) fn text(&self, path: &Path) -> Option<String> {
        let open = self.texts.get(path).cloned();
        open.or_else(|| std::fs::read_to_string(path).ok())
    }

    /// Findings of all open documents.
    pub(super) fn findings(&mut self) -> Result<Findings> {
        let mut out = Findings::default();
        for path in self.texts.keys() {
            let params = json!({ "textDocument": { "uri": uri(path) } });
            let answer = self.editor.answer("textDocument/diagnostic", params)?.1;
            let items = answer["items"].as_array().into_iter().flatten();
            let findings = items.map(Finding::read).collect();
            out.0.insert(path.clone(), findings);
        }
        Ok(out)
    }

    /// Code actions for a range, in the form of the protocol.
    pub(super) fn actions(
        &mut self,
        path: &Path,
        range: &Value,
        diagnostics: &[Value],
        only: Option<&str>,
    ) -> Result<Vec<Value>> {
        let mut context = json!({ "diagnostics": diagnostics });
        if let Some(only) = only {
            context["only"] = json!([only]);
        }
        let params = json!({ "textDocument": { "uri": uri(path) }, "range": range,
            "context": context });
        let mut answer = self.editor.answer("textDocument/codeAction", params)?.1;
        Ok(match answer.take() {
            Value::Array(actions) => actions,
            _ => Vec::new(),
        })
    }
}

fn uri(path: &Path) -> String {
    format!("file://{}", path.display())
}
