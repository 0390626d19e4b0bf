//! The syntax tree as text, for debugging.

use super::FileView;

pub(crate) fn syntax_tree(view: &FileView<'_>) -> String {
    dotgen_syntax::dump(view.parse())
}
