//! One cause, one diagnostic.

use crate::test_support::Fixture;

#[track_caller]
fn check(text: &str, expected: &[&str]) {
    let all = Fixture::new(text).all_diagnostics();
    assert_eq!(codes(text), expected, "{all}");
}

fn codes(text: &str) -> Vec<&'static str> {
    let fixture = Fixture::new(text);
    let mut codes = Vec::new();
    for path in fixture.paths() {
        let found = fixture.analysis().diagnostics(&path).unwrap();
        codes.extend(found.iter().map(|diagnostic| diagnostic.code));
    }
    codes
}

#[test]
fn names_from_a_missing_include_are_quiet() {
    check(
        "#include \"none.idl\"
interface i { port in m::s p; };
component c {
  uses d;
  ids { m::s v; };
  throws gone;
  task t { period N ms; };
  activity go(in m::s x = { .a = 1 }) { task t; codel<start> f(in v.x, out q) yield ether; };
};
",
        &["pp-include-not-found"],
    );
}

#[test]
fn names_in_text_that_does_not_parse_are_quiet() {
    check("typedef long 4 t;\ntypedef t u;\ntypedef nope v;\n", &["syntax", "unknown-type"]);
}

#[test]
fn an_unfinished_declaration_declares_its_name() {
    check("const long n = ;\ntypedef long a[n];\n", &["syntax"]);
    check("struct s { long x };\ntypedef s t;\n", &["missing-semicolon"]);
    check("struct s { };\ntypedef s t;\n", &["syntax"]);
    check("typedef nope t;\ntypedef t u;\nstruct s { u x; };\n", &["unknown-type"]);
}

#[test]
fn an_unfinished_line_leaves_the_next_one_alone() {
    check(
        "struct s { long y; };
component c {
  port out s
  ids { long x; };
  task t {
    period 5 ms;
    codel<start> f(out x) yield
    codel<main> g(in x) yield pause::main, ether;
  };
};
",
        &["syntax", "syntax"],
    );
    check(
        "component c {
  ids { long x; };
  task t {
    codel<start> f(out x) yield main wcet
    codel<main> g(in x) yield ether wcet 1 ms;
  };
};
",
        &["wcet-value", "syntax"],
    );
}

#[test]
fn a_forgotten_brace_is_one_error() {
    const RIGHT: &str = "typedef long n;
component c {
  version \"1\";
  ids {
    long x;
    struct s { long y; } z;
  };
  port in n p {
    doc \"text\";
  };
  task t {
    period 5 ms;
    codel<start> f(inout x) yield pause::start wcet 1 ms;
  };
  activity a(in long y) {
    task t;
    validate v(in y) wcet 1 ms;
    codel<start> g(inout z, in p) yield ether wcet 1 ms;
  };
};
";
    check(RIGHT, &[]);
    for (at, _) in RIGHT.match_indices(['{', '}']) {
        let (before, after) = (&RIGHT[..at], &RIGHT[at + 1..]);
        check(&format!("{before}{after}"), &["syntax"]);
    }
}

#[test]
fn a_forgotten_first_line_of_a_task_or_service_is_one_error() {
    const RIGHT: &str = "component c {
  version \"1\";
  ids { long x; };
  task t {
    period 5 ms;
    codel<start> f(inout x) yield pause::start wcet 1 ms;
  };
  activity a(in long y) {
    doc \"It goes.\";
    task t;
    validate v(in y) wcet 1 ms;
    codel<start> g(in y, out x) yield ether wcet 1 ms;
    interrupts a;
  };
  function f() {
    interrupts a;
  };
};
";
    check(RIGHT, &[]);
    for line in ["  task t {\n", "  activity a(in long y) {\n", "  function f() {\n"] {
        let (before, after) = RIGHT.split_once(line).unwrap();
        check(&format!("{before}{after}"), &["syntax"]);
    }
}

#[test]
fn a_machine_that_is_not_understood_is_not_judged() {
    let machine = |start: &str, states: &str| {
        format!(
            "component c {{
  ids {{ long x; }};
  task t {{
    {start}
    codel<main> g(inout x) yield {states} wcet 1 ms;
    codel<other> h(in x) yield ether wcet 1 ms;
  }};
  task u {{ codel<start> i() yield ether wcet 1 ms; codel<lost> j() yield ether wcet 1 ms; }};
}};
"
        )
    };
    let of_u = "fsm/unreachable-state";
    let right = "codel<start> f(out x) yield main wcet 1 ms;";
    check(&machine(right, "other"), &[of_u]);
    check(&machine(right, "ether"), &["fsm/unreachable-state", of_u]);
    for broken in [
        "codel<start f(out x) yield main wcet 1 ms;",
        "codl<start> f(out x) yield main wcet 1 ms;",
        "codel<start> (out x) yield main wcet 1 ms;",
        "codel<start> f(out x) yeld main wcet 1 ms;",
        "<start> f(out x) yield main wcet 1 ms;",
        "codel<start> f(out x yield main wcet 1 ms;",
        "codel<> f(out x) yield main wcet 1 ms;",
        "codel start f(out x) yield main wcet 1 ms;",
    ] {
        let fixture = Fixture::new(&machine(broken, "ether"));
        let found = fixture.analysis().diagnostics("/main.gen".into()).unwrap();
        let mut codes: Vec<_> = found.iter().map(|diagnostic| diagnostic.code).collect();
        assert_eq!(codes.pop(), Some(of_u), "{}", fixture.all_diagnostics());
        assert!(
            codes.len() == 1 && !codes[0].starts_with("fsm/"),
            "{broken}: {}",
            fixture.all_diagnostics()
        );
    }
    // Without its `;` the declaration is complete.
    check(
        &machine("codel<start> f(out x) yield main wcet 1 ms", "ether"),
        &["missing-semicolon", "fsm/unreachable-state", of_u],
    );
}

#[test]
fn a_name_that_is_to_come_is_not_missed() {
    let text = |ids: &str, port: &str| {
        format!(
            "struct s {{ long x; }};
component c {{
  ids {{ {ids} }};
  {port}
  task t {{ codel<start> f(inout v, port out p) yield ether wcet 1 ms; }};
  activity a() {{ task t; codel<start> g(in v.x, in w) yield ether wcet 1 ms; }};
}};
"
        )
    };
    let port = "port out s p;";
    check(&text("s v;", port), &["param-unknown"]);
    check(&text("s ; ", port), &["syntax"]);
    check(&text("s v;", "port out s"), &["syntax"]);
}

#[test]
fn texts_taken_for_code_are_one_error() {
    let text = |doc: &str| {
        format!(
            "component c {{
  {doc}
  task t {{ codel<start> f() yield ether wcet 1 ms; }};
  function g() {{ doc \"Return the limits of the planner.\"; codel h() wcet 1 ms; }};
  activity a() {{ doc \"Plan, and execute.\"; task t; codel<start> i() yield ether wcet 1 ms; }};
}};
"
        )
    };
    check(&text("doc \"What it does.\";"), &[]);
    check(&text("doc \"What it does.;"), &["missing-semicolon"]);
    check(&text("doc What it does.\";"), &["syntax"]);
    check(&text("does.\";"), &["syntax"]);
    check(
        &text("doc \"What\nit does.\" doc \"more\"; typedef nope n;"),
        &["missing-semicolon", "unknown-type"],
    );
    // An unrelated string over several lines hides nothing.
    check(&text("dok \"What\nit does.\"; typedef nope n;"), &["syntax", "unknown-type"]);
}

#[test]
fn names_from_an_include_without_a_file_are_quiet() {
    check(
        "#include \"or/pose/\n#include t.idl\ntypedef m::t u;\n",
        &["pp-include-bad", "pp-include-bad"],
    );
}

#[test]
fn a_file_included_twice_reports_once() {
    check(
        "//- /a.gen\n#include \"t.idl\"\n//- /b.gen\n#include \"t.idl\"\n//- /t.idl\ntypedef nope t;\n",
        &["unknown-type"],
    );
}

#[test]
fn expanded_code_points_at_the_macro() {
    let fixture = Fixture::new("#define T typedef nope t;\nT\n");
    let found = fixture.analysis().diagnostics("/main.gen".into()).unwrap();
    let text = fixture.text("/main.gen");
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(&text[found[0].range.clone()], "T");
    assert_eq!(found[0].range.start, 26);
    assert_eq!(&text[found[0].related[0].range.clone()], "T");
    assert_eq!(found[0].related[0].range.start, 8);
}

#[test]
fn severities_are_configured_except_those_of_errors() {
    use crate::{diagnostic::Severity, host::Config};
    let text = "#define N 1\n#define N 2\ntypedef nope t;\n";
    let config = |severity| Config {
        severities: vec![("pp-redefined".into(), severity), ("unknown-type".into(), None)],
        ..Config::default()
    };
    let severities = |config| {
        let fixture = Fixture::with_config(text, config);
        let found = fixture.analysis().diagnostics("/main.gen".into()).unwrap();
        found.iter().map(|diagnostic| diagnostic.severity).collect::<Vec<_>>()
    };
    assert_eq!(severities(Config::default()), [Severity::Warning, Severity::Error]);
    assert_eq!(severities(config(Some(Severity::Hint))), [Severity::Hint, Severity::Error]);
    assert_eq!(severities(config(None)), [Severity::Error]);
}

#[test]
fn an_activity_that_breaks_off_is_not_asked_for_what_would_follow() {
    for unfinished in [
        "activity home",
        "activity home(",
        "activity home(in double",
        "activity home(in double speed = ",
        "activity home(in double speed)",
        "activity home(in double speed) { doc ",
        "activity home(in double speed) { codel<",
    ] {
        let text = format!("component c {{\n  task t;\n  {unfinished}\n}};\n");
        let found = codes(&text);
        let asked = found.iter().filter(|code| code.starts_with("activity-"));
        assert_eq!(asked.count(), 0, "{unfinished}: {found:?}");
        assert!(!found.is_empty(), "{unfinished}");
    }
    // The task before is complete and unaffected.
    let text = "component c {\n  task t;\n  activity home() { };\n  activity\n};\n";
    assert!(codes(text).contains(&"activity-task"), "{:?}", codes(text));
}
