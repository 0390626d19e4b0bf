//! Fixes that make both sides agree.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn every_quick_fix_removes_what_it_is_offered_for() {
    let original = tank();
    let mut client = Client::start(original.params(capable())).await;
    let mut fixes: Vec<(String, Value)> = Vec::new();
    for name in FILES {
        let uri = original.uri(name);
        let pushed = client.pushed(&uri).await;
        for diagnostic in pushed["diagnostics"].as_array().expect("a list") {
            if !diagnostic["code"].as_str().unwrap_or_default().starts_with("codel/") {
                continue;
            }
            let finding = messages(&json!([diagnostic])).remove(0);
            let actions = client.actions(&uri, &diagnostic["range"], Some("quickfix")).await;
            let mut offered = 0;
            // The setting of a project has another check.
            for action in actions.iter().filter(|action| !title(action).starts_with("Allow")) {
                let about = action["diagnostics"].as_array().into_iter().flatten();
                if messages(&json!(about.collect::<Vec<_>>())).contains(&finding) {
                    offered += 1;
                    fixes.push((finding.clone(), action.clone()));
                }
            }
            assert!(offered > 0, "no fix for {finding} in {name}: {actions:#?}");
            // Only unambiguous fixes are preferred.
            let preferred = actions.iter().filter(|action| action["isPreferred"] == true);
            let preferred: Vec<&str> = preferred.map(title).collect();
            assert!(preferred.iter().all(|title| !title.starts_with("Remove")), "{preferred:?}");
            assert!(offered == 1 || preferred.len() < offered, "{finding}");
        }
    }
    client.finish().await;
    assert!(fixes.len() > 12, "{}", fixes.len());
    for (finding, action) in fixes {
        // The edit of one folder, applied to the files of another.
        let copy = tank();
        let moved = action.to_string().replace(&original.uri(""), &copy.uri(""));
        let action: Value = serde_json::from_str(&moved).expect("JSON");
        // Sources are changed at once; only the action that applies every fix is reviewed first.
        let edit = &action["edit"];
        let files = edit["documentChanges"].as_array().map_or(0, Vec::len);
        let shown = title(&action).starts_with("Fix all") && files > 1;
        let annotation = &edit["changeAnnotations"]["reviewed"];
        assert_eq!(annotation["needsConfirmation"] == true, shown, "{action:#}");
        write(&action["edit"]);
        let left = check(&path(&copy.uri("tank.gen")));
        assert!(!left.contains(&finding), "{} leaves {finding}", title(&action));
    }
}

/// The text that the client shows after a stub was written.
async fn shown_body(capabilities: Value) -> Option<String> {
    let folder = tank();
    let uri = folder.uri("tank.gen");
    let text = read(path(&uri));
    let mut client = Client::start(folder.params(capabilities)).await;
    let start = place(&text, "tank_drain_wait", 0);
    let range = json!({ "start": start, "end": start });
    let actions = client.actions(&uri, &range, Some("quickfix")).await;
    let stub = actions
        .iter()
        .find(|action| title(action).starts_with("Write a stub of"))
        .unwrap_or_else(|| panic!("{actions:#?}"));
    client.ignore("textDocument/publishDiagnostics");
    drop(client);
    let files = applied(&stub["edit"], on_disk);
    let command = stub.get("command")?;
    assert_eq!(command["command"], "dotgen.showCodel");
    let place = &command["arguments"][0];
    let text = &files[place["uri"].as_str().expect("a URI")];
    let lines = Lines::new(text.as_str().into(), Encoding::Utf16);
    let range = serde_json::from_value(place["range"].clone()).expect("a range");
    let range = lines.bytes(range).expect("a range of the text");
    let function = text[..range.start].rfind("tank_drain_wait(");
    assert!(function.is_some_and(|function| !text[function..range.start].contains('}')));
    Some(text[range].to_owned())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_new_stub_is_shown_where_its_code_goes() {
    assert_eq!(shown_body(capable()).await, None, "the client shows no documents");
    let mut able = capable();
    able["window"] = json!({ "showDocument": { "support": true } });
    let body = shown_body(able).await;
    assert_eq!(body.as_deref(), Some("/* skeleton sample: insert your code */"));
}

/// Applies the action for every fix, and checks the remaining findings.
async fn fix_all(only: Option<&str>, ranges: &Value) {
    let folder = tank();
    let uri = folder.uri("tank.gen");
    let mut client = Client::start(folder.params(capable())).await;
    client.open(&uri, &on_disk(&uri).expect("it is there")).await;
    let actions = client.actions(&uri, ranges, only).await;
    let all: Vec<_> = actions
        .iter()
        .filter(|action| title(action) == "Fix all differences between specification and codels")
        .collect();
    assert_eq!(all.len(), 1, "{actions:#?}");
    write(&all[0]["edit"]);
    client.ignore("textDocument/publishDiagnostics");
    let specification = path(&uri);
    // A yield that the code does not use may be intended: it is removed only on request.
    let left = check(&specification);
    assert!(left.len() == 1 && left[0].starts_with("codel/never-yielded: "), "{left:?}");

    // The result compiles, with the headers that the server makes for clangd.
    client.change(&uri, 2, json!([{ "text": on_disk(&uri).expect("it is there") }])).await;
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
            // A new parameter is not used yet.
            .args(["-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter"])
            .args(flags.lines())
            .arg(directory.join(source))
            .output();
        let Ok(output) = output else {
            dotgen_loaders::skip("no `cc` on this system");
            return;
        };
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{source}: {errors}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn fix_all_leaves_only_what_somebody_meant_and_the_code_compiles() {
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
    assert!(!actions.iter().any(|action| action.to_string().contains("_codels.c")), "{actions:#?}");
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
            .find(|action| title(action) == "Write the 13 missing stubs of component `tank`")
            .unwrap_or_else(|| panic!("{actions:#?}"));
        let files = applied(&stubs["edit"], on_disk);
        let names: Vec<_> =
            files.keys().map(|key| key.rsplit('/').next().unwrap_or_default()).collect();
        assert_eq!(names, ["tank_codels.c", "tank_control_codels.c"]);
        std::fs::create_dir_all(path(&folder.uri("codels"))).expect("a folder");
        write(&stubs["edit"]);
        assert_eq!(check(&path(&uri)), Vec::<String>::new());
        client.ignore("textDocument/publishDiagnostics");
        drop(client);
    }
}

const LAMP: &str = "component lamp {
  version \"1\";
  lang \"c\";
  ids { double wanted, light; };
  task main {
    period 10 ms;
    codel<start> lamp_start(out light) yield main wcet 1 ms;
    codel<main, dim> lamp_main(in wanted, inout light)
      yield pause::main, dim wcet 1 ms;
    codel<stop> lamp_stop(in light) yield ether wcet 1 ms;
  };
};
";

/// Codels of which each returns one of its events.
const LAMP_CODELS: &str = "#include \"aclamp.h\"
#include \"lamp_c_types.h\"

/** Codel lamp_start of task main.
 *
 * Triggered by lamp_start.
 * Yields to lamp_main.
 */
genom_event
lamp_start(double *light, const genom_context self)
{
  *light = 0.;
  return lamp_main;
}

/** Codel lamp_main of task main.
 *
 * Triggered by lamp_main, lamp_dim.
 * Yields to lamp_pause_main, lamp_dim.
 */
genom_event
lamp_main(double wanted, double *light, const genom_context self)
{
  if (*light > wanted) return lamp_dim;
  return lamp_pause_main;
}

/** Codel lamp_stop of task main.
 *
 * Triggered by lamp_stop.
 * Yields to lamp_ether.
 */
genom_event
lamp_stop(double light, const genom_context self)
{
  return lamp_ether;
}
";

fn lamp() -> Folder {
    Folder::new(&[("lamp.gen", LAMP), ("codels/lamp_main_codels.c", LAMP_CODELS)])
}

#[tokio::test(flavor = "multi_thread")]
async fn a_state_is_split_on_both_sides() {
    let original = lamp();
    let uri = original.uri("lamp.gen");
    let before = check(&path(&uri));
    let mut client = Client::start(original.params(capable())).await;
    client.pushed(&uri).await;
    let mut split = Vec::new();
    for (offset, _) in LAMP.match_indices("codel<") {
        let start = place_at(LAMP, offset + "codel<".len());
        let range = json!({ "start": start, "end": start });
        let actions = client.actions(&uri, &range, Some("refactor")).await;
        let found = actions.into_iter().filter(|action| title(action).starts_with("Split state"));
        split.extend(found);
    }
    client.finish().await;
    assert_eq!(split.len(), 3);
    for action in split {
        let copy = lamp();
        let moved = action.to_string().replace(&original.uri(""), &copy.uri(""));
        let action: Value = serde_json::from_str(&moved).expect("JSON");
        let title = title(&action);
        assert!(title.ends_with(", and change the codels"), "{action:#}");
        write(&action["edit"]);
        assert_eq!(check(&path(&copy.uri("lamp.gen"))), before, "{title}");
        let code = read(path(&copy.uri("codels/lamp_main_codels.c")));
        assert!(code.contains("_first("), "{code}");
    }
}
