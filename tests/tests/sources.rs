//! What the sources of a crate may do: nothing below the server reaches the system by itself.

use std::path::Path;

use dotgen_tests::workspace_root;

/// Crates that do no input or output: they ask a trait.
const PURE: [&str; 10] = [
    "syntax",
    "analysis",
    "diagram",
    "codegen",
    "timing",
    "recording",
    "export",
    "xta",
    "runtime",
    "ros2",
];

/// Words that reach the system.
const SYSTEM_WORDS: [&str; 16] = [
    "std::fs",
    // The ends of pipes and a status are types that a trait may name.
    "process::Command",
    "Command::new(",
    "process::exit",
    "std::net",
    "std::env",
    "use std::{fs",
    "fs::read",
    "fs::write",
    "env::var",
    "env::current_dir",
    "tempfile::",
    "walkdir::",
    ".read_dir(",
    ".canonicalize(",
    "absolute_utf8(",
];

/// Looks for the Tcl interpreter in the environment, which no trait gives yet.
const ENVIRONMENT: &str = "codegen/src/template/host.rs";

/// The code of a file without its tests: `#[cfg(test)]` ends a file here, but for modules of their own.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut tests = false;
    text.lines().enumerate().filter(move |(_, line)| {
        tests |= line.trim_start().starts_with("#[cfg(test)]");
        let module =
            tests && line.trim_start().starts_with("mod ") && line.trim_end().ends_with(';');
        let skip = tests;
        tests &= !module;
        !skip && !line.trim_start().starts_with("//")
    })
}

/// Whether a file is compiled for tests alone: its module says so, or that around it.
fn is_test(path: &Path) -> bool {
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    path.ancestors().any(|ancestor| matches!(name(ancestor).as_str(), "tests" | "fixture"))
        // Writes the typed tree, in a test.
        || path.ends_with("ast/generator.rs")
}

#[test]
fn nothing_below_the_server_reaches_the_system() {
    let mut found = Vec::new();
    let mut files = 0;
    for folder in PURE {
        let source = workspace_root().join(folder).join("src");
        for entry in walkdir::WalkDir::new(&source).into_iter().flatten() {
            let path = entry.path();
            let shown = path.strip_prefix(workspace_root()).unwrap_or(path);
            if path.extension().is_none_or(|extension| extension != "rs") || is_test(shown) {
                continue;
            }
            files += 1;
            let text = std::fs::read_to_string(path).expect("a source");
            for (line, text) in code(&text) {
                let word = SYSTEM_WORDS.iter().find(|word| text.contains(**word));
                let allowed = shown == Path::new(ENVIRONMENT) && text.contains("env::");
                if let Some(word) = word.filter(|_| !allowed) {
                    found.push(format!("{}:{}: {word}", shown.display(), line + 1));
                }
            }
        }
    }
    assert!(files > 300, "the sources are found: {files}");
    assert_eq!(found, Vec::<String>::new(), "see docs/architecture.md: files come by a trait");
}

/// Columns of a line of prose.
const COLUMNS: usize = 110;

/// Comments in Rust and paragraphs in Markdown are read beside other text. Tables, examples and pictures are
/// as wide as they are; pages of diagnostics are made from texts.
#[test]
fn lines_of_prose_have_at_most_110_columns() {
    let mut wide = Vec::new();
    let of_project = |entry: &walkdir::DirEntry| {
        let name = entry.file_name().to_string_lossy();
        // The extension's copy of the manual is made when it is packaged.
        !matches!(&*name, "target" | "node_modules" | "dist" | "diagnostics")
            && !entry.path().ends_with("vscode-extension/docs")
            && (entry.depth() == 0 || !name.starts_with('.'))
    };
    let all = walkdir::WalkDir::new(workspace_root()).sort_by_file_name();
    for entry in all.into_iter().filter_entry(of_project).flatten() {
        let path = entry.path();
        let is_prose = match path.extension().and_then(|extension| extension.to_str()) {
            Some("rs") => |line: &str| line.starts_with("//") && !line.starts_with("//! |"),
            Some("md") => |line: &str| !line.starts_with(['|', '!']),
            _ => continue,
        };
        let Ok(text) = std::fs::read_to_string(path) else {
            continue;
        };
        let mut example = false;
        for (number, line) in text.lines().enumerate() {
            let content = line.trim_start();
            example ^= content.starts_with("```");
            if !example && is_prose(content) && line.chars().count() > COLUMNS {
                wide.push(format!("{}:{}", path.display(), number + 1));
            }
        }
    }
    assert!(wide.is_empty(), "wider than {COLUMNS} columns: {wide:#?}");
}
