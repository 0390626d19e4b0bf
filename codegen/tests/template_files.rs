//! Templates that run have no diagnostics.
//!
//! Templates of other projects are not part of this repository: `golden/templates` of the shared test data,
//! and the directories that `DOTGEN_TEST_TEMPLATES` names (separated by colons).

use std::path::Path;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_codegen::template::check;
use dotgen_codegen::template::files::{self, Role, SCRIPT};

/// Every file below a directory with its diagnostics, if it belongs to a template.
fn findings(directory: &Utf8Path) -> Vec<(Utf8PathBuf, Vec<Diagnostic>)> {
    let files = walkdir::WalkDir::new(directory).into_iter().flatten();
    let files = files.filter_map(|it| Utf8PathBuf::from_path_buf(it.into_path()).ok());
    let read = |it: &Utf8Path| -> Option<String> { std::fs::read_to_string(it).ok() };
    let mut out = Vec::new();
    for file in files {
        let home = file.ancestors().find(|it| it.join(SCRIPT).is_file());
        let (Some(text), Some(home)) = (read(&file), home) else {
            continue;
        };
        let main = read(&home.join(SCRIPT)).unwrap_or_default();
        let required = files::required(home, &main);
        let mut scripts = vec![main];
        scripts.extend(required.iter().filter_map(|it| read(it)));
        let found = match files::role(&file, &text, scripts.iter().map(String::as_str)) {
            Some(Role::Script) => check::script(&file, &text),
            Some(Role::Source) => check::source(&file, &text),
            None => continue,
        };
        out.push((file, found));
    }
    out.sort_by(|a, b| a.0.cmp(&b.0));
    out
}

#[test]
fn templates_that_run_have_no_errors() {
    let shared = dotgen_loaders::shared("golden/templates");
    let more = std::env::var("DOTGEN_TEST_TEMPLATES").unwrap_or_default();
    let directories: Vec<_> = shared
        .iter()
        .filter_map(|folder| folder.to_str())
        .chain(more.split(':'))
        .filter(|it| Path::new(it).is_dir())
        .collect();
    for directory in directories {
        let all = findings(directory.into());
        assert!(!all.is_empty(), "no template below {directory}");
        for (file, found) in all {
            let errors = found.iter().filter(|it| it.severity == Severity::Error);
            let messages: Vec<_> = errors
                .map(|it| format!("{file}:{}: {}", it.range.start, it.message))
                .collect();
            // Recorded for the errors of the engine.
            let fails = ["badtag", "mixed", "unclosed", "unopened"].iter();
            let fails = fails
                .into_iter()
                .any(|it| file.as_str().contains(&format!("/failing/{it}/")));
            assert_eq!(
                fails && file.file_name() != Some(SCRIPT),
                !messages.is_empty(),
                "{file} {messages:#?}"
            );
        }
    }
}
