//! Lenses that run components and scenarios.

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const LAMP: &str = "module colours { enum hue { RED }; };\n\ncomponent lamp {\n  version \"1\"; lang \"c\"; email \"a@b\";\n};\ncomponent bell {\n  version \"1\"; lang \"c\"; email \"a@b\";\n};\n";
const SCENARIO: &str = "scenario both {\n  use \"lamp.gen\";\n};\n";

/// `LINE TITLE COMMAND` of the lenses with run commands.
async fn lenses(client: &mut Client, uri: &str) -> Vec<String> {
    let lenses = client.ok("textDocument/codeLens", document(uri)).await;
    let runs = |other: &Value| {
        let command = other["command"]["command"].as_str()?;
        let argument = &other["command"]["arguments"][0];
        matches!(command, "dotgen.run" | "dotgen.simulate").then(|| {
            assert_eq!(argument, &json!({ "uri": uri }));
            let line = &other["range"]["start"]["line"];
            format!("{line} {} {command}", other["command"]["title"].as_str().expect("a title"))
        })
    };
    lenses.as_array().into_iter().flatten().filter_map(runs).collect()
}

/// The lenses over a specification and over a scenario.
async fn offered(options: Value, config: &str) -> [Vec<String>; 2] {
    let folder =
        Folder::new(&[("lamp.gen", LAMP), ("both.scn", SCENARIO), ("dotgen.toml", config)]);
    let mut params = folder.params(pulling());
    params["initializationOptions"] = options;
    let mut client = Client::start(params).await;
    let (lamp, both) = (folder.uri("lamp.gen"), folder.uri("both.scn"));
    client.open(&lamp, LAMP).await;
    client.open(&both, SCENARIO).await;
    [lenses(&mut client, &lamp).await, lenses(&mut client, &both).await]
}

#[tokio::test(flavor = "multi_thread")]
async fn components_and_scenarios_are_run_where_they_are_named() {
    let [components, scenario] = offered(json!({ "runs": true }), "").await;
    assert_eq!(
        components,
        [
            "2 Simulate dotgen.simulate",
            "2 Run dotgen.run",
            "5 Simulate dotgen.simulate",
            "5 Run dotgen.run",
        ]
    );
    assert_eq!(scenario, ["0 Simulate dotgen.simulate", "0 Run dotgen.run"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_run_where_the_client_cannot_or_nobody_wants_it() {
    let none: [Vec<String>; 2] = Default::default();
    assert_eq!(offered(json!({}), "").await, none);
    let off = "code-lens-runs = false\n";
    assert_eq!(offered(json!({ "runs": true }), off).await, none);
}
