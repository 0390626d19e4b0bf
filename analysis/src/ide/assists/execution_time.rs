//! Another execution time for a codel that states one.

use std::ops::Range;

use dotgen_syntax::ast::{self, AstNode};

use super::Cx;
use crate::diagnostic::FileEdit;
use crate::ide::FileView;

/// The edit that gives the codel around a place the execution time `time` (`4 ms`), if it states one in a clause of its
/// own: one that comes from a macro or a pragma is left to its author.
pub(crate) fn execution_time(
    view: &FileView<'_>,
    range: &Range<usize>,
    time: &str,
) -> Option<FileEdit> {
    let range = range.clone();
    let cx = Cx { view, range };
    let codel = cx.ancestor::<ast::Codel>()?;
    let mut clauses = codel.wcets();
    let (clause, None) = (clauses.next()?, clauses.next()) else {
        return None;
    };
    let quantity = clause.quantity()?;
    if !cx.is_plain(quantity.syntax()) {
        return None;
    }
    // The blanks around it stay.
    let node = cx.node_range(quantity.syntax());
    let text = view.text().get(node.clone())?;
    let start = node.start + (text.len() - text.trim_start().len());
    let end = start + text.trim().len();
    Some(cx.edit(start..end, time))
}
