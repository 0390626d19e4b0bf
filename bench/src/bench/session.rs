//! A recorded editing session over the protocol, in the form of an editor: open, type 500 characters, and
//! send an editor's requests after each.

#[path = "../../../analysis/benches/components.rs"]
mod components;

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result};
use serde_json::json;

use super::client::Editor;

const COMPONENTS: usize = 100;
/// The typed text, a character at a time, in the middle of a component. It is incomplete most of the time,
/// and valid in the end.
const TYPED: &str = "
  /** Typed while the clock runs. */
  activity typed(
    in geo::vec to,
    in double speed = 0.5 : \"in m/s\")
  {
    doc \"Goes somewhere else, by way of a point.\";
    task slow;
    throws geo::lost;
    local geo::vec tmp;
    validate c50_check_typed(in to, in speed);
    codel<start> c50_typed_begin(in to, local out tmp, ids out goal.at)
      yield step, ether;
    codel<step> c50_typed_step(in tmp, in speed, ids in current.at)
      yield pause::step, ether;
    codel<stop> c50_typed_stop(ids out goal.at)
      yield ether;
    interrupts typed;
  };
";

/// Runs the session against a server and prints the duration of each request.
pub(super) fn session(dotgen: &Path) -> Result<()> {
    let folder = std::env::temp_dir().join(format!("dotgen-session-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("types.idl"), components::TYPES)?;
    for i in 0..COMPONENTS {
        std::fs::write(folder.join(format!("c{i}.gen")), components::component(i))?;
    }
    let capabilities =
        json!({ "textDocument": { "diagnostic": {}, "completion": {}, "hover": {} } });
    let played = Editor::start(dotgen, &folder, capabilities).and_then(play);
    std::fs::remove_dir_all(&folder).ok();
    played
}

fn play(mut editor: Editor) -> Result<()> {
    let mut times: Vec<(&str, Vec<Duration>)> =
        ["diagnostics", "completion", "hover", "definition", "semantic tokens", "rename"]
            .map(|text| (text, Vec::new()))
            .into();
    let text = components::component(50);
    let line = text
        .lines()
        .position(|line| line.contains("attribute set_goal"))
        .context("the component has an attribute")?;
    let mut opened = editor.open("c50.gen", &text)?;
    let document = json!({ "uri": opened.uri });
    // The first answers wait until the workspace is read.
    editor.request("textDocument/diagnostic", json!({ "textDocument": document }))?;
    let (mut at_line, mut at_character) = (line + 1, 0);
    let here = |character| [character, character];
    editor.edit(&mut opened, at_line, here(at_character), "\n")?;
    for c in TYPED.chars() {
        editor.edit(&mut opened, at_line, here(at_character), &c.to_string())?;
        if c == '\n' {
            (at_line, at_character) = (at_line + 1, 0);
        } else {
            at_character += 1;
        }
        let at = json!({ "textDocument": document, "position": { "line": at_line, "character": at_character } });
        // The name in the attribute above, which does not move.
        let name =
            json!({ "textDocument": document, "position": { "line": line, "character": 25 } });
        let asked = [
            ("textDocument/diagnostic", json!({ "textDocument": document })),
            ("textDocument/completion", at),
            ("textDocument/hover", name.clone()),
            ("textDocument/definition", name),
            ("textDocument/semanticTokens/full", json!({ "textDocument": document })),
        ];
        for ((method, params), (_, times)) in std::iter::zip(asked, &mut times) {
            times.push(editor.request(method, params)?);
        }
    }
    // Not after each character: the server refuses it for incomplete text.
    for round in 0..50 {
        let position = json!({ "line": line, "character": 25 });
        let params = json!({ "textDocument": document, "position": position, "newName": format!("goal{round}") });
        let time = editor.request("textDocument/rename", params)?;
        times[5].1.push(time);
    }
    editor.end()?;
    println!("{:<18} {:>9} {:>9} {:>9}  requests", "request", "p50", "p95", "p99");
    for (name, times) in &mut times {
        times.sort_unstable();
        let at = |percent: usize| super::milliseconds(times[(times.len() - 1) * percent / 100]);
        println!(
            "{name:<18} {:>6.2} ms {:>6.2} ms {:>6.2} ms  {}",
            at(50),
            at(95),
            at(99),
            times.len()
        );
    }
    Ok(())
}
