//! `dotgen/interfaces` and `dotgen/newComponent`.

use serde_json::{Value, json};

use super::client::{Client, Folder};

const POSE: &str = "struct pose_s { double x; };
interface pose { port out pose_s position; };
interface driven { port in pose_s goal; activity go() { }; };
";

async fn start() -> (Client, Folder) {
    let folder = Folder::new(&[
        ("idl/pose.gen", POSE),
        ("arm/arm.gen", "component arm { version \"1\"; lang \"c\"; };\n"),
    ]);
    let client = Client::start(folder.params(json!({}))).await;
    (client, folder)
}

#[tokio::test(flavor = "multi_thread")]
async fn interfaces_that_can_be_included_are_listed() {
    let (mut client, folder) = start().await;
    let found = client.ok("dotgen/interfaces", json!({})).await;
    let uri = folder.uri("idl/pose.gen");
    assert_eq!(
        found,
        json!([
            { "name": "driven", "uri": uri, "ports": ["in goal"], "canBeProvided": false },
            { "name": "pose", "uri": uri, "ports": ["out position"], "canBeProvided": true },
        ])
    );
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_component_comes_with_scenario_and_codels() {
    let (mut client, folder) = start().await;
    let pose = json!([{ "name": "pose", "uri": folder.uri("idl/pose.gen") }]);
    let mut params = json!({
        "folder": folder.uri("nav"),
        "name": "nav",
        "tasks": [{ "name": "track", "period": "20 ms" }, { "name": "plan" }],
        "uses": pose,
    });
    let made = client.ok("dotgen/newComponent", params.clone()).await;
    let files = made["files"].as_array().expect("files");
    let names: Vec<String> = files
        .iter()
        .map(|file| {
            let uri = file["uri"].as_str().expect("a URI");
            uri.trim_start_matches(&folder.uri("")).trim_start_matches('/').to_owned()
        })
        .collect();
    assert_eq!(
        names,
        [
            "nav/nav.gen",
            "nav/nav.scn",
            "nav/codels/nav_codels.c",
            "nav/codels/nav_plan_codels.c",
            "nav/codels/nav_track_codels.c"
        ]
    );
    insta::assert_snapshot!(files[0]["text"].as_str().expect("a text"));
    insta::assert_snapshot!(files[1]["text"].as_str().expect("a text"));
    let track = files[4]["text"].as_str().expect("a text");
    assert!(track.contains("\nnav_track_main("), "{track}");

    params["folder"] = json!(folder.uri("arm"));
    params["name"] = json!("arm");
    let refused =
        client.request("dotgen/newComponent", params.clone()).await.expect_err("it is there");
    let message = refused["message"].as_str().unwrap_or_default();
    assert!(message.contains("`arm/arm.gen` is there already"), "{message}");
    params["name"] = json!("struct");
    let refused = client.request("dotgen/newComponent", params).await;
    let refused: Value = refused.expect_err("it is a word of the language");
    assert_eq!(refused["code"], -32803, "{refused}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_sources_of_a_new_component_are_known_without_an_event() {
    let folder = Folder::new(&[("README", "")]);
    let mut client = Client::start(folder.params(super::client::pulling())).await;
    let tasks = json!([{ "name": "exec", "period": "10 ms" }]);
    let params = json!({ "folder": folder.uri("arm"), "name": "arm", "tasks": tasks });
    let made = client.ok("dotgen/newComponent", params).await;
    for file in made["files"].as_array().expect("files") {
        let name = file["uri"].as_str().and_then(|uri| uri.strip_prefix(&folder.uri("")));
        let name = name.expect("in the folder").trim_start_matches('/');
        folder.write(name, file["text"].as_str().expect("a text"));
    }
    let uri = folder.uri("arm/arm.gen");
    let text = folder.read("arm/arm.gen");
    client.open(&uri, &text).await;
    assert_eq!(client.pulled(&uri).await, [""; 0]);
    let end = text.rfind("};").expect("the end of the component");
    let more = format!("{}  function go() {{ codel arm_go() wcet 1 ms; }};\n}};\n", &text[..end]);
    client.change(&uri, 2, json!([{ "text": more }])).await;
    assert_eq!(client.pulled(&uri).await, ["codel/missing-definition"]);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_that_is_not_found_is_searched_where_it_is() {
    let folder = Folder::new(&[
        ("share/idl/or/pose.idl", "struct pose { double x; };\n"),
        ("dotgen.toml", "# ours\nrelease = \"2.99.41\"\n"),
    ]);
    let edits = json!({ "documentChanges": true, "resourceOperations": ["create"] });
    let capable = json!({
        "textDocument": { "codeAction": { "codeActionLiteralSupport": { "codeActionKind": { "valueSet": [] } } } },
        "workspace": { "workspaceEdit": edits },
    });
    let mut client = Client::start(folder.params(capable)).await;
    let uri = folder.uri("arm.gen");
    client.open(&uri, "#include \"or/pose.idl\"\n").await;
    let mut params = super::client::document(&uri);
    let at = json!({ "line": 0, "character": 12 });
    params["range"] = json!({ "start": at, "end": at });
    params["context"] = json!({ "diagnostics": [] });
    let actions = client.ok("textDocument/codeAction", params).await;
    let title = "Search `share/idl` for included files, in dotgen.toml";
    let mut all = actions.as_array().expect("actions").iter();
    let action = all.find(|action| action["title"] == title);
    let change = &action.unwrap_or_else(|| panic!("{actions:#}"))["edit"]["documentChanges"][0];
    assert_eq!(change["textDocument"]["uri"], folder.uri("dotgen.toml"));
    assert_eq!(change["edits"][0]["newText"], "include-paths = [\"share/idl\"]\n");
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

/// The quick fix with a title among the [`quick_fixes`].
async fn quick_fix(folder: &Folder, at: Value, title: &str) -> (Client, String, Value) {
    let (client, uri, all) = quick_fixes(folder, at).await;
    let action = all.iter().find(|json| json["title"] == title).cloned();
    (client, uri, action.unwrap_or_else(|| panic!("{all:#?}")))
}

/// A client that can create files, with `arm.gen` open, and the quick fixes at a place in it.
async fn quick_fixes(folder: &Folder, at: Value) -> (Client, String, Vec<Value>) {
    let mut capable = super::client::pulling();
    capable["textDocument"]["codeAction"] =
        json!({ "codeActionLiteralSupport": { "codeActionKind": { "valueSet": [] } } });
    capable["workspace"] = json!({
        "workspaceEdit": { "documentChanges": true, "resourceOperations": ["create"] }
    });
    let mut client = Client::start(folder.params(capable)).await;
    let uri = folder.uri("arm.gen");
    client.open(&uri, &folder.read("arm.gen")).await;
    let mut params = super::client::document(&uri);
    params["range"] = json!({ "start": at, "end": at });
    params["context"] = json!({ "diagnostics": [] });
    let actions = client.ok("textDocument/codeAction", params).await;
    (client, uri, actions.as_array().expect("actions").clone())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_package_that_is_not_found_is_searched_where_it_is() {
    const PACKAGE: (&str, &str) =
        ("devel/lib/pkgconfig/pose-idl.pc", "Name: pose\nDescription: x\nVersion: 1.2\n");
    let arm = ("arm.gen", "#pragma requires \"pose-idl >= 1\"\n");
    let settings = [
        (None, "package-paths = [\"devel/lib/pkgconfig\"]\n"),
        (
            Some("# ours\npackage-paths = [\"pc\"] # more\n"),
            "# ours\npackage-paths = [\"pc\", \"devel/lib/pkgconfig\"] # more\n",
        ),
    ];
    for (before, after) in settings {
        let mut files = vec![arm, PACKAGE];
        files.extend(before.map(|text| ("dotgen.toml", text)));
        let folder = Folder::new(&files);
        let title = "Search `devel/lib/pkgconfig` for packages, in dotgen.toml";
        let at = json!({ "line": 0, "character": 22 });
        let (mut client, uri, action) = quick_fix(&folder, at, title).await;
        super::codels::write(&action["edit"]);
        assert_eq!(folder.read("dotgen.toml"), after);
        // With the setting, the package is found.
        let event = folder.event("dotgen.toml", if before.is_some() { 2 } else { 1 });
        client.notify("workspace/didChangeWatchedFiles", event).await;
        assert_eq!(client.pulled(&uri).await, [""; 0]);
        client.ignore("textDocument/publishDiagnostics");
        drop(client);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stand_in_is_written_for_an_interface_by_its_use() {
    let text = "#include \"nav/nav.gen\"
component arm {
  version \"1\"; lang \"c\";
  provides nav;
  activity go(in long n) {
    task motion;
    codel<start> armGo(in n, port in goal, local out plan) yield ether;
    interrupts track;
  };
};
";
    let folder = Folder::new(&[("arm.gen", text)]);
    let at = json!({ "line": 0, "character": 12 });
    let title = "Write a stand-in for `nav/nav.gen`";
    let (mut client, uri, action) = quick_fix(&folder, at, title).await;
    super::codels::write(&action["edit"]);
    let standin = folder.read(".dotgen/standins/nav/nav.gen");
    for part in ["task motion", "track()", "activity go(in long n)", "port in ", "local "] {
        assert!(standin.contains(part), "{part}: {standin}");
    }
    assert_eq!(folder.read(".dotgen/.gitignore"), "*\n");
    let event = folder.event(".dotgen/standins/nav/nav.gen", 1);
    client.notify("workspace/didChangeWatchedFiles", event).await;
    let left = client.pulled(&uri).await;
    assert!(!left.iter().any(|left| left == "pp-include-not-found"), "{left:?}");
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_package_and_what_it_may_bring_have_the_same_offers() {
    let text = "#pragma require \"nav-idl\"\n#include \"nav/nav.gen\"\n#include \"nav/map.gen\"\n";
    let folder = Folder::new(&[
        ("arm.gen", text),
        ("idl/nav/nav.gen", "interface nav {};\n"),
        ("idl/nav/map.gen", "interface map {};\n"),
        ("pc/nav-idl.pc", "Name: nav\nDescription: x\nVersion: 1\n"),
    ]);
    for line in [0, 1] {
        for title in [
            "Search `idl` for included files, in dotgen.toml",
            "Search `pc` for packages, in dotgen.toml",
            "Write a stand-in for `nav/nav.gen`",
        ] {
            let at = json!({ "line": line, "character": 12 });
            let (mut client, _, all) = quick_fixes(&folder, at).await;
            let titles = all.iter().filter(|json| json["title"] == title);
            assert_eq!(titles.count(), 1, "{all:#?}");
            client.ignore("textDocument/publishDiagnostics");
            drop(client);
        }
    }
}
