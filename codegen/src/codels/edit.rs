//! Text edits over several files.

use std::collections::BTreeMap;
use std::ops::Range;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::diagnostic::FileEdit;
use dotgen_syntax::encoding::LineEnd;
use serde::Serialize;

/// A replacement of a range of one text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TextEdit {
    /// Byte offsets; empty for an insertion.
    pub range: Range<usize>,
    pub text: String,
}

/// Changes to a set of files.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Edit {
    /// New files with their text.
    pub created: BTreeMap<Utf8PathBuf, String>,
    /// Edits of existing files, in text order. All ranges refer to the text before the edits.
    pub changed: BTreeMap<Utf8PathBuf, Vec<TextEdit>>,
}

impl Edit {
    /// The edit that makes some replacements. Insertions at one place keep their order.
    pub fn of(edits: &[FileEdit]) -> Edit {
        let mut all = Edit::default();
        for edit in edits {
            all.changed
                .entry(edit.path.clone())
                .or_default()
                .push(TextEdit { range: edit.range.clone(), text: edit.new_text.clone() });
        }
        for edits in all.changed.values_mut() {
            edits.sort_by_key(|edit| edit.range.start);
        }
        all
    }

    /// True if there is no change.
    pub fn is_empty(&self) -> bool {
        self.created.is_empty() && self.changed.is_empty()
    }

    /// True if another edit changes or touches a range that this one changes.
    pub fn touches(&self, other: &Edit) -> bool {
        let apart =
            |a: &TextEdit, b: &TextEdit| a.range.end < b.range.start || b.range.end < a.range.start;
        other.changed.iter().any(|(path, edits)| {
            let mine = self.changed.get(path).map_or(&[][..], Vec::as_slice);
            edits.iter().any(|edit| !mine.iter().all(|mine| apart(mine, edit)))
        })
    }

    /// Adds one replacement, unless it is already there.
    pub fn replace(&mut self, path: &Utf8Path, range: Range<usize>, text: impl Into<String>) {
        let edits = self.changed.entry(path.to_owned()).or_default();
        let edit = TextEdit { range, text: text.into() };
        if !edits.contains(&edit) {
            let at = edits.partition_point(|other| other.range.start <= edit.range.start);
            edits.insert(at, edit);
        }
    }

    /// Adds another edit, if it touches no range of this one. Returns true if it was added.
    pub fn merge(&mut self, other: Edit) -> bool {
        let clash = other.changed.iter().any(|(path, edits)| {
            let mine = self.changed.get(path).map_or(&[][..], Vec::as_slice);
            edits.iter().any(|edit| mine.iter().any(|mine| overlap(mine, edit)))
        });
        let created = |path: &Utf8PathBuf| self.created.contains_key(path);
        if clash || other.created.keys().any(created) {
            return false;
        }
        self.created.extend(other.created);
        for (path, edits) in other.changed {
            for edit in edits {
                self.replace(&path, edit.range, edit.text);
            }
        }
        true
    }
}

/// Edits that turn one text into another: whole lines, and as few as possible.
pub fn line_edits(before: &str, after: &str) -> Vec<TextEdit> {
    let diff = similar::TextDiff::from_lines(before, after);
    // Byte offsets of the beginning of each line, and of the end.
    let offsets = |lines: &[&str]| -> Vec<usize> {
        let mut at = 0;
        let starts = lines.iter().map(|line| {
            at += line.len();
            at
        });
        std::iter::once(0).chain(starts).collect()
    };
    let old = offsets(diff.old_slices());
    let new = offsets(diff.new_slices());
    let ops = diff.ops().iter();
    ops.filter(|diff_op| diff_op.tag() != similar::DiffTag::Equal)
        .map(|diff_op| {
            let (from, to) = (diff_op.old_range(), diff_op.new_range());
            TextEdit {
                range: old[from.start]..old[from.end],
                text: after[new[to.start]..new[to.end]].to_owned(),
            }
        })
        .collect()
}

/// True if two edits overlap. Two insertions at one place do not: the earlier one comes first.
fn overlap(a: &TextEdit, b: &TextEdit) -> bool {
    if a == b {
        return false;
    }
    if a.range.is_empty() || b.range.is_empty() {
        let (point, other) = if a.range.is_empty() { (a, b) } else { (b, a) };
        return other.range.start < point.range.start && point.range.start < other.range.end;
    }
    a.range.start < b.range.end && b.range.start < a.range.end
}

/// Applies edits to a text, with its line ends. Edits that do not fit the text or overlap an earlier one are
/// skipped.
pub fn apply(text: &str, edits: &[TextEdit]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    let line_end = LineEnd::of(text);
    for edit in edits {
        let fits = edit.range.start >= at
            && edit.range.end >= edit.range.start
            && text.is_char_boundary(edit.range.start)
            && text.is_char_boundary(edit.range.end);
        if fits && edit.range.end <= text.len() {
            out += &text[at..edit.range.start];
            out += &line_end.fit(&edit.text);
            at = edit.range.end;
        }
    }
    out += &text[at..];
    out
}

/// The difference of two texts in the format of `diff -u`; empty if they are equal. A missing text is shown
/// as `/dev/null`.
pub fn unified_diff(path: &Utf8Path, before: Option<&str>, after: &str) -> String {
    let old = before.unwrap_or_default();
    if before.is_some() && old == after {
        return String::new();
    }
    let name = path.as_str().trim_start_matches('/');
    let from = match before {
        Some(_) => format!("a/{name}"),
        None => "/dev/null".to_owned(),
    };
    similar::TextDiff::from_lines(old, after)
        .unified_diff()
        .context_radius(3)
        .header(&from, &format!("b/{name}"))
        .to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_apply_in_text_order() {
        let mut edit = Edit::default();
        edit.replace("f".into(), 3..4, "X");
        edit.replace("f".into(), 0..1, "");
        edit.replace("f".into(), 4..4, "+");
        let edits = &edit.changed[Utf8Path::new("f")];
        assert_eq!(apply("abcdef", edits), "bcX+ef");
    }

    #[test]
    fn what_is_inserted_has_the_line_ends_of_the_text() {
        let mut edit = Edit::default();
        edit.replace("f".into(), 3..3, "x\ny\n");
        let edits = &edit.changed[Utf8Path::new("f")];
        assert_eq!(apply("a\r\nb\r\n", edits), "a\r\nx\r\ny\r\nb\r\n");
        assert_eq!(apply("a\n\nb\n", edits), "a\n\nx\ny\nb\n");
    }

    #[test]
    fn what_overlaps_is_refused() {
        let mut edit = Edit::default();
        edit.replace("f".into(), 2..5, "X");
        let mut other = Edit::default();
        other.replace("f".into(), 4..6, "Y");
        assert!(!edit.merge(other));
        let mut other = Edit::default();
        other.replace("f".into(), 5..6, "Y");
        assert!(edit.merge(other));
        let edits = &edit.changed[Utf8Path::new("f")];
        assert_eq!(apply("abcdefg", edits), "abXYg");
    }

    #[test]
    fn lines_that_stay_are_not_touched() {
        let (before, after) = ("a\nb\nc\nd\n", "a\nB\nc\nd\ne");
        let edits = line_edits(before, after);
        assert_eq!(apply(before, &edits), after);
        assert_eq!(edits.len(), 2, "{edits:?}");
        assert_eq!(edits[0].range, 2..4);
        assert_eq!(line_edits("a", "a"), []);
    }

    #[test]
    fn a_diff_names_both_sides() {
        let diff = unified_diff("x/a.c".into(), Some("a\nb\n"), "a\nc\n");
        assert_eq!(diff, "--- a/x/a.c\n+++ b/x/a.c\n@@ -1,2 +1,2 @@\n a\n-b\n+c\n");
        let diff = unified_diff("a.c".into(), None, "a\n");
        assert_eq!(diff, "--- /dev/null\n+++ b/a.c\n@@ -0,0 +1 @@\n+a\n");
    }
}
