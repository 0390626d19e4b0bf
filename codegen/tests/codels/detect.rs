//! Small cases of what is drift and what is not.

use dotgen_codegen::codels::drift::{CODES, Drift, Repair};
use dotgen_codegen::codels::edit::apply;
use dotgen_codegen::codels::repair::Repairs;
use dotgen_codegen::codels::stub::StubOptions;

use dotgen_loaders::pages::Page;

use crate::codels::support::Fixture;

/// A component with one task; `params` are those of its codel `f`.
fn task(types: &str, params: &str, yields: &str) -> String {
    format!(
        "component c {{\n  {types}\n  exception e_one; exception e_two {{ short n; }};\n  task t {{\n    \
         codel<start> f({params}) yield {yields};\n    codel<main> g() yield ether;\n    \
         throw e_one;\n  }};\n}};\n"
    )
}

const G: &str = "genom_event g(const genom_context self) { return c_ether; }\n";

/// Findings of a task whose codel `f` has this function.
fn report(types: &str, params: &str, yields: &str, f: &str) -> Vec<String> {
    let spec = task(types, params, yields);
    Fixture::new(&spec, &[("c_t_codels.c", &format!("{G}{f}"))]).report()
}

#[track_caller]
fn silent(types: &str, params: &str, yields: &str, f: &str) {
    assert_eq!(report(types, params, yields, f), Vec::<String>::new());
}

#[track_caller]
fn one(types: &str, params: &str, yields: &str, f: &str, wanted: &str) {
    let found = report(types, params, yields, f);
    assert!(found.len() == 1 && found[0].contains(wanted), "{found:#?}");
}

const IDS: &str = "struct s { long a; }; typedef double vec[3]; typedef s alias; enum color { RED };\n  \
    ids { s v; double w; long n; vec p; color k; unsigned long long big; string<8> text; sequence<s> many; };";

#[test]
fn equal_types_have_many_spellings() {
    for (param, spelling) in [
        ("in v", "struct c_s const * v"),
        ("in v", "const struct c_s v[1]"),
        ("in v", "c_s const *const v"),
        ("in n", "int n"),
        ("in n", "const signed int n"),
        ("in n", "int32_t"),
        ("in p", "const double p[3]"),
        ("in p", "const double *p"),
        ("in p", "const double p[]"),
        ("in k", "uint32_t k"),
        ("in k", "unsigned k"),
        ("out big", "unsigned long *big"),
        ("out big", "unsigned long long *big"),
        ("in text", "const char *text"),
        ("in many", "const sequence_c_s *many"),
        ("in v", "const c_s *value"),
    ] {
        let f = format!("genom_event f({spelling}, genom_context self) {{ return c_main; }}");
        silent(IDS, param, "main", &f);
    }
}

#[test]
fn other_types_are_told() {
    for (param, spelling, wanted) in [
        ("in v", "c_s *v", "expected `const c_s *v`, found `c_s *v`"),
        ("inout v", "const c_s *v", "expected `c_s *v`, found `const c_s *v`"),
        ("in v", "c_s v", "expected `const c_s *v`, found `c_s v`"),
        ("in v", "const c_gone *v", "found `const c_gone *v`"),
        ("in n", "long n", "expected `int32_t n`, found `long n`"),
        ("in w", "float w", "expected `double w`, found `float w`"),
        ("in p", "const double p[4]", "found `const double p[4]`"),
        ("in v, in w", "const c_s *v", "found 2 (missing: `double w`)"),
        ("in v", "const c_s *v, double w", "expected 2 parameters, found 3 (too many: `double w`)"),
        ("in w, in n", "int32_t n, double w", "order: expected (w, n, self), found (n, w, self)"),
    ] {
        let f = format!("genom_event f({spelling}, const genom_context self) {{ return c_main; }}");
        one(IDS, param, "main", &f, wanted);
    }
    one(
        IDS,
        "",
        "main",
        "int f(const genom_context self) { return c_main; }",
        "expected return type",
    );
    one(
        IDS,
        "",
        "main",
        "static genom_event f(const genom_context self) { return c_main; }",
        "it is `static`",
    );
}

#[test]
fn what_is_defined_elsewhere_is_not_judged() {
    for f in [
        "typedef c_s mine; genom_event f(const mine *v, const genom_context self) { return c_main; }",
        "#define ARG const c_s *v\ngenom_event f(ARG, const genom_context self) { return c_main; }",
        "#define TYPE c_s\ngenom_event f(const TYPE *v, const genom_context self) { return c_main; }",
    ] {
        silent(IDS, "in v", "main", f);
    }
    silent(
        IDS,
        "in p",
        "main",
        "genom_event f(const double p[LENGTH], const genom_context self) { return c_main; }",
    );
}

#[test]
fn one_of_several_definitions_suffices() {
    silent(
        IDS,
        "in n",
        "main",
        "#ifdef A\ngenom_event f(int32_t n, const genom_context self) { return c_main; }\n#else\n\
         genom_event f(double n, const genom_context self) { return c_main; }\n#endif\n",
    );
}

#[test]
fn missing_functions() {
    one(
        "",
        "",
        "main",
        "",
        "missing-definition: no source in `codels/` defines the function of codel `f`",
    );
    // A macro may define it.
    silent("", "", "main", "CODEL(f)\n");
    silent("", "", "main", "#define f other\n");
    silent("", "", "main", "#define CODEL(x) genom_event x##_(void)\nCODEL(ff);\n");
    // A prototype is no definition.
    let f = "genom_event f(const genom_context self);";
    one("", "", "main", f, "missing-definition");
    let spec = task("", "", "main");
    // Without sources there is nothing to compare.
    assert!(Fixture::new(&spec, &[]).report().is_empty());
    // Sources of something else.
    assert!(
        Fixture::new(&spec, &[("other.c", "int main(void) { return 0; }")]).report().is_empty()
    );
    // The build file names a source that is made by the build.
    let makefile = "l_SOURCES = c_t_codels.c made.c\n";
    let files = [("c_t_codels.c", G), ("Makefile.am", makefile)];
    assert!(Fixture::new(&spec, &files).report().is_empty());
}

/// Checks the finding for a codel without parameters.
#[track_caller]
fn finds(yields: &str, f: &str, wanted: &str) {
    one("", "", yields, f, wanted);
}

#[track_caller]
fn finds_nothing(yields: &str, f: &str) {
    silent("", "", yields, f);
}

#[test]
fn returned_events() {
    let f = |body: &str| format!("genom_event f(const genom_context self) {{ {body} }}");
    finds(
        "main",
        &f("if (g) return c_ether; return c_main;"),
        "returns `c_ether`, which its codel does not yield",
    );
    finds("main", &f("if (g) return c_pause_main; return c_main;"), "`c_pause_main`");
    finds("main", &f("if (g) return c_sleep; return c_main;"), "`c_sleep`");
    finds(
        "main",
        &f("if (g) return genom_ok; return c_main;"),
        "returns `genom_ok`, but its codel has states",
    );
    finds("main", &f("genom_event e = c_sleep; if (g) e = c_main; return e;"), "`c_sleep`");
    finds("main, ether", &f("return c_main;"), "never-yielded: codel `f` may yield `ether`");
    finds("pause::main, main", &f("return c_main;"), "never returns `c_pause_main`");
    // Silent where it cannot know.
    for body in [
        "return helper(self);",
        "genom_event e = helper(); if (e) return e; return c_main;",
        "CHECK(self); return c_main;",
        "genom_event e; set(&e); return e;",
        "return table[0];",
        "if (( return c_main;",
        "/* skeleton sample: insert your code */ return c_main;",
        "if (last == c_ether) return c_main; return c_main;",
    ] {
        finds_nothing("main, ether", &f(body));
    }
    // A variable is often set to it before it gets its value.
    finds_nothing("main", &f("genom_event e = genom_ok; e = c_main; return e;"));
    // Helpers of the sources are followed.
    let helper = "static genom_event h(const genom_context self) { return c_e_one(self); }\n";
    finds(
        "main, ether",
        &(helper.to_owned() + &f("if (g) return h(self); return c_main;")),
        "never-yielded",
    );
    let helper = "static genom_event h(void) { return c_ether; }\n";
    finds_nothing("main, ether", &(helper.to_owned() + &f("if (g) return h(); return c_main;")));
    // A name that the sources declare is their own business.
    finds_nothing(
        "main",
        &format!("static genom_event c_last;\n{}", f("if (g) return c_last; return c_main;")),
    );
}

#[test]
fn raised_exceptions() {
    let f =
        |body: &str| format!("genom_event f(const genom_context self) {{ {body} return c_main; }}");
    silent("", "", "main", &f("if (g) return c_e_one(self);"));
    one(
        "",
        "",
        "main",
        &f("if (g) return c_e_two(&d, self);"),
        "raises `c_e_two`, which neither its task `t` nor the component throws",
    );
    one("", "", "main", &f("if (g) return c_e_gone(self);"), "has no exception of that name");
    silent("", "", "main", &f("if (g) return genom_syserr(&d, self);"));
    silent(
        "",
        "",
        "main",
        &format!(
            "genom_event c_e_mine(const genom_context self);\n{}",
            f("if (g) return c_e_mine(self);")
        ),
    );
}

#[test]
fn orphans() {
    let f = "genom_event f(const genom_context self) { return c_main; }\n";
    let orphan = "genom_event lost(int a, const genom_context self) { return c_main; }\n";
    one("", "", "main", &format!("{f}{orphan}"), "orphan: function `lost` looks like a codel");
    // Helpers are no orphans.
    silent("", "", "main", &format!("{f}static {orphan}"));
    silent(
        "",
        "",
        "main",
        &format!("genom_event lost(int a, const genom_context self);\n{f}{orphan}"),
    );
    silent("", "", "main", &format!("{f}{orphan}genom_event x(int a) {{ return lost(a, 0); }}\n"));
    // A near name is a rename.
    let spec = task("", "", "main").replace(" f(", " move_arm(");
    let source = format!("{G}{}", f.replace(" f(", " move_arms("));
    let found = Fixture::new(&spec, &[("c_t_codels.c", &source)]).report();
    assert!(found.len() == 1 && found[0].contains("was one of them renamed?"), "{found:?}");
}

#[test]
fn comments_of_shared_codels() {
    let spec = "component c { attribute a() { validate v(); }; attribute b() { validate v(); }; };";
    let comment = |owner: &str, throws: &str| {
        format!(
            "/** Validation codel v of attribute {owner}.\n *\n * Returns genom_ok.\n * Throws {throws}.\n */\n"
        )
    };
    let function = "genom_event v(const genom_context self) { return genom_ok; }\n";
    let text = format!(
        "{}{function}\n{}/* already defined in service a validation */\n",
        comment("a", ""),
        comment("b", "")
    );
    assert!(Fixture::new(spec, &[("c_codels.c", &text)]).report().is_empty());
    let text = format!("{}{function}", comment("a", "c_e_old"));
    let found = Fixture::new(spec, &[("c_codels.c", &text)]).report();
    assert_eq!(found, ["codel/stale-comment: comment of codel `v`: it now throws nothing"]);
    let text = format!("{}{function}", comment("gone", ""));
    let found = Fixture::new(spec, &[("c_codels.c", &text)]).report();
    assert_eq!(
        found,
        [
            "codel/stale-comment: comment of codel `v`: it is now validation codel `v` of attribute `a`"
        ]
    );
}

#[test]
fn cxx_codels() {
    let spec = task(
        "lang \"c++\"; struct s { string a; }; ids { s v; sequence<s> many; };",
        "in v, out many",
        "main, ether",
    );
    let g = "genom::event g() { return c::ether; }\n";
    let report = |f: &str| Fixture::new(&spec, &[("c_t_codels.cc", &format!("{g}{f}"))]).report();
    let good = "genom::event f(const c::s &v, std::vector<c::s> &many) { if (v.a.empty()) return c::ether; \
        if (many.empty()) throw c::e_one(); return c::main; }\n";
    assert_eq!(report(good), Vec::<String>::new());
    let using = "using namespace c;\nusing namespace std;\n\
        genom::event f(const s &v, vector<c::s> &many) { return g() ? c::ether : c::main; }\n";
    assert_eq!(report(using), Vec::<String>::new());
    let found = report(&good.replace("const c::s &v", "const c::s v").replace("e_one", "e_two"));
    assert!(found[0].contains("expected `const c::s &v`, found `const c::s v`"), "{found:?}");
    assert!(found[1].contains("raises `c::e_two`"), "{found:?}");
}

/// Texts after the first repair of the first finding.
fn repaired(spec: &str, file: &str, text: &str) -> (String, String) {
    let fixture = Fixture::new(spec, &[(file, text)]);
    let findings = fixture.check();
    let repair: &Repair = &findings[0].repairs[0];
    let expected = fixture.expected();
    let stubs = StubOptions::default();
    let repairs = Repairs {
        expected: &expected,
        sources: &fixture.sources,
        locations: &*fixture.unit.locations,
        text: &*fixture.files,
        stubs: &stubs,
    };
    let edit = repairs.edit(repair).expect("the repair has an edit");
    let after = |path: &str, text: &str| {
        let edits = edit.changed.get(camino::Utf8Path::new(path));
        apply(text, edits.map_or(&[], Vec::as_slice))
    };
    (after("/c.gen", spec), after(&format!("/codels/{file}"), text))
}

#[test]
fn a_new_signature_has_the_names_of_the_specification_but_for_the_context() {
    let spec = task(IDS, "in v, in w, out n", "main");
    let f =
        "genom_event\nf(c_s *value, int32_t *n, const genom_context ctx)\n{\n  return c_main;\n}\n";
    let (_, source) = repaired(&spec, "c_t_codels.c", &format!("{G}{f}"));
    insta::assert_snapshot!(source.strip_prefix(G).unwrap(), @r"
    genom_event
    f(const c_s *v, double w, int32_t *n, const genom_context ctx)
    {
      return c_main;
    }
    ");
}

#[test]
fn states_and_exceptions_go_where_they_belong() {
    let f = "genom_event f(const genom_context self) { if (g) return c_ether; return c_main; }\n";
    let spec = task("", "", "main /* x */").replace("  task t", "  /* yield { ; */ task t");
    let (changed, _) = repaired(&spec, "c_t_codels.c", &format!("{G}{f}"));
    assert!(changed.contains("codel<start> f() yield main /* x */, ether;"), "{changed}");
    let f = "genom_event f(const genom_context self) { if (g) return c_e_two(0, self); return c_main; }\n";
    let (changed, _) = repaired(&spec, "c_t_codels.c", &format!("{G}{f}"));
    assert!(changed.contains("throw e_one, e_two;"), "{changed}");
    let spec = spec.replace("    throw e_one;\n", "");
    let (changed, _) = repaired(&spec, "c_t_codels.c", &format!("{G}{f}"));
    assert!(changed.contains("yield ether;\n    throw e_two;\n  };"), "{changed}");
}

#[test]
fn an_orphan_becomes_a_codel() {
    let spec = task(IDS, "", "main").replace("yield ether", "yield wait, ether");
    let spec = spec.replace("codel<main>", "codel<wait> h() yield ether;\n    codel<main>");
    let sources = "genom_event f(const genom_context self) { return c_main; }\n\
        genom_event h(const genom_context self) { return c_ether; }\n\
        genom_event g(const genom_context self) { return self ? c_wait : c_ether; }\n\
        /** Codel tidy of task t.\n *\n * Triggered by c_stop.\n */\n\
        genom_event tidy(const c_s *v, int32_t *n, const genom_context self) { return c_ether; }\n";
    let (changed, _) = repaired(&spec, "c_t_codels.c", sources);
    assert!(
        changed.contains("    codel<stop> tidy(ids in v, ids inout n)\n    yield ether;\n"),
        "{changed}"
    );
}

/// A component whose functions `f` and `g` have the output port `p`, with these bodies.
fn with_port(lang: &str, f: &str, g: Option<&str>, around: &str) -> Vec<String> {
    let spec = format!(
        "component c {{ {lang}\n  struct s {{ double x; }}; port out s p;\n  task t {{\n    \
         codel<start> c_f(out p) yield main;\n    codel<main> c_g(out p) yield ether;\n  }};\n}};\n"
    );
    let cxx = !lang.is_empty();
    let function = |name: &str, body: &str| {
        let [event, context, end] = if cxx {
            ["genom::event", "", "c::ether"]
        } else {
            ["genom_event", ", const genom_context self", "c_ether"]
        };
        format!("{event} c_{name}(const c_p *out{context})\n{{\n  {body}\n  return {end};\n}}\n")
    };
    let g = g.map(|body| function("g", body)).unwrap_or_default();
    let source = format!("{around}{}{g}", function("f", f));
    let found = Fixture::new(&spec, &[(if cxx { "c_codels.cc" } else { "c_codels.c" }, &source)]);
    let mut found = found.report();
    found.retain(|line| line.starts_with("codel/unwritten-port"));
    found
}

#[test]
fn a_port_that_no_codel_writes_is_told_at_each() {
    let data = "if (self) out->data(self)->x = 1.;";
    let found = with_port("", data, Some("(void)out;"), "");
    let message = |function: &str| {
        format!(
            "codel/unwritten-port: `{function}` never writes the output port `p`, and no other codel of `c` \
             does: readers get no data; call `write` on the port, or remove the parameter"
        )
    };
    assert_eq!(found, [message("c_f"), message("c_g")]);
    assert_eq!(with_port("", "", Some("out->open(\"x\", self);"), "").len(), 2);
    let lambda = "auto all = [&]() { out->data(self)->x = 1.; };";
    // `auto` needs no call: the port is used, but not written.
    assert_eq!(with_port("lang \"c++\";", lambda, Some(""), "").len(), 2);
    let other = "#define RATE 10\nstatic double p_of(double x) { return x; }\n";
    assert_eq!(with_port("", data, Some("p_of(2.);"), other).len(), 2);
}

#[test]
fn a_port_that_may_be_written_is_not_told() {
    let data = "out->data(self)->x = 1.;";
    for body in [
        "out->write(self);",
        "if (out->write(self)) return c_e(self);",
        "(*out).write(self);",
        "(out)->write(self);",
        "publish(out);",
        "publish(&out, self);",
        "publish(self, 2, (void *)out);",
        "const c_p *other = out; other->write(self);",
        "struct all all = { out };",
        "keep = out;",
        "genom_event (*write)(genom_context) = out->write; write(self);",
        "PUBLISH(self);",
        "#if RATE\n  out->write(self);\n#endif",
        "/* skeleton sample: insert your code */",
        "out->write(self;",
    ] {
        assert_eq!(with_port("", data, Some(body), ""), Vec::<String>::new(), "{body}");
        assert_eq!(with_port("", body, Some(data), ""), Vec::<String>::new(), "{body}");
    }
    // No function yet.
    assert_eq!(with_port("", data, None, ""), Vec::<String>::new());
    let macros = "#define publish(x) \\\n  out->write(x)\n";
    assert_eq!(with_port("", data, Some("publish(self);"), macros), Vec::<String>::new());
    for body in
        ["[&] { out->write(self); }();", "auto &port = *out; port.write(self);", "std::ref(out);"]
    {
        assert_eq!(
            with_port("lang \"c++\";", data, Some(body), ""),
            Vec::<String>::new(),
            "{body}"
        );
    }
}

#[test]
fn every_code_of_the_manual_is_found_in_its_example_and_nothing_else() {
    for (code, _) in CODES {
        let page = Page::read(code).expect("every kind has a page");
        let text = |language, corrected| page.texts(language, corrected).first().copied();
        let (specification, source) = (text("genom", false), text("c", false));
        let (specification, source) = specification.zip(source).expect("both sides");
        let fixture = Fixture::new(specification, &[("c_codels.c", source)]);
        let found: Vec<_> = fixture.check().iter().map(Drift::code).collect();
        assert_eq!(found, [code], "{:?}", fixture.report());
        let (specification, source) =
            (text("genom", true).unwrap_or(specification), text("c", true).unwrap_or(source));
        let fixture = Fixture::new(specification, &[("c_codels.c", source)]);
        let found: Vec<_> = fixture.check().iter().map(Drift::code).collect();
        assert!(found.is_empty(), "{code}: {:?}", fixture.report());
    }
}
