//! Changes the execution time of a codel that states one.

use std::ops::Range;

use dotgen_syntax::ast::{self, AstNode};

use super::Cx;
use crate::diagnostic::FileEdit;
use crate::ide::FileView;

/// Marks an execution time that is required and not measured.
const BUDGET: &str = " /* budget */";

/// The edit that makes `time` (`4 ms`) the budget of the codel around a place, if the codel states a time in
/// a clause of its own or in a pragma of the file. A clause gets the comment *budget*: the new time is a
/// requirement, not a measured value. Times from a macro are not edited.
pub(crate) fn execution_time(
    view: &FileView<'_>,
    range: &Range<usize>,
    time: &str,
) -> Option<FileEdit> {
    let range = range.clone();
    let cx = Cx { view, range };
    let codel = cx.ancestor::<ast::Codel>()?;
    let mut clauses = codel.wcets();
    match (clauses.next(), clauses.next()) {
        (Some(clause), None) => {
            let quantity = clause.quantity()?;
            let after = cx.view.text().get(cx.node_range(quantity.syntax()).end..)?;
            let known = after.trim_start().starts_with(BUDGET.trim_start());
            let mark = if known { "" } else { BUDGET };
            replace_time(&cx, &quantity, &format!("{time}{mark}"))
        }
        (None, _) => {
            let name = cx.text(codel.name()?.syntax()).to_owned();
            let directives = view.root().descendants().filter_map(ast::Directive::cast);
            let pragma = { directives }.find(|directive| {
                // The first name is the word after `#pragma`.
                let mut names = directive.syntax().children().filter_map(ast::NameRef::cast);
                let mut is =
                    |text: &str| names.next().is_some_and(|name| cx.text(name.syntax()) == text);
                is("wcet") && is(&name)
            })?;
            replace_time(&cx, &pragma.quantity()?, time)
        }
        _ => None,
    }
}

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
