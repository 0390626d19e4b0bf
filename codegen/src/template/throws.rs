//! Exceptions an object may raise: those of its owner first, then its own, each once.

use dotgen_analysis::model::{Component, Remote, ServiceId, Task, TypeId};

fn unique(lists: &[&[TypeId]]) -> Vec<TypeId> {
    let mut out = Vec::new();
    for ty in lists.iter().copied().flatten() {
        if !out.contains(ty) {
            out.push(*ty);
        }
    }
    out
}

/// Of a component: its own, those of its tasks, those of its services.
pub(crate) fn component_throws(component: &Component) -> Vec<TypeId> {
    let mut lists: Vec<&[TypeId]> = vec![&component.throws];
    lists.extend(component.tasks.iter().map(|task| task.throws.as_slice()));
    lists.extend(component.services.iter().map(|service| service.throws.as_slice()));
    unique(&lists)
}

pub(crate) fn task_throws(component: &Component, task: &Task) -> Vec<TypeId> {
    unique(&[&component.throws, &task.throws])
}

pub fn service_throws(component: &Component, service: ServiceId) -> Vec<TypeId> {
    let service = &component.services[service];
    let task = service.task.map(|task| &component.tasks[task]);
    let task = task.map_or(&[][..], |task| task.throws.as_slice());
    unique(&[&component.throws, task, &service.throws])
}

/// Of a remote: the using component's before those of the providing side.
pub(crate) fn remote_throws(component: &Component, remote: &Remote) -> Vec<TypeId> {
    unique(&[&component.throws, &remote.throws])
}
