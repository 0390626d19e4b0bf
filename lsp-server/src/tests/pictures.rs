//! `dotgen/diagram`, pictures as text, and the lenses that link to them.

use std::path::Path;

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const LIFT: &str = r"component lift {
  ids { double height; };
  port in height_s wanted;
  task move {
    period 10 ms;
    codel<start> init(out height) wcet 1 ms yield up;
    codel<up> raise(inout height) wcet 2 ms yield pause::up, ether;
  };
  activity go() {
    task move;
    codel<start> look(in height) yield ether;
  };
  attribute get(out height);
};
";

fn text() -> String {
    format!("struct height_s {{ double h; }};\n{LIFT}")
}

async fn start(options: Value) -> (Client, Folder, String) {
    start_beside(options, &[]).await
}

/// Starts with additional files in the folder.
async fn start_beside(options: Value, files: &[(&str, &str)]) -> (Client, Folder, String) {
    let text = text();
    let mut all = vec![("lift.gen", text.as_str())];
    all.extend_from_slice(files);
    let folder = Folder::new(&all);
    let mut params = folder.params(pulling());
    params["initializationOptions"] = options;
    let mut client = Client::start(params).await;
    let uri = folder.uri("lift.gen");
    client.open(&uri, &text).await;
    (client, folder, uri)
}

async fn draw(client: &mut Client, uri: &str, more: Value) -> Value {
    let mut params = document(uri);
    for (key, value) in more.as_object().cloned().unwrap_or_default() {
        params[key] = value;
    }
    client.ok("dotgen/diagram", params).await
}

/// The start of a text.
fn position(of: &str) -> Value {
    let text = text();
    let offset = text.find(of).expect("it occurs");
    let start = text[..offset].rfind('\n').map_or(0, |end| end + 1);
    json!({ "line": text[..offset].matches('\n').count(), "character": offset - start })
}

fn ids(answer: &Value) -> Vec<&str> {
    let nodes = answer["nodes"].as_array().expect("nodes");
    nodes.iter().filter_map(|node| node["id"].as_str()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_machine_at_a_place_or_of_a_name() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let at = draw(&mut client, &uri, json!({ "position": position("raise") })).await;
    assert_eq!(at["owner"], "move");
    assert_eq!(at["component"], "lift");
    assert!(ids(&at).contains(&"up"), "{at}");
    let named = draw(&mut client, &uri, json!({ "component": "lift", "owner": "move" })).await;
    assert_eq!(at["picture"], named["picture"]);
    assert_eq!(at["place"]["selectionRange"]["start"], position("move {"));

    let go = draw(
        &mut client,
        &uri,
        json!({ "position": position("look"), "component": "lift", "owner": "move" }),
    )
    .await;
    assert_eq!(go["owner"], "go", "what is at the place wins over the name");
    let nothing = draw(&mut client, &uri, json!({ "owner": "nobody" })).await;
    assert_eq!(nothing, Value::Null);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_node_knows_its_place_and_its_codel() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let answer = draw(&mut client, &uri, json!({ "owner": "move" })).await;
    let nodes = answer["nodes"].as_array().expect("nodes");
    let up = nodes.iter().find(|node| node["id"] == "up").expect("the state");
    assert_eq!(up["place"]["uri"], uri.as_str());
    assert_eq!(up["place"]["selectionRange"]["start"], position("raise"), "{up}");
    assert_eq!(up["place"]["range"]["start"], position("codel<up>"), "{up}");
    assert_eq!(
        up["codel"],
        json!({
            "name": "raise",
            "states": ["up"],
            "async": false,
            "params": ["inout ids height"],
            "wcet": "2 ms",
            "excludes": ["get (through height of the ids)"],
        })
    );
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_broken_text_keeps_the_last_picture() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let wish = json!({ "component": "lift", "owner": "move" });
    let good = draw(&mut client, &uri, wish.clone()).await;
    assert_eq!(good["stale"], Value::Null);

    let broken = text().replace("yield pause::up, ether;", "yield pause::, ,;");
    client.change(&uri, 2, json!([{ "text": broken }])).await;
    let stale = draw(&mut client, &uri, wish.clone()).await;
    assert_eq!(stale["picture"], good["picture"]);
    let reason = stale["stale"].as_str().expect("a reason");
    assert!(reason.starts_with("line 8: "), "{reason}");
    // A picture without an earlier version is drawn as far as possible.
    let wish_for_paths = json!({ "component": "lift", "owner": "move", "paths": true });
    let incomplete = draw(&mut client, &uri, wish_for_paths).await;
    assert!(incomplete["incomplete"].is_string(), "{incomplete}");

    let other = text().replace("pause::up, ether", "pause::up, start, ether");
    client.change(&uri, 3, json!([{ "text": other }])).await;
    let now = draw(&mut client, &uri, wish).await;
    assert_eq!(now["stale"], Value::Null);
    assert_ne!(now["picture"], good["picture"]);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn systems_and_locks() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let locks = draw(&mut client, &uri, json!({ "kind": "locks" })).await;
    assert!(ids(&locks).contains(&"ids.height"), "{locks}");
    let alone = draw(&mut client, &uri, json!({ "kind": "system" })).await;
    let unconnected = |answer: &Value| {
        let nodes = answer["nodes"].as_array().expect("nodes").clone();
        let is = |other: &Value| {
            let classes = other["classes"].as_array().expect("classes");
            classes.contains(&json!("unconnected"))
        };
        nodes.iter().any(is)
    };
    assert!(unconnected(&alone), "{alone}");
    client.finish().await;

    // dotgen.toml selects one of two writers.
    let writer = |name: &str| {
        format!(
            "struct height_s {{ double h; }};\n\
             component {name} {{ port out height_s p; }};\n"
        )
    };
    let files = [
        ("a.gen", &*writer("a")),
        ("b.gen", &*writer("b")),
        ("dotgen.toml", "[connections]\nlift.wanted = \"b.p\"\n"),
    ];
    let (mut client, _folder, uri) = start_beside(json!({}), &files).await;
    // The files of the workspace are being listed.
    let find = json!({ "query": "b" });
    let found = |json: Value| {
        json.as_array().is_some_and(|json| json.iter().any(|json| json["name"] == "b"))
    };
    while !found(client.ok("workspace/symbol", find.clone()).await) {}
    let system = draw(&mut client, &uri, json!({ "kind": "system" })).await;
    let edges = system["edges"].as_array().expect("edges");
    let into: Vec<&Value> = edges.iter().filter(|edge| edge["to"] == "lift").collect();
    assert_eq!(into.len(), 1, "{system}");
    assert_eq!(into[0]["from"], "b.p");
    assert!(!unconnected(&system));
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_editor_shows_the_bytes_of_the_command_line() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect(path);
    let names = [
        "maneuver.gen",
        "dotgen.toml",
        "idl/or/pose/pose_estimator.gen",
        "idl/or/pose/t3d.idl",
        "idl/or/time/time.idl",
    ];
    let texts: Vec<(&str, String)> =
        names.iter().map(|name| (*name, read(&format!("examples/maneuver/{name}")))).collect();
    let files: Vec<(&str, &str)> = texts.iter().map(|text| (text.0, text.1.as_str())).collect();
    let folder = Folder::new(&files);
    let mut client = Client::start(folder.params(pulling())).await;
    let uri = folder.uri("maneuver.gen");
    client.open(&uri, &texts[0].1).await;
    // The output of `dotgen diagram` is compared with the committed pictures in
    // `cli/tests/pictures.rs`.
    for (file, wish) in [
        ("goto.svg", json!({ "owner": "goto" })),
        ("exec.svg", json!({ "owner": "exec", "paths": true })),
        ("locks.svg", json!({ "kind": "locks" })),
    ] {
        let mut wish = wish;
        wish["theme"] = json!("auto");
        let answer = draw(&mut client, &uri, wish).await;
        let committed = read(&format!("docs/pictures/{file}"));
        assert!(answer["picture"] == committed.as_str(), "{file}");
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_as_text_for_editors_without_webviews() {
    let (mut client, _folder, uri) = start(json!({})).await;
    for (command, beginning) in [
        ("dotgen.diagram.mermaid", "flowchart TD\n"),
        ("dotgen.diagram.dot", "digraph \"lift.move\" {\n"),
    ] {
        let mut argument = document(&uri);
        argument["owner"] = json!("move");
        let params = json!({ "command": command, "arguments": [argument] });
        let text = client.ok("workspace/executeCommand", params).await;
        let text = text.as_str().expect("a text");
        assert!(text.starts_with(beginning), "{text}");
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_place_that_names_a_task_or_a_state_has_its_machine() {
    let (mut client, _folder, uri) = start(json!({})).await;
    for (at, way) in [("move {", json!([])), ("up>", json!(["up"])), ("raise(inout", Value::Null)] {
        let named = json!({ "position": position(at), "named": true });
        let drawn = draw(&mut client, &uri, named).await;
        assert_eq!(drawn["way"], way, "{at}");
        assert_eq!(drawn["owner"], if way.is_null() { Value::Null } else { json!("move") });
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_hover_over_a_codel_tells_what_it_is_in_its_language() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let mut params = document(&uri);
    params["position"] = position("raise(inout");
    let hover = client.ok("textDocument/hover", params).await;
    let text = hover["contents"]["value"].as_str().expect("Markdown");
    expect_test::expect![[r"
        ```genom
        codel<up> raise(inout height) wcet 2 ms yield pause::up, ether;
        ```

        * task `move`: called from `init`, `raise`, after a pause
        * at most 2 ms, 20 % of the period of 10 ms
        * excludes attribute `get` through `height` of the ids

        ```c
        genom_event raise(double *height, const genom_context self);
        ```"]]
    .assert_eq(text);
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_system_is_opened_and_moved() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let before = draw(&mut client, &uri, json!({ "kind": "system" })).await;
    assert_eq!(node(&before, "lift")["open"], false);
    assert_eq!(node(&before, "lift")["holds"], json!(["wanted", "move", "go", "get"]));
    let wish =
        json!({ "kind": "system", "opened": { "lift": true }, "moved": { "lift": [40, 300] } });
    let after = draw(&mut client, &uri, wish).await;
    let lift = node(&after, "lift");
    assert_eq!(lift["open"], true);
    let lines = lift["lines"].as_array().expect("lines");
    let task = lines.iter().position(|line| line == "task move · 10 ms");
    let place = &lift["parts"][task.expect("the task is listed")];
    assert_eq!(place["selectionRange"]["start"], position("move {"));
    // The port moved with its component: their distance is unchanged.
    let height = |json: &Value| json["height"].as_f64().expect("a number");
    assert!(height(&after) < height(&before) + 200.0, "{after}");
    let wish = json!({ "kind": "system", "moved": { "lift.wanted": [0, 300] } });
    let apart = draw(&mut client, &uri, wish).await;
    assert!(height(&apart) > height(&before) + 200.0, "{apart}");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_way_through_a_machine_is_told() {
    let (mut client, _folder, uri) = start(json!({})).await;
    let wish = json!({ "component": "lift", "owner": "move", "way": ["start", "up", "ether"] });
    let answer = draw(&mut client, &uri, wish).await;
    let notes = answer["notes"].as_array().expect("notes");
    assert_eq!(notes.last().expect("a note"), "start → up → ether: at most 3 ms of execution");
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_open_in_another_folder_belongs_to_the_system() {
    const OTHER: &str = "component other { version \"1\"; lang \"c\"; email \"a@b\"; };\n";
    let elsewhere = Folder::new(&[("other.gen", OTHER)]);
    let (mut client, _folder, uri) = start(json!({})).await;
    let there = elsewhere.uri("other.gen");
    client.open(&there, OTHER).await;
    for from in [&uri, &there] {
        let answer = draw(&mut client, from, json!({ "kind": "system" })).await;
        let found = ids(&answer);
        assert!(found.contains(&"lift") && found.contains(&"other"), "{found:?}");
    }
    client.finish().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_folders_of_a_workspace_are_one_system() {
    const TYPE: &str = "struct s { long x; };\n";
    let component = |name: &str, ports: &str| {
        format!("{TYPE}component {name} {{ version \"1\"; lang \"c\"; email \"a@b\"; {ports} }};\n")
    };
    let settings = "[connections]\nnav.goal = \"plan.path\"\n";
    let folder = Folder::new(&[
        ("rover/nav.gen", &component("nav", "port in s goal;")),
        ("rover/plan.gen", &component("plan", "port out s path; port out s goal;")),
        ("rover/dotgen.toml", settings),
        ("drone/nav.gen", &component("nav", "port in s goal; port out s pose;")),
        ("drone/log.gen", &component("log", "port in s pose;")),
    ]);
    let mut params = folder.params(pulling());
    let folders = ["rover", "drone"].map(|name| json!({ "uri": folder.uri(name), "name": name }));
    params["workspaceFolders"] = json!(folders);
    let mut client = Client::start(params).await;
    let uri = folder.uri("rover/plan.gen");
    client.open(&uri, &folder.read("rover/plan.gen")).await;
    // The files of the workspace are being listed.
    let mut answer = Value::Null;
    while answer["title"] != "System of 4 components" {
        answer = draw(&mut client, &uri, json!({ "kind": "system" })).await;
    }
    let edges = answer["edges"].as_array().expect("edges").iter();
    let mut reads: Vec<&str> = edges
        .filter_map(|edge| edge["description"].as_str().filter(|text| text.contains(" reads ")))
        .collect();
    reads.sort_unstable();
    assert_eq!(
        reads,
        [
            "log reads nav (drone).pose as pose",
            // Equal names connect across folders, the settings of a folder its own components.
            "nav (drone) reads plan.goal as goal",
            "nav (rover) reads plan.path as goal",
        ]
    );
    client.finish().await;
}

/// A node of an answer.
fn node<'a>(answer: &'a Value, id: &str) -> &'a Value {
    let mut nodes = answer["nodes"].as_array().expect("nodes").iter();
    nodes.find(|node| node["id"] == id).expect("a node")
}
