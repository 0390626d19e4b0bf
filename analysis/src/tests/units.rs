//! The files that a unit visits, and the diagnostics for files that it cannot visit.

use camino::Utf8Path;

use crate::progress::Progress;
use crate::{
    host::{BatchInput, Change, Config, Input, PackageFlags},
    test_support::{Fixture, diagnostic_line},
};

#[track_caller]
fn check(fixture: &Fixture, expected: &str) {
    let codes: Vec<String> = fixture
        .paths()
        .iter()
        .flat_map(|path| fixture.analysis().diagnostics(path).unwrap())
        .map(|diagnostic| {
            let line = fixture.text(diagnostic.path.as_str())[..diagnostic.range.start]
                .matches('\n')
                .count()
                + 1;
            format!("{}:{line} {}", diagnostic.path, diagnostic.code)
        })
        .collect();
    let wanted: Vec<&str> =
        expected.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    assert_eq!(codes, wanted, "{}", fixture.all_diagnostics());
}

#[test]
fn quoted_include_is_relative_to_the_including_file() {
    let fixture = Fixture::new(
        r#"
//- /a/main.gen
#include "sub/x.idl"
//- /a/sub/x.idl
#include "y.idl"
//- /a/sub/y.idl
const long n = 1;
"#,
    );
    check(&fixture, "");
    let unit = fixture.analysis().unit("/a/main.gen".into()).unwrap();
    assert_eq!(unit.files, ["/a/main.gen", "/a/sub/x.idl", "/a/sub/y.idl"]);
}

#[test]
fn angled_include_searches_the_path_only() {
    let text = r#"
//- /main.gen
#include <x.idl>
#include "x.idl"
//- /x.idl
//- /inc/x.idl
"#;
    check(&Fixture::new(text), "/main.gen:1 pp-include-not-found");
    let config =
        Config { include_dirs: vec!["/nowhere".into(), "/inc".into()], ..Config::default() };
    let fixture = Fixture::with_config(text, config);
    check(&fixture, "");
    let unit = fixture.analysis().unit("/main.gen".into()).unwrap();
    assert_eq!(unit.files, ["/main.gen", "/inc/x.idl", "/x.idl"]);
}

#[test]
fn missing_directory_and_cyclic_includes_are_reported() {
    let fixture = Fixture::new(
        r#"
//- /a.gen
#include "nowhere.idl"
#include "dir"
//- /b.gen
#include "b.gen"
//- /dir/x.idl
"#,
    );
    check(
        &fixture,
        "/a.gen:1 pp-include-not-found
         /a.gen:2 pp-include-not-found
         /b.gen:1 pp-include-depth",
    );
}

#[test]
fn a_file_that_appears_is_found() {
    let mut fixture = Fixture::new("#include \"x.idl\"\n");
    check(&fixture, "/main.gen:1 pp-include-not-found");
    fixture.edit("/x.idl", "const long n = 1;\n");
    check(&fixture, "");
}

#[test]
fn macros_flow_through_includes() {
    let fixture = Fixture::new(
        r#"
//- /main.gen
#define A
#include "x.idl"
#ifndef B
#error no B
#endif
//- /x.idl
#ifdef A
#define B
#else
#error no A
#endif
"#,
    );
    // The header is served by the unit that includes it, where `A` is defined.
    check(&fixture, "/main.gen:4 inactive-code\n/x.idl:4 inactive-code");
}

#[test]
fn packages_add_directories_and_definitions() {
    let text = r#"
//- /main.gen
#include <early.idl>
#pragma requires "p"
#include <x.idl>
#ifndef FROM_P
#error no definition
#endif
//- /p/x.idl
//- /p/early.idl
"#;
    let fixture = Fixture::new(text);
    let flags = PackageFlags {
        include_dirs: vec!["/p".into()],
        defines: vec![("FROM_P".into(), "1".into())],
        ..PackageFlags::default()
    };
    fixture.loader.packages.lock().unwrap().insert("p".into(), flags);
    check(&fixture, "/main.gen:1 pp-include-not-found\n/main.gen:5 inactive-code");
}

#[test]
fn pragmas_come_out_of_macros_too() {
    let fixture = Fixture::new(
        r#"
//- /main.gen
#include "m.idl"
_Pragma("requires \"q\"")
NEED_P
#include <x.idl>
//- /m.idl
#define NEED_P _Pragma("requires \"p\"")
//- /p/x.idl
"#,
    );
    let flags =
        |dir: &str| PackageFlags { include_dirs: vec![dir.into()], ..PackageFlags::default() };
    fixture
        .loader
        .packages
        .lock()
        .unwrap()
        .extend([("p".to_owned(), flags("/p")), ("q".to_owned(), flags("/q"))]);
    check(&fixture, "");
    let unit = fixture.analysis().unit("/main.gen".into()).unwrap();
    assert_eq!(unit.files, ["/main.gen", "/m.idl", "/p/x.idl"]);
}

#[test]
fn a_missing_package_is_one_error() {
    let fixture = Fixture::new("#pragma requires \"p\"\n#include <x.idl>\n");
    check(&fixture, "/main.gen:1 pp-requires-unresolved");
}

#[test]
fn includes_take_part_in_bodies_but_not_in_declarations() {
    let fixture = Fixture::new(
        r#"
//- /main.gen
component c {
#include "body.idl"
};
const long n =
#include "one.idl"
1;
//- /body.idl
version "1";
//- /one.idl
1
"#,
    );
    check(&fixture, "/main.gen:5 pp-include-place");
}

#[test]
fn a_declaration_ends_in_its_file() {
    let fixture = Fixture::new(
        r#"
//- /main.gen
#include "open.idl"
};
//- /open.idl
module m {
"#,
    );
    let all = fixture.all_diagnostics();
    assert!(all.contains("syntax-eof"), "{all}");
    let eof = fixture.analysis().diagnostics("/open.idl".into()).unwrap();
    let related: Vec<_> = eof[0].related.iter().map(|related| related.path.as_str()).collect();
    assert_eq!(related, ["/open.idl", "/main.gen"]);
}

#[test]
fn several_inputs_are_one_unit() {
    let fixture = Fixture::new("//- /a.idl\n#define A\n");
    let input = BatchInput {
        inputs: vec![
            Input::File("/a.idl".into()),
            Input::Text {
                name: "/text.gen".into(),
                text: "#ifndef A\n#error no A\n#endif\n#ifndef D\n#error no D\n#endif\n".into(),
            },
        ],
        defines: vec![("D".into(), "1".into())],
        ..BatchInput::default()
    };
    let unit = fixture.analysis().batch(&input).unwrap();
    let lines: Vec<String> = unit.diagnostics.iter().map(diagnostic_line).collect();
    assert_eq!(lines, [""; 0]);
    assert_eq!(unit.files, ["/a.idl", "/text.gen"]);
}

#[test]
fn a_missing_input_is_reported() {
    let fixture = Fixture::new("");
    let unit = fixture.analysis().root_unit("/none.gen".into()).unwrap();
    assert_eq!(unit.diagnostics[0].code, "pp-input");
    assert!(!unit.accepted());
}

#[test]
fn the_active_root_serves_its_headers() {
    let mut fixture = Fixture::new(
        r#"
//- /a.gen
#include "x.idl"
//- /b.gen
#include "x.idl"
//- /x.idl
"#,
    );
    let root = |fixture: &Fixture| fixture.analysis().root_of("/x.idl".into()).unwrap();
    assert_eq!(root(&fixture), "/a.gen");
    let show = |fixture: &mut Fixture, path: &str| {
        fixture.host.apply(crate::host::Change { active: Some(path.into()), ..Default::default() });
    };
    show(&mut fixture, "/b.gen");
    assert_eq!(root(&fixture), "/b.gen");
    show(&mut fixture, "/x.idl");
    assert_eq!(root(&fixture), "/b.gen");
    assert_eq!(fixture.analysis().root_of("/new.idl".into()).unwrap(), "/new.idl");
}

#[test]
fn includes_that_double_are_cut_off() {
    use std::fmt::Write as _;
    let mut text = String::from("//- /f0.gen\n#include \"f1.idl\"\n");
    for i in 1..30 {
        let next = i + 1;
        write!(text, "//- /f{i}.idl\n#include \"f{next}.idl\"\n#include \"f{next}.idl\"\n")
            .unwrap();
    }
    text += "//- /f30.idl\n";
    let fixture = Fixture::new(&text);
    let unit = fixture.analysis().unit("/f0.gen".into()).unwrap();
    assert_eq!(unit.diagnostics[0].code, "pp-include-not-found");
    assert!(unit.diagnostics[0].message.to_string().contains("4000 files"));
}

#[test]
fn text_that_is_not_utf8_is_a_warning() {
    use std::sync::Arc;

    use crate::host::{AnalysisHost, FileContent, Loader};
    struct Latin;
    impl Loader for Latin {
        fn read(&self, _: &camino::Utf8Path) -> FileContent {
            FileContent::NotUtf8("// caf\u{fffd}\n".into())
        }
        fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
            Ok(PackageFlags::default())
        }
    }
    let host = AnalysisHost::new(Arc::new(Latin));
    let unit = host.analysis().root_unit("/main.gen".into()).unwrap();
    assert_eq!(unit.diagnostics[0].code, "not-utf8");
    assert_eq!(unit.diagnostics[0].range, 6..9);
    assert!(unit.accepted());
}

/// Each alias is resolved through the previous one, not through all before it.
#[test]
fn a_long_chain_of_aliases_is_analysed() {
    let mut text = "typedef long t0;\n".to_owned();
    for i in 0..24_000 {
        text += &format!("typedef t{i} t{};\n", i + 1);
    }
    let fixture = Fixture::new(&(text + "const t24000 LAST = 3;\nstruct s { t24000 x[LAST]; };\n"));
    assert_eq!(fixture.all_diagnostics(), "");
}

#[test]
fn a_pause_without_a_state_is_one_error_with_the_state_of_the_codel() {
    let text = "component c {
  task t {
    period 5 ms;
    codel<start> first_step() yield main;
    codel<main> next_step() yield pause, ether;
  };
};
";
    let fixture = Fixture::new(text);
    let found = fixture.analysis().diagnostics("/main.gen".into()).unwrap();
    let [only] = found.as_slice() else { panic!("{found:?}") };
    assert_eq!((only.code, &text[only.range.clone()]), ("fsm/undefined-state", "pause"));
    assert_eq!(only.fixes[0].edits[0].new_text, "pause::main");
    assert_eq!(only.fixes[0].edits[0].range, only.range);
}

/// More units that share a file than are queried with cached results.
fn many() -> Fixture {
    let mut text =
        "//- /t.idl\nstruct shared$0 { long x; };\nstruct other { long y; };\n".to_owned();
    for i in 0..40 {
        text += &format!("//- /u{i:02}.gen\n#include \"t.idl\"\ntypedef shared t{i};\n");
    }
    Fixture::new(&text)
}

#[test]
fn names_are_found_and_changed_in_very_many_units() {
    let fixture = many();
    let (analysis, at) = (fixture.analysis(), fixture.at());
    let found = analysis.references(&at, true).unwrap().unwrap();
    assert_eq!(found.len(), 41);
    let edits = analysis.rename(&at, "renamed", &Progress::default()).unwrap().unwrap();
    let places: Vec<_> = edits.iter().map(|edit| (&edit.path, &edit.range)).collect();
    let wanted: Vec<_> =
        found.iter().map(|reference| (&reference.place.path, &reference.place.range)).collect();
    assert_eq!(places, wanted);
    let refused = analysis.rename(&at, "other", &Progress::default()).unwrap().unwrap_err();
    assert!(refused.0.contains("other"), "{refused}");
}

#[test]
fn what_was_forgotten_is_made_again() {
    let mut fixture = many();
    let before = fixture.all_diagnostics();
    fixture.host.keep_little();
    for _ in 0..2 {
        fixture.host.evict_cache();
        assert_eq!(fixture.all_diagnostics(), before);
    }
    fixture.replace("/t.idl", "struct shared", "struct lost");
    fixture.host.evict_cache();
    let after = fixture.all_diagnostics();
    assert_eq!(after.matches("`shared`").count(), 40, "{after}");
}

#[test]
fn a_file_that_is_too_large_is_not_read() {
    let config = Config { max_file_bytes: Some(40), ..Config::default() };
    let text = "
//- /a.gen
#include \"b.idl\"
//- /b.idl
const long a = 1 + 1 + 1 + 1 + 1 + 1 + 1 + 1 +
";
    let fixture = Fixture::with_config(text, config);
    let codes = |path: &str| -> Vec<&str> {
        let found = fixture.analysis().diagnostics(path.into()).unwrap();
        found.iter().map(|diagnostic| diagnostic.code).collect()
    };
    assert_eq!(codes("/b.idl"), ["pp-input"]);
    assert_eq!(codes("/a.gen"), ["pp-include-not-found"]);
}

#[test]
fn a_file_that_becomes_too_large_is_forgotten() {
    let mut fixture = Fixture::new("//- /a.gen\nconst long a = 1;\n");
    fixture.replace("/a.gen", "1;", "1 + 1");
    let codes = |fixture: &Fixture| -> Vec<&str> {
        let found = fixture.analysis().diagnostics("/a.gen".into()).unwrap();
        found.iter().map(|diagnostic| diagnostic.code).collect()
    };
    assert_eq!(codes(&fixture), ["missing-semicolon"]);
    let config = Config { max_file_bytes: Some(10), ..Config::default() };
    fixture.host.apply(Change { config: Some(config), ..Change::default() });
    assert_eq!(codes(&fixture), ["pp-input"]);
}

#[test]
fn the_first_answer_about_a_root_looks_at_no_other_root() {
    let mut text = "//- /whole.gen\ntypedef long t;\n#include \"part.gen\"\n".to_owned();
    text += "//- /part.gen\ntypedef t u;\n";
    for number in 0..20 {
        text += &format!("//- /other{number}.gen\nconst long n = {number};\n");
    }
    let mut fixture = Fixture::new(&text);
    let part = Utf8Path::new("/part.gen");
    let indexed = |fixture: &mut Fixture, indexed| {
        fixture.host.apply(Change { indexed: Some(indexed), ..Change::default() });
    };
    indexed(&mut fixture, false);
    fixture.take_log();
    let alone = fixture.analysis().diagnostics(part).unwrap();
    assert_eq!(alone.len(), 1, "nobody is known who includes it: {alone:?}");
    let walked = |fixture: &Fixture| {
        let log = fixture.take_log();
        log.iter().filter(|log| *log == "walk_unit").count()
    };
    assert_eq!(walked(&fixture), 1);
    assert!(fixture.analysis().index().unwrap());
    assert!(walked(&fixture) >= 20);
    indexed(&mut fixture, true);
    let included = fixture.analysis().diagnostics(part).unwrap();
    assert_eq!(included, []);
    assert_eq!(walked(&fixture), 0);
}
