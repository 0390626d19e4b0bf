//! Navigation between both sides, and the sources that are served.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn from_codels_to_functions_and_back() {
    let folder = tank();
    let (uri, source) = (folder.uri("tank.gen"), folder.uri("codels/tank_control_codels.c"));
    let (text, code) = (read(path(&uri)), read(path(&source)));
    let mut capabilities = capable();
    capabilities["window"] = json!({ "showDocument": { "support": true } });
    let answers = vec![("window/showDocument", json!({ "success": true }))];
    let mut client = Client::start_answering(folder.params(capabilities), answers).await;
    client.open(&uri, &text).await;
    client.open_code(&source, &code).await;

    let params = at(&uri, &text, "tank_fill_wait", 0);
    let found = client.ok("textDocument/implementation", params.clone()).await;
    assert_eq!(found[0]["uri"], source);
    assert_eq!(found[0]["range"]["start"], place(&code, "tank_fill_wait(double", 0));

    let mut references = params;
    references["context"] = json!({ "includeDeclaration": true });
    let found = client.ok("textDocument/references", references).await;
    let uris: Vec<_> =
        found.as_array().expect("a list").iter().map(|client| client["uri"].clone()).collect();
    assert_eq!(uris, [json!(uri), json!(source)]);

    let mut references = at(&source, &code, "tank_fill_wait(double", 0);
    references["context"] = json!({ "includeDeclaration": true });
    let found = client.ok("textDocument/references", references).await;
    assert_eq!(found[0]["uri"], uri);
    assert_eq!(found[0]["range"]["start"], place(&text, "tank_fill_wait", 0));

    let lenses = client.ok("textDocument/codeLens", document(&source)).await;
    let titles: Vec<_> = lenses
        .as_array()
        .expect("a list")
        .iter()
        .map(|lens| lens["command"]["title"].as_str().unwrap_or_default().to_owned())
        .collect();
    assert_eq!(
        titles,
        [
            "task control: start → main · excludes tank_get_level, tank_reset_cycles",
            "task control: main → pause::main, stop · excludes tank_get_level, set_gain",
            "activity fill: start → wait",
            "activity fill: wait → pause::wait, ether",
            "activity fill: stop → ether",
            "activity drain: start → wait",
        ]
    );
    let command = &lenses[3]["command"];
    let params = json!({ "command": command["command"], "arguments": command["arguments"] });
    client.ok("workspace/executeCommand", params).await;
    while client.asked.is_empty() {
        client.ok("textDocument/codeLens", document(&source)).await;
    }
    let shown = &client.asked[0]["params"];
    assert_eq!(shown["uri"], uri);
    assert_eq!(shown["selection"]["start"], place(&text, "tank_fill_wait", 0));
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn names_in_sources_lead_to_their_declarations() {
    let folder = tank();
    let (uri, source) = (folder.uri("tank.gen"), folder.uri("codels/tank_control_codels.c"));
    let (text, code) = (read(path(&uri)), read(path(&source)));
    // A variable in place of a parameter.
    let code = code.replace("*setpoint = until;", "{ double until = 1.; *setpoint = until; }");
    let mut client = Client::start(folder.params(capable())).await;
    client.open(&uri, &text).await;
    client.open_code(&source, &code).await;
    // The place in the source, the declaration with its distance to the name, and the line of the hover that
    // describes it.
    for (name, skip, declaration, to, said) in [
        ("last->level", 6, "double level;", 7, "double level"),
        (".valve = valve", 1, "short valve", 6, "short valve"),
        ("tank_CLOSED", 0, "CLOSED, MOVING", 0, "CLOSED"),
        ("tank_reading *out", 0, "reading {", 0, "reading"),
        ("tank_e_valve_detail", 0, "e_valve {", 0, "e_valve"),
        ("return tank_main", 7, "main> tank_control_main", 0, "main"),
        ("return tank_pause_main", 7, "main> tank_control_main", 0, "main"),
        ("tank_wait;\n}\n\n/** Codel tank_fill", 0, "wait> tank_fill_wait", 0, "wait"),
        ("tank_wait;\n}\n$", 0, "wait> tank_drain_wait", 0, "wait"),
        ("target ? ", 0, "target, in reading limit", 0, "target"),
        ("state->data", 0, "state;\n\n  task", 0, "state"),
        ("\ntank_fill_stop(", 1, "tank_fill_stop(ids", 0, "tank_fill_stop"),
    ] {
        let at = match name.strip_suffix('$') {
            Some(last) => code.rfind(last),
            None => code.find(name),
        };
        let at = at.unwrap_or_else(|| panic!("{name}")) + skip;
        let params = json!({
            "textDocument": { "uri": source },
            "position": place_at(&code, at),
        });
        let found = client.ok("textDocument/definition", params.clone()).await;
        let wanted = place_at(&text, text.find(declaration).expect(declaration) + to);
        assert_eq!(found[0]["uri"], uri, "{name}: {found:#}");
        assert_eq!(found[0]["range"]["start"], wanted, "{name}: {found:#}");
        let hover = client.ok("textDocument/hover", params.clone()).await;
        let markdown = hover["contents"]["value"].as_str().unwrap_or_default();
        assert!(markdown.contains(said), "{name}: {markdown}");
        let mut references = params;
        references["context"] = json!({ "includeDeclaration": true });
        let found = client.ok("textDocument/references", references).await;
        let found = found.as_array().cloned().unwrap_or_default();
        let starts: Vec<_> = found.iter().map(|client| &client["range"]["start"]).collect();
        assert!(starts.contains(&&wanted), "{name}: {found:#?}");
        assert!(found.iter().all(|client| client["uri"] == uri), "{name}: {found:#?}");
    }
    // Names that only the source declares belong to the server of its language.
    for name in ["out = state", "NULL", "data(self)", "tank_stuck(0", "until; }"] {
        let params = at(&source, &code, name, 0);
        let found = client.ok("textDocument/definition", params.clone()).await;
        assert_eq!(found, Value::Null, "{name}");
        let hover = client.ok("textDocument/hover", params).await;
        assert_eq!(hover, Value::Null, "{name}");
    }
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn values_of_a_codel_are_proposed_after_return() {
    let folder = tank();
    let (uri, source) = (folder.uri("tank.gen"), folder.uri("codels/tank_control_codels.c"));
    let (text, code) = (read(path(&uri)), read(path(&source)));
    let code = code.replace("return tank_main;", "/* return */ return ");
    let mut client = Client::start(folder.params(capable())).await;
    client.open(&uri, &text).await;
    client.open_code(&source, &code).await;
    let labels = async |client: &mut Client, after: &str| {
        let at = code.find(after).expect(after) + after.len();
        let params = json!({ "textDocument": { "uri": source }, "position": place_at(&code, at) });
        let found = client.ok("textDocument/completion", params).await;
        let items = found.as_array().cloned().unwrap_or_default();
        let labels = items.iter().map(|item| item["label"].as_str().map(str::to_owned));
        labels.collect::<Option<Vec<String>>>().unwrap_or_default()
    };
    assert_eq!(
        labels(&mut client, "/* return */ return ").await,
        ["tank_main", "tank_e_valve(&(tank_e_valve_detail){0}, self)"]
    );
    let paused = labels(&mut client, "return tank_p").await;
    assert_eq!(paused[..2], ["tank_pause_main", "tank_stop"]);
    assert!(labels(&mut client, "/* return ").await.is_empty());
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_codel_is_renamed_on_both_sides() {
    let folder = tank();
    let (uri, source) = (folder.uri("tank.gen"), folder.uri("codels/tank_control_codels.c"));
    let text = read(path(&uri));
    let mut client = Client::start(folder.params(capable())).await;
    let before = check(&path(&uri));
    let mut params = at(&uri, &text, "tank_fill_wait", 0);
    params["newName"] = json!("tank_fill_watch");
    let edit = client.ok("textDocument/rename", params.clone()).await;
    // The edit changes several files: it is reviewed first.
    let reviewed = &edit["changeAnnotations"]["reviewed"];
    assert_eq!(reviewed["needsConfirmation"], true, "{edit:#}");
    assert_eq!(reviewed["label"], "Rename to tank_fill_watch");
    write(&edit);
    let code = read(path(&source));
    assert!(code.contains("\ntank_fill_watch(double target"), "{code}");
    assert!(code.contains("Codel tank_fill_watch of activity fill"), "{code}");
    let after: Vec<_> =
        check(&path(&uri)).iter().map(|check| check.replace("fill_watch", "fill_wait")).collect();
    assert_eq!(after, before);

    params["newName"] = json!("tank_fill_stop");
    let refused =
        client.request("textDocument/rename", params).await.expect_err("the name is taken");
    let message = refused["message"].as_str().unwrap_or_default();
    assert!(message.contains("tank_fill_stop"), "{message}");
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn sources_are_left_to_the_server_of_their_language() {
    let folder = tank();
    let (source, other) = (folder.uri("codels/tank_codels.c"), folder.uri("main.c"));
    let code = read(path(&source));
    let mut client = Client::start(folder.params(capable())).await;
    client.open_code(&source, &code).await;
    client.open_code(&other, "int main(void) { return 0; }\n").await;
    for method in [
        "textDocument/documentSymbol",
        "textDocument/foldingRange",
        "textDocument/completion",
        "textDocument/semanticTokens/full",
        "textDocument/prepareRename",
    ] {
        let found = client.ok(method, at(&source, &code, "tank_mix", 1)).await;
        assert_eq!(found, Value::Null, "{method}");
    }
    let lenses = client.ok("textDocument/codeLens", document(&other)).await;
    assert_eq!(lenses, json!([]));
    // A source outside of folders of codels has no findings.
    client.pushed(&source).await;
    client.ok("test/text", document(&folder.uri("tank.gen"))).await;
    client.ok("shutdown", Value::Null).await;
    for message in client.all() {
        assert_ne!(message["params"]["uri"], other, "{message}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn sources_are_asked_for_where_clients_let_choose() {
    let folder = tank();
    let dynamic = json!({ "dynamicRegistration": true });
    let mut capabilities = capable();
    for method in ["synchronization", "codeAction", "codeLens", "definition", "hover", "references"]
    {
        capabilities["textDocument"][method]["dynamicRegistration"] = json!(true);
    }
    capabilities["workspace"]["didChangeWatchedFiles"] = dynamic;
    let answers = vec![
        ("client/registerCapability", Value::Null),
        ("client/unregisterCapability", Value::Null),
    ];
    let mut client = Client::start_answering(folder.params(capabilities), answers).await;
    client.pushed(&folder.uri("tank.gen")).await;
    let lens = |asked: &[Value]| -> Vec<Value> {
        let all = asked.iter().flat_map(|message| {
            message["params"]["registrations"].as_array().cloned().unwrap_or_default()
        });
        all.filter(|registration| registration["method"] == "textDocument/codeLens").collect()
    };
    while lens(&client.asked).is_empty() {
        client.ok("test/text", document(&folder.uri("tank.gen"))).await;
    }
    let selector = &lens(&client.asked)[0]["registerOptions"]["documentSelector"];
    assert_eq!(
        *selector,
        json!([
            { "language": "c", "scheme": "file", "pattern": "**/codels/**" },
            { "language": "cpp", "scheme": "file", "pattern": "**/codels/**" },
        ])
    );
    folder.write("dotgen.toml", "[codels]\nfolder = \"src\"\n");
    client.notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 1)).await;
    while lens(&client.asked).len() < 2 {
        client.ok("test/text", document(&folder.uri("tank.gen"))).await;
    }
    let selector = &lens(&client.asked)[1]["registerOptions"]["documentSelector"];
    assert_eq!(selector[0]["pattern"], "**/src/**");
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}
