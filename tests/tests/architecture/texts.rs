//! Nothing reads a rendered text: not a message, nor a name, time, title or label.

use dotgen_tests::workspace_root;

use super::{ALLOWED, files, walk};

/// Ways to look into a text.
const TEXT_SEARCHES: [&str; 14] = [
    "split",
    "rsplit",
    "contains(",
    "strip_",
    "find(",
    "rfind(",
    "starts_with(",
    "ends_with(",
    "matches(",
    "match_indices(",
    "trim_start_matches(",
    "trim_end_matches(",
    "lines()",
    "replace(",
];

/// Names of texts that people read.
const TEXTS: [&str; 5] = ["message", "message()", "wording()", "wording().what", "advice"];

/// Places of a source that look into a message, by line.
fn text_searches(source: &str) -> Vec<usize> {
    // Without blanks, so that a chain over several lines is seen, with the line of each byte.
    let mut text = String::new();
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(source.lines()) {
        let code = line.split("//").next().unwrap_or_default();
        for c in code.chars().filter(|character| !character.is_whitespace()) {
            text.push(c);
            lines.extend(std::iter::repeat_n(number, c.len_utf8()));
        }
    }
    let through = ["", ".as_str()", ".as_ref()", ".to_string()", ".clone()"];
    let mut found = Vec::new();
    for subject in TEXTS {
        for (i, _) in text.match_indices(&format!("{subject}.")) {
            let before = text[..i].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
                continue;
            }
            let rest = &text[i + subject.len()..];
            let text_searches = through.iter().any(|text| {
                let rest = rest.strip_prefix(text).and_then(|rest| rest.strip_prefix('.'));
                rest.is_some_and(|rest| TEXT_SEARCHES.iter().any(|search| rest.starts_with(search)))
            });
            if text_searches {
                found.push(lines[i]);
            }
        }
    }
    found
}

#[test]
fn nothing_looks_into_a_message() {
    let crates = [
        "syntax",
        "analysis",
        "diagram",
        "codegen",
        "timing",
        "runtime",
        "recording",
        "export",
        "xta",
        "platform",
        "ros2",
        "hosting",
        "views",
        "lsp-server",
        "cli",
    ];
    let mut bad = Vec::new();
    for folder in crates {
        let sources = walk(&workspace_root().join(folder).join("src"));
        assert!(!sources.is_empty(), "no sources in {folder}");
        for path in sources {
            // Tests may look at what is said.
            let name = path.to_string_lossy().replace('\\', "/");
            if name.contains("/tests/") || name.ends_with("tests.rs") {
                continue;
            }
            // Where words are made; and where those of another program, of Tcl, are all there is.
            if name.contains("/finding/") || name.ends_with("/template/error_location.rs") {
                continue;
            }
            let source = std::fs::read_to_string(&path).unwrap();
            bad.extend(text_searches(&source).iter().map(|line| format!("{name}:{line}")));
        }
    }
    assert!(bad.is_empty(), "a message is read back; let the finding say it: {bad:#?}");
}

#[test]
fn a_look_into_a_message_is_seen() {
    for source in [
        "let a = it.message.split('`');",
        "if it\n    .message\n    .as_str()\n    .contains(\"x\") {}",
        "let (a, b) = message.split_once(';')?;",
        "error.message().starts_with(\"no\")",
    ] {
        assert_eq!(text_searches(source).len(), 1, "{source}");
    }
    for source in [
        "let a = it.message.clone();",
        "// it.message.split(';')",
        "self.messages.contains(&it)",
        "out.push_str(&it.message);",
    ] {
        assert_eq!(text_searches(source).len(), 0, "{source}");
    }
}

/// Ways to take a name of a codel or thread, a time, a title, a label or a sentence apart again, in Rust
/// and in TypeScript. Blanks are left out, also those in quotes.
const PARTS_OF_TEXT: [&str; 20] = [
    "rsplit('.')",
    "rsplit_once('.')",
    "rsplit_once('')",
    "unit.split",
    "codel.rsplit",
    "thread.split",
    "codel.strip_prefix(",
    "thread.strip_prefix(",
    "task.strip_prefix(&",
    "\"us\"=>1.0",
    "exec(run.title)",
    "title.match(",
    "title.split(",
    "title.startsWith(",
    "title.includes(",
    "label.startsWith(",
    "label.rfind(",
    "label.split",
    "label.strip_",
    "replace('`'",
];

/// Places of a source that take such a text apart, by line.
fn taken_apart(source: &str) -> Vec<usize> {
    let code = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        code.chars().filter(|character| !character.is_whitespace()).collect()
    };
    let has_parts = |line: &str| {
        let code: String = code(line);
        PARTS_OF_TEXT.iter().any(|part| code.contains(part))
    };
    let lines = (1..).zip(source.lines());
    lines.filter(|line| has_parts(line.1)).map(|line| line.0).collect()
}

/// The parts of a run are data: `CodelName`, `ThreadName`, `TimeUnit`.
#[test]
fn names_and_times_are_not_taken_apart() {
    let mut sources = Vec::new();
    for (folder, _) in ALLOWED {
        let folder = workspace_root().join(folder).join("src");
        sources.extend(files(&folder, "rs"));
    }
    let rust = sources.len();
    sources.extend(files(&workspace_root().join("vscode-extension/src"), "ts"));
    assert!(rust > 0 && sources.len() > rust, "no sources");
    let mut bad = Vec::new();
    for path in sources {
        let name = path.to_string_lossy().replace('\\', "/");
        // Endings of names of files, and times that users write; the messages of the reference compiler,
        // which have no quotes; a comparison of VS Code, of which the label is all that is known.
        let other = [
            "codegen/src/codels/source.rs",
            "codegen/src/component.rs",
            "analysis/src/finding.rs",
            "syntax/src/finding/preprocessing.rs",
            "vscode-extension/src/generate/review.ts",
        ];
        let is_other = other.iter().any(|text| name.ends_with(text));
        if name.contains("/tests/") || name.ends_with("tests.rs") || is_other {
            continue;
        }
        let source = std::fs::read_to_string(&path).expect("a source");
        let lines = taken_apart(&source);
        bad.extend(lines.iter().map(|line| format!("{name}:{line}")));
    }
    assert!(bad.is_empty(), "a name or time is read back; pass the data: {bad:#?}");
}

#[test]
fn a_name_or_time_that_is_taken_apart_is_seen() {
    for source in [
        "let last = codel.path.rsplit('.').next();",
        "let (number, unit) = value.rsplit_once(' ')?;",
        "match unit.split_once(' ') {}",
        "\"us\" => 1.0,",
        "task.strip_prefix(&*event.component)",
        "const [, what] = /: (an? .*)$/.exec(run.title) ?? [];",
        "let at = label.rfind([' ', ':']).map_or(0, |index| index + 1);",
        "let name = label.strip_suffix(\" =\").unwrap_or(label);",
        "const action = actions.find((it) => it.title.startsWith(WRITE_OUT));",
        ".map(|cause| cause.wait_in_words(unit).replace('`', \"\"));",
    ] {
        assert_eq!(taken_apart(source), [1], "{source}");
    }
    for source in ["codel.path.own()", "// path.rsplit('.')", "run.shows"] {
        assert!(taken_apart(source).is_empty(), "{source}");
    }
}
