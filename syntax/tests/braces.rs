//! A missing brace is reported as one mistake, and all other declarations are understood.

use std::path::{Path, PathBuf};

use dotgen_syntax::{
    Parse, SyntaxKind,
    ast::{AstNode, Name},
    format::{self, Options, format},
    parse_text,
};

fn specifications(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").filter_map(std::result::Result::ok) {
        let path = entry.path();
        if path.is_dir() {
            specifications(&path, out);
        } else if path.extension().is_some_and(|extension| extension == "gen" || extension == "idl")
        {
            out.push(path);
        }
    }
    out.sort();
}

/// Correct texts: the examples, and published specifications if they are next to the project.
fn texts() -> Vec<(String, String)> {
    let mut found = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    specifications(&root.join("examples"), &mut found);
    assert!(!found.is_empty(), "there are examples");
    if let Some(published) = crate::suite::shared::optional("corpus") {
        specifications(&published, &mut found);
    }
    let read =
        |path: &PathBuf| Some((path.display().to_string(), std::fs::read_to_string(path).ok()?));
    let texts = found.iter().filter_map(read);
    texts.filter(|(_, text)| parse_text(text).errors.is_empty()).collect()
}

/// The names that a text declares, in order.
fn names(parse: &Parse) -> Vec<String> {
    let names = parse.syntax().descendants().filter_map(Name::cast);
    names.map(|name| name.text(&parse.expansion).to_string()).collect()
}

/// The braces of a kind around bodies.
fn braces(parse: &Parse, kind: SyntaxKind) -> Vec<usize> {
    let tokens = parse.syntax().descendants_with_tokens();
    let tokens = tokens.filter_map(rowan::NodeOrToken::into_token);
    tokens
        .filter(|token| token.kind() == kind && !token.text_range().is_empty())
        .filter(|token| {
            let parent = token.parent().map(|parent| parent.kind());
            matches!(parent, Some(SyntaxKind::BODY | SyntaxKind::ENUMERATOR_LIST))
        })
        .map(|token| token.text_range().start().into())
        .collect()
}

/// Removes each brace of a kind from every text, with `more` of the text that follows it, and lists the
/// removals that are not reported as one mistake.
fn check_without_each(kind: SyntaxKind, more: &str) {
    let (mut all, mut bad) = (0, Vec::new());
    for (path, text) in texts() {
        let right = parse_text(&text);
        let expected = names(&right);
        for start in braces(&right, kind) {
            let rest = &text[start + 1..];
            let broken = format!("{}{}", &text[..start], rest.strip_prefix(more).unwrap_or(rest));
            let parse = parse_text(&broken);
            assert_eq!(parse.syntax().text().to_string(), broken);
            all += 1;
            let line = text[..start].matches('\n').count() + 1;
            if parse.errors.len() != 1 || names(&parse) != expected {
                bad.push(format!("{path}:{line}: {:#?}", parse.errors));
            }
        }
    }
    assert!(all > 100, "there are braces");
    assert!(bad.is_empty(), "{} of {all}\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn a_forgotten_opening_brace_is_one_error() {
    check_without_each(SyntaxKind::L_CURLY, "");
}

#[test]
fn a_forgotten_closing_brace_is_one_error() {
    check_without_each(SyntaxKind::R_CURLY, "");
}

#[test]
fn a_forgotten_closing_brace_and_semicolon_are_one_error() {
    check_without_each(SyntaxKind::R_CURLY, ";");
}

/// A file whose structure is a guess is not formatted.
#[test]
fn a_text_with_a_forgotten_brace_is_not_formatted() {
    let text = "component c {\n  task t {\n  period   5 ms;\n  port in n p;\n};\n";
    let parse = parse_text(text);
    let style = Options::default();
    assert_eq!(format(&parse.syntax(), &parse.broken(), None, &style), []);
}

#[test]
fn what_does_not_parse_stays_beyond_the_last_error_that_is_listed() {
    let broken = "struct  a { long ; };\n".repeat(600);
    let text = format!("struct  good  {{ long x; }};\n{broken}struct  last  {{ long ; }};\n");
    let parse = parse_text(&text);
    assert!(parse.errors.len() < 600, "there are more than are listed");
    let edits = format::format(&parse.syntax(), &parse.broken(), None, &Options::default());
    let new = format::apply(&text, &edits);
    assert!(new.starts_with("struct good {"), "{}", &new[..40]);
    assert!(new.ends_with(&format!("{broken}struct  last  {{ long ; }};\n")));
}
