//! Findings besides the answers: codels that block others, requests that end each other, loops; and the
//! soundness of answers under preemption.

use dotgen_timing::diagnostic::remark::Remark;
use dotgen_timing::report::{Report, Soundness, Value, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, SystemInput, verify};

use crate::scenario::load;

fn report(specification: &str, items: &str) -> Report {
    let unit = load(specification);
    let parsed = parse(&format!("scenario s {{ unit 1 ms; {items} }}"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let (options, cancel) = (Options::default(), Cancel::default());
    let report = verify(&input, &parsed.scenario, &options, &cancel);
    assert!(!report.has_errors(), "{:?}", report.diagnostics);
    report
}

fn remarks(report: &Report) -> Vec<&Remark> {
    let all = report.diagnostics.iter();
    all.filter_map(|diagnostic| diagnostic.remark.as_deref()).collect()
}

/// `slow` and `look` share `map`; `fast` shares nothing with either.
const QUEUE: &str = "component c {
  version \"1\"; lang \"c\"; ids { long map; };
  task slow { period 100 ms; codel<start> a(inout map) yield pause::start wcet 12 ms; };
  task look { period 100 ms; codel<start> b(in map) yield pause::start wcet 1 ms; };
  task fast { period 10 ms; codel<start> d() yield pause::start wcet 1 ms; };
};";

/// `go` comes after `init`, which comes after `power`; `reset` comes after itself.
#[test]
fn a_request_that_can_only_be_refused_is_found() {
    let specification = "component c { version \"1\"; lang \"c\";
        task t { period 10 ms; codel<start> a() yield pause::start wcet 1 ms; };
        function power() { }; function init() { after power; }; function go() { after init; };
        function reset() { after reset; };
      };";
    let missing = |sends: &str| {
        let found = report(specification, &format!("client k {{ {sends} }} check schedulable *;"));
        let all = remarks(&found).into_iter();
        let names = all.map(|remark| match remark {
            Remark::OnlyRefused { service, missing } => format!("{service}: {}", missing.join(" ")),
            other => panic!("{other:?}"),
        });
        names.collect::<Vec<_>>()
    };
    assert_eq!(missing("send c.go; send c.init;"), ["c.go: c.init", "c.init: c.power"]);
    // Their order does not matter: the request may be repeated.
    assert!(missing("send c.go; send c.init; send c.power;").is_empty());
    assert_eq!(missing("send c.reset;"), ["c.reset: c.reset"]);
    assert!(missing("send c.power;").is_empty());
    let off = "order off; client k { send c.go; } check schedulable *;";
    assert!(remarks(&report(specification, off)).is_empty());
}

/// A permanent activity that loops without a pause has a first cycle that never ends: "schedulable" would
/// hold for no job at all.
#[test]
fn a_loop_without_pause_has_nothing_to_verify() {
    let specification = |yields: &str| {
        format!(
            "component c {{ version \"1\"; lang \"c\";
               task t {{ period 10 ms;
                 codel<start> a() yield main wcet 1 ms; codel<main> b() yield {yields} wcet 2 ms;
                 codel<stop> z() yield ether wcet 1 ms;
               }};
               task u {{ period 10 ms; codel<start> d() yield pause::start wcet 1 ms; }};
             }};"
        )
    };
    let checks = "check schedulable *; check response *;";
    let found = report(&specification("start"), checks);
    for check in found.checks.iter().filter(|check| check.of == "c.t") {
        assert_eq!((check.verdict, check.value), (Verdict::Nothing, None));
        assert_eq!(
            check.note.as_deref(),
            Some(
                "the permanent activity of `c.t` goes round start → main → start and never pauses, so its first cycle never \
                 ends and no job of the task is ever measured; let one of these codels yield `pause::` or `ether`"
            )
        );
    }
    assert!(found.nothing());
    // Other tasks of the component are verified, and so is this task if it can pause.
    let others = found.checks.iter().filter(|check| check.of == "c.u");
    assert!(others.map(|check| check.verdict).all(|verdict| verdict == Verdict::Proved));
    let pausing = report(&specification("pause::start"), "check response c.t;");
    assert_eq!(pausing.checks[0].verdict, Verdict::Proved);
}

#[test]
fn who_is_behind_the_head_of_the_lock_queue_is_told_for_how_long() {
    let found = report(QUEUE, "check schedulable *;");
    let [Remark::LockQueue { codel, head, task, .. }] = remarks(&found)[..] else {
        panic!("{:?}", remarks(&found));
    };
    assert_eq!([codel, head, task], ["c.slow.start", "c.look.start", "c.fast"]);
    let diagnostic =
        (found.diagnostics.iter()).find(|diagnostic| diagnostic.code == "timing-lock-queue");
    assert_eq!(
        diagnostic.map(|diagnostic| diagnostic.message.to_string()).as_deref(),
        Some(
            "while c.look.start waits for c.slow.start, which takes up to 12 ms, the lock queue stands still: c.fast, which \
             shares nothing with it, waits behind and can miss its period of 10 ms; shorten what c.slow.start does with shared data, \
             for example by a `local` copy"
        )
    );
    // The deadline is missed.
    let late = found.checks.iter().find(|check| check.of == "c.fast");
    assert_eq!(late.map(|check| check.verdict), Some(Verdict::Refuted));
    // Without a queue a codel does not wait for codels with which it shares nothing.
    assert!(remarks(&report(QUEUE, "locks free; check schedulable *;")).is_empty());
    // Without a codel at the head, none is behind it.
    let alone = QUEUE.replace("b(in map)", "b()");
    assert!(remarks(&report(&alone, "check schedulable *;")).is_empty());
}

const PORT: &str = "struct map { long v; };
component c {
  version \"1\"; lang \"c\"; port out map m;
  task plan { period 500 ms; codel<start> a(out m) yield pause::start wcet 180 ms; };
};
component d {
  version \"1\"; lang \"c\"; port in map m;
  task move { period 50 ms; codel<start> b(in m) yield pause::start wcet 1 ms; };
};";

#[test]
fn a_port_held_longer_than_a_period_is_told_where_ports_are_locks() {
    for items in ["semantics published;", "ports lock;"] {
        let found = report(PORT, &format!("{items} check schedulable *;"));
        let [Remark::PortHold { codel, other, task, .. }] = remarks(&found)[..] else {
            panic!("{:?}", remarks(&found));
        };
        assert_eq!([codel, other, task], ["c.plan.start", "d.move.start", "d.move"]);
    }
    assert!(remarks(&report(PORT, "check schedulable *;")).is_empty());
}

#[test]
fn restarts_that_end_each_other_are_told_when_they_can() {
    let specification = "component c {
      version \"1\"; lang \"c\";
      task t { period 10 ms; };
      activity s() {
        task t;
        codel<start> a() yield pause::start wcet 1 ms;
        codel<stop> b() yield ether wcet 1 ms;
        interrupts s;
      };
    };";
    let told = |client: &str| {
        let found = report(specification, &format!("client k {{ {client} }} check schedulable *;"));
        found.notes.iter().any(|note| note.contains("interrupt each other"))
    };
    assert!(told("send c.s; delay 25 ms; send c.s; send c.s;"));
    // After the end of the first instance the next one may come.
    assert!(!told("send c.s; delay 25 ms; send c.s; delay 25 ms; send c.s;"));
}

#[test]
fn an_unbounded_response_names_the_loop_and_what_limits_it() {
    let specification = "component c {
      version \"1\"; lang \"c\";
      task t {
        period 10 ms;
        codel<start> a() yield x wcet 1 ms;
        codel<x> b() yield start, pause::start wcet 1 ms;
      };
    };";
    let found = report(specification, "check response c.t;");
    assert_eq!(found.checks[0].value, Some(Value::Unbounded));
    let note = found.checks[0].note.as_deref().unwrap_or_default();
    let loops = "c.t may go round start → x → start without a pause; `loop once c.t;` in a scenario limits \
        its rounds";
    assert_eq!(note, loops);
}

const PRIORITIES: &str = "component c {
  version \"1\"; lang \"c\";
  task hi { period 10 ms; priority 1; codel<start> a() yield pause::start wcet 2 ms; };
};
component d {
  version \"1\"; lang \"c\";
  task lo { period 40 ms; priority 2; codel<start> b() yield pause::start wcet 5 ms; };
};";

#[test]
fn under_preemption_intervals_have_bounds_and_say_so() {
    let found = report(
        PRIORITIES,
        "cores 1; policy priority; check schedulable *; check response *; check always c.hi.idle or \
            c.hi.running;",
    );
    let of = |name: &'static str| found.checks.iter().filter(move |check| check.of == name);
    for report in of("c.hi").chain(of("d.lo")) {
        assert_eq!(report.verdict, Verdict::Proved, "{report:?}");
        // Answers of analysis hold for any time.
        let worth = [Soundness::Exact, Soundness::UpperBound];
        assert!(worth.contains(&report.soundness), "{report:?}");
    }
    // Preempted once, by 2 ms, it takes 7 ms.
    let response = of("d.lo").find(|report| report.value.is_some()).expect("a value");
    assert_eq!(response.value, Some(Value::Time(7.0)));
    assert_eq!(response.soundness, Soundness::Exact);
    // Answers of exploration hold for whole units.
    let explored = of("c.hi.idle or c.hi.running").next().expect("an answer");
    assert_eq!((explored.verdict, explored.soundness), (Verdict::Proved, Soundness::WholeUnits));
    // With fixed durations there is no such restriction, and there is a run, with its preemption.
    let fixed = report(PRIORITIES, "cores 1; policy priority; durations fixed; check response *;");
    let exact = fixed.checks.iter().find(|check| check.of == "d.lo");
    assert!(exact.is_some_and(|check| !check.witness.is_empty() && !check.left_out));
    assert_eq!(
        exact.map(|check| (check.value, check.soundness)),
        Some((Some(Value::Time(7.0)), Soundness::Under))
    );
}

#[test]
fn only_cores_that_are_taken_away_can_be_tied_to() {
    let unit = load(PRIORITIES);
    let parsed =
        parse("scenario s { cores 1; policy fifo; affinity c.hi 1; check schedulable *; }");
    let input = SystemInput { specs: vec![&unit.spec] };
    let (options, cancel) = (Options::default(), Cancel::default());
    let report = verify(&input, &parsed.scenario, &options, &cancel);
    let messages: Vec<String> =
        report.diagnostics.iter().map(|diagnostic| diagnostic.message.to_string()).collect();
    assert_eq!(
        messages,
        [
            "policy fifo gives a task any core that is free; write `policy priority;` or `policy fair;` to \
                tie `c.hi` to one"
        ]
    );
}

/// A task that never gives its core back, after the start-up of an earlier one if there is one.
fn polls(earlier: &str) -> String {
    format!(
        "component c {{ version \"1\"; lang \"c\"; {earlier}
           task poll {{ codel <start> p() yield read wcet 3 ms; codel <read> r() yield start wcet 7 ms; }};
         }};"
    )
}

#[test]
fn a_task_that_holds_the_core_for_ever_ends_the_search() {
    let work = load(
        "component d { version \"1\"; lang \"c\";
           task work { period 10 ms; codel <start> s() yield pause::start wcet 1 ms; };
           task other { period 13 ms; codel <start> o() yield pause::start wcet 1 ms; };
         };",
    );
    let answer = |earlier: &str, cores: u32| {
        let unit = load(&polls(earlier));
        let input = SystemInput { specs: vec![&unit.spec, &work.spec] };
        let text = format!(
            "scenario x {{ cores {cores}; policy fifo; duration c.poll.read [1, 7] ms; check schedulable d.work; }}"
        );
        let parsed = parse(&text);
        assert_eq!(parsed.errors, []);
        verify(&input, &parsed.scenario, &Options::default(), &Cancel::default())
    };
    let never = answer("", 1);
    insta::assert_snapshot!(never.checks[0].note.as_deref().unwrap(), @"`d.work` is never released: the start-up of `d.work` never completes, because `c.poll` can hold a core for ever");
    assert_eq!(never.checks[0].verdict, Verdict::Vacuous);
    assert!(never.states < 200, "{} states", never.states);
    // With another core, and if jobs came before, there are answers.
    assert_eq!(answer("", 2).checks[0].verdict, Verdict::Proved);
    let late = "task first { period 20 ms; codel <start> f() yield pause::start wcet 1 ms; };";
    assert_eq!(answer(late, 1).checks[0].verdict, Verdict::Refuted);
}
