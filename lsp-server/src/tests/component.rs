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
        (
            "arm/arm.gen",
            "component arm { version \"1\"; lang \"c\"; };\n",
        ),
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
        .map(|it| {
            let uri = it["uri"].as_str().expect("a URI");
            uri.trim_start_matches(&folder.uri("")).to_owned()
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
    let refused = client
        .request("dotgen/newComponent", params.clone())
        .await
        .expect_err("it is there");
    let message = refused["message"].as_str().unwrap_or_default();
    assert!(message.contains("arm.gen is there already"), "{message}");
    params["name"] = json!("task");
    let refused = client.request("dotgen/newComponent", params).await;
    let refused: Value = refused.expect_err("it is a word of the language");
    assert_eq!(refused["code"], -32803, "{refused}");
    client.finish().await;
}
