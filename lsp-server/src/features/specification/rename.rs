//! `textDocument/prepareRename`, `textDocument/rename` and `workspace/willRenameFiles`

use camino::Utf8PathBuf;
use dotgen_analysis::host::Cancellable;
use dotgen_analysis::ide::FilePosition;
use dotgen_codegen::codels::edit::Edit;
use dotgen_codegen::codels::rename::listed;

use crate::features::codels::navigation;
use crate::features::convert::edit::{Review, edit_of, workspace_edit};
use crate::features::{mentions, rules};
use crate::protocol::convert::uri;
use crate::protocol::types::*;
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};
use dotgen_platform::files::vfs;

/// Maximum number of listed places that the user has to check; the message counts the others.
const MAX_LISTED: usize = 20;

pub(crate) fn prepare(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &TextDocumentPositionParams,
) -> Answer<UserResult<PrepareRenameResponse>> {
    let at = snapshot.at(subject, params.position)?;
    let found = match snapshot.analysis.prepare_rename(&at)? {
        Ok(found) => found,
        Err(error) => return Ok(UserResult(Err(error.0))),
    };
    let location = snapshot.location(&at.path, &found.range)?;
    Ok(UserResult(Ok(location.map(|location| PrepareRenameResponse::RangeWithPlaceholder {
        range: location.range,
        placeholder: found.info,
    }))))
}

pub(crate) fn rename(
    snapshot: &Snapshot,
    subject: &Subject,
    params: &RenameParams,
) -> Answer<UserResult<WorkspaceEdit>> {
    let position = params.text_document_position.position;
    let at = snapshot.at(subject, position)?;
    Ok(rename_at(snapshot, &at, &params.new_name)?)
}

/// Renames the declaration at a place of a specification. The place is the declaration or one of its
/// mentions.
pub(crate) fn rename_at(
    snapshot: &Snapshot,
    at: &FilePosition,
    new_name: &str,
) -> Cancellable<UserResult<WorkspaceEdit>> {
    let mut edits = match snapshot.analysis.rename(at, new_name, &snapshot.progress)? {
        Ok(edits) => edits,
        Err(error) => return Ok(UserResult(Err(error.0))),
    };
    let specifications = edits.clone();
    edits.extend(mentions::renames(snapshot, at, new_name)?);
    let rules = rules::renames(snapshot, &specifications, new_name)?;
    edits.extend(rules.edits);
    // Headers of installed packages must not be edited.
    let foreign = edits.iter().find(|edit| {
        let path = &edit.path;
        vfs::is_own_interface(path)
            || !snapshot.folders.is_empty()
                && !snapshot.in_workspace(path)
                && !snapshot.open.contains_key(path)
    });
    if let Some(foreign) = foreign {
        return Ok(UserResult(Err(format!(
            "The name is also written in {}, which is not in the workspace",
            foreign.path
        ))));
    }
    let sources = match navigation::rename(snapshot, &specifications)? {
        Ok(sources) => sources,
        Err(why) => return Ok(UserResult(Err(why))),
    };
    let mut all = Edit::of(&edits);
    for (path, edits) in sources.edit.changed {
        for edit in edits {
            all.replace(&path, edit.range, edit.text);
        }
    }
    let label = format!("Rename to {new_name}");
    let mut folders = snapshot.folders.iter().filter(|folder| at.path.starts_with(folder));
    let folder = folders.next().cloned().unwrap_or_default();
    let mut left = rules.left;
    left.extend(sources.left);
    let left = listed(&left, MAX_LISTED, &folder);
    let review = if left.is_empty() {
        Review::SeveralFiles(&label)
    } else {
        Review::Leaves { label: &label, left: &left }
    };
    Ok(UserResult(edit_of(snapshot, review, &all)?.map(Some)))
}

/// The edits of includes, and of `use` in scenarios, for moved files.
pub(crate) fn files(
    snapshot: &Snapshot,
    params: &RenameFilesParams,
) -> Cancellable<UserResult<WorkspaceEdit>> {
    let path = |text: &str| -> Option<Utf8PathBuf> { Some(uri::to_path(&text.parse().ok()?)) };
    let moves = params.files.iter();
    let moves: Vec<_> = moves
        .filter_map(|movement| Some((path(&movement.old_uri)?, path(&movement.new_uri)?)))
        .collect();
    let mut edits = snapshot.analysis.files_moved(&moves)?;
    edits.extend(rules::uses_moved(snapshot, &moves)?);
    if edits.is_empty() {
        Ok(UserResult::default())
    } else {
        Ok(UserResult(workspace_edit(snapshot, &edits)?.map(Some)))
    }
}
