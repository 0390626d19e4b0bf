//! Random edits and requests, valid and invalid.

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const PIECES: [&str; 16] = [
    "component c {\n",
    "};\n",
    "task t { period 1 ms; };\n",
    "codel<start, pause::x> f(in a.b[0]::r, port out p) yield ether, x",
    "#include \"pose.idl\"\n",
    "#if 0\r\n",
    "#endif\n",
    "#define M(x) struct x { M }",
    "M(s);",
    "port in sequence<optional<pose>, 3> p;\r",
    "ids { pose a, b[2]; };",
    "é😀",
    "/* ",
    "\"",
    "attribute set(in a = { .x = 1, [2] = : \"doc\" });",
    "",
];

const QUESTIONS: [&str; 16] = [
    "textDocument/hover",
    "textDocument/definition",
    "textDocument/typeDefinition",
    "textDocument/declaration",
    "textDocument/documentHighlight",
    "textDocument/documentSymbol",
    "textDocument/foldingRange",
    "textDocument/semanticTokens/full",
    "textDocument/completion",
    "textDocument/signatureHelp",
    "textDocument/implementation",
    "textDocument/prepareCallHierarchy",
    "textDocument/codeLens",
    "textDocument/diagnostic",
    "dotgen/expandMacro",
    "dotgen/model",
];

/// A small generator, so that a failure repeats.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(self.0 >> 33).unwrap_or(0) % sides.max(1)
    }

    /// A position, in most cases inside the text.
    fn position(&mut self, text: &str) -> Value {
        let lines = text.matches(['\n', '\r']).count() + 1;
        json!({ "line": self.roll(lines + 1), "character": self.roll(30) })
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_a_client_does_costs_more_than_its_request() {
    for seed in 0..4 {
        rage(seed, 150).await;
    }
}

async fn rage(seed: u64, steps: i32) {
    let mut dice = Dice(seed);
    let folder = Folder::new(&[("pose.idl", "struct pose { double x, y; };\n")]);
    let uri = folder.uri("arm.gen");
    let mut client = Client::start(folder.params(pulling())).await;
    client.open(&uri, "").await;
    let mut begun = Vec::new();
    let mut text = String::new();
    for version in 2..steps {
        if dice.roll(20) == 0 {
            // The whole text: the document is known again after any earlier edits.
            text = (0..dice.roll(12)).map(|_| PIECES[dice.roll(PIECES.len())]).collect();
            client.change(&uri, version, json!([{ "text": text }])).await;
        } else {
            let (start, end) = (dice.position(&text), dice.position(&text));
            let piece = PIECES[dice.roll(PIECES.len())];
            let edit = json!({ "range": { "start": start, "end": end }, "text": piece });
            client.change(&uri, version, json!([edit])).await;
            text.push_str(piece);
        }
        let question = QUESTIONS[dice.roll(QUESTIONS.len())];
        let mut params = document(&uri);
        params["position"] = dice.position(&text);
        let id = client.begin(question, params).await;
        match dice.roll(8) {
            0 => client.notify("$/cancelRequest", json!({ "id": id })).await,
            1 => {
                let _ = client.end(id).await;
                continue;
            }
            _ => {}
        }
        begun.push((question, id));
    }
    for (question, id) in begun {
        if let Err(error) = client.end(id).await {
            let code = error["code"].as_i64().expect("a number");
            let known = [-32800, -32801, -32802];
            assert!(known.contains(&code), "seed {seed}, {question}: {error}");
        }
    }
    client.change(&uri, steps, json!([{ "text": "const long a = 1;" }])).await;
    let last = client.ok("test/text", document(&uri)).await;
    assert_eq!(last, "const long a = 1;");
    client.finish().await;
}
