//! The syntax layer against the conformance suite and the specifications of the shared corpus, if they are
//! present.

use std::path::{Path, PathBuf};

use dotgen_syntax::{Fragment, Parse, Severity, lexer, parse, parse_text, preproc};
use serde_json::Value;

use crate::suite::shared::shared;

/// All `.gen` and `.idl` files below a directory, in order.
fn specifications(dir: &Path, acc: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(dir)
        .expect("readable directory")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            specifications(&path, acc);
        } else if path.extension().is_some_and(|extension| extension == "gen" || extension == "idl")
        {
            acc.push(path);
        }
    }
}

fn read(path: &Path) -> String {
    String::from_utf8_lossy(&std::fs::read(path).expect("readable file")).into_owned()
}

/// 1-based lines of all errors, those of the preprocessor included.
fn error_lines(text: &str) -> Vec<(usize, String)> {
    let raw = lexer::lex(text);
    let env = preproc::MacroEnv::default();
    let pre = preproc::preprocess(&"main.gen".into(), text, &raw, env, &mut preproc::NoIncludes);
    let parse = parse(text, &raw, &pre, Fragment::Specification);
    let line = |at: usize| text[..at].matches('\n').count() + 1;
    let own = parse.errors.iter().filter(|error| error.severity == Severity::Error);
    let other = pre.errors.iter().filter(|error| error.severity == Severity::Error);
    own.map(|error| {
        (line(error.range.start().into()), format!("{}: {}", error.code(), error.wording()))
    })
    .chain(other.map(|error| {
        (
            line(error.range.start().into()),
            format!("{}: {}", error.kind.code(), error.kind.wording()),
        )
    }))
    .collect()
}

#[test]
fn conformance_of_the_syntax_layer() {
    let Some(dir) = shared("conformance") else {
        return;
    };
    let expected: Value =
        serde_json::from_str(&read(&dir.join("expected.json"))).expect("expected.json");
    let mut failures = Vec::new();
    let mut checked = 0;
    for (name, case) in expected.as_object().expect("an object of cases") {
        let text = read(&dir.join(case["file"].as_str().expect("file")));
        // Texts that need other files or definitions are tested in the layers above.
        if text.contains("#include") || text.contains("#pragma require") || case["args"].is_array()
        {
            continue;
        }
        let ours = if case["ours"].is_object() { &case["ours"] } else { case };
        let errors = error_lines(&text);
        checked += 1;
        if ours["verdict"] == "accept" {
            if !errors.is_empty() {
                failures.push(format!("{name}: accepted, but {errors:?}"));
            }
            continue;
        }
        for error in ours["errors"].as_array().into_iter().flatten() {
            let check = error["check"].as_str().unwrap_or_default();
            let of_syntax = check.starts_with("syntax") || check.starts_with("missing-");
            if !of_syntax || error["consequence"] == true {
                continue;
            }
            let also = error["also"].as_array().into_iter().flatten();
            let good = also
                .chain([&error["line"]])
                .filter_map(Value::as_u64)
                .any(|line| errors.iter().any(|(at, _)| at.abs_diff(line as usize) <= 1));
            if !good {
                failures.push(format!("{name}: no error near {error}; have {errors:?}"));
            }
        }
    }
    assert!(checked > 100, "only {checked} cases were found");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn specifications_that_the_reference_accepts_have_no_syntax_error() {
    for name in ["corpus", "golden/inputs"] {
        let Some(dir) = shared(name) else { continue };
        let mut files = Vec::new();
        specifications(&dir, &mut files);
        assert!(!files.is_empty());
        for file in files {
            let text = read(&file);
            let parse = parse_text(&text);
            assert_eq!(parse.syntax().text().to_string(), text, "{}", file.display());
            let errors: Vec<_> =
                parse.errors.iter().filter(|error| error.severity == Severity::Error).collect();
            assert!(errors.is_empty(), "{}: {errors:?}", file.display());
        }
    }
}

#[test]
fn truncations_keep_their_text() {
    for name in ["corpus", "golden/inputs", "conformance"] {
        let Some(dir) = shared(name) else { continue };
        let mut files = Vec::new();
        specifications(&dir, &mut files);
        for file in files {
            let text = read(&file);
            let raw = lexer::lex(&text);
            // Every token in small files, a regular sample of tokens in others.
            let step = 1 + raw.len() / 300;
            for i in (0..raw.len()).step_by(step) {
                let cut = &text[..raw.range(i).start];
                assert_text(&parse_text(cut), cut);
            }
        }
    }
}

fn assert_text(parse: &Parse, text: &str) {
    assert!(
        parse.syntax().text() == text,
        "text lost after {:?}",
        text.get(text.len().saturating_sub(60)..)
    );
}
