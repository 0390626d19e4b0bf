//! Declared and never used.

use crate::{
    elab::ElabDiagnostic,
    model::{Component, ComponentKind},
};

pub(super) fn check(component: &Component, found: &mut Vec<ElabDiagnostic>) {
    if component.kind != ComponentKind::Component {
        return;
    }
    for (index, task) in (0..).zip(&component.tasks) {
        let runs =
            !task.codels.is_empty() || component.services.iter().any(|it| it.task == Some(index));
        if !runs && task.imported_from.is_none() {
            let message = format!(
                "task `{}` runs nothing: it has no codels, and no activity has `task {};`",
                task.name, task.name
            );
            found.push(ElabDiagnostic::new("unused-task", task.src, message));
        }
    }
}
