//! Stand-ins for missing files, as files to be written.

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
use crate::features::codels::judged_actions::JudgedActions;
use crate::features::convert::diagnostic;
use crate::protocol::convert::position::touches;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

/// The files of stand-ins that do not exist yet, and the `.gitignore` that keeps them out of the sources.
pub fn changes(specification: &Utf8Path, stand_ins: &[StandIn]) -> Vec<FileChange> {
    let new = |path: &Utf8Path, text: &str| {
        let there = Disk.read(path).is_some();
        (!there).then(|| FileChange { path: path.to_owned(), before: None, after: text.to_owned() })
    };
    let mut out: Vec<FileChange> =
        stand_ins.iter().filter_map(|stand_in| new(&stand_in.path, &stand_in.text)).collect();
    if !out.is_empty() {
        let beside = specification.parent().unwrap_or(Utf8Path::new(""));
        out.extend(new(&beside.join(FOLDER).join(".gitignore"), IGNORED));
    }
    out
}

/// "Write a stand-in for…": at a missing package, one for each file that the package may contain; at an
/// include of a missing file, one for that file.
pub(crate) fn actions(
    snapshot: &Snapshot,
    subject: &Subject,
    found: &[Diagnostic],
    range: &Range<usize>,
    offers: &mut JudgedActions<'_, '_, '_>,
) -> Cancellable<Vec<CodeActionOrCommand>> {
    let cause =
        found.iter().find(|finding| is_environment(finding.code) && touches(&finding.range, range));
    let missing = snapshot.analysis.missing_includes(&subject.path)?;
    let mut missing = missing.iter().map(|include| &include.range);
    // An include that depends on a missing package has no finding of its own.
    if cause.is_none() && !missing.any(|other| touches(other, range)) {
        return Ok(Vec::new());
    }
    let root = snapshot.analysis.root_of(&subject.path)?;
    let all = snapshot.analysis.stand_ins(&root)?;
    // At an include: the stand-in for that file. At a package: every stand-in.
    let at = |input: &&StandIn| input.by == subject.path && touches(&input.at, range);
    let only_here = all.iter().any(|stand_in| at(&stand_in));
    let mut out = Vec::new();
    for stand_in in all.iter().filter(|stand_in| !only_here || at(stand_in)) {
        let title = format!("Write a stand-in for `{}`", stand_in.include);
        let mut edit = Edit::default();
        for change in changes(&root, std::slice::from_ref(stand_in)) {
            edit.created.insert(change.path, change.after);
        }
        if edit.created.is_empty() {
            continue;
        }
        // At a package the finding remains: a stand-in replaces a file, not the package.
        let mended = cause.filter(|_| only_here);
        let shown = match mended {
            Some(cause) => diagnostic::to_proto(snapshot, cause)?,
            None => None,
        };
        let action = CodeAction {
            title,
            kind: Some(CodeActionKind::QUICKFIX),
            diagnostics: shown.map(|proto| vec![proto]),
            ..CodeAction::default()
        };
        out.extend(offers.action(action, &edit, mended.map(|cause| cause.code))?);
    }
    Ok(out)
}
