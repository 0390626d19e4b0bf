//! A recorded editing session, driven over the protocol as an editor does it: open, type 500 characters, and ask
//! after each what an editor asks.

#[path = "../../../analysis/benches/components.rs"]
mod components;

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

const COMPONENTS: usize = 100;
/// What is typed, a character at a time, in the middle of a component; half-typed most of the time, and read
/// without error in the end.
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

/// Plays the session against a server and prints what each request took.
pub(super) fn session(dotgen: &Path) -> Result<()> {
    let folder = std::env::temp_dir().join(format!("dotgen-session-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("types.idl"), components::TYPES)?;
    for i in 0..COMPONENTS {
        std::fs::write(folder.join(format!("c{i}.gen")), components::component(i))?;
    }
    let played = Editor::start(dotgen, &folder).and_then(play);
    std::fs::remove_dir_all(&folder).ok();
    played
}

fn play(mut editor: Editor) -> Result<()> {
    let mut times: Vec<(&str, Vec<Duration>)> = [
        "diagnostics",
        "completion",
        "hover",
        "definition",
        "semantic tokens",
        "rename",
    ]
    .map(|it| (it, Vec::new()))
    .into();
    let text = components::component(50);
    let line = text
        .lines()
        .position(|it| it.contains("attribute set_goal"))
        .context("the component has an attribute")?;
    editor.open(&text)?;
    let document = json!({ "uri": editor.uri });
    // The first answers wait for the workspace to be read.
    editor.request(
        "textDocument/diagnostic",
        json!({ "textDocument": document }),
    )?;
    let (mut at_line, mut at_character) = (line + 1, 0);
    editor.insert(at_line, at_character, "\n")?;
    for c in TYPED.chars() {
        editor.insert(at_line, at_character, &c.to_string())?;
        if c == '\n' {
            (at_line, at_character) = (at_line + 1, 0);
        } else {
            at_character += 1;
        }
        let here = json!({ "textDocument": document, "position": { "line": at_line, "character": at_character } });
        // The name in the attribute above, which does not move.
        let name =
            json!({ "textDocument": document, "position": { "line": line, "character": 25 } });
        let asked = [
            (
                "textDocument/diagnostic",
                json!({ "textDocument": document }),
            ),
            ("textDocument/completion", here),
            ("textDocument/hover", name.clone()),
            ("textDocument/definition", name),
            (
                "textDocument/semanticTokens/full",
                json!({ "textDocument": document }),
            ),
        ];
        for ((method, params), (_, times)) in std::iter::zip(asked, &mut times) {
            times.push(editor.request(method, params)?);
        }
    }
    // Not after each character: a half-typed text refuses it.
    for round in 0..50 {
        let position = json!({ "line": line, "character": 25 });
        let params = json!({ "textDocument": document, "position": position, "newName": format!("goal{round}") });
        let time = editor.request("textDocument/rename", params)?;
        times[5].1.push(time);
    }
    editor.end()?;
    println!(
        "{:<18} {:>9} {:>9} {:>9}  requests",
        "request", "p50", "p95", "p99"
    );
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

/// The least of an editor.
struct Editor {
    server: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    uri: String,
    version: i32,
    next_id: i64,
}

impl Editor {
    fn start(dotgen: &Path, folder: &Path) -> Result<Editor> {
        let mut server = Command::new(dotgen)
            .arg("lsp")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .context("cannot run dotgen lsp")?;
        let input = server.stdin.take().context("the server has an input")?;
        let output = server.stdout.take().context("the server has an output")?;
        let root = format!("file://{}", folder.display());
        let mut editor = Editor {
            server,
            input,
            output: BufReader::new(output),
            uri: format!("{root}/c50.gen"),
            version: 1,
            next_id: 0,
        };
        let capabilities =
            json!({ "textDocument": { "diagnostic": {}, "completion": {}, "hover": {} } });
        let params = json!({ "processId": null, "rootUri": root, "capabilities": capabilities,
            "workspaceFolders": [{ "uri": root, "name": "session" }] });
        editor.request("initialize", params)?;
        editor.send(json!({ "method": "initialized", "params": {} }))?;
        Ok(editor)
    }

    fn open(&mut self, text: &str) -> Result<()> {
        let document =
            json!({ "uri": self.uri, "languageId": "genom3", "version": 1, "text": text });
        self.send(
            json!({ "method": "textDocument/didOpen", "params": { "textDocument": document } }),
        )
    }

    fn insert(&mut self, line: usize, character: usize, text: &str) -> Result<()> {
        self.version += 1;
        let position = json!({ "line": line, "character": character });
        let change = json!({ "range": { "start": position, "end": position }, "text": text });
        let document = json!({ "uri": self.uri, "version": self.version });
        let params = json!({ "textDocument": document, "contentChanges": [change] });
        self.send(json!({ "method": "textDocument/didChange", "params": params }))
    }

    fn send(&mut self, mut message: Value) -> Result<()> {
        message["jsonrpc"] = "2.0".into();
        let text = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        Ok(self.input.flush()?)
    }

    /// Time from sending a request to its answer.
    fn request(&mut self, method: &str, params: Value) -> Result<Duration> {
        self.next_id += 1;
        let id = self.next_id;
        let started = Instant::now();
        self.send(json!({ "id": id, "method": method, "params": params }))?;
        loop {
            let message = self.receive()?;
            if message["method"].is_string() {
                // Questions of the server: none is needed here.
                if !message["id"].is_null() {
                    self.send(json!({ "id": message["id"], "result": null }))?;
                }
            } else if message["id"] == id {
                let time = started.elapsed();
                if !message["error"].is_null() {
                    bail!("{method}: {}", message["error"]);
                }
                return Ok(time);
            }
        }
    }

    fn receive(&mut self) -> Result<Value> {
        let mut length = 0;
        loop {
            let mut line = String::new();
            if self.output.read_line(&mut line)? == 0 {
                bail!("the server has ended");
            }
            match line.trim_end().strip_prefix("Content-Length: ") {
                Some(number) => length = number.parse()?,
                None if line.trim_end().is_empty() => break,
                None => {}
            }
        }
        let mut text = vec![0; length];
        self.output.read_exact(&mut text)?;
        Ok(serde_json::from_slice(&text)?)
    }

    fn end(mut self) -> Result<()> {
        self.request("shutdown", Value::Null)?;
        self.send(json!({ "method": "exit" }))?;
        self.server.wait()?;
        Ok(())
    }
}
