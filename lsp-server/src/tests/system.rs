//! The effects of one component on the others of a workspace.

use serde_json::json;

use super::client::{Client, Folder, document, pulling};

const POM: &str = "struct s { long x; };\ncomponent pom {\n  version \"1\"; lang \"c\"; email \"a@b\";\n  port out s pose;\n  task t { period 5 ms; codel<start> pom_t(out pose) yield pause::start; };\n};\n";

/// A reader with `codels` codels that use the port.
fn reader(name: &str, port: &str, codels: usize) -> String {
    let functions: String = (0..codels)
        .map(|codel| {
            format!("  function f{codel}() {{ codel {name}_f{codel}(in {port}, out x); }};\n")
        })
        .collect();
    format!(
        "struct s {{ long x; }};\ncomponent {name} {{\n  version \"1\"; lang \"c\"; email \"a@b\";\n  port in s {port};\n  ids {{ s x; }};\n{functions}}};\n"
    )
}

async fn hover(client: &mut Client, uri: &str) -> Vec<String> {
    let mut params = document(uri);
    params["position"] = json!({ "line": 4, "character": 40 });
    let hover = client.ok("textDocument/hover", params).await;
    let text = hover["contents"]["value"].as_str().expect("Markdown");
    assert!(text.contains("pom_t("), "{text}");
    let facts = text.lines().filter(|line| line.contains("other components"));
    facts.map(str::to_owned).collect()
}

async fn lens(client: &mut Client, uri: &str) -> String {
    let lenses = client.ok("textDocument/codeLens", document(uri)).await;
    lenses[0]["command"]["title"].as_str().expect("a title").to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_codel_says_what_it_excludes_through_ports() {
    let source = "genom_event pom_t(const pom_pose *pose, const genom_context self)\n{\n  return pom_pause_start;\n}\n";
    let folder = Folder::new(&[
        ("pom.gen", POM),
        ("nav.gen", &reader("nav", "pose", 1)),
        ("log.gen", &reader("log", "position", 7)),
        ("codels/pom_t_codels.c", source),
    ]);
    let mut client = Client::start(folder.params(pulling())).await;
    let (uri, code) = (folder.uri("pom.gen"), folder.uri("codels/pom_t_codels.c"));
    client.open(&uri, POM).await;
    let file = json!({ "uri": code, "languageId": "c", "version": 1, "text": source });
    client.notify("textDocument/didOpen", json!({ "textDocument": file })).await;
    // The files of the workspace are being listed.
    while hover(&mut client, &uri).await.is_empty() {}
    assert_eq!(
        hover(&mut client, &uri).await,
        ["* excludes in other components `log_f0` of function `f0` of `log` (port `pom.pose`), \
          `log_f1` of function `f1` of `log` (port `pom.pose`), \
          `log_f2` of function `f2` of `log` (port `pom.pose`), \
          `log_f3` of function `f3` of `log` (port `pom.pose`), \
          `log_f4` of function `f4` of `log` (port `pom.pose`), \
          `log_f5` of function `f5` of `log` (port `pom.pose`) and 2 more"]
    );
    assert_eq!(
        lens(&mut client, &code).await,
        "task t: start → pause::start · excludes elsewhere log.log_f0 through pom.pose, \
         log.log_f1 through pom.pose, log.log_f2 through pom.pose and 5 more"
    );

    // An edit of another component has an effect at once.
    let other = folder.uri("log.gen");
    client.open(&other, &reader("log", "position", 0)).await;
    let nav = "`nav_f0` of function `f0` of `nav` (port `pom.pose`)";
    assert_eq!(hover(&mut client, &uri).await, [format!("* excludes in other components {nav}")]);

    // So do connections in the configuration.
    folder.write("dotgen.toml", "[connections]\nnav.pose = \"gps.pose\"\n");
    folder.write("gps.gen", &POM.replace("pom", "gps"));
    for name in ["dotgen.toml", "gps.gen"] {
        client.notify("workspace/didChangeWatchedFiles", folder.event(name, 1)).await;
    }
    assert_eq!(hover(&mut client, &uri).await, [""; 0]);
    assert_eq!(lens(&mut client, &code).await, "task t: start → pause::start");
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
}
