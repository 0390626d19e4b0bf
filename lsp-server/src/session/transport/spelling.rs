//! One URI for each file, in the spelling of the client.
//!
//! `file:///a+b.gen` and `file:///a%2Bb.gen` are one file. The server uses paths and has its own spelling of
//! URIs. This module changes every outgoing URI to the spelling that the client used for the file, or for its
//! folder. Editors store diagnostics by spelling, so two spellings would give two sets of diagnostics.

use camino::{Utf8Path, Utf8PathBuf};
use rustc_hash::FxHashMap;
use serde_json::{Value, json};

use crate::protocol::convert::uri;
use crate::protocol::types::Uri;

/// Fields whose value is a URI.
const FIELDS: [&str; 6] = ["uri", "targetUri", "oldUri", "newUri", "scopeUri", "baseUri"];

const PUBLISH: &str = "textDocument/publishDiagnostics";

/// The spellings of the client.
#[derive(Debug, Default)]
pub(super) struct Spelling {
    files: FxHashMap<Utf8PathBuf, String>,
    folders: FxHashMap<Utf8PathBuf, String>,
    /// Documents that are not files and whose URI had to be escaped, by the escaped URI.
    others: FxHashMap<String, String>,
    /// Files with diagnostics at the client, and the URI under which they were sent.
    published: FxHashMap<Utf8PathBuf, String>,
}

impl Spelling {
    /// Stores the URIs of a message of the client.
    pub(super) fn store_uris(&mut self, method: &str, params: &Value) {
        match method {
            "initialize" => {
                self.store_folder(&params["rootUri"]);
                self.store_folders(&params["workspaceFolders"]);
            }
            "workspace/didChangeWorkspaceFolders" => {
                self.store_folders(&params["event"]["added"]);
            }
            "textDocument/didOpen" => {
                let uri = &params["textDocument"]["uri"];
                if let Some((path, text)) = file(uri) {
                    self.files.insert(path, text.to_owned());
                } else if let Some(text) = uri.as_str()
                    && let Some(escaped) = uri::escaped(text)
                {
                    self.others.insert(escaped, text.to_owned());
                }
            }
            _ => {}
        }
    }

    fn store_folders(&mut self, folders: &Value) {
        for folder in folders.as_array().into_iter().flatten() {
            self.store_folder(&folder["uri"]);
        }
    }

    fn store_folder(&mut self, folder: &Value) {
        if let Some((path, text)) = file(folder) {
            let text = text.trim_end_matches('/').to_owned();
            self.folders.insert(path, text);
        }
    }

    /// Changes a message to the client to its spelling. Returns a message to send before, which clears
    /// diagnostics under another spelling.
    pub(super) fn apply(&mut self, message: &mut Value) -> Option<Value> {
        if !(self.files.is_empty() && self.folders.is_empty() && self.others.is_empty()) {
            for part in ["params", "result"] {
                if let Some(part) = message.get_mut(part) {
                    self.rewrite(part);
                }
            }
        }
        if message["method"] != PUBLISH {
            return None;
        }
        let params = &message["params"];
        let (path, text) = file(&params["uri"])?;
        let empty = params["diagnostics"].as_array().is_none_or(Vec::is_empty);
        let before = if empty {
            self.published.remove(&path)
        } else {
            self.published.insert(path, text.to_owned())
        };
        let before = before.filter(|old| old != text)?;
        Some(json!({
            "jsonrpc": "2.0",
            "method": PUBLISH,
            "params": { "uri": before, "diagnostics": [] },
        }))
    }

    fn rewrite(&self, value: &mut Value) {
        match value {
            Value::Array(values) => values.iter_mut().for_each(|value| self.rewrite(value)),
            Value::Object(fields) => {
                // The edits of a workspace edit by URI.
                if let Some(Value::Object(changes)) = fields.get_mut("changes") {
                    let old = std::mem::take(changes);
                    let renamed = |(key, value): (String, Value)| {
                        let own = self.spell(&key);
                        (own.unwrap_or(key), value)
                    };
                    *changes = old.into_iter().map(renamed).collect();
                }
                for (name, value) in fields {
                    match value {
                        Value::String(text) if FIELDS.contains(&name.as_str()) => {
                            if let Some(own) = self.spell(text) {
                                *text = own;
                            }
                        }
                        value => self.rewrite(value),
                    }
                }
            }
            _ => {}
        }
    }

    /// The client's spelling of a URI, if it differs.
    fn spell(&self, text: &str) -> Option<String> {
        if let Some(own) = self.others.get(text) {
            return Some(own.clone());
        }
        let path = path(text)?;
        let spelt = if let Some(own) = self.files.get(&path) {
            own.clone()
        } else {
            let folder = path.ancestors().find_map(|ancestor| self.folders.get_key_value(ancestor));
            let (folder, own) = folder?;
            // The rest of the path has the spelling of the server.
            let server = uri::from_path(folder)?;
            let rest = text.strip_prefix(server.as_str().trim_end_matches('/'))?;
            format!("{own}{rest}")
        };
        (spelt != text).then_some(spelt)
    }
}

fn file(value: &Value) -> Option<(Utf8PathBuf, &str)> {
    let text = value.as_str()?;
    Some((path(text)?, text))
}

fn path(text: &str) -> Option<Utf8PathBuf> {
    let scheme = text.get(..5)?;
    if !scheme.eq_ignore_ascii_case("file:") {
        return None;
    }
    let escaped = uri::escaped(text);
    let uri: Uri = escaped.as_deref().unwrap_or(text).parse().ok()?;
    let path = uri::to_path(&uri);
    (!uri::is_virtual(Utf8Path::new(&path))).then_some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn publish(uri: &str, count: usize) -> Value {
        let diagnostics = vec![json!({ "message": uri }); count];
        json!({ "method": PUBLISH, "params": { "uri": uri, "diagnostics": diagnostics } })
    }

    fn opened(uri: &str) -> Value {
        json!({ "textDocument": { "uri": uri } })
    }

    #[test]
    fn uris_leave_as_they_came() {
        let mut spelling = Spelling::default();
        spelling.store_uris("initialize", &json!({ "rootUri": "file:///%77%2bx/" }));
        let opened = opened("file:///%77%2bx/a%3Ab.gen");
        spelling.store_uris("textDocument/didOpen", &opened);
        let server = |path: &str| uri::from_path(path.into()).expect("a URI").to_string();
        let (open, other, apart) =
            (server("/w+x/a:b.gen"), server("/w+x/sub/c.gen"), server("/o+.gen"));
        let mut message = json!({ "result": [
            { "uri": open, "message": open },
            { "targetUri": other },
            { "changes": { (open.clone()): [], (apart.clone()): [] } },
        ]});
        assert_eq!(spelling.apply(&mut message), None);
        let client = "file:///%77%2bx/a%3Ab.gen";
        assert_eq!(
            message["result"],
            json!([
                { "uri": client, "message": open },
                { "targetUri": "file:///%77%2bx/sub/c.gen" },
                { "changes": { (client): [], (apart): [] } },
            ])
        );
    }

    #[test]
    fn raw_characters_leave_as_they_came() {
        let mut spelling = Spelling::default();
        spelling.store_uris("initialize", &json!({ "rootUri": "file:///w/[é]" }));
        for uri in ["file:///w/[é]/a#1.gen", "untitled:a b"] {
            spelling.store_uris("textDocument/didOpen", &opened(uri));
        }
        let mut message = json!({ "result": [
            { "uri": "file:///w/%5B%C3%A9%5D/a%231.gen" },
            { "uri": "file:///w/%5B%C3%A9%5D/b.gen" },
            { "uri": "untitled:a%20b" },
        ]});
        assert_eq!(spelling.apply(&mut message), None);
        let expected = json!([
            { "uri": "file:///w/[é]/a#1.gen" },
            { "uri": "file:///w/[é]/b.gen" },
            { "uri": "untitled:a b" },
        ]);
        assert_eq!(message["result"], expected);
    }

    #[test]
    fn a_new_spelling_takes_the_old_diagnostics_along() {
        let mut spelling = Spelling::default();
        spelling.store_uris("textDocument/didOpen", &opened("file:///x.gen"));
        assert_eq!(spelling.apply(&mut publish("file:///a+b.gen", 1)), None);
        spelling.store_uris("textDocument/didOpen", &opened("file:///a%2Bb.gen"));
        let mut again = publish("file:///a+b.gen", 1);
        let before = spelling.apply(&mut again).expect("a message");
        assert_eq!(before["params"], json!({ "uri": "file:///a+b.gen", "diagnostics": [] }));
        assert_eq!(again["params"]["uri"], "file:///a%2Bb.gen");
        assert_eq!(spelling.apply(&mut publish("file:///a+b.gen", 0)), None);
    }
}
