//! The expansion of a macro call, for display.

use dotgen_syntax::{SyntaxKind, TextSize, ast::support};

use super::{FileView, MacroExpansion, RangeInfo, hover::expansion};

/// The innermost call around the cursor.
pub(crate) fn expand_macro(view: &FileView<'_>, at: usize) -> Option<RangeInfo<MacroExpansion>> {
    let at = TextSize::try_from(at).ok()?;
    let root = view.root();
    if at > root.text_range().end() {
        return None;
    }
    let tokens = root.token_at_offset(at);
    let around = |token: dotgen_syntax::SyntaxToken| {
        token.parent_ancestors().find(|ancestor| ancestor.kind() == SyntaxKind::MACRO_CALL)
    };
    // The cursor may be right after the call.
    let call = tokens
        .clone()
        .right_biased()
        .and_then(around)
        .or_else(|| tokens.left_biased().and_then(around))?;
    let name = support::first_text_token(&call)?;
    Some(RangeInfo {
        range: call.text_range().into(),
        info: MacroExpansion {
            name: name.text().into(),
            expansion: expansion(view, call.text_range())?,
        },
    })
}
