//! For any text: no panic, no lost text, no quadratic time, no stack overflow.

use std::path::Path;

use dotgen_syntax::{
    Fragment, Parse,
    ast::{self, AstNode, HasBody},
    lexer, parse, parse_text, preproc,
};
use proptest::{
    prelude::*,
    sample::Index,
    test_runner::{Config, TestRunner},
};

/// The text of the tree is the text of the file, and everything in the tree can be visited.
fn check(text: &str) -> Parse {
    let parse = parse_text(text);
    let root = parse.syntax();
    assert!(root.text() == text, "text lost");
    let end = root.text_range().end();
    for error in &parse.errors {
        assert!(error.range.end() <= end, "error outside the text: {error:?}");
        assert!(!error.wording().to_string().is_empty());
    }
    for token in root
        .descendants_with_tokens()
        .filter_map(rowan::NodeOrToken::into_token)
        .filter(|token| token.text_range().is_empty())
    {
        assert!(parse.expansion.virtual_token(&token).is_some(), "empty token without text");
    }
    parse
}

/// Texts of this project: correct, wrong and with macros.
fn fixtures() -> Vec<String> {
    let mut texts = Vec::new();
    for kind in ["inline", "ok", "err"] {
        let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("test_data/parser").join(kind);
        let mut files: Vec<_> = std::fs::read_dir(dir)
            .expect("fixtures")
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.extension().is_some_and(|extension| extension == "gen"))
            .collect();
        files.sort();
        texts.extend(files.iter().map(|file| std::fs::read_to_string(file).expect("readable")));
    }
    texts
}

/// Pieces that change the structure of the text after them.
const PIECES: &[&str] = &[
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    "<",
    ">",
    ";",
    ":",
    "::",
    ",",
    "=",
    ".",
    "\"",
    "'",
    "/*",
    "*/",
    "//",
    "\n",
    "\\\n",
    "#",
    "\n#if 0\n",
    "\n#else\n",
    "\n#endif\n",
    "\n#define M(x) x; {\n",
    "\n#define N component c {\n",
    " N ",
    " M(1) ",
    " M(",
    "\n#include \"x\"\n",
    "\n#pragma wcet f 1 ms\n",
    "\n#pragma wcet",
    " component ",
    " task ",
    " codel<",
    " yield ",
    " port in ",
    " ids ",
    " struct ",
    " case ",
    " in ",
    " wcet ",
    " 12 ",
    " 500us ",
    "\0",
    "é",
    "@",
    "const long a = ",
    ">>",
    "-",
    "%:",
];

#[derive(Debug, Clone)]
struct Edit {
    at: Index,
    delete: usize,
    insert: Option<usize>,
}

fn edits() -> impl Strategy<Value = (Index, Vec<Edit>)> {
    let edit = (any::<Index>(), 0..12usize, prop::option::of(0..PIECES.len()))
        .prop_map(|(at, delete, insert)| Edit { at, delete, insert });
    (any::<Index>(), prop::collection::vec(edit, 1..6))
}

fn apply(text: &str, edits: &[Edit]) -> String {
    let mut text = text.to_owned();
    for edit in edits {
        let boundary = |mut at: usize| {
            at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = boundary(edit.at.index(text.len() + 1));
        let end = boundary(start + edit.delete);
        let piece = edit.insert.map_or("", |piece| PIECES[piece]);
        text.replace_range(start..end.max(start), piece);
    }
    text
}

fn random_edits(cases: u32, texts: &[String]) {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new(config)
        .run(&edits(), |(file, edits)| {
            let text = apply(&texts[file.index(texts.len())], &edits);
            check(&text);
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn random_edits_keep_the_text() {
    random_edits(3_000, &fixtures());
}

#[test]
#[ignore = "100,000 edits; run it in a release build"]
fn many_random_edits_keep_the_text() {
    let mut texts = fixtures();
    let folders = ["corpus", "golden/inputs"].into_iter();
    let mut stack: Vec<_> = folders.filter_map(crate::suite::shared::shared).collect();
    while let Some(dir) = stack.pop() {
        let Ok(entries) = std::fs::read_dir(&dir) else {
            continue;
        };
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            if path.is_dir() {
                stack.push(path);
            } else if path
                .extension()
                .is_some_and(|extension| extension == "gen" || extension == "idl")
            {
                texts.push(String::from_utf8_lossy(&std::fs::read(path).expect("readable")).into());
            }
        }
    }
    random_edits(100_000, &texts);
}

#[test]
fn truncations_of_our_texts_keep_the_text() {
    for text in fixtures() {
        let raw = lexer::lex(&text);
        for i in 0..raw.len() {
            check(&text[..raw.range(i).start]);
            check(&text[raw.range(i).start..]);
        }
    }
}

#[test]
fn every_fragment_reads_every_text() {
    for text in fixtures() {
        let raw = lexer::lex(&text);
        let env = preproc::MacroEnv::default();
        let pre = preproc::preprocess(&"f".into(), &text, &raw, env, &mut preproc::NoIncludes);
        for fragment in [
            Fragment::Module,
            Fragment::Component,
            Fragment::Members,
            Fragment::Cases,
            Fragment::Properties,
        ] {
            let parse = parse(&text, &raw, &pre, fragment);
            assert!(parse.syntax().text() == text.as_str());
        }
    }
}

#[test]
fn deep_nesting_is_an_error_and_no_overflow() {
    // With 64 bytes for each level, a recursion would fill the stack of a test, 2 MiB.
    let depth = 1 << 15;
    for (open, prefix) in [
        ("(", "const long a = "),
        ("(", ""),
        ("{", ""),
        ("[", ""),
        ("<", "component c { activity a() { codel"),
        ("{", "component c { function f(in long a = "),
        ("{ [1] = ", "component c { function f(in long a = "),
        ("module m { ", ""),
        ("component c { ", ""),
        ("struct s { ", ""),
        ("struct s { long x; struct t { ", ""),
        ("union u switch (long) { case 1: ", ""),
        ("union u switch (", ""),
        ("sequence<", "typedef "),
        ("optional<", "struct s { "),
        ("-(", "const long a = "),
        ("- ", "const long a = "),
        ("1 + ", "const long a = "),
        ("1 | 2 ^ 3 & 4 << 5 + 6 * ", "const long a = "),
        ("a::", "const long a = "),
        ("[0]", "typedef long a"),
        ("task t { ", "component c { "),
        ("\n#if 1\n", ""),
        ("\n#if 0\n", ""),
        ("exception e { ", ""),
        ("function f(in struct s { ", "component c { "),
    ] {
        let text = format!("{prefix}{}", open.repeat(depth));
        let parse = check(&text);
        assert!(!parse.errors.is_empty() || open.contains('#'), "{prefix}{open}… is accepted");
        assert!(parse.errors.len() < 600);
        let closed = format!("{prefix}{}{}", open.repeat(1000), ")}]>".repeat(1000));
        check(&closed);
    }
}

#[test]
fn a_long_correct_expression_is_read() {
    let text = format!("const long a = 1{};", " + 1".repeat(150));
    assert_eq!(check(&text).errors, []);
}

#[test]
fn large_and_odd_texts() {
    let good = "component c { doc \"x\"; ids { long a; }; task t { period 5 ms; }; };\n";
    let ten_mega = good.repeat((10 << 20) / good.len());
    let parse = check(&ten_mega);
    assert_eq!(parse.errors, []);
    assert_eq!(parse.tree().items().count(), (10 << 20) / good.len());

    for text in ["\0", "\0\0{\0", "\u{feff}component c;", "\r", "a\rb", "é", "'", "\"", "#", "\\"]
    {
        check(text);
        check(&text.repeat(10_000));
    }
    // One token as long as a file.
    for piece in ["é", "a", "1", "0x", "1e", " ", "\\\n", "'", "\"é", "\"\\", "_-"] {
        check(&piece.repeat(1 << 16));
        check(&format!("// {}", piece.repeat(1 << 16)));
        check(&format!("/* {}", piece.repeat(1 << 16)));
        check(&format!("\"{}", piece.repeat(1 << 16)));
    }
    check(&"foo bar; ".repeat(1 << 15));
    check(&"} ".repeat(1 << 17));
    check(&"; ".repeat(1 << 17));
    check(&"// c\n".repeat(1 << 16));
    check(&"#define A A A\nA\n".repeat(1 << 12));
}

#[test]
fn a_large_expansion_is_read_in_linear_time() {
    let mut text = String::from("#define M0 x,\n");
    for i in 1..=4 {
        text.push_str(&format!("#define M{i} {}\n", format!("M{} ", i - 1).repeat(10)));
    }
    text.push_str("enum e { M4 last };\n");
    let parse = check(&text);
    assert_eq!(parse.errors, []);
    let names = parse.syntax().descendants().filter_map(ast::Name::cast);
    let texts: Vec<_> = names.map(|name| name.text(&parse.expansion)).skip(5).collect();
    assert_eq!(texts.len(), 10_002);
    assert_eq!((&*texts[0], &*texts[1], &*texts[10_001]), ("e", "x", "last"));
}

#[test]
fn directives_stand_among_the_items_of_their_body() {
    let text = "\
#include \"a\"
component c {
  doc \"x\";
#include \"b\"
  task t {
    period 1;
#pragma requires \"p\"
  };
#if 0
  junk
#endif
};
#pragma provides i
";
    let parse = check(text);
    let kinds = |items: Vec<dotgen_syntax::ast::Item>| {
        items.iter().map(|item| format!("{:?}", item.syntax().kind())).collect::<Vec<_>>()
    };
    let items: Vec<_> = parse.tree().items().collect();
    assert_eq!(kinds(items.clone()), ["DIRECTIVE", "COMPONENT", "DIRECTIVE"]);
    let dotgen_syntax::ast::Item::Component(component) = &items[1] else {
        panic!("a component");
    };
    let inside: Vec<_> = component.items().collect();
    assert_eq!(
        kinds(inside.clone()),
        ["STRING_PROPERTY", "DIRECTIVE", "TASK", "DIRECTIVE", "DIRECTIVE"]
    );
    let dotgen_syntax::ast::Item::Task(task) = &inside[2] else {
        panic!("a task");
    };
    assert_eq!(kinds(task.items().collect()), ["DURATION_PROPERTY", "DIRECTIVE"]);
}
