//! `dotgen mcp`, as an assistant uses it.

mod defects;

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

use serde_json::{Value, json};

use crate::directory::Directory;

const PUMP: &str = include_str!("../../examples/pump/pump.gen");
const SCENARIO: &str = include_str!("../../examples/pump/pump.scn");

/// A client with the server in a directory.
struct Client {
    server: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    requests: u32,
}

impl Client {
    fn start(directory: &Directory) -> Client {
        Client::start_in(directory, "")
    }

    /// A client with the server in a folder of a directory.
    fn start_in(directory: &Directory, folder: &str) -> Client {
        let mut command = directory.command(&["mcp"]);
        command.current_dir(directory.path().join(folder));
        let mut server = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the server starts");
        let mut client = Client {
            input: server.stdin.take(),
            output: BufReader::new(server.stdout.take().expect("piped")),
            server,
            requests: 0,
        };
        let client_info = json!({ "name": "test", "version": "0" });
        let parameters = json!({
            "protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": client_info,
        });
        let answer = client.request("initialize", parameters);
        assert_eq!(answer["serverInfo"]["name"], "dotgen");
        client.send(&json!({ "jsonrpc": "2.0", "method": "notifications/initialized" }));
        client
    }

    fn send(&mut self, message: &Value) {
        let input = self.input.as_mut().expect("open");
        writeln!(input, "{message}").expect("the server reads");
    }

    fn request(&mut self, method: &str, parameters: Value) -> Value {
        self.requests += 1;
        let id = self.requests;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": parameters }));
        let mut line = String::new();
        self.output.read_line(&mut line).expect("an answer");
        let mut answer: Value = serde_json::from_str(&line).expect("JSON");
        assert_eq!(answer["id"], id);
        answer["result"].take()
    }

    /// The texts of an answer, and true if it is an error.
    fn call(&mut self, tool: &str, arguments: Value) -> (String, bool) {
        let result = self.request("tools/call", json!({ "name": tool, "arguments": arguments }));
        let blocks = result["content"].as_array().expect("content");
        let texts: Vec<&str> = blocks.iter().filter_map(|block| block["text"].as_str()).collect();
        (texts.concat(), result["isError"] == true)
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        // The end of the input ends the server.
        self.input = None;
        let status = self.server.wait().expect("it ends");
        assert!(status.success() || std::thread::panicking(), "{status}");
    }
}

#[test]
fn the_tools_are_at_most_eight_and_described() {
    let directory = Directory::new(&[]);
    let mut client = Client::start(&directory);
    let tools = client.request("tools/list", json!({}));
    let tools = tools["tools"].as_array().expect("tools");
    let names: Vec<&str> = tools.iter().filter_map(|tool| tool["name"].as_str()).collect();
    let expected = ["check", "codels", "draw", "explain", "fix", "look_up", "simulate", "verify"];
    assert_eq!(names, expected);
    for tool in tools {
        assert_eq!(tool["inputSchema"]["additionalProperties"], false, "{}", tool["name"]);
        let changes_files = ["codels", "fix"].contains(&tool["name"].as_str().expect("a name"));
        assert_eq!(tool["annotations"]["destructiveHint"] == true, changes_files, "{tool}");
        for (name, property) in tool["inputSchema"]["properties"].as_object().expect("properties") {
            let described = property["description"].is_string() || property["$ref"].is_string();
            assert!(described, "{}: {name}", tool["name"]);
        }
    }
}

#[test]
fn a_call_changes_only_what_it_names() {
    let broken = PUMP.replacen("lang    \"c\";", "lang    \"c\"", 1);
    let directory = Directory::new(&[("in/pump.gen", &broken), ("out.gen", &broken)]);
    let mut client = Client::start_in(&directory, "in");
    for (tool, arguments) in [
        ("fix", json!({ "file": "pump.gen" })),
        ("fix", json!({ "path": "pump.gen", "unsafe": true })),
        ("fix", json!({})),
        ("check", json!({ "file": "pump.gen" })),
        ("explain", json!({ "code": "fsm/busy-loop", "path": "." })),
    ] {
        let (text, is_error) = client.call(tool, arguments.clone());
        assert!(is_error && text.contains("field"), "{tool} {arguments}: {text}");
    }
    for (tool, path) in
        [("fix", ".."), ("fix", "../out.gen"), ("check", "/"), ("draw", "none/../../x")]
    {
        let (text, is_error) = client.call(tool, json!({ "path": path }));
        assert!(is_error && text.contains("is outside of"), "{tool} {path}: {text}");
    }
    let (text, is_error) = client.call("codels", json!({ "action": "stub" }));
    assert!(is_error && text.starts_with("`path` is missing"), "{text}");
    assert_eq!(directory.read("in/pump.gen"), broken);
    assert_eq!(directory.read("out.gen"), broken);
}

#[test]
fn a_defect_is_found_explained_and_fixed() {
    let broken = PUMP.replacen("lang    \"c\";", "lang    \"c\"", 1);
    let directory = Directory::new(&[("pump.gen", &broken), ("pump.scn", SCENARIO)]);
    let mut client = Client::start(&directory);
    let (found, is_error) = client.call("check", json!({ "path": "pump.gen" }));
    assert!(found.contains("error[") && !is_error, "{found}");
    let code = found.split(['[', ']']).nth(1).expect("a code");
    let (page, is_error) = client.call("explain", json!({ "code": code }));
    assert!(page.starts_with(&format!("# {code}")) && !is_error, "{page}");
    client.call("fix", json!({ "path": "pump.gen" }));
    assert_eq!(directory.read("pump.gen"), PUMP);
    for (tool, path) in [("check", "pump.gen"), ("verify", "pump.scn"), ("simulate", "pump.scn")] {
        let (text, is_error) = client.call(tool, json!({ "path": path }));
        assert!(!is_error && !text.is_empty(), "{tool}: {text}");
    }
}

#[test]
fn a_long_answer_is_shortened_and_an_error_is_one() {
    let state = "  codel<a> f() yield nowhere;\n";
    let text = format!("component c {{ task t {{\n{}}}; }};\n", state.repeat(300));
    let directory = Directory::new(&[("c.gen", &text)]);
    let mut client = Client::start(&directory);
    let (answer, _) = client.call("check", json!({}));
    assert!(answer.len() <= 7_000, "{}", answer.len());
    assert!(answer.contains("more lines: name one file or declaration\n"), "{answer}");
    let (answer, is_error) = client.call("check", json!({ "path": "--help" }));
    assert!(is_error, "a path is not an option: {answer}");
}

/// Ten tasks on one core, whose exploration takes minutes.
fn endless() -> (String, &'static str) {
    let mut text = "component c {\n".to_owned();
    for (task, period) in [10, 20, 25, 40, 50, 80, 100, 110, 200, 210].into_iter().enumerate() {
        let codel = format!("codel<start> f{task}() yield pause::start wcet {} ms;", task + 2);
        text += &format!("  task t{task} {{ period {period} ms; {codel} }};\n");
    }
    let scenario = "scenario s { use \"c.gen\"; cores 1; policy priority; check schedulable *; }\n";
    (text + "};\n", scenario)
}

#[test]
fn a_cancelled_request_ends_its_command() {
    let (text, scenario) = endless();
    let directory = Directory::new(&[("c.gen", &text), ("c.scn", scenario)]);
    let mut client = Client::start(&directory);
    let call = json!({ "name": "verify", "arguments": { "path": "c.scn" } });
    client.requests += 1;
    let id = client.requests;
    client.send(&json!({ "jsonrpc": "2.0", "id": id, "method": "tools/call", "params": call }));
    let cancelled = json!({ "requestId": id });
    let method = "notifications/cancelled";
    client.send(&json!({ "jsonrpc": "2.0", "method": method, "params": cancelled }));
    // One command runs at a time: this one waits for the end of the first.
    let started = std::time::Instant::now();
    let (page, is_error) = client.call("explain", json!({ "code": "fsm/busy-loop" }));
    assert!(page.starts_with("# fsm/busy-loop") && !is_error, "{page}");
    assert!(started.elapsed().as_secs() < 60, "the first command did not end");
}
