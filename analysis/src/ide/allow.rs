//! The comment that allows a finding, see [`crate::suppress`].

use dotgen_syntax::{
    TextSize,
    ast::{self, AstNode, support},
    line_index::line_start,
};

use super::FileView;
use crate::{
    codes::lints,
    diagnostic::{Diagnostic, FileEdit, Fix, FixKind, Severity},
    suppress::MARK,
};

/// Returns true if the findings of a code are about comments that allow others.
pub fn is_about_comment(code: &str) -> bool {
    [lints::UNUSED_SUPPRESSION, lints::NO_REASON].contains(&code)
}

/// The fix that allows a finding by a comment above its declaration. The comment has no reason yet, which is
/// reported. `None` if the finding cannot be allowed, or its declaration begins in the middle of a line.
pub(crate) fn allowing(view: &FileView<'_>, diagnostic: &Diagnostic) -> Option<Fix> {
    let rule = lints::find(diagnostic.code)?;
    if diagnostic.severity == Severity::Error || is_about_comment(rule.id) {
        return None;
    }
    let text = view.text();
    let at = TextSize::try_from(diagnostic.range.start).ok()?;
    let token = view.root().token_at_offset(at).right_biased()?;
    let mut items =
        token.parent_ancestors().filter(|ancestor| ast::Item::can_cast(ancestor.kind()));
    let (at, indent) = items.find_map(|item| {
        let first = support::first_text_token(&item)?;
        let start = usize::from(first.text_range().start());
        let line = line_start(text, start);
        let indent = &text[line..start];
        indent.trim().is_empty().then_some((line, indent))
    })?;
    let comment = format!("{indent}// {MARK} allow({})\n", diagnostic.code);
    Some(Fix {
        title: format!("Allow `{}` here, with a comment", diagnostic.code),
        kind: FixKind::Choice,
        edits: vec![FileEdit { path: diagnostic.path.clone(), range: at..at, new_text: comment }],
    })
}
