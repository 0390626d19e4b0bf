//! Messages of clients that follow another version of the protocol, or none.
//!
//! One value that the protocol types reject must not cost the whole message. Before a message is
//! deserialized:
//!
//! - Whole numbers written as `12.0` become integers, and coordinates outside the protocol's range are
//!   clamped.
//! - URIs are escaped where clients leave characters raw; see [`uri`].
//! - In `initialize` and in notifications about the workspace, the smallest part that cannot be read is
//!   removed. A removed part is as if absent.

use serde::de::DeserializeOwned;
use serde_json::{Number, Value, json};
use serde_path_to_error::{Path, Segment};

use crate::protocol::convert::uri;
use crate::protocol::types::{
    DidChangeConfigurationParams, DidChangeTextDocumentParams, DidChangeWatchedFilesParams,
    DidChangeWorkspaceFoldersParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams,
    DidSaveTextDocumentParams, InitializeParams,
};

/// Maximum number of parts that are removed from one message.
const MAX_REMOVED: usize = 256;

/// Maximum number of trials to find the parts, each with a copy of the message.
const MAX_TRIALS: usize = 1_024;

/// Greatest coordinate of the protocol (`uinteger`).
const MAX_COORDINATE: u64 = (1 << 31) - 1;

/// Changes the parameters of a message to what the protocol types accept. Returns a description of each part
/// that was removed.
pub(super) fn mend(method: &str, params: &mut Value) -> Vec<String> {
    normalize(params);
    if !params.is_object() {
        return Vec::new();
    }
    match method {
        "initialize" => {
            name_folders(&mut params["workspaceFolders"]);
            if !params["capabilities"].is_object() {
                params["capabilities"] = json!({});
            }
            prune::<InitializeParams>(params)
        }
        "workspace/didChangeWorkspaceFolders" => {
            for part in ["added", "removed"] {
                let Some(event) = params.get_mut("event").and_then(Value::as_object_mut) else {
                    break;
                };
                let folders = event.entry(part).or_insert_with(|| json!([]));
                if folders.is_null() {
                    *folders = json!([]);
                }
                name_folders(folders);
            }
            prune::<DidChangeWorkspaceFoldersParams>(params)
        }
        "workspace/didChangeWatchedFiles" => prune::<DidChangeWatchedFilesParams>(params),
        "workspace/didChangeConfiguration" if params.get("settings").is_none() => {
            // From a client that is asked for the settings.
            params["settings"] = Value::Null;
            Vec::new()
        }
        "textDocument/didOpen" => {
            // The name of the file gives the language too, and the version is only compared.
            if let Some(document) = params.get_mut("textDocument").and_then(Value::as_object_mut) {
                if !document.get("languageId").is_some_and(Value::is_string) {
                    document.insert("languageId".to_owned(), json!(""));
                }
                if !document.get("version").is_some_and(Value::is_i64) {
                    document.insert("version".to_owned(), json!(0));
                }
            }
            Vec::new()
        }
        "textDocument/didSave" => prune::<DidSaveTextDocumentParams>(params),
        _ => Vec::new(),
    }
}

/// The error in the parameters of a notification that changes the server's state. The library drops a
/// notification that it cannot read.
pub(super) fn error(method: &str, params: &Value) -> Option<String> {
    fn read<T: DeserializeOwned>(params: &Value) -> Option<String> {
        let error = serde_path_to_error::deserialize::<_, T>(params).err()?;
        Some(format!("`{}`: {}", error.path(), error.inner()))
    }
    match method {
        "textDocument/didOpen" => read::<DidOpenTextDocumentParams>(params),
        "textDocument/didChange" => read::<DidChangeTextDocumentParams>(params),
        "textDocument/didSave" => read::<DidSaveTextDocumentParams>(params),
        "textDocument/didClose" => read::<DidCloseTextDocumentParams>(params),
        "workspace/didChangeConfiguration" => read::<DidChangeConfigurationParams>(params),
        "workspace/didChangeWatchedFiles" => read::<DidChangeWatchedFilesParams>(params),
        "workspace/didChangeWorkspaceFolders" => read::<DidChangeWorkspaceFoldersParams>(params),
        _ => None,
    }
}

/// Rewrites numbers, coordinates and URIs at every depth.
fn normalize(value: &mut Value) {
    match value {
        Value::Number(number) => whole(number),
        Value::Array(values) => values.iter_mut().for_each(normalize),
        Value::Object(fields) => {
            // The edits of a workspace edit by URI, which the client sends back to be resolved.
            if let Some(Value::Object(changes)) = fields.get_mut("changes") {
                let old = std::mem::take(changes);
                let escaped = old.into_iter().map(|(key, value)| {
                    let escaped = uri::escaped(&key);
                    (escaped.unwrap_or(key), value)
                });
                *changes = escaped.collect();
            }
            for (name, value) in fields {
                match value {
                    Value::String(text) if is_uri(name, text) => {
                        if let Some(escaped) = uri::escaped(text) {
                            *text = escaped;
                        }
                    }
                    Value::Number(number) => {
                        whole(number);
                        let coordinates = ["line", "character", "startLine", "endLine"];
                        if coordinates.contains(&name.as_str()) {
                            clamp(number);
                        }
                    }
                    value => normalize(value),
                }
            }
        }
        _ => {}
    }
}

/// True for the fields whose value is a URI. Settings of some of these names are paths.
fn is_uri(field: &str, text: &str) -> bool {
    let may_be = || matches!(field, "root" | "folder" | "current") && text.starts_with("file:");
    field == "uri" || field.ends_with("Uri") || may_be()
}

#[expect(clippy::cast_possible_truncation, reason = "whole numbers in range")]
fn whole(number: &mut Number) {
    let float = number.as_f64().filter(|_| number.is_f64());
    if let Some(float) = float.filter(|float| float.fract() == 0.0 && float.abs() < 9e15) {
        *number = Number::from(float as i64);
    }
}

fn clamp(number: &mut Number) {
    let value = match (number.as_u64(), number.as_f64()) {
        (Some(value), _) => value.min(MAX_COORDINATE),
        (None, Some(value)) if value > 0.0 => MAX_COORDINATE,
        _ => 0,
    };
    *number = Number::from(value);
}

/// Gives folders without a name the last part of their URI.
fn name_folders(folders: &mut Value) {
    for folder in folders.as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut) {
        if !folder.get("name").is_some_and(Value::is_string) {
            let uri = folder.get("uri").and_then(Value::as_str).unwrap_or_default();
            let name = uri.trim_end_matches('/').rsplit('/').next().unwrap_or_default().to_owned();
            folder.insert("name".to_owned(), json!(name));
        }
    }
}

/// Removes the smallest parts of a value that `T` cannot be read from. Returns a description of each.
fn prune<T: DeserializeOwned>(value: &mut Value) -> Vec<String> {
    let (mut removed, mut trials) = (Vec::new(), MAX_TRIALS);
    while removed.len() < MAX_REMOVED {
        let Some((path, reason)) = failure::<T>(value) else { break };
        let mut path = steps(&path);
        narrow::<T>(value, &mut path, &mut trials);
        if path.is_empty() {
            break;
        }
        remove(value, &path);
        removed.push(format!("`{}`: {reason}", path.join(".")));
    }
    removed
}

fn failure<T: DeserializeOwned>(value: &Value) -> Option<(Path, String)> {
    let error = serde_path_to_error::deserialize::<_, T>(value).err()?;
    Some((error.path().clone(), error.inner().to_string()))
}

/// The keys and indexes of a path, up to the first step that is neither.
fn steps(path: &Path) -> Vec<String> {
    let step = |segment: &Segment| match segment {
        Segment::Seq { index } => Some(index.to_string()),
        Segment::Map { key } => Some(key.clone()),
        Segment::Enum { .. } | Segment::Unknown => None,
    };
    path.iter().map_while(step).collect()
}

/// Extends a path to the one part below it that is to blame. Types that accept several forms report the place
/// of the whole value. Without trials left, the whole value is.
fn narrow<T: DeserializeOwned>(value: &Value, path: &mut Vec<String>, trials: &mut usize) {
    loop {
        let Some(part) = at(value, path) else { return };
        let children: Vec<String> = match part {
            Value::Object(fields) => fields.keys().cloned().collect(),
            Value::Array(values) => (0..values.len()).map(|place| place.to_string()).collect(),
            _ => return,
        };
        let outer = path.clone();
        let mut is_to_blame = |child: &String| {
            if *trials == 0 {
                return false;
            }
            *trials -= 1;
            let mut without = value.clone();
            let inner: Vec<String> = outer.iter().chain([child]).cloned().collect();
            remove(&mut without, &inner);
            failure::<T>(&without).is_none_or(|(path, _)| steps(&path) != outer)
        };
        match children.into_iter().take(MAX_REMOVED).find(&mut is_to_blame) {
            Some(child) => path.push(child),
            None => return,
        }
    }
}

fn at<'a>(value: &'a Value, path: &[String]) -> Option<&'a Value> {
    path.iter().try_fold(value, |value, step| match value {
        Value::Array(values) => values.get(step.parse::<usize>().ok()?),
        value => value.get(step),
    })
}

fn remove(value: &mut Value, path: &[String]) {
    let Some((last, outer)) = path.split_last() else { return };
    let parent = outer.iter().try_fold(value, |value, step| match value {
        Value::Array(values) => values.get_mut(step.parse::<usize>().ok()?),
        value => value.get_mut(step),
    });
    match parent {
        Some(Value::Array(values)) => {
            if let Some(place) = last.parse().ok().filter(|place| *place < values.len()) {
                values.remove(place);
            }
        }
        Some(Value::Object(fields)) if last == "capabilities" && outer.is_empty() => {
            fields.insert(last.clone(), json!({}));
        }
        Some(Value::Object(fields)) => _ = fields.remove(last),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn initialize(params: Value) -> (Value, Vec<String>) {
        let mut params = params;
        let removed = mend("initialize", &mut params);
        assert_eq!(failure::<InitializeParams>(&params).map(|failure| failure.1), None, "{params}");
        (params, removed)
    }

    /// Each value is one that a client has sent, or a later version of the protocol may add.
    #[test]
    fn a_value_that_is_not_understood_is_as_if_absent() {
        for (field, value) in [
            ("/trace", json!("compact")),
            ("/rootUri", json!("")),
            ("/rootUri", json!(7)),
            ("/processId", json!("12")),
            ("/clientInfo", json!([])),
            ("/locale", json!(5)),
            ("/workspaceFolders", json!("none")),
            ("/capabilities/textDocument/semanticTokens/requests/range", json!({ "x": [] })),
            ("/capabilities/textDocument/foldingRange/rangeLimit", json!("many")),
            ("/capabilities/textDocument/hover/contentFormat", json!("markdown")),
            ("/capabilities/workspace/workspaceEdit/failureHandling", json!("none")),
            ("/capabilities/window/workDoneProgress", json!("yes")),
            ("/capabilities/general/positionEncodings", json!({})),
            ("/capabilities/textDocument", json!(1)),
        ] {
            let mut params = json!({
                "processId": null, "rootUri": null, "locale": "de", "trace": "off",
                "capabilities": { "textDocument": {
                    "semanticTokens": {
                        "requests": { "range": true, "full": {} },
                        "tokenTypes": [], "tokenModifiers": [], "formats": [],
                    },
                    "foldingRange": {}, "hover": {},
                }, "workspace": { "workspaceEdit": {} }, "window": {}, "general": {} },
            });
            let (outer, key) = field.rsplit_once('/').expect("a path");
            params.pointer_mut(outer).expect("a place")[key] = value;
            let (_, removed) = initialize(params);
            let name = field[1..].replace('/', ".");
            let place = format!("`{name}`: ");
            assert!(matches!(removed.as_slice(), [one] if one.starts_with(&place)), "{removed:?}");
        }
    }

    #[test]
    fn of_a_list_only_the_unknown_entries_go() {
        let (params, removed) = initialize(json!({ "capabilities": {
            "textDocument": {
                "completion": { "completionItem": { "documentationFormat": ["html", "markdown", "rst"] } },
                "foldingRange": { "foldingRangeKind": { "valueSet": ["comment", 3] } },
            },
            "workspace": { "workspaceEdit": { "resourceOperations": ["create", "copy"] } },
        }}));
        let part = |pointer: &str| params.pointer(pointer).cloned().unwrap_or_default();
        let item = "/capabilities/textDocument/completion/completionItem/documentationFormat";
        assert_eq!(part(item), json!(["markdown"]));
        let operations = "/capabilities/workspace/workspaceEdit/resourceOperations";
        assert_eq!(part(operations), json!(["create"]));
        assert_eq!(removed.len(), 4, "{removed:?}");
    }

    #[test]
    fn capabilities_may_be_missing_and_folders_may_have_no_name() {
        let (params, removed) = initialize(json!({ "processId": 12.0, "workspaceFolders": [
            { "uri": "file:///a/[arm]/" }, { "uri": "file:///b", "name": "b" }, { "name": "c" },
        ]}));
        assert_eq!(params["processId"], json!(12));
        assert_eq!(params["capabilities"], json!({}));
        assert_eq!(params["workspaceFolders"][0]["uri"], "file:///a/%5Barm%5D/");
        assert_eq!(params["workspaceFolders"].as_array().map(Vec::len), Some(2));
        assert_eq!(removed.len(), 1, "{removed:?}");
    }

    #[test]
    fn coordinates_are_clamped() {
        let mut params = json!({ "position": { "line": -1, "character": 4_294_967_296_u64 } });
        assert_eq!(mend("textDocument/hover", &mut params), Vec::<String>::new());
        assert_eq!(params["position"], json!({ "line": 0, "character": MAX_COORDINATE }));
        let mut params = json!({ "position": { "line": 2.0, "character": 1e300 } });
        mend("textDocument/hover", &mut params);
        assert_eq!(params["position"], json!({ "line": 2, "character": MAX_COORDINATE }));
    }

    #[test]
    fn parameters_of_any_form_are_survived() {
        let methods = [
            "initialize",
            "textDocument/didOpen",
            "textDocument/didChange",
            "textDocument/didSave",
            "workspace/didChangeConfiguration",
            "workspace/didChangeWatchedFiles",
            "workspace/didChangeWorkspaceFolders",
        ];
        for params in [
            json!(null),
            json!([]),
            json!([1]),
            json!(1.0),
            json!("x"),
            json!({}),
            json!({ "event": [] }),
            json!({ "textDocument": 1 }),
            json!({ "workspaceFolders": [1] }),
            json!({ "capabilities": [], "changes": { "a": 1 } }),
        ] {
            for method in methods {
                let mut params = params.clone();
                mend(method, &mut params);
                error(method, &params);
            }
        }
    }

    #[test]
    fn the_errors_of_notifications_name_the_field() {
        let params = json!({ "textDocument": { "uri": "file:///a.gen" }, "contentChanges": 4 });
        let error = error("textDocument/didChange", &params).expect("an error");
        assert!(error.starts_with("`textDocument`: missing field `version`"), "{error}");
    }
}
