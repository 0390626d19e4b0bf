//! Verification on edit over the protocol.

mod places;

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const STATUS: &str = "dotgen/verificationStatus";

/// Two tasks that share data: `slow` can block `fast`.
fn pump(slow: &str) -> String {
    format!(
        "component pump {{\n  ids {{ double level; }};\n  task fast {{ period 10 ms;\n    codel<start> watch(in level) yield pause::main wcet 0 ms;\n    codel<main> more(in level) yield pause::main wcet 0 ms;\n  }};\n  task t {{ period 10 ms;\n    codel<start> init(out level) yield pause::main wcet 1 ms;\n    codel<main> control(inout level) yield pause::main wcet {slow};\n  }};\n}};\n"
    )
}

/// `pump` without the execution times of the task `fast`.
fn untimed(slow: &str) -> String {
    pump(slow).replace(" wcet 0 ms", "")
}

const SCENARIO: &str = "scenario tank {\n  use \"pump.gen\"; semantics published;\n  cores 2;\n  check schedulable *;\n  check limit: response pump.t <= 8 ms;\n}\n";

fn telling(folder: &Folder) -> Value {
    let mut params = folder.params(pulling());
    params["initializationOptions"] = json!({ "verificationStatus": true });
    params
}

/// Waits until the verification of a document has the wanted status for a version.
async fn until(client: &mut Client, uri: &str, version: i64, status: &str) {
    let mut seen = Vec::new();
    loop {
        let notification = client.notification(STATUS).await;
        if notification["uri"] == uri
            && notification["version"] == version
            && notification["status"] == status
        {
            return;
        }
        let settled =
            ["proved", "conditional", "refuted", "gave-up", "nothing", "blocked"].map(Value::from);
        assert!(
            notification["uri"] != uri
                || notification["version"] != version
                || !settled.contains(&notification["status"]),
            "{notification} after {seen:?}"
        );
        seen.push(notification);
    }
}

async fn lenses(client: &mut Client, uri: &str) -> Vec<String> {
    let lenses = client.ok("textDocument/codeLens", document(uri)).await;
    let lenses = lenses.as_array().cloned().unwrap_or_default();
    let title = |json: &Value| json["command"]["title"].as_str().map(str::to_owned);
    lenses.iter().filter_map(title).collect()
}

async fn timing(client: &mut Client, uri: &str) -> Vec<String> {
    let all = client.pulled(uri).await;
    let verified = [
        "timing/deadline-miss",
        "timing/response-exceeded",
        "timing/check-failed",
        "timing/gave-up",
    ];
    all.into_iter().filter(|text| verified.contains(&text.as_str())).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_longer_codel_misses_the_deadline_until_it_is_shorter_again() {
    let folder = Folder::new(&[]);
    let mut client = Client::start(telling(&folder)).await;
    let uri = folder.uri("pump.gen");
    client.open(&uri, &pump("4 ms")).await;
    until(&mut client, &uri, 1, "proved").await;
    assert_eq!(timing(&mut client, &uri).await, [""; 0]);

    client.change(&uri, 2, json!([{ "text": pump("12 ms") }])).await;
    until(&mut client, &uri, 2, "refuted").await;
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    let miss = report["items"].as_array().expect("a list").iter();
    let miss = miss.filter(|miss| miss["code"] == "timing/deadline-miss");
    // `fast` is blocked by `t` for too long, and also misses its deadline.
    let miss: Vec<&Value> = miss.filter(|miss| miss["range"]["start"]["line"] == 6).collect();
    assert_eq!(miss.len(), 1, "{report}");
    let message = miss[0]["message"].as_str().expect("text");
    assert!(message.contains("`pump.t`") && message.contains("30 ms"), "{message}");
    let related = miss[0]["relatedInformation"].as_array().expect("places");
    assert!(!related.is_empty() && related[0]["location"]["uri"] == uri.as_str());

    client.change(&uri, 3, json!([{ "text": pump("4 ms") }])).await;
    until(&mut client, &uri, 3, "proved").await;
    assert_eq!(timing(&mut client, &uri).await, [""; 0]);
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn lenses_say_what_was_computed() {
    let folder = Folder::new(&[("pump.gen", &pump("4 ms"))]);
    let mut client = Client::start(telling(&folder)).await;
    let (gen_uri, scn) = (folder.uri("pump.gen"), folder.uri("pump.scn"));
    client.open(&scn, SCENARIO).await;
    // The number of cores comes last.
    while client.notification(STATUS).await["minimumCores"] != 1 {}
    let titles = lenses(&mut client, &scn).await;
    assert!(titles[0].starts_with("proved · "), "{titles:?}");
    assert_eq!(titles[1..], ["pump.fast proved | pump.t proved", "4 ms · proved"]);
    client.open(&gen_uri, &pump("4 ms")).await;
    until(&mut client, &scn, 1, "proved").await;
    let titles = lenses(&mut client, &gen_uri).await;
    assert!(titles.contains(&"✓ 4 of 8 ms".to_owned()), "{titles:?}");
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_edit_of_what_a_scenario_uses_makes_its_answer_stale_at_once() {
    let folder = Folder::new(&[("pump.gen", &pump("4 ms"))]);
    let mut client = Client::start(telling(&folder)).await;
    let (gen_uri, scn) = (folder.uri("pump.gen"), folder.uri("pump.scn"));
    client.open(&scn, SCENARIO).await;
    until(&mut client, &scn, 1, "proved").await;
    client.open(&gen_uri, &pump("4 ms")).await;
    until(&mut client, &scn, 1, "proved").await;
    client.change(&gen_uri, 2, json!([{ "text": pump("9.9 ms") }])).await;
    // The number of cores of the first version may come in between.
    let mut seen = Vec::new();
    loop {
        let notification = client.notification(STATUS).await;
        if notification["status"] == "proved" {
            continue;
        }
        assert_eq!(notification["uri"], scn.as_str(), "the specification has a scenario");
        seen.push(notification["status"].as_str().expect("a word").to_owned());
        if notification["status"] == "refuted" {
            break;
        }
    }
    // The number of answered checks may be reported in between.
    seen.dedup();
    // Results of the first version are not repeated for the second.
    assert_eq!(seen, ["stale", "running", "refuted"]);
    assert_eq!(timing(&mut client, &scn).await, ["timing/response-exceeded"]);
    assert_eq!(timing(&mut client, &gen_uri).await, ["timing/response-exceeded"]);

    // A comment changes no result, so nothing is computed again.
    let commented = format!("// é\n{}", pump("9.9 ms"));
    client.change(&gen_uri, 3, json!([{ "text": commented }])).await;
    while client.notification(STATUS).await["status"] != "stale" {}
    assert_eq!(client.notification(STATUS).await["status"], "refuted");
    let report = client.ok("textDocument/diagnostic", document(&gen_uri)).await;
    let items = report["items"].as_array().expect("a list");
    let found = items.iter().find(|json| json["code"] == "timing/response-exceeded");
    assert_eq!(found.expect("it is there")["range"]["start"]["line"], 7, "it has moved");
    client.finish_ignoring(STATUS).await;
}

/// A scenario of any client with three different components: more states than a test can explore.
fn endless() -> String {
    let service = |i: usize| {
        format!(
            "  activity a{i}() {{ task u;\n    codel<start> s{i}(inout level) yield pause::start, ether wcet {} us;\n  }};\n",
            1000 + 7 * i
        )
    };
    let services: String = (0..8).map(service).collect();
    pump("4 ms").replace(
        "  task t {",
        &format!("  task u {{ period 7 ms; codel<start> w(inout level) yield pause::start wcet 1301 us; }};\n{services}  task t {{"),
    )
}

#[tokio::test(flavor = "multi_thread")]
async fn a_verification_is_cancelled_by_an_edit_and_limited_by_the_settings() {
    let folder = Folder::new(&[]);
    let mut params = telling(&folder);
    params["capabilities"]["workspace"]["workspaceEdit"] =
        json!({ "documentChanges": true, "resourceOperations": ["create"] });
    let mut client = Client::start(params).await;
    let uri = folder.uri("pump.gen");
    let patient =
        json!({ "time-limit": 3600, "max-states": 4_000_000_000_u32, "max-memory": 4096 });
    let patient = json!({ "settings": { "dotgen": { "verification": patient } } });
    client.notify("workspace/didChangeConfiguration", patient).await;
    client.open(&uri, &endless()).await;
    while client.notification(STATUS).await["status"] != "running" {}
    // The search for limits does not end either, unless the request is cancelled.
    let mut question = document(&uri);
    question["workDoneToken"] = json!("limits");
    let search = client.begin("dotgen/sensitivity", question).await;
    client.notification("$/progress").await;
    client.notify("$/cancelRequest", json!({ "id": search })).await;
    assert!(client.end(search).await.is_err());
    // The next request does not wait for the end of the first, which is far away.
    let third = "  task rest { codel<start> r() yield pause::start wcet 1 ms; };\n  task w { period 10 ms;\n    codel<start> a(inout level) yield b, pause::start wcet 2 ms;\n    codel<b> b(inout level) yield pause::start wcet 1 ms;\n  };\n  task t {";
    let text = pump("6 ms").replace("  task t {", third);
    client.change(&uri, 2, json!([{ "text": text }])).await;
    until(&mut client, &uri, 2, "proved").await;

    // The text is unchanged, but its answer is not: the stored answer must not be used. With the published
    // semantics and one core only exploration proves the check: each bound counts a job of every other task.
    let verification = json!({ "max-states": 3, "semantics": "published" });
    let settings = json!({ "verification": verification, "timing": { "cores": 1 } });
    let limits = json!({ "settings": { "dotgen": settings } });
    client.notify("workspace/didChangeConfiguration", limits).await;
    // The number of cores may still arrive before.
    while client.notification(STATUS).await["status"] != "gave-up" {}
    let titles = lenses(&mut client, &uri).await;
    assert!(titles.iter().any(|title| title.starts_with("? not settled")), "{titles:?}");
    // The diagnostic names a remedy, and its fix applies that.
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    let items = report["items"].as_array().expect("a list").iter();
    let told: Vec<&Value> = items.filter(|json| json["code"] == "timing/gave-up").collect();
    let [told] = told[..] else {
        panic!("one for all tasks: {told:?}");
    };
    let message = told["message"].as_str().expect("text");
    assert!(
        message.contains("not settled within the limit of states; explore less: "),
        "{message}"
    );
    let mut question = document(&uri);
    question["range"] = told["range"].clone();
    question["context"] = json!({ "diagnostics": [told] });
    let actions = client.ok("textDocument/codeAction", question).await;
    let mut actions = actions.as_array().expect("a list").iter();
    let write =
        actions.find(|action| action["title"] == "Write the verification scenario to pump.scn");
    let write = write.expect("a fix");
    assert_eq!(write["kind"], "quickfix");
    assert_eq!(write["diagnostics"][0]["code"], "timing/gave-up");
    client.finish_ignoring(STATUS).await;
}

/// A lamp and a pump, of which not every check can be settled in the time of a test.
fn lamp(wcet: &str) -> String {
    let lamp = "component lamp {\n  ids { long light; };\n  task blink { period 8 ms;\n    codel<start> toggle(inout light) yield pause::start wcet 1 ms;\n  };\n};\n";
    format!("{}{}", lamp.replace("1 ms", wcet), endless())
}

fn lamp_and_pump() -> String {
    let send: Vec<String> = (0..8).map(|i| format!("{{ send pump.a{i}; }}")).collect();
    format!(
        "scenario tank {{\n  use \"lamp.gen\"; semantics published;\n  client any {{ repeat * {{ delay [0,*] ms; choice {} }} }}\n  check schedulable lamp.blink;\n  check response lamp.blink;\n  check wrong: always not lamp.blink;\n  check limit: within pump.a0.run => pump.a0.void <= 1 s;\n}}\n",
        send.join(" or ")
    )
}

/// Waits until `number` checks of a specification's version are answered.
async fn answered(client: &mut Client, number: u64) -> Value {
    loop {
        let notification = client.notification(STATUS).await;
        assert!(notification["answered"].as_u64() <= Some(number), "{notification}");
        if notification["answered"].as_u64() == Some(number) {
            return notification;
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn answers_are_shown_as_they_are_found() {
    let folder = Folder::new(&[("lamp.scn", &lamp_and_pump())]);
    let mut client = Client::start(telling(&folder)).await;
    let patient =
        json!({ "time-limit": 3600, "max-states": 4_000_000_000_u32, "max-memory": 4096 });
    let patient = json!({ "settings": { "dotgen": { "verification": patient } } });
    client.notify("workspace/didChangeConfiguration", patient).await;
    let (gen_uri, scn) = (folder.uri("lamp.gen"), folder.uri("lamp.scn"));
    client.open(&gen_uri, &lamp("1 ms")).await;
    client.open(&scn, &lamp_and_pump()).await;
    let said = answered(&mut client, 3).await;
    let words = (&said["status"], &said["checks"], &said["states"]);
    assert_eq!(words, (&json!("running"), &json!(4), &Value::Null));

    // Each check separately; a refuted one is a diagnostic at once.
    assert_eq!(
        lenses(&mut client, &scn).await,
        [
            "verifying … · 3 of 4 checks answered",
            "proved",
            "1 ms · proved",
            "refuted",
            "verifying …"
        ]
    );
    assert_eq!(timing(&mut client, &scn).await, ["timing/check-failed"]);
    let titles = lenses(&mut client, &gen_uri).await;
    let of_lamp = "✓ 1 of 8 ms".to_owned();
    assert!(titles.contains(&of_lamp), "{titles:?}");

    // The same for a panel, which receives the version of the text.
    let answer = client.ok("dotgen/verification", document(&scn)).await;
    assert_eq!((&answer["status"], &answer["earlier"]), (&json!("running"), &json!(false)));
    assert_eq!(answer["howFar"], "3 of 4 checks answered");
    assert_eq!(answer["checks"][3]["verdict"], "open");
    assert_eq!(answer["run"]["check"], 2, "the run that refutes it");
    let codels = answer["codels"].as_array().expect("a list").iter();
    let mut odd = codels.filter(|codel| codel["path"] == "pump.a1.start");
    assert_eq!(odd.next().expect("it has one")["wcet"], 1007.0);

    // An edit makes all answers stale at once, and none is reported for the new text.
    client.change(&gen_uri, 2, json!([{ "text": lamp("9.9 ms") }])).await;
    let said = client.notification(STATUS).await;
    let words = (&said["status"], &said["answered"]);
    assert_eq!(words, (&json!("stale"), &Value::Null));
    assert_eq!(timing(&mut client, &scn).await, [""; 0]);
    // As many lenses as with answers: the lines of the editor stay.
    assert_eq!(lenses(&mut client, &scn).await, ["verifying …"; 5]);
    let titles = lenses(&mut client, &gen_uri).await;
    assert!(!titles.contains(&of_lamp), "{titles:?}");
    let answer = client.ok("dotgen/verification", document(&scn)).await;
    assert_eq!(answer["earlier"], true);
    let said = client.notification(STATUS).await;
    let words = (&said["status"], &said["answered"]);
    assert_eq!(words, (&json!("running"), &Value::Null));
    answered(&mut client, 3).await;
    let titles = lenses(&mut client, &gen_uri).await;
    let missed = |text: &&String| text.starts_with("✗ can be late");
    assert_eq!(titles.iter().filter(missed).count(), 1, "{titles:?}");
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_answer_has_everything_a_panel_needs() {
    let folder = Folder::new(&[("pump.gen", &pump("4 ms"))]);
    let mut client = Client::start(telling(&folder)).await;
    let scn = folder.uri("pump.scn");
    client.open(&scn, SCENARIO).await;
    until(&mut client, &scn, 1, "proved").await;
    let answer = client.ok("dotgen/verification", document(&scn)).await;
    assert_eq!(answer["status"], "proved");
    assert_eq!(answer["written"], true);
    assert_eq!(answer["platform"], "2 cores, policy fifo, durations interval, semantics published");
    let checks = answer["checks"].as_array().expect("a list");
    assert_eq!(checks.len(), 3);
    assert_eq!(checks[2]["value"], "4 ms");
    assert_eq!(checks[2]["slack"], "50 %");
    assert_eq!(checks[2]["location"]["range"]["start"]["line"], 4);
    let blocking = answer["blocking"].as_array().expect("a list");
    let of = |codel: &str| blocking.iter().find(|json| json["codel"] == codel);
    let by = &of("pump.fast.start").expect("it shares data")["by"][0];
    assert_eq!(by["through"], "`level` of the ids");
    let events = answer["run"]["events"].as_array().expect("a list");
    let places = events.iter().map(|event| &event["location"]["uri"]);
    assert!({ places }.any(|place| *place == folder.uri("pump.gen")), "{events:?}");

    // A longer codel, only for this request.
    let mut question = document(&scn);
    question["whatIf"] = json!({ "cores": 1, "wcet": { "pump.t.main": 12000.0 } });
    question["check"] = json!(1);
    let answer = client.ok("dotgen/verification", question.clone()).await;
    assert_eq!((&answer["status"], &answer["whatIf"]), (&json!("refuted"), &json!(true)));
    assert_eq!(answer["platform"], "1 core, policy fifo, durations interval, semantics published");
    assert_eq!(answer["run"]["check"], 1);
    assert_eq!(timing(&mut client, &scn).await, [""; 0], "the text is as it was");
    question["whatIf"]["cores"] = json!("many");
    let answer = client.ok("dotgen/verification", question).await;
    assert_eq!(answer["status"], "blocked");
    assert!(answer["errors"][0].as_str().expect("why").contains("`many`"));
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn limits_are_looked_for_with_progress() {
    let folder = Folder::new(&[("pump.gen", &pump("4 ms"))]);
    let mut client = Client::start(telling(&folder)).await;
    let scn = folder.uri("pump.scn");
    client.open(&scn, SCENARIO).await;
    until(&mut client, &scn, 1, "proved").await;
    let mut question = document(&scn);
    question["workDoneToken"] = json!("limits");
    let answer = client.ok("dotgen/sensitivity", question.clone()).await;
    assert_eq!(answer["cores"], "1");
    let codels = answer["wcet"].as_array().expect("a list");
    let main = codels.iter().find(|codel| codel["of"] == "pump.t.main");
    let main = main.expect("it has a WCET");
    assert_eq!(main["now"], "4 ms");
    assert_eq!(main["extreme"], "9.9 ms");
    assert_eq!(main["location"]["uri"], folder.uri("pump.gen"));
    let period = &answer["period"][0];
    assert_eq!(period["remark"], "not known to be the limit");
    let told = client.notification("$/progress").await;
    assert_eq!(told["token"], "limits");
    assert_eq!(told["value"]["message"], "the number of cores");
    while client.notification("$/progress").await["value"]["percentage"] != 85 {}

    question["whatIf"] = json!({ "cores": "many" });
    let answer = client.ok("dotgen/sensitivity", question).await;
    let why = answer["errors"][0].as_str().expect("why");
    assert!(why.contains("`many`"), "{why}");
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_default_scenario_can_be_written_out() {
    let folder = Folder::new(&[]);
    let mut params = telling(&folder);
    params["capabilities"]["workspace"]["workspaceEdit"] =
        json!({ "documentChanges": true, "resourceOperations": ["create"] });
    params["capabilities"]["textDocument"]["codeAction"] =
        json!({ "codeActionLiteralSupport": { "codeActionKind": { "valueSet": [] } } });
    let mut client = Client::start(params).await;
    let uri = folder.uri("pump.gen");
    client.open(&uri, &pump("4 ms")).await;
    until(&mut client, &uri, 1, "proved").await;
    let answer = client.ok("dotgen/verification", document(&uri)).await;
    assert_eq!(answer["written"], false);
    let mut question = document(&uri);
    let place = json!({ "line": 0, "character": 12 });
    question["range"] = json!({ "start": place, "end": place });
    // The panel of the extension asks for this kind alone.
    let kind = "refactor.rewrite.scenario";
    question["context"] = json!({ "diagnostics": [], "only": [kind] });
    let actions = client.ok("textDocument/codeAction", question).await;
    assert_eq!(actions.as_array().map(Vec::len), Some(1), "{actions}");
    let write = &actions[0];
    assert_eq!(write["kind"], kind);
    assert_eq!(write["title"], "Write the verification scenario to pump.scn");
    let edits = &write["edit"]["documentChanges"];
    assert_eq!(edits[0]["kind"], "create");
    let text = edits[1]["edits"][0]["newText"].as_str().expect("text");
    assert!(text.starts_with("scenario pump {\n  use \"pump.gen\";\n"), "{text}");
    let scn = folder.uri("pump.scn");
    client.open(&scn, text).await;
    until(&mut client, &scn, 1, "proved").await;
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn verification_can_be_switched_off() {
    let folder = Folder::new(&[]);
    let mut client = Client::start(telling(&folder)).await;
    let uri = folder.uri("pump.gen");
    client.open(&uri, &pump("12 ms")).await;
    until(&mut client, &uri, 1, "refuted").await;
    let off = json!({ "settings": { "dotgen": { "verification": { "enable": false } } } });
    client.notify("workspace/didChangeConfiguration", off).await;
    assert_eq!(timing(&mut client, &uri).await, [""; 0]);
    // On request the document is verified all the same.
    let answer = client.ok("dotgen/verification", document(&uri)).await;
    assert_eq!(answer["status"], "refuted");
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_refreshes_what_shows_it_and_no_colours() {
    let refreshes = [
        "workspace/diagnostic/refresh",
        "workspace/codeLens/refresh",
        "workspace/semanticTokens/refresh",
    ];
    let folder = Folder::new(&[]);
    let mut params = telling(&folder);
    params["capabilities"]["workspace"] = json!({
        "diagnostics": { "refreshSupport": true },
        "codeLens": { "refreshSupport": true },
        "semanticTokens": { "refreshSupport": true },
    });
    let answers = refreshes.map(|text| (text, Value::Null)).to_vec();
    let mut client = Client::start_answering(params, answers).await;
    let uri = folder.uri("pump.gen");
    client.open(&uri, &pump("4 ms")).await;
    until(&mut client, &uri, 1, "proved").await;
    for (version, slow, status) in [(2, "12 ms", "refuted"), (3, "4 ms", "proved")] {
        let text = json!([{ "text": pump(slow) }]);
        client.change(&uri, version, text).await;
        until(&mut client, &uri, i64::from(version), status).await;
    }
    let asked = |client: &Client, what: &str| {
        let all = client.asked.iter();
        all.filter(|message| message["method"] == what).count()
    };
    let [diagnostics, lens, colours] = refreshes;
    // Every answer, and every edit that made an answer stale.
    while asked(&client, diagnostics) < 5 || asked(&client, lens) < 5 {
        lenses(&mut client, &uri).await;
    }
    assert!(asked(&client, colours) <= 1, "only once the folder was read");
    client.finish_ignoring(STATUS).await;
}
