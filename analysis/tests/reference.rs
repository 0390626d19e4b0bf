//! Surprising texts that the reference compiler, release 2.99.39, accepts or rejects. Each text was tried
//! with it.

use std::sync::Arc;

use dotgen_analysis::{
    diagnostic::Severity,
    host::{AnalysisHost, BatchInput, Change, Config, Input},
    release::{Release, ReleaseChoice, ReleaseOrigin},
};
use dotgen_loaders::EmptyLoader;

/// Codes and messages of the diagnostics of this severity.
fn found(text: &str, severity: Severity) -> Vec<(&'static str, String)> {
    let mut host = AnalysisHost::new(Arc::new(EmptyLoader));
    host.apply(Change {
        config: Some(Config {
            release: Some(ReleaseChoice {
                release: Release::V2_99_39,
                origin: ReleaseOrigin::CommandLine,
            }),
            ..Config::default()
        }),
        ..Change::default()
    });
    let input = BatchInput {
        inputs: vec![Input::Text { name: "/fixture/main.gen".into(), text: text.into() }],
        ..BatchInput::default()
    };
    let unit = host.analysis().batch(&input).unwrap();
    let all = unit.diagnostics.iter();
    all.filter(|diagnostic| diagnostic.severity == severity)
        .map(|diagnostic| (diagnostic.code, diagnostic.message.to_string()))
        .collect()
}

#[track_caller]
fn taken(texts: &[&str]) {
    for text in texts {
        let errors = found(text, Severity::Error);
        assert!(errors.is_empty(), "{text}\n{errors:#?}");
    }
}

#[track_caller]
fn refused(texts: &[(&str, &str)]) {
    for (text, code) in texts {
        let errors = found(text, Severity::Error);
        let codes: Vec<&str> = errors.iter().map(|error| error.0).collect();
        assert_eq!(codes, [*code], "{text}\n{errors:#?}");
    }
}

#[test]
fn members_hide_no_types_and_constants() {
    taken(&[
        "typedef long t; struct s { t t; t u; };",
        "typedef long t; union u switch (long) { case 1: double t; case 2: t x; };",
        "typedef long t; exception e { long t; t u; };",
        "const long N = 3; struct s { long N; long a[N]; };",
        "typedef long t; component c { ids { double t; t u; }; };",
        "struct a { long b; }; struct s { a a; sequence<a, 2> more; };",
    ]);
    refused(&[("struct s { long t; t u; };", "unknown-type")]);
}

#[test]
fn whatever_has_a_name_is_a_type() {
    let texts = [
        "const long N = 1; struct s { N x; }; const N M = 2;",
        "enum e { A }; typedef sequence<A> t; component c { port in t p; };",
        "typedef long t; component c { port in t p; ids { p x; }; function f(in p x); };",
        "component c { function f(in start x) { local ether y; codel g(in x); }; };",
        "interface i { function f(); }; component c { uses i; ids { f x; }; };",
        "const long k = 1; union u switch (k) { case 1: long x; };",
    ];
    taken(&texts);
    for text in texts {
        let warnings = found(text, Severity::Warning);
        assert!(warnings.iter().any(|warning| warning.0 == "not-a-type"), "{text}");
    }
    refused(&[
        ("enum e { A }; const A k = A;", "const-type"),
        ("enum e { A }; union u switch (A) { case A: long x; };", "union-switch-type"),
        (
            "component c { function f(in start x) { codel g(in x); }; task t { codel<start> g() yields \
                ether; }; };",
            "codel-conflict",
        ),
    ]);
}

#[test]
fn exceptions_without_members_are_elements() {
    taken(&["exception e; typedef sequence<e> t; typedef optional<e> u;"]);
    refused(&[("exception e; typedef e t;", "void-exception-type")]);
}

#[test]
fn empty_braces_give_no_value() {
    taken(&[
        "component c { function f(in long x = {}); };",
        "component c { function f(in long x = {{}, {}}); };",
        "struct s { long a; string b; }; component c { function f(in s x = { {}, 1, {}, \"b\" }); };",
        "struct s { long a; string b; }; component c { function f(in s x = { .b = {}, .a = {} }); };",
        "component c { function f(in long x[2] = { 1, {}, 2, {} }); };",
        "component c { function f(in long x[2] = { , 1, 2 }); };",
    ]);
    refused(&[
        ("component c { function f(in long x = { 1 }); };", "init-compound-scalar"),
        ("component c { function f(in long x[2] = { , }); };", "syntax"),
        ("component c { function f(in long x[2] = { 1, , 2 }); };", "syntax"),
        ("component c { function f(in long x[2] = { 1, {}, 2, 3 }); };", "init-bounds"),
    ]);
}

#[test]
fn a_codel_for_ether_keeps_machines_from_ending() {
    taken(&[
        "component c { task t; activity a() { task t; codel<start> f() yields ether; codel<ether> g() \
            yields ether; }; };",
    ]);
    refused(&[(
        "component c { task t; activity a() { task t; codel<start> f() yields ether; codel<stop> h() yields ether;
         codel<ether> g() yields ether; }; };",
        "fsm/stop-without-ether",
    )]);
}

#[test]
fn the_ids_of_a_component_take_their_name_when_it_begins() {
    taken(&[
        "component c { typedef long ids; };",
        "module c { module ids { }; }; component c { };",
        "component c { task ids { period 1; }; task t; activity ids() { task ids; codel<start> f() yields \
            ether; }; };",
    ]);
    refused(&[
        ("module c { typedef long ids; }; component c { };", "name-clash"),
        ("component ids;", "name-clash-enclosing"),
        ("interface ids;", "name-clash-enclosing"),
        ("component c { typedef long ids; ids { long x; }; };", "name-clash"),
    ]);
}

#[test]
fn the_ids_are_a_type_once_there_are_some() {
    taken(&[
        "component c { ids { struct t { long x; } a; ids::t b; }; typedef sequence<ids> t; };",
    ]);
    refused(&[
        ("component c { ids { ids again; }; };", "unknown-type"),
        ("component c { typedef ids t; ids { long x; }; };", "unknown-type"),
    ]);
}

#[test]
fn misplaced_codels_are_read() {
    for (text, code) in [
        (
            "component c { task t; activity a() { task t; codel<start> f() yields ether; codel g(in nope); \
                }; };",
            "service-simple-codel",
        ),
        (
            "component c { function f() { codel<start> g(in nope) yields ether; }; };",
            "service-fsm-codel",
        ),
        ("component c { task t { codel g(in nope); }; };", "codel-in-task"),
    ] {
        let errors = found(text, Severity::Error);
        let mut codes: Vec<&str> = errors.iter().map(|error| error.0).collect();
        codes.sort_unstable();
        let mut wanted = [code, "param-unknown"];
        wanted.sort_unstable();
        assert_eq!(codes, wanted, "{text}\n{errors:#?}");
    }
}

#[test]
fn local_variables_are_declared_once_in_a_declaration() {
    taken(&[
        "component c { function f() { local long x; }; function f() { local long y; local long x; }; };",
    ]);
    refused(&[
        ("component c { function f() { local long x; local long x; }; };", "param-duplicate"),
        (
            "component c { function f() { local long x; }; function f() { local long x; local long x; }; };",
            "param-duplicate",
        ),
    ]);
}

#[test]
fn an_interface_that_names_itself_imports_itself() {
    taken(&[
        "interface i { doc \"d\"; ids { long x; }; task t; function f(); extends i; };",
        "interface i { extends i; typedef long t; port in t p; };",
    ]);
    refused(&[
        ("interface i { version \"1\"; extends i; };", "prop-duplicate"),
        ("interface i { typedef long t; port in t p; provides i; };", "name-clash"),
        ("interface i { function f(); uses i; };", "redefinition"),
        ("interface i { function f() { codel g(); }; extends i; };", "prop-duplicate"),
    ]);
}

#[test]
fn what_an_interface_imports_by_the_same_property_comes_twice() {
    taken(&[
        "interface i { typedef long t; port in t p; }; interface j { extends i; }; component c { provides \
            j; };",
        "interface i { typedef long t; port in t p; }; interface j { provides i; }; interface e { };
         component c { provides e; provides j; };",
        "interface i { function f(); ids { long x; }; }; interface j { provides i; }; component c { \
            provides j; };",
    ]);
    refused(&[
        (
            "interface i { typedef long t; port in t p; }; interface j { provides i; }; component c { \
                provides j; };",
            "name-clash",
        ),
        (
            "interface i { typedef long t; port in t p; }; interface j { extends i; }; interface k { \
                extends j; };",
            "name-clash",
        ),
        (
            "interface i { function f(); }; interface j { uses i; }; component c { uses j; };",
            "name-clash",
        ),
        (
            "interface i { codels-requires \"r\"; lang \"c\"; }; component c { provides i; extends i; };",
            "prop-duplicate",
        ),
    ]);
}

#[test]
fn imported_codels_are_not_compared() {
    taken(&["interface i { ids { long x; }; function f() { codel g(in ::all); }; };
         component c { ids { double y; }; provides i; function h() { codel g(in ::all); }; };"]);
    refused(&[(
        "interface i { ids { long x; }; function f() { codel g(in ::all); }; };
         component c { ids { double y; }; function h() { codel g(in ::all); }; };",
        "codel-conflict",
    )]);
}

#[test]
fn comments_in_pragmas_are_words() {
    taken(&[
        "interface i { };\n#pragma provides i\ncomponent c { };\n",
        "typedef long t;\n#pragma masquerade ros t L\"wide \\\"text\\\"\"\n",
        "#pragma unknown /* fine */ // fine\n",
    ]);
    refused(&[
        ("interface i { };\n#pragma provides i // why\n", "pragma-provides-unknown"),
        (
            "typedef long t;\n#pragma masquerade ros t \"text\" /* why */\n",
            "pragma-masquerade-syntax",
        ),
    ]);
}

#[test]
fn directives_that_one_would_not_write() {
    taken(&[
        "#define f(x) x\nconst long f = 1;\nconst long a = f /* no call */;\n",
        "#define defined 3\nconst long a = defined;\n",
        "#if 1\n#else\n#elif 1\nconst long a = 1;\n#endif\nconst long b = a;\n",
    ]);
    refused(&[("#line 3 \"a\" \"b\"\n", "pp-line-bad")]);
    let errors = found("#define f(x) x\nconst long a = f /* c */ (1);\n", Severity::Error);
    assert!(!errors.is_empty());
}
