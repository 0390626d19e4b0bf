//! `dotgen/exportModel`.

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const PUMP: &str = "component pump {
  ids { double level; };
  task control { period 10 ms;
    codel<start> steer(inout level) yield pause::start wcet 3 ms;
  };
  activity fill() { task control;
    codel<start> open(inout level) yield ether wcet 1 ms;
  };
};
";

const SCENARIO: &str = "scenario tank {
  use \"pump.gen\";
  cores 1; policy fifo;
  client c { send pump.fill; await ended; };
  check limit: response pump.control <= 8 ms;
}
";

async fn start() -> (Client, Folder) {
    let folder = Folder::new(&[("pump.gen", PUMP), ("tank.scn", SCENARIO)]);
    let client = Client::start(folder.params(pulling())).await;
    (client, folder)
}

fn asked(uri: &str, format: &str) -> Value {
    let mut params = document(uri);
    params["format"] = json!(format);
    params
}

async fn exported(client: &mut Client, uri: &str, format: &str) -> Value {
    client.ok("dotgen/exportModel", asked(uri, format)).await
}

/// The refusals, each with the file and the line of its place.
fn refusals(answer: &Value) -> Vec<(String, String)> {
    let all = answer["refusals"].as_array().unwrap_or_else(|| panic!("{answer}"));
    let text = |json: &Value| json.as_str().unwrap_or_default().to_owned();
    let place = |json: &Value| {
        let uri = text(&json["location"]["uri"]);
        let name = uri.rsplit('/').next().unwrap_or_default();
        format!("{name}:{}", json["location"]["range"]["start"]["line"])
    };
    all.iter().map(|json| (text(&json["message"]), place(json))).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn every_format_has_its_files() {
    let (mut client, folder) = start().await;
    let uri = folder.uri("tank.scn");
    client.open(&uri, SCENARIO).await;
    let formats: &[(&str, &[&str])] = &[
        ("uppaal", &["tank.xta", "tank.q", "tank.xml"]),
        ("tchecker", &["tank.tck"]),
        ("fiacre", &["tank.fcr"]),
        ("bip", &["tank.bip"]),
    ];
    for (format, names) in formats {
        let answer = exported(&mut client, &uri, format).await;
        let files = answer["files"].as_array().unwrap_or_else(|| panic!("{answer}"));
        let found: Vec<&str> = files.iter().filter_map(|file| file["name"].as_str()).collect();
        assert_eq!(found, *names);
        for file in files {
            assert!(file["text"].as_str().is_some_and(|text| text.contains("limit")), "{file}");
        }
    }
    let error = client.request("dotgen/exportModel", asked(&uri, "spin")).await;
    assert_eq!(error.expect_err("the format is unknown")["code"], -32602);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn unsaved_edits_are_exported_with_their_places() {
    let (mut client, folder) = start().await;
    let (spec, uri) = (folder.uri("pump.gen"), folder.uri("tank.scn"));
    client.open(&uri, SCENARIO).await;
    client.open(&spec, PUMP).await;
    client.change(&uri, 2, json!([{ "text": SCENARIO.replace("tank", "basin") }])).await;
    let moved = format!("\n\n{}", PUMP.replace("3 ms", "5 ms"));
    client.change(&spec, 2, json!([{ "text": moved }])).await;
    let answer = exported(&mut client, &uri, "uppaal").await;
    assert_eq!(answer["files"][0]["name"], "basin.xta", "{answer}");
    let text = answer["files"][0]["text"].as_str().expect("text");
    assert!(text.contains("pump.gen:6") && !text.contains("pump.gen:4"), "{text}");
    // The specification alone, with the default scenario.
    let alone = exported(&mut client, &spec, "uppaal").await;
    assert_eq!(alone["files"][0]["name"], "pump.xta", "{alone}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn refusals_have_their_places() {
    let (mut client, folder) = start().await;
    let uri = folder.uri("tank.scn");
    let text = SCENARIO.replace("await ended;", "kill pump;").replace("fifo", "priority");
    client.open(&uri, &text).await;
    let found = refusals(&exported(&mut client, &uri, "uppaal").await);
    let expected = |message: &str, place: &str| (message.to_owned(), place.to_owned());
    assert_eq!(
        found,
        [
            expected("not exported: `policy priority`", "tank.scn:0"),
            expected("not exported: `kill` of c", "tank.scn:3"),
        ]
    );
    let text = SCENARIO.replace("\n}", "\n  check ends: eventually pump.fill.run;\n}");
    client.change(&uri, 2, json!([{ "text": text }])).await;
    let found = refusals(&exported(&mut client, &uri, "uppaal").await);
    let message = "not exported: `eventually` of ends: eventually pump.fill.run";
    assert_eq!(found, [expected(message, "tank.scn:5")]);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn errors_are_refusals() {
    let (mut client, folder) = start().await;
    let (spec, uri) = (folder.uri("pump.gen"), folder.uri("tank.scn"));
    client.open(&spec, &PUMP.replace("task control;", "task other;")).await;
    client.open(&uri, SCENARIO).await;
    let found = refusals(&exported(&mut client, &uri, "bip").await);
    assert!(found[0].1 == "pump.gen:5", "{found:?}");
    client
        .change(&uri, 2, json!([{ "text": SCENARIO.replace("pump.control", "pump.nobody") }]))
        .await;
    client.change(&spec, 2, json!([{ "text": PUMP }])).await;
    let found = refusals(&exported(&mut client, &uri, "bip").await);
    assert!(found[0].0.contains("nobody") && found[0].1 == "tank.scn:4", "{found:?}");
    // A document of another language has no model.
    let code = folder.uri("codels/steer.c");
    client.open(&code, "int x;\n").await;
    assert_eq!(exported(&mut client, &code, "bip").await, Value::Null);
    client.finish().await;
}

/// A component whose tasks all lock one member of the ids.
fn crowded(tasks: usize, codels: usize) -> String {
    use std::fmt::Write as _;
    let mut out = "component crowd {\n  ids { double level; };\n".to_owned();
    for task in 0..tasks {
        let _ = writeln!(out, "  task t{task} {{ period 10 ms;");
        for state in 0..codels {
            let name = if state == 0 { "start".to_owned() } else { format!("s{state}") };
            let next =
                if state + 1 == codels { "start".to_owned() } else { format!("s{}", state + 1) };
            let _ = writeln!(
                out,
                "    codel<{name}> f{task}_{state}(inout level) yield pause::{next} wcet 1 us;"
            );
        }
        out.push_str("  };\n");
    }
    out + "};\n"
}

#[tokio::test(flavor = "multi_thread")]
async fn a_large_system_is_refused_and_the_client_can_cancel() {
    let folder = Folder::new(&[]);
    let mut params = folder.params(pulling());
    params["initializationOptions"] =
        json!({ "settings": { "dotgen": { "verification": { "enable": false } } } });
    let mut client = Client::start(params).await;
    let uri = folder.uri("crowd.gen");
    client.open(&uri, &crowded(20, 20)).await;
    let id = client.begin("dotgen/exportModel", asked(&uri, "uppaal")).await;
    client.notify("$/cancelRequest", json!({ "id": id })).await;
    assert_eq!(client.end(id).await.expect_err("cancelled")["code"], -32800);
    let found = refusals(&exported(&mut client, &uri, "uppaal").await);
    assert_eq!(found.len(), 1);
    assert!(found[0].0.contains("too large"), "{found:?}");
    // The writer is free.
    client.change(&uri, 2, json!([{ "text": crowded(2, 2) }])).await;
    let answer = exported(&mut client, &uri, "uppaal").await;
    assert_eq!(answer["files"][0]["name"], "crowd.xta", "{answer}");
    client.finish().await;
}
