//! Specifications and the sources of their codels, as an editor sees them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use camino::Utf8PathBuf;
use dotgen_analysis::host::{AnalysisHost, Change};
use dotgen_codegen::codels::command::{self, Project};
use dotgen_codegen::codels::files::FilesConfig;
use dotgen_codegen::codels::stub::StubOptions;
use serde_json::{Value, json};

use super::client::{Client, Folder, codes, document, pulling};
use crate::codels::Disk;
use crate::convert::{Encoding, Lines};
use crate::vfs::Vfs;

const DID_CHANGE_FILES: &str = "workspace/didChangeWatchedFiles";
const FILES: [&str; 3] = [
    "tank.gen",
    "codels/tank_codels.c",
    "codels/tank_control_codels.c",
];

/// The example with a drift of each kind.
fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/drift")
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).expect("a file of the example")
}

/// A copy of the example.
fn tank() -> Folder {
    let all = FILES
        .iter()
        .chain(&["codels/Makefile.am"])
        .map(|it| (*it, read(example().join(it))));
    let all: Vec<_> = all.collect();
    let files: Vec<_> = all.iter().map(|it| (it.0, it.1.as_str())).collect();
    Folder::new(&files)
}

/// A client that can do everything that edits need.
fn capable() -> Value {
    json!({
        "textDocument": {
            "publishDiagnostics": { "relatedInformation": true, "codeDescriptionSupport": true },
            "codeAction": {
                "codeActionLiteralSupport": { "codeActionKind": { "valueSet": [] } },
                "dataSupport": true,
                "resolveSupport": { "properties": ["edit"] },
            },
        },
        "workspace": { "workspaceEdit": {
            "documentChanges": true,
            "resourceOperations": ["create"],
            "changeAnnotationSupport": {},
        } },
    })
}

/// The place of the n-th occurrence of a word in a text.
fn place(text: &str, what: &str, nth: usize) -> Value {
    let (offset, _) = text.match_indices(what).nth(nth).expect("it occurs");
    let line = text[..offset].matches('\n').count();
    let start = text[..offset].rfind('\n').map_or(0, |it| it + 1);
    json!({ "line": line, "character": offset - start })
}

fn at(uri: &str, text: &str, what: &str, nth: usize) -> Value {
    let mut params = document(uri);
    params["position"] = place(text, what, nth);
    params
}

/// `code: message` of diagnostics.
fn messages(diagnostics: &Value) -> Vec<String> {
    let all = diagnostics.as_array().expect("a list").iter();
    all.map(|it| {
        let text = |key: &str| it[key].as_str().unwrap_or_default().to_owned();
        format!("{}: {}", text("code"), text("message"))
    })
    .collect()
}

impl Client {
    async fn open_code(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "c", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }))
            .await;
    }

    /// Waits for the diagnostics pushed for a document to be such.
    async fn pushed_until(&mut self, uri: &str, wanted: impl Fn(&[String]) -> bool) -> Value {
        loop {
            let pushed = self.pushed(uri).await;
            if wanted(&codes(&pushed["diagnostics"])) {
                return pushed["diagnostics"].clone();
            }
        }
    }

    async fn actions(&mut self, uri: &str, range: &Value, only: Option<&str>) -> Vec<Value> {
        let mut params = document(uri);
        params["range"] = range.clone();
        params["context"] = json!({ "diagnostics": [] });
        if let Some(only) = only {
            params["context"]["only"] = json!([only]);
        }
        let answer = self.ok("textDocument/codeAction", params).await;
        let mut out = Vec::new();
        for action in answer.as_array().cloned().unwrap_or_default() {
            out.push(match action.get("edit") {
                Some(_) => action,
                None => self.ok("codeAction/resolve", action).await,
            });
        }
        out
    }
}

fn title(action: &Value) -> &str {
    action["title"].as_str().unwrap_or_default()
}

/// Texts by URI with a workspace edit applied, as a client does it.
fn applied(edit: &Value, text: impl Fn(&str) -> Option<String>) -> BTreeMap<String, String> {
    let mut out: BTreeMap<String, String> = BTreeMap::new();
    let change = |uri: &str, edits: &Value, created: &BTreeMap<String, String>| {
        let before = created.get(uri).cloned().or_else(|| text(uri));
        let before = before.unwrap_or_default();
        let lines = Lines::new(before.as_str().into(), Encoding::Utf16);
        let mut edits: Vec<_> = edits
            .as_array()
            .expect("edits")
            .iter()
            .map(|it| {
                let range = serde_json::from_value(it["range"].clone()).expect("a range");
                let range = lines.bytes(range).expect("a range of the text");
                (range, it["newText"].as_str().expect("a text").to_owned())
            })
            .collect();
        // From the end, insertions at one place in order.
        edits.sort_by_key(|it| it.0.start);
        let mut after = before;
        for (range, new) in edits.into_iter().rev() {
            after.replace_range(range, &new);
        }
        (uri.to_owned(), after)
    };
    for operation in edit["documentChanges"].as_array().into_iter().flatten() {
        if operation["kind"] == "create" {
            let uri = operation["uri"].as_str().expect("a URI");
            assert_eq!(operation["options"]["overwrite"], false);
            assert_eq!(text(uri), None, "a file that is there is created");
            out.insert(uri.to_owned(), String::new());
            continue;
        }
        let uri = operation["textDocument"]["uri"].as_str().expect("a URI");
        let (uri, after) = change(uri, &operation["edits"], &out);
        out.insert(uri, after);
    }
    for (uri, edits) in edit["changes"].as_object().into_iter().flatten() {
        let (uri, after) = change(uri, edits, &out);
        out.insert(uri, after);
    }
    out
}

fn path(uri: &str) -> PathBuf {
    let uri: crate::proto::Uri = uri.parse().expect("a URI");
    crate::convert::uri::to_path(&uri).into_std_path_buf()
}

fn on_disk(uri: &str) -> Option<String> {
    std::fs::read_to_string(path(uri)).ok()
}

/// Writes what an edit makes of the files.
fn write(edit: &Value) {
    for (uri, text) in applied(edit, on_disk) {
        std::fs::write(path(&uri), text).expect("a file");
    }
}

/// What `dotgen codels check` finds.
fn check(specification: &Path) -> Vec<String> {
    let root = Utf8PathBuf::from_path_buf(specification.to_owned()).expect("UTF-8");
    let mut host = AnalysisHost::new(std::sync::Arc::new(Vfs::default()));
    host.apply(Change {
        roots: Some(vec![root.clone()]),
        ..Change::default()
    });
    let (files, stubs) = (FilesConfig::default(), StubOptions::default());
    let report = command::check(&mut Project::new(&mut host, &Disk, files, stubs), &[root]);
    assert_eq!(report.errors, Vec::<String>::new());
    let all = report.findings.iter();
    all.map(|it| format!("{}: {}", it.code, it.message))
        .collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn drift_is_shown_on_both_sides_without_a_document_being_open() {
    let folder = tank();
    let mut client = Client::start(folder.params(capable())).await;
    let mut shown = BTreeMap::new();
    for name in FILES {
        let pushed = client.pushed(&folder.uri(name)).await;
        shown.insert(name, pushed["diagnostics"].clone());
    }
    let specification = messages(&shown["tank.gen"]);
    let sources: Vec<String> = FILES[1..]
        .iter()
        .flat_map(|it| messages(&shown[it]))
        .collect();
    for message in check(&path(&folder.uri("tank.gen"))) {
        let code = message.split(':').next().expect("a code").to_owned();
        assert!(specification.contains(&message), "{message} in tank.gen");
        let only_there = code == "codel/missing-definition";
        assert_eq!(
            sources.contains(&message),
            !only_there,
            "{message} in a source"
        );
    }
    // Each side leads to the other.
    let mismatch = |name: &str| -> Value {
        let all = shown[name].as_array().expect("a list").iter();
        let mut found = all.filter(|it| {
            it["code"] == "codel/signature-mismatch"
                && it["message"]
                    .as_str()
                    .unwrap_or_default()
                    .contains("tank_mix")
        });
        found.next().expect("it is there").clone()
    };
    let related = |it: &Value| it["relatedInformation"][0]["location"]["uri"].clone();
    let (here, there) = (mismatch("tank.gen"), mismatch("codels/tank_codels.c"));
    assert_eq!(related(&here), folder.uri("codels/tank_codels.c"));
    assert_eq!(related(&there), folder.uri("tank.gen"));
    let page = there["codeDescription"]["href"]
        .as_str()
        .unwrap_or_default();
    assert!(
        page.ends_with("docs/diagnostics/codel/signature-mismatch.md"),
        "{page}"
    );
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edit_of_either_side_changes_what_is_said_of_both() {
    let folder = Folder::new(&[
        (
            "c.gen",
            "component c {\n  function f(in long n) { codel c_f(local in n); };\n};\n",
        ),
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
    client
        .open(&gen_uri, &on_disk(&gen_uri).expect("it is there"))
        .await;
    assert_eq!(client.pulled(&gen_uri).await, Vec::<String>::new());
    client
        .open_code(&c_uri, &on_disk(&c_uri).expect("it is there"))
        .await;
    client.pushed_until(&c_uri, <[String]>::is_empty).await;

    // The source, as typed and not yet saved.
    let typed = json!([{ "range": { "start": { "line": 0, "character": 16 }, "end": { "line": 0, "character": 23 } }, "text": "double" }]);
    client.change(&c_uri, 2, typed).await;
    let mismatch = |it: &[String]| it == ["codel/signature-mismatch"];
    client.pushed_until(&c_uri, mismatch).await;
    assert!(mismatch(&client.pulled(&gen_uri).await));
    // The client is told that the other document has news.
    while client.asked.is_empty() {
        client.pulled(&gen_uri).await;
    }

    // The specification follows.
    let text = "component c {\n  function f(in double n) { codel c_f(local in n); };\n};\n";
    client.change(&gen_uri, 2, json!([{ "text": text }])).await;
    client.pushed_until(&c_uri, <[String]>::is_empty).await;
    assert_eq!(client.pulled(&gen_uri).await, Vec::<String>::new());

    // Closed without saving: the disk counts.
    client
        .notify("textDocument/didClose", document(&c_uri))
        .await;
    client.pushed_until(&c_uri, mismatch).await;
    // Changed by somebody else.
    folder.write(
        "codels/c_codels.c",
        "genom_event c_f(double n, const genom_context self)\n{\n  return genom_ok;\n}\n",
    );
    client
        .notify(DID_CHANGE_FILES, folder.event("codels/c_codels.c", 2))
        .await;
    client.pushed_until(&c_uri, <[String]>::is_empty).await;
    client.ignore("textDocument/publishDiagnostics");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn every_quick_fix_removes_what_it_is_offered_for() {
    let original = tank();
    let mut client = Client::start(original.params(capable())).await;
    let mut fixes: Vec<(String, Value)> = Vec::new();
    for name in FILES {
        let uri = original.uri(name);
        let pushed = client.pushed(&uri).await;
        for diagnostic in pushed["diagnostics"].as_array().expect("a list") {
            if !diagnostic["code"]
                .as_str()
                .unwrap_or_default()
                .starts_with("codel/")
            {
                continue;
            }
            let finding = messages(&json!([diagnostic])).remove(0);
            let actions = client
                .actions(&uri, &diagnostic["range"], Some("quickfix"))
                .await;
            let mut offered = 0;
            for action in &actions {
                let about = action["diagnostics"].as_array().into_iter().flatten();
                if messages(&json!(about.collect::<Vec<_>>())).contains(&finding) {
                    offered += 1;
                    fixes.push((finding.clone(), action.clone()));
                }
            }
            assert!(offered > 0, "no fix for {finding} in {name}: {actions:#?}");
            let preferred = actions.iter().filter(|it| it["isPreferred"] == true);
            assert!(preferred.count() > 0, "{finding}");
        }
    }
    client.finish().await;
    assert!(fixes.len() > 20, "{}", fixes.len());
    for (finding, action) in fixes {
        // The edit of one folder, applied to the files of another.
        let copy = tank();
        let moved = action.to_string().replace(&original.uri(""), &copy.uri(""));
        let action: Value = serde_json::from_str(&moved).expect("JSON");
        let touches_code = action["edit"].to_string().contains("_codels.c\"");
        let annotations = &action["edit"]["changeAnnotations"];
        assert_eq!(
            touches_code,
            annotations["codels"]["needsConfirmation"] == true,
            "{action:#}"
        );
        write(&action["edit"]);
        let left = check(&path(&copy.uri("tank.gen")));
        assert!(
            !left.contains(&finding),
            "{} leaves {finding}",
            title(&action)
        );
    }
}

/// Applies the action that mends everything and looks what is left.
async fn fix_all(only: Option<&str>, ranges: &Value) {
    let folder = tank();
    let uri = folder.uri("tank.gen");
    let mut client = Client::start(folder.params(capable())).await;
    client
        .open(&uri, &on_disk(&uri).expect("it is there"))
        .await;
    let actions = client.actions(&uri, ranges, only).await;
    let all: Vec<_> = actions
        .iter()
        .filter(|it| title(it) == "Fix all differences between specification and codels")
        .collect();
    assert_eq!(all.len(), 1, "{actions:#?}");
    write(&all[0]["edit"]);
    client.ignore("textDocument/publishDiagnostics");
    let specification = path(&uri);
    assert_eq!(check(&specification), Vec::<String>::new());

    // And it compiles, with the headers that the server makes for clangd.
    client
        .change(
            &uri,
            2,
            json!([{ "text": on_disk(&uri).expect("it is there") }]),
        )
        .await;
    let headers = client.ok("dotgen/codelHeaders", document(&uri)).await;
    assert_eq!(headers["folder"], folder.uri(".dotgen"), "{headers}");
    for file in headers["files"].as_array().expect("files") {
        let path = path(file["uri"].as_str().expect("a URI"));
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, file["text"].as_str().expect("a text")).expect("a file");
    }
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
    let directory = specification.parent().expect("a folder");
    let flags = read(directory.join(".dotgen/compile_flags.txt"));
    for source in &FILES[1..] {
        let output = std::process::Command::new("cc")
            // A parameter that is new is not used yet.
            .args(["-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter"])
            .args(flags.lines())
            .arg(directory.join(source))
            .output();
        let Ok(output) = output else {
            eprintln!("SKIPPED: no `cc` on this system");
            return;
        };
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{source}: {errors}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn fix_all_leaves_nothing_to_report_and_the_code_compiles() {
    let text = read(example().join("tank.gen"));
    let start = place(&text, "tank_mix", 0);
    let here = json!({ "start": start, "end": start });
    fix_all(Some("quickfix"), &here).await;
    let top =
        json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 0, "character": 0 } });
    fix_all(Some("source"), &top).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn saving_with_fix_all_does_not_touch_codels() {
    let folder = tank();
    let uri = folder.uri("tank.gen");
    let mut client = Client::start(folder.params(capable())).await;
    let all =
        json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 50, "character": 0 } });
    let actions = client.actions(&uri, &all, Some("source.fixAll")).await;
    assert!(
        !actions
            .iter()
            .any(|it| it.to_string().contains("_codels.c")),
        "{actions:#?}"
    );
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn stubs_of_a_component_without_sources_make_the_files_of_the_skeleton() {
    let text = read(example().join("tank.gen"));
    let start = place(&text, "tank {", 0);
    let range = json!({ "start": start, "end": start });
    for creates in [true, false] {
        let folder = Folder::new(&[("tank.gen", &text)]);
        let uri = folder.uri("tank.gen");
        let mut capabilities = capable();
        if !creates {
            capabilities["workspace"] = json!({});
        }
        let mut client = Client::start(folder.params(capabilities)).await;
        let actions = client.actions(&uri, &range, Some("refactor")).await;
        let stubs = actions
            .iter()
            .find(|it| title(it) == "Write the 13 missing stubs of component `tank`")
            .unwrap_or_else(|| panic!("{actions:#?}"));
        let files = applied(&stubs["edit"], on_disk);
        let names: Vec<_> = files
            .keys()
            .map(|it| it.rsplit('/').next().unwrap_or_default())
            .collect();
        assert_eq!(names, ["tank_codels.c", "tank_control_codels.c"]);
        std::fs::create_dir_all(path(&folder.uri("codels"))).expect("a folder");
        write(&stubs["edit"]);
        assert_eq!(check(&path(&uri)), Vec::<String>::new());
        client.ignore("textDocument/publishDiagnostics");
        drop(client);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn from_codels_to_functions_and_back() {
    let folder = tank();
    let (uri, source) = (
        folder.uri("tank.gen"),
        folder.uri("codels/tank_control_codels.c"),
    );
    let (text, code) = (read(path(&uri)), read(path(&source)));
    let mut capabilities = capable();
    capabilities["window"] = json!({ "showDocument": { "support": true } });
    let answers = vec![("window/showDocument", json!({ "success": true }))];
    let mut client = Client::start_answering(folder.params(capabilities), answers).await;
    client.open(&uri, &text).await;
    client.open_code(&source, &code).await;

    let params = at(&uri, &text, "tank_fill_wait", 0);
    let found = client
        .ok("textDocument/implementation", params.clone())
        .await;
    assert_eq!(found[0]["uri"], source);
    assert_eq!(
        found[0]["range"]["start"],
        place(&code, "tank_fill_wait(double", 0)
    );

    let mut references = params;
    references["context"] = json!({ "includeDeclaration": true });
    let found = client.ok("textDocument/references", references).await;
    let uris: Vec<_> = found
        .as_array()
        .expect("a list")
        .iter()
        .map(|it| it["uri"].clone())
        .collect();
    assert_eq!(uris, [json!(uri), json!(source)]);

    let mut references = at(&source, &code, "tank_fill_wait(double", 0);
    references["context"] = json!({ "includeDeclaration": true });
    let found = client.ok("textDocument/references", references).await;
    assert_eq!(found[0]["uri"], uri);
    assert_eq!(
        found[0]["range"]["start"],
        place(&text, "tank_fill_wait", 0)
    );

    let lenses = client.ok("textDocument/codeLens", document(&source)).await;
    let titles: Vec<_> = lenses
        .as_array()
        .expect("a list")
        .iter()
        .map(|it| {
            it["command"]["title"]
                .as_str()
                .unwrap_or_default()
                .to_owned()
        })
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
    assert_eq!(
        shown["selection"]["start"],
        place(&text, "tank_fill_wait", 0)
    );
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_codel_is_renamed_on_both_sides() {
    let folder = tank();
    let (uri, source) = (
        folder.uri("tank.gen"),
        folder.uri("codels/tank_control_codels.c"),
    );
    let text = read(path(&uri));
    let mut client = Client::start(folder.params(capable())).await;
    let before = check(&path(&uri));
    let mut params = at(&uri, &text, "tank_fill_wait", 0);
    params["newName"] = json!("tank_fill_watch");
    let edit = client.ok("textDocument/rename", params.clone()).await;
    assert_eq!(
        edit["changeAnnotations"]["codels"]["needsConfirmation"],
        true
    );
    write(&edit);
    let code = read(path(&source));
    assert!(code.contains("\ntank_fill_watch(double target"), "{code}");
    assert!(
        code.contains("Codel tank_fill_watch of activity fill"),
        "{code}"
    );
    let after: Vec<_> = check(&path(&uri))
        .iter()
        .map(|it| it.replace("fill_watch", "fill_wait"))
        .collect();
    assert_eq!(after, before);

    params["newName"] = json!("tank_fill_stop");
    let refused = client
        .request("textDocument/rename", params)
        .await
        .expect_err("the name is taken");
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
    client
        .open_code(&other, "int main(void) { return 0; }\n")
        .await;
    for method in [
        "textDocument/hover",
        "textDocument/definition",
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
    // Nothing is said of what is in no folder of codels.
    client.pushed(&source).await;
    client
        .ok("test/text", document(&folder.uri("tank.gen")))
        .await;
    client.ok("shutdown", Value::Null).await;
    for message in client.all() {
        assert_ne!(message["params"]["uri"], other, "{message}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn findings_follow_the_configuration_and_comments() {
    let specification = "component c {\n  // dotgen: allow(codel/missing-definition) written by hand elsewhere\n  function f() { codel c_f(); };\n  function g() { codel c_g(); };\n  function h() { codel c_h(); };\n};\n";
    let source = "genom_event c_h(const genom_context self)\n{\n  return genom_ok;\n}\n/** Codel c_old of function old. */\ngenom_event c_old(const genom_context self)\n{\n  return genom_ok;\n}\n";
    let folder = Folder::new(&[("c.gen", specification), ("codels/c_codels.c", source)]);
    let (uri, code) = (folder.uri("c.gen"), folder.uri("codels/c_codels.c"));
    let mut client = Client::start(folder.params(capable())).await;
    let is = |wanted: &'static [&'static str]| move |it: &[String]| it == wanted;
    let shown = client
        .pushed_until(&uri, is(&["codel/missing-definition"]))
        .await;
    assert!(messages(&shown)[0].contains("c_g"), "{shown}");
    client.pushed_until(&code, is(&["codel/orphan"])).await;

    // In the source.
    let allowed = source.replace(
        "/** Codel",
        "// dotgen: allow(codel/orphan) old scripts call it\n/** Codel",
    );
    client.open_code(&code, &allowed).await;
    client.pushed_until(&code, is(&[])).await;

    // In the configuration.
    folder.write(
        "dotgen.toml",
        "[severity]\n\"codel/missing-definition\" = \"error\"\n",
    );
    client
        .notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 1))
        .await;
    let shown = client
        .pushed_until(&uri, is(&["codel/missing-definition"]))
        .await;
    assert_eq!(shown[0]["severity"], 1);
    folder.write(
        "dotgen.toml",
        "[severity]\n\"codel/missing-definition\" = \"off\"\n",
    );
    client
        .notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 2))
        .await;
    client.pushed_until(&uri, is(&[])).await;
    folder.write("dotgen.toml", "[codels]\nfolder = \"src\"\n");
    folder.write(
        "src/c_codels.c",
        "genom_event c_f(int x, const genom_context self)\n{\n  return genom_ok;\n}\n",
    );
    client
        .notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 2))
        .await;
    let elsewhere = [
        // The function is there now.
        "lint/unused-suppression",
        "codel/signature-mismatch",
        "codel/missing-definition",
        "codel/missing-definition",
    ];
    client.pushed_until(&uri, |it| it == elsewhere).await;
    folder.write("dotgen.toml", "[codels]\ncheck = false\n");
    client
        .notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 2))
        .await;
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
        move |it: &[String]| {
            it.iter()
                .filter(|it| *it == "lint/unused-suppression")
                .count()
                == wanted
        }
    };
    let shown = client.pushed_until(&uri, unused(2)).await;
    assert_eq!(
        messages(&shown),
        [
            "lint/unused-suppression: nothing here is reported as `codel/missing-definition`: remove it from the comment",
            "lint/unused-suppression: `codel/mising-definition` is no code of a diagnostic",
        ]
    );
    assert_eq!(shown[0]["severity"], 4);
    assert_eq!(
        shown[0]["range"]["start"],
        place(specification, "codel/missing", 0)
    );
    let shown = client.pushed_until(&code, unused(1)).await;
    assert_eq!(
        messages(&shown),
        [
            "lint/unused-suppression: nothing here is reported as `codel/orphan`: remove it from the comment"
        ]
    );
    assert_eq!(
        shown[0]["range"]["start"],
        place(&source, "codel/orphan", 0)
    );

    // It is mended where it stands.
    let at = place(specification, "codel/missing", 0);
    let actions = client
        .actions(&uri, &json!({ "start": at, "end": at }), Some("quickfix"))
        .await;
    let titles: Vec<_> = actions.iter().map(title).collect();
    assert!(titles.contains(&"Remove the comment"), "{titles:?}");

    // Where nothing is compared, nothing is known.
    folder.write("dotgen.toml", "[codels]\nfolder = \"src\"\n");
    client
        .notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 1))
        .await;
    client.pushed_until(&uri, <[String]>::is_empty).await;
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}

#[tokio::test(flavor = "multi_thread")]
async fn sources_are_asked_for_where_clients_let_choose() {
    let folder = tank();
    let dynamic = json!({ "dynamicRegistration": true });
    let mut capabilities = capable();
    for method in ["synchronization", "codeAction", "codeLens", "references"] {
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
        let all = asked.iter().flat_map(|it| {
            it["params"]["registrations"]
                .as_array()
                .cloned()
                .unwrap_or_default()
        });
        all.filter(|it| it["method"] == "textDocument/codeLens")
            .collect()
    };
    while lens(&client.asked).is_empty() {
        client
            .ok("test/text", document(&folder.uri("tank.gen")))
            .await;
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
    client
        .notify(DID_CHANGE_FILES, folder.event("dotgen.toml", 1))
        .await;
    while lens(&client.asked).len() < 2 {
        client
            .ok("test/text", document(&folder.uri("tank.gen")))
            .await;
    }
    let selector = &lens(&client.asked)[1]["registerOptions"]["documentSelector"];
    assert_eq!(selector[0]["pattern"], "**/src/**");
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}
