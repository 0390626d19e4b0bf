//! The places of findings about codels, and the times at which they are shown.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn drift_is_shown_once_without_a_document_being_open() {
    let folder = tank();
    let mut client = Client::start(folder.params(capable())).await;
    let mut shown = BTreeMap::new();
    for name in FILES {
        let pushed = client.pushed(&folder.uri(name)).await;
        shown.insert(name, pushed["diagnostics"].clone());
    }
    for message in check(&path(&folder.uri("tank.gen"))) {
        let times = shown.values().flat_map(messages);
        assert_eq!(times.filter(|time| *time == message).count(), 1, "{message}");
        let is_missing = message.starts_with("codel/missing-definition");
        assert_eq!(messages(&shown["tank.gen"]).contains(&message), is_missing, "{message}");
    }
    // The related information is on the other side.
    let mut all = shown["codels/tank_codels.c"].as_array().expect("a list").iter();
    let there = all
        .find(|codelsc| {
            let message = codelsc["message"].as_str().unwrap_or_default();
            codelsc["code"] == "codel/signature-mismatch" && message.contains("tank_mix")
        })
        .expect("it is there");
    assert_eq!(there["relatedInformation"][0]["location"]["uri"], folder.uri("tank.gen"));
    let page = there["codeDescription"]["href"].as_str().unwrap_or_default();
    assert!(page.ends_with("docs/diagnostics/codel/signature-mismatch.md"), "{page}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edit_of_either_side_changes_what_is_said_of_both() {
    let folder = Folder::new(&[
        ("c.gen", "component c {\n  function f(in long n) { codel c_f(local in n); };\n};\n"),
        (
            "codels/c_codels.c",
            "genom_event c_f(int32_t n, const genom_context self)\n{\n  return genom_ok;\n}\n",
        ),
    ]);
    let (gen_uri, c_uri) = (folder.uri("c.gen"), folder.uri("codels/c_codels.c"));
    let mut capabilities = pulling();
    capabilities["workspace"] = json!({ "diagnostics": { "refreshSupport": true } });
    let refresh = ("workspace/diagnostic/refresh", Value::Null);
    let mut client = Client::start_answering(folder.params(capabilities), vec![refresh]).await;
    client.open(&gen_uri, &on_disk(&gen_uri).expect("it is there")).await;
    assert_eq!(client.pulled(&gen_uri).await, Vec::<String>::new());
    client.open_code(&c_uri, &on_disk(&c_uri).expect("it is there")).await;
    client.pushed_until(&c_uri, <[String]>::is_empty).await;

    // The source, as typed and not yet saved.
    let typed = json!([{ "range": { "start": { "line": 0, "character": 16 }, "end": { "line": 0, "character": 23 } }, "text": "double" }]);
    client.change(&c_uri, 2, typed).await;
    let mismatch = |codes: &[String]| codes == ["codel/signature-mismatch"];
    client.pushed_until(&c_uri, mismatch).await;
    assert_eq!(client.pulled(&gen_uri).await, Vec::<String>::new());
    // Without the function, the finding is at the specification, and the client is asked to refresh.
    client.change(&c_uri, 3, json!([{ "text": "\n" }])).await;
    client.pushed_until(&c_uri, <[String]>::is_empty).await;
    assert_eq!(client.pulled(&gen_uri).await, ["codel/missing-definition"]);
    while client.asked.is_empty() {
        client.pulled(&gen_uri).await;
    }
    let text = "genom_event c_f(double n, const genom_context self)\n{\n  return genom_ok;\n}\n";
    client.change(&c_uri, 4, json!([{ "text": text }])).await;
    client.pushed_until(&c_uri, mismatch).await;

    // Now the specification agrees.
    let text = "component c {\n  function f(in double n) { codel c_f(local in n); };\n};\n";
    client.change(&gen_uri, 2, json!([{ "text": text }])).await;
    client.pushed_until(&c_uri, <[String]>::is_empty).await;
    assert_eq!(client.pulled(&gen_uri).await, Vec::<String>::new());

    // Closed without saving: the text on the disk counts.
    client.notify("textDocument/didClose", document(&c_uri)).await;
    client.pushed_until(&c_uri, mismatch).await;
    // Changed by another program.
    folder.write(
        "codels/c_codels.c",
        "genom_event c_f(double n, const genom_context self)\n{\n  return genom_ok;\n}\n",
    );
    client.notify(DID_CHANGE_FILES, folder.event("codels/c_codels.c", 2)).await;
    client.pushed_until(&c_uri, <[String]>::is_empty).await;
    client.ignore("textDocument/publishDiagnostics");
    client.finish().await;
}

/// Each project sets the folder of its codels. A client may pull diagnostics of sources.
#[tokio::test(flavor = "multi_thread")]
async fn projects_of_a_workspace_have_folders_of_their_own() {
    let specification = |name: &str| {
        format!(
            "component {name} {{\n  function f(in long n) {{ codel {name}_f(local in n); }};\n}};\n"
        )
    };
    let source = |name: &str| {
        format!(
            "genom_event {name}_f(double n, const genom_context self)\n{{\n  return genom_ok;\n}}\n"
        )
    };
    let (a, b) = (specification("a"), specification("b"));
    let (in_a, in_b) = (source("a"), source("b"));
    let folder = Folder::new(&[
        ("a/a.gen", &a),
        ("a/codels/a_codels.c", &in_a),
        ("b/b.gen", &b),
        ("b/dotgen.toml", "[codels]\nfolder = \"src\"\n"),
        ("b/src/b_codels.c", &in_b),
        ("c/dotgen.toml", "[codels]\ncheck = false\n"),
    ]);
    let mut params = folder.params(pulling());
    params["initializationOptions"] = json!({ "pullSources": true });
    let mut client = Client::start(params).await;
    for name in ["a/codels/a_codels.c", "b/src/b_codels.c"] {
        let uri = folder.uri(name);
        client.open_code(&uri, &on_disk(&uri).expect("it is there")).await;
        client.pushed_until(&uri, |codes| codes == ["codel/signature-mismatch"]).await;
        assert_eq!(client.pulled(&uri).await, ["codel/signature-mismatch"]);
    }
    client.ignore("textDocument/publishDiagnostics");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn findings_follow_the_configuration_and_comments() {
    let specification = "component c {\n  // dotgen: allow(codel/missing-definition) written by hand elsewhere\n  function f() { codel c_f(); };\n  function g() { codel c_g(); };\n  function h() { codel c_h(); };\n};\n";
    let source = "genom_event c_h(const genom_context self)\n{\n  return genom_ok;\n}\n/** Codel c_old of function old. */\ngenom_event c_old(const genom_context self)\n{\n  return genom_ok;\n}\n";
    let folder = Folder::new(&[("c.gen", specification), ("codels/c_codels.c", source)]);
    let (uri, code) = (folder.uri("c.gen"), folder.uri("codels/c_codels.c"));
    let mut client = Client::start(folder.params(capable())).await;
    let is = |wanted: &'static [&'static str]| move |codes: &[String]| codes == wanted;
    let shown = client.pushed_until(&uri, is(&["codel/missing-definition"])).await;
    assert!(messages(&shown)[0].contains("c_g"), "{shown}");
    client.pushed_until(&code, is(&["codel/orphan"])).await;

    // In the source.
    let allowed = source
        .replace("/** Codel", "// dotgen: allow(codel/orphan) old scripts call it\n/** Codel");
    client.open_code(&code, &allowed).await;
    client.pushed_until(&code, is(&[])).await;

    // In the configuration.
    folder.write("dotgen.toml", "[severity]\n\"codel/missing-definition\" = \"error\"\n");
    client.notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 1)).await;
    let shown = client.pushed_until(&uri, is(&["codel/missing-definition"])).await;
    assert_eq!(shown[0]["severity"], 1);
    folder.write("dotgen.toml", "[severity]\n\"codel/missing-definition\" = \"off\"\n");
    client.notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 2)).await;
    client.pushed_until(&uri, is(&[])).await;
    folder.write("dotgen.toml", "[codels]\nfolder = \"src\"\n");
    folder.write(
        "src/c_codels.c",
        "genom_event c_f(int x, const genom_context self)\n{\n  return genom_ok;\n}\n",
    );
    client.notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 2)).await;
    let elsewhere = [
        // The function exists now.
        "lint/unused-suppression",
        "codel/missing-definition",
        "codel/missing-definition",
    ];
    client.pushed_until(&uri, |codes| codes == elsewhere).await;
    folder.write("dotgen.toml", "[codels]\ncheck = false\n");
    client.notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 2)).await;
    client.pushed_until(&uri, is(&[])).await;
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn comments_that_allow_nothing_are_told_on_both_sides() {
    let specification = "component c {\n  // dotgen: allow(codel/missing-definition) written by hand\n  function f() { codel c_f(); };\n  // dotgen: allow(codel/mising-definition) as above\n  function g() { codel c_g(); };\n  // dotgen: allow(codel/missing-definition) to come\n  function h() { codel c_h(); };\n};\n";
    let body = "(const genom_context self)\n{\n  return genom_ok;\n}\n";
    let source = format!(
        "// dotgen: allow(codel/orphan, codel/signature-mismatch) why\ngenom_event c_f(int x, const genom_context self)\n{{\n  return genom_ok;\n}}\n\
         genom_event c_g{body}// dotgen: allow(codel/orphan) of another\nint other{body}"
    );
    let folder = Folder::new(&[("c.gen", specification), ("codels/c_codels.c", &source)]);
    let (uri, code) = (folder.uri("c.gen"), folder.uri("codels/c_codels.c"));
    let mut client = Client::start(folder.params(capable())).await;
    client.open(&uri, specification).await;
    client.open_code(&code, &source).await;
    let unused = |wanted: usize| {
        move |codes: &[String]| {
            codes.iter().filter(|code| *code == "lint/unused-suppression").count() == wanted
        }
    };
    let shown = client.pushed_until(&uri, unused(2)).await;
    assert_eq!(
        messages(&shown),
        [
            "lint/unused-suppression: nothing here is reported as `codel/missing-definition`: remove it \
                from the comment",
            "lint/unused-suppression: `codel/mising-definition` is no code of a diagnostic",
        ]
    );
    assert_eq!(shown[0]["severity"], 4);
    assert_eq!(shown[0]["range"]["start"], place(specification, "codel/missing", 0));
    let shown = client.pushed_until(&code, unused(1)).await;
    assert_eq!(
        messages(&shown),
        [
            "lint/unused-suppression: nothing here is reported as `codel/orphan`: remove it from the comment"
        ]
    );
    assert_eq!(shown[0]["range"]["start"], place(&source, "codel/orphan", 0));

    // The fix is at its place.
    let at = place(specification, "codel/missing", 0);
    let actions = client.actions(&uri, &json!({ "start": at, "end": at }), Some("quickfix")).await;
    let titles: Vec<_> = actions.iter().map(title).collect();
    assert!(titles.contains(&"Remove the comment"), "{titles:?}");

    // Without a comparison there are no findings.
    folder.write("dotgen.toml", "[codels]\nfolder = \"src\"\n");
    client.notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 1)).await;
    client.pushed_until(&uri, <[String]>::is_empty).await;
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}
