use std::sync::Arc;

use dotgen_analysis::diagnostic::{FileEdit, FixKind, Related};

use super::*;
use dotgen_lsp_server::protocol::convert::Encoding;

const ARM: &str = "\
#include \"pose.idl\"

component arm {
\tversion \"1.0\";
\tport in pose::stat goal; // 😀 où
\ttask motion {
\t\tcodel<start> init(port in gaol) yield ether
\t};
};
";

fn texts(files: &[(&str, &str)]) -> Texts {
    let lines = |text: &str| Lines::new(Arc::from(text), Encoding::Utf16);
    files.iter().map(|(path, text)| (Utf8PathBuf::from(path), lines(text))).collect()
}

/// Returns the range of the n-th occurrence of a text.
fn find(text: &str, what: &str, nth: usize) -> Range<usize> {
    let (at, _) = text.match_indices(what).nth(nth).expect("it occurs");
    at..at + what.len()
}

fn diagnostic(code: &'static str, message: &str, range: Range<usize>) -> Diagnostic {
    let path = "/robot/arm.gen".into();
    Diagnostic::new(code, Severity::Error, message, path, range)
}

fn shown(diagnostic: &Diagnostic, texts: &Texts) -> String {
    anstream::adapter::strip_str(&render(diagnostic, texts)).to_string()
}

#[test]
fn place_explanation_and_fix_are_shown() {
    let texts = texts(&[("/robot/arm.gen", ARM)]);
    let mut diagnostic = diagnostic(
        "param-unknown-port",
        "there is no port `gaol` in component `arm`; did you mean `goal`?",
        find(ARM, "gaol", 0),
    );
    diagnostic.related.push(Related {
        path: "/robot/arm.gen".into(),
        range: find(ARM, "goal", 0),
        message: "a port with a similar name".into(),
    });
    diagnostic.fixes.push(Fix {
        kind: FixKind::Guess,
        title: "change it to `goal`".to_owned(),
        edits: vec![FileEdit {
            path: "/robot/arm.gen".into(),
            range: find(ARM, "gaol", 0),
            new_text: "goal".to_owned(),
        }],
    });
    insta::assert_snapshot!(shown(&diagnostic, &texts));
}

#[test]
fn explanations_in_other_files_get_their_own_snippet() {
    const POSE: &str = "module pose {\r\n  struct state { double x; };\r\n};\r\n";
    let texts = texts(&[("/robot/arm.gen", ARM), ("/robot/pose.idl", POSE)]);
    let mut diagnostic =
        diagnostic("unknown-type", "`pose` has no member `stat`", find(ARM, "stat", 0));
    diagnostic.severity = Severity::Warning;
    diagnostic.related.push(Related {
        path: "/robot/pose.idl".into(),
        range: find(POSE, "pose", 0),
        message: "`pose` is declared here".into(),
    });
    insta::assert_snapshot!(shown(&diagnostic, &texts));
}

#[test]
fn the_end_of_the_file_and_missing_text_can_be_shown() {
    let texts = texts(&[("/robot/arm.gen", "component arm {\n")]);
    let mut diagnostic = diagnostic("syntax-eof", "expected `}`", 16..16);
    insta::assert_snapshot!("end", shown(&diagnostic, &texts));
    diagnostic.range = 15..15;
    insta::assert_snapshot!("end_of_line", shown(&diagnostic, &texts));
    diagnostic.path = "/robot/gone.gen".into();
    insta::assert_snapshot!("gone", shown(&diagnostic, &texts));
}

#[test]
fn odd_texts_and_ranges_do_not_hurt() {
    let long = format!("component {} {{", "a".repeat(1_000_000));
    let odd = "a\rb\r\nc\0\u{1b}[31m\td\u{202e}\n";
    let texts = texts(&[("/robot/arm.gen", odd), ("/robot/long.gen", &long)]);
    for start in 0..odd.len() + 3 {
        for end in start..odd.len() + 3 {
            let diagnostic = diagnostic("syntax", "odd", start..end);
            let text = shown(&diagnostic, &texts);
            assert!(text.contains("syntax") && !text.contains('\u{1b}'), "{text:?}");
        }
    }
    let mut diagnostic = diagnostic("syntax", "too long to show", 500_000..500_001);
    diagnostic.path = "/robot/long.gen".into();
    insta::assert_snapshot!("long", shown(&diagnostic, &texts));
}
