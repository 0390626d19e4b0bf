use super::*;

fn index(text: &str) -> SourceIndex {
    SourceIndex::new(text, Grammar::C)
}

fn cxx(text: &str) -> SourceIndex {
    SourceIndex::new(text, Grammar::Cxx)
}

fn names(index: &SourceIndex) -> Vec<&str> {
    index.functions.iter().map(|function| function.name.as_str()).collect()
}

#[test]
fn signatures() {
    let text = "genom_event\nf(const a_b *x, double m[2][3], struct s v, char **argv,\n  \
                const int32_t (*p)[3], unsigned long int n, int (*cb)(int), const genom_context self)\n{\n}\n";
    let index = index(text);
    let f = &index.functions[0];
    assert!(f.known && f.body.is_some() && !f.is_static);
    assert_eq!(f.result, CType::plain("genom_event"));
    let shown: Vec<String> = f
        .parameters
        .iter()
        .map(|parameter| format!("{} {:?}", parameter.name.as_deref().unwrap_or("-"), parameter.ty))
        .collect();
    insta::assert_snapshot!(shown.join("\n"), @r#"
    x CType { base: "a_b", constant: true, layers: [Pointer { constant: false }] }
    m CType { base: "double", constant: false, layers: [Array { length: Some("2") }, Array { length: Some("3") }] }
    v CType { base: "s", constant: false, layers: [] }
    argv CType { base: "char", constant: false, layers: [Pointer { constant: false }, Pointer { constant: false }] }
    p CType { base: "int32_t", constant: true, layers: [Pointer { constant: false }, Array { length: Some("3") }] }
    n CType { base: "unsigned long", constant: false, layers: [] }
    cb CType { base: "int32_t", constant: false, layers: [Pointer { constant: false }, Function { parameters: "(int)" }] }
    self CType { base: "genom_context", constant: true, layers: [] }
    "#);
    assert_eq!(&text[f.signature_span.clone()], text.split("\n{").next().unwrap());
    assert_eq!(&text[f.name_span.clone()], "f");
}

#[test]
fn attributes_are_read_over() {
    for attribute in ["__attribute__((unused))", "__attribute ((section(\".text;)\"), cold))"] {
        for read in [index, cxx] {
            let index = read(&format!(
                "static {attribute} int\nf(int a {attribute}, {attribute} const double *b) {attribute};\n\
                 int {attribute} f(int a {attribute}, double {attribute} *b)\n\
                 {{ int {attribute} c = a; label: {attribute}; return (*b {attribute}); }}\n"
            ));
            let known = index.functions.iter().all(|function| function.known);
            assert!(known && names(&index) == ["f", "f"], "{index:#?}");
            assert!(index.loose.is_empty(), "{index:#?}");
            assert_eq!(index.functions[0].parameters[1].ty.base, "double");
        }
    }
    let spliced = index("#define A __attribute__((a, \\\n b)) int\nint g(void) { return 1; }\n");
    assert_eq!(names(&spliced), ["g"]);
    assert!(spliced.loose.is_empty(), "{spliced:#?}");
    let unfinished =
        index("int f(int a __attribute__((unused { return 1; }\nint g(void) { return 2; }");
    assert!(unfinished.loose.contains("g"), "{unfinished:#?}");
}

#[test]
fn scopes_and_linkage() {
    let index = cxx("namespace a::b { int f(void) {} namespace { void g() {} } }\n\
        extern \"C\" { void h() {} void p(); }\nvoid C::m() {}\nstatic inline int s() { return 0; }\n");
    let shown: Vec<String> = index
        .functions
        .iter()
        .map(|function| {
            let global = if function.is_global() { "" } else { " hidden" };
            let kind = if function.body.is_some() { "" } else { " prototype" };
            let link = if function.is_static { " static" } else { "" };
            format!("{}::{}{global}{kind}{link}", function.scope.join("::"), function.name)
        })
        .collect();
    assert_eq!(
        shown,
        ["a::b::f hidden", "a::b::::g hidden", "::h", "::p prototype", "C::m hidden", "::s static"]
    );
}

#[test]
fn functions_are_found_among_macros_and_directives() {
    let index = index(
        "MACRO(x)\nDEFINE_CODEL(hidden)\n#ifdef A\nint f(int a) {}\n#else\nint f(long a) {}\n#endif\n\
         int g(void) { return }\n",
    );
    assert_eq!(names(&index), ["f", "f", "g"]);
    assert!(index.functions[2].body.as_ref().unwrap().broken);
    assert!(index.loose.contains("hidden"), "{:?}", index.loose);
}

/// A half-typed declaration hides no later function: the function is found, mentioned in a broken body, or a
/// loose name.
#[test]
fn half_typed_code_hides_nothing() {
    for text in [
        "int broken(int a { if (\n}\nint g(void) { return 1; }\n",
        "int broken(int a) { if (a) {\n\nint g(void) { return 1; }\n",
        "int broken(\n\nint g(void) { return 1; }\n",
        "int x = {\nint g(void) { return 1; }\n",
    ] {
        let index = index(text);
        let swallowed = index
            .functions
            .iter()
            .filter_map(|function| function.body.as_ref())
            .any(|body| body.broken && body.mentions.contains("g"));
        let found = names(&index).contains(&"g");
        assert!(found || swallowed || index.loose.contains("g"), "{text}: {index:#?}");
    }
}

#[test]
fn returned_values_follow_variables_and_branches() {
    let index = index(
        "genom_event f(int p, const genom_context self) {\n\
         genom_event e = c_a, q; q = (c_b);\n\
         if (p) return e; if (p == 2) return p ? c_c : (genom_event)c_d;\n\
         if (p == 3) return helper(p, self);\n  g(&unknown); return p; }\n",
    );
    let body = index.functions[0].body.as_ref().unwrap();
    let shown: Vec<String> = body
        .returns
        .iter()
        .map(|result| {
            let values = result.values.iter().map(|value| match value {
                Value::Name { name, variable, .. } => {
                    format!("{name}{}", if *variable { "~" } else { "" })
                }
                Value::Call { call, .. } => format!("{}()", body.calls[*call].name),
                Value::Unknown => "?".into(),
            });
            values.collect::<Vec<_>>().join(" ")
        })
        .collect();
    assert_eq!(shown, ["c_a~", "c_c c_d", "helper()", "?"]);
    assert_eq!(body.calls[0].last.as_deref(), Some("self"));
}

#[test]
fn lambdas_and_throws_of_cxx() {
    let index = cxx(
        "genom::event f() { auto l = []{ return 1; }; throw c::e_foo(); throw e_bar{}; throw; \
         return c::pause::x; }",
    );
    let body = index.functions[0].body.as_ref().unwrap();
    assert_eq!(body.returns.len(), 1);
    assert!(
        matches!(&body.returns[0].values[..], [Value::Name { name, .. }] if name == "c::pause::x")
    );
    let throws: Vec<&str> = body.throws.iter().map(|exception| exception.name.as_str()).collect();
    assert_eq!(throws, ["c::e_foo", "e_bar"]);
}

#[test]
fn generated_comments() {
    let text = "/** Codel other of task t.\n *\n * Yields to c_x.\n */\n/* already defined */\n\n\
        /** Codel f of activity a.\n *\n * Triggered by c_start, c_pause_b,\n * c_c.\n * Yields to c_x.\n\
         * Throws c_e_one.\n */\n/* mine */\ngenom_event f(void) {}\n\
        // Codel g of service s. Yields to start, ether.\n// More.\nvoid g() {}\n\
        /* Codel g is fine. */\nvoid h() {}\n";
    let index = index(text);
    let comments = |at: usize| &index.functions[at].comments;
    let f = &comments(0)[1];
    let comment = f.generated.as_ref().unwrap();
    assert_eq!(
        (comment.codel.as_str(), comment.owner_kind.as_str(), comment.owner.as_str()),
        ("f", "activity", "a")
    );
    assert_eq!(comment.triggers.as_deref().unwrap(), ["c_start", "c_pause_b", "c_c"]);
    assert_eq!(comment.yields.as_deref().unwrap(), ["c_x"]);
    assert_eq!(comment.throws.as_deref().unwrap(), ["c_e_one"]);
    assert_eq!(&text[comment.header.clone()], "Codel f of activity a");
    assert!(text[comment.sentences.clone()].starts_with("Triggered by"));
    assert!(text[comment.sentences.clone()].ends_with("c_e_one."));
    assert_eq!(comments(0).len(), 4);
    let g = comments(1)[0].generated.as_ref().unwrap();
    assert_eq!(g.yields.as_deref().unwrap(), ["start", "ether"]);
    assert_eq!(comments(1).len(), 1, "lines are one comment");
    assert!(comments(2)[0].generated.is_none());
}

#[test]
fn names_macros_and_includes() {
    let index = index(
        "#include \"a.h\"\n#include <b.h>\n#define RET(x) do { return x; } while (0)\n#define PASTE(a) a##_b\n\
         typedef struct s { int a; } s_t;\nstatic int global = 1, *other;\nenum color { RED };\n",
    );
    let includes: Vec<&str> = index.includes.iter().map(|include| include.path.as_str()).collect();
    assert_eq!(includes, ["a.h", "b.h"]);
    assert!(index.macros[0].returns && !index.macros[0].pastes && index.macros[1].pastes);
    for name in ["s_t", "global", "other", "color"] {
        assert!(index.names.contains(name), "{name}");
    }
}

#[test]
fn mentions_are_identifiers_only() {
    let text = "/* f */ void f(); int x() { f(); return \"f\"[0]; }";
    let found: Vec<usize> =
        mentions(text, Grammar::C, "f").iter().map(|mention| mention.start).collect();
    assert_eq!(found, [13, text.rfind("f();").unwrap()]);
}

#[test]
fn garbage_is_read_without_panic() {
    for text in
        ["", "{", "(((((", "return return", "}}}}{{{{", "int f(", "\u{0}\u{1}é{", "#if\n#if\n"]
    {
        index(text);
        cxx(text);
    }
    let deep = format!("int f(void) {{ return {}1{}; }}", "(".repeat(20_000), ")".repeat(20_000));
    index(&deep);
    let chain = format!("int f(int a) {{ return {}1; }}", "a ? 1 : ".repeat(5_000));
    cxx(&chain);
}

#[test]
fn names_that_a_function_does_not_declare() {
    let free = |index: &SourceIndex| -> Vec<String> {
        let bodies = index.functions.iter().filter_map(|function| function.body.as_ref());
        let names = bodies.flat_map(|body| &body.free);
        names.map(|name| name.0.to_string()).collect()
    };
    let c = index(
        "int f(int a, int b[2]) { int c = a, *d = &e; for (int i = 0; i < g; i++) { c += i + b[i] + g; }\n\
         enum { H, I = 2 }; struct { int a; } s = { .j = k }; call(l, s.m, H); goto out; out: return *d; }\n\
         int g(void) {\n#ifdef X\n  int n = o;\n#endif\n  FOR_EACH(p, list) { use(p); }\n  return n; }\n",
    );
    assert_eq!(free(&c), ["e", "g", "k"]);
    let cxx = cxx("int f(int a) { auto [b, c] = pair(); for (auto &d : e) { use(d, b, c); }\n\
         auto h = [g](int i) { return i + g; }; try { h(a); } catch (error &x) { log(x); }\n\
         return std::max(j, 2) + k::l; }");
    assert_eq!(free(&cxx), ["e", "j"]);
}

#[test]
fn writes_to_what_a_parameter_only_reads() {
    let index = index(
        "void f(const s *a, s *b, const double *c, const s d[2], const char *const *e, s g) {\n\
         a->x = 1; (*a).x.y += 1; a->p->x = 2; a->list[0] = 3; *b = 4; *c = 5; (*c)++; c[1] = 6; d[0].x = 7;\n\
         *e = 0; a = 0; g.x = 8; b->x = 9; if (a->x == 1) return; }\n\
         void h(const s *a) { { s *a = other; a->x = 1; } }\n",
    );
    let text = "a->x|(*a).x.y|*c|(*c)|c[1]|d[0].x";
    let body = index.functions[0].body.as_ref().expect("a body");
    let found: Vec<&str> =
        body.constant_writes.iter().map(|constant_write| constant_write.0.as_str()).collect();
    assert_eq!(found, ["a", "a", "c", "c", "c", "d"], "{text}");
    let body = index.functions[1].body.as_ref().expect("a body");
    assert!(body.constant_writes.is_empty());
}
