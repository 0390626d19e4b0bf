//! What a client may do wrong, and what the server makes of it: it answers, and the session goes on.

use std::process::{Command, Stdio};

use serde_json::{Value, json};

#[allow(dead_code, reason = "shared with other tests")]
use crate::server::Server;

const URI: &str = "file:///nowhere/arm.gen";

fn frame(body: &str) -> Vec<u8> {
    format!("Content-Length: {}\r\n\r\n{body}", body.len()).into_bytes()
}

fn message(mut value: Value) -> Vec<u8> {
    value["jsonrpc"] = json!("2.0");
    frame(&value.to_string())
}

/// The server still works.
fn goes_on(mut server: Server) {
    server.open("struct s { nope x; };\n");
    assert_eq!(server.diagnostics()[0]["code"], "unknown-type");
    server.end();
}

fn refused(server: &mut Server, bytes: &[u8], code: i64) {
    server.bytes(bytes);
    let answer = server.receive(|message| message.get("error").is_some());
    assert_eq!(answer["error"]["code"], code, "{answer}");
}

#[test]
fn bad_json_is_told_and_forgotten() {
    let mut server = Server::start();
    for body in ["{", "nope", "{\"jsonrpc\":\"2.0\",}", "", &"[".repeat(5000)] {
        refused(&mut server, &frame(body), -32700);
    }
    for body in ["[]", "4", "{}", "{\"jsonrpc\":\"2.0\",\"id\":7}"] {
        refused(&mut server, &frame(body), -32600);
    }
    goes_on(server);
}

#[test]
fn bad_headers_cost_one_message_at_most() {
    let shutdown = |id: i64| message(json!({ "id": id, "method": "dotgen/nothing" }));
    let mut server = Server::start();
    let mut answered = |bytes: Vec<u8>, id: i64| {
        server.bytes(&bytes);
        let answer = server.receive(|message| message["id"] == id);
        assert_eq!(answer["error"]["code"], -32601);
    };
    let other = b"X-Other: 1\r\nContent-Type: application/vscode-jsonrpc\r\n".to_vec();
    answered([other, shutdown(1)].concat(), 1);
    let garbage = b"GET / HTTP/1.1\r\nHost: x\r\n\r\nhello".to_vec();
    answered([garbage, shutdown(2)].concat(), 2);
    let short = b"Content-Length: 3\r\n\r\n{\"id\":8}".to_vec();
    answered([short, shutdown(3)].concat(), 3);
    let long = b"Content-Length: 3000\r\n\r\n{\"id\":8}".to_vec();
    answered([long, shutdown(4)].concat(), 4);
    for length in ["-1", "x", "", "9999999999", "18446744073709551616000"] {
        let wrong = format!("Content-Length: {length}\r\n\r\n{{}}").into_bytes();
        answered([wrong, shutdown(5)].concat(), 5);
    }
    goes_on(server);
}

#[test]
fn a_huge_length_takes_no_memory() {
    let mut server = Server::start();
    server.bytes(b"Content-Length: 200000000\r\n\r\n{");
    server.bytes(&message(json!({ "id": 1, "method": "dotgen/nothing" })));
    server.receive(|message| message["id"] == 1);
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.child.id()));
    if let Ok(status) = status {
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak = peak.and_then(|peak| peak.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        assert!(peak.expect("a peak") < 190_000, "{peak:?}");
    }
    goes_on(server);
}

#[test]
fn every_request_is_answered() {
    let mut server = Server::raw(&[]);
    let code = |answer: Value| answer["error"]["code"].as_i64();
    let document = json!({ "textDocument": { "uri": URI } });
    for method in ["textDocument/hover", "shutdown", "dotgen/nothing", "$/nothing"] {
        let answer = server.request(1, method, document.clone());
        assert_eq!(code(answer), Some(-32002), "{method} before initialize");
    }
    let answer = server.request(2, "initialize", json!(5));
    assert_eq!(code(answer), Some(-32602));
    let answer = server.request(3, "initialize", json!({ "capabilities": {} }));
    assert_eq!(answer["result"]["serverInfo"]["name"], "dotgen");
    let answer = server.request(4, "initialize", json!({ "capabilities": {} }));
    assert_eq!(code(answer), Some(-32600));
    for method in ["dotgen/nothing", "textDocument/nothing", "$/nothing"] {
        assert_eq!(code(server.request(5, method, json!({}))), Some(-32601), "{method}");
    }
    for params in [Value::Null, json!([]), json!({}), json!({ "textDocument": 5 })] {
        let answer = server.request(6, "textDocument/hover", params);
        assert_eq!(code(answer), Some(-32602));
    }
    // Notifications with an id, as some clients send them.
    for (method, params) in [("initialized", json!({})), ("$/cancelRequest", json!({ "id": 99 }))] {
        let answer = server.request(7, method, params);
        assert_eq!(answer["result"], Value::Null, "{method}");
    }
    server.send(json!({ "id": 1.5, "method": "textDocument/hover", "params": document }));
    assert_eq!(code(server.receive(|message| message["id"] == 1.5)), Some(-32600));
    server.send(json!({ "id": "text", "method": "dotgen/nothing" }));
    assert_eq!(code(server.receive(|message| message["id"] == "text")), Some(-32601));
    assert_eq!(server.request(8, "shutdown", Value::Null)["result"], Value::Null);
    for method in ["textDocument/hover", "shutdown", "initialize", "dotgen/nothing"] {
        let answer = server.request(9, method, document.clone());
        assert_eq!(code(answer), Some(-32600), "{method} after shutdown");
    }
    server.send(json!({ "method": "exit" }));
    assert_eq!(server.child.wait().expect("it ends").code(), Some(0));
}

#[test]
fn a_whole_session_can_be_sent_at_once() {
    let initialize = json!({ "id": 1, "method": "initialize", "params": { "capabilities": {} } });
    let shutdown = json!({ "id": 2, "method": "shutdown" });
    let exit = json!({ "method": "exit" });
    for (messages, status) in
        [(vec![&initialize, &shutdown, &exit], 0), (vec![&initialize, &exit], 1), (vec![&exit], 1)]
    {
        let mut server = Server::raw(&[]);
        let all: Vec<u8> = messages.iter().flat_map(|other| message((*other).clone())).collect();
        server.bytes(&all);
        for asked in messages.iter().filter(|message| message.get("id").is_some()) {
            let answer = server.receive(|message| message["id"] == asked["id"]);
            assert!(answer.get("result").is_some(), "{answer}");
        }
        let ended = server.child.wait().expect("it ends, its input still open");
        assert_eq!(ended.code(), Some(status));
    }
}

#[test]
fn half_a_character_is_mended_and_asked_for_again() {
    let options = json!({ "documentText": true });
    let mut server =
        Server::start_with(json!({ "capabilities": {}, "initializationOptions": options }), &[]);
    server.open("// \nstruct s { long x; };\n");
    assert_eq!(server.diagnostics(), json!([]));
    let change = |version: i64, at: i64, text: &str| {
        let position = json!({ "line": 0, "character": at });
        let body = json!({ "jsonrpc": "2.0", "method": "textDocument/didChange", "params": {
            "textDocument": { "uri": URI, "version": version },
            "contentChanges": [{ "range": { "start": position, "end": position }, "text": "TEXT" }],
        }});
        frame(&body.to_string().replace("TEXT", text))
    };
    server.bytes(&change(2, 3, "\\ud83d"));
    let asked = server.receive(|message| message["method"] == "dotgen/documentText");
    assert_eq!(asked["params"]["uri"], URI);
    // The other half is on its way: the answer is of a version that the server does not have.
    let text = "// \u{1f600}\nstruct s { long x; };\n";
    server.send(json!({ "id": asked["id"], "result": { "version": 3, "text": text } }));
    server.bytes(&change(3, 4, "\\ude00"));
    let asked = server.receive(|message| message["method"] == "dotgen/documentText");
    server.send(json!({ "id": asked["id"], "result": { "version": 3, "text": text } }));
    // The text becomes right some time after the answer.
    let document = json!({ "textDocument": { "uri": URI } });
    let tree = |server: &mut Server, id: i64| {
        let answer = server.request(id, "dotgen/syntaxTree", document.clone());
        answer["result"].as_str().expect("a tree").to_owned()
    };
    let right = (10..1000).any(|id| tree(&mut server, id).contains('\u{1f600}'));
    assert!(right, "{}", tree(&mut server, 1000));
    server.end();
}

#[test]
fn half_a_character_goes_when_the_file_is_saved() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("arm.gen");
    let uri = format!("file://{}", path.display());
    let mut server = Server::start();
    let document = json!({ "uri": uri, "languageId": "gen", "version": 1, "text": "// TEXT" });
    let open = json!({ "jsonrpc": "2.0", "method": "textDocument/didOpen",
                       "params": { "textDocument": document } });
    server.bytes(&frame(&open.to_string().replace("TEXT", "\\ude00 bad")));
    let document = json!({ "textDocument": { "uri": uri } });
    let tree = server.request(1, "dotgen/syntaxTree", document.clone());
    assert!(tree["result"].as_str().is_some_and(|text| text.contains("\u{fffd} bad")), "{tree}");
    std::fs::write(&path, "// good").expect("saved");
    server.send(json!({ "method": "textDocument/didSave", "params": document }));
    let tree = server.request(2, "dotgen/syntaxTree", document);
    assert!(tree["result"].as_str().is_some_and(|text| text.contains("// good")), "{tree}");
    server.end();
}

#[test]
fn a_file_has_one_set_of_diagnostics_however_its_uri_is_spelt() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("a+b.gen");
    std::fs::write(&path, "struct s { nope x; };\n").expect("a file");
    let folder = format!("file://{}", directory.path().display());
    let mut server = Server::start_with(json!({ "capabilities": {}, "rootUri": folder }), &[]);
    let mut sets = std::collections::BTreeMap::new();
    let mut hear = |server: &mut Server, until: &dyn Fn(&str, usize) -> bool| {
        loop {
            let message =
                server.receive(|message| message["method"] == "textDocument/publishDiagnostics");
            let uri = message["params"]["uri"].as_str().expect("a URI").to_owned();
            let count = message["params"]["diagnostics"].as_array().map_or(0, Vec::len);
            let done = until(&uri, count);
            match count {
                0 => sets.remove(&uri),
                count => sets.insert(uri, count),
            };
            if done {
                return sets.clone();
            }
        }
    };
    let before = hear(&mut server, &|_, count| count > 0);
    assert_eq!(before.len(), 1);
    for (version, name) in [(1, "a%2Bb.gen"), (2, "a%2bb.gen"), (3, "a+b.gen"), (4, "%61+b.gen")] {
        let uri = format!("{folder}/{name}");
        let text = "struct s { nope x; };\n";
        let document = json!({ "uri": uri, "languageId": "gen", "version": version, "text": text });
        server.send(json!({ "method": "textDocument/didOpen",
                            "params": { "textDocument": document } }));
        let after = hear(&mut server, &|document, count| document == uri && count > 0);
        assert_eq!(after.into_iter().collect::<Vec<_>>(), [(uri.clone(), 1)]);
        let document = json!({ "textDocument": { "uri": uri } });
        server.send(json!({ "method": "textDocument/didClose", "params": document }));
    }
    server.end();
}

#[cfg(unix)]
#[test]
fn the_server_ends_with_the_process_of_its_client() {
    let mut client =
        Command::new("sleep").arg("1000").stdin(Stdio::null()).spawn().expect("sleep runs");
    let mut server =
        Server::start_with(json!({ "capabilities": {}, "processId": client.id() }), &[]);
    server.open("struct s { nope x; };\n");
    server.diagnostics();
    client.kill().expect("it is ours");
    // Not waited for yet: a client that nobody buries has ended all the same.
    assert_eq!(server.child.wait().expect("it ends").code(), Some(1));
    client.wait().expect("it has ended");
}

/// As in a container: the id of the client belongs to another namespace.
#[test]
fn a_client_that_is_not_visible_is_not_watched() {
    let client = json!({ "capabilities": {}, "processId": i32::MAX });
    goes_on(Server::start_with(client, &[]));
}

/// A pipe holds 64 KiB on Linux. Each of the changes is about a document that is not open, which is logged.
#[test]
fn a_log_that_is_not_read_blocks_nothing() {
    let mut server = Server::unread();
    server.request(0, "initialize", json!({ "capabilities": {} }));
    server.send(json!({ "method": "initialized", "params": {} }));
    let params = json!({
        "textDocument": { "uri": "file:///nowhere/other.gen", "version": 1 },
        "contentChanges": [{ "text": "x" }],
    });
    for _ in 0..2000 {
        server.send(json!({ "method": "textDocument/didChange", "params": params }));
    }
    goes_on(server);
}

#[test]
fn garbage_costs_nothing_but_itself() {
    let mut server = Server::start();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: u64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state % below
    };
    let pieces: [&[u8]; 8] = [
        b"{\"jsonrpc\":\"2.0\",\"id\":",
        b"Content-Length: ",
        b"12\r\n\r\n",
        b"\xff\xfe\0",
        b"}]\"",
        b"\r\n",
        b"Content-Type: x\r\n",
        b"\\ud800",
    ];
    for id in 0..300 {
        let mut bytes = Vec::new();
        for _ in 0..random(12) {
            match random(3) {
                0 => bytes.push(random(256) as u8),
                _ => bytes.extend_from_slice(pieces[random(8) as usize]),
            }
        }
        // A header that is cut off takes the next line for its value, as it must.
        bytes.extend_from_slice(b"\r\n");
        server.bytes(&bytes);
        server.bytes(&message(json!({ "id": id, "method": "dotgen/nothing" })));
        let answer =
            server.receive(|message| message["id"] == id && message["error"]["code"] == -32601);
        assert_eq!(answer["id"], id);
    }
    goes_on(server);
}
