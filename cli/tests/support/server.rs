//! The built program as a server, over its standard input and output.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};

/// A running server and the pipes to it.
pub(crate) struct Server {
    pub(crate) child: Child,
    pub(crate) to: Option<ChildStdin>,
    pub(crate) from: BufReader<ChildStdout>,
}

impl Server {
    /// Initialized, by a client that can do nothing.
    pub(crate) fn start() -> Server {
        Server::start_with(json!({ "capabilities": {} }), &[])
    }

    /// Initialized with parameters.
    pub(crate) fn start_with(params: Value, environment: &[(&str, &std::path::Path)]) -> Server {
        let mut server = Server::raw(environment);
        server.send(json!({ "id": 0, "method": "initialize", "params": params }));
        let answer = server.receive(|message| message["id"] == 0);
        assert_eq!(answer["result"]["serverInfo"]["name"], "dotgen");
        server.send(json!({ "method": "initialized", "params": {} }));
        server
    }

    /// A server that nothing was said to yet.
    pub(crate) fn raw(environment: &[(&str, &std::path::Path)]) -> Server {
        Server::with_log(environment, Stdio::null())
    }

    /// As [`Server::raw`], with a log that is a pipe without reader.
    pub(crate) fn unread() -> Server {
        Server::with_log(&[], Stdio::piped())
    }

    fn with_log(environment: &[(&str, &std::path::Path)], log: Stdio) -> Server {
        let mut child = Command::new(env!("CARGO_BIN_EXE_dotgen"))
            .args(["lsp", "--stdio"])
            .envs(environment.iter().copied())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()
            .expect("the program runs");
        let to = child.stdin.take();
        let from = BufReader::new(child.stdout.take().expect("a pipe"));
        Server { child, to, from }
    }

    /// Sends bytes as they are.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        let to = self.to.as_mut().expect("the pipe is open");
        to.write_all(bytes).expect("the server reads");
        to.flush().expect("the server reads");
    }

    /// Asks something; the answer.
    pub(crate) fn request(&mut self, id: i64, method: &str, params: Value) -> Value {
        self.send(json!({ "id": id, "method": method, "params": params }));
        self.receive(|message| message["id"] == id && message.get("method").is_none())
    }

    /// Ends as the protocol wants it.
    pub(crate) fn end(mut self) {
        self.request(-1, "shutdown", Value::Null);
        self.send(json!({ "method": "exit" }));
        assert_eq!(self.child.wait().expect("it ends").code(), Some(0));
    }

    pub(crate) fn send(&mut self, mut message: Value) {
        message["jsonrpc"] = json!("2.0");
        let text = message.to_string();
        let to = self.to.as_mut().expect("the pipe is open");
        write!(to, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("the server reads");
        to.flush().expect("the server reads");
    }

    /// The next message of some kind; others are skipped.
    pub(crate) fn receive(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        loop {
            let mut length = 0;
            loop {
                let mut line = String::new();
                let read = self.from.read_line(&mut line).expect("UTF-8 headers");
                assert_ne!(read, 0, "the server goes on");
                match line.trim_end().strip_prefix("Content-Length: ") {
                    Some(value) => length = value.parse().expect("a number"),
                    None if line.trim_end().is_empty() => break,
                    None => {}
                }
            }
            let mut body = vec![0; length];
            self.from.read_exact(&mut body).expect("a whole message");
            let message = serde_json::from_slice(&body).expect("JSON and nothing else");
            if wanted(&message) {
                return message;
            }
        }
    }

    pub(crate) fn open(&mut self, text: &str) {
        let document = json!({ "uri": "file:///nowhere/arm.gen", "languageId": "gen",
                               "version": 1, "text": text });
        let params = json!({ "textDocument": document });
        self.send(json!({ "method": "textDocument/didOpen", "params": params }));
    }

    pub(crate) fn diagnostics(&mut self) -> Value {
        let message =
            self.receive(|message| message["method"] == "textDocument/publishDiagnostics");
        message["params"]["diagnostics"].clone()
    }
}
