//! Clients that differ from VS Code: other values, other URIs, no file watchers.

use serde_json::{Value, json};

use super::client::{Client, Folder, codes, document, pulling};

const URI: &str = "file:///nowhere/a.gen";

#[tokio::test(flavor = "multi_thread")]
async fn values_of_other_protocols_cost_only_themselves() {
    let mut capabilities = pulling();
    capabilities["textDocument"]["semanticTokens"] =
        json!({ "requests": { "range": { "x": [] } }, "tokenTypes": [], "tokenModifiers": [] });
    capabilities["textDocument"]["hover"] = json!({ "contentFormat": ["html", "plaintext"] });
    let params = json!({
        "processId": null, "rootUri": "", "trace": "compact", "capabilities": capabilities,
        "workspaceFolders": [{ "uri": "file:///nowhere/[arm]" }],
    });
    let mut client = Client::raw();
    let answer = client.ok("initialize", params).await;
    // The capability next to the unknown one is kept.
    assert!(answer["capabilities"]["diagnosticProvider"].is_object(), "{answer}");
    client.notify("initialized", json!({})).await;
    client.open(URI, "struct s { long x; };").await;
    let mut place = document(URI);
    for (line, character) in [(json!(0.0), json!(7)), (json!(-1), json!(1_u64 << 40))] {
        place["position"] = json!({ "line": line, "character": character });
        client.ok("textDocument/hover", place.clone()).await;
    }
    client.finish_ignoring("window/showMessage").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_change_that_cannot_be_read_drops_the_document() {
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    client.open(URI, "struct s { long x; };").await;
    let broken = json!({ "textDocument": { "uri": URI, "version": 2 }, "contentChanges": [7] });
    client.notify("textDocument/didChange", broken).await;
    assert_eq!(client.ok("test/text", document(URI)).await, Value::Null);
    client.change(URI, 3, json!([{ "text": "struct t { long y; };" }])).await;
    assert_eq!(client.ok("test/text", document(URI)).await, "struct t { long y; };");
    // Neither the language nor the version is needed.
    let opened = json!({ "uri": "file:///nowhere/b.gen", "text": "// b" });
    client.notify("textDocument/didOpen", json!({ "textDocument": opened })).await;
    assert_eq!(client.ok("test/text", document("file:///nowhere/b.gen")).await, "// b");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn answers_have_the_uris_that_the_client_wrote() {
    let text = "struct pose { nope x; };\n";
    let folder = Folder::new(&[("[é] #1/a.gen", text)]);
    let root = folder.uri("").replace("%20", " ").replace("%C3%A9", "é");
    let uri = format!("{root}/[é] #1/a.gen");
    let mut client = Client::raw();
    client.ok("initialize", json!({ "rootUri": root, "capabilities": {} })).await;
    client.notify("initialized", json!({})).await;
    client.open(&uri, text).await;
    while client.pushed(&uri).await["diagnostics"] == json!([]) {}
    let mut place = document(&uri);
    place["position"] = json!({ "line": 0, "character": 8 });
    let found = client.ok("textDocument/definition", place.clone()).await;
    assert_eq!(found[0]["uri"].as_str().or(found["uri"].as_str()), Some(&*uri), "{found}");
    place["newName"] = json!("place");
    let edit = client.ok("textDocument/rename", place).await;
    assert_eq!(edit["changes"][&uri][0]["newText"], "place", "{edit}");
    client.finish_ignoring("textDocument/publishDiagnostics").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn files_are_read_again_for_a_client_without_watchers() {
    let text = "#include \"late.idl\"\nstruct s { later x; };\n";
    let folder = Folder::new(&[("a.gen", text)]);
    let mut client = Client::start(folder.params(pulling())).await;
    let uri = folder.uri("a.gen");
    client.open(&uri, text).await;
    assert!(!client.pulled(&uri).await.is_empty());
    folder.write("late.idl", "struct later { long x; };\n");
    client.notify("textDocument/didSave", document(&uri)).await;
    assert_eq!(client.pulled(&uri).await, Vec::<String>::new());

    folder.write("late.idl", "/* moved */\n\nstruct later { long x; };\n");
    folder.write("new.gen", "#include \"late.idl\"\nstruct t { later y; };\n");
    let mut place = document(&uri);
    place["position"] = json!({ "line": 1, "character": 13 });
    place["newName"] = json!("sooner");
    let edit = client.ok("textDocument/rename", place).await;
    let included = &edit["changes"][folder.uri("late.idl")];
    assert_eq!(included[0]["range"]["start"], json!({ "line": 2, "character": 7 }), "{edit}");
    assert_eq!(edit["changes"][folder.uri("new.gen")][0]["newText"], "sooner", "{edit}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_findings_of_a_removed_folder_go() {
    let folder = Folder::new(&[("a.gen", "struct s { nope x; };\n")]);
    let mut client = Client::start(folder.params(json!({}))).await;
    let uri = folder.uri("a.gen");
    while codes(&client.pushed(&uri).await["diagnostics"]).is_empty() {}
    let removed = json!([{ "uri": folder.uri("") }]);
    let event = json!({ "event": { "removed": removed } });
    client.notify("workspace/didChangeWorkspaceFolders", event).await;
    assert_eq!(client.pushed(&uri).await["diagnostics"], json!([]));
    client.finish().await;
}

const POM: &str = "struct st { long sec; double x; };
component pom { version \"1\"; lang \"c\";
  port out st frame;
  task exec { period 10 ms; codel<start> pom_go(out frame) yield pause::start; };
};
";

const RULES: &str = "[ros2.messages.pom.frame]
type = \"geometry_msgs/Point\"
fields = { x = \"x\" }
";

#[tokio::test(flavor = "multi_thread")]
async fn a_rename_edits_rules() {
    let folder = Folder::new(&[("pom.gen", POM), ("dotgen.toml", RULES)]);
    let mut client = Client::start(folder.params(pulling())).await;
    let uri = folder.uri("pom.gen");
    client.open(&uri, POM).await;
    for ((line, character), start) in [((2, 14), (0, 19)), ((0, 29), (2, 16)), ((1, 11), (0, 15))] {
        let mut place = document(&uri);
        place["position"] = json!({ "line": line, "character": character });
        place["newName"] = json!("other");
        let edit = client.ok("textDocument/rename", place).await;
        let edits = &edit["changes"][folder.uri("dotgen.toml")];
        let expected = json!({ "line": start.0, "character": start.1 });
        assert_eq!(edits[0]["range"]["start"], expected, "{edit}");
        assert_eq!(edits.as_array().map(Vec::len), Some(1), "{edit}");
    }
    // A member that no rule names.
    let mut place = document(&uri);
    place["position"] = json!({ "line": 0, "character": 18 });
    place["newName"] = json!("other");
    let edit = client.ok("textDocument/rename", place).await;
    assert_eq!(edit["changes"].as_object().map(serde_json::Map::len), Some(1), "{edit}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn scenarios_follow_renamed_specifications() {
    let scenario = "scenario s { use \"pom.gen\"; cores 1; check schedulable *; }\n";
    let folder = Folder::new(&[("pom.gen", POM), ("sub/s.scn", ""), ("s.scn", scenario)]);
    let mut client = Client::start(folder.params(pulling())).await;
    for (old, new, text) in
        [("pom.gen", "arm.gen", "arm.gen"), ("s.scn", "sub/t.scn", "../pom.gen")]
    {
        let files = json!([{ "oldUri": folder.uri(old), "newUri": folder.uri(new) }]);
        let edit = client.ok("workspace/willRenameFiles", json!({ "files": files })).await;
        let edits = &edit["changes"][folder.uri("s.scn")];
        assert_eq!(edits[0]["newText"], text, "{edit}");
        assert_eq!(edits[0]["range"]["start"]["character"], 18, "{edit}");
    }
    client.finish().await;
}
