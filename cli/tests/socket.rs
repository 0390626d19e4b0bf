//! What a run tells of itself at its socket: the types of what it takes, and how far it has come.
#![cfg(target_os = "linux")]

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;

use serde_json::{Value, json};

use crate::directory::Directory;
use crate::running::Listening;

const SPECIFICATION: &str = r#"
enum mode { SLOW, FAST };
struct point { double y, x; };
struct tree;
struct tree { sequence<tree> left, right; };
component arm {
  version "1"; lang "c";
  ids { point at; mode m; tree t; boolean hard; };
  port out point seen;
  task main {
    period 10 ms;
    codel<start> first(out at) yield pause::go wcet 1 ms;
    codel<go> again(inout at) yield pause::go wcet 2 ms;
  };
  function go(in point at = { .x = 1.5 : "To the right (m)", .y = 2. : "Ahead [m]" } : "Where to (see the map)",
              in mode m = FAST, in boolean hard, in sequence<octet, 4> few = { 1, 2 } : "(s)") {};
  function plant(in tree t) {};
};
"#;

/// The answers to a request: the first, and those that follow.
fn ask(directory: &Directory, request: &Value) -> impl Iterator<Item = Value> + use<> {
    let socket = directory.path().join("s");
    let mut client = UnixStream::connect(socket).expect("it listens");
    writeln!(client, "{request}").expect("it reads");
    let lines = BufReader::new(client).lines();
    lines.map(|line| {
        let reply: Value = serde_json::from_str(&line.expect("text")).expect("JSON");
        assert_eq!(reply["version"], 1, "{reply}");
        reply
    })
}

fn run() -> (Directory, Listening) {
    let directory = Directory::new(&[]);
    directory.write("arm.gen", SPECIFICATION.as_bytes());
    let arguments = "run arm.gen --clock real --simulate all --bounds analysed --socket s";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let run = Listening::start(&directory, &arguments);
    (directory, run)
}

#[test]
fn a_run_describes_the_types_of_what_its_services_take() {
    let (directory, _run) = run();
    let mut answers = ask(&directory, &json!({"id": 1, "describe": null}));
    let description = answers.next().expect("an answer");
    let services = description["components"][0]["services"].as_array();
    let service = |name: &str| {
        let mut all = services.expect("services").iter();
        all.find(|service| service["name"] == name).expect("the service")
    };
    let number = json!(["number", "null"]);
    let given = &service("go")["inputs"];
    assert_eq!(given[0]["name"], "at");
    assert_eq!(
        given[0]["schema"],
        json!({
            "type": "object",
            "description": "Where to (see the map)",
            "default": {"x": 1.5, "y": 2.0},
            "properties": {
                "y": {"type": number, "description": "Ahead", "unit": "m", "default": 2.0},
                "x": {"type": number, "description": "To the right", "unit": "m", "default": 1.5},
            },
            "required": ["y", "x"],
            "additionalProperties": false,
        })
    );
    let mode = &given[1]["schema"];
    assert_eq!(mode["anyOf"][0]["enum"], json!(["SLOW", "FAST"]));
    assert_eq!(mode["default"], "FAST");
    assert_eq!(given[2], json!({"name": "hard", "schema": {"type": "boolean"}}));
    let few = &given[3]["schema"];
    assert_eq!(few["maxItems"], 4);
    assert_eq!((&few["unit"], &few["description"]), (&json!("s"), &Value::Null));
    assert_eq!(few["default"], json!([1, 2]));
    // A type that holds itself is not unrolled.
    let tree = &service("plant")["inputs"][0]["schema"];
    assert_eq!(tree["properties"]["left"]["items"], json!({}));
    let connect = &service("connect_port")["inputs"];
    assert_eq!(connect[1]["schema"]["type"], "string");
}

#[test]
fn a_run_tells_how_far_it_has_come() {
    let (directory, _run) = run();
    let mut answers = ask(&directory, &json!({"id": 2, "progress": null}));
    assert_eq!(answers.next().expect("an answer")["event"], "following");
    let taken = |json: &Value, to: &str| {
        let all = json["machines"][0]["transitions"].as_array();
        let mut all = all.expect("transitions").iter();
        let found = all.find(|transition| transition["to"] == to && transition["from"] == "go");
        found.expect("the transition")["taken"].as_u64()
    };
    let moved = |value: &Value| taken(value, "pause::go") > Some(0);
    let first = answers.find(moved).expect("it goes on");
    assert_eq!((&first["id"], &first["event"]), (&json!(2), &json!("progress")));
    assert_eq!(first["machines"][0]["machine"], "arm.main");
    assert_eq!(first["activities"][0]["machine"], "arm.main");
    assert_eq!(first["activities"][0]["state"], "go");
    let task = &first["tasks"][0];
    assert_eq!((&task["task"], &task["bound"]), (&json!("arm.main"), &json!(2)));
    let load = task["load"].as_f64().expect("a number");
    assert!(load > 0.0 && load < 0.5, "{load}");
    let second = answers.next().expect("it goes on");
    assert!(second["time"].as_f64() > first["time"].as_f64());
    assert!(taken(&second, "pause::go") >= taken(&first, "pause::go"));
}

#[test]
fn a_client_that_sends_no_more_gets_its_answers() {
    let (directory, _run) = run();
    let socket = directory.path().join("s");
    let mut client = UnixStream::connect(socket).expect("it listens");
    // As `printf … | nc -U s`: without a line end.
    write!(client, "{}", json!({"id": 3, "call": "arm.go"})).expect("it reads");
    client.shutdown(Shutdown::Write).expect("a half");
    let mut said = String::new();
    client.read_to_string(&mut said).expect("text, and an end");
    let answer: Value = serde_json::from_str(said.trim()).expect("one line");
    assert_eq!((&answer["id"], &answer["event"]), (&json!(3), &json!("done")));
}

#[test]
fn a_client_is_told_its_limits() {
    let (directory, _run) = run();
    let socket = directory.path().join("s");
    let connect = || UnixStream::connect(&socket).expect("it listens");
    let clients: Vec<UnixStream> = (0..64).map(|_| connect()).collect();
    let mut refused = String::new();
    connect().read_to_string(&mut refused).expect("text");
    assert!(refused.contains("too many connections"), "{refused}");
    assert!(refused.contains(r#""version":1"#), "{refused}");
    let mut client = &clients[0];
    let mut lines = BufReader::new(client).lines();
    let mut next = || -> Value {
        let line = lines.next().expect("a line").expect("text");
        serde_json::from_str(&line).expect("JSON")
    };
    let message = |answer: &Value| answer["message"].as_str().unwrap_or_default().to_owned();
    let long = vec![b'x'; 5 << 20];
    client.write_all(&long).expect("it reads");
    writeln!(client).expect("it reads");
    let answer = next();
    assert!(message(&answer).contains("too long"), "{answer}");
    for id in 0..257 {
        let request = json!({"id": id, "watch": "arm/seen"});
        writeln!(client, "{request}").expect("it reads");
    }
    for _ in 0..256 {
        let answer = next();
        assert_eq!(answer["event"], "watching", "{answer}");
    }
    let answer = next();
    assert_eq!(answer["id"], 256);
    assert!(message(&answer).contains("too many requests"), "{answer}");
    let request = json!({"id": 7, "call": "arm.go"});
    writeln!(client, "{request}").expect("it reads");
    let answer = next();
    assert!(message(&answer).contains("has not ended"), "{answer}");
    // There is room again when one has gone.
    drop(clients);
    crate::running::soon("a place", || {
        let mut client = connect();
        let request = json!({"id": 1, "describe": null});
        writeln!(client, "{request}").ok()?;
        let answer = BufReader::new(client).lines().next()?.ok()?;
        answer.contains("description").then_some(())
    });
}

/// Requests with 1 MB of text and of numbers: the process of the component gives the memory back.
#[test]
fn memory_of_requests_is_given_back_in_c() {
    if !crate::running::compilers() {
        return;
    }
    let specification = r#"
struct load { string text; sequence<string> names; sequence<sequence<octet> > rows; };
component store { version "1"; lang "c"; ids { load last; };
  port out load first; port out load second;
  task main { period 10 ms; };
  function take(in load it, out long pages) { codel take_it(in it, out pages); };
  activity keep(in load it) { task main;
    codel<start> keep_it(in it, out last, port out first, port out second) yield ether; };
  attribute kept(out last); };
"#;
    let source = r#"#include "acstore.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "store_c_types.h"
genom_event keep_it(const load *it, load *last, const store_first *first, const store_second *second,
                    const genom_context self) {
  *last = *first->data(self) = *second->data(self) = *it;
  if (first->write(self) || second->write(self)) abort();
  return store_ether;
}
genom_event take_it(const load *it, int32_t *pages, const genom_context self) {
  long all = 0, mine = -1;
  FILE *f = fopen("/proc/self/statm", "r");
  if (f) { if (fscanf(f, "%ld %ld", &all, &mine) != 2) mine = -1; fclose(f); }
  if (strlen(it->text) != 300000 || it->names._length != 3 || it->rows._length != 2) mine = -1;
  *pages = mine;
  return genom_ok;
}
"#;
    let directory = Directory::new(&[("store.gen", specification), ("codels/store.c", source)]);
    let arguments = ["run", "store.gen", "--clock", "real", "--socket", "s"];
    let _run = Listening::start(&directory, &arguments);
    let text = "x".repeat(300_000);
    let input = json!({"it": { "text": text, "names": [text, "b", text], "rows": [[1, 2], vec![7; 100_000]] }});
    let request = json!({"id": 1, "call": "store.take", "input": input});
    let client = UnixStream::connect(directory.path().join("s")).expect("it listens");
    let mut lines = BufReader::new(&client).lines();
    let mut output = |request: &Value| -> Value {
        writeln!(&client, "{request}").expect("it reads");
        loop {
            let line = lines.next().expect("a line").expect("text");
            let answer: Value = serde_json::from_str(&line).expect("JSON");
            match answer["event"].as_str() {
                Some("accepted") => {}
                Some("done") => return answer["output"].clone(),
                _ => panic!("{answer}"),
            }
        }
    };
    let mut pages = || {
        let pages = output(&request)["pages"].as_i64();
        pages.filter(|page| *page > 0).expect("what was sent arrives")
    };
    let first = (0..5).map(|_| pages()).max().expect("five");
    let last = (0..20).map(|_| pages()).max().expect("twenty");
    // Pages of 4 kB: 20 requests of 1 MB would be 5,000.
    assert!(last - first < 1_000, "from {first} to {last} pages");
    // What a codel assigns to the ids and to ports stays there after the request.
    output(&json!({"id": 2, "call": "store.keep", "input": input}));
    output(&request);
    let kept = output(&json!({"id": 3, "call": "store.kept"}));
    assert!(kept["last"] == input["it"]);
    for port in ["store/first", "store/second"] {
        let mut answers = ask(&directory, &json!({"id": 4, "read": port}));
        assert!(answers.next().expect("an answer")["value"] == input["it"]);
    }
}
