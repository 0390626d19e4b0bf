//! Each diagnostic code has a fixture, `data/codes/CODE.gen`, with a text that triggers it and, after
//! the line `// near miss`, one that almost does. A third one after `// corrected` is the first text as it
//! should be, for the manual; without it the near miss is.
//!
//! In the first text a comment `//!` marks each line where the code is reported; nothing else may be
//! reported (one cause, one diagnostic). In the other texts there is no problem at all.

use std::{fs, path::Path, sync::Arc};

use camino::Utf8Path;
use dotgen_analysis::{
    codes::{self, find},
    diagnostic::{Diagnostic, Severity},
    host::{AnalysisHost, BatchInput, FileContent, Input, Loader, PackageFlags},
};
use dotgen_loaders::pages::Page;

/// Two header files, and nothing else.
struct Headers;

impl Loader for Headers {
    fn read(&self, path: &Utf8Path) -> FileContent {
        match path.file_name() {
            Some("node.idl") => FileContent::Text("struct node { long x; }; //!\n".to_owned()),
            Some("other.idl") => FileContent::Text("struct other { long x; };\n".to_owned()),
            _ => FileContent::Missing,
        }
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

/// All diagnostics of a text.
fn reported(text: &str) -> Vec<Diagnostic> {
    let host = AnalysisHost::new(Arc::new(Headers));
    let input = BatchInput {
        inputs: vec![Input::Text { name: "/fixture/main.gen".into(), text: text.into() }],
        ..BatchInput::default()
    };
    let result = host.analysis().batch(&input).unwrap();
    result.diagnostics.to_vec()
}

/// `line: code: message` of every diagnostic.
fn diagnostics(text: &str) -> Vec<(usize, &'static str, String)> {
    let found = reported(text);
    let all = found.iter();
    // Lints have tests of their own.
    let is_hint = |diagnostic: &Diagnostic| {
        diagnostic.severity == Severity::Hint && find(diagnostic.code).is_none()
    };
    all.filter(|diagnostic| !is_hint(diagnostic) && codes::lints::find(diagnostic.code).is_none())
        .map(|diagnostic| {
            let in_header = diagnostic.path.file_name() == Some("node.idl");
            let line = if in_header {
                2
            } else {
                1 + text[..diagnostic.range.start].matches('\n').count()
            };
            (line, diagnostic.code, diagnostic.message.to_string())
        })
        .collect()
}

#[test]
fn every_code_has_a_fixture_that_triggers_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/codes");
    let mut failures = Vec::new();
    for code in codes::checks::CODES {
        let path = folder.join(code.id).with_extension("gen");
        let Ok(fixture) = fs::read_to_string(&path) else {
            failures.push(format!("{}: there is no fixture", code.id));
            continue;
        };
        let Some((bad, good)) = fixture.split_once("// near miss\n") else {
            failures.push(format!("{}: there is no near miss", code.id));
            continue;
        };
        let marked = |(index, line): (usize, &str)| line.contains("//!").then_some(index + 1);
        let wanted: Vec<usize> = bad.lines().enumerate().filter_map(marked).collect();
        // In a pragma, comments are words.
        let unmarked = |line: &str| {
            if line.starts_with("#pragma") {
                line.replace(" //!", "") + "\n"
            } else {
                format!("{line}\n")
            }
        };
        let found = diagnostics(&bad.lines().map(unmarked).collect::<String>());
        let lines: Vec<usize> = found.iter().map(|diagnostic| diagnostic.0).collect();
        if wanted.is_empty()
            || lines != wanted
            || found.iter().any(|diagnostic| diagnostic.1 != code.id)
        {
            failures.push(format!("{}: should be at {wanted:?}: {found:#?}", code.id));
        }
        for accepted in good.split("// corrected\n") {
            let found = diagnostics(accepted);
            if !found.is_empty() {
                failures.push(format!("{}: {accepted}: {found:#?}", code.id));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_fixture_has_a_code() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/codes");
    let mut pending = vec![folder.clone()];
    while let Some(directory) = pending.pop() {
        for entry in fs::read_dir(directory).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                pending.push(path);
                continue;
            }
            let code = path.strip_prefix(&folder).unwrap().with_extension("");
            let code = code.to_str().unwrap();
            assert!(find(code).is_some(), "{code} is no code");
        }
    }
}

/// The codes of syntax have their examples in the table; these need other files, or are about excluded text.
const OF_FILES: [&str; 3] = ["pp-include-depth", "pp-include-place", "inactive-code"];

#[test]
fn examples_of_syntax_trigger_their_codes_until_they_are_corrected() {
    let shows =
        |text: &str, id: &str| reported(text).iter().any(|diagnostic| diagnostic.code == id);
    for code in dotgen_syntax::codes::all() {
        let page = Page::read(code.id).unwrap();
        let corrected = page.texts("genom", true);
        if corrected.is_empty() || OF_FILES.contains(&code.id) {
            continue;
        }
        let faulty = page.texts("genom", false)[0];
        // This one is about the end of the file.
        let faulty = if code.id == "pp-no-newline" { faulty.trim_end() } else { faulty };
        assert!(shows(faulty, code.id), "{}", code.id);
        assert!(!shows(corrected[0], code.id), "{}", code.id);
    }
}

/// One cause, one diagnostic: consequences of an error are not reported.
#[test]
fn consequences_are_quiet() {
    for (text, wanted) in [
        // An unknown type is unknown everywhere, once.
        (
            "typedef nope a; struct s { a x; a y[2]; }; const a k = 1; typedef long t[k];
             component c { ids { s all; }; port in a p; function f(in a v = 1) { codel g(in v, out all.x); }; };",
            &["unknown-type"][..],
        ),
        // Names of refused declarations are remembered.
        (
            "component c { const long c = 2; typedef long t[c]; };",
            &["name-clash-enclosing"],
        ),
        (
            "typedef long d; component c { function p(); port in d p;
             task t { codel<start> f(port in p) yields ether; }; };",
            &["redefinition"],
        ),
        // Names that an unknown interface may declare are not reported.
        (
            "component c { provides nope; activity a() { task t; codel<start> f(in x, port out p) yields ether;
             interrupts b; }; attribute get(out y); };",
            &["iface-unknown"],
        ),
        // A codel with a bad parameter still has its states, and its name.
        (
            "component c { task t { codel<start> f(in nope) yields main; codel<main> g() yields ether; };
             task u { codel<start> f(in neither) yields ether; }; };",
            &["param-unknown", "param-unknown"],
        ),
        // A forward declaration whose definition is refused.
        ("struct s; typedef long s; typedef sequence<s> t;", &["name-clash"]),
        // An invalid property still counts as given.
        (
            "component c { clock-rate TRUE; task t { period -1; delay 1; codel<start> f() yields ether; }; \
                };",
            &["const-numeric", "clock-rate-value"],
        ),
        // An interface imported twice.
        (
            "typedef long d; interface i { clock-rate 1; port in d p; port in d q; };
             component c { provides i; extends i; };",
            &["prop-duplicate"],
        ),
        // A body that ends twice is checked twice and reported once.
        (
            "component c { task t { codel<start> f() yields nope; }; }; component c { doc \"again\"; };",
            &["fsm/undefined-state"],
        ),
    ] {
        let found: Vec<&str> = diagnostics(text).iter().map(|diagnostic| diagnostic.1).collect();
        assert_eq!(found, wanted, "{text}\n{:#?}", diagnostics(text));
    }
}
