//! `dotgen lsp`, the built program, over its standard input and output.

use std::io::BufReader;
use std::process::{Command, Stdio};

use serde_json::json;

#[allow(dead_code, reason = "shared with other tests")]
use crate::server::Server;

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
    server.receive(|message| message["id"] == 1);
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
        let mut other = Command::new("true").stdout(Stdio::piped()).spawn().expect("true runs");
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
