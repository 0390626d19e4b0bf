//! Edits of files as workspace edits.

use std::collections::HashMap;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_analysis::host::Cancellable;
use dotgen_codegen::codels::edit::Edit;
use dotgen_syntax::encoding::LineEnd;

use crate::proto::*;
use crate::snapshot::Snapshot;

/// An edit for the client, or why there is none: a message for the user.
pub type Edited = std::result::Result<WorkspaceEdit, String>;

/// What a client may do to a file, or why it may not: it would write its own idea of bytes that are no UTF-8.
/// An open document is written as the client read it. The line end of the file.
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

/// New text as the file wants it. Characters that could not be read are not passed on.
fn fitted(line_end: LineEnd, text: &str, path: &Utf8Path) -> std::result::Result<String, String> {
    if text.contains(char::REPLACEMENT_CHARACTER) {
        return Err(format!(
            "the text for {path} has characters that could not be read where they come from: save that file as UTF-8"
        ));
    }
    Ok(line_end.fit(text).into_owned())
}

/// As one workspace edit.
pub fn workspace_edit(snapshot: &Snapshot, edits: &[FileEdit]) -> Cancellable<Edited> {
    let mut by_file: Vec<(Uri, Option<i32>, Vec<TextEdit>)> = Vec::new();
    for FileEdit {
        path,
        range,
        new_text,
    } in edits
    {
        let new_text = match line_end_of(snapshot, path)?.and_then(|it| fitted(it, new_text, path))
        {
            Ok(new_text) => new_text,
            Err(why) => return Ok(Err(why)),
        };
        let Some(location) = snapshot.location(path, range)? else {
            return Ok(Err(format!("{path} cannot be read")));
        };
        let edit = TextEdit::new(location.range, new_text);
        match by_file.iter_mut().find(|it| it.0 == location.uri) {
            Some(file) => file.2.push(edit),
            None => {
                let version = snapshot.open.get(path).map(|it| it.version);
                by_file.push((location.uri, version, vec![edit]));
            }
        }
    }
    if !snapshot.client.document_changes {
        #[allow(clippy::mutable_key_type, reason = "the type of the protocol")]
        let changes: HashMap<_, _> = by_file.into_iter().map(|it| (it.0, it.2)).collect();
        return Ok(Ok(WorkspaceEdit::new(changes)));
    }
    let changes = by_file
        .into_iter()
        .map(|(uri, version, edits)| TextDocumentEdit {
            text_document: OptionalVersionedTextDocumentIdentifier { uri, version },
            edits: edits.into_iter().map(OneOf::Left).collect(),
        });
    Ok(Ok(WorkspaceEdit {
        document_changes: Some(DocumentChanges::Edits(changes.collect())),
        ..WorkspaceEdit::default()
    }))
}

/// The edits of one file.
pub fn text_edits(
    snapshot: &Snapshot,
    path: &Utf8Path,
    edits: &[FileEdit],
) -> Cancellable<Option<Vec<TextEdit>>> {
    let Some(lines) = snapshot.lines(path)? else {
        return Ok(None);
    };
    let of_file = edits.iter().filter(|it| it.path == path);
    let line_end = LineEnd::of(lines.text());
    let convert = of_file.map(|it| {
        let new_text = line_end.fit(&it.new_text).into_owned();
        TextEdit::new(lines.range(&it.range), new_text)
    });
    Ok(Some(convert.collect()))
}

/// An edit of specifications and sources, with new files. Where sources are touched, clients that
/// can show every change before it is made, if they can.
pub fn annotated_edit(snapshot: &Snapshot, label: &str, edit: &Edit) -> Cancellable<Edited> {
    let mut changed: Vec<(Uri, Option<i32>, bool, Vec<TextEdit>)> = Vec::new();
    for (path, edits) in &edit.changed {
        let line_end = match line_end_of(snapshot, path)? {
            Ok(line_end) => line_end,
            Err(why) => return Ok(Err(why)),
        };
        let (Some(lines), Some(uri)) = (snapshot.lines(path)?, snapshot.uri(path)) else {
            return Ok(Err(format!("{path} cannot be read")));
        };
        let mut converted = Vec::new();
        for it in edits {
            match fitted(line_end, &it.text, path) {
                Ok(text) => converted.push(TextEdit::new(lines.range(&it.range), text)),
                Err(why) => return Ok(Err(why)),
            }
        }
        let version = snapshot.open.get(path).map(|it| it.version);
        let is_code = snapshot.is_code(path);
        changed.push((uri, version, is_code, converted));
    }
    let mut created: Vec<(Uri, TextEdit)> = Vec::new();
    for (path, text) in &edit.created {
        let Some(uri) = snapshot.uri(path) else {
            return Ok(Err(format!("{path} has no name that the editor could use")));
        };
        match fitted(LineEnd::Lf, text, path) {
            Ok(text) => created.push((uri, TextEdit::new(Range::default(), text))),
            Err(why) => return Ok(Err(why)),
        }
    }
    let client = &snapshot.client;
    if !client.document_changes || !(created.is_empty() || client.creates_files) {
        let created = created.into_iter().map(|it| (it.0, vec![it.1]));
        let changed = changed.into_iter().map(|it| (it.0, it.3));
        #[allow(clippy::mutable_key_type, reason = "the type of the protocol")]
        let changes: HashMap<_, _> = created.chain(changed).collect();
        return Ok(Ok(WorkspaceEdit::new(changes)));
    }
    let touches_code = !created.is_empty() || changed.iter().any(|it| it.2);
    let annotate = client.change_annotations && touches_code;
    let annotation = |is_code| annotate.then(|| annotation_of(is_code).to_owned());
    let document = |uri, version, is_code, edits: Vec<TextEdit>| {
        let edits = edits
            .into_iter()
            .map(|text_edit| match annotation(is_code) {
                Some(annotation_id) => OneOf::Right(AnnotatedTextEdit {
                    text_edit,
                    annotation_id,
                }),
                None => OneOf::Left(text_edit),
            });
        DocumentChangeOperation::Edit(TextDocumentEdit {
            text_document: OptionalVersionedTextDocumentIdentifier { uri, version },
            edits: edits.collect(),
        })
    };
    let mut operations = Vec::new();
    for (uri, edit) in created {
        operations.push(DocumentChangeOperation::Op(ResourceOp::Create(
            CreateFile {
                uri: uri.clone(),
                options: Some(CreateFileOptions {
                    overwrite: Some(false),
                    ignore_if_exists: Some(false),
                }),
                annotation_id: annotation(true),
            },
        )));
        operations.push(document(uri, None, true, vec![edit]));
    }
    for (uri, version, is_code, edits) in changed {
        operations.push(document(uri, version, is_code, edits));
    }
    let annotations = annotate.then(|| {
        let annotation = |is_code| ChangeAnnotation {
            label: label.to_owned(),
            needs_confirmation: Some(is_code),
            description: None,
        };
        let both = [true, false].map(|it| (annotation_of(it).to_owned(), annotation(it)));
        HashMap::from(both)
    });
    Ok(Ok(WorkspaceEdit {
        document_changes: Some(DocumentChanges::Operations(operations)),
        change_annotations: annotations,
        ..WorkspaceEdit::default()
    }))
}

/// Edits of sources are confirmed; those of specifications go with them.
fn annotation_of(is_code: bool) -> &'static str {
    match is_code {
        true => "codels",
        false => "specification",
    }
}
