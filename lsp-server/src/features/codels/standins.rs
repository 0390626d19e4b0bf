//! Stand-ins for files that are not found, as files to be written.

use std::ops::Range;

use camino::Utf8Path;
use dotgen_analysis::codes::is_environment;
use dotgen_analysis::deps::standin::StandIn;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::Cancellable;
use dotgen_codegen::codels::command::FileChange;
use dotgen_codegen::codels::edit::Edit;
use dotgen_codegen::codels::files::Files as _;

use super::headers::{FOLDER, IGNORED};
use crate::features::codels::Disk;
use crate::features::convert::diagnostic;
use crate::features::convert::edit::{Review, edit_of, with_edit};
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

/// The files of stand-ins that do not exist yet, and the `.gitignore` that keeps them out of the sources.
pub(crate) fn changes(specification: &Utf8Path, stand_ins: &[StandIn]) -> Vec<FileChange> {
    let new = |path: &Utf8Path, text: &str| {
        let there = Disk.read(path).is_some();
        (!there).then(|| FileChange {
            path: path.to_owned(),
            before: None,
            after: text.to_owned(),
        })
    };
    let mut out: Vec<FileChange> = stand_ins
        .iter()
        .filter_map(|it| new(&it.path, &it.text))
        .collect();
    if !out.is_empty() {
        let beside = specification.parent().unwrap_or(Utf8Path::new(""));
        out.extend(new(&beside.join(FOLDER).join(".gitignore"), IGNORED));
    }
    out
}

/// "Write a stand-in for…" at a finding that says that files or packages are not there: one for each file.
pub(crate) fn actions(
    snapshot: &Snapshot,
    subject: &Subject,
    found: &[Diagnostic],
    range: &Range<usize>,
) -> Cancellable<Vec<CodeActionOrCommand>> {
    let touches = |it: &&Diagnostic| it.range.start <= range.end && range.start <= it.range.end;
    let mut here = found
        .iter()
        .filter(|it| is_environment(it.code))
        .filter(touches);
    let Some(cause) = here.next() else {
        return Ok(Vec::new());
    };
    let root = snapshot.analysis.root_of(&subject.path)?;
    let all = snapshot.analysis.stand_ins(&root)?;
    // At an include: for that file. At a package: for all that it may bring.
    let at = |it: &&StandIn| {
        it.by == subject.path && it.at.start <= range.end && range.start <= it.at.end
    };
    let only_here = all.iter().any(|it| at(&it));
    let mut out = Vec::new();
    for it in all.iter().filter(|it| !only_here || at(it)) {
        let title = format!("Write a stand-in for `{}`", it.include);
        let mut edit = Edit::default();
        for change in changes(&root, std::slice::from_ref(it)) {
            edit.created.insert(change.path, change.after);
        }
        if edit.created.is_empty() {
            continue;
        }
        let action = CodeAction {
            title: title.clone(),
            kind: Some(CodeActionKind::QUICKFIX),
            diagnostics: diagnostic::to_proto(snapshot, cause)?.map(|it| vec![it]),
            ..CodeAction::default()
        };
        let edit = edit_of(snapshot, Review::None, &edit)?;
        let action = with_edit(snapshot, action, edit);
        out.extend(action.map(CodeActionOrCommand::CodeAction));
    }
    Ok(out)
}
