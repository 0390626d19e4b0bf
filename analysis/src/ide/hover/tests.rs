//! The texts of hovers.

use expect_test::{Expect, expect};

use crate::test_support::Fixture;

#[track_caller]
fn check(text: &str, expected: Expect) {
    let fixture = Fixture::new(text);
    let hover = fixture.analysis().hover(&fixture.at()).unwrap();
    let text = hover.map_or_else(String::new, |hover| {
        let text = fixture.text(fixture.at().path.as_str());
        format!("[{}]\n{}\n", &text[hover.range], hover.info.markdown)
    });
    expected.assert_eq(&text);
}

#[test]
fn types() {
    check(
        "module m { struct s { long x; double /* y */ y[3]; }; };\ntypedef m::s$0 t;\n",
        expect![[r"
            [s]
            ```genom
            struct s {
              long x;
              double y[3];
            }
            ```

            in `m` · 28 bytes packed
        "]],
    );
    check(
        "typedef sequence<string<8>, 4> t;\nstruct s { t$0 x; };\n",
        expect![[r"
            [t]
            ```genom
            typedef sequence<string<8>, 4> t;
            ```

            type `sequence<string<8>, 4>`
        "]],
    );
    check(
        "enum e { A, B };\nunion u switch (e) { case A: long a; default: float b; };\ntypedef u$0 t;\n",
        expect![[r"
            [u]
            ```genom
            union u switch(e) {
              case A: long a;
              default: float b;
            }
            ```
        "]],
    );
    check(
        "enum e { A, B };\nconst e x = B$0;\n",
        expect![[r"
            [B]
            ```genom
            B
            ```

            in `e` · value 1 of enum `e`
        "]],
    );
}

#[test]
fn constants_have_values() {
    check(
        "const unsigned long n = 2 * 3;\ntypedef long a[n$0];\n",
        expect![[r"
            [n]
            ```genom
            const unsigned long n = 2 * 3;
            ```

            type `unsigned long` · value `6`
        "]],
    );
    check(
        "const unsigned long n$0 = 4096;\n",
        expect![[r"
            [n]
            ```genom
            const unsigned long n = 4096;
            ```

            type `unsigned long` · value `4096` (`0x1000`)
        "]],
    );
    check(
        "const double half = 1 / 2.0;\nconst double x = half$0;\n",
        expect![[r"
            [half]
            ```genom
            const double half = 1 / 2.0;
            ```

            type `double` · value `0.5`
        "]],
    );
    check(
        "const string s$0 = \"a\" \"b\";\n",
        expect![[r#"
            [s]
            ```genom
            const string s = "a" "b";
            ```

            type `string` · value `"ab"`
        "#]],
    );
}

/// A component with the cursor at a mark.
fn component_at(mark: &str) -> String {
    r#"
struct st { long a, b; };
component c {
  doc "What it is.";
  ids { st v; };
  task t { doc "Main."; period 10ms; };
  port out st p { doc "Out."; };
  attribute set(in v.a = 3 : "the a");
  activity go(in long speed = 2 : "in m/s") {
    doc "Goes.";
    task t;
    local st before, after;
    codel<start> begin(local in speed, ids out v.b, port out p) yield pause::start, ether;
  };
};
"#
    .replacen(&mark.replace("$0", ""), mark, 1)
}

#[test]
fn components_and_their_data() {
    check(
        &component_at("component c$0"),
        expect![[r"
            [c]
            ```genom
            component c { … };
            ```

            What it is.
        "]],
    );
    check(
        &component_at("task t$0 {"),
        expect![[r#"
                [t]
                ```genom
                task t {
                  doc "Main.";
                  period 10 ms;
                };
                ```

                in `c`

                Main.

                * runs `go`
            "#]],
    );
    check(
        &component_at("port out st p$0"),
        expect![[r#"
            [p]
            ```genom
            port out st p {
              doc "Out.";
            };
            ```

            in `c` · type `struct st (2 members)` · 8 bytes packed

            Out.
        "#]],
    );
    check(
        &component_at("ids out v$0"),
        expect![[r"
            [v]
            ```genom
            st v;
            ```

            in `ids` · type `struct st (2 members)` · 8 bytes packed
        "]],
    );
    check(
        &component_at("ids$0 {"),
        expect![[r"
            [ids]
            ```genom
            ids {
              st v;
            };
            ```

            in `c`
        "]],
    );
}

#[test]
fn services_and_their_parameters() {
    check(
        &component_at("attribute set$0"),
        expect![[r#"
                [set]
                ```genom
                attribute set(in v.a = 3 : "the a");
                ```

                in `c`
            "#]],
    );
    check(
        &component_at("activity go$0"),
        expect![[r#"
                [go]
                ```genom
                activity go(in long speed = 2 : "in m/s") {
                  doc "Goes.";
                  task t;
                  local st before, after;
                  codel<start> begin(local in speed, ids out v.b, port out p) yield pause::start, ether;
                };
                ```

                in `c`

                Goes.
            "#]],
    );
    check(
        &component_at("local in speed$0"),
        expect![[r#"
            [speed]
            ```genom
            in long speed = 2 : "in m/s"
            ```

            in `go` · type `long` · 4 bytes packed

            in m/s
        "#]],
    );
    check(
        &component_at(", after$0"),
        expect![[r"
            [after]
            ```genom
            local st before, after;
            ```

            in `go` · type `struct st (2 members)` · 8 bytes packed
        "]],
    );
}

#[test]
fn codels_and_states() {
    check(
        &component_at("begin$0"),
        expect![[r"
                [begin]
                ```genom
                codel<start> begin(local in speed, ids out v.b, port out p) yield pause::start, ether;
                ```

                * activity `go`: called from the start, `begin`, after a pause
            "]],
    );
    check(
        &component_at("<start$0"),
        expect![[r"
                [start]
                ```genom
                state start
                ```

                in `c`

                * activity `go`: from `begin` → `begin` → `pause::start`, `ether`
            "]],
    );
}

#[test]
fn macros_and_includes() {
    check(
        "#define N  (4 /* four */ + 1)\ntypedef long a[N$0];\n",
        expect![[r"
            [N]
            ```genom
            #define N (4 + 1)
            ```

            expands to

            ```genom
            (4 + 1)
            ```
        "]],
    );
    check(
        "#define F(x, y) sequence<x, y>\ntypedef F$0(long, 3) a;\n",
        expect![[r"
            [F]
            ```genom
            #define F(x, y) sequence<x, y>
            ```

            expands to

            ```genom
            sequence<long, 3>
            ```
        "]],
    );
    check(
        "#if __GENOM__$0 > 1\n#endif\n",
        expect![[r"
            [__GENOM__]
            macro `__GENOM__` (predefined or from the command line)
        "]],
    );
    check(
        "//- /main.gen\n#include \"t$0.idl\"\n//- /t.idl\n",
        expect![[r"
            [t.idl]
            `/t.idl`
        "]],
    );
    check(
        "//- /a/main.gen\n#include \"b/t$0.idl\"\n",
        expect![[r"
            [b/t.idl]
            `b/t.idl` is not found. Looked for in, in order:

            - `/a`
        "]],
    );
    check("//- /main.gen\n#if 0\n#include \"t$0.idl\"\n#endif\n", expect![""]);
}

#[test]
fn values_stay_on_their_line() {
    check(
        "struct p { long x; long y[2]; };\ncomponent c { ids { long a; }; function f$0(in p v={1,.y={[1]=2}}:\"where\",out long n) { codel g(out n); }; };\n",
        expect![[r#"
                [f]
                ```genom
                function f(in p v = { 1, .y = { [1] = 2 } } : "where", out long n) {
                  codel g(out n);
                };
                ```

                in `c`
            "#]],
    );
    check(
        "union u switch (long) { case 1: long x; };\ntypedef u$0 t;\n",
        expect![[r"
                [u]
                ```genom
                union u switch(long) {
                  case 1: long x;
                }
                ```
            "]],
    );
}

/// An interface that a component completes, with the cursor at a mark.
fn completed_at(mark: &str) -> String {
    r#"
//- /i.gen
interface i {
  function halt() { doc "Stops."; };
  activity go(in long x);
  task t;
};
//- /main.gen
#include "i.gen"
component c {
  provides i;
  ids { long v; };
  task main { period 5 ms; };
  function halt() { doc "At once."; codel f(out v); interrupts go; };
  activity go(in long x) { task main; codel<start> g(in x) yield ether; };
};
component d { provides i; function other() { interrupts halt; }; };
"#
    .replacen(&mark.replace("$0", ""), mark, 1)
}

#[test]
fn what_completes_an_interface_shows_itself() {
    check(
        &completed_at("function halt$0() { doc \"At"),
        expect![[r#"
            [halt]
            ```genom
            function halt() {
              doc "At once.";
              codel f(out v);
              interrupts go;
            };
            ```

            in `c` · implements `halt` of the interface `i` from `i.gen`

            Stops.
            At once.
        "#]],
    );
    // Also where the component uses it.
    check(
        &completed_at("interrupts go$0"),
        expect![[r"
            [go]
            ```genom
            activity go(in long x) {
              task main;
              codel<start> g(in x) yield ether;
            };
            ```

            in `c` · implements `go` of the interface `i` from `i.gen`

            * interrupted by `halt`
        "]],
    );
}

/// A component without a declaration of its own shows that of the interface.
#[test]
fn what_an_interface_declares_shows_the_interface() {
    check(
        &completed_at("interrupts halt$0"),
        expect![[r#"
            [halt]
            ```genom
            function halt() {
              doc "Stops.";
            };
            ```

            in `i` · from `i.gen`

            Stops.
        "#]],
    );
    check(
        &completed_at("function halt$0() { doc \"Stops"),
        expect![[r#"
            [halt]
            ```genom
            function halt() {
              doc "Stops.";
            };
            ```

            in `i`

            Stops.

            *as included by `main.gen`*
        "#]],
    );
}

#[test]
fn headers_name_the_unit_that_shows_them() {
    check(
        "//- /main.gen\n#include \"t.idl\"\n//- /t.idl\ntypedef long t$0;\n",
        expect![[r"
                [t]
                ```genom
                typedef long t;
                ```

                type `long` · 4 bytes packed

                *as included by `main.gen`*
            "]],
    );
}

#[test]
fn a_state_tells_the_machine_it_is_seen_in_first() {
    let text = "component c {\n  task t { codel<start> f() yield main; codel<main> g() yield ether; };\n  \
                activity a() { task t; codel<start> h() yield main; codel<main> k() yield ether; };\n};\n";
    let machines = |mark: &str| {
        let fixture = Fixture::new(&text.replacen(mark, &format!("{mark}$0"), 1));
        let hover = fixture.analysis().hover(&fixture.at()).unwrap();
        let text = hover.expect("it is a name").info.markdown;
        let lines = text.lines().filter(|line| line.starts_with("* "));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let of_task = "* task `t`: from `f` → `g` → `ether`";
    let of_activity = "* activity `a`: from `h` → `k` → `ether`";
    assert_eq!(machines("f() yield ma"), [of_task, of_activity]);
    assert_eq!(machines("h() yield ma"), [of_activity, of_task]);
}

#[test]
fn long_lists_of_parameters_are_wrapped() {
    check(
        "component c { task t; activity go$0(in double first = 1. : \"the first of many\", in double second = { 2. } : \"another\", in double third) { task t; }; };\n",
        expect![[r#"
            [go]
            ```genom
            activity go(in double first = 1. : "the first of many", in double second = { 2. } : "another",
                in double third) {
              task t;
            };
            ```

            in `c`
        "#]],
    );
}

#[test]
fn a_doc_is_no_markdown() {
    let fixture = Fixture::new(
        "component c { function f$0() { doc \"<b>*x*</b> [y](command:z) a_b # `\"; }; };\n",
    );
    let hover = fixture.analysis().hover(&fixture.at()).unwrap();
    let text = hover.map(|hover| hover.info.markdown).unwrap_or_default();
    let escaped = "\\<b\\>\\*x\\*\\</b\\> \\[y\\](command:z) a_b # \\`";
    assert!(text.contains(escaped), "{text}");
}
