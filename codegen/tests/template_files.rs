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
    let files = files.filter_map(|file| Utf8PathBuf::from_path_buf(file.into_path()).ok());
    let read = |path: &Utf8Path| -> Option<String> { std::fs::read_to_string(path).ok() };
    let mut out = Vec::new();
    for file in files {
        let home = file.ancestors().find(|ancestor| ancestor.join(SCRIPT).is_file());
        let (Some(text), Some(home)) = (read(&file), home) else {
            continue;
        };
        let main = read(&home.join(SCRIPT)).unwrap_or_default();
        let required = files::required(home, &main);
        let mut scripts = vec![main];
        scripts.extend(required.iter().filter_map(|path| read(path)));
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
    let shared = dotgen_loaders::optional("golden/templates");
    let more = std::env::var("DOTGEN_TEST_TEMPLATES").unwrap_or_default();
    let directories: Vec<_> = shared
        .iter()
        .filter_map(|folder| folder.to_str())
        .chain(more.split(':'))
        .filter(|text| Path::new(text).is_dir())
        .collect();
    for directory in directories {
        let all = findings(directory.into());
        assert!(!all.is_empty(), "no template below {directory}");
        for (file, found) in all {
            let errors = found.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
            let messages: Vec<_> = errors
                .map(|error| format!("{file}:{}: {}", error.range.start, error.message))
                .collect();
            // Recorded for the errors of the engine.
            let fails = ["badtag", "mixed", "unclosed", "unopened"].iter();
            let fails =
                fails.into_iter().any(|text| file.as_str().contains(&format!("/failing/{text}/")));
            assert_eq!(
                fails && file.file_name() != Some(SCRIPT),
                !messages.is_empty(),
                "{file} {messages:#?}"
            );
        }
    }
}
