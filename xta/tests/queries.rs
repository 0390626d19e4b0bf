//! Forms of queries, their answers and traces.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use dotgen_xta::{Answer, Limits, Reason, queries, read};

use super::{answer, holds, trace, values};

const COUNTER: &str = "int[0, 50] n := 0;
    process P() { clock x; state a { x <= 4 }; init a;
        trans a -> a { guard x >= 2 && n < 50; assign n++, x := 0; },
            a -> a { guard n == 50; assign x := 0; }; }
    system P;";

#[test]
fn a_trace_has_steps_changes_and_earliest_times() {
    let trace = trace(COUNTER, "A[] n < 3");
    let times: Vec<i64> = trace.steps.iter().map(|step| step.time).collect();
    assert_eq!(times, [2, 4, 6]);
    let change = &trace.steps[2].changes[0];
    assert_eq!((change.variable.as_str(), change.before, change.after), ("n", 2, 3));
    assert_eq!(trace.steps[0].transition, "P.a -> a");
    assert_eq!(trace.locations, ["P.a"]);
}

#[test]
fn an_earlier_step_waits_for_a_later_one() {
    let model = "chan c; process P() { clock x; state a, b { x <= 1 }, d; init a;
            trans a -> b { assign x := 0; }, b -> d { sync c!; }; }
        process Q() { clock y; state a, b; init a; trans a -> b { guard y >= 10; sync c?; }; }
        system P, Q;";
    let trace = trace(model, "E<> P.d");
    let times: Vec<i64> = trace.steps.iter().map(|step| step.time).collect();
    assert_eq!(times, [9, 10]);
    assert_eq!(trace.steps[1].channel.as_deref(), Some("c"));
}

#[test]
fn sup_and_inf_are_of_clocks_and_integers() {
    assert_eq!(values(COUNTER, "sup: P.x, n"), [Some((4, true)), Some((50, true))]);
    assert_eq!(values(COUNTER, "inf{n > 7}: n, P.x"), [Some((8, true)), Some((0, true))]);
    let strict = COUNTER.replace("x <= 4", "x < 4");
    assert_eq!(values(&strict, "sup{P.a}: P.x"), [Some((4, false))]);
}

#[test]
fn sup_finds_values_far_beyond_the_constants() {
    let model =
        "clock y; process P() { clock x; int[0, 99] n := 0; state a { x <= 9 }, b { x <= 0 }, c;
        init a;
        trans a -> a { guard x == 9 && n < 99; assign x := 0, n++; },
            a -> b { guard n == 99; assign x := 0; }, b -> c { }; } system P;";
    assert_eq!(values(model, "sup{P.b}: y"), [Some((900, true))]);
    assert_eq!(values(model, "inf{P.b}: y"), [Some((891, true))]);
    assert_eq!(values(model, "sup: y"), [None]);
}

#[test]
fn deadlock_is_found_now_and_later() {
    let model = "process P() { clock x; state a { x <= 5 }, b; init a;
        trans a -> a { guard x >= 2 && x <= 3; assign x := 0; }, b -> b { }; } system P;";
    assert!(!holds(model, "A[] not deadlock"));
    assert!(holds(model, "A[] deadlock imply P.x > 3"));
    assert!(holds(model, "E<> not deadlock and P.x <= 3"));
    assert!(holds(&model.replace("x <= 5", "x <= 3"), "A[] not deadlock"));
}

#[test]
fn a_search_gives_up_at_its_limits() {
    let network = read(COUNTER).expect("reads");
    let query = &queries("A[] n <= 50").expect("parses")[0];
    let few = Limits { states: 10, cancel: None };
    assert!(matches!(
        network.answer(query, &few),
        Answer::GaveUp { reason: Reason::States(10), .. }
    ));
    let endless =
        "int n := 0; process P() { state a; init a; trans a -> a { assign n := (n + 1) % 9999; }; }
        system P;";
    let cancelled = Limits { states: 1 << 20, cancel: Some(Arc::new(AtomicBool::new(true))) };
    let answer =
        read(endless).expect("reads").answer(&queries("A[] true").expect("parses")[0], &cancelled);
    assert!(matches!(answer, Answer::GaveUp { reason: Reason::Cancelled, .. }));
}

#[test]
fn liveness_and_statistics_are_refused() {
    for query in
        ["A<> P.a", "E[] P.a", "P.a --> n == 3", "Pr[<=10](<> P.a)", "simulate [<=10] {P.x}"]
    {
        assert!(matches!(answer(COUNTER, query), Answer::Refused(_)), "{query}");
    }
}

#[test]
fn queries_start_on_lines_and_continue_after_operators() {
    let text = "// first\nA[] n <= 50\n\n/* second */ E<>\n n == 3 &&\n P.a\n  or n == 4\nsup{P.a}:\n P.x, n\n";
    let queries = queries(text).expect("parses");
    let texts: Vec<&str> = queries.iter().map(|query| query.text.as_str()).collect();
    assert_eq!(texts, ["A[] n <= 50", "E<>\n n == 3 &&\n P.a\n  or n == 4", "sup{P.a}:\n P.x, n"]);
}

#[test]
fn an_error_of_a_query_has_its_place() {
    let error = queries("A[] true\n\n  A[] n <=").expect_err("no operand");
    assert_eq!((error.line, error.column), (3, 11));
    let network = read(COUNTER).expect("reads");
    let query = &queries("A[] true\nA[] P.b").expect("parses")[1];
    let error = network.check(query).expect_err("no such location");
    assert_eq!(error.to_string(), "2:5: process `P` has no location and no variable `b`");
}
