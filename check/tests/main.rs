//! Small certificates: what is printed of a claim, and what is refused before it is read whole.

use dotgen_check::{Outcome, check};

/// A certificate of one system, and the claim that a predicate never holds.
fn certificate(never: &str) -> String {
    format!(
        r#"{{ "format": 1, "scenarios": [{{ "scenario": "s", "uncertified": [], "systems": [{{
            "cores": 1, "codels": [
                {{ "name": "a", "shared": [], "exclusive": ["l"] }},
                {{ "name": "b", "shared": ["l"], "exclusive": [] }}],
            "parts": [
                {{ "name": "p", "initial": ["off"], "steps": [{{ "from": "off", "to": "on", "what": "begins" }}],
                  "states": [{{ "name": "off" }}, {{ "name": "on", "executes": "a" }}] }},
                {{ "name": "q", "initial": ["on"], "steps": [], "states": [{{ "name": "on", "executes": "b" }}] }}],
            "atoms": [
                {{ "name": "A", "exact": true, "parts": {{ "p": ["on"] }} }},
                {{ "name": "B", "exact": true, "parts": {{ "q": ["on"] }} }}],
            "checks": [{{ "check": "always C (proved)", "never": {never} }}] }}] }}] }}"#
    )
}

fn outcome(text: &str) -> String {
    let answers = check(text.as_bytes()).unwrap();
    let [answer] = &answers[..] else { panic!("{answers:?}") };
    format!("{}: {}", answer.check, answer.outcome)
}

#[test]
fn an_answer_has_the_predicate_that_is_proved() {
    let both = certificate(r#"{ "and": [{ "atom": "A" }, { "atom": "B" }] }"#);
    let expected = "s: always C (proved): accepted: never (A and B)";
    assert_eq!(outcome(&both), expected);
    // A predicate that says nothing is shown as such.
    let nothing = "s: always C (proved): accepted: never false";
    assert_eq!(outcome(&certificate(r#"{ "or": [] }"#)), nothing);
    let one = certificate(r#"{ "atom": "A" }"#);
    assert_eq!(outcome(&one), "s: always C (proved): refused: no invariant excludes `A` true");
}

#[test]
fn another_version_is_named_whatever_else_it_holds() {
    let answer = check(br#"{ "format": 2, "new": [] }"#);
    assert_eq!(answer, Err("has format 2, not 1".to_owned()));
}

#[test]
fn a_certificate_that_needs_too_much_work_is_refused() {
    // 2^40 cases.
    let pair = r#"{ "or": [{ "atom": "A" }, { "atom": "B" }] }"#;
    let all = vec![pair; 40].join(",");
    let answers = check(certificate(&format!(r#"{{ "and": [{all}] }}"#)).as_bytes()).unwrap();
    let Outcome::Refused(reason) = &answers[0].outcome else { panic!("{answers:?}") };
    assert!(reason.contains("steps"), "{reason}");
}
