//! Generated files as a workspace edit.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use camino::Utf8Path;
use dotgen_codegen::codels::edit::line_edits;
use dotgen_codegen::template::{Concern, PreviewFile};

use crate::protocol::convert::{Encoding, Lines, uri};
use crate::protocol::types::*;

/// A new or changed file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FileChange {
    pub(crate) uri: Uri,
    /// The present text; `None` for a new file.
    pub(crate) before: Option<String>,
    pub(crate) after: String,
    /// Unix permissions, if the template sets any.
    pub(crate) mode: Option<u32>,
    /// A warning for the user: the file is hidden, or becomes executable.
    pub(crate) concern: Option<Concern>,
}

/// The files that a run would change.
///
/// # Errors
/// A file whose text is not UTF-8 and therefore cannot be edited.
pub(crate) fn changes<'a>(
    files: impl IntoIterator<Item = (&'a std::path::PathBuf, &'a PreviewFile)>,
) -> std::result::Result<Vec<FileChange>, String> {
    let mut all = Vec::new();
    for (path, file) in files {
        if file.before.as_ref() == Some(&file.after) {
            continue;
        }
        let bad = |what: &str| format!("{}: {what} is not UTF-8 text", path.display());
        let line = file.before.as_deref().and_then(not_utf8);
        let old = match line {
            Some(line) => format!("line {line} of the file"),
            None => "the file".to_owned(),
        };
        let before = file.before.clone().map(String::from_utf8).transpose();
        all.push(FileChange {
            uri: uri_of(path).ok_or_else(|| bad("the path"))?,
            before: before.map_err(|_| bad(&old))?,
            after: String::from_utf8(file.after.clone()).map_err(|_| bad("the new text"))?,
            mode: file.mode,
            concern: file.concern,
        });
    }
    Ok(all)
}

/// The first line that is not UTF-8.
fn not_utf8(bytes: &[u8]) -> Option<usize> {
    let valid = std::str::from_utf8(bytes).err()?.valid_up_to();
    Some(1 + bytes[..valid].iter().filter(|byte| **byte == b'\n').count())
}

fn uri_of(path: &Path) -> Option<Uri> {
    uri::from_path(Utf8Path::from_path(path)?)
}

/// The kinds of workspace edits that the client supports.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EditSupport {
    /// Edits.
    pub(crate) apply: bool,
    /// Creation of files.
    pub(crate) create: bool,
    pub(crate) encoding: Encoding,
}

/// The edit that makes the changes, which the user has already reviewed.
pub(crate) fn workspace_edit(changes: &[FileChange], able: EditSupport) -> WorkspaceEdit {
    let mut operations = Vec::new();
    #[allow(clippy::mutable_key_type, reason = "the type of the protocol")]
    let mut plain: HashMap<Uri, Vec<TextEdit>> = HashMap::new();
    for change in changes {
        let edits = text_edits(change.before.as_deref().unwrap_or_default(), &change.after, able);
        if !able.create {
            plain.insert(change.uri.clone(), edits);
            continue;
        }
        if change.before.is_none() {
            operations.push(DocumentChangeOperation::Op(ResourceOp::Create(CreateFile {
                uri: change.uri.clone(),
                options: Some(CreateFileOptions {
                    overwrite: Some(false),
                    ignore_if_exists: Some(true),
                }),
                annotation_id: None,
            })));
        }
        operations.push(DocumentChangeOperation::Edit(TextDocumentEdit {
            text_document: OptionalVersionedTextDocumentIdentifier {
                uri: change.uri.clone(),
                version: None,
            },
            edits: edits.into_iter().map(OneOf::Left).collect(),
        }));
    }
    if !able.create {
        return WorkspaceEdit::new(plain);
    }
    WorkspaceEdit {
        document_changes: Some(DocumentChanges::Operations(operations)),
        ..WorkspaceEdit::default()
    }
}

/// The edits that turn one text into the other, by whole lines.
fn text_edits(before: &str, after: &str, able: EditSupport) -> Vec<TextEdit> {
    let lines = Lines::new(Arc::from(before), able.encoding);
    let edits = line_edits(before, after).into_iter();
    edits.map(|edit| TextEdit::new(lines.range(&edit.range), edit.text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL_EDITS: EditSupport =
        EditSupport { apply: true, create: true, encoding: Encoding::Utf16 };

    #[test]
    fn edits_change_the_lines_that_differ() {
        for (before, after, count) in [
            ("", "a\nb\n", 1),
            ("a\nb\nc\n", "a\nx\nc\n", 1),
            ("a\nb\nc\nd\ne", "a\nc\nd\ne\nf\n", 2),
            ("é𐐀\r\nb", "é𐐀\r\nb\r\n", 1),
            ("a\n", "", 1),
        ] {
            let edits = text_edits(before, after, ALL_EDITS);
            assert_eq!(edits.len(), count, "{before:?} {edits:?}");
            let lines = Lines::new(Arc::from(before), Encoding::Utf16);
            let mut text = before.to_owned();
            for edit in edits.iter().rev() {
                let range = lines.bytes(edit.range).unwrap();
                text.replace_range(range, &edit.new_text);
            }
            assert_eq!(text, after);
        }
    }
}
