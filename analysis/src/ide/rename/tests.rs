use crate::progress::Progress;
use crate::test_support::Fixture;

/// The fixture with the edits applied, in its own form.
fn renamed(fixture: &Fixture, new_name: &str) -> Result<String, String> {
    let edits = fixture.analysis().rename(&fixture.at(), new_name, &Progress::default()).unwrap();
    let edits = edits.map_err(|error| error.0)?;
    let mut out = String::new();
    for path in fixture.paths() {
        let text = fixture.text(path.as_str());
        let text =
            crate::ide::speculate::apply(&text, edits.iter().filter(|edit| edit.path == path));
        match fixture.paths().len() {
            1 => out += &text,
            _ => out += &format!("//- {path}\n{text}"),
        }
    }
    Ok(out)
}

#[track_caller]
fn check(text: &str, new_name: &str, expected: &str) {
    let fixture = Fixture::new(text);
    let found = renamed(&fixture, new_name);
    assert_eq!(found.as_deref(), Ok(expected), "{}", fixture.all_diagnostics());
}

#[track_caller]
fn refused(text: &str, new_name: &str, because: &str) {
    let found = renamed(&Fixture::new(text), new_name);
    let error = found.expect_err("refused");
    assert!(error.contains(because), "{error}");
}

#[test]
fn types_constants_and_members() {
    check("typedef long a$0;\ntypedef a b;\n", "c", "typedef long c;\ntypedef c b;\n");
    check(
        "module m { const long n = 1; };\ntypedef long a[m::n$0 + 1];\n",
        "size",
        "module m { const long size = 1; };\ntypedef long a[m::size + 1];\n",
    );
    check("module m$0 { };\nmodule m { };\n", "n", "module n { };\nmodule n { };\n");
    check("enum e { A, B };\nconst e x = A$0;\n", "Z", "enum e { Z, B };\nconst e x = Z;\n");
    check(
        "struct s;\nstruct s { long x; };\ntypedef s$0 t;\n",
        "u",
        "struct u;\nstruct u { long x; };\ntypedef u t;\n",
    );
    check(
        "exception e$0;\ncomponent c { throw e; };\n",
        "bad",
        "exception bad;\ncomponent c { throw bad; };\n",
    );
    check(
        "struct s { long x$0; };\ncomponent c { ids { s v; }; attribute a(in v.x::y = 1); function f(in s p = { .x = 2 }); };\n",
        "z",
        "struct s { long z; };\ncomponent c { ids { s v; }; attribute a(in v.z::y = 1); function f(in s p = { .z = 2 }); };\n",
    );
}

#[test]
fn parts_of_components() {
    check("component c$0;\ncomponent c { };\n", "d", "component d;\ncomponent d { };\n");
    check(
        "component c { task t$0; activity a() { task t; codel<start> f() yield ether; }; };\n",
        "u",
        "component c { task u; activity a() { task u; codel<start> f() yield ether; }; };\n",
    );
    check(
        "struct s { long x; };\ncomponent c { port in s p; task t { codel<start> f(port in p$0) yield ether; }; };\n",
        "q",
        "struct s { long x; };\ncomponent c { port in s q; task t { codel<start> f(port in q) yield ether; }; };\n",
    );
    check(
        "component c { function f$0(); function g() { interrupt f; }; };\n",
        "h",
        "component c { function h(); function g() { interrupt h; }; };\n",
    );
    check(
        "component c { function f(in long a$0) { codel g(in a); }; };\n",
        "b",
        "component c { function f(in long b) { codel g(in b); }; };\n",
    );
    check(
        "component c { task t { codel<start> f() yield go$0; codel<go> g() yield ether; }; };\n",
        "run",
        "component c { task t { codel<start> f() yield run; codel<run> g() yield ether; }; };\n",
    );
    check(
        "component c { task t { codel<start> f$0() yield ether; }; task u { codel<start> f() yield ether; }; };\n",
        "g",
        "component c { task t { codel<start> g() yield ether; }; task u { codel<start> g() yield ether; }; };\n",
    );
}

#[test]
fn what_has_its_name_from_another() {
    check(
        "component c { ids { long x$0; }; attribute a(in x) { validate v(local in x); }; };\n",
        "y",
        "component c { ids { long y; }; attribute a(in y) { validate v(local in y); }; };\n",
    );
}

#[test]
fn across_interfaces_and_files() {
    check(
        "//- /i.idl\ninterface i { function go$0(); };\n//- /main.gen\n#include \"i.idl\"\ncomponent c { provides i; function go() { codel g(); }; };\n//- /other.gen\n#include \"i.idl\"\ncomponent d { uses i; task t { codel<start> f(remote in go) yield ether; }; };\n",
        "run",
        "//- /i.idl\ninterface i { function run(); };\n//- /main.gen\n#include \"i.idl\"\ncomponent c { provides i; function run() { codel g(); }; };\n//- /other.gen\n#include \"i.idl\"\ncomponent d { uses i; task t { codel<start> f(remote in run) yield ether; }; };\n",
    );
}

#[test]
fn macros() {
    check(
        "#define N$0 3\n#define M (N + 1)\n#ifdef N\ntypedef long a[N];\n#endif\ntypedef long b[M];\n",
        "SIZE",
        "#define SIZE 3\n#define M (SIZE + 1)\n#ifdef SIZE\ntypedef long a[SIZE];\n#endif\ntypedef long b[M];\n",
    );
    refused("#define N$0 3\n#define M 4\n", "M", "macro");
    refused("#define N$0 3\ntypedef long M;\n", "M", "already says");
    refused("#define M 3\ntypedef long a$0;\n", "M", "is a macro");
    refused("#ifdef __FILE__$0\n#endif\n", "X", "not defined in a file");
}

#[test]
fn text_of_macros_and_inactive_text_is_left_alone() {
    refused("#define T a\ntypedef long a$0;\ntypedef T b;\n", "c", "macro call `T`");
    refused("#define T a\ntypedef long a;\ntypedef T$0 b;\n", "T2 x", "not a name");
    check(
        "#define ID(x) x\ntypedef long a$0;\ntypedef ID(a) b;\n",
        "c",
        "#define ID(x) x\ntypedef long c;\ntypedef ID(c) b;\n",
    );
    check(
        "typedef long a$0;\n#if 0\ntypedef a b;\n#endif\n// a\n",
        "c",
        "typedef long c;\n#if 0\ntypedef a b;\n#endif\n// a\n",
    );
}

#[test]
fn clashes_captures_and_words_are_refused() {
    refused(
        "typedef long a$0;\ntypedef long b;\n",
        "b",
        "`a` cannot be called `b`: a type has that name already (main.gen, line 2); choose another name",
    );
    refused("typedef long a$0;\n", "struct", "reserved");
    refused("typedef long a$0;\n", "xor", "reserved");
    refused("typedef long a$0;\n", "1a", "not a name");
    refused("typedef long a$0;\n", "clock-rate", "not a name");
    // `b` inside the module would be found first.
    refused(
        "typedef long a$0;\nmodule m { typedef short b; typedef a c; };\n",
        "b",
        "cannot be called",
    );
    refused("component c { function f$0(); };\n", "all", "all");
    refused(
        "component c { task t { codel<start$0> f() yield ether; }; };\n",
        "x",
        "from the language",
    );
    refused("component c { ids$0 { long x; }; };\n", "x", "word of the language");
    // Two codels of one name are one function.
    refused(
        "component c { function f() { codel a$0(); codel b(); }; };\n",
        "b",
        "a codel has that name already (main.gen, line 1) and codels of one name are one function",
    );
    refused(
        "component c {\n  ids { long x; };\n  task t {\n    codel<start> f$0(in x) yield main;\n    codel<main> g(out x) yield ether;\n  };\n};\n",
        "g",
        "`f` cannot be called `g`: a codel has that name already (main.gen, line 5)",
    );
    refused(
        "component c {\n  task t { codel<start> f() yield m$0; codel<m> g() yield n; codel<n> h() yield ether; };\n};\n",
        "n",
        "a state has that name already (main.gen, line 2); choose another name, or rename that one first",
    );
    // Entities that do not clash are not mentioned.
    refused(
        "struct s { long b; };\ncomponent c { function f(in long a$0, in long z); attribute b(); };\n",
        "z",
        "a parameter has that name already",
    );
    // A contextual keyword is a name like any other.
    check("typedef long a$0;\n", "task", "typedef long task;\n");
}

#[test]
fn there_and_back_is_the_identity() {
    let text = "struct s { long x; };\ninterface i { port in s p; function f(in s a = { .x = 1 }); };\ncomponent c { provides i; ids { s v; }; attribute g(in v.x); task t { codel<start> k(port in p, ids in v.x) yield go; codel<go> l(out ::ids) yield ether; }; function f(in s a) { codel m(in a.x); }; };\n";
    let mut fixture = Fixture::new(text);
    let names: Vec<usize> = text
        .match_indices(|character: char| character.is_ascii_alphabetic())
        .map(|(at, _)| at)
        .collect();
    let mut renamed = 0;
    for at in names {
        let at = crate::ide::FilePosition { path: "/main.gen".into(), offset: at };
        let Ok(prepared) = fixture.analysis().prepare_rename(&at).unwrap() else {
            continue;
        };
        let edits = fixture.analysis().rename(&at, "other_name", &Progress::default()).unwrap();
        let edits = edits.unwrap_or_else(|error| panic!("{prepared:?}: {error}"));
        let there = crate::ide::speculate::apply(text, &edits);
        assert_ne!(there, text);
        fixture.edit("/main.gen", there.clone());
        assert_eq!(fixture.all_diagnostics().matches(" error ").count(), 0);
        let at = crate::ide::FilePosition {
            path: "/main.gen".into(),
            offset: there.find("other_name").unwrap(),
        };
        let edits =
            fixture.analysis().rename(&at, &prepared.info, &Progress::default()).unwrap().unwrap();
        assert_eq!(crate::ide::speculate::apply(&there, &edits), text);
        fixture.edit("/main.gen", text);
        renamed += 1;
    }
    assert!(renamed > 20, "{renamed}");
}

#[test]
fn includes_follow_their_files() {
    let moved = |text: &str, from: &str, to: &str| {
        let fixture = Fixture::new(text);
        let edits = fixture.analysis().files_moved(&[(from.into(), to.into())]).unwrap();
        let edits = edits.iter().map(|edit| format!("{}: {}", edit.path, edit.new_text));
        edits.collect::<Vec<_>>()
    };
    let text = "//- /a/main.gen\n#include \"t.idl\"\n//- /a/t.idl\n#include \"sub/u.idl\"\n//- /a/sub/u.idl\n";
    assert_eq!(moved(text, "/a/t.idl", "/a/types.idl"), ["/a/main.gen: types.idl"]);
    assert_eq!(
        moved(text, "/a/t.idl", "/b/t.idl"),
        ["/a/main.gen: ../b/t.idl", "/a/t.idl: ../a/sub/u.idl"]
    );
    assert_eq!(moved(text, "/a/sub", "/a/deep"), ["/a/t.idl: deep/u.idl"]);
    assert_eq!(moved(text, "/a", "/b"), [""; 0]);
}

/// A second unit has the type as well. The rename is compiled there unless no word in it can clash with the
/// new name.
#[test]
fn other_units_are_tried_where_the_new_name_may_meet_another() {
    let shared = |other: &str| {
        let first = "//- /a.gen\n#include \"t.idl\"\ncomponent a { ids { pose p; }; };\n";
        let shared = "//- /t.idl\nstruct pose$0 { long x; };\n";
        format!("{first}//- /b.gen\n#include \"t.idl\"\n{other}\n{shared}")
    };
    for (other, because) in [
        ("struct place { long y; };", "has that name"),
        ("#define place pose\nstruct q { pose p; };", "macro"),
        ("#define T(a) a ## ce\nstruct T(pla) { pose p; };", "has that name"),
    ] {
        refused(&shared(other), "place", because);
    }
    let other = "component b { ids { pose p; sequence<pose, 3> q; }; port in pose r; };";
    check(&shared(other), "place", &shared(other).replace("pose", "place").replace("$0", ""));
}

#[test]
fn the_work_is_counted() {
    let fixture = Fixture::new(
        "//- /types.idl\nstruct $0point { long x; };\n//- /a.gen\n#include \"types.idl\"\ncomponent a { ids { point p; }; };\n\
         //- /b.gen\n#include \"types.idl\"\ncomponent b { ids { point p; }; };\n",
    );
    let progress = Progress::default();
    let renamed = fixture.analysis().rename(&fixture.at(), "place", &progress);
    assert!(renamed.unwrap().is_ok());
    let (done, known) = progress.parts();
    assert!(done == known && known >= 2, "{done} of {known}");
}
