//! Fixes for an included file that is not found: the settings search its directory.

use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Cancellable, FileContent};
use dotgen_codegen::codels::edit::{Edit, line_edits};
use toml_edit::{Array, DocumentMut, value};

use crate::config;
use crate::features::convert::edit::{Review, edit_of, with_edit};
use crate::files::vfs;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Directories that are offered.
const MOST_DIRECTORIES: usize = 3;

/// For every included file that is not found in a range: the directories of the project in which it is.
pub(crate) fn fixes(
    snapshot: &Snapshot,
    subject: &Subject,
    range: &Range<usize>,
    out: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    let missing = snapshot.analysis.missing_includes(&subject.path)?;
    let here = missing
        .into_iter()
        .filter(|it| it.range.start <= range.end && range.start <= it.range.end);
    for it in here {
        let Some(project) = project(snapshot, &subject.path) else {
            continue;
        };
        for directory in directories(&project, Utf8Path::new(&it.path)) {
            let Some(edit) = edit(&project, &directory) else {
                continue;
            };
            let name = if directory.as_str().is_empty() {
                "."
            } else {
                directory.as_str()
            };
            let action = CodeAction {
                title: format!(
                    "Search `{name}` for included files, in {}",
                    config::FILE_NAME
                ),
                kind: Some(CodeActionKind::QUICKFIX),
                ..CodeAction::default()
            };
            let edit = edit_of(snapshot, Review::None, &edit)?;
            out.extend(with_edit(snapshot, action, edit).map(CodeActionOrCommand::CodeAction));
        }
    }
    Ok(())
}

/// Where the configuration of a document is, or would be.
fn project(snapshot: &Snapshot, path: &Utf8Path) -> Option<Utf8PathBuf> {
    if let Some(project) = snapshot.config.project(path) {
        return Some(project.directory.clone());
    }
    let around = snapshot.folders.iter().filter(|it| path.starts_with(it));
    around.max_by_key(|it| it.as_str().len()).cloned()
}

/// The directories below a folder in which a file is, relative to the folder.
fn directories(folder: &Utf8Path, wanted: &Utf8Path) -> Vec<Utf8PathBuf> {
    let Some(extension) = wanted.extension() else {
        return Vec::new();
    };
    let all = vfs::files_below(folder, &[extension]).into_iter();
    let found = all.filter(|it| it.ends_with(wanted));
    let directory = |it: Utf8PathBuf| {
        let up = it.ancestors().nth(wanted.components().count())?;
        Some(up.strip_prefix(folder).ok()?.to_owned())
    };
    found.filter_map(directory).take(MOST_DIRECTORIES).collect()
}

/// The configuration with one more directory; `None` if it cannot be edited, or has it already.
fn edit(project: &Utf8Path, directory: &Utf8Path) -> Option<Edit> {
    let path = project.join(config::FILE_NAME);
    let mut edit = Edit::default();
    match vfs::read(&path) {
        FileContent::Text(before) => {
            let after = with_directory(&before, directory)?;
            for it in line_edits(&before, &after) {
                edit.replace(&path, it.range, it.text);
            }
        }
        _ if path.exists() => return None,
        _ => {
            edit.created.insert(path, with_directory("", directory)?);
        }
    }
    Some(edit)
}

/// The text of a configuration with one more directory in `include-paths`. Everything else stays, comments too.
fn with_directory(text: &str, directory: &Utf8Path) -> Option<String> {
    let directory = match directory.as_str() {
        "" => ".".to_owned(),
        other => other.replace('\\', "/"),
    };
    let mut document: DocumentMut = text.parse().ok()?;
    let entry = document
        .entry("include-paths")
        .or_insert_with(|| value(Array::new()));
    let paths = entry.as_value_mut().and_then(|it| it.as_array_mut())?;
    if paths.iter().any(|it| it.as_str() == Some(&directory)) {
        return None;
    }
    paths.push(directory);
    Some(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_added_and_the_rest_stays() {
        for (before, after) in [
            ("", "include-paths = [\"idl\"]\n"),
            (
                "# ours\ninclude-paths = [\"a\"] # here\n[codels]\ncheck = false\n",
                "# ours\ninclude-paths = [\"a\", \"idl\"] # here\n[codels]\ncheck = false\n",
            ),
            (
                "release = \"2.99.41\"\n",
                "release = \"2.99.41\"\ninclude-paths = [\"idl\"]\n",
            ),
        ] {
            assert_eq!(
                with_directory(before, Utf8Path::new("idl")).as_deref(),
                Some(after)
            );
            assert_eq!(
                with_directory(after, Utf8Path::new("idl")),
                None,
                "it is there"
            );
        }
        assert_eq!(
            with_directory("include-paths = 1\n", Utf8Path::new("idl")),
            None
        );
        assert_eq!(with_directory("= no toml", Utf8Path::new("idl")), None);
    }
}
