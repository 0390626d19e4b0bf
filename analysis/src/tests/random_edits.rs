//! For any edits in any order, an incremental database answers like a fresh one, and nothing panics.

use camino::{Utf8Path, Utf8PathBuf};
use proptest::prelude::*;

use crate::{
    host::{Change, Config},
    ide::FilePosition,
    test_support::{Fixture, split},
};

pub(super) const FILES: &str = r#"
//- /c.gen
#include "i.gen"
#include "t.idl"
#define STATE(name) codel<name> on_##name(ids in v) yield ether
component c {
  doc "documented";
  provides i;
  ids { m::s v; sequence<long, N> w; };
  task t { period 10 ms; };
  port in m::s p;
  attribute set(in v.x = 1 : "x", out w);
  activity go(in long speed = 3) {
    task t;
    local m::s tmp;
    validate check(in speed);
    STATE(start);
    codel<stop> end(port in p, local inout tmp) yield ether;
  };
};
//- /d.gen
#pragma requires "p"
#include "i.gen"
#ifdef N
component d { uses i;
#include "body.idl"
};
#else
component d { version "2"; };
#endif
//- /i.gen
#ifndef I
#define I
#include <t.idl>
interface i { function f(in m::s a); port out m::s q; };
#endif
//- /t.idl
#ifndef T
#define T
#define N 3
module m {
  enum e { A, B };
  struct s { long x, y[N]; e k; };
  union u switch (e) { case A: long a; default: s b; };
  const double half = 1 / 2.0;
  exception bad { string<8> why; };
};
#endif
//- /body.idl
version "1"; throws m::bad;
"#;

/// Pieces of text that form interesting texts.
const PIECES: &[&str] = &[
    "\n",
    " ",
    ";",
    "{",
    "}",
    "(",
    ")",
    "<",
    ">",
    "\"",
    "/*",
    "*/",
    "//",
    "#",
    "#if 0\n",
    "\n#endif\n",
    "\n#include \"t.idl\"\n",
    "\n#include \"c.gen\"\n",
    "\n#define N 4\n",
    "\n#undef N\n",
    "m::s",
    "in ",
    "ids in v.x",
    "codel<start> f() yield ether;",
    "struct s;",
    "typedef m::s z;",
    "const long N = N;",
    "component c { };",
    "N",
    "STATE(x)",
    "é",
    "\\\n",
    "\n#pragma provides i\n",
    "9999999999999999999",
];

#[derive(Debug, Clone)]
enum Edit {
    Insert(usize, u16, usize),
    Delete(usize, u16, u16),
    Remove(usize),
    Restore(usize),
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let file = 0..5_usize;
    let edit = prop_oneof![
        5 => (file.clone(), any::<u16>(), 0..PIECES.len()).prop_map(|(f, at, p)| Edit::Insert(f, at, p)),
        3 => (file.clone(), any::<u16>(), 1..40_u16).prop_map(|(f, at, n)| Edit::Delete(f, at, n)),
        1 => file.clone().prop_map(Edit::Remove),
        2 => file.prop_map(Edit::Restore),
    ];
    prop::collection::vec(edit, 1..10)
}

fn boundary(text: &str, at: u16) -> usize {
    let mut at = usize::from(at) % (text.len() + 1);
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

fn apply(fixture: &mut Fixture, original: &[(Utf8PathBuf, String)], edit: &Edit) {
    let (Edit::Insert(i, ..) | Edit::Delete(i, ..) | Edit::Remove(i) | Edit::Restore(i)) = *edit;
    let path = original[i].0.clone();
    let old = fixture.loader.files.lock().unwrap().get(&path).cloned();
    let new = match (edit, old) {
        (Edit::Insert(_, at, piece), Some(mut text)) => {
            let at = boundary(&text, *at);
            text.insert_str(at, PIECES[*piece]);
            Some(text)
        }
        (Edit::Delete(_, at, length), Some(mut text)) => {
            let start = boundary(&text, *at);
            let end = text.len().min(start + usize::from(*length));
            let end = (end..=text.len()).find(|end| text.is_char_boundary(*end)).unwrap();
            text.replace_range(start..end, "");
            Some(text)
        }
        (Edit::Remove(_), _) => None,
        (Edit::Restore(_), _) => Some(original[i].1.clone()),
        (_, None) => None,
    };
    let mut files = fixture.loader.files.lock().unwrap();
    match &new {
        Some(text) => _ = files.insert(path.clone(), text.clone()),
        None => _ = files.remove(&path),
    }
    drop(files);
    fixture.host.apply(Change { files: vec![(path, new)], ..Change::default() });
}

/// Everything that must be equal, as text.
fn answers(fixture: &Fixture, paths: &[Utf8PathBuf]) -> String {
    let analysis = fixture.analysis();
    let mut out = String::new();
    for path in paths {
        let unit = analysis.unit(path).unwrap();
        out += &format!(
            "{path}\n{:#?}\n{:#?}\n{:#?}\n{:?}\n",
            analysis.diagnostics(path).unwrap(),
            analysis.document_symbols(path).unwrap(),
            unit.spec,
            analysis.semantic_tokens(path, None).unwrap(),
        );
    }
    out + &format!("{:#?}", analysis.workspace_symbols("", 1000).unwrap())
}

fn config() -> Config {
    Config { include_dirs: vec!["/".into()], ..Config::default() }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn incremental_equals_fresh(edits in edits()) {
        let original = split(FILES);
        let mut fixture = Fixture::with_config(FILES, config());
        let paths: Vec<Utf8PathBuf> = original.iter().map(|file| file.0.clone()).collect();
        answers(&fixture, &paths);
        for (i, edit) in edits.iter().enumerate() {
            apply(&mut fixture, &original, edit);
            // Not after every edit, so that several changes precede one query too.
            if i % 2 == 0 || i + 1 == edits.len() {
                let fresh = Fixture::with_config("//- /none.idl\n", config());
                *fresh.loader.files.lock().unwrap() = fixture.loader.files.lock().unwrap().clone();
                let mut fresh = fresh;
                fresh.host.apply(Change {
                    roots: Some(vec!["/c.gen".into(), "/d.gen".into(), "/i.gen".into()]),
                    ..Change::default()
                });
                prop_assert_eq!(answers(&fixture, &paths), answers(&fresh, &paths));
            }
        }
    }
}

/// Runs every query at an offset.
fn ask_everything(fixture: &Fixture, path: &Utf8Path, offset: usize) {
    let analysis = fixture.analysis();
    let at = FilePosition { path: path.to_owned(), offset };
    analysis.goto_definition(&at).unwrap();
    analysis.goto_declaration(&at).unwrap();
    analysis.goto_type_definition(&at).unwrap();
    analysis.references(&at, true).unwrap();
    analysis.highlights(&at).unwrap();
    analysis.hover(&at).unwrap();
    let ranges = analysis.selection_ranges(path, &[offset]).unwrap();
    assert!(!ranges[0].is_empty());
}

fn ask_about_file(fixture: &Fixture, path: &Utf8Path) {
    let analysis = fixture.analysis();
    let length = fixture.text(path.as_str()).len();
    for token in analysis.semantic_tokens(path, None).unwrap() {
        assert!(token.range.start < token.range.end && token.range.end <= length);
    }
    analysis.folding_ranges(path).unwrap();
    analysis.document_symbols(path).unwrap();
    analysis.document_links(path).unwrap();
    analysis.diagnostics(path).unwrap();
    analysis.syntax_tree(path).unwrap();
}

#[test]
fn no_panic_at_any_offset_of_half_typed_files() {
    for (path, text) in split(FILES) {
        let mut fixture = Fixture::with_config(FILES, config());
        let ends = (0..=text.len()).filter(|end| text.is_char_boundary(*end)).step_by(7);
        for end in ends.chain([text.len()]) {
            fixture.edit(path.as_str(), &text[..end]);
            ask_about_file(&fixture, &path);
            // Near the end always; elsewhere at some offsets.
            for offset in 0..=end + 1 {
                if offset + 3 > end || offset % 61 == end % 61 {
                    ask_everything(&fixture, &path, offset);
                }
            }
        }
        for offset in 0..=text.len() {
            ask_everything(&fixture, &path, offset);
        }
    }
}
