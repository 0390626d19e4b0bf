//! Specifications and the sources of their codels in an editor.

mod findings;
mod fixes;
mod navigation;
mod typing;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use camino::Utf8PathBuf;
use dotgen_analysis::host::{AnalysisHost, Change};
use dotgen_codegen::codels::command::{self, Project};
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_codegen::codels::stub::StubOptions;
use serde_json::{Value, json};

use super::client::{Client, Folder, codes, document, pulling};
use crate::features::codels::Disk;
use crate::protocol::convert::{Encoding, Lines};
use dotgen_platform::files::vfs::Vfs;

const DID_CHANGE_FILES: &str = "workspace/didChangeWatchedFiles";
const FILES: [&str; 3] = ["tank.gen", "codels/tank_codels.c", "codels/tank_control_codels.c"];

/// The example with a drift of each kind.
fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drift")
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).expect("a file of the example")
}

/// A copy of the example.
fn tank() -> Folder {
    let all =
        FILES.iter().chain(&["codels/Makefile.am"]).map(|file| (*file, read(example().join(file))));
    let all: Vec<_> = all.collect();
    let files: Vec<_> = all.iter().map(|(file, text)| (*file, text.as_str())).collect();
    Folder::new(&files)
}

/// A client with all capabilities that edits need.
fn capable() -> Value {
    json!({
        "textDocument": {
            "publishDiagnostics": { "relatedInformation": true, "codeDescriptionSupport": true },
            "codeAction": {
                "codeActionLiteralSupport": { "codeActionKind": { "valueSet": [] } },
                "dataSupport": true,
                "resolveSupport": { "properties": ["edit"] },
            },
        },
        "workspace": { "workspaceEdit": {
            "documentChanges": true,
            "resourceOperations": ["create"],
            "changeAnnotationSupport": {},
        } },
    })
}

/// The place of the n-th occurrence of a word in a text.
fn place(text: &str, what: &str, nth: usize) -> Value {
    let (offset, _) = text.match_indices(what).nth(nth).expect("it occurs");
    place_at(text, offset)
}

fn place_at(text: &str, offset: usize) -> Value {
    let line = text[..offset].matches('\n').count();
    let start = text[..offset].rfind('\n').map_or(0, |end| end + 1);
    json!({ "line": line, "character": offset - start })
}

fn at(uri: &str, text: &str, what: &str, nth: usize) -> Value {
    let mut params = document(uri);
    params["position"] = place(text, what, nth);
    params
}

/// `code: message` of diagnostics.
fn messages(diagnostics: &Value) -> Vec<String> {
    let all = diagnostics.as_array().expect("a list").iter();
    all.map(|diagnostic| {
        let text = |key: &str| diagnostic[key].as_str().unwrap_or_default().to_owned();
        format!("{}: {}", text("code"), text("message"))
    })
    .collect()
}

impl Client {
    async fn open_code(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "c", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document })).await;
    }

    /// Waits until the diagnostics pushed for a document satisfy `wanted`.
    async fn pushed_until(&mut self, uri: &str, wanted: impl Fn(&[String]) -> bool) -> Value {
        loop {
            let pushed = self.pushed(uri).await;
            if wanted(&codes(&pushed["diagnostics"])) {
                return pushed["diagnostics"].clone();
            }
        }
    }

    async fn actions(&mut self, uri: &str, range: &Value, only: Option<&str>) -> Vec<Value> {
        let mut params = document(uri);
        params["range"] = range.clone();
        params["context"] = json!({ "diagnostics": [] });
        if let Some(only) = only {
            params["context"]["only"] = json!([only]);
        }
        let answer = self.ok("textDocument/codeAction", params).await;
        let mut out = Vec::new();
        for action in answer.as_array().cloned().unwrap_or_default() {
            out.push(match action.get("edit") {
                Some(_) => action,
                None => self.ok("codeAction/resolve", action).await,
            });
        }
        out
    }
}

fn title(action: &Value) -> &str {
    action["title"].as_str().unwrap_or_default()
}

/// Texts by URI after a workspace edit, applied as by a client.
fn applied(edit: &Value, text: impl Fn(&str) -> Option<String>) -> BTreeMap<String, String> {
    let mut out: BTreeMap<String, String> = BTreeMap::new();
    let change = |uri: &str, edits: &Value, created: &BTreeMap<String, String>| {
        let before = created.get(uri).cloned().or_else(|| text(uri));
        let before = before.unwrap_or_default();
        let lines = Lines::new(before.as_str().into(), Encoding::Utf16);
        let mut edits: Vec<_> = edits
            .as_array()
            .expect("edits")
            .iter()
            .map(|edit| {
                let range = serde_json::from_value(edit["range"].clone()).expect("a range");
                let range = lines.bytes(range).expect("a range of the text");
                (range, edit["newText"].as_str().expect("a text").to_owned())
            })
            .collect();
        // From the end, insertions at one place in order.
        edits.sort_by_key(|edit| edit.0.start);
        let mut after = before;
        for (range, new) in edits.into_iter().rev() {
            after.replace_range(range, &new);
        }
        (uri.to_owned(), after)
    };
    for operation in edit["documentChanges"].as_array().into_iter().flatten() {
        if operation["kind"] == "create" {
            let uri = operation["uri"].as_str().expect("a URI");
            assert_eq!(operation["options"]["overwrite"], false);
            assert_eq!(text(uri), None, "a file that is there is created");
            out.insert(uri.to_owned(), String::new());
            continue;
        }
        let uri = operation["textDocument"]["uri"].as_str().expect("a URI");
        let (uri, after) = change(uri, &operation["edits"], &out);
        out.insert(uri, after);
    }
    for (uri, edits) in edit["changes"].as_object().into_iter().flatten() {
        let (uri, after) = change(uri, edits, &out);
        out.insert(uri, after);
    }
    out
}

fn path(uri: &str) -> PathBuf {
    let uri: crate::protocol::types::Uri = uri.parse().expect("a URI");
    crate::protocol::convert::uri::to_path(&uri).into_std_path_buf()
}

fn on_disk(uri: &str) -> Option<String> {
    std::fs::read_to_string(path(uri)).ok()
}

/// Writes the files that an edit changes.
pub(super) fn write(edit: &Value) {
    for (uri, text) in applied(edit, on_disk) {
        let path = path(&uri);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    }
}

/// The findings of `dotgen codels check`.
fn check(specification: &Path) -> Vec<String> {
    let root = Utf8PathBuf::from_path_buf(specification.to_owned()).expect("UTF-8");
    let mut host = AnalysisHost::new(std::sync::Arc::new(Vfs::default()));
    host.apply(Change { roots: Some(vec![root.clone()]), ..Change::default() });
    let (files, stubs) = (FilesConfig::default(), StubOptions::default());
    let report = command::check(&mut Project::new(&mut host, &Disk, files, stubs), &[root]);
    assert_eq!(report.errors, Vec::<String>::new());
    let all = report.findings.iter();
    all.map(|finding| format!("{}: {}", finding.code, finding.message)).collect()
}
