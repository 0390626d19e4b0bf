//! Scenario documents over the protocol.

use serde_json::{Value, json};

use super::client::{Client, Folder, codes, document, pulling};

const PUMP: &str = "struct flow { double rate; }; component pump {
  ids { double level; };
  port in flow inflow;
  port out flow outflow;
  task t { period 10 ms;
    codel<start> init(out level) yield main wcet 1 ms;
    codel<main> control(inout level) yield pause::main wcet 4 ms;
  };
  attribute set_level(in level);
  activity drain() { task t;
    codel<start> open(out level) yield pause::start, ether wcet 1 ms;
  };
};
";

const SCENARIO: &str = "scenario tank {
  use \"pump.gen\";
  cores 2;
  client operator {
    first: send pump.drain;
    await ended pump.drain;
  }
  check limit: response pump.t <= 8 ms;
  check within pump.drain.start => leave operator.first;
}
";

/// A client with the scenario open, and the position of `$0` in it, if any. `$0` is removed.
async fn start(scenario: &str) -> (Client, Folder, String, Value) {
    let folder = Folder::new(&[("pump.gen", PUMP), ("other.gen", "const long a = 1;\n")]);
    let mut params = folder.params(pulling());
    params["capabilities"]["textDocument"]["documentSymbol"] =
        json!({ "hierarchicalDocumentSymbolSupport": true });
    params["capabilities"]["workspace"]["workspaceEdit"] = json!({ "documentChanges": true });
    let mut client = Client::start(params).await;
    let uri = folder.uri("tank.scn");
    let offset = scenario.find("$0").unwrap_or(0);
    let text = scenario.replace("$0", "");
    client.open(&uri, &text).await;
    let line = text[..offset].matches('\n').count();
    let start = text[..offset].rfind('\n').map_or(0, |end| end + 1);
    let mut params = document(&uri);
    params["position"] = json!({ "line": line, "character": offset - start });
    (client, folder, uri, params)
}

/// The scenario with the cursor after the first of some text.
fn at(text: &str) -> String {
    SCENARIO.replacen(text, &format!("{text}$0"), 1)
}

async fn labels(scenario: &str) -> Vec<String> {
    let (mut client, _folder, _, params) = start(scenario).await;
    let list = client.ok("textDocument/completion", params).await;
    client.finish().await;
    let items = list["items"].as_array().expect("a list").iter();
    items.map(|json| json["label"].as_str().expect("text").to_owned()).collect()
}

/// `file:line` of every location.
fn places(locations: &Value) -> Vec<String> {
    let all = locations.as_array().into_iter().flatten();
    let mut places: Vec<String> = all
        .map(|location| {
            let file = location["uri"].as_str().expect("a uri").rsplit('/').next();
            let line = &location["range"]["start"]["line"];
            format!("{}:{line}", file.unwrap_or_default())
        })
        .collect();
    places.sort();
    places
}

#[tokio::test(flavor = "multi_thread")]
async fn completion_knows_the_place() {
    for (text, wanted) in [
        ("$0", "scenario"),
        (
            "scenario a {\n $0",
            "use times weights unit semantics cores policy affinity durations duration loop idle ticks turns locks \
                ports pause exceptions order async aperiodic connect slots client on check",
        ),
        ("scenario a { policy $0", "fifo edf any priority fair"),
        ("scenario a { policy f$0", "fifo edf any priority fair"),
        ("scenario a { use \"$0\"; }", "other.gen pump.gen"),
        (
            "scenario a { use \"pump.gen\"; check $0",
            "schedulable no-overdue response within reaction age leadsto eventually always never reachable \
                deadlock absent lasts before after between",
        ),
        (
            "scenario a { use \"pump.gen\"; check x: $0 }",
            "schedulable no-overdue response within reaction age leadsto eventually always never reachable \
                deadlock absent lasts before after between",
        ),
        ("scenario a { use \"pump.gen\"; check schedulable $0; }", "* pump.t"),
        ("scenario a { use \"pump.gen\"; check response pump.$0", "pump.t"),
        ("scenario a { use \"pump.gen\"; check response pump.t <= 5 $0", "ms us s"),
        (
            "scenario a { use \"pump.gen\"; duration pump.$0",
            "pump.t.start pump.t.main pump.drain.start",
        ),
        ("scenario a { use \"pump.gen\"; duration pump.t.main [1,2] $0", "ms us s"),
        ("scenario a { use \"pump.gen\"; slots $0", "pump.t pump.drain"),
        ("scenario a { use \"pump.gen\"; connect $0", "pump.inflow"),
        ("scenario a { use \"pump.gen\"; connect pump.inflow $0", "to"),
        ("scenario a { use \"pump.gen\"; connect pump.inflow to $0", "none pump.outflow"),
        (
            "scenario a { use \"pump.gen\"; client c { $0",
            "send await delay repeat choice abort kill connect stop",
        ),
        (
            "scenario a { use \"pump.gen\"; client c { again: send $0 } }",
            "pump.set_level pump.drain",
        ),
        (
            "scenario a { use \"pump.gen\"; client c { choice { } $0",
            "or send await delay repeat choice abort kill connect stop",
        ),
        (
            "scenario a { use \"pump.gen\"; client c { x: send pump.drain; } check always $0",
            "pump c not leave",
        ),
        ("scenario a { use \"pump.gen\"; client c { x: send pump.drain; } check always c.$0", "x"),
        (
            "scenario a { use \"pump.gen\"; check always pump.t.$0",
            "start main idle waiting running tick",
        ),
        ("scenario a { use \"pump.gen\"; check always pump.t $0", "and or"),
        (
            "scenario a { use \"pump.gen\"; check absent pump.t after pump.drain $0",
            "and or after for",
        ),
        ("scenario a { use \"pump.gen\"; check within pump => pump.t $0", "and or then in"),
        ("scenario a { use \"pump.gen\"; check pump.t $0", "and or precedes"),
        ("scenario a { // $0", ""),
        ("scenario a { cores 2; // policy\n  cores 3$0", ""),
    ] {
        assert_eq!(labels(text).await.join(" "), wanted, "{text}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_completion_replaces_the_whole_path() {
    let (mut client, _folder, _, params) = start(&at("response pump")).await;
    let list = client.ok("textDocument/completion", params).await;
    let edit = &list["items"][0]["textEdit"];
    assert_eq!((&edit["newText"], &edit["range"]["start"]["character"]), (&json!("*"), &json!(24)));
    let edit = &list["items"][1]["textEdit"];
    assert_eq!(
        (&edit["newText"], &edit["range"]["start"]["character"]),
        (&json!("pump.t"), &json!(24))
    );
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn hovers_explain_names_and_words() {
    for (at_text, wanted) in [
        ("cores", "Number of cores"),
        ("send pump.drain", "activity pump.drain"),
        ("response pump.t", "period 10 ms"),
        ("within pump.drain.start", "takes at most 1 ms"),
        ("leave operator", "client operator"),
    ] {
        let (mut client, _folder, _, params) = start(&at(at_text)).await;
        let hover = client.ok("textDocument/hover", params).await;
        let text = hover["contents"]["value"].as_str().expect("text");
        assert!(text.contains(wanted), "{at_text}: {text}");
        client.finish().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn names_lead_to_their_declarations() {
    for (at_text, wanted) in [
        ("use \"pump.gen", "pump.gen:0"),
        ("send pump", "pump.gen:0"),
        ("send pump.drain", "pump.gen:9"),
        ("response pump.t", "pump.gen:4"),
        ("within pump.drain.start", "pump.gen:10"),
        ("leave operator", "tank.scn:3"),
        ("leave operator.first", "tank.scn:4"),
    ] {
        let (mut client, _folder, _, params) = start(&at(at_text)).await;
        let found = client.ok("textDocument/definition", params).await;
        assert_eq!(places(&found), [wanted], "{at_text}");
        client.finish().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn references_and_renames_cross_the_languages() {
    let (mut client, folder, scn, _) = start(SCENARIO).await;
    let gen_uri = folder.uri("pump.gen");
    client.open(&gen_uri, PUMP).await;
    let mut params = document(&gen_uri);
    params["position"] = json!({ "line": 9, "character": 12 });
    params["context"] = json!({ "includeDeclaration": true });
    let found = client.ok("textDocument/references", params.clone()).await;
    let both = ["pump.gen:9", "tank.scn:4", "tank.scn:5", "tank.scn:8"];
    assert_eq!(places(&found), both);
    let mut from_scenario = document(&scn);
    from_scenario["position"] = json!({ "line": 4, "character": 22 });
    from_scenario["context"] = json!({ "includeDeclaration": true });
    let found = client.ok("textDocument/references", from_scenario.clone()).await;
    assert_eq!(places(&found), both);

    for mut params in [params, from_scenario] {
        params["newName"] = json!("empty");
        let edit = client.ok("textDocument/rename", params).await;
        let changes = edit["documentChanges"].as_array().expect("a list");
        let mut counts: Vec<(String, usize)> = changes
            .iter()
            .map(|change| {
                let uri = change["textDocument"]["uri"].as_str().expect("a uri");
                let edits = change["edits"].as_array().expect("a list");
                assert!(edits.iter().all(|edit| edit["newText"] == "empty"));
                (uri.rsplit('/').next().unwrap_or_default().to_owned(), edits.len())
            })
            .collect();
        counts.sort();
        assert_eq!(counts, [("pump.gen".to_owned(), 1), ("tank.scn".to_owned(), 3)]);
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_outline_folds_and_formats() {
    let (mut client, _folder, uri, _) = start(SCENARIO).await;
    let symbols = client.ok("textDocument/documentSymbol", document(&uri)).await;
    assert_eq!(symbols[0]["name"], "tank");
    let children = symbols[0]["children"].as_array().expect("a list").iter();
    let names: Vec<&str> = children.filter_map(|child| child["name"].as_str()).collect();
    assert_eq!(
        names,
        ["pump.gen", "operator", "limit", "check within pump.drain.start => leave operator.first"]
    );
    let folds = client.ok("textDocument/foldingRange", document(&uri)).await;
    assert_eq!(folds.as_array().map(Vec::len), Some(2));
    let mut params = document(&uri);
    params["options"] = json!({ "tabSize": 2, "insertSpaces": true });
    assert_eq!(client.ok("textDocument/formatting", params.clone()).await, Value::Null);
    let untidy = SCENARIO.replace("  cores 2;", "cores   2 ;");
    client.change(&uri, 2, json!([{ "text": untidy }])).await;
    let edits = client.ok("textDocument/formatting", params.clone()).await;
    // Only the blanks change, so that the cursor and the marks of the editor stay.
    let texts = edits.as_array().map(|edit| edit.iter().map(|edit| &edit["newText"]).collect());
    assert_eq!(texts, Some(vec![&json!("\n  "), &json!(" "), &json!("")]));
    params["range"] =
        json!({ "start": { "line": 4, "character": 0 }, "end": { "line": 5, "character": 0 } });
    let part = client.ok("textDocument/rangeFormatting", params).await;
    assert_eq!(part, Value::Null);
    client.finish().await;
}

/// The titles and new texts of the quick fixes at a place.
async fn fixes(scenario: &str) -> Vec<(String, String)> {
    let (mut client, _folder, uri, mut params) = start(scenario).await;
    let at = params["position"].clone();
    params["range"] = json!({ "start": at, "end": at });
    params["context"] = json!({ "diagnostics": [], "only": ["quickfix"] });
    let actions = client.ok("textDocument/codeAction", params).await;
    client.finish().await;
    let actions = actions.as_array().expect("a list").iter();
    let fixes = actions.map(|action| {
        let edit = &action["edit"]["documentChanges"][0];
        assert_eq!(edit["textDocument"]["uri"], uri, "{action}");
        let text = |value: &Value| value.as_str().expect("a text").to_owned();
        (text(&action["title"]), text(&edit["edits"][0]["newText"]))
    });
    fixes.collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn misspelt_words_and_names_have_a_fix() {
    for (right, wrong, fixed) in [
        ("response", "respons$0e_", "response"),
        ("cores", "cpres$0", "cores"),
        ("await", "awiat$0", "await"),
        ("8 ms", "8 m$0sc", "ms"),
        ("pump.drain.start", "pump.dra$0n.start", "drain"),
    ] {
        assert_eq!(
            fixes(&SCENARIO.replacen(right, wrong, 1)).await,
            [(format!("Change to `{fixed}`"), fixed.to_owned())],
            "{wrong}"
        );
    }
    assert_eq!(fixes(&SCENARIO.replacen("cores", "zz$0", 1)).await, []);
}

#[tokio::test(flavor = "multi_thread")]
async fn selections_grow_links_lead_to_files_and_names_have_colours() {
    let (mut client, folder, uri, mut params) = start(&at("await ended pump.dra")).await;
    params["positions"] = json!([params["position"]]);
    let selections = client.ok("textDocument/selectionRange", params).await;
    let mut lines = Vec::new();
    let mut range = &selections[0];
    while let Some(start) = range["range"]["start"]["line"].as_u64() {
        lines.push((start, range["range"]["end"]["line"].as_u64().expect("a line")));
        range = &range["parent"];
    }
    // The word, the path, the step; the contents of the client, its braces, the client; the scenario.
    assert_eq!(
        lines,
        [(5, 5), (5, 5), (5, 5), (3, 6), (3, 6), (3, 6), (0, 9), (0, 9), (0, 9), (0, 10)]
    );

    let links = client.ok("textDocument/documentLink", document(&uri)).await;
    assert_eq!(links[0]["target"], folder.uri("pump.gen"));
    assert_eq!(links[0]["range"]["start"], json!({ "line": 1, "character": 7 }));

    let tokens = client.ok("textDocument/semanticTokens/full", document(&uri)).await;
    let count = tokens["data"].as_array().map_or(0, Vec::len) / 5;
    let mut in_line = document(&uri);
    in_line["range"] =
        json!({ "start": { "line": 4, "character": 0 }, "end": { "line": 4, "character": 99 } });
    let part = client.ok("textDocument/semanticTokens/range", in_line).await;
    // `first` and `send`, `pump`, `drain`.
    assert_eq!(part["data"].as_array().map_or(0, Vec::len) / 5, 3, "{part}");
    assert!(count > 20, "{count}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn diagnostics_say_what_is_wrong_and_where() {
    for (text, code, line) in [
        (SCENARIO.replace("cores 2", "cores two"), "scn-syntax", 2),
        (SCENARIO.replace("pump.gen", "pomp.gen"), "scn-use-not-found", 1),
        (SCENARIO.replace("response pump.t", "response pump.u"), "scn-unknown-name", 7),
    ] {
        let (mut client, _folder, uri, _) = start(&text).await;
        let report = client.ok("textDocument/diagnostic", document(&uri)).await;
        assert_eq!(codes(&report["items"]), [code], "{report}");
        assert_eq!(report["items"][0]["range"]["start"]["line"], line);
        client.finish().await;
    }
}

/// Every prefix of a text, and every text without one byte: no panic, and every request is answered.
#[tokio::test(flavor = "multi_thread")]
async fn half_typed_text_is_survived() {
    let (mut client, _folder, uri, _) = start("").await;
    let mut version = 1;
    let texts = (0..SCENARIO.len()).step_by(3).flat_map(|i| {
        let mut without = SCENARIO.to_owned();
        without.remove(i);
        [(SCENARIO[..i].to_owned(), i), (without, i)]
    });
    for (text, offset) in texts {
        version += 1;
        client.change(&uri, version, json!([{ "text": text }])).await;
        let line = text[..offset].matches('\n').count();
        let start = text[..offset].rfind('\n').map_or(0, |end| end + 1);
        let mut params = document(&uri);
        params["position"] = json!({ "line": line, "character": offset - start });
        for method in [
            "completion",
            "hover",
            "definition",
            "documentHighlight",
            "documentSymbol",
            "foldingRange",
        ] {
            let method = format!("textDocument/{method}");
            client.ok(&method, params.clone()).await;
        }
        client.pulled(&uri).await;
    }
    client.finish().await;
}
