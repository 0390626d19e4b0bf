//! Completion, rename, formatting, hints, lenses, signatures and call hierarchy over the protocol.

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const ARM: &str = r#"#include "pose.idl"

component arm {
  ids { pose goal; };
  port out pose state;
  task motion {
    period 10 ms;
    codel<start> init(out ::ids) wcet 1 ms yield go;
    codel<go> move(in goal, port out state) wcet 2 ms yield pause::go, ether;
  };
  function  stop() { interrupt stop; };
};
"#;

async fn start(capabilities: Value) -> (Client, Folder, String) {
    let folder = Folder::new(&[("pose.idl", "struct pose { double x; };\n"), ("arm.gen", ARM)]);
    let mut all = pulling();
    for (key, value) in capabilities.as_object().cloned().unwrap_or_default() {
        all["textDocument"][key] = value;
    }
    let mut client = Client::start(folder.params(all)).await;
    let uri = folder.uri("arm.gen");
    client.open(&uri, ARM).await;
    (client, folder, uri)
}

/// A request about the n-th occurrence of a text.
fn at(uri: &str, what: &str, nth: usize) -> Value {
    let (offset, _) = ARM.match_indices(what).nth(nth).expect("it occurs");
    let line = ARM[..offset].matches('\n').count();
    let start = ARM[..offset].rfind('\n').map_or(0, |arm| arm + 1);
    let mut params = document(uri);
    params["position"] = json!({ "line": line, "character": offset - start });
    params
}

#[tokio::test(flavor = "multi_thread")]
async fn functions_without_codel_are_proposed_as_names_of_codels() {
    let spec = "component c {\n  ids { long x; };\n  task t {\n    codel<start> c_t_start(in x) yield ether;\n    \
                codel<stop> \n  };\n};\n";
    let code = "genom_event\nc_t_start(int32_t x, const genom_context self)\n{\n  return c_ether;\n}\n\
                genom_event\nc_halt(int32_t *x, const genom_context self)\n{\n  return c_ether;\n}\n";
    let folder = Folder::new(&[("c.gen", spec), ("codels/c_t_codels.c", code)]);
    let mut all = pulling();
    all["textDocument"]["completion"] = json!({ "completionItem": { "snippetSupport": true } });
    let mut client = Client::start(folder.params(all)).await;
    let uri = folder.uri("c.gen");
    client.open(&uri, spec).await;
    let mut params = document(&uri);
    params["position"] = json!({ "line": 4, "character": 16 });
    let list = client.ok("textDocument/completion", params).await;
    let items = list["items"].as_array().expect("a list");
    let labels: Vec<&str> = items.iter().filter_map(|json| json["label"].as_str()).collect();
    // The function comes first, then a name formed like the other codel's. A function with a codel is absent.
    assert_eq!(labels, ["c_halt", "c_t_stop"]);
    assert_eq!(items[0]["textEdit"]["newText"], "c_halt(${1:ids inout x})\n\tyield ${2:ether};$0");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn completion_with_and_without_snippets() {
    let snippets = json!({ "completion": { "completionItem": { "snippetSupport": true } } });
    for (capabilities, has_snippets) in [(snippets, true), (json!({}), false)] {
        let (mut client, _folder, uri) = start(capabilities).await;
        let list = client.ok("textDocument/completion", at(&uri, "function", 0)).await;
        let items = list["items"].as_array().expect("a list");
        let task = items.iter().find(|json| json["label"] == "task").expect("task");
        assert_eq!(task["insertTextFormat"], if has_snippets { 2 } else { 1 });
        let text = task["textEdit"]["newText"].as_str().expect("a text");
        assert_eq!(text.contains("${1:main}"), has_snippets, "{text}");

        let list = client.ok("textDocument/completion", at(&uri, "pose goal", 0)).await;
        let items = list["items"].as_array().expect("a list");
        let pose = items.iter().find(|json| json["label"] == "pose").expect("pose");
        let resolved = client.ok("completionItem/resolve", pose.clone()).await;
        let doc = resolved["documentation"]["value"].as_str().expect("text");
        assert!(doc.contains("double x"), "{doc}");

        let list = client.ok("textDocument/completion", at(&uri, "pose.idl", 0)).await;
        assert_eq!(list["items"][0]["label"], "pose.idl", "{list}");
        client.finish().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_blank_opens_no_list_where_a_line_may_end() {
    let (mut client, _folder, uri) = start(json!({})).await;
    for (behind, typed, opens) in [
        ("  ", " ", false),
        ("ids { ", " ", false),
        ("yield ", " ", true),
        ("yield pause::", ":", true),
    ] {
        let mut params = at(&uri, behind, 0);
        let character = params["position"]["character"].as_u64().expect("a number");
        params["position"]["character"] = json!(character + behind.len() as u64);
        let by_hand = client.ok("textDocument/completion", params.clone()).await;
        assert_ne!(by_hand["items"], json!([]), "{behind:?} by hand");
        params["context"] = json!({ "triggerKind": 2, "triggerCharacter": typed });
        let list = client.ok("textDocument/completion", params).await;
        assert_eq!(!list.is_null(), opens, "{behind:?}: {list}");
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn rename_across_files_and_its_refusals() {
    let (mut client, folder, uri) = start(json!({})).await;
    let prepared = client.ok("textDocument/prepareRename", at(&uri, "pose goal", 0)).await;
    assert_eq!(prepared["placeholder"], "pose");
    let mut params = at(&uri, "pose goal", 0);
    params["newName"] = json!("position");
    let edit = client.ok("textDocument/rename", params.clone()).await;
    let changes = edit["changes"].as_object().expect("changes");
    assert_eq!(changes.len(), 2, "{edit}");
    assert_eq!(changes[&folder.uri("pose.idl")][0]["newText"], "position");
    assert_eq!(changes[&uri].as_array().map(Vec::len), Some(2));

    params["newName"] = json!("struct");
    let error = client.request("textDocument/rename", params).await;
    let error = error.expect_err("refused");
    assert_eq!(error["code"], -32803);
    assert!(
        error["message"].as_str().is_some_and(|message| message.contains("reserved")),
        "{error}"
    );
    let nothing = client.request("textDocument/prepareRename", at(&uri, "period", 0)).await;
    nothing.expect_err("a keyword has no name");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn includes_follow_renamed_files() {
    let (mut client, folder, uri) = start(json!({})).await;
    let files = json!([{ "oldUri": folder.uri("pose.idl"), "newUri": folder.uri("types.idl") }]);
    let edit = client.ok("workspace/willRenameFiles", json!({ "files": files })).await;
    assert_eq!(edit["changes"][&uri][0]["newText"], "types.idl", "{edit}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn formatting_whole_in_part_and_while_typing() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let options = json!({ "tabSize": 2, "insertSpaces": true });
    let mut params = document(&uri);
    params["options"] = options.clone();
    let edits = client.ok("textDocument/formatting", params.clone()).await;
    let edits = edits.as_array().expect("edits");
    assert!(edits.iter().any(|edit| edit["range"]["start"]["line"] == 10), "{edits:?}");
    params["range"] = json!({ "start": { "line": 0, "character": 0 },
                              "end": { "line": 1, "character": 0 } });
    let part = client.ok("textDocument/rangeFormatting", params).await;
    assert_eq!(part, json!([]));
    let mut params = at(&uri, "\n};", 0);
    params["options"] = options;
    params["ch"] = json!(";");
    let typed = client.ok("textDocument/onTypeFormatting", params).await;
    let typed = typed.as_array().expect("edits");
    assert!(
        typed.iter().all(|client| client["range"]["start"]["line"].as_u64() >= Some(9)),
        "{typed:?}"
    );
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn lenses_are_resolved_one_by_one() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let lenses = client.ok("textDocument/codeLens", document(&uri)).await;
    let mut titles = Vec::new();
    let mut commands = Vec::new();
    for lens in lenses.as_array().expect("lenses") {
        assert_eq!(lens.get("command"), None, "resolved too early");
        let lens = client.ok("codeLens/resolve", lens.clone()).await;
        titles.push(lens["command"]["title"].as_str().expect("a title").to_owned());
        commands.push(lens["command"].clone());
    }
    assert!(titles.contains(&"state machine".to_owned()), "{titles:?}");
    assert!(
        !titles.iter().any(|title| title.contains("reference") || title.contains("load")),
        "{titles:?}"
    );
    let diagram = commands.iter().find(|command| command["command"] == "dotgen.showDiagram");
    let argument = &diagram.expect("a diagram")["arguments"][0];
    assert_eq!(*argument, json!({ "uri": uri, "component": "arm", "owner": "motion" }));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn hints_signatures_implementations_and_calls() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let mut params = document(&uri);
    params["range"] = json!({ "start": { "line": 0, "character": 0 },
                              "end": { "line": 12, "character": 0 } });
    let hints = client.ok("textDocument/inlayHint", params).await;
    let labels: Vec<&str> =
        hints.as_array().expect("hints").iter().filter_map(|hint| hint["label"].as_str()).collect();
    assert!(labels.contains(&" ‹load 20 %›"), "{labels:?}");

    let help = client.ok("textDocument/signatureHelp", at(&uri, "in goal", 0)).await;
    assert_eq!(help["activeParameter"], 0);
    assert_eq!(help["signatures"][0]["label"], "move(ids in pose goal, port out pose state)");

    let none = client.ok("textDocument/implementation", at(&uri, "motion", 0)).await;
    assert_eq!(none, Value::Null);

    let items = client.ok("textDocument/prepareCallHierarchy", at(&uri, "go>", 0)).await;
    assert_eq!(items[0]["name"], "go");
    let item = json!({ "item": items[0] });
    let incoming = client.ok("callHierarchy/incomingCalls", item.clone()).await;
    let from: Vec<_> = incoming
        .as_array()
        .expect("calls")
        .iter()
        .map(|client| client["from"]["name"].as_str().expect("a name").to_owned())
        .collect();
    assert_eq!(from, ["start", "go"]);
    let outgoing = client.ok("callHierarchy/outgoingCalls", item).await;
    assert_eq!(outgoing.as_array().map(Vec::len), Some(2));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn refactorings_are_code_actions() {
    let literals = json!({ "codeAction": { "codeActionLiteralSupport":
        { "codeActionKind": { "valueSet": ["refactor"] } } } });
    let (mut client, _folder, uri) = start(literals).await;
    let place = at(&uri, "goal; }", 0)["position"].clone();
    let mut params = document(&uri);
    params["range"] = json!({ "start": place, "end": place });
    params["context"] = json!({ "diagnostics": [], "only": ["refactor.extract"] });
    let actions = client.ok("textDocument/codeAction", params.clone()).await;
    let actions = actions.as_array().expect("actions");
    let titles: Vec<&str> = actions.iter().filter_map(|action| action["title"].as_str()).collect();
    assert_eq!(titles, ["Extract struct from members of the ids"]);
    assert_eq!(actions[0]["kind"], "refactor.extract");
    assert!(actions[0]["edit"]["changes"][&uri].is_array(), "{actions:?}");
    params["context"]["only"] = json!(["quickfix"]);
    assert_eq!(client.ok("textDocument/codeAction", params).await, json!([]));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_finding_is_allowed_by_a_comment_above_its_declaration() {
    let text = "component c {\n  ids { long speed; };\n  task t { period 5 ms; };\n  activity go() {\n    \
        task t; interrupts go;\n    codel<start> f(out speed) yield pause::start, ether;\n  };\n};\n";
    let folder = Folder::new(&[("c.gen", text)]);
    let mut capabilities = pulling();
    capabilities["textDocument"]["codeAction"] = json!({
        "codeActionLiteralSupport": { "codeActionKind": { "valueSet": ["quickfix"] } },
    });
    let mut client = Client::start(folder.params(capabilities)).await;
    let uri = folder.uri("c.gen");
    client.open(&uri, text).await;
    let place = json!({ "line": 3, "character": 11 });
    let mut params = document(&uri);
    params["range"] = json!({ "start": place, "end": place });
    params["context"] = json!({ "diagnostics": [], "only": ["quickfix"] });
    let actions = client.ok("textDocument/codeAction", params).await;
    let actions = actions.as_array().expect("actions");
    let [here, project] = &actions[actions.len() - 2..] else { panic!("{actions:?}") };
    assert_eq!(here["title"], "Allow `fsm/missing-stop` here, with a comment");
    assert_eq!(here["isPreferred"], false);
    let edit = &here["edit"]["changes"][&uri][0];
    assert_eq!(edit["newText"], "  // dotgen: allow(fsm/missing-stop)\n");
    assert_eq!(edit["range"]["start"], json!({ "line": 3, "character": 0 }));
    assert_eq!(project["title"], "Allow `fsm/missing-stop` in this workspace, in dotgen.toml");
    let edit = &project["edit"]["changes"][folder.uri("dotgen.toml")][0];
    assert_eq!(edit["newText"], "[severity]\n\"fsm/missing-stop\" = \"off\"\n");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_included_file_can_be_shown_in_another_unit() {
    let files = [
        ("a.gen", "#define T long\n#include \"t.idl\"\n"),
        ("b.gen", "#define T short\n#include \"t.idl\"\n"),
        ("t.idl", "// shared\ntypedef T t;\n"),
    ];
    let folder = Folder::new(&files);
    let mut client = Client::start(folder.params(pulling())).await;
    let uri = folder.uri("t.idl");
    client.open(&uri, files[2].1).await;
    let expected = [folder.uri("a.gen"), folder.uri("b.gen")];
    // The folder is searched in the background of the first requests.
    let mut roots = Value::Null;
    for _ in 0..10_000 {
        roots = client.ok("dotgen/includingRoots", document(&uri)).await;
        if roots["roots"].as_array().is_some_and(|root| root.len() == 2) {
            break;
        }
    }
    assert_eq!(roots, json!({ "current": expected[0], "roots": expected }));
    let mut hover = document(&uri);
    hover["position"] = json!({ "line": 0, "character": 0 });
    let shown = client.ok("textDocument/hover", hover.clone()).await;
    let text = |json: &Value| json["contents"]["value"].as_str().unwrap_or_default().to_owned();
    assert!(text(&shown).contains("included by `a.gen`"), "{shown}");
    let choice = json!({ "command": "dotgen.chooseRoot",
                         "arguments": [{ "uri": uri, "root": expected[1] }] });
    client.ok("workspace/executeCommand", choice).await;
    let shown = client.ok("textDocument/hover", hover).await;
    assert!(text(&shown).contains("included by `b.gen`"), "{shown}");
    let unknown = json!({ "command": "rm", "arguments": [] });
    let error = client.request("workspace/executeCommand", unknown).await;
    assert_eq!(error.expect_err("unknown")["code"], -32602);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn documents_without_a_file_or_a_folder() {
    let elsewhere = Folder::new(&[("loose.gen", "typedef long t;\ntypedef t u;\n")]);
    let (mut client, _folder, _) = start(json!({})).await;
    let text = "typedef long t;\ntypedef t u;\n";
    for uri in ["untitled:Untitled-1".to_owned(), elsewhere.uri("loose.gen")] {
        client.open(&uri, text).await;
        let mut params = document(&uri);
        params["position"] = json!({ "line": 1, "character": 8 });
        let found = client.ok("textDocument/definition", params.clone()).await;
        assert_eq!(found[0]["uri"], json!(uri));
        let items = client.ok("textDocument/completion", params.clone()).await;
        assert!(items["items"].as_array().is_some_and(|items| !items.is_empty()));
        params["newName"] = json!("v");
        let edit = client.ok("textDocument/rename", params).await;
        assert_eq!(edit["changes"][&uri].as_array().map(Vec::len), Some(2), "{edit}");
    }
    client.finish().await;
}

/// A text after an edit that inserts text.
fn with_inserted(text: &str, edit: &Value) -> String {
    let number = |value: &Value| value.as_u64().expect("a number") as usize;
    let start = &edit["range"]["start"];
    let lines = text.split_inclusive('\n').take(number(&start["line"]));
    let at = lines.map(str::len).sum::<usize>() + number(&start["character"]);
    let new_text = edit["newText"].as_str().expect("a text");
    format!("{}{new_text}{}", &text[..at], &text[at..])
}

#[tokio::test(flavor = "multi_thread")]
async fn a_missing_brace_is_inserted_where_it_belongs() {
    const RIGHT: &str = "typedef long n;
component c {
  version \"1\";
  ids {
    long x;
    struct s { long y; } z;
  };
  task t {
    period 5 ms; // five
  };

  // What goes on.
  function f(in long y) {
    doc \"It works.\";
  };
};
";
    let folder = Folder::new(&[("a.gen", RIGHT)]);
    let mut client = Client::start(folder.params(pulling())).await;
    let uri = folder.uri("a.gen");
    let broken: Vec<(&str, &str)> = vec![
        ("component c {", "component c"),
        ("  ids {", "  ids"),
        ("struct s {", "struct s"),
        ("long y; } z", "long y; z"),
        ("long y; } z;\n  };", "long y; } z;"),
        ("task t {", "task t"),
        ("// five\n  };", "// five"),
        ("// five\n  };", "// five\n  ;"),
        ("(in long y) {", "(in long y)"),
        ("  };\n};\n", "  };\n"),
    ];
    for (i, (right, wrong)) in broken.into_iter().enumerate() {
        let text = RIGHT.replacen(right, wrong, 1);
        if i == 0 {
            client.open(&uri, &text).await;
        } else {
            let changes = json!([{ "text": text }]);
            client.change(&uri, i as i32 + 1, changes).await;
        }
        let found = client.ok("textDocument/diagnostic", document(&uri)).await;
        let mut found = found["items"].as_array().expect("diagnostics").clone();
        found.retain(|json| json["code"].as_str().is_some_and(|code| code.starts_with("syntax")));
        assert_eq!(found.len(), 1, "{wrong}: {found:?}");
        let mut params = document(&uri);
        params["range"] = found[0]["range"].clone();
        params["context"] = json!({ "diagnostics": [], "only": ["quickfix"] });
        let actions = client.ok("textDocument/codeAction", params).await;
        let edit = &actions[0]["edit"]["changes"][&uri][0];
        assert_eq!(edit["range"]["start"], edit["range"]["end"], "{actions}");
        assert_eq!(with_inserted(&text, edit), RIGHT, "{wrong}: {actions}");
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_editors_fix_unasked_is_plain() {
    let text = "component c {\n  task t {\n    period 5 ms;\n    codel<start> f() yield main, ethr\n    codel<main> g() yield main;\n  };\n};\n";
    let folder = Folder::new(&[("c.gen", text)]);
    let mut capabilities = pulling();
    capabilities["textDocument"]["codeAction"] = json!({
        "codeActionLiteralSupport": { "codeActionKind": { "valueSet": ["source"] } },
    });
    let mut client = Client::start(folder.params(capabilities)).await;
    let uri = folder.uri("c.gen");
    client.open(&uri, text).await;
    // Fixes that touch each other are made one after the other. Transitions are left to the user.
    for (kind, edits) in [("source.fixAll", [";"]), ("source.fixFindings", ["ether"])] {
        let mut params = document(&uri);
        params["range"] =
            json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 6, "character": 0 } });
        params["context"] = json!({ "diagnostics": [], "only": [kind] });
        let actions = client.ok("textDocument/codeAction", params).await;
        let action = &actions[0];
        assert_eq!(action["kind"], kind, "{actions}");
        let all = action["edit"]["changes"][&uri].as_array().expect("edits");
        let all: Vec<&str> = all.iter().filter_map(|change| change["newText"].as_str()).collect();
        assert_eq!(all, edits, "{action}");
    }
    client.finish().await;
}
