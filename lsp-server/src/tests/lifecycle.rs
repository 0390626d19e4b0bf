use serde_json::{Value, json};

use super::client::{Client, document, pulling};

const URI: &str = "file:///nowhere/a.gen";

#[tokio::test(flavor = "multi_thread")]
async fn shutdown_and_exit_end_the_server_with_the_pipe_open() {
    let client = Client::start(json!({ "capabilities": pulling() })).await;
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_end_of_input_ends_the_server() {
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    client.disconnect().await;
    assert!(!client.ended().await, "shutdown was not said");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_end_of_input_ends_a_server_with_a_waiting_client() {
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    client.open(URI, "").await;
    let first = client.ok("workspace/diagnostic", json!({ "previousResultIds": [] })).await;
    let known: Vec<Value> = first["items"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|report| json!({ "uri": report["uri"], "value": report["resultId"] }))
        .collect();
    client.begin("workspace/diagnostic", json!({ "previousResultIds": known })).await;
    client.disconnect().await;
    assert!(!client.ended().await);
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_before_initialize_are_refused_and_unknown_ones_too() {
    let mut client = Client::raw();
    let error = client.request("textDocument/hover", json!({})).await;
    assert_eq!(error.expect_err("not initialized")["code"], -32002);
    client.ok("initialize", json!({ "capabilities": pulling() })).await;
    client.notify("initialized", json!({})).await;
    let error = client.request("dotgen/nothing", json!({})).await;
    assert_eq!(error.expect_err("unknown")["code"], -32601);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_panic_costs_one_request_and_is_shown_once() {
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    client.open(URI, "struct s { long x; };").await;
    for _ in 0..2 {
        let error = client.request("test/panic", document(URI)).await;
        let error = error.expect_err("it panics");
        assert_eq!(error["code"], -32603);
        let message = error["message"].as_str().expect("a message");
        assert!(message.contains("on purpose at "), "{message}");
    }
    let shown = client.notification("window/showMessage").await;
    assert_eq!(shown["type"], 1);
    let text = client.ok("test/text", document(URI)).await;
    assert_eq!(text, "struct s { long x; };");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_panic_in_a_change_leaves_the_text_of_the_client() {
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    client.open(URI, "struct s { long x; };").await;
    let change = json!({
        "textDocument": { "uri": URI, "version": 2 },
        "contentChanges": [{ "text": "struct s { long y; };" }],
    });
    client.notify("test/broken", change).await;
    let text = client.ok("test/text", document(URI)).await;
    assert_eq!(text, "struct s { long y; };");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn unknown_documents_have_nothing_to_show() {
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    for uri in ["file:///nowhere/missing.gen", "untitled:Untitled-9"] {
        for method in [
            "textDocument/documentSymbol",
            "textDocument/foldingRange",
            "textDocument/semanticTokens/full",
            "textDocument/documentLink",
        ] {
            assert_eq!(client.ok(method, document(uri)).await, Value::Null);
        }
        let report = client.ok("textDocument/diagnostic", document(uri)).await;
        assert_eq!(report["items"], json!([]));
    }
    // Not open: the change is ignored.
    client.change(URI, 7, json!([{ "text": "x" }])).await;
    client.notify("textDocument/didClose", document("file:///nowhere/missing.gen")).await;
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn messages_that_make_no_sense_get_an_error() {
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    let error = client.request("textDocument/hover", json!({ "x": 1 })).await;
    assert_eq!(error.expect_err("no position")["code"], -32602);
    let bad_uri = json!({ "textDocument": { "uri": "::not a uri::" } });
    let error = client.request("textDocument/documentSymbol", bad_uri).await;
    assert_eq!(error.expect_err("no URI")["code"], -32602);
    client.finish().await;
}
