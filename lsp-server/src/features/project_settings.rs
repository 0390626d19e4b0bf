//! Edits of the `dotgen.toml` of a document.

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::{Diagnostic, Severity};
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::is_about_comment;
use dotgen_codegen::codels::edit::{Edit, line_edits};
use toml_edit::{DocumentMut, InlineTable, Item, Table, Value, value};

use crate::config;
use crate::features::convert::diagnostic;
use crate::features::convert::edit::{Review, edit_of, with_edit};
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

/// The path of the configuration for a document, which need not exist.
pub(crate) fn project(snapshot: &Snapshot, path: &Utf8Path) -> Option<Utf8PathBuf> {
    if let Some(project) = snapshot.config.project(path) {
        return Some(project.directory.clone());
    }
    let around = snapshot.folders.iter().filter(|folder| path.starts_with(folder));
    around.max_by_key(|folder| folder.as_str().len()).cloned()
}

/// The changed configuration of a directory, created if it does not exist. `None` if it cannot be read, or
/// the change is impossible or already made.
pub(crate) fn edit(
    snapshot: &Snapshot,
    project: &Utf8Path,
    change: impl Fn(&mut DocumentMut) -> Option<()>,
) -> Cancellable<Option<Edit>> {
    let path = project.join(config::FILE_NAME);
    let mut edit = Edit::default();
    // The text that the client edits: an open document may differ from its file.
    let before = snapshot.analysis.text(&path)?;
    let Some(after) = changed(before.as_deref().unwrap_or_default(), change) else {
        return Ok(None);
    };
    match before {
        Some(before) => {
            for line_edit in line_edits(&before, &after) {
                edit.replace(&path, line_edit.range, line_edit.text);
            }
        }
        None if path.symlink_metadata().is_ok() => return Ok(None),
        None => {
            edit.created.insert(path, after);
        }
    }
    Ok(Some(edit))
}

/// The directory of the configuration that sets the severity of a code, or can set it, for a document.
/// Severities apply to the whole workspace, and those of the earlier folder count.
fn setting_severity(
    snapshot: &Snapshot,
    path: &Utf8Path,
    code: &str,
) -> Cancellable<Option<Utf8PathBuf>> {
    for folder in snapshot.folders.iter() {
        let text = snapshot.analysis.text(&folder.join(config::FILE_NAME))?;
        let document = text.and_then(|text| text.parse::<DocumentMut>().ok());
        let severity = document.as_ref().and_then(|document| document.get("severity"));
        if severity.is_some_and(|severity| severity.get(code).is_some()) {
            return Ok(Some(folder.clone()));
        }
    }
    let around = snapshot.folders.iter().filter(|folder| path.starts_with(folder));
    let around = around.max_by_key(|folder| folder.as_str().len()).cloned();
    Ok(around.or_else(|| project(snapshot, path)))
}

/// The text of a configuration after a change. All other text, comments included, is unchanged.
pub(super) fn changed(
    text: &str,
    change: impl Fn(&mut DocumentMut) -> Option<()>,
) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    change(&mut document)?;
    Some(document.to_string())
}

/// Adds the action that switches the code of a finding off in the workspace, unless the finding is an error.
pub(crate) fn allow(
    snapshot: &Snapshot,
    subject: &Subject,
    finding: &Diagnostic,
    out: &mut Vec<CodeActionOrCommand>,
) -> Cancellable<()> {
    if finding.severity == Severity::Error || is_about_comment(finding.code) {
        return Ok(());
    }
    let title = format!("Allow `{}` in this workspace, in {}", finding.code, config::FILE_NAME);
    let is_same = |action: &CodeActionOrCommand| match action {
        CodeActionOrCommand::CodeAction(action) => action.title == title,
        CodeActionOrCommand::Command(_) => false,
    };
    if out.iter().any(is_same) {
        return Ok(());
    }
    let Some(project) = setting_severity(snapshot, &subject.path, finding.code)? else {
        return Ok(());
    };
    let Some(edit) = edit(snapshot, &project, |document| switch_off(document, finding.code))?
    else {
        return Ok(());
    };
    let action = CodeAction {
        title,
        kind: Some(CodeActionKind::QUICKFIX),
        diagnostics: diagnostic::to_proto(snapshot, finding)?.map(|finding| vec![finding]),
        is_preferred: Some(false),
        ..CodeAction::default()
    };
    let edit = edit_of(snapshot, Review::None, &edit)?;
    out.extend(with_edit(snapshot, action, edit).map(CodeActionOrCommand::CodeAction));
    Ok(())
}

/// Sets the severity of a code to `off`. Returns `None` if it is off, or if `severity` is not a table.
fn switch_off(document: &mut DocumentMut, code: &str) -> Option<()> {
    let severity = document.entry("severity").or_insert_with(|| Item::Table(Table::new()));
    match severity.as_table_like_mut()?.get_mut(code) {
        None => {
            severity[code] = value("off");
            // The blank before the brace would stay before the comma.
            severity.as_inline_table_mut().map(InlineTable::fmt);
        }
        Some(known) => {
            let known = known.as_value_mut().filter(|known| known.as_str() != Some("off"))?;
            // The comment after the value stays.
            let around = known.decor().clone();
            *known = Value::from("off");
            *known.decor_mut() = around;
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_switched_off_and_the_rest_stays() {
        for (before, after) in [
            ("", "[severity]\n\"fsm/a\" = \"off\"\n"),
            (
                "# ours\nrelease = \"3\"\n",
                "# ours\nrelease = \"3\"\n\n[severity]\n\"fsm/a\" = \"off\"\n",
            ),
            (
                "[severity] # by code\nb = \"hint\" # b\n\n[codels]\ncheck = false\n",
                "[severity] # by code\nb = \"hint\" # b\n\"fsm/a\" = \"off\"\n\n[codels]\ncheck = false\n",
            ),
            (
                "[severity]\n\"fsm/a\" = \"error\" # for now\nb = \"hint\"\n",
                "[severity]\n\"fsm/a\" = \"off\" # for now\nb = \"hint\"\n",
            ),
            ("severity = { b = \"hint\" }\n", "severity = { b = \"hint\", \"fsm/a\" = \"off\" }\n"),
        ] {
            let off = |document: &mut DocumentMut| switch_off(document, "fsm/a");
            assert_eq!(changed(before, off).as_deref(), Some(after));
            assert_eq!(changed(after, off), None, "it is off");
        }
        assert_eq!(changed("severity = 1\n", |document| switch_off(document, "a")), None);
        assert_eq!(changed("= no toml", |document| switch_off(document, "a")), None);
    }
}
