//! Edits of files as workspace edits.

use std::collections::HashMap;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::Cancellable;
use dotgen_codegen::codels::edit::Edit;
use dotgen_syntax::encoding::LineEnd;

use crate::protocol::client::ClientCaps;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Answer, Snapshot};

/// An edit for the client. The error is a message for the user.
pub(crate) type EditResult = std::result::Result<WorkspaceEdit, String>;

/// The line end of a file that the client may edit. The error says why it may not: the client would replace
/// bytes that are not UTF-8. An open document is saved with the text that the client read.
fn line_end_of(
    snapshot: &Snapshot,
    path: &Utf8Path,
) -> Cancellable<std::result::Result<LineEnd, String>> {
    let Some(text) = snapshot.analysis.text(path)? else {
        return Ok(Err(format!("{path} cannot be read")));
    };
    if !snapshot.open.contains_key(path) && snapshot.analysis.is_not_utf8(path)? {
        let at = text.find(char::REPLACEMENT_CHARACTER).unwrap_or(0);
        let line = 1 + text[..at].matches('\n').count();
        return Ok(Err(format!(
            "{path} would have to be changed, and line {line} is not UTF-8: the editor would damage it. Save the file \
             as UTF-8, or open it first in the encoding that it has"
        )));
    }
    Ok(Ok(LineEnd::of(&text)))
}

/// New text with the line end of the file. The error reports characters that could not be read.
fn with_line_end(
    line_end: LineEnd,
    text: &str,
    path: &Utf8Path,
) -> std::result::Result<String, String> {
    if text.contains(char::REPLACEMENT_CHARACTER) {
        return Err(format!(
            "the text for {path} has characters that could not be read where they come from: save that file \
                as UTF-8"
        ));
    }
    Ok(line_end.fit(text).into_owned())
}

/// The edits as one workspace edit, without a review by the user.
pub(crate) fn workspace_edit(snapshot: &Snapshot, edits: &[FileEdit]) -> Cancellable<EditResult> {
    edit_of(snapshot, Review::None, &Edit::of(edits))
}

/// The edits of one file.
pub(crate) fn text_edits(
    snapshot: &Snapshot,
    path: &Utf8Path,
    edits: &[FileEdit],
) -> Answer<Option<Vec<TextEdit>>> {
    let lines = snapshot.text_lines(path)?;
    let of_file = edits.iter().filter(|edit| edit.path == path);
    let line_end = LineEnd::of(lines.text());
    let convert = of_file.map(|file| {
        let new_text = line_end.fit(&file.new_text).into_owned();
        TextEdit::new(lines.range(&file.range), new_text)
    });
    Ok(Some(convert.collect()))
}

/// The review of an edit by the user before it is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Review<'a> {
    /// No review: the edit is what the user requested.
    None,
    /// A review under this label if the edit changes several files, in clients that support it.
    SeveralFiles(&'a str),
    /// A review under this label, with a list of places that the edit does not change, although they may have
    /// the same meaning.
    Leaves {
        label: &'a str,
        /// The unchanged places, one a line.
        left: &'a str,
    },
}

/// An edit of specifications and sources, with new files.
pub(crate) fn edit_of(
    snapshot: &Snapshot,
    review: Review<'_>,
    edit: &Edit,
) -> Cancellable<EditResult> {
    let mut changed: Vec<(Uri, Option<i32>, Vec<TextEdit>)> = Vec::new();
    for (path, edits) in &edit.changed {
        let line_end = match line_end_of(snapshot, path)? {
            Ok(line_end) => line_end,
            Err(why) => return Ok(Err(why)),
        };
        let (Some(lines), Some(uri)) = (snapshot.lines(path)?, snapshot.uri(path)) else {
            return Ok(Err(format!("{path} cannot be read")));
        };
        let mut converted = Vec::new();
        for edit in edits {
            match with_line_end(line_end, &edit.text, path) {
                Ok(text) => converted.push(TextEdit::new(lines.range(&edit.range), text)),
                Err(why) => return Ok(Err(why)),
            }
        }
        let version = snapshot.open.get(path).map(|file| file.version);
        changed.push((uri, version, converted));
    }
    let mut created: Vec<(Uri, TextEdit)> = Vec::new();
    for (path, text) in &edit.created {
        let Some(uri) = snapshot.uri(path) else {
            return Ok(Err(format!("{path} has no name that the editor could use")));
        };
        match with_line_end(LineEnd::Lf, text, path) {
            Ok(text) => created.push((uri, TextEdit::new(Range::default(), text))),
            Err(why) => return Ok(Err(why)),
        }
    }
    Ok(Ok(reviewed_edit(&snapshot.client, review, created, changed)))
}

/// The changes as one edit, with a review in clients that support it.
fn reviewed_edit(
    client: &ClientCaps,
    review: Review<'_>,
    created: Vec<(Uri, TextEdit)>,
    changed: Vec<(Uri, Option<i32>, Vec<TextEdit>)>,
) -> WorkspaceEdit {
    if !client.document_changes || !(created.is_empty() || client.creates_files) {
        let created = created.into_iter().map(|(uri, edit)| (uri, vec![edit]));
        let changed = changed.into_iter().map(|(uri, _, edits)| (uri, edits));
        #[allow(clippy::mutable_key_type, reason = "the type of the protocol")]
        let changes: HashMap<_, _> = created.chain(changed).collect();
        return WorkspaceEdit::new(changes);
    }
    let label = match review {
        Review::SeveralFiles(label) if created.len() + changed.len() > 1 => Some(label),
        Review::Leaves { label, .. } => Some(label),
        _ => None,
    };
    let label = label.filter(|_| client.change_annotations);
    let annotation = label.map(|_| REVIEWED.to_owned());
    let document = |uri, version, edits: Vec<TextEdit>| {
        let edits = edits.into_iter().map(|text_edit| match annotation.clone() {
            Some(annotation_id) => OneOf::Right(AnnotatedTextEdit { text_edit, annotation_id }),
            None => OneOf::Left(text_edit),
        });
        DocumentChangeOperation::Edit(TextDocumentEdit {
            text_document: OptionalVersionedTextDocumentIdentifier { uri, version },
            edits: edits.collect(),
        })
    };
    let mut operations = Vec::new();
    for (uri, edit) in created {
        operations.push(DocumentChangeOperation::Op(ResourceOp::Create(CreateFile {
            uri: uri.clone(),
            options: Some(CreateFileOptions {
                overwrite: Some(false),
                ignore_if_exists: Some(false),
            }),
            annotation_id: annotation.clone(),
        })));
        operations.push(document(uri, None, vec![edit]));
    }
    for (uri, version, edits) in changed {
        operations.push(document(uri, version, edits));
    }
    let annotations = label.map(|label| {
        let annotation = ChangeAnnotation {
            label: label.to_owned(),
            needs_confirmation: Some(true),
            description: match review {
                Review::Leaves { left, .. } => Some(format!("To be looked at by hand:\n{left}")),
                _ => None,
            },
        };
        HashMap::from([(REVIEWED.to_owned(), annotation)])
    });
    WorkspaceEdit {
        document_changes: Some(DocumentChanges::Operations(operations)),
        change_annotations: annotations,
        ..WorkspaceEdit::default()
    }
}

/// Name of the annotation for edits with a review.
const REVIEWED: &str = "reviewed";

/// An action with its edit. If the edit is impossible, the action is shown with the reason, in clients that
/// support it.
pub(crate) fn with_edit(
    snapshot: &Snapshot,
    action: CodeAction,
    edit: EditResult,
) -> Option<CodeAction> {
    match edit {
        Ok(edit) => Some(CodeAction { edit: Some(edit), ..action }),
        Err(reason) => snapshot.client.disabled_actions.then(|| CodeAction {
            disabled: Some(CodeActionDisabled { reason }),
            is_preferred: None,
            ..action
        }),
    }
}

/// True if a client wants actions of a kind.
pub(crate) fn is_wanted(params: &CodeActionParams, kind: &CodeActionKind) -> bool {
    let only = params.context.only.as_deref();
    only.is_none_or(|only| {
        only.iter().any(|action_kind| kind.as_str().starts_with(action_kind.as_str()))
    })
}
