//! Scenario language and verification, on small specifications of our own.

mod abstraction;
mod advice;
mod beside;
mod chains;
mod codes;
mod data;
mod findings;
mod invariants;
mod json;
mod language;
mod measures;
mod patterns;
mod quick;
mod requests;
mod simulate;
mod told;
mod vacuous;
mod walks;

use std::collections::BTreeMap;
use std::time::Duration;

use dotgen_analysis::host::UnitResult;
use dotgen_loaders::unit;
use dotgen_timing::derive::{largest_wcet, minimum_cores, smallest_period};
use dotgen_timing::explore::{Kind, Kinds, Stop};
use dotgen_timing::report::{CheckReport, Report, Soundness, Value, Verdict};
use dotgen_timing::scn::ast::{Path, Spanned};
use dotgen_timing::scn::names::Names;
use dotgen_timing::scn::parse;
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::system::build::build;
use dotgen_timing::system::settings::Settings;
use dotgen_timing::system::{SharedPorts, ThreadName};
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

/// The options of these tests: the published models.
fn published() -> Options {
    Options { semantics: Some(Preset::Published), ..Options::default() }
}

fn load(text: &str) -> UnitResult {
    unit(text).expect("a specification without errors")
}

/// A sensor that writes the data that a controller reads; both also log.
const ROBOT: &str = r#"
typedef long scan_data;
component sensor {
  version "1"; lang "c"; 
  ids { long raw; long log; };
  port out scan_data scan;
  task acquire {
    period 10 ms;
    codel <start> init(out raw) yield read wcet 1 ms;
    codel <read> acquire_read(out raw) yield publish wcet 2 ms;
    codel <publish> acquire_publish(in raw, port out scan) yield pause::read wcet 3 ms;
  };
  function reset() { codel reset_raw(out raw) wcet 1 ms; };
  activity record() {
    task acquire;
    codel <start> record_start(in raw) yield pause::start, ether wcet 1 ms;
    codel <stop> record_stop() yield ether wcet 1 ms;
    interrupts record;
  };
};
component control {
  version "1"; lang "c"; 
  ids { long goal; };
  port in scan_data scan;
  task move {
    period 5 ms;
    codel <start> init(out goal) yield step wcet 1 ms;
    codel <step> move_step(in goal, port in scan) yield pause::step wcet 1 ms;
  };
};
"#;

fn robot(items: &str) -> Report {
    let unit = load(ROBOT);
    let parsed = parse(&format!("scenario robot {{ {items} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    verify(&input, &parsed.scenario, &published(), &Cancel::default())
}

fn summary(report: &Report) -> String {
    let mut out = String::new();
    for diagnostic in &report.diagnostics {
        out.push_str(&format!("{}: {}\n", diagnostic.code, diagnostic.message));
    }
    for check in &report.checks {
        let value = check.value.map_or(String::new(), |value| format!(" {value}"));
        out.push_str(&format!("{} {} {:?}{value}\n", check.kind, check.of, check.verdict));
    }
    out
}

#[test]
fn checks_of_tasks() {
    let report = robot("check schedulable *; check no-overdue *; check response *;");
    insta::assert_snapshot!(summary(&report));
}

#[test]
fn one_core_makes_the_fast_task_late() {
    let report =
        robot("cores 1; check schedulable control.move; check response control.move <= 5 ms;");
    insta::assert_snapshot!(runs_in_words(&report));
}

/// Returns the counterexamples line by line, with the causes of the late jobs.
fn runs_in_words(report: &Report) -> String {
    let mut out = String::new();
    for check in &report.checks {
        out += &format!("{:?} {} {}\n", check.verdict, check.kind, check.of);
        for event in check.run() {
            let ThreadName { component, task } = &event.thread;
            let task = task.as_deref().unwrap_or_default();
            out += &format!("{:>4}  {component}.{task}  {}\n", event.time, event.what);
        }
        for delay in &check.reason {
            let codel = delay.codel.as_deref().unwrap_or("the job");
            let held = delay.held.iter().map(|holder| {
                let codel = holder.codel.as_deref().map_or(holder.by.to_string(), str::to_owned);
                format!("{codel} {}-{}", holder.from, holder.until)
            });
            let held: Vec<String> = held.collect();
            let (from, until) = (delay.from, delay.until);
            out += &format!(
                "{codel} waits {from}-{until} for {:?}: {}\n",
                delay.awaited,
                held.join(", ")
            );
        }
    }
    out
}

/// A long activity, a short one, and one without requests.
const JOBS: &str = r#"
component c {
  version "1"; lang "c";
  task t {};
  activity slow() { task t; codel <start> do_slow() yield ether wcet 10 ms; };
  activity quick() { task t; codel <start> do_quick() yield ether wcet 5 ms; };
  activity other() { task t; codel <start> do_other() yield ether wcet 1 ms; };
};
"#;

/// Returns the end of the counterexample of the only check, and its value.
fn excess(check: &str) -> (f64, Option<Value>) {
    let unit = load(JOBS);
    let text = format!(
        "scenario s {{ durations fixed;
           client u {{ choice {{ delay 1 ms; send c.slow; }} or {{ delay 3 ms; send c.quick; }} }}
           check {check}; }}"
    );
    let parsed = parse(&text);
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &parsed.scenario, &published(), &Cancel::default());
    let check = &report.checks[0];
    assert_eq!(check.verdict, Verdict::Refuted, "{}", checks_in_words(&report));
    (check.counterexample.last().unwrap().time, check.value)
}

#[test]
fn a_counterexample_ends_when_the_limit_is_exceeded_first() {
    // The quick activity is over at 8 ms, before the exploration reaches the end of the slow one at 11 ms.
    let time = |number| Some(Value::Time(number));
    assert_eq!(excess("response c.t <= 4 ms"), (6.0, time(10.0)));
    assert_eq!(excess("response c.t <= 6 ms"), (8.0, time(10.0)));
    // No event follows the quick activity: that is known while the slow one still runs.
    let within = "within c.t.running => c.other.run";
    let unbounded = Some(Value::Unbounded);
    assert_eq!(excess(&format!("{within} <= 4 ms")), (6.0, unbounded));
    // Beyond that, a run that exceeds the limit is shown, but not the shortest one.
    assert_eq!(excess(&format!("{within} <= 2 s")), (2004.0, unbounded));
}

#[test]
fn predicates() {
    let report = robot(
        "client user { send sensor.record; await ended; again: send sensor.reset; }
         check reachable sensor.record.run and control.move.running;
         check always not (sensor.acquire.publish.exec and control.move.step.exec);
         check within sensor.record.waiting or sensor.record.run => leave sensor.record.start <= 20 ms;
         check leadsto sensor.record.run => sensor.record.void;
         check eventually sensor.acquire.publish.exec;
         check reachable user.again;
         check deadlock;",
    );
    insta::assert_snapshot!(summary(&report));
}

#[test]
fn a_loop_limit_that_cannot_be_kept_is_explained() {
    let unit = load(
        r#"component c { version "1"; lang "c";
             task t {
               period 5 ms;
               codel <start> begin() yield wait wcet 1 ms;
               codel <wait> do_wait() yield pause::wait, main wcet 1 ms;
               codel <main> do_main() yield wait, pause::main, start wcet 1 ms;
             };
           };"#,
    );
    let input = SystemInput { specs: vec![&unit.spec] };
    let said = |items: &str| {
        let scenario = parse(&format!("scenario x {{ {items} check schedulable *; }}")).scenario;
        let report = verify(&input, &scenario, &published(), &Cancel::default());
        summary(&report)
    };
    insta::assert_snapshot!(format!(
        "{}\n{}\n{}",
        said("loop once c.t;"),
        said("loop 2;"),
        said("")
    ));
}

#[test]
fn slots_are_for_activities_whether_requested_or_not() {
    let report = robot(
        "slots sensor.record 3; slots sensor.recrod 3; slots sensor.reset 3;
         slots sensor.acquire 3; check schedulable *;",
    );
    insta::assert_snapshot!(summary(&report), @"
    scn-unknown-name: `sensor` has nothing called `recrod`; did you mean `record`?
    scn-wrong-kind: `sensor.reset` is neither a task nor an activity, and nothing else has slots; name one, or remove this line
        ");
    let wrong = report.diagnostics.iter().map(|diagnostic| diagnostic.range.len());
    let names = ["recrod", "sensor.reset"];
    assert_eq!(wrong.collect::<Vec<_>>(), names.map(str::len));
}

#[test]
fn orders_of_services_that_are_not_kept_are_an_assumption() {
    let unit = load(
        r#"component c { version "1"; lang "c"; task t {};
             function calibrate() {};
             activity move() { task t; codel <start> go() yield ether wcet 1 ms; after calibrate; };
           };"#,
    );
    let input = SystemInput { specs: vec![&unit.spec] };
    let said = |service: &str| {
        let text = format!("scenario x {{ client u {{ send c.{service}; }} check deadlock; }}");
        let report = verify(&input, &parse(&text).scenario, &published(), &Cancel::default());
        let mut all = report.assumptions.into_iter();
        all.find(|assumption| assumption.starts_with("requests"))
    };
    let expected =
        "requests: `before` and `after` of c.move are not looked at; they are accepted at any time";
    assert_eq!(said("move").as_deref(), Some(expected));
    assert_eq!(said("calibrate"), None);
}

fn path(text: &str) -> Path {
    Path {
        names: text
            .split('.')
            .map(|part| Spanned { value: part.to_owned(), range: 0..0 })
            .collect(),
    }
}

#[test]
fn derived_questions() {
    let unit = load(ROBOT);
    let input = SystemInput { specs: vec![&unit.spec] };
    let scenario = parse("scenario x { check schedulable *; }").scenario;
    let options = published();
    let cancel = Cancel::default();
    let cores = minimum_cores(&input, &scenario, &options, &cancel).unwrap();
    assert_eq!(cores.cores, Some(2));
    assert_eq!(cores.tried, [(1, Verdict::Refuted), (2, Verdict::Proved)]);
    // The other component holds the port for 3 ms: 3 + 1 < 5 with nothing to spare.
    let slack = largest_wcet(&input, &scenario, &options, &path("control.move.step"), &cancel);
    let slack = slack.unwrap();
    assert_eq!((slack.now, slack.exact), (Value::Time(1.0), true));
    insta::assert_debug_snapshot!(slack.extreme);
    let period = smallest_period(&input, &scenario, &options, &path("control.move"), &cancel);
    insta::assert_debug_snapshot!(period.unwrap().extreme);
    assert!(largest_wcet(&input, &scenario, &options, &path("control.move"), &cancel).is_err());
}

#[test]
fn connections_that_make_codels_wait_are_named() {
    let unit = load(ROBOT);
    let names = Names::new(&[&unit.spec]);
    let shared = |items: &str| {
        let settings = Settings::new(&parse(&format!("scenario x {{ {items} }}")).scenario);
        let built = build(&names, &settings, &|_| true);
        let site = |path: &str| {
            let mut codels = built.system.codels.iter();
            codels.find(|codel| *codel.path == *path).unwrap().site.unwrap()
        };
        let (publish, step) = (site("sensor.acquire.publish"), site("control.move.step"));
        let ports = SharedPorts::new(&names, &settings);
        assert_eq!(ports.of(publish, step), ports.of(step, publish));
        assert_eq!(ports.of(publish, publish), [""; 0]);
        (ports.of(publish, step), ports.of(step, step))
    };
    let scan = vec!["sensor.scan → control.scan".to_owned()];
    assert_eq!(shared(""), (scan.clone(), scan));
    assert_eq!(shared("connect control.scan to none;"), (vec![], vec![]));
}

/// Two tasks with ample slack, and a client that never stops.
const CALM: &str = r#"
component calm {
  version "1"; lang "c";
  ids { long a; long b; };
  task t {
    period 20 ms;
    codel <start> init(out a) yield step wcet 1 ms;
    codel <step> t_step(inout a) yield pause::step wcet 2 ms;
  };
  task u {
    period 30 ms;
    codel <start> u_step(in a, out b) yield pause::start wcet 1 ms;
  };
  activity work() { task t; codel <start> w(inout a) yield pause::start, ether wcet 1 ms; };
};
"#;

#[test]
fn analysis_answers_what_exploration_has_to_give_up() {
    let unit = load(CALM);
    let input = SystemInput { specs: vec![&unit.spec] };
    let text = "scenario x { client k { repeat * { delay [0, *] ms; send calm.work; } }
      check schedulable *; check no-overdue *; check response calm.t; check response calm.t <= 2 ms; }";
    let scenario = parse(text).scenario;
    let mut options = published();
    options.limits.states = 1;
    let report = verify(&input, &scenario, &options, &Cancel::default());
    insta::assert_snapshot!(checks_in_words(&report));
    // A check that needs no exploration takes no states.
    let scenario =
        parse(&text.replace("check response calm.t; check response calm.t <= 2 ms;", ""));
    let report = verify(&input, &scenario.scenario, &options, &Cancel::default());
    assert_eq!(report.states, 0);
    assert_eq!(report.notes.len(), 1, "{:?}", report.notes);
}

#[test]
fn what_fails_without_requests_is_found_whatever_clients_may_do() {
    let unit = load(&CALM.replace(
        "t_step(inout a) yield pause::step wcet 2 ms",
        "t_step(inout a) yield pause::step wcet 20 ms",
    ));
    let input = SystemInput { specs: vec![&unit.spec] };
    let text = "scenario x { client k { repeat * { delay [0, *] ms; send calm.work; } }
      check schedulable calm.t; }";
    // Every order of requests would be explored first.
    let mut options = published();
    options.limits.states = 500;
    let report = verify(&input, &parse(text).scenario, &options, &Cancel::default());
    assert_eq!(report.checks[0].verdict, Verdict::Refuted);
    let run = &report.checks[0].counterexample;
    assert!(run.iter().all(|run| !run.what.contains("request")), "{run:?}");
    // A client that has to send at once cannot be left out.
    let text = text.replace("delay [0, *] ms; ", "delay 1 ms; ");
    options.limits.without = options.limits.without.with(Kind::RandomSearch);
    let report = verify(&input, &parse(&text).scenario, &options, &Cancel::default());
    assert_eq!(report.checks[0].verdict, Verdict::Unknown);
    // Random walks do not need the states before.
    options.limits.without = Kinds::NONE;
    let report = verify(&input, &parse(&text).scenario, &options, &Cancel::default());
    assert_eq!(report.checks[0].verdict, Verdict::Refuted);
}

#[test]
fn what_fails_after_one_request_is_found_whatever_clients_may_do() {
    let many: String = (0..8)
        .map(|i| {
            format!(
                "activity a{i}() {{ task t; codel <start> w{i}(inout b) yield pause::start, ether \
            wcet 1 ms; }};"
            )
        })
        .collect();
    let slow = "activity slow() { task t; codel <start> s() yield ether wcet 30 ms; };";
    let unit = load(&CALM.replace("activity work()", &format!("{many} {slow} activity work()")));
    let input = SystemInput { specs: vec![&unit.spec] };
    let services: Vec<String> = (0..8).map(|i| format!("a{i}")).collect();
    let choice: Vec<String> = (services.iter().map(String::as_str))
        .chain(["slow", "work"])
        .map(|service| format!("{{ send calm.{service}; }}"))
        .collect();
    let text = format!(
        "scenario x {{ client k {{ repeat * {{ delay [0, *] ms; choice {} }} }}
          check schedulable calm.t; check response calm.t; }}",
        choice.join(" or ")
    );
    let mut options = published();
    options.limits.states = 5_000;
    let report = verify(&input, &parse(&text).scenario, &options, &Cancel::default());
    let [schedulable, response] = &report.checks[..] else {
        panic!("{}", checks_in_words(&report));
    };
    assert_eq!(schedulable.verdict, Verdict::Refuted);
    let run = &schedulable.counterexample;
    let requests: Vec<&str> =
        (run.iter().map(|run| run.what.as_str())).filter(|run| run.contains("request")).collect();
    assert_eq!(requests, ["takes the request calm.slow of client k"]);
    // The exploration was incomplete: this value is the greatest seen.
    let note = response.note.as_deref().unwrap_or_default();
    assert!(note.contains("is reached"), "{}", checks_in_words(&report));
}

#[test]
fn a_task_that_takes_no_time_needs_no_exploration_to_the_end() {
    let services: String = (0..20)
        .map(|i| {
            format!(
                "activity a{i}() {{ task t; codel <start> w{i}(inout b) yield pause::start, ether; \
            }};"
            )
        })
        .collect();
    let unit = load(&format!(
        "component idle {{ version \"1\"; lang \"c\"; ids {{ long b; }};
           task t {{ codel <start> s(out b) yield wait; codel <wait> w(in b) yield pause::wait, wait; }};
           function other() {{ codel f() wcet 1 ms; }};
           {services} }};"
    ));
    let input = SystemInput { specs: vec![&unit.spec] };
    let choice: Vec<String> = (0..20).map(|i| format!("{{ send idle.a{i}; }}")).collect();
    let text = format!(
        "scenario x {{ client k {{ repeat * {{ delay [0, *] ms; choice {} }} }} check response idle.t; }}",
        choice.join(" or ")
    );
    let report = verify(&input, &parse(&text).scenario, &published(), &Cancel::default());
    assert_eq!(checks_in_words(&report), "response idle.t: Conditional Exact 0 ");
    assert!(report.steps < 200_000, "{} steps", report.steps);
}

fn checks_in_words(report: &Report) -> String {
    let line = |report: &CheckReport| {
        let value = report.value.map(|value| value.to_string()).unwrap_or_default();
        let note = report.note.as_deref().unwrap_or_default();
        let (verdict, soundness) = (report.verdict, report.soundness);
        format!("{} {}: {verdict:?} {soundness:?} {value} {note}", report.kind, report.of)
    };
    let lines: Vec<String> = report.checks.iter().map(line).collect();
    lines.join("\n")
}

#[test]
fn giving_up_is_said() {
    let unit = load(ROBOT);
    let input = SystemInput { specs: vec![&unit.spec] };
    let text = "scenario x { client k { repeat * { delay [0, *] ms; send sensor.reset; } } check deadlock; }";
    let scenario = parse(text).scenario;
    let mut options = published();
    options.limits.states = 1;
    let report = verify(&input, &scenario, &options, &Cancel::default());
    assert!(report.checks.iter().all(|check| check.verdict == Verdict::Unknown));
    let note = report.checks[0].note.as_deref().unwrap();
    assert!(note.starts_with("gave up at"), "{note}");
    let reason = report.checks[0].gave_up.map(|gave_up| gave_up.reason);
    assert_eq!(reason, Some(Stop::States));
    let out_of_time = Cancel::default();
    out_of_time.limit(Duration::ZERO);
    let report = verify(&input, &scenario, &published(), &out_of_time);
    let gave_up = report.checks[0].gave_up.expect("time is up");
    assert_eq!((gave_up.reason, gave_up.seconds), (Stop::Time, Some(0.0)));
    let cancelled = Cancel::default();
    cancelled.abandon();
    let report = verify(&input, &scenario, &published(), &cancelled);
    assert!(report.checks.iter().all(|check| check.note.as_deref() == Some("cancelled")));
}

#[test]
fn a_verification_tells_how_far_it_is() {
    let unit = load(ROBOT);
    let input = SystemInput { specs: vec![&unit.spec] };
    let text = "scenario x { client k { send sensor.record; } check deadlock; check eventually \
        sensor.record; }";
    let cancel = Cancel::default();
    let report = verify(&input, &parse(text).scenario, &published(), &cancel);
    assert!(report.states > 0);
    assert_eq!(cancel.effort().states, report.states);
}

/// Two tasks of 10 ms with a codel of 1 ms each.
const TWO: &str = r#"
component c {
  version "1"; lang "c";
  ids { long x; };
  task t { period 10 ms; codel <start> t_main(inout x) yield pause::start wcet 1 ms; };
  task u { period 10 ms; codel <start> u_main(inout x) yield pause::start wcet 1 ms; };
};
"#;

fn of_two(items: &str) -> Report {
    let unit = load(TWO);
    let parsed = parse(&format!("scenario s {{ {items} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let (options, cancel) = (published(), Cancel::default());
    verify(&input, &parsed.scenario, &options, &cancel)
}

#[test]
fn what_fails_with_rounded_durations_only_is_verified_with_the_exact_ones() {
    let report = of_two("unit 5 ms; check schedulable c.t; check response c.t <= 20 ms;");
    let [late, bounded] = &report.checks[..] else {
        panic!("{}", checks_in_words(&report));
    };
    assert_eq!((late.verdict, late.soundness), (Verdict::Proved, Soundness::Exact));
    // A small system is explored with the exact times at once: nothing was rounded.
    assert_eq!((bounded.verdict, bounded.rounded), (Verdict::Proved, false));
    assert_eq!(report.notes.len(), 0);
    let exact = of_two("unit 1 ms; check schedulable c.t;");
    assert_eq!(exact.checks[0].verdict, Verdict::Proved);
    assert_eq!((exact.checks[0].soundness, exact.notes.len()), (Soundness::Exact, 0));
}

/// A nanosecond beside half a minute is beyond the range of times: only rounded times can be explored.
#[test]
fn what_can_only_be_rounded_proves_what_holds_with_more_runs_and_refutes_nothing() {
    let of = |wcet: &str, durations: &str| {
        let specification = format!(
            "component c {{ version \"1\"; lang \"c\"; task t {{ period 30 s; codel<start> c_t() yield pause::start \
             wcet {wcet}; }}; }};"
        );
        let unit = unit(&specification).expect("a specification");
        let text =
            format!("scenario s {{ unit 1 ms; durations {durations}; check schedulable *; }}");
        let parsed = parse(&text);
        let input = SystemInput { specs: vec![&unit.spec] };
        let report = verify(&input, &parsed.scenario, &published(), &Cancel::default());
        assert!(!report.has_errors(), "{:?}", report.diagnostics);
        let notes = report.notes.iter().filter(|note| note.starts_with("rounded to"));
        (report.checks[0].verdict, notes.count())
    };
    assert_eq!(of("0.000001 ms", "interval"), (Verdict::Proved, 1));
    assert_eq!(of("0.000001 ms", "fixed"), (Verdict::Unknown, 0));
    assert_eq!(of("29999.9999999 ms", "interval").0, Verdict::Unknown);
}

#[test]
fn periods_are_not_rounded() {
    let report = of_two("unit 4 ms; check schedulable *;");
    let errors: Vec<String> =
        report.diagnostics.iter().map(|diagnostic| diagnostic.message.to_string()).collect();
    assert_eq!(
        errors,
        [
            "the period of c.t, 10 ms, is no multiple of the unit of the scenario, 4 ms; write `unit 2 ms;`",
            "the period of c.u, 10 ms, is no multiple of the unit of the scenario, 4 ms; write `unit 2 ms;`"
        ]
    );
    assert!(report.checks.is_empty());
}

#[test]
fn without_execution_times_nothing_is_proved() {
    let unit = load(&TWO.replace(" wcet 1 ms", ""));
    let scenario =
        "scenario s { check schedulable *; check response *; check always not c.t.start.lock; }";
    let parsed = parse(scenario);
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &parsed.scenario, &published(), &Cancel::default());
    let (tasks, predicate) = report.checks.split_at(4);
    for task in tasks {
        assert_eq!((task.verdict, task.value, task.slack()), (Verdict::Nothing, None, None));
        let note = task.note.as_deref().unwrap_or_default();
        assert!(note.contains("c.t.start, c.u.start") && note.contains("`wcet`"), "{note}");
    }
    // Checks that do not depend on times are answered.
    assert_ne!(predicate[0].verdict, Verdict::Nothing);
    assert!(report.nothing());
}
