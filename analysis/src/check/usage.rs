//! Declarations that are never used.

use crate::{
    finding::{Finding, codels::CodelProblem},
    model::{Component, ComponentKind},
};

pub(super) fn check(component: &Component, found: &mut Vec<Finding>) {
    if component.kind != ComponentKind::Component {
        return;
    }
    for (index, task) in component.tasks.iter_enumerated() {
        let runs = !task.codels.is_empty()
            || component.services.iter().any(|service| service.task == Some(index));
        if !runs && task.imported_from.is_none() {
            found.push(Finding::new(CodelProblem::IdleTask { task: task.name.clone() }, task.src));
        }
    }
}
