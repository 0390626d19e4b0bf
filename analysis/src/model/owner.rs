//! Names of tasks and services in messages.

use std::fmt;

use super::{Component, Name, Owner};

/// The task or service that a codel belongs to.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct OwnerName {
    /// `task`, `attribute`, `function` or `activity`.
    pub kind: &'static str,
    /// The name.
    pub name: Name,
}

impl OwnerName {
    /// The name of a task or service of a component.
    pub fn of(component: &Component, owner: Owner) -> OwnerName {
        let (kind, name) = match owner {
            Owner::Task(task) => ("task", &component.tasks[task].name),
            Owner::Service(index) => {
                let service = &component.services[index];
                (service.kind.word(), &service.name)
            }
        };
        OwnerName { kind, name: name.clone() }
    }
}

impl fmt::Display for OwnerName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} `{}`", self.kind, self.name)
    }
}
