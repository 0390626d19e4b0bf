//! Requests that every component accepts, and outcomes of requests.

use dotgen_timing::report::{Report, Value, Verdict};
use dotgen_timing::scn::complete::{Completions, complete};
use dotgen_timing::scn::{format, parse};
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::scenario::load;

/// `t` stops for 3 ms; `walk` pauses for ever and stops for 2 ms, `fail` may throw, `cut` has no `stop`.
const ROBOT: &str = "component r {
  version \"1\"; lang \"c\"; ids { long map; }; exception bad;
  task t { period 10 ms;
    codel<start> a() yield pause::start wcet 1 ms;
    codel<stop> z() yield ether wcet 3 ms;
  };
  task u { period 10 ms; };
  activity walk() { task u;
    codel<start> w() yield pause::start wcet 1 ms;
    codel<stop> ws() yield ether wcet 2 ms;
  };
  activity fail() { task u; throw bad; codel<start> f() yield ether wcet 1 ms; };
  activity cut() { task u; codel<start> c() yield pause::start wcet 1 ms; };
};";

fn report(items: &str) -> Report {
    let unit = load(ROBOT);
    let parsed = parse(&format!("scenario s {{ unit 1 ms; durations fixed; {items} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let (options, cancel) = (Options::default(), Cancel::default());
    verify(&input, &parsed.scenario, &options, &cancel)
}

/// Returns verdicts and times, in order.
fn answers(items: &str) -> Vec<(Verdict, Option<Value>)> {
    let report = report(items);
    assert!(!report.has_errors(), "{:?}", report.diagnostics);
    let checks = report.checks.into_iter();
    checks.map(|check| (check.verdict, check.value)).collect()
}

fn verdicts(items: &str) -> Vec<Verdict> {
    answers(items).into_iter().map(|answer| answer.0).collect()
}

fn messages(items: &str) -> Vec<String> {
    let report = report(items);
    let all = report.diagnostics.into_iter();
    all.map(|diagnostic| format!("{}: {}", diagnostic.code, diagnostic.message)).collect()
}

#[test]
fn a_component_that_is_killed_stops_its_activities_then_its_tasks() {
    let found = verdicts(
        "client k { send r.walk; delay 25 ms; kill r; delay 60 ms; }
         check stops: reachable r.walk.stop.exec;
         check after: reachable r.t.stop.exec;
         check not_together: reachable r.t.stop.exec and not r.walk.void and not r.walk.waiting
           and (r.walk.run or r.walk.stop);
         check ends: eventually k and r.t.idle and r.walk.void;
         check quiet: reachable k and r.t.running;",
    );
    let expected =
        [Verdict::Proved, Verdict::Proved, Verdict::Refuted, Verdict::Proved, Verdict::Refuted];
    assert_eq!(found, expected);
}

#[test]
fn nobody_takes_requests_of_a_component_that_has_ended() {
    let found = verdicts(
        "client k { kill r; delay 100 ms; again: send r.walk; }
         check waits: reachable k.again;
         check taken: reachable k;",
    );
    assert_eq!(found, [Verdict::Proved, Verdict::Refuted]);
}

#[test]
fn an_abort_interrupts_the_last_instance_or_the_one_of_a_label() {
    // The label stands for the first instance: two run, one is aborted, and the other continues.
    let found = verdicts(
        "client k { one: send r.walk; send r.cut; delay 25 ms; abort one; delay 40 ms; }
         check stopped: reachable r.walk.stop.exec;
         check over: reachable k and r.walk.void;
         check stays: reachable k and r.cut.void;",
    );
    assert_eq!(found, [Verdict::Proved, Verdict::Proved, Verdict::Refuted]);
}

#[test]
fn an_abort_of_what_has_ended_fails() {
    let clients = |how: &str| {
        format!(
            "exceptions off; client k {{ send r.fail; await ended; abort r.fail; await ended {how}; }}
             check done: reachable k;"
        )
    };
    assert_eq!(verdicts(&clients("failed")), [Verdict::Proved]);
    assert_eq!(verdicts(&clients("ok")), [Verdict::Refuted]);
}

#[test]
fn a_client_can_depend_on_how_a_request_ends() {
    let client = "client k { send r.fail;
         choice { await ended ok; good: delay 1 ms; } or { await ended failed r.fail; poor: delay 1 ms; } }
         check good: reachable k.good; check poor: reachable k.poor;";
    assert_eq!(verdicts(client), [Verdict::Proved, Verdict::Proved]);
    let without = format!("exceptions off; {client}");
    assert_eq!(verdicts(&without), [Verdict::Proved, Verdict::Refuted]);
}

#[test]
fn what_is_cut_for_want_of_a_stop_codel_has_failed() {
    let client = |how: &str| {
        format!(
            "client k {{ send r.cut; delay 25 ms; abort r.cut; await ended {how} r.cut; }}
             check done: reachable k;"
        )
    };
    assert_eq!(verdicts(&client("failed")), [Verdict::Proved]);
    assert_eq!(verdicts(&client("ok")), [Verdict::Refuted]);
}

#[test]
fn connecting_waits_at_the_head_of_the_queue_and_everybody_behind_it() {
    // The first codel of `u` executes from 10 ms to 11 ms, like that of `t`; the request comes in between or
    // before. The codels share nothing: without the request there is no wait.
    let waits = |request: &str| {
        let items = format!(
            "durations interval; duration r.t.start [5,5] ms;
             client k {{ send r.walk; delay [0,20] ms; {request} }}
             check response r.u;"
        );
        let found = answers(&items);
        found[0].1
    };
    assert_eq!(waits(""), Some(Value::Time(1.0)));
    assert_eq!(waits("connect r;"), Some(Value::Time(6.0)));
}

#[test]
fn the_published_models_have_none_of_it() {
    let found = messages(
        "semantics published; client k { send r.walk; await ended ok; abort r.walk; kill r; connect r; }
         check schedulable *;",
    );
    for word in ["await ended ok", "abort", "kill", "connect"] {
        let told = format!(
            "scn-semantics: the published models have no `{word}`; write `semantics servers;`, or leave \
                this step out"
        );
        assert!(found.contains(&told), "{word}: {found:?}");
    }
}

#[test]
fn the_published_models_know_no_order_of_services() {
    let found = messages("semantics published; order on; check schedulable *;");
    let told = "scn-semantics: the published models know no order of services; write `semantics servers;`, or leave \
                `order on;` out";
    assert!(found.iter().any(|message| message == told), "{found:?}");
    assert!(messages("semantics published; order off; check schedulable *;").is_empty());
}

#[test]
fn completion_offers_requests_and_outcomes() {
    let unit = load(ROBOT);
    let names = dotgen_timing::scn::names::Names::new(&[&unit.spec]);
    let offered = |steps: &str| -> Vec<String> {
        let text = format!("scenario s {{ client k {{ one: send r.walk; {steps}");
        let scenario = parse(&text).scenario;
        match complete(&text, &scenario, &names, text.len()) {
            Completions::Of { items, .. } => {
                items.into_iter().map(|completion| completion.label).collect()
            }
            Completions::File(_) => Vec::new(),
        }
    };
    let has = |steps: &str, labels: &[&str]| {
        let found = offered(steps);
        for label in labels {
            assert!(found.iter().any(|candidate| candidate == label), "{steps}: {found:?}");
        }
    };
    has("", &["abort", "kill", "connect", "await"]);
    has("kill ", &["r"]);
    has("connect ", &["r"]);
    has("abort ", &["one", "r.walk", "r.cut"]);
    has("await ended ", &["ok", "failed", "r.walk"]);
    has("await ended ok ", &["r.walk"]);
    assert!(!offered("abort ").contains(&"r.t".to_owned()));
    assert!(!offered("await ended ok ").contains(&"failed".to_owned()));
}

#[test]
fn formatting_keeps_the_new_steps() {
    let text = "scenario s {\n  client k {\n    one: send r.walk;\n    abort one;\n    await ended failed r.walk;\n    connect r;\n    \
                kill r;\n  }\n}\n";
    assert_eq!(format(&text.replace("\n  ", " ")).as_deref(), Some(text));
}

#[test]
fn only_activities_are_aborted_and_only_components_killed() {
    let found = messages("client k { send r.walk; abort one; } check schedulable *;");
    let told = "scn-abort: `one` is no label of a request of this client; write `abort COMPONENT.ACTIVITY;`, or `one:` \
                before a `send`";
    assert!(found.iter().any(|message| message == told), "{found:?}");
    let found = messages("client k { kill r.walk; } check schedulable *;");
    let told = "scn-wrong-kind: `r.walk` is no component";
    assert!(found.iter().any(|message| message == told), "{found:?}");
}
