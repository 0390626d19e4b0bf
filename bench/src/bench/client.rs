//! A minimal editor: a server as a child process, and messages with the times of their arrival.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

/// Timeout, longer than any measured operation.
const REPLY_TIMEOUT: Duration = Duration::from_secs(600);

/// A message of the server.
pub(crate) struct Message {
    /// The time at which it had completely arrived.
    pub(crate) at: Instant,
    pub(crate) content: Value,
}

/// A document of the editor.
pub(crate) struct Document {
    pub(crate) uri: String,
    version: i32,
}

/// The connection to a server.
pub(crate) struct Editor {
    server: Child,
    /// `None`: closed.
    input: Option<ChildStdin>,
    messages: Receiver<Message>,
    next_id: i64,
    /// URI of the folder.
    pub(crate) root: String,
}

impl Editor {
    /// Starts a server over a folder and initializes it.
    pub(crate) fn start(dotgen: &Path, folder: &Path, capabilities: Value) -> Result<Editor> {
        let mut command = Command::new(dotgen);
        Editor::run(command.arg("lsp"), folder, capabilities)
    }

    /// As [`Editor::start`], with the command that runs the server.
    pub(crate) fn run(command: &mut Command, folder: &Path, capabilities: Value) -> Result<Editor> {
        let mut server = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .context("cannot run dotgen lsp")?;
        let input = server.stdin.take().context("the server has an input")?;
        let output = server.stdout.take().context("the server has an output")?;
        let (sender, messages) = channel();
        // The thread ends with the output of the server.
        std::thread::spawn(move || receive(BufReader::new(output), &sender));
        let root = format!("file://{}", folder.display());
        let mut editor = Editor { server, input: Some(input), messages, next_id: 0, root };
        let folders = json!([{ "uri": editor.root, "name": "measured" }]);
        let params = json!({ "processId": null, "rootUri": editor.root, "capabilities": capabilities,
            "workspaceFolders": folders, "initializationOptions": { "pullSources": true } });
        editor.request("initialize", params)?;
        editor.notify("initialized", json!({}))?;
        Ok(editor)
    }

    /// Process id of the server.
    pub(crate) fn pid(&self) -> u32 {
        self.server.id()
    }

    /// Memory of the server, in MB, by the name of the line in the status of its process.
    pub(crate) fn memory(&self, key: &str) -> Result<f64> {
        let text = std::fs::read_to_string(format!("/proc/{}/status", self.pid()))?;
        let line = text.lines().find_map(|line| line.strip_prefix(key));
        let number = line.and_then(|line| line.split_whitespace().nth(1));
        let kilobytes: f64 = number.context("no such line")?.parse()?;
        Ok(kilobytes / 1024.0)
    }

    /// Opens a file of the folder.
    pub(crate) fn open(&mut self, name: &str, text: &str) -> Result<Document> {
        let uri = format!("{}/{name}", self.root);
        let language = match name.rsplit_once('.') {
            Some((_, "c" | "h")) => "c",
            Some((_, "cc" | "cpp" | "cxx" | "hh" | "hpp")) => "cpp",
            _ => "genom3",
        };
        let document = json!({ "uri": uri, "languageId": language, "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }))?;
        Ok(Document { uri, version: 1 })
    }

    /// Closes a document.
    pub(crate) fn close(&mut self, document: &Document) -> Result<()> {
        let params = json!({ "textDocument": { "uri": document.uri } });
        self.notify("textDocument/didClose", params)
    }

    pub(crate) fn remove_line(&mut self, document: &mut Document, line: usize) -> Result<()> {
        self.replace(document, [(line, 0), (line + 1, 0)], "")
    }

    /// Replaces the characters from one column of a line to another.
    pub(crate) fn edit(
        &mut self,
        document: &mut Document,
        line: usize,
        columns: [usize; 2],
        text: &str,
    ) -> Result<()> {
        self.replace(document, columns.map(|column| (line, column)), text)
    }

    /// Replaces the text between two places, each a line and a column.
    fn replace(
        &mut self,
        document: &mut Document,
        places: [(usize, usize); 2],
        text: &str,
    ) -> Result<()> {
        document.version += 1;
        let [start, end] = places.map(|place| json!({ "line": place.0, "character": place.1 }));
        let change = json!({ "range": { "start": start, "end": end }, "text": text });
        let document = json!({ "uri": document.uri, "version": document.version });
        let params = json!({ "textDocument": document, "contentChanges": [change] });
        self.notify("textDocument/didChange", params)
    }

    /// Sends a notification.
    pub(crate) fn notify(&mut self, method: &str, params: Value) -> Result<()> {
        self.send(json!({ "method": method, "params": params }))
    }

    fn send(&mut self, mut message: Value) -> Result<()> {
        message["jsonrpc"] = "2.0".into();
        let text = message.to_string();
        let input = self.input.as_mut().context("the input is closed")?;
        write!(input, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        Ok(input.flush()?)
    }

    /// Sends a request and returns its number.
    pub(crate) fn ask(&mut self, method: &str, params: Value) -> Result<i64> {
        self.next_id += 1;
        let id = self.next_id;
        self.send(json!({ "id": id, "method": method, "params": params }))?;
        Ok(id)
    }

    /// Time from sending a request to its answer, and the answer.
    pub(crate) fn answer(&mut self, method: &str, params: Value) -> Result<(Duration, Value)> {
        let started = Instant::now();
        let id = self.ask(method, params)?;
        loop {
            let message = self.next()?;
            if message.content["id"] == id {
                return Ok((message.at - started, result(method, message.content)?));
            }
        }
    }

    /// Time from sending a request to its answer.
    pub(crate) fn request(&mut self, method: &str, params: Value) -> Result<Duration> {
        Ok(self.answer(method, params)?.0)
    }

    /// The next message that is not a request of the server; those are answered with `null`.
    pub(crate) fn next(&mut self) -> Result<Message> {
        self.next_within(REPLY_TIMEOUT)?.context("the server says nothing any more")
    }

    /// As [`Editor::next`]; `None` if no message arrives for the duration.
    pub(crate) fn next_within(&mut self, quiet: Duration) -> Result<Option<Message>> {
        loop {
            let message = match self.messages.recv_timeout(quiet) {
                Ok(message) => message,
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => bail!("the server has ended"),
            };
            if message.content["method"].is_string() && !message.content["id"].is_null() {
                self.send(json!({ "id": message.content["id"], "result": null }))?;
                continue;
            }
            return Ok(Some(message));
        }
    }

    /// Ends the server.
    pub(crate) fn end(mut self) -> Result<()> {
        self.request("shutdown", Value::Null)?;
        self.send(json!({ "method": "exit" }))?;
        self.input = None;
        self.server.wait()?;
        Ok(())
    }
}

/// The result of a request.
pub(crate) fn result(method: &str, mut answer: Value) -> Result<Value> {
    if !answer["error"].is_null() {
        bail!("{method}: {}", answer["error"]);
    }
    Ok(answer["result"].take())
}

/// Reads messages to the end of the output.
fn receive(mut output: impl BufRead, sender: &Sender<Message>) -> Result<()> {
    loop {
        let mut length = 0;
        loop {
            let mut line = String::new();
            if output.read_line(&mut line)? == 0 {
                return Ok(());
            }
            match line.trim_end().strip_prefix("Content-Length: ") {
                Some(number) => length = number.parse()?,
                None if line.trim_end().is_empty() => break,
                None => {}
            }
        }
        let mut text = vec![0; length];
        output.read_exact(&mut text)?;
        let at = Instant::now();
        let content = serde_json::from_slice(&text)?;
        sender.send(Message { at, content })?;
    }
}
