//! The texts after fixes that remove the only finding.

use super::*;

#[test]
fn fixes_of_states_remove_what_they_mend() {
    let mut all = String::new();
    let state = "component c {\n  task t {\n    period 5 ms;\n    codel<start> f() yield mian;\n    codel<main> g() yield ether;\n  };\n};\n";
    all += &fixed(state, "fsm/undefined-state");
    let end =
        "component c {\n  task t {\n    period 5 ms;\n    codel<start> f() yield ethr;\n  };\n};\n";
    all += &fixed(end, "fsm/undefined-state");
    all += &fixed(
        "component c {\n  task t {\n    period 5 ms;\n    codel<start> f() yield ether;\n    codel<main> g() yield ether;\n  };\n};\n",
        "fsm/unreachable-state",
    );
    expect![[r"
        --- Change to `main`
        component c {
          task t {
            period 5 ms;
            codel<start> f() yield main;
            codel<main> g() yield ether;
          };
        };
        --- Declare a codel for the state `mian`
        component c {
          task t {
            period 5 ms;
            codel<start> f() yield mian;
            codel<mian> t_mian() yield ether;
            codel<main> g() yield ether;
          };
        };
        --- Change to `ether`
        component c {
          task t {
            period 5 ms;
            codel<start> f() yield ether;
          };
        };
        --- Declare a codel for the state `ethr`
        component c {
          task t {
            period 5 ms;
            codel<start> f() yield ethr;
            codel<ethr> t_ethr() yield ether;
          };
        };
        --- Let `f` yield `main`
        component c {
          task t {
            period 5 ms;
            codel<start> f() yield ether, main;
            codel<main> g() yield ether;
          };
        };
        --- Remove the codel `g`
        component c {
          task t {
            period 5 ms;
            codel<start> f() yield ether;
          };
        };
    "]]
    .assert_eq(&all);
}

#[test]
fn fixes_of_throws_remove_what_they_mend() {
    let mut all = String::new();
    all += &fixed(
        "module m { exception e_far; };\ncomponent c {\n  task t {\n    period 5 ms;\n    codel<start> f() yield e_far, ether;\n  };\n};\n",
        "throw/undeclared-use",
    );
    all += &fixed(
        "module m { exception e_far; };\ncomponent c {\n  task t { period 5 ms; };\n  activity a() {\n    task t;\n    codel<start> f() yield e_far;\n  };\n};\n",
        "throw/undeclared-use",
    );
    expect![[r"
        --- Throw `m::e_far` instead of yielding it
        module m { exception e_far; };
        component c {
          task t {
            period 5 ms;
            codel<start> f() yield ether;
            throw ::m::e_far;
          };
        };
        --- Throw `m::e_far` instead of yielding it
        module m { exception e_far; };
        component c {
          task t { period 5 ms; };
          activity a() {
            task t;
            codel<start> f() yield ether;
            throw ::m::e_far;
          };
        };
    "]]
    .assert_eq(&all);
}

#[test]
fn fixes_of_examples_remove_what_they_mend() {
    let mut all = String::new();
    for code in [
        "fsm/busy-loop",
        "fsm/no-termination",
        "fsm/missing-stop",
        "timing/missing-wcet",
        "service/blind-validate",
        "service/concurrent-instances",
        "unused/type",
        "lint/unused-suppression",
    ] {
        let page = Page::read(code).unwrap();
        all += &format!("=== {code}\n");
        all += &fixed(page.texts("genom", false)[0], code);
    }
    expect![[r"
        === fsm/busy-loop
        --- Pause before `main`
        component c {
          task t { period 5 ms;
            codel<start> f() yield main;
            codel<main> g() yield pause::main, ether;
          };
        };
        === fsm/no-termination
        --- Let `g` yield `ether`
        component c {
          task t { period 5 ms; };
          activity a() { task t;
            codel<start> f() yield run;
            codel<run> g() yield run, ether;
          };
        };
        --- Pause before `run`
        component c {
          task t { period 5 ms; };
          activity a() { task t;
            codel<start> f() yield run;
            codel<run> g() yield pause::run;
          };
        };
        === fsm/missing-stop
        --- Add the codel `go_stop`
        component c {
          ids { long speed; };
          task t { period 5 ms; };
          activity go() { task t; interrupts go;
            codel<start> f(out speed) yield pause::start, ether;
            codel<stop> go_stop() yield ether;
          };
        };
        === timing/missing-wcet
        --- Insert `wcet 1 ms` here, to be replaced by the measured time
        component c {
          task t { period 5 ms;
            codel<start> f() yield main wcet 10 us;
            codel<main> g() yield pause::main wcet 1 ms;
          };
        };
        === service/blind-validate
        --- Validate the new value
        component c {
          ids { long x; };
          attribute set(in x) { validate check(local in x); };
        };
        === service/concurrent-instances
        --- Let `go` interrupt itself
        component c {
          ids { long x; };
          task t { period 5 ms; };
          activity go() { task t; codel<start> f(out x) yield pause::start, ether; interrupts go; };
        };
        === unused/type
        --- Remove `s`
        component c {
          task t { codel<start> f() yield ether; };
        };
        === lint/unused-suppression
        --- Remove the comment
        component c {
          task t { codel<start> f() yield ether; };
        };
    "]]
    .assert_eq(&all);
}

#[test]
fn fixes_of_names_remove_what_they_mend() {
    let mut all = String::new();
    all += &fixed(
        "component c {\n  ids { long speed; };\n  task t { codel<start> f(in sped) yield ether; };\n};\n",
        "param-unknown",
    );
    all += &fixed(
        "module m { typedef long speed_t; };\ncomponent c {\n  ids { m::sped_t s; };\n};\n",
        "unknown-type",
    );
    all += &fixed(
        "component c {\n  exception a, b;\n  task t { throw a; codel<start> f() yield ether; };\n};\n",
        "unused/exception",
    );
    all += &fixed(
        "component c {\n  exception b { long x; }, a;\n  task t { throw a; codel<start> f() yield ether; };\n};\n",
        "unused/exception",
    );
    all += &fixed(
        "component c {\n  task t;\n  activity a() { task t;\n    local long x, y;\n    codel<start> f(out x) yield ether;\n  };\n};\n",
        "unused/local",
    );
    expect![[r"
        --- Change to `speed`
        component c {
          ids { long speed; };
          task t { codel<start> f(in speed) yield ether; };
        };
        --- Add `long sped` to the ids
        component c {
          ids { long speed; long sped; };
          task t { codel<start> f(in sped) yield ether; };
        };
        --- Declare the input port `sped`
        typedef long sped_data;

        component c {
          ids { long speed; };
          port in sped_data sped;

          task t { codel<start> f(in sped) yield ether; };
        };
        --- Change to `speed_t`
        module m { typedef long speed_t; };
        component c {
          ids { m::speed_t s; };
        };
        --- Remove `b`
        component c {
          exception a;
          task t { throw a; codel<start> f() yield ether; };
        };
        --- Remove `b`
        component c {
          exception a;
          task t { throw a; codel<start> f() yield ether; };
        };
        --- Remove `y`
        component c {
          task t;
          activity a() { task t;
            local long x;
            codel<start> f(out x) yield ether;
          };
        };
    "]]
    .assert_eq(&all);
}
