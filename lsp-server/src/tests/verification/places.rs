//! The places at which assumptions, errors and answers of a verification are shown.

use serde_json::{Value, json};

use super::{SCENARIO, STATUS, lenses, pump, telling, until, untimed};
use crate::tests::client::{Client, Folder, document};

#[tokio::test(flavor = "multi_thread")]
async fn what_is_assumed_stands_at_the_use_of_the_specification() {
    let folder = Folder::new(&[("pump.gen", &untimed("4 ms"))]);
    let mut params = telling(&folder);
    params["capabilities"]["textDocument"]["publishDiagnostics"] =
        json!({ "relatedInformation": true });
    let mut client = Client::start(params).await;
    let (uri, scn) = (folder.uri("pump.gen"), folder.uri("pump.scn"));
    client.open(&scn, SCENARIO).await;
    until(&mut client, &scn, 1, "conditional").await;
    let report = client.ok("textDocument/diagnostic", document(&scn)).await;
    let items = report["items"].as_array().expect("a list");
    let [found] = &items[..] else {
        panic!("once: {report:#}");
    };
    assert_eq!(found["code"], "timing-no-wcet");
    assert_eq!(found["range"]["start"]["line"], 1, "the `use`");
    let message = found["message"].as_str().expect("text");
    assert!(message.starts_with("2 codels have no `wcet`"), "{message}");
    let related = found["relatedInformation"].as_array().expect("places");
    let lines = related.iter().map(|related| {
        assert_eq!(related["location"]["uri"], uri.as_str());
        related["location"]["range"]["start"]["line"].as_u64()
    });
    assert_eq!(lines.collect::<Vec<_>>(), [Some(3), Some(4)]);
    // In the specification itself, only analysis reports it.
    client.open(&uri, &untimed("4 ms")).await;
    until(&mut client, &scn, 1, "conditional").await;
    let said = client.pulled(&uri).await;
    let of_wcet = said.iter().filter(|text| text.contains("wcet"));
    assert_eq!(of_wcet.collect::<Vec<_>>(), ["timing/missing-wcet", "timing/missing-wcet"]);
    // No word is green.
    let mut titles = lenses(&mut client, &scn).await;
    titles.extend(lenses(&mut client, &uri).await);
    let verdict = "? 2 codels without wcet: 4 of 8 ms";
    assert!(titles.iter().any(|title| title.starts_with("conditional · ")), "{titles:?}");
    assert!(titles.iter().any(|title| title.contains(verdict)), "{titles:?}");
    let mut at = document(&uri);
    at["position"] = json!({ "line": 2, "character": 7 });
    let hover = client.ok("textDocument/hover", at).await;
    let answer = client.ok("dotgen/verification", document(&scn)).await;
    for text in [format!("{titles:?}"), hover.to_string(), answer.to_string()] {
        assert!(!text.contains("proved") && !text.contains('✓'), "{text}");
        assert!(text.contains("conditional"), "{text}");
    }
    let condition = answer["checks"][0]["condition"].as_str().expect("a sentence");
    assert!(
        condition.contains("pump.fast.start, pump.fast.main have no `wcet` and count"),
        "{condition}"
    );
    let off = json!({ "settings": { "dotgen": { "severity": { "timing-no-wcet": "off" } } } });
    client.notify("workspace/didChangeConfiguration", off).await;
    until(&mut client, &scn, 1, "conditional").await;
    assert_eq!(client.pulled(&scn).await, [""; 0]);
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_prevents_a_verification_stands_in_the_specification() {
    let folder = Folder::new(&[]);
    let mut client = Client::start(telling(&folder)).await;
    let uri = folder.uri("pump.gen");
    let zero = pump("4 ms").replacen("period 10 ms", "period 0 ms", 1);
    client.open(&uri, &zero).await;
    until(&mut client, &uri, 1, "blocked").await;
    let report = client.ok("textDocument/diagnostic", document(&uri)).await;
    let items = report["items"].as_array().expect("a list").iter();
    let error = items.clone().find(|json| json["code"] == "scn-zero-period");
    let range = &error.expect("it is an error")["range"]["start"];
    assert_eq!((&range["line"], &range["character"]), (&json!(2), &json!(14)));
    // Without a scenario file, the diagnostics of analysis are sufficient.
    client.change(&uri, 2, json!([{ "text": pump("4 ms") }])).await;
    until(&mut client, &uri, 2, "proved").await;
    let said = client.pulled(&uri).await;
    assert!(said.iter().all(|said| !said.starts_with("timing-")), "{said:?}");
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_was_given_up_names_the_setting_to_raise() {
    let folder = Folder::new(&[("pump.gen", &untimed("6 ms"))]);
    let mut client = Client::start(telling(&folder)).await;
    let limits = json!({ "settings": { "dotgen": { "verification": { "max-states": 3 } } } });
    client.notify("workspace/didChangeConfiguration", limits).await;
    let scn = folder.uri("pump.scn");
    let scenario = SCENARIO.replace("check limit:", "check deadlock; check limit:");
    client.open(&scn, &scenario).await;
    until(&mut client, &scn, 1, "gave-up").await;
    let report = client.ok("textDocument/diagnostic", document(&scn)).await;
    let items = report["items"].as_array().expect("a list").iter();
    let mut gave_up = items.filter(|json| json["code"] == "timing/gave-up");
    let message = gave_up.next().expect("one of them")["message"].clone();
    let message = message.as_str().expect("text");
    assert!(
        message.contains(
            " is not settled within the limit of states; raise `verification.max-states` in \
            the settings, or "
        ),
        "{message}"
    );
    let answer = client.ok("dotgen/verification", document(&scn)).await;
    let advice = answer["advice"].as_str().expect("text");
    assert!(advice.starts_with("raise `verification.max-states` in the settings, or "), "{advice}");
    // An assumption is not an error, and links to the codels.
    assert_eq!(answer["errors"], json!([]));
    let warning = &answer["warnings"][0];
    let text = warning["message"].as_str().expect("text");
    assert!(text.starts_with("2 codels have no `wcet`"), "{text}");
    assert_eq!(warning["location"]["uri"], folder.uri("pump.gen"));
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn each_check_is_answered_where_it_is_written() {
    let folder = Folder::new(&[("pump.gen", &pump("4 ms"))]);
    let mut client = Client::start(telling(&folder)).await;
    let scn = folder.uri("pump.scn");
    let text = "scenario tank {\n  use \"pump.gen\";\n  check response pump.t <= 10 ms;\n  check response pump.t <= 2 ms;\n}\n";
    client.open(&scn, text).await;
    until(&mut client, &scn, 1, "refuted").await;
    let report = client.ok("textDocument/diagnostic", document(&scn)).await;
    let exceeded = report["items"].as_array().expect("a list").iter();
    let exceeded = exceeded.filter(|json| json["code"] == "timing/response-exceeded");
    let lines: Vec<&Value> = exceeded.map(|json| &json["range"]["start"]["line"]).collect();
    assert_eq!(lines, [3], "{report}");
    let lenses = client.ok("textDocument/codeLens", document(&scn)).await;
    let mut titles: Vec<(u64, &str)> = Vec::new();
    for lens in lenses.as_array().expect("a list") {
        let line = lens["range"]["start"]["line"].as_u64().expect("a line");
        titles.push((line, lens["command"]["title"].as_str().expect("text")));
    }
    let of = |line| titles.iter().find(|title| title.0 == line).map(|title| title.1);
    assert_eq!((of(2), of(3)), (Some("4 ms · proved"), Some("4 ms · refuted")));
    client.finish_ignoring(STATUS).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn without_execution_times_no_lens_is_green() {
    let text = "component pump {\n  task t { period 10 ms;\n    codel<start> f() yield pause::start;\n  };\n};\n";
    let folder = Folder::new(&[("pump.gen", text)]);
    let mut client = Client::start(telling(&folder)).await;
    let (uri, scn) = (folder.uri("pump.gen"), folder.uri("pump.scn"));
    let scenario =
        "scenario s {\n  use \"pump.gen\";\n  check schedulable *;\n  check response *;\n}\n";
    client.open(&scn, scenario).await;
    until(&mut client, &scn, 1, "nothing").await;
    client.open(&uri, text).await;
    until(&mut client, &scn, 1, "nothing").await;
    let mut titles = lenses(&mut client, &scn).await;
    let of_tasks = lenses(&mut client, &uri).await;
    titles.extend(of_tasks.clone());
    let nothing = titles.iter().filter(|title| title.contains("nothing to verify"));
    assert!(nothing.count() >= 3, "{titles:?}");
    let green = |text: &String| text.contains("proved") || text.contains('✓');
    assert!(!titles.iter().any(green), "{titles:?}");
    // A task without a lens has none while its new text is verified.
    client.change(&uri, 2, json!([{ "text": format!("// new\n{text}") }])).await;
    assert_eq!(lenses(&mut client, &uri).await, of_tasks);
    client.finish_ignoring(STATUS).await;
}
