//! Edits that must be refused or delayed: edits of only a part of the places, and of files that the client
//! cannot write back unchanged.

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const POSE: &str = "struct pose { double x; };\n";
const ARM: &str = "#include \"pose.idl\"\ncomponent arm {\n  ids { pose goal; };\n};\n";
const BASE: &str =
    "#include \"pose.idl\"\n/* Andr\u{e9} */\ncomponent base {\n  ids { pose goal; };\n};\n";

/// A request about the name in `POSE`.
fn at_pose(uri: &str) -> Value {
    let mut params = document(uri);
    params["position"] = json!({ "line": 0, "character": 8 });
    params["newName"] = json!("position");
    params
}

fn latin1(text: &str) -> Vec<u8> {
    text.chars().map(|character| u8::try_from(u32::from(character)).expect("Latin-1")).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_rename_waits_until_all_files_are_known() {
    let folder = Folder::new(&[("pose.idl", POSE), ("arm.gen", ARM), ("sub/base.gen", BASE)]);
    folder.write("sub/pose.idl", "#include \"../pose.idl\"\n");
    let mut capabilities = pulling();
    capabilities["window"] = json!({ "workDoneProgress": true });
    let asked = vec![("window/workDoneProgress/create", Value::Null)];
    let mut client = Client::start_answering(folder.params(capabilities), asked).await;
    let uri = folder.uri("pose.idl");
    client.open(&uri, POSE).await;
    // The server lists the files after the answer to its request for a progress, which comes after these
    // requests.
    let rename = client.begin("textDocument/rename", at_pose(&uri)).await;
    let files = json!({ "files": [{ "oldUri": uri, "newUri": folder.uri("types.idl") }] });
    let moved = client.begin("workspace/willRenameFiles", files).await;
    let edit = client.end(rename).await.expect("an edit");
    for name in ["pose.idl", "arm.gen", "sub/base.gen"] {
        assert!(edit["changes"].get(folder.uri(name)).is_some(), "{name}: {edit}");
    }
    let edit = client.end(moved).await.expect("an edit");
    for name in ["arm.gen", "sub/pose.idl"] {
        assert!(edit["changes"].get(folder.uri(name)).is_some(), "{name}: {edit}");
    }
    client.finish_ignoring("$/progress").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_in_another_encoding_is_changed_only_when_it_is_open() {
    let folder = Folder::new(&[("pose.idl", POSE), ("arm.gen", ARM)]);
    folder.write_bytes("base.gen", &latin1(BASE));
    let mut client = Client::start(folder.params(pulling())).await;
    let uri = folder.uri("pose.idl");
    client.open(&uri, POSE).await;
    let error = client.request("textDocument/rename", at_pose(&uri)).await;
    let error = error.expect_err("it would do harm");
    let message = error["message"].as_str().expect("a message");
    assert!(
        message.contains("base.gen would have to be changed, and line 2 is not UTF-8"),
        "{message}"
    );
    let files = json!({ "files": [{ "oldUri": uri, "newUri": folder.uri("types.idl") }] });
    let error = client.request("workspace/willRenameFiles", files).await;
    error.expect_err("it would do harm");
    // The client has read an open file in the file's own encoding.
    client.open(&folder.uri("base.gen"), BASE).await;
    let edit = client.ok("textDocument/rename", at_pose(&uri)).await;
    assert!(edit["changes"].get(folder.uri("base.gen")).is_some(), "{edit}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn new_text_has_the_line_ends_of_the_document() {
    let spec = "component c {\r\n  ids { long x; };\r\n  task t {\r\n    codel<start> f(in x) yield ether;\r\n    \
                codel<stop> g(in x) yield ether;\r\n  };\r\n};\r\n";
    let code = "#include \"acc.h\"\r\n#include \"c_c_types.h\"\r\n\r\ngenom_event\r\nf(int32_t x, const genom_context \
                self)\r\n{\r\n  return c_ether;\r\n}\r\n";
    let folder = Folder::new(&[("c.gen", spec), ("codels/c_t_codels.c", code)]);
    let mut capabilities = pulling();
    capabilities["textDocument"]["codeAction"] = json!({ "codeActionLiteralSupport": {
        "codeActionKind": { "valueSet": [] } } });
    let mut client = Client::start(folder.params(capabilities)).await;
    let uri = folder.uri("c.gen");
    client.open(&uri, spec).await;
    let mut params = document(&uri);
    params["range"] =
        json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 8, "character": 0 } });
    params["context"] = json!({ "diagnostics": [] });
    let actions = client.ok("textDocument/codeAction", params).await;
    let mut several = 0;
    for action in actions.as_array().expect("actions") {
        let changes = action["edit"]["changes"].as_object();
        for (file, edits) in changes.into_iter().flatten() {
            for edit in edits.as_array().expect("edits") {
                let text = edit["newText"].as_str().expect("a text");
                let is_new = !file.ends_with("c_t_codels.c") && *file != uri;
                several += usize::from(text.contains("\r\n"));
                assert!(is_new || !text.replace("\r\n", "").contains('\n'), "{action}");
            }
        }
    }
    assert!(several > 0, "{actions}");
    client.finish_ignoring("textDocument/publishDiagnostics").await;
}
