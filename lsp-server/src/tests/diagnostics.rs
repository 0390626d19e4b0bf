use serde_json::{Value, json};

use super::client::{Client, Folder, codes, document, pulling};

const DID_CHANGE_FILES: &str = "workspace/didChangeWatchedFiles";

fn pushing() -> Value {
    json!({ "textDocument": { "publishDiagnostics": { "relatedInformation": true } } })
}

#[tokio::test(flavor = "multi_thread")]
async fn pushed_diagnostics_follow_the_text_and_carry_its_version() {
    let folder = Folder::new(&[]);
    let mut client = Client::start(folder.params(pushing())).await;
    let uri = folder.uri("arm.gen");
    client.open(&uri, "const long é😀 = 1;\nconst long a @ = 1;\n").await;
    let pushed = client.pushed(&uri).await;
    assert_eq!(pushed["version"], 1);
    assert!(codes(&pushed["diagnostics"]).contains(&"lex-stray".to_owned()));
    client.change(&uri, 2, json!([{ "text": "const long a = 1;\n" }])).await;
    let pushed = client.pushed(&uri).await;
    assert_eq!((&pushed["version"], &pushed["diagnostics"]), (&json!(2), &json!([])));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn closed_files_of_the_workspace_are_pushed_too() {
    let folder = Folder::new(&[
        ("arm.gen", "#include \"pose.idl\"\n"),
        ("pose.idl", "struct pose { long x; }\n"),
        ("fine.gen", "const long a = 1;\n"),
    ]);
    let mut client = Client::start(folder.params(pushing())).await;
    let pushed = client.pushed(&folder.uri("pose.idl")).await;
    assert_eq!(codes(&pushed["diagnostics"]).len(), 1);
    assert!(pushed.get("version").is_none(), "it is not open");

    folder.write("pose.idl", "struct pose { long x; };\n");
    client.notify(DID_CHANGE_FILES, folder.event("pose.idl", 2)).await;
    let pushed = client.pushed(&folder.uri("pose.idl")).await;
    assert_eq!(pushed["diagnostics"], json!([]));

    folder.remove("pose.idl");
    client.notify(DID_CHANGE_FILES, folder.event("pose.idl", 3)).await;
    let pushed = client.pushed(&folder.uri("arm.gen")).await;
    assert_eq!(codes(&pushed["diagnostics"]), ["pp-include-not-found"]);

    folder.remove("arm.gen");
    client.notify(DID_CHANGE_FILES, folder.event("arm.gen", 3)).await;
    let pushed = client.pushed(&folder.uri("arm.gen")).await;
    assert_eq!(pushed["diagnostics"], json!([]));

    folder.write("more.gen", "const long a = 1\n");
    client.notify(DID_CHANGE_FILES, folder.event("more.gen", 1)).await;
    let pushed = client.pushed(&folder.uri("more.gen")).await;
    assert_ne!(pushed["diagnostics"], json!([]));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_an_open_document_says_counts_until_it_is_closed() {
    let folder = Folder::new(&[("arm.gen", "const long a = 1\n")]);
    let uri = folder.uri("arm.gen");
    let mut client = Client::start(folder.params(pushing())).await;
    assert_ne!(client.pushed(&uri).await["diagnostics"], json!([]));
    client.open(&uri, "const long a = 1;\n").await;
    assert_eq!(client.pushed(&uri).await["diagnostics"], json!([]));
    client.notify("textDocument/didClose", document(&uri)).await;
    assert_ne!(client.pushed(&uri).await["diagnostics"], json!([]));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn pulled_diagnostics_are_not_pushed_and_unchanged_ones_not_repeated() {
    let folder = Folder::new(&[]);
    let uri = folder.uri("arm.gen");
    let mut client = Client::start(folder.params(pulling())).await;
    client.open(&uri, "const long a = 1\n").await;
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    assert_eq!(report["kind"], "full");
    assert_eq!(codes(&report["items"]).len(), 1);

    let mut again = document(&uri);
    again["previousResultId"] = report["resultId"].clone();
    let report = client.ok("textDocument/diagnostic", again.clone()).await;
    assert_eq!(report["kind"], "unchanged");

    client.change(&uri, 2, json!([{ "text": "const long a = 1;\n" }])).await;
    let report = client.ok("textDocument/diagnostic", again).await;
    assert_eq!((&report["kind"], &report["items"]), (&json!("full"), &json!([])));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_workspace_is_pulled_and_waits_for_news() {
    let folder = Folder::new(&[
        ("a/arm.gen", "#include \"../pose.idl\"\n"),
        ("pose.idl", "struct pose { long x; }\n"),
        (".hidden/no.gen", "const long a = 1\n"),
    ]);
    let mut capabilities = pulling();
    capabilities["workspace"] = json!({ "diagnostics": { "refreshSupport": true } });
    let refresh = ("workspace/diagnostic/refresh", Value::Null);
    let mut client = Client::start_answering(folder.params(capabilities), vec![refresh]).await;
    let mut known: Vec<Value> = Vec::new();
    // The files are listed in the background: repeat the request until they are known.
    let report = loop {
        let params = json!({ "previousResultIds": known });
        let report = client.ok("workspace/diagnostic", params).await;
        let items = report["items"].as_array().expect("a list").clone();
        if !items.is_empty() {
            break items;
        }
        known.clear();
    };
    let with_errors: Vec<_> = report
        .iter()
        .filter(|report| report["items"] != json!([]))
        .map(|report| report["uri"].clone())
        .collect();
    assert_eq!(with_errors, [json!(folder.uri("pose.idl"))]);
    assert_eq!(report.len(), 2, "hidden directories are not searched");
    known = report
        .iter()
        .map(|report| json!({ "uri": report["uri"], "value": report["resultId"] }))
        .collect();
    let id = client.begin("workspace/diagnostic", json!({ "previousResultIds": known })).await;
    folder.write("pose.idl", "struct pose { long x; };\n");
    client.notify(DID_CHANGE_FILES, folder.event("pose.idl", 2)).await;
    let report = client.end(id).await.expect("news");
    let changed: Vec<_> = report["items"]
        .as_array()
        .expect("a list")
        .iter()
        .filter(|json| json["kind"] == "full")
        .collect();
    assert_eq!(changed.len(), 1);
    assert_eq!(changed[0]["items"], json!([]));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn inactive_regions_are_announced_or_hinted() {
    let text = "#if 0\nconst long a = 1;\n#endif\n";
    let folder = Folder::new(&[]);
    let uri = folder.uri("arm.gen");

    let mut capabilities = pulling();
    capabilities["textDocument"]["inactiveRegionsCapabilities"] =
        json!({ "inactiveRegions": true });
    let mut client = Client::start(folder.params(capabilities)).await;
    client.open(&uri, text).await;
    let params = client.notification("textDocument/inactiveRegions").await;
    assert_eq!(params["textDocument"], json!({ "uri": uri, "version": 1 }));
    assert_eq!(params["regions"][0]["start"]["line"], 1);
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    assert_eq!(report["items"], json!([]));
    client.change(&uri, 2, json!([{ "text": "" }])).await;
    let params = client.notification("textDocument/inactiveRegions").await;
    assert_eq!(params["regions"], json!([]));
    client.finish().await;

    let mut client = Client::start(folder.params(pulling())).await;
    client.open(&uri, text).await;
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    let hint = &report["items"][0];
    assert_eq!((&hint["severity"], &hint["tags"]), (&json!(4), &json!([1])));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn untitled_documents_have_diagnostics() {
    let mut client = Client::start(json!({ "capabilities": pushing() })).await;
    let uri = "untitled:Untitled-1";
    client.open(uri, "const long a = 1\n").await;
    let pushed = client.pushed(uri).await;
    assert_eq!(codes(&pushed["diagnostics"]).len(), 1);
    client.notify("textDocument/didClose", document(uri)).await;
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_wants_parts_gets_the_open_files_first_and_each_file_once() {
    let names: Vec<String> = (0..70).map(|i| format!("part{i:02}.gen")).collect();
    let files: Vec<(&str, &str)> =
        names.iter().map(|name| (name.as_str(), "const long a = 1\n")).collect();
    let folder = Folder::new(&files);
    let mut client = Client::start(folder.params(pulling())).await;
    let last = folder.uri(&names[69]);
    client.open(&last, "const long a = 1\n").await;
    // The list of files and the settings arrive later.
    let mut asked = json!({ "previousResultIds": [] });
    let mut listed = 0;
    while listed < 70 {
        let id = client.begin("workspace/diagnostic", asked.clone()).await;
        match client.end(id).await {
            Ok(answer) => listed = answer["items"].as_array().map_or(0, Vec::len),
            Err(error) => assert_eq!(error["data"]["retriggerRequest"], true, "{error}"),
        }
    }
    asked["partialResultToken"] = json!("parts");
    let answer = client.ok("workspace/diagnostic", asked).await;
    assert_eq!(answer["items"], json!([]), "all was told before");
    let mut told = Vec::new();
    while told.len() < 70 {
        let part = client.notification("$/progress").await;
        if part["token"] == "parts" {
            for json in part["value"]["items"].as_array().into_iter().flatten() {
                assert_eq!(codes(&json["items"]), ["missing-semicolon"]);
                let uri = json["uri"].as_str().unwrap_or_default().to_owned();
                told.push(uri);
            }
        }
    }
    assert_eq!(told[0], last);
    told.sort();
    told.dedup();
    assert_eq!(told.len(), 70);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn of_a_file_that_is_too_large_only_that_is_said() {
    let folder = Folder::new(&[("dotgen.toml", "max-file-size = 1\n")]);
    let uri = folder.uri("arm.gen");
    let mut client = Client::start(folder.params(pulling())).await;
    client.open(&uri, &"const long a = 1\n".repeat(100)).await;
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    assert_eq!(codes(&report["items"]), ["pp-input"]);
    let formatted = json!({ "textDocument": { "uri": uri },
        "options": { "tabSize": 2, "insertSpaces": true } });
    let edits = client.ok("textDocument/formatting", formatted).await;
    assert!(edits.as_array().is_none_or(Vec::is_empty), "{edits}");
    client.change(&uri, 2, json!([{ "text": "const long a = 1\n" }])).await;
    assert_eq!(client.pulled(&uri).await, ["missing-semicolon"]);
    client.finish().await;
}
