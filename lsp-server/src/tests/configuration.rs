use serde_json::{Value, json};

use super::client::{Client, Folder, codes, pulling};

const ARM: &str = "#include <pose.idl>\n#ifdef BROKEN\n#error broken\n#endif\n";

fn folder(toml: &str) -> Folder {
    Folder::new(&[("arm.gen", ARM), ("idl/pose.idl", "const long a = 1;\n"), ("dotgen.toml", toml)])
}

async fn found(client: &mut Client, folder: &Folder) -> Vec<String> {
    let mut codes = client.pulled(&folder.uri("arm.gen")).await;
    codes.retain(|code| code != "inactive-code");
    codes
}

#[tokio::test(flavor = "multi_thread")]
async fn the_file_of_a_folder_counts_and_may_change() {
    let folder = folder("include-paths = ['idl']\n");
    let mut client = Client::start(folder.params(pulling())).await;
    assert_eq!(found(&mut client, &folder).await, [""; 0]);
    folder.write("dotgen.toml", "include-paths = ['idl']\ndefines = { BROKEN = true }\n");
    client.notify("workspace/didChangeWatchedFiles", folder.event("dotgen.toml", 2)).await;
    assert_eq!(found(&mut client, &folder).await, ["pp-error-directive"]);
    client.ignore("textDocument/publishDiagnostics");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn problems_of_the_file_are_shown_in_it() {
    let folder = folder("include-paths = ['idl']\nincludes = 1\n[severity]\nsyntax = 3\n");
    let mut client = Client::start(folder.params(pulling())).await;
    let pushed = client.pushed(&folder.uri("dotgen.toml")).await;
    let diagnostics = &pushed["diagnostics"];
    assert_eq!(codes(diagnostics), ["config-unknown-key", "config-bad-value"]);
    assert_eq!(diagnostics[0]["range"]["start"], json!({ "line": 1, "character": 0 }));
    assert_eq!(diagnostics[0]["severity"], 2);
    assert_eq!(found(&mut client, &folder).await, [""; 0], "the rest counts");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn settings_are_pulled_from_clients_that_can_be_asked() {
    let folder = folder("");
    let mut capabilities = pulling();
    capabilities["workspace"] = json!({
        "configuration": true,
        "didChangeConfiguration": { "dynamicRegistration": true },
        "didChangeWatchedFiles": { "dynamicRegistration": true },
        "diagnostics": { "refreshSupport": true },
    });
    let settings = json!({ "includePaths": ["idl"], "defines": {}, "severity": {} });
    let answers = vec![
        ("client/registerCapability", Value::Null),
        ("workspace/configuration", json!([settings, settings])),
        ("workspace/diagnostic/refresh", Value::Null),
    ];
    let mut client = Client::start_answering(folder.params(capabilities), answers).await;
    while found(&mut client, &folder).await != [""; 0] {}
    let question = client
        .asked
        .iter()
        .find(|message| message["method"] == "workspace/configuration")
        .expect("it asked");
    let items = question["params"]["items"].clone();
    assert_eq!(
        items,
        json!([{ "section": "dotgen" }, { "section": "dotgen", "scopeUri": folder.uri("") }])
    );
    let registered = client
        .asked
        .iter()
        .find(|message| message["method"] == "client/registerCapability")
        .expect("it registered");
    assert_eq!(registered["params"]["registrations"].as_array().map(Vec::len), Some(2));

    let settings = json!({ "includePaths": ["idl"], "defines": { "BROKEN": 1 } });
    client.answer("workspace/configuration", json!([settings, settings]));
    client.notify("workspace/didChangeConfiguration", json!({ "settings": null })).await;
    while found(&mut client, &folder).await != ["pp-error-directive"] {}
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn settings_are_pushed_by_the_others() {
    let folder = folder("");
    let mut client = Client::start(folder.params(pulling())).await;
    assert_eq!(found(&mut client, &folder).await, ["pp-include-not-found"]);
    for (settings, expected) in [
        (json!({ "dotgen": { "includePaths": ["idl"] } }), &[][..]),
        (
            json!({ "includePaths": ["idl"], "defines": { "BROKEN": true } }),
            &["pp-error-directive"],
        ),
        (json!({ "dotgen.includePaths": ["idl"] }), &[]),
        (json!({}), &["pp-include-not-found"]),
    ] {
        let params = json!({ "settings": settings });
        client.notify("workspace/didChangeConfiguration", params).await;
        assert_eq!(found(&mut client, &folder).await, expected, "{settings}");
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn folders_come_and_go() {
    let folder = folder("include-paths = ['idl']\n");
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    let change = |added: bool| {
        let value = json!([{ "uri": folder.uri(""), "name": "test" }]);
        let (added, removed) = if added { (value, json!([])) } else { (json!([]), value) };
        json!({ "event": { "added": added, "removed": removed } })
    };
    let method = "workspace/didChangeWorkspaceFolders";
    assert_eq!(found(&mut client, &folder).await, ["pp-include-not-found"]);
    client.notify(method, change(true)).await;
    assert_eq!(found(&mut client, &folder).await, [""; 0]);
    client.notify(method, change(false)).await;
    assert_eq!(found(&mut client, &folder).await, ["pp-include-not-found"]);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_without_a_workspace_is_configured_by_its_surroundings() {
    let folder = folder("include-paths = ['idl']\n");
    let mut client = Client::start(json!({ "capabilities": pulling() })).await;
    client.open(&folder.uri("arm.gen"), ARM).await;
    assert_eq!(found(&mut client, &folder).await, [""; 0]);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn packages_are_read_without_running_anything_when_nobody_trusts() {
    let folder = Folder::new(&[
        ("arm.gen", "#pragma requires \"pose-idl >= 1\"\n#include <pose.idl>\n"),
        ("inc/pose.idl", "const long a = 1;\n"),
        (
            "pc/pose-idl.pc",
            "Name: pose\nDescription: x\nVersion: 1.2\nCflags: -I${pcfiledir}/../inc\n",
        ),
        ("dotgen.toml", "package-paths = ['pc']\n"),
    ]);
    let mut client = Client::start(folder.params(pulling())).await;
    assert_eq!(found(&mut client, &folder).await, [""; 0]);
    folder.write("pc/pose-idl.pc", "Name: pose\nDescription: x\nVersion: 0.9\n");
    client.notify("workspace/didChangeWatchedFiles", folder.event("pc/pose-idl.pc", 2)).await;
    let codes = found(&mut client, &folder).await;
    assert!(codes.contains(&"pp-requires-unresolved".to_owned()), "{codes:?}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn indexing_shows_progress() {
    let folder = folder("");
    let mut capabilities = pulling();
    capabilities["window"] = json!({ "workDoneProgress": true });
    let answers = vec![("window/workDoneProgress/create", Value::Null)];
    let mut client = Client::start_answering(folder.params(capabilities), answers).await;
    let begin = client.notification("$/progress").await;
    assert_eq!(begin["value"]["kind"], "begin");
    let end = client.notification("$/progress").await;
    assert_eq!(end["value"], json!({ "kind": "end", "message": "1 specification" }));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn wrong_settings_of_the_editor_are_shown_once() {
    let folder = folder("");
    let mut params = folder.params(pulling());
    params["initializationOptions"] = json!({ "settings": { "includePaths": "idl" } });
    let mut client = Client::start(params).await;
    let shown = client.notification("window/showMessage").await;
    let message = shown["message"].as_str().expect("a text");
    assert!(
        message.ends_with("bad value for `dotgen.includePaths`: expected a list of directories")
    );
    for settings in [json!({ "inclde-paths": [] }), json!({ "inclde-paths": [] })] {
        let params = json!({ "settings": { "dotgen": settings } });
        client.notify("workspace/didChangeConfiguration", params).await;
    }
    let shown = client.notification("window/showMessage").await;
    let message = shown["message"].as_str().expect("a text");
    assert!(message.ends_with("did you mean `dotgen.includePaths`?"), "{message}");
    client.finish().await;
}

/// One wrong value is named, and the other settings of the message apply.
#[tokio::test(flavor = "multi_thread")]
async fn the_settings_next_to_a_wrong_one_apply() {
    let folder = folder("");
    let mut client = Client::start(folder.params(pulling())).await;
    client.notify("workspace/didChangeConfiguration", json!([])).await;
    let settings = json!({ "includePaths": ["idl"], "maxFileSize": "large", "severity": 4 });
    let params = json!({ "settings": { "dotgen": settings } });
    client.notify("workspace/didChangeConfiguration", params).await;
    for field in ["maxFileSize", "severity"] {
        let shown = client.notification("window/showMessage").await;
        let message = shown["message"].as_str().expect("a text");
        let start = format!("dotgen, editor settings: bad value for `dotgen.{field}`: ");
        assert!(message.starts_with(&start), "{message}");
    }
    assert_eq!(found(&mut client, &folder).await, [""; 0]);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn projects_below_a_folder_are_read_as_they_say() {
    let part = "#include \"types.idl\"\nstruct s { own x[SIZE]; };\n";
    let toml = "include-paths = ['idl']\ndefines = { SIZE = 3 }\n";
    let folder = Folder::new(&[
        ("a/a.gen", part),
        ("a/idl/types.idl", "typedef long own;\n"),
        ("a/dotgen.toml", toml),
        ("b/b.gen", &part.replace("own x", "other x")),
        ("b/idl/types.idl", "typedef double other;\n"),
        ("b/dotgen.toml", toml),
        ("c/c.gen", part),
    ]);
    let mut client = Client::start(folder.params(pulling())).await;
    for name in ["a/a.gen", "b/b.gen"] {
        let uri = folder.uri(name);
        client.open(&uri, &folder.read(name)).await;
        assert_eq!(client.pulled(&uri).await, [""; 0], "{name}");
    }
    let without = client.pulled(&folder.uri("c/c.gen")).await;
    assert!(without.contains(&"pp-include-not-found".to_owned()), "{without:?}");

    // A file that is written later, and one that is deleted.
    folder.write("c/idl/types.idl", "typedef long own;\n");
    folder.write("c/dotgen.toml", toml);
    folder.remove("b/dotgen.toml");
    for (name, kind) in [("c/dotgen.toml", 1), ("b/dotgen.toml", 3)] {
        let event = folder.event(name, kind);
        client.notify("workspace/didChangeWatchedFiles", event).await;
    }
    assert_eq!(client.pulled(&folder.uri("c/c.gen")).await, [""; 0]);
    let without = client.pulled(&folder.uri("b/b.gen")).await;
    assert!(without.contains(&"pp-include-not-found".to_owned()), "{without:?}");
    client.ignore("textDocument/publishDiagnostics");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_folder_that_is_deleted_takes_its_files_with_it() {
    let folder = folder("include-paths = ['idl']\n");
    let mut client = Client::start(folder.params(pulling())).await;
    assert_eq!(found(&mut client, &folder).await, [""; 0]);
    folder.remove("idl/pose.idl");
    // Clients report only the folder.
    let event = folder.event("idl", 3);
    client.notify("workspace/didChangeWatchedFiles", event).await;
    assert_eq!(found(&mut client, &folder).await, ["pp-include-not-found"]);
    client.finish().await;
}
