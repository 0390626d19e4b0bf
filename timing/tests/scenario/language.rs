//! The scenario language: parsing, recovery, formatting and resolution.

use dotgen_timing::scn::ast::CheckKind;
use dotgen_timing::scn::names::{Names, Target};
use dotgen_timing::scn::{default_text, format, parse, parse_check};
use dotgen_timing::verify::{Cancel, SystemInput, verify};

use crate::scenario::{ROBOT, load, published, robot, summary};

#[test]
fn mistakes_are_explained() {
    let report = robot(
        "check response sensor.aquire; check schedulable sensor.record;
         duration sensor.record 3 ms; connect sensor.scan to control.scan;
         check within sensor.acquire.read.idle => control.move;",
    );
    insta::assert_snapshot!(summary(&report));
}

#[test]
fn patterns_are_told_as_they_are_written() {
    for text in [
        "absent b after a for 3 ms",
        "lasts a >= 2 ms",
        "a precedes b",
        "before a never b",
        "before a always b",
        "before a eventually b",
        "after a never b or c",
        "after a until b always c",
        "between (a or b) and not c eventually d.e",
        "between a and b never not c",
    ] {
        let check = parse_check(text).expect(text).remove(0);
        let CheckKind::Pattern(pattern) = check.kind else { panic!("{text}: {:?}", check.kind) };
        assert_eq!(pattern.text(), text);
    }
    let kinds = |text: &str| parse_check(text).map(|checks| checks.len());
    assert_eq!(kinds("within a => b in [5, 20] ms"), Ok(2));
    assert_eq!(kinds("within a => b in [0, 20] ms"), Ok(1));
    let open = parse_check("within a => b in [5, *] ms").expect("a check").remove(0);
    assert!(matches!(open.kind, CheckKind::Pattern(_)), "b need not come: {:?}", open.kind);
    for nothing in ["within a => b in [0, *] ms", "lasts a >= 0 ms", "absent a after b for 0 s"] {
        assert_eq!(parse_check(nothing).expect_err(nothing).code, "scn-interval");
    }
}

#[test]
fn the_time_after_a_moment_is_no_predicate() {
    for (check, is_right) in [
        ("never sensor.acquire.tick and control.move", true),
        ("always sensor.acquire.tick => control.move", true),
        ("never not sensor.acquire.tick", false),
        ("always sensor.acquire.tick", false),
        ("lasts sensor.acquire.tick >= 1 ms", false),
        ("absent not leave control.move after sensor.acquire.tick for 1 ms", false),
        ("reachable not leave control.move", true),
    ] {
        let report = robot(&format!("check {check};"));
        let wrong = report.diagnostics.iter().any(|wrong| wrong.code == "scn-wrong-status");
        assert_eq!(wrong, !is_right, "{check}: {:?}", report.diagnostics);
    }
}

#[test]
fn slots_are_some_and_not_too_many() {
    for (number, allowed) in [
        ("0", false),
        ("1", true),
        ("32", true),
        ("33", false),
        ("40", false),
        ("4294967298", false),
    ] {
        let text = format!(
            "scenario s {{ slots sensor.record 3; slots sensor.record {number}; cores 1; }}"
        );
        let parsed = parse(&text);
        let wrong = parsed.errors.iter();
        let wrong: Vec<_> = wrong.map(|wrong| (wrong.code, &text[wrong.range.clone()])).collect();
        if allowed {
            assert_eq!(wrong, []);
        } else {
            assert_eq!(wrong, [("scn-slots", number)]);
        }
        assert_eq!(parsed.scenario.items.len(), 2 + usize::from(allowed));
    }
    let told = &parse("scenario s { slots sensor.record 40; }").errors[0].message;
    insta::assert_snapshot!(told, @"a task or an activity can have 1 to 32 slots, not 40: without one it \
        never runs, and each one more multiplies what has to be explored");
}

#[test]
fn broken_text_is_recovered_from() {
    let parsed = parse(
        "scenario x {\n  cores 0;\n  policy lifo;\n  unit 1 ms\n  check response a.b;\n  client c { send a.; repeat 3 { } }\n  wrong;\n",
    );
    let errors: Vec<String> = parsed
        .errors
        .iter()
        .map(|error| format!("{:?} {}: {}", error.range, error.code, error.message))
        .collect();
    insta::assert_snapshot!(errors.join("\n"));
    assert_eq!(parsed.scenario.items.len(), 2);
}

#[test]
fn formatting_keeps_comments_and_is_stable() {
    let text = "// Head.\nscenario  x{use \"a.gen\" ;cores   4;// all of them\n\n\n  duration a.b.c [ 1,* ]us;\nclient k{ choice{send a.b ;}or{ delay [0,3] ms; } }\ncheck q:within a.b=>not (c.d or e.f)<=3 ms;}";
    let formatted = format(text).unwrap();
    insta::assert_snapshot!(formatted);
    assert_eq!(format(&formatted).as_ref(), Some(&formatted));
    // Line breaks of a long check are kept.
    let long = "scenario x {\n  check stop: within a.b\n    => c.d\n    then e.f\n    or g.h <= 5 ms;\n}\n";
    assert_eq!(format(long).as_deref(), Some(long));
    let other = long.replace("\n    ", "\n\n       ").replace("<=", "\n<=");
    assert_eq!(format(&other).as_deref(), Some(long));
    assert_eq!(format("scenario x { cores ; }"), None);
}

#[test]
fn the_default_scenario_is_one() {
    let unit = load(ROBOT);
    let input = SystemInput { specs: vec![&unit.spec] };
    let names = Names::new(&input.specs);
    let components: Vec<_> = names.components.iter().map(|component| component.component).collect();
    let text = default_text(&components, &["robot.gen".to_owned()]);
    let parsed = parse(&text);
    assert_eq!(parsed.errors, []);
    assert_eq!(format(&text).as_ref(), Some(&text));
    let report = verify(&input, &parsed.scenario, &published(), &Cancel::default());
    insta::assert_snapshot!(format!("{text}\n{}", summary(&report)));
}

#[test]
fn names_lead_to_the_model() {
    let unit = load(ROBOT);
    let names = Names::new(&[&unit.spec]);
    let parsed = parse(
        "scenario x { check response sensor.acquire; check always not sensor.acquire.read.exec; client k { \
            send sensor.reset; } }",
    );
    let found: Vec<Target> =
        names.references(&parsed.scenario).into_iter().map(|reference| reference.target).collect();
    insta::assert_debug_snapshot!(found);
}

#[test]
fn checks_can_be_given_alone() {
    assert!(parse_check("response a.b <= 3 ms").is_ok());
    assert!(parse_check("q: always not a.b.exec").is_ok());
    assert!(parse_check("response a.b <= ").is_err());
    assert!(parse_check("schedulable * ;").is_err());
}

#[test]
fn implications_and_never_stand_for_other_predicates() {
    let text = |check: &str| match parse_check(check).unwrap().remove(0).kind {
        CheckKind::Always(predicate) | CheckKind::Reachable(predicate) => predicate.text(),
        other => panic!("{other:?}"),
    };
    for (written, meant) in [
        ("never a.b", "always not a.b"),
        ("never a or b", "always not (a or b)"),
        ("always a => b", "always not a or b"),
        ("always a and b => c or d", "always not (a and b) or c or d"),
        ("always a => b => c", "always not a or not b or c"),
        ("reachable (a => b) and c", "reachable (not a or b) and c"),
    ] {
        assert_eq!(text(written), text(meant), "{written}");
    }
    // There the arrow is that of the check.
    assert!(parse_check("leadsto a => b => c").is_err());
    assert!(parse_check("leadsto (a => b) => c").is_ok());
}

#[test]
fn garbage_never_panics() {
    let pieces = [
        "scenario", "x", "{", "}", "check", "within", "=>", "<=", "3", "[", "*", "client",
        "repeat", "choice", "or", "\"", "/*", ".", ";", "é", "send", "not", "(",
    ];
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..2000 {
        let mut text = String::from("scenario x {");
        for _ in 0..30 {
            text.push_str(random.choice(pieces).unwrap_or_default());
            text.push(' ');
        }
        let parsed = parse(&text);
        assert!(parsed.errors.iter().all(|error| error.range.end <= text.len()));
        format(&text);
    }
}
