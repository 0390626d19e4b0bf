//! Open template files.

use serde_json::{Value, json};

use super::client::{Client, Folder, codes};

const SCRIPT: &str = "template require ../common/util.tcl\n\
                      template parse file model.c file model.c\n\
                      template parse file ../common/types.h file types.h\n";
const MODEL: &str = "é <'foreach c [dotgen components] {\n#include \"<\"[$c name]\">.h\"\n";
const PLAIN: &str = "int f(char c) { return c == '>'; }\n";

fn folder() -> Folder {
    Folder::new(&[
        ("t/server/template.tcl", SCRIPT),
        ("t/server/model.c", MODEL),
        ("t/server/plain.c", PLAIN),
        ("t/common/util.tcl", "proc f {} {\n"),
        ("t/common/types.h", "a '>\n"),
        ("other/model.c", MODEL),
    ])
}

impl Client {
    async fn open_as(&mut self, uri: &str, language: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": language, "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document })).await;
    }
}

/// A client whose workspace is completely listed.
async fn found(folder: &Folder) -> Client {
    let capabilities =
        json!({ "textDocument": { "diagnostic": {} }, "window": { "workDoneProgress": true } });
    let answers = vec![("window/workDoneProgress/create", Value::Null)];
    let mut client = Client::start_answering(folder.params(capabilities), answers).await;
    loop {
        let progress = client.notification("$/progress").await;
        if progress["value"]["kind"] == "end" {
            return client;
        }
    }
}

#[tokio::test]
async fn errors_of_markers_are_shown_where_they_are_and_go_when_they_are_mended() {
    let folder = folder();
    let mut client = found(&folder).await;
    let uri = folder.uri("t/server/model.c");
    client.open_as(&uri, "c", MODEL).await;
    let pushed = client.pushed(&uri).await;
    assert_eq!(codes(&pushed["diagnostics"]), ["template/marker"]);
    let found = &pushed["diagnostics"][0];
    let start = json!({ "line": 0, "character": 2 });
    assert_eq!(found["range"]["start"], start);
    let message =
        "this marker is not closed before the next one begins in line 2: write `'>` where it ends";
    assert_eq!(found["message"], message);
    let end = json!({ "line": 0, "character": 36 });
    let close = json!({ "range": { "start": end, "end": end }, "text": "'>" });
    client.change(&uri, 2, json!([close])).await;
    // Now a brace is missing.
    let pushed = client.pushed(&uri).await;
    assert_eq!(codes(&pushed["diagnostics"]), ["template/tcl"]);
    let last = json!({ "line": 2, "character": 0 });
    let brace = json!({ "range": { "start": last, "end": last }, "text": "<'}'>\n" });
    client.change(&uri, 3, json!([brace])).await;
    let pushed = client.pushed(&uri).await;
    assert_eq!(codes(&pushed["diagnostics"]), [""; 0]);
    client.finish().await;
}

#[tokio::test]
async fn scripts_and_files_beside_a_template_that_it_names_belong_to_it() {
    let folder = folder();
    let mut client = found(&folder).await;
    let script = format!("{SCRIPT}puts [f\n");
    for (name, language, text, expected) in [
        ("t/common/types.h", "cpp", "a '>\n", "template/marker"),
        ("t/common/util.tcl", "tcl", "proc f {} {\n", "template/tcl"),
        ("t/server/template.tcl", "tcl", &script, "template/tcl"),
    ] {
        let uri = folder.uri(name);
        client.open_as(&uri, language, text).await;
        let pushed = client.pushed(&uri).await;
        assert_eq!(codes(&pushed["diagnostics"]), [expected], "{name}");
    }
    client.finish().await;
}

#[tokio::test]
async fn other_documents_are_left_alone_unless_their_language_says_so() {
    let folder = folder();
    let mut client = found(&folder).await;
    let plain = folder.uri("t/server/plain.c");
    client.open_as(&plain, "c", PLAIN).await;
    assert_eq!(client.pushed(&plain).await["diagnostics"], json!([]));
    // No other feature of the server is available in these files.
    let params = json!({ "textDocument": { "uri": plain } });
    let symbols = client.ok("textDocument/documentSymbol", params).await;
    assert_eq!(symbols, Value::Null);
    let other = folder.uri("other/model.c");
    client.open_as(&other, "c", MODEL).await;
    let said = folder.uri("other/said.txt");
    client.open_as(&said, "genom3-template", MODEL).await;
    let pushed = client.pushed(&said).await;
    assert_eq!(codes(&pushed["diagnostics"]), ["template/marker"]);
    assert!(client.all().all(|message| message["params"]["uri"] != other));
    client.finish().await;
}

#[tokio::test]
async fn the_client_is_asked_for_the_files_of_templates() {
    let folder = folder();
    let dynamic = json!({ "dynamicRegistration": true });
    let capabilities = json!({
        "textDocument": {
            "diagnostic": {},
            "synchronization": dynamic, "codeAction": dynamic,
            "codeLens": dynamic, "references": dynamic, "definition": dynamic, "hover": dynamic,
        },
        "window": { "workDoneProgress": true },
    });
    let answers = [
        "window/workDoneProgress/create",
        "client/registerCapability",
        "client/unregisterCapability",
    ];
    let answers = answers.map(|answer| (answer, Value::Null)).to_vec();
    let mut client = Client::start_answering(folder.params(capabilities), answers).await;
    let uri = folder.uri("t/server/model.c");
    client.open_as(&uri, "c", MODEL).await;
    let sent = loop {
        let asked = client.asked.iter().rev();
        let registered = asked.filter(|message| message["method"] == "client/registerCapability");
        let mut all = registered
            .flat_map(|message| message["params"]["registrations"].as_array().expect("a list"));
        let sent = all.find(|registration| registration["method"] == "textDocument/didChange");
        if let Some(sent) = sent
            && sent.to_string().contains("/t/server/**")
        {
            break sent.clone();
        }
        // Any request makes the pipe move on.
        client.ok("workspace/symbol", json!({ "query": "" })).await;
    };
    let selector = sent["registerOptions"]["documentSelector"].as_array().expect("a list").clone();
    let patterns = |language: &str| -> Vec<String> {
        let of = selector.iter().filter(|selector| selector["language"] == language);
        of.map(|selector| selector["pattern"].as_str().expect("a glob").to_owned()).collect()
    };
    let has =
        |language: &str, end: &str| patterns(language).iter().any(|pattern| pattern.ends_with(end));
    assert!(has("c", "**/codels/**") && has("c", "/t/server/**") && has("c", "/t/common/types.h"));
    assert!(has("tcl", "/t/common/util.tcl") && !has("tcl", "**/codels/**"));
    assert!(patterns("genom3").is_empty(), "the client sends these anyway");
    client.ignore("$/progress");
    client.ignore("textDocument/publishDiagnostics");
    client.finish_ignoring("$/progress").await;
}
