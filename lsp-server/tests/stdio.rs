//! `dotgen lsp`, the built program, over its standard input and output.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};

struct Server {
    child: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
}

impl Server {
    fn start() -> Server {
        Server::start_with(json!({ "capabilities": {} }), &[])
    }

    fn start_with(params: Value, environment: &[(&str, &std::path::Path)]) -> Server {
        let mut child = Command::new(env!("CARGO_BIN_EXE_dotgen"))
            .args(["lsp", "--stdio"])
            .envs(environment.iter().copied())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program runs");
        let to = child.stdin.take();
        let from = BufReader::new(child.stdout.take().expect("a pipe"));
        let mut server = Server { child, to, from };
        server.send(json!({ "id": 0, "method": "initialize", "params": params }));
        let answer = server.receive(|it| it["id"] == 0);
        assert_eq!(answer["result"]["serverInfo"]["name"], "dotgen");
        server.send(json!({ "method": "initialized", "params": {} }));
        server
    }

    fn send(&mut self, mut message: Value) {
        message["jsonrpc"] = json!("2.0");
        let text = message.to_string();
        let to = self.to.as_mut().expect("the pipe is open");
        write!(to, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("the server reads");
        to.flush().expect("the server reads");
    }

    /// The next message of some kind; others are skipped.
    fn receive(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
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

    fn open(&mut self, text: &str) {
        let document = json!({ "uri": "file:///nowhere/arm.gen", "languageId": "gen",
                               "version": 1, "text": text });
        let params = json!({ "textDocument": document });
        self.send(json!({ "method": "textDocument/didOpen", "params": params }));
    }

    fn diagnostics(&mut self) -> Value {
        let message = self.receive(|it| it["method"] == "textDocument/publishDiagnostics");
        message["params"]["diagnostics"].clone()
    }
}

#[test]
fn an_error_comes_and_goes() {
    let mut server = Server::start();
    server.open("struct s { nope x; };\n");
    assert_eq!(server.diagnostics()[0]["code"], "unknown-type");
    let range = json!({ "start": { "line": 0, "character": 11 },
                        "end": { "line": 0, "character": 15 } });
    let params = json!({
        "textDocument": { "uri": "file:///nowhere/arm.gen", "version": 2 },
        "contentChanges": [{ "range": range, "text": "long" }],
    });
    server.send(json!({ "method": "textDocument/didChange", "params": params }));
    assert_eq!(server.diagnostics(), json!([]));

    server.send(json!({ "id": 1, "method": "shutdown" }));
    server.receive(|it| it["id"] == 1);
    server.send(json!({ "method": "exit" }));
    let status = server.child.wait().expect("it ends, its input still open");
    assert_eq!(status.code(), Some(0));
}

#[test]
fn exit_without_shutdown_is_a_failure() {
    let mut server = Server::start();
    server.send(json!({ "method": "exit" }));
    assert_eq!(server.child.wait().expect("it ends").code(), Some(1));
}

#[test]
fn the_end_of_input_ends_the_program() {
    let mut server = Server::start();
    server.open("component arm {\n");
    server.to = None;
    assert_eq!(server.child.wait().expect("it ends").code(), Some(1));
}

#[test]
fn a_client_that_dies_takes_the_program_along() {
    let mut server = Server::start();
    server.open("component arm {\n");
    server.from = {
        // Nobody reads any more.
        let mut other = Command::new("true")
            .stdout(Stdio::piped())
            .spawn()
            .expect("true runs");
        let _ = other.wait();
        BufReader::new(other.stdout.take().expect("a pipe"))
    };
    server.to = None;
    server.child.wait().expect("it ends");
}

#[test]
fn the_package_tool_runs_only_where_the_client_trusts() {
    use std::os::unix::fs::PermissionsExt;
    let directory = tempfile::tempdir().expect("a directory");
    let tool = directory.path().join("tool");
    let trace = directory.path().join("trace");
    let script = format!("#!/bin/sh\ntouch '{}'\n", trace.display());
    std::fs::write(&tool, script).expect("a script");
    std::fs::set_permissions(&tool, PermissionsExt::from_mode(0o755)).expect("it runs");
    for trusted in [false, true] {
        let options = json!({ "trusted": trusted });
        let params = json!({ "capabilities": {}, "initializationOptions": options });
        let mut server = Server::start_with(params, &[("PKG_CONFIG", &tool)]);
        server.open("#pragma requires \"no-such-package\"\n");
        let found = server.diagnostics();
        assert_eq!(found == json!([]), trusted, "{found}");
        assert_eq!(trace.exists(), trusted);
    }
}
