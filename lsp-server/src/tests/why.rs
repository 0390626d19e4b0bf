//! The causes of missed deadlines, their remedies, and the run step by step, over the protocol.

use serde_json::{Value, json};

use super::client::{Client, Folder, document, pulling};

const STATUS: &str = "dotgen/verificationStatus";

const LIFT: &str = "component lift {
  ids { double level; };
  task control { period 10 ms;
    codel<start> steer(inout level) yield pause::start wcet 3 ms;
  };
  task report { period 20 ms;
    codel<start> tell(in level) yield pause::start wcet 8 ms;
  };
};
";

const SCENARIO: &str = "scenario ride {
  use \"lift.gen\"; semantics published;
  cores 2;
  check schedulable *;
}
";

/// The server with both files open, after it has found the remedy.
async fn start() -> (Client, Folder, String) {
    start_with(LIFT).await
}

async fn start_with(lift: &str) -> (Client, Folder, String) {
    let folder = Folder::new(&[("lift.gen", lift), ("ride.scn", SCENARIO)]);
    let mut params = folder.params(pulling());
    params["initializationOptions"] = json!({ "verificationStatus": true });
    params["capabilities"]["workspace"]["workspaceEdit"] = json!({ "documentChanges": true });
    let mut client = Client::start(params).await;
    let uri = folder.uri("lift.gen");
    client.open(&uri, lift).await;
    client.open(&folder.uri("ride.scn"), SCENARIO).await;
    loop {
        let notification = client.notification(STATUS).await;
        if notification["status"] == "refuted" {
            break;
        }
    }
    (client, folder, uri)
}

/// The diagnostic of `control` with its remedy, which is found after the answer. The request is repeated,
/// because the notification of the remedy may arrive before the answer to the previous request.
async fn problem(client: &mut Client, uri: &str) -> Value {
    for _ in 0..100_000 {
        let report = client.ok("textDocument/diagnostic", document(uri)).await;
        let all = report["items"].as_array().cloned().unwrap_or_default();
        let missed = |json: &&Value| json["code"] == "timing/deadline-miss";
        let found = all.iter().find(missed).cloned().unwrap_or_default();
        let helps = found["message"].as_str().unwrap_or_default();
        if helps.contains("it holds if") {
            return found;
        }
        tokio::task::yield_now().await;
    }
    panic!("no remedy is found");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_missed_deadline_says_why_and_what_would_help_and_the_fix_makes_it_hold() {
    let (mut client, _folder, uri) = start().await;
    let problem = problem(&mut client, &uri).await;
    let message = problem["message"].as_str().expect("text");
    let (cause, remedy) = (
        "`control` waits 8 ms for `level` of the ids, held by `tell`",
        "it holds if `tell` takes at most 6.8 ms",
    );
    assert!(message.contains(cause) && message.contains(remedy), "{message}");
    let answer = client.ok("dotgen/verification", document(&uri)).await;
    let all = format!(
        "{cause}; executes `steer` for 2 ms: together 10 ms, and the job has not ended when its next tick comes"
    );
    assert_eq!(answer["checks"][0]["cause"], all.as_str());
    assert_eq!(answer["checks"][0]["remedy"], remedy);

    let mut params = document(&uri);
    params["range"] = problem["range"].clone();
    params["context"] = json!({ "diagnostics": [], "only": ["quickfix"] });
    let actions = client.ok("textDocument/codeAction", params).await;
    let of_remedy = |json: &&Value| {
        let title = json["title"].as_str().unwrap_or_default();
        title == "Give `lift.report.start` a budget of 6.8 ms, with which this holds"
    };
    let found = actions.as_array().into_iter().flatten().find(of_remedy);
    let action = found.unwrap_or_else(|| panic!("{actions}"));
    let edit = &action["edit"]["documentChanges"][0]["edits"][0];
    assert_eq!(edit["newText"], "6800 us /* budget */");
    assert_eq!(edit["range"]["start"]["line"], 6);
    client.change(&uri, 2, json!([edit_of(edit)])).await;
    loop {
        let notification = client.notification(STATUS).await;
        if notification["status"] == "proved" {
            break;
        }
        assert!(notification["status"] != "gave-up", "{notification}");
    }
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_time_of_a_pragma_gets_its_budget_there() {
    let lift = format!("{}#pragma wcet tell 8 ms\n", LIFT.replace(" wcet 8 ms", ""));
    let (mut client, _folder, uri) = start_with(&lift).await;
    let problem = problem(&mut client, &uri).await;
    let mut params = document(&uri);
    params["range"] = problem["range"].clone();
    params["context"] = json!({ "diagnostics": [], "only": ["quickfix"] });
    let actions = client.ok("textDocument/codeAction", params).await;
    let found = actions.as_array().into_iter().flatten().find(|json| {
        let title = json["title"].as_str().unwrap_or_default();
        title.starts_with("Give `lift.report.start` a budget of 6.8 ms")
    });
    let action = found.unwrap_or_else(|| panic!("{actions}"));
    let edit = &action["edit"]["documentChanges"][0]["edits"][0];
    assert_eq!((&edit["newText"], &edit["range"]["start"]["line"]), (&json!("6800 us"), &json!(9)));
    client.finish_ignoring(STATUS).await;
}

/// Other repairs come after the remedy, as fixes of the same diagnostic.
#[tokio::test(flavor = "multi_thread")]
async fn other_changes_that_make_it_hold_are_fixes_too() {
    let (mut client, _folder, uri) = start().await;
    let problem = problem(&mut client, &uri).await;
    let mut params = document(&uri);
    params["range"] = problem["range"].clone();
    params["context"] = json!({ "diagnostics": [], "only": ["quickfix"] });
    let mut found = None;
    for _ in 0..100_000 {
        let actions = client.ok("textDocument/codeAction", params.clone()).await;
        let of_period = |json: &&Value| {
            let title = json["title"].as_str().unwrap_or_default();
            title.starts_with("Set the period of `lift.control` to ")
        };
        let all = actions.as_array().into_iter().flatten();
        found = { all }.find(of_period).cloned();
        if found.is_some() {
            break;
        }
        tokio::task::yield_now().await;
    }
    let action = found.expect("a longer period repairs it");
    let edit = &action["edit"]["documentChanges"][0]["edits"][0];
    assert_eq!(edit["range"]["start"]["line"], 2);
    let answer = client.ok("dotgen/verification", document(&uri)).await;
    let repairs = answer["repairs"].as_array().expect("a list").iter();
    let repairs: Vec<&str> = repairs.filter_map(Value::as_str).collect();
    assert!(
        repairs
            .iter()
            .any(|repair| repair.contains("`steer` and `tell` do not wait for each other")
                || repair.contains("`tell` and `steer` do not wait for each other")),
        "{repairs:?}"
    );
    client.change(&uri, 2, json!([edit_of(edit)])).await;
    loop {
        let notification = client.notification(STATUS).await;
        if notification["status"] == "proved" {
            break;
        }
        assert!(notification["status"] != "gave-up", "{notification}");
    }
    client.finish_ignoring(STATUS).await;
}

fn edit_of(edit: &Value) -> Value {
    json!({ "range": edit["range"], "text": edit["newText"] })
}

#[tokio::test(flavor = "multi_thread")]
async fn the_run_comes_as_data_with_its_places() {
    let (mut client, _folder, uri) = start().await;
    let trace = client.ok("dotgen/trace", document(&uri)).await;
    assert_eq!((&trace["format"], &trace["unit"]), (&json!(1), &json!("ms")));
    let names = trace["lanes"].as_array().into_iter().flatten();
    let names: Vec<&str> = names.filter_map(|name| name["name"].as_str()).collect();
    assert!(names.ends_with(&["lift.control", "lift.report", "lift locks"]), "{names:?}");
    let spans = trace["spans"].as_array().expect("a list");
    let wait = spans.iter().find(|span| span["kind"] == "wait-lock");
    let wait = wait.unwrap_or_else(|| panic!("{trace}"));
    let holder = &wait["by"][0];
    assert_eq!(holder["name"], "report.start");
    assert_eq!(holder["through"], json!(["`level` of the ids"]));
    let step = &trace["steps"][wait["step"].as_u64().expect("a step") as usize];
    assert_eq!(step["rule"], "wait");
    assert!(trace["rules"]["wait"].as_str().is_some_and(|wait| wait.contains("excludes")));
    let place = &trace["places"][step["place"].as_u64().expect("a place") as usize];
    assert_eq!(place["uri"], uri.as_str());
    assert_eq!(place["range"]["start"]["line"], 3);
    // The missed deadline is at the end, in the lane of the task.
    assert_eq!(trace["focus"]["at"], trace["end"]);
    assert_eq!(
        trace["lanes"][trace["focus"]["lane"].as_u64().expect("a lane") as usize]["name"],
        "lift.control"
    );
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_run_goes_on_with_chosen_steps() {
    let (mut client, _folder, uri) = start().await;
    let whole = client.ok("dotgen/trace", document(&uri)).await;
    assert!(whole.get("next").is_none());
    let asked = |take: &[usize]| {
        let mut document = document(&uri);
        document["after"] = json!(3);
        document["take"] = json!(take);
        document
    };
    let first = client.ok("dotgen/trace", asked(&[])).await;
    let steps = |json: &Value| json["steps"].as_array().expect("a list").clone();
    assert!(steps(&first).len() < steps(&whole).len());
    assert_eq!(steps(&whole)[..4], steps(&first)[..4]);
    let choices = first["next"]["choices"].as_array().expect("a list");
    assert!(choices.iter().all(serde_json::Value::is_string) && !choices.is_empty());
    let taken = client.ok("dotgen/trace", asked(&[choices.len() - 1])).await;
    assert_eq!(taken["next"]["taken"], json!([steps(&first).len()]));
    assert!(taken["title"].as_str().expect("a title").ends_with("with chosen steps"));
    client.finish_ignoring(STATUS).await;
}
