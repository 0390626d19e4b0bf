//! Trees and errors of small texts.
//!
//! `test_data/parser/inline` holds the examples in the comments of the grammar (`// test NAME` and
//! the comment lines below it), written by a test here; `ok` and `err` are written by hand. Next to
//! each text is the dump of its tree: set `UPDATE_EXPECT=1` to write it, then read it.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use dotgen_syntax::{
    Severity,
    ast::{AstNode, Name, Quantity},
    dump, parse_text,
};
use expect_test::expect_file;

fn manifest() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn data(kind: &str) -> PathBuf {
    manifest().join("test_data/parser").join(kind)
}

fn files(dir: &Path, extension: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(dir)
        .unwrap_or_else(|error| panic!("{}: {error}", dir.display()))
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|name| name == extension))
        .collect();
    files.sort();
    files
}

/// The examples in the comments of the grammar.
fn examples() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for file in files(&manifest().join("src/parser/grammar"), "rs") {
        let source = fs::read_to_string(file).expect("readable source");
        let mut lines = source.lines().peekable();
        while let Some(line) = lines.next() {
            let Some(name) = line.strip_prefix("// test ") else {
                continue;
            };
            let mut text = String::new();
            while let Some(line) = lines.peek().and_then(|line| line.strip_prefix("//")) {
                text.push_str(line.strip_prefix(' ').unwrap_or(line));
                text.push('\n');
                lines.next();
            }
            let old = found.insert(name.to_owned(), text);
            assert!(old.is_none(), "two examples are called {name}");
        }
    }
    found
}

#[test]
fn inline_examples_are_up_to_date() {
    let dir = data("inline");
    fs::create_dir_all(&dir).expect("directory for the examples");
    let examples = examples();
    assert!(examples.len() > 15, "examples are found");
    let mut changed = Vec::new();
    for (name, text) in &examples {
        let path = dir.join(format!("{name}.gen"));
        if fs::read_to_string(&path).ok().as_deref() != Some(text) {
            fs::write(&path, text).expect("write the example");
            changed.push(name.clone());
        }
    }
    for path in files(&dir, "gen") {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !examples.contains_key(&name) {
            fs::remove_file(&path).expect("remove an old example");
            let _ = fs::remove_file(path.with_extension("tree"));
            changed.push(name);
        }
    }
    assert!(
        changed.is_empty(),
        "examples were not up to date, they are now: {changed:?}; look at the change and commit it"
    );
}

#[test]
fn correct_texts() {
    for path in files(&data("inline"), "gen").into_iter().chain(files(&data("ok"), "gen")) {
        let (text, parse) = check(&path);
        let errors: Vec<_> =
            parse.errors.iter().filter(|error| error.severity == Severity::Error).collect();
        assert!(errors.is_empty(), "{}: {errors:?}\n{text}", path.display());
    }
}

#[test]
fn broken_texts() {
    for path in files(&data("err"), "gen") {
        let (text, parse) = check(&path);
        assert!(
            parse.errors.iter().any(|error| error.severity == Severity::Error),
            "{} has no error\n{text}",
            path.display()
        );
    }
}

fn check(path: &Path) -> (String, dotgen_syntax::Parse) {
    let text = fs::read_to_string(path).expect("readable text");
    let parse = parse_text(&text);
    assert_eq!(parse.syntax().text().to_string(), text, "{}", path.display());
    expect_file![path.with_extension("tree")].assert_eq(&dump(&parse));
    (text, parse)
}

#[test]
fn names_out_of_macros_can_be_read() {
    let text = "\
#define COMPONENT component c {
#define PORT(dir, name) port dir t name;
#define JOIN(a) a ## _t
#define UNIT 5ms
COMPONENT
PORT(in, p) PORT(out, q)
task JOIN(main) { period UNIT; delay 5 ms; delay 500us; };
};
const long spl\\
iced = 1;
";
    let parse = parse_text(text);
    assert_eq!(parse.errors, []);
    let names = parse.syntax().descendants().filter_map(Name::cast);
    let names: Vec<_> = names
        .map(|name| (name.text(&parse.expansion), &text[name.range(&parse.expansion)]))
        .collect();
    let names: Vec<_> = names.iter().map(|(name, at)| (name.as_str(), *at)).collect();
    assert_eq!(
        names[4..],
        [
            ("c", "COMPONENT"),
            ("p", "PORT(in, p)"),
            ("q", "PORT(out, q)"),
            ("main_t", "JOIN(main)"),
            ("spliced", "spl\\\niced"),
        ]
    );
    let glued: Vec<_> = parse
        .syntax()
        .descendants()
        .filter_map(Quantity::cast)
        .map(|quantity| quantity.is_glued(&parse.expansion))
        .collect();
    assert_eq!(glued, [true, false, true]);
}
