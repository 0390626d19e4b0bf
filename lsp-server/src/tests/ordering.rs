use serde_json::{Value, json};

use super::client::{Client, document, pulling};

const URI: &str = "file:///nowhere/a.gen";

async fn start() -> Client {
    Client::start(json!({ "capabilities": pulling() })).await
}

fn insert(line: u32, character: u32, text: &str) -> Value {
    let at = json!({ "line": line, "character": character });
    json!([{ "range": { "start": at, "end": at }, "text": text }])
}

#[tokio::test(flavor = "multi_thread")]
async fn two_thousand_rapid_edits_arrive_in_order() {
    let mut client = start().await;
    client.open(URI, "").await;
    let mut expected = String::new();
    for version in 2..2002 {
        let piece = format!("{version},");
        let at = u32::try_from(expected.len()).expect("short");
        client.change(URI, version, insert(0, at, &piece)).await;
        expected.push_str(&piece);
    }
    assert_eq!(client.ok("test/text", document(URI)).await, expected);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_sees_the_text_of_its_turn() {
    let mut client = start().await;
    client.open(URI, "").await;
    let mut ids = Vec::new();
    for version in 2..52 {
        client.change(URI, version, json!([{ "text": version.to_string() }])).await;
        ids.push((version, client.begin("test/text", document(URI)).await));
    }
    for (version, id) in ids {
        match client.end(id).await {
            Ok(text) => assert_eq!(text, version.to_string()),
            // A later edit came during the work: the client repeats the request.
            Err(error) => assert_eq!(error["code"], -32801),
        }
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_client_can_cancel_and_the_writer_is_free_again() {
    let mut client = start().await;
    client.open(URI, "a").await;
    let id = client.begin("test/forever", document(URI)).await;
    client.notify("$/cancelRequest", json!({ "id": id })).await;
    assert_eq!(client.end(id).await.expect_err("cancelled")["code"], -32800);
    client.change(URI, 2, json!([{ "text": "b" }])).await;
    assert_eq!(client.ok("test/text", document(URI)).await, "b");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edit_cancels_what_works_on_the_old_text() {
    let mut client = start().await;
    client.open(URI, "a").await;
    // More requests than the library serves at once by default. With the default, no later request would be
    // served.
    let mut ids = Vec::new();
    for _ in 0..12 {
        ids.push(client.begin("test/forever", document(URI)).await);
    }
    client.change(URI, 2, json!([{ "text": "b" }])).await;
    for id in ids {
        let error = client.end(id).await.expect_err("out of date");
        assert_eq!(error["code"], -32801);
    }
    assert_eq!(client.ok("test/text", document(URI)).await, "b");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edit_elsewhere_makes_a_request_try_again() {
    let mut client = start().await;
    client.open(URI, "a").await;
    client.change(URI, 2, json!([{ "text": "b" }])).await;
    let other = "file:///nowhere/b.gen";
    client.open(other, "").await;
    let id = client.begin("test/second", document(URI)).await;
    client.change(other, 2, json!([{ "text": "x" }])).await;
    assert_eq!(client.end(id).await, Ok(json!(true)));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn positions_count_in_the_unit_that_was_agreed() {
    // "é😀x": the position of x, in each unit.
    for (offered, agreed, character) in [
        (json!(["utf-16", "utf-8", "utf-32"]), "utf-8", 6),
        (json!(["utf-16", "utf-32"]), "utf-32", 2),
        (json!(["utf-16"]), "utf-16", 3),
        (json!(null), "utf-16", 3),
    ] {
        let mut client = Client::raw();
        let mut capabilities = pulling();
        if !offered.is_null() {
            capabilities["general"] = json!({ "positionEncodings": offered });
        }
        let result = client.ok("initialize", json!({ "capabilities": capabilities })).await;
        assert_eq!(result["capabilities"]["positionEncoding"], agreed);
        client.notify("initialized", json!({})).await;
        client.open(URI, "// 1\r\n// 2\ré😀x\n").await;
        client.change(URI, 2, insert(2, character, "|")).await;
        let text = client.ok("test/text", document(URI)).await;
        assert_eq!(text, "// 1\r\n// 2\ré😀|x\n", "{agreed}");
        client.finish().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edit_out_of_range_drops_the_document_until_its_text_is_known_again() {
    let mut client = start().await;
    client.open(URI, "a\n").await;
    client.change(URI, 2, insert(9, 0, "x")).await;
    assert_eq!(client.ok("test/text", document(URI)).await, json!(null));
    client.change(URI, 3, insert(0, 0, "x")).await;
    assert_eq!(client.ok("test/text", document(URI)).await, json!(null));
    client.change(URI, 4, json!([{ "text": "whole" }])).await;
    assert_eq!(client.ok("test/text", document(URI)).await, "whole");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_takes_long_is_shown_and_can_be_stopped() {
    let mut capabilities = pulling();
    capabilities["window"] = json!({ "workDoneProgress": true });
    let params = json!({ "capabilities": capabilities });
    let answers = vec![("window/workDoneProgress/create", Value::Null)];
    let mut client = Client::start_answering(params, answers).await;
    client.open(URI, "a").await;
    let id = client.begin("test/everywhere", document(URI)).await;
    let mut shown = Vec::new();
    let token = loop {
        let told = client.notification("$/progress").await;
        let value = &told["value"];
        let what = value.get("title").or(value.get("percentage"));
        shown.push(what.cloned().unwrap_or_default());
        if value["kind"] == "report" {
            break told["token"].clone();
        }
    };
    assert_eq!(shown, [json!("Testing"), json!(25)]);
    let stop = json!({ "token": token });
    client.notify("window/workDoneProgress/cancel", stop).await;
    assert_eq!(client.end(id).await.expect_err("stopped")["code"], -32800);
    let end = client.notification("$/progress").await;
    assert_eq!((&end["token"], &end["value"]["kind"]), (&token, &json!("end")));
    // The work has ended too: a change does not wait for it.
    client.change(URI, 2, json!([{ "text": "b" }])).await;
    assert_eq!(client.ok("test/text", document(URI)).await, "b");
    client.finish().await;
}
