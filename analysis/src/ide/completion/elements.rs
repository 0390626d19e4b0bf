//! Completion of elements that several statements share: tasks, sizes, quantities.

use super::{CompletionKind, Completions, names::VisibleNames};
use crate::{
    elab::Entity,
    ide::{SymbolKind, context::Word},
};

pub(super) fn tasks(names: &VisibleNames<'_, '_>, out: &mut Completions) {
    let Some(component) = names.component() else {
        return;
    };
    for (i, task) in component.tasks.iter_enumerated() {
        let definition = names.part(|c| Entity::Task(c, i));
        if !names.is_above(definition) || !names.is_imported_above(task.imported_from) {
            continue;
        }
        let item = out.add(task.name.as_str(), CompletionKind::Symbol(SymbolKind::Task), 0);
        item.definition = definition;
        item.detail = task
            .period
            .as_ref()
            .map(|period| format!("period {}", crate::quantity::time(period.value)));
    }
}

/// Constants that are valid sizes.
pub(super) fn sizes(names: &VisibleNames<'_, '_>, out: &mut Completions) {
    names.numbers(&[], true, out);
}

/// A number, then its unit.
pub(super) fn quantity(
    names: &VisibleNames<'_, '_>,
    rest: &[Word],
    units: &[&str],
    out: &mut Completions,
) {
    use dotgen_syntax::SyntaxKind::*;
    match rest.last().map(|word| word.kind) {
        // The unit already follows.
        Some(IDENT) if rest.len() > 1 && rest.last().is_some_and(|word| word.is_any(units)) => {}
        Some(INT | FLOAT | IDENT | R_PAREN) => {
            for unit in units {
                out.add(*unit, CompletionKind::Unit, 0);
            }
        }
        _ => {
            names.numbers(rest, units.is_empty(), out);
            super::directive::values(names.view, names.at(), 4, out);
        }
    }
}
