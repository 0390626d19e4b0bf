//! The texts after quick fixes.

mod removal;

use super::*;

/// The text after each fix of the first finding with a code: title, then text.
fn fixed(source: &str, code: &str) -> String {
    let found = check(text(source), strict());
    let Some(diagnostic) = found.iter().find(|check| check.code == code) else {
        panic!("{code} is not reported: {found:#?}")
    };
    assert!(!diagnostic.fixes.is_empty(), "{code} has no fix");
    let mut out = String::new();
    for fix in &diagnostic.fixes {
        let mut after = source.to_owned();
        let mut edits: Vec<_> = fix.edits.iter().collect();
        edits.sort_by_key(|edit| std::cmp::Reverse(edit.range.start));
        for edit in edits {
            after.replace_range(edit.range.clone(), &edit.new_text);
        }
        let left = check(text(&after), strict());
        let again = left.iter().filter(|check| check.code == code).count();
        let before = found.iter().filter(|check| check.code == code).count();
        assert!(again < before, "{}: does not help:\n{after}", fix.title);
        out.push_str(&format!("--- {}\n{after}", fix.title));
    }
    out
}

/// The texts after the fixes of several findings: code and source.
fn fixed_all(all: &[(&str, &str)]) -> String {
    let one = |(code, source): &(&str, &str)| format!("=== {code}\n{}", fixed(source, code));
    all.iter().map(one).collect()
}

/// Existing lists are extended, and inserted text follows the style of the file.
#[test]
fn fixes_write_as_the_author_does() {
    let all = fixed_all(&[
        (
            "throw/undeclared-use",
            "module m { exception far, near; };\ncomponent c {\n  task t {\n    throws m::near;\n    \
             period 5 ms;\n    codel <start> f() yields ether, far;\n  };\n};\n",
        ),
        (
            "service/concurrent-instances",
            "component c {\n  ids { long x; };\n  task t { period 5 ms; };\n  function stop() { };\n  \
             activity go() {\n    task t;\n    interrupt stop, // it rests\n              end;\n    \
             codel<start> f(out x) yield pause::start, ether;\n  };\n  function end() { };\n};\n",
        ),
        (
            "fsm/missing-stop",
            "component c {\n  ids { long x; };\n  task t { period 5 ms; };\n  activity go() {\n    \
             task t;\n    interrupts go;\n    codel <start> f(out x)\n      yields pause::start, ether;\n  \
             };\n};\n",
        ),
    ]);
    expect![[r"
        === throw/undeclared-use
        --- Throw `m::far` instead of yielding it
        module m { exception far, near; };
        component c {
          task t {
            throws m::near, ::m::far;
            period 5 ms;
            codel <start> f() yields ether;
          };
        };
        === service/concurrent-instances
        --- Let `go` interrupt itself
        component c {
          ids { long x; };
          task t { period 5 ms; };
          function stop() { };
          activity go() {
            task t;
            interrupt stop, // it rests
                      end,
                      go;
            codel<start> f(out x) yield pause::start, ether;
          };
          function end() { };
        };
        === fsm/missing-stop
        --- Add the codel `go_stop`
        component c {
          ids { long x; };
          task t { period 5 ms; };
          activity go() {
            task t;
            interrupts go;
            codel <start> f(out x)
              yields pause::start, ether;
            codel <stop> go_stop() yields ether;
          };
        };
    "]]
    .assert_eq(&all);
}

#[test]
fn slips_have_a_fix() {
    let all = fixed_all(&[
        ("missing-semicolon", "const long a = 1 // one\nconst long b = 2;\n"),
        (
            "glued-unit",
            "component c {\n  task t { period 500us; codel<start> f() yield ether; };\n};\n",
        ),
        (
            "fsm/paused-ether",
            "component c {\n  task t { codel<start> f() yield pause::ether; };\n};\n",
        ),
        ("lex-stray", "const long a@ = 1;\n"),
        ("lex-stray", "\u{feff}const long a = 1;\n"),
        (
            "fsm/duplicate-yield",
            "component c {\n  task t { codel<start> f() yield ether, ether; };\n};\n",
        ),
    ]);
    expect![[r"
        === missing-semicolon
        --- Insert `;`
        const long a = 1; // one
        const long b = 2;
        === glued-unit
        --- Write `500 us`
        component c {
          task t { period 500 us; codel<start> f() yield ether; };
        };
        === fsm/paused-ether
        --- Change to `ether`
        component c {
          task t { codel<start> f() yield ether; };
        };
        === lex-stray
        --- Remove `@`
        const long a = 1;
        === lex-stray
        --- Remove the byte order mark
        const long a = 1;
        === fsm/duplicate-yield
        --- Remove `ether`
        component c {
          task t { codel<start> f() yield ether; };
        };
    "]]
    .assert_eq(&all);
}

#[test]
fn duplicates_and_gaps_have_a_fix() {
    let all = fixed_all(&[
        ("throw-duplicate", "component c {\n  exception e;\n  throws e, ::c::e;\n};\n"),
        ("list-duplicate-string", "component c {\n  requires \"a\",\n    \"a\";\n};\n"),
        ("missing-yield", "component c {\n  task t { codel<start> f(); };\n};\n"),
        (
            "activity-task",
            "component c {\n  task t;\n  activity a() { codel<start> f() yield ether; };\n};\n",
        ),
        ("activity-start", "component c {\n  task t;\n  activity a() {\n    task t;\n  };\n};\n"),
    ]);
    expect![[r#"
        === throw-duplicate
        --- Remove `::c::e`
        component c {
          exception e;
          throws e;
        };
        === list-duplicate-string
        --- Remove `"a"`
        component c {
          requires "a";
        };
        === missing-yield
        --- Insert `yield ether`
        component c {
          task t { codel<start> f() yield ether; };
        };
        === activity-task
        --- Add `task t;`
        component c {
          task t;
          activity a() { codel<start> f() yield ether; task t; };
        };
        === activity-start
        --- Add the codel `a_start`
        component c {
          task t;
          activity a() {
            task t;
            codel<start> a_start() yield ether;
          };
        };
    "#]]
    .assert_eq(&all);
}

#[test]
fn the_first_fix_is_what_the_message_advises() {
    let source = "component c {\n  task t {\n    period 5 ms;\n    codel<start> f() yield step;\n    codel<step> g() yield settle;\n    codel<settle> h() yield step, ether;\n  };\n};\n";
    let found = check(text(source), strict());
    let round = found.iter().find(|check| check.code == "fsm/busy-loop");
    let round = round.expect("it is reported");
    let message = round.message.to_string();
    assert!(message.ends_with("yield `pause::step` if each round may wait"), "{message}");
    assert_eq!(round.fixes[0].title, "Pause before `step`");
}

/// The text after the first fix of the first finding with a code.
fn first_fix(source: &str, code: &str) -> String {
    let found = check(text(source), strict());
    let check = found.iter().find(|check| check.code == code && !check.fixes.is_empty());
    let diagnostic = check.unwrap_or_else(|| panic!("{code} has no fix: {found:#?}"));
    let mut after = source.to_owned();
    let mut edits: Vec<_> = diagnostic.fixes[0].edits.iter().collect();
    edits.sort_by_key(|edit| std::cmp::Reverse(edit.range.start));
    for edit in edits {
        after.replace_range(edit.range.clone(), &edit.new_text);
    }
    after
}

#[test]
fn what_was_meant_replaces_the_very_token_that_is_misspelt() {
    for (code, right, part, misspelt) in [
        // In a path, the scope that does not exist.
        (
            "unknown-type",
            "module a { module inner { struct point { long x; }; }; };\ntypedef a::inner::point p;\n",
            "a::inner::point",
            "a::inne::point",
        ),
        // A name that occurs in the path before.
        (
            "unknown-type",
            "module poin { struct point { long x; }; };\ntypedef poin::point p;\n",
            "poin::point",
            "poin::poin",
        ),
        // A part of a parameter.
        (
            "param-member",
            "component c {\n  struct s { double heading; };\n  ids { s goal; };\n  \
             function f() { codel g(in goal.heading); };\n};\n",
            "goal.heading",
            "goal.headin",
        ),
        // A part of a default value that is not the first.
        (
            "init-member",
            "component c {\n  struct s { double x, heading; };\n  \
             function f(in s a = { .x = 1.0, .heading = 1.0 });\n};\n",
            ".heading",
            ".headng",
        ),
        // A state after a pause.
        (
            "fsm/undefined-state",
            "component c {\n  task t {\n    codel<start> main() yield loop;\n    \
             codel<loop> g() yield pause::loop, ether;\n  };\n};\n",
            "pause::loop",
            "pause::lop",
        ),
    ] {
        let broken = right.replace(part, misspelt);
        assert_ne!(broken, right);
        assert_eq!(first_fix(&broken, code), right, "{misspelt}");
    }
}

#[test]
fn what_is_used_and_declared_nowhere_can_be_declared() {
    for (code, source, expected) in [
        // Behind the others of its kind.
        (
            "unknown-type",
            "component c {\n  exception e_a;\n  exception e_b;\n\n  ids { long x; };\n\n  \
             function f() { throw lost; codel g(in x); };\n};\n",
            "--- Declare the exception `lost`\ncomponent c {\n  exception e_a;\n  exception e_b;\n  exception lost;\n\n  \
             ids { long x; };\n\n  function f() { throw lost; codel g(in x); };\n};\n",
        ),
        // The first of its kind is inserted before its use.
        (
            "task-unknown",
            "component c {\n  ids { long x; };\n\n  activity a() {\n    task t;\n    codel<start> f(out x) yield ether;\n  };\n};\n",
            "--- Declare the task `t`\ncomponent c {\n  ids { long x; };\n\n  task t { };\n\n  activity a() {\n    \
             task t;\n    codel<start> f(out x) yield ether;\n  };\n};\n",
        ),
        (
            "param-member",
            "component c {\n  ids {\n    long x;\n  };\n  function f() { codel g(ids in total); };\n};\n",
            "--- Add `long total` to the ids\ncomponent c {\n  ids {\n    long x;\n    long total;\n  };\n  \
             function f() { codel g(ids in total); };\n};\n",
        ),
        (
            "param-unknown-port",
            "typedef long a_data;\ncomponent c {\n  port in a_data a;\n\n  task t {\n    codel<start> g(port in b) yield ether;\n  };\n};\n",
            "--- Declare the input port `b`\ntypedef long a_data;\ntypedef long b_data;\n\ncomponent c {\n  port in a_data a;\n  \
             port in b_data b;\n\n  task t {\n    codel<start> g(port in b) yield ether;\n  };\n};\n",
        ),
        // In the existing task.
        (
            "service-unknown",
            "component c {\n  task t { };\n\n  function stop() {\n    interrupts go;\n  };\n};\n",
            "--- Declare the activity `go`\ncomponent c {\n  task t { };\n\n  activity go() { task t; \
             codel<start> go_start() yield ether; };\n\n  function stop() {\n    interrupts go;\n  };\n};\n",
        ),
        (
            "service-unknown",
            "component c {\n  function a() { };\n  function stop() { before go; };\n};\n",
            "--- Declare the function `go`\ncomponent c {\n  function a() { };\n  function go() { };\n  \
             function stop() { before go; };\n};\n",
        ),
        (
            "port-anonymous",
            "component c {\n  // The goal.\n  port in sequence<long> goal;\n};\n",
            "--- Name the type `goal_data`\ncomponent c {\n  typedef sequence<long> goal_data;\n  // The goal.\n  \
             port in goal_data goal;\n};\n",
        ),
        // With the members as used, before the comment of the declaration.
        (
            "unknown-type",
            "const long n = 1;\n\n// Moves.\ncomponent c {\n  ids { pose at; long x; };\n  port out pose state;\n  function f() {\n    \
             codel g(in at.x, port out state.y, ids in at.x, in x);\n  };\n};\n",
            "--- Declare the struct `pose`\nconst long n = 1;\n\nstruct pose {\n  double x;\n  double y;\n};\n\n// Moves.\n\
             component c {\n  ids { pose at; long x; };\n  port out pose state;\n  function f() {\n    \
             codel g(in at.x, port out state.y, ids in at.x, in x);\n  };\n};\n",
        ),
        // Types in a module stay there.
        (
            "unknown-type",
            "module m {\n  struct s { part p; };\n};\n",
            "--- Declare the struct `part`\nmodule m {\n  struct part {\n    double value;\n  };\n\n  struct s { part p; };\n};\n",
        ),
    ] {
        assert_eq!(fixed(source, code), expected);
    }
}
