//! Changes the execution time of a codel that states one.

use std::ops::Range;

use dotgen_syntax::ast::{self, AstNode};

use super::Cx;
use crate::diagnostic::FileEdit;
use crate::ide::FileView;

/// The edit that sets the execution time of the codel around a place to `time` (`4 ms`), if the codel states
/// one in a clause of its own. Times from a macro or a pragma are not edited.
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
    replace_time(&cx, &clause.quantity()?, time)
}

/// A time of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TaskTime {
    /// `period`
    Period,
    /// `delay`
    Delay,
}

/// The edit that sets the period or delay of the task around a place: the existing value is replaced; a
/// missing delay is inserted after the period. Values from a macro are not edited.
pub(crate) fn task_time(
    view: &FileView<'_>,
    range: &Range<usize>,
    which: TaskTime,
    time: &str,
) -> Option<FileEdit> {
    let range = range.clone();
    let cx = Cx { view, range };
    let task = cx.ancestor::<ast::Task>()?;
    let body = task.body()?;
    let all = || {
        let nodes = body.syntax().descendants();
        nodes.filter_map(ast::DurationProperty::cast)
    };
    let stated = match which {
        TaskTime::Period => all().find(|property| property.period_token().is_some()),
        TaskTime::Delay => all().find(|property| property.delay_token().is_some()),
    };
    if let Some(property) = stated {
        return replace_time(&cx, &property.quantity()?, time);
    }
    let period = all().find(|property| property.period_token().is_some())?;
    if which == TaskTime::Period || !cx.is_plain(period.syntax()) {
        return None;
    }
    // After its `;`, before the blanks that follow.
    let node = cx.node_range(period.syntax());
    let end = node.start + cx.slice(node.clone()).trim_end().len();
    Some(cx.edit(end..end, format!(" delay {time};")))
}

/// Replaces the time of a quantity.
fn replace_time(cx: &Cx<'_, '_>, quantity: &ast::Quantity, time: &str) -> Option<FileEdit> {
    if !cx.is_plain(quantity.syntax()) {
        return None;
    }
    // The blanks around it stay.
    let node = cx.node_range(quantity.syntax());
    let text = cx.view.text().get(node.clone())?;
    let start = node.start + (text.len() - text.trim_start().len());
    let end = start + text.trim().len();
    Some(cx.edit(start..end, time))
}
