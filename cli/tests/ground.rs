//! The ground of an answer, wherever the answer is shown: for each kind of missing ground, and each place,
//! the word that stands there. None is *proved*, *kept* or `✓`.

use serde_json::{Value, json};

use crate::directory::{Directory, status, stdout};
use crate::running::compilers;
use crate::server::Server;

/// An answer with less ground than its check asks for.
struct Case {
    name: &'static str,
    /// The body of the task.
    task: &'static str,
    /// Further declarations of the component.
    more: &'static str,
    /// Items of the scenario.
    scenario: &'static str,
    /// The verdict, as a word.
    word: &'static str,
    /// Text that gives the reason.
    reason: &'static str,
    status: i32,
    /// The exploration is given up at once.
    limited: bool,
}

const TIMED: &str = "period 10 ms; codel<start> c_first(out n) yield pause::start wcet 1 ms;";

/// The words of an answer that rests on what is given.
const GREEN: [&str; 2] = ["proved", "✓"];

const CASES: [Case; 7] = [
    Case {
        name: "an execution time is missing",
        task: "period 10 ms; codel<start> c_first(out n) yield pause::go; codel<go> c_go(out n) yield pause::go wcet 1 ms;",
        more: "",
        scenario: "check schedulable c.main;",
        word: "conditional",
        reason: "c.main.start has no `wcet`",
        status: 3,
        limited: false,
    },
    Case {
        name: "a stand-in takes the place of an interface",
        task: TIMED,
        more: "provides i;",
        scenario: "check schedulable c.main;",
        word: "conditional",
        reason: "i (of c) is an unknown interface",
        status: 3,
        limited: false,
    },
    Case {
        name: "no time is given at all",
        task: "period 10 ms; codel<start> c_first(out n) yield pause::start;",
        more: "",
        scenario: "check schedulable c.main;",
        word: "nothing",
        reason: "nothing to verify",
        status: 3,
        limited: false,
    },
    Case {
        name: "no job is ever released",
        task: "codel<start> c_first(out n) yield pause::start wcet 1 ms;",
        more: "",
        scenario: "check response c.main;",
        word: "vacuous",
        reason: "has no period",
        status: 0,
        limited: false,
    },
    Case {
        name: "the value is beyond the period, without a limit",
        task: "period 10 ms; codel<start> c_first(out n) yield pause::start wcet 12 ms;",
        more: "",
        scenario: "check response c.main;",
        word: "exceeds",
        reason: "10 ms",
        status: 0,
        limited: false,
    },
    Case {
        name: "only a bound is known, beyond the period",
        task: "period 10 ms; codel<start> c_first(out n) yield pause::start wcet 12 ms;",
        more: "",
        scenario: "check response c.main;",
        word: "bounded",
        reason: "≤ 32 ms",
        status: 0,
        limited: true,
    },
    Case {
        name: "the verification was given up",
        task: TIMED,
        more: "",
        scenario: "check leadsto c.main.start.exec => c.main.idle;",
        word: "gave up",
        reason: "",
        status: 3,
        limited: true,
    },
];

impl Case {
    fn specification(&self) -> String {
        let include = if self.more.contains("provides") { "#include \"i.gen\"\n" } else { "" };
        format!(
            "{include}component c {{ version \"1\"; lang \"c\"; ids {{ long n; }};\ntask main {{ {} }};\n{}\n}};\n",
            self.task, self.more
        )
    }

    fn folder(&self) -> Directory {
        let scenario = format!("scenario s {{ use \"c.gen\"; {} }}\n", self.scenario);
        let files = [("c.gen", self.specification()), ("s.scn", scenario)];
        let directory = Directory::new(&[]);
        for (name, text) in &files {
            directory.write(name, text.as_bytes());
        }
        if self.more.contains("provides") {
            directory.write(".dotgen/standins/i.gen", b"interface i {\n};\n");
        }
        if self.limited {
            directory.write("dotgen.toml", b"[verification]\nmax-states = 2\n");
        }
        directory
    }
}

/// A word says no more than it rests on.
fn assert_modest(place: &str, text: &str, words: &[&str]) {
    for word in words {
        assert!(!text.contains(word), "{place} says `{word}`: {text}");
    }
}

#[test]
fn the_command_line_and_json_say_on_what_an_answer_rests() {
    for case in &CASES {
        let directory = case.folder();
        let states = if case.limited { "2" } else { "100000" };
        let arguments = ["verify", "s.scn", "--max-states", states];
        let text = directory.run(&arguments);
        let shown = stdout(&text);
        assert_modest(case.name, &shown, &GREEN);
        assert!(shown.contains(case.word) && shown.contains(case.reason), "{}: {shown}", case.name);
        assert_eq!(status(&text), case.status, "{}: {shown}", case.name);
        let json = directory.run(&[&arguments[..], &["--format", "json"]].concat());
        let json: Value = serde_json::from_str(&stdout(&json)).expect("JSON");
        let word = if case.word == "gave up" { "unknown" } else { case.word };
        assert_eq!(json["checks"][0]["verdict"], word, "{}: {json}", case.name);
    }
}

#[test]
fn an_editor_says_on_what_an_answer_rests() {
    for case in &CASES {
        let directory = case.folder();
        let uri = |name: &str| format!("file://{}", directory.path().join(name).display());
        let mut server = Server::start_with(
            json!({
                "capabilities": {
                    "textDocument": { "diagnostic": {}, "hover": { "contentFormat": ["markdown"] } },
                },
                "workspaceFolders": [{ "uri": uri(""), "name": "folder" }],
                "initializationOptions": { "verificationStatus": true },
            }),
            &[],
        );
        for (name, language) in [("c.gen", "genom3"), ("s.scn", "genom3-scenario")] {
            let text = std::fs::read_to_string(directory.path().join(name)).expect("a file");
            let item =
                json!({ "uri": uri(name), "languageId": language, "version": 1, "text": text });
            let params = json!({ "textDocument": item });
            server.send(json!({ "method": "textDocument/didOpen", "params": params }));
        }
        let settled = server.receive(|message| {
            let params = &message["params"];
            message["method"] == "dotgen/verificationStatus"
                && params["uri"] == uri("s.scn")
                && !["stale", "running"].map(Value::from).contains(&params["status"])
        });
        let mut places = vec![("status", settled["params"].to_string())];
        let of = |name: &str| json!({ "textDocument": { "uri": uri(name) } });
        let mut ask = |id: i64, place, method: &str, params: Value| {
            let answer = server.request(id, method, params);
            assert!(!answer["result"].is_null(), "{}: {answer}", case.name);
            places.push((place, answer["result"].to_string()));
        };
        ask(1, "panel", "dotgen/verification", of("s.scn"));
        ask(2, "lens of the scenario", "textDocument/codeLens", of("s.scn"));
        ask(3, "lens of the task", "textDocument/codeLens", of("c.gen"));
        ask(4, "diagnostics", "textDocument/diagnostic", of("s.scn"));
        ask(5, "diagnostics", "textDocument/diagnostic", of("c.gen"));
        let lines = case.specification();
        let line = lines.lines().position(|line| line.starts_with("task main")).expect("a task");
        let mut at = of("c.gen");
        at["position"] = json!({ "line": line, "character": 6 });
        ask(6, "hover", "textDocument/hover", at);
        for (place, text) in &places {
            assert_modest(&format!("{}, {place}", case.name), text, &GREEN);
        }
        let panel = &places[1].1;
        assert!(
            panel.contains(&format!("\"verdict\":\"{}\"", case.word)),
            "{}: {panel}",
            case.name
        );
        server.end();
    }
}

/// Everything is simulated where there are no sources, and a check is not exercised where nothing happens.
#[test]
fn a_run_says_what_was_simulated_and_what_nothing_exercised() {
    let cases = [
        ("", "check schedulable c.main;", "simulated"),
        (
            "activity go() { task main; codel<start> c_go(in n) yield ether wcet 1 ms; };",
            "check leadsto c.go.start.exec => c.main.idle;",
            "not-exercised",
        ),
    ];
    for (more, scenario, word) in cases {
        let case = Case { task: TIMED, more, scenario, ..CASES[3] };
        let directory = case.folder();
        let arguments = ["run", "s.scn", "--until", "1s"];
        let text = stdout(&directory.run(&arguments));
        let json = directory.run(&[&arguments[..], &["--format", "json"]].concat());
        let json: Value = serde_json::from_str(&stdout(&json)).expect("JSON");
        assert_modest("the report", &text, &["kept"]);
        assert!(text.contains(&word.replace('-', " ")), "{text}");
        assert_eq!((&json["verdict"], &json["checks"][0]["verdict"]), (&word.into(), &word.into()));
    }
}

#[test]
fn a_run_names_the_ports_that_nothing_wrote() {
    if !compilers() {
        return;
    }
    let specification = "typedef long v_data; component c { version \"1\"; lang \"c\";\n\
        port out v_data level; port out v_data ok;\n\
        task main { period 10 ms; codel<start> c_first(port out level, port out ok) yield pause::start \
        wcet 1 ms; }; };\n";
    let directory = Directory::new(&[("c.gen", specification)]);
    assert_eq!(status(&directory.run(&["codels", "stub", "c.gen"])), 0);
    let source = directory.path().join("codels/c_main_codels.c");
    let text = std::fs::read_to_string(&source).expect("a stub");
    let (body, rest) = text.split_once("/* skeleton sample */ return").expect("a stub returns");
    let written = format!("{body}*ok->data(self) = 1; ok->write(self); return{rest}");
    std::fs::write(&source, written).expect("a file");
    let ran = directory.run(&["run", "c.gen", "--until", "100ms", "--format", "json"]);
    let report: Value = serde_json::from_str(&stdout(&ran)).expect("JSON");
    let [level, ok] = [0, 1].map(|port| &report["ports"][port]);
    assert_eq!((&level["port"], &level["writes"]), (&"c/level".into(), &0.into()), "{report:#}");
    assert!(level["greatest-age"].is_null() && ok["writes"].as_u64() > Some(8), "{report:#}");
    let age = ok["greatest-age"].as_f64();
    assert!(age.is_some_and(|age| (9.0..=11.0).contains(&age)), "{report:#}");
}
