use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const ARM: &str = r#"#include "pose.idl"
#define RATE 5

/* Moves
   the arm. */
component arm {
  version "1.0";
  ids { pose goal; };
  port out pose state;
  task motion {
    period RATE ms;
    codel<start> init(out ::ids) yield ether;
  };
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

fn names(symbols: &Value) -> Vec<String> {
    let mut names = Vec::new();
    for symbol in symbols.as_array().into_iter().flatten() {
        names.push(symbol["name"].as_str().unwrap_or_default().to_owned());
        names.extend(self::names(&symbol["children"]));
    }
    names
}

#[tokio::test(flavor = "multi_thread")]
async fn symbols_are_nested_or_flat_as_the_client_likes() {
    let nested = json!({ "documentSymbol": { "hierarchicalDocumentSymbolSupport": true } });
    let (mut client, _folder, uri) = start(nested).await;
    let symbols = client.ok("textDocument/documentSymbol", document(&uri)).await;
    let all = names(&symbols);
    for name in ["arm", "goal", "state", "motion", "init"] {
        assert!(all.iter().any(|candidate| candidate == name), "{name} in {all:?}");
    }
    client.finish().await;

    let (mut client, _folder, uri) = start(json!({})).await;
    let symbols = client.ok("textDocument/documentSymbol", document(&uri)).await;
    assert_eq!(names(&symbols).len(), all.len());
    assert_eq!(symbols[0]["location"]["uri"], uri);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn semantic_tokens_leave_to_a_grammar_what_it_tells_as_well() {
    let capabilities = json!({ "semanticTokens": {
        "requests": {}, "tokenTypes": [], "tokenModifiers": [], "formats": ["relative"],
        "augmentsSyntaxTokens": true,
    } });
    let (mut client, _folder, uri) = start(capabilities).await;
    let tokens = client.ok("textDocument/semanticTokens/full", document(&uri)).await;
    let data = tokens["data"].as_array().expect("numbers").clone();
    let types: Vec<u64> = data.chunks(5).filter_map(|chunk| chunk[3].as_u64()).collect();
    let legend = crate::protocol::convert::semantic_tokens::legend().token_types;
    let lexical = ["comment", "keyword", "string", "number", "operator", "directive"];
    assert!(!types.is_empty());
    for ty in types {
        assert!(!lexical.contains(&legend[ty as usize].as_str()));
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn semantic_tokens_come_whole_and_in_part() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let full = client.ok("textDocument/semanticTokens/full", document(&uri)).await;
    let data = full["data"].as_array().expect("numbers").clone();
    assert!(data.len() > 50 && data.len() % 5 == 0);

    let mut params = document(&uri);
    params["range"] = json!({ "start": { "line": 1, "character": 0 },
                              "end": { "line": 2, "character": 0 } });
    let part = client.ok("textDocument/semanticTokens/range", params).await;
    assert!(part["data"].as_array().is_some_and(|data| !data.is_empty() && data.len() < 50));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn definitions_are_links_or_locations_as_the_client_likes() {
    let (mut client, folder, uri) = start(json!({ "definition": { "linkSupport": true } })).await;
    let found = client.ok("textDocument/definition", at(&uri, "pose goal", 0)).await;
    assert_eq!(found[0]["targetUri"], folder.uri("pose.idl"));
    assert_eq!(found[0]["targetSelectionRange"]["start"], json!({ "line": 0, "character": 7 }));
    assert_eq!(found[0]["originSelectionRange"]["start"], at(&uri, "pose goal", 0)["position"]);
    client.finish().await;

    let (mut client, folder, uri) = start(json!({})).await;
    let method = "textDocument/definition";
    let found = client.ok(method, at(&uri, "pose.idl", 0)).await;
    assert_eq!(found[0]["uri"], folder.uri("pose.idl"));
    let found = client.ok(method, at(&uri, "RATE", 1)).await;
    assert_eq!(found[0]["range"]["start"], json!({ "line": 1, "character": 8 }));
    let found = client.ok("textDocument/typeDefinition", at(&uri, "state", 0)).await;
    assert_eq!(found[0]["uri"], folder.uri("pose.idl"));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn names_are_found_everywhere() {
    let (mut client, folder, uri) = start(json!({})).await;
    let mut params = at(&uri, "pose goal", 0);
    params["context"] = json!({ "includeDeclaration": true });
    let references = client.ok("textDocument/references", params).await;
    let files: Vec<_> = references
        .as_array()
        .expect("a list")
        .iter()
        .map(|reference| reference["uri"].as_str().expect("a URI").to_owned())
        .collect();
    assert_eq!(files.len(), 3, "{references}");
    assert!(files.contains(&folder.uri("pose.idl")));

    let highlights = client.ok("textDocument/documentHighlight", at(&uri, "pose goal", 0)).await;
    assert_eq!(highlights.as_array().map(Vec::len), Some(2));

    let hover = client.ok("textDocument/hover", at(&uri, "pose goal", 0)).await;
    let text = hover["contents"]["value"].as_str().expect("Markdown");
    assert!(text.contains("pose"), "{text}");

    let symbols = client.ok("workspace/symbol", json!({ "query": "motion" })).await;
    assert_eq!(symbols[0]["name"], "motion");
    assert_eq!(symbols[0]["location"]["uri"], uri);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn regions_fold_expand_and_link() {
    let (mut client, folder, uri) =
        start(json!({ "foldingRange": { "lineFoldingOnly": true } })).await;
    let folds = client.ok("textDocument/foldingRange", document(&uri)).await;
    let body = folds
        .as_array()
        .expect("a list")
        .iter()
        .find(|client| client["startLine"] == 5)
        .expect("the component's body");
    assert_eq!(body["endLine"], 12, "the closing brace stays visible");
    assert!(
        folds
            .as_array()
            .is_some_and(|client| client.iter().any(|client| client["kind"] == "comment"))
    );

    let mut params = document(&uri);
    params["positions"] = json!([at(&uri, "init", 0)["position"], at(&uri, "RATE", 1)["position"]]);
    let chains = client.ok("textDocument/selectionRange", params).await;
    assert_eq!(chains.as_array().map(Vec::len), Some(2));
    let mut depth = 0;
    let mut range = &chains[0];
    while !range.is_null() {
        depth += 1;
        range = &range["parent"];
    }
    assert!(depth > 4, "{depth} levels");

    let links = client.ok("textDocument/documentLink", document(&uri)).await;
    assert_eq!(links[0]["target"], folder.uri("pose.idl"));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_dotgen_makes_of_a_document_can_be_looked_at() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let tree = client.ok("dotgen/syntaxTree", document(&uri)).await;
    assert!(tree.as_str().is_some_and(|tree| tree.contains("COMPONENT")), "{tree}");
    let model = client.ok("dotgen/model", document(&uri)).await;
    assert_eq!(model["components"][0]["name"], "arm");
    let items = client.ok("dotgen/itemTree", document(&uri)).await;
    assert!(items.as_str().is_some_and(|client| client.contains("\"motion\"")), "{items}");
    let call = client.ok("dotgen/expandMacro", at(&uri, "RATE", 1)).await;
    assert_eq!((&call["name"], &call["expansion"]), (&json!("RATE"), &json!("5")));
    assert_eq!(call["range"]["start"], at(&uri, "RATE", 1)["position"]);
    let none = client.ok("dotgen/expandMacro", at(&uri, "motion", 0)).await;
    assert_eq!(none, Value::Null);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn prototypes_are_aligned_under_their_first_argument() {
    let (mut client, folder, _) = start(json!({})).await;
    let uri = folder.uri("long.gen");
    let text = "struct trajectory { double x; };\ncomponent c {\n  ids { trajectory one, other; };\n  task t {\n    \
                codel<start> plan_it(in one, out other)\n      yield ether;\n  };\n};\n";
    client.open(&uri, text).await;
    let mut params = document(&uri);
    params["position"] = json!({ "line": 4, "character": 20 });
    let hover = client.ok("textDocument/hover", params).await;
    let shown = hover["contents"]["value"].as_str().expect("a hover");
    let fences: Vec<&str> = shown.split("```").collect();
    let of = |language: &str| fences.iter().find_map(|fence| fence.strip_prefix(language));
    assert_eq!(
        of("c\n"),
        Some(
            "genom_event plan_it(const trajectory *one, trajectory *other,\n\
             \x20                   const genom_context self);\n"
        ),
        "{shown}"
    );
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn fixes_are_offered_where_they_apply() {
    let literals = json!({ "codeActionKind": { "valueSet": ["quickfix"] } });
    let capabilities = json!({ "codeAction": { "codeActionLiteralSupport": literals } });
    let (mut client, folder, _) = start(capabilities).await;
    let uri = folder.uri("bare.gen");
    let text = "component c {\n  task t { period 1 s; codel<start> f() yield ether 26 us; };\n};\n";
    client.open(&uri, text).await;
    let action = |line: u32, only: Value| {
        let at = json!({ "line": line, "character": 55 });
        let mut params = document(&uri);
        params["range"] = json!({ "start": at, "end": at });
        params["context"] = json!({ "diagnostics": [], "only": only });
        params
    };
    let method = "textDocument/codeAction";
    let actions = client.ok(method, action(1, Value::Null)).await;
    let edit = &actions[0]["edit"]["changes"][&uri][0];
    assert_eq!(edit["newText"], "wcet ", "{actions}");
    assert_eq!(edit["range"]["start"], json!({ "line": 1, "character": 52 }));
    assert_eq!(actions[0]["kind"], "quickfix");
    assert_eq!(client.ok(method, action(0, Value::Null)).await, json!([]));
    let others = client.ok(method, action(1, json!(["refactor"]))).await;
    let mut others = others.as_array().into_iter().flatten();
    assert!(others.all(|client| {
        client["kind"].as_str().is_some_and(|kind| kind.starts_with("refactor"))
    }));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn fixes_are_offered_where_they_change_something() {
    let literals = json!({ "codeActionKind": { "valueSet": ["quickfix"] } });
    let capabilities = json!({ "codeAction": { "codeActionLiteralSupport": literals } });
    let (mut client, folder, _) = start(capabilities).await;
    let uri = folder.uri("bare.gen");
    let text = "component c {\n  task t { period 10 ms;\n    codel<start> first() yield pause::lopp;\n    \
                codel<loop> second() yield pause::loop, ether;\n  };\n};\n";
    client.open(&uri, text).await;
    let mut offered = Vec::new();
    for (line, character) in [(2, 19), (2, 40), (2, 30)] {
        let at = json!({ "line": line, "character": character });
        let mut params = document(&uri);
        params["range"] = json!({ "start": at, "end": at });
        params["context"] = json!({ "diagnostics": [], "only": ["quickfix"] });
        let actions = client.ok("textDocument/codeAction", params).await;
        let shown = actions.as_array().expect("a list").iter().map(|action| {
            let code = action["diagnostics"][0]["code"].as_str().unwrap_or_default();
            let title = action["title"].as_str().expect("a title");
            (format!("{code}: {title}"), action["isPreferred"] == true)
        });
        offered.push(shown.collect::<Vec<_>>());
    }
    let fix = |text: &str, preferred| (format!("fsm/{text}"), preferred);
    assert_eq!(
        offered,
        [
            vec![],
            // At the reported state. The intended state is a guess.
            vec![
                fix("undefined-state: Change to `loop`", false),
                fix("undefined-state: Declare a codel for the state `lopp`", false),
            ],
            vec![],
        ]
    );
    client.finish().await;
}
