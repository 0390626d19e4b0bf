//! Fixes of several findings, made together.

use dotgen_analysis::diagnostic::{FileEdit, Fix};

/// The edits of fixes, leaving out those that touch the edits of one before.
pub(crate) fn together<'f>(fixes: impl IntoIterator<Item = &'f Fix>) -> Vec<FileEdit> {
    let apart = |a: &FileEdit, b: &FileEdit| {
        a.path != b.path || a.range.end < b.range.start || b.range.end < a.range.start
    };
    let mut edits: Vec<FileEdit> = Vec::new();
    for fix in fixes {
        let mut own = fix.edits.iter();
        if own.all(|new| edits.iter().all(|old| apart(old, new))) {
            edits.extend(fix.edits.iter().cloned());
        }
    }
    edits
}
