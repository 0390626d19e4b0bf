//! Mutual exclusion: the codels that cannot run at the same time, and the shared data that causes it.
//!
//! Codels that share data of the ids, or a port, exclude each other if different tasks can run them
//! (reference manual, "Codel mutual exclusion"; language reference, section 14).

use super::{
    Codel, CodelKind, CodelRef, Component, Owner, Param, ParamDir, ParamSource, PathElement,
    PortId, ServiceId, Spec,
};
use crate::phrase::Phrase;

/// A codel or attribute that a codel excludes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exclusion {
    pub with: Excluded,
    /// Every pair of parameters that causes the exclusion, at least one.
    pub through: Vec<SharedParameters>,
}

/// See [`Exclusion`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Excluded {
    /// Another codel.
    Codel(CodelRef),
    /// An attribute, whose parameters are data of the ids: index into [`Component::services`].
    Service(ServiceId),
}

/// Two parameters that refer to the same data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharedParameters {
    /// The shared data.
    pub shared: Shared,
    /// Index into the parameters of the codel.
    pub own: u32,
    /// Index into the parameters of the other.
    pub other: u32,
}

/// Shared data.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Shared {
    /// A part of the ids, by the longer of both paths; the whole ids if empty.
    Ids(Vec<PathElement>),
    /// Index into [`Component::ports`].
    Port(PortId),
}

impl Shared {
    /// For messages: `` `v.x` of the ids ``, `` port `p` ``.
    pub fn describe(&self, component: &Component) -> Phrase {
        match self {
            Self::Ids(path) if path.is_empty() => Phrase::words("the whole ids"),
            Self::Ids(path) => Phrase::name(path_text(path)).and(" of the ids"),
            Self::Port(port) => match component.ports.get(*port) {
                Some(port) => Phrase::words("port ").and_name(port.name.as_str()),
                None => Phrase::words("a port"),
            },
        }
    }
}

/// A path as written: `v.a[1]`.
pub fn path_text(path: &[PathElement]) -> String {
    let mut text = String::new();
    for element in path {
        match element {
            PathElement::Member(name) => {
                if !text.is_empty() {
                    text.push('.');
                }
                text.push_str(name);
            }
            PathElement::Index(index) => text.push_str(&format!("[{index}]")),
        }
    }
    text
}

/// Everything that a codel excludes: codels of tasks, codels of services in order, then attributes.
pub fn exclusions(spec: &Spec, component: &Component, codel: CodelRef) -> Vec<Exclusion> {
    let own = component.codel(codel);
    let is_shared = |param: &Param| matches!(param.source, ParamSource::Port(_) | ParamSource::Ids);
    if !own.params.iter().any(is_shared) {
        return Vec::new();
    }
    let task = component.task_of(codel);
    let mut found: Vec<Exclusion> = Vec::new();
    let mut add = |with: Excluded, through: Vec<SharedParameters>| {
        if !through.is_empty() {
            found.push(Exclusion { with, through });
        }
    };
    for (number, other) in component.tasks.iter_enumerated() {
        let owner = Owner::Task(number);
        if task == Some(number) {
            continue;
        }
        for (index, codel) in other.codels.iter_enumerated() {
            let through = collisions(spec, own, codel);
            add(Excluded::Codel(CodelRef { owner, index }), through);
        }
    }
    for (number, service) in component.services.iter_enumerated() {
        let owner = Owner::Service(number);
        for (index, codel) in service.codels.iter_enumerated() {
            if task.is_some() && codel.kind != CodelKind::Fsm {
                let through = collisions(spec, own, codel);
                add(Excluded::Codel(CodelRef { owner, index }), through);
            }
        }
        if service.task == task || (task.is_some() && interrupts(service, codel)) {
            continue;
        }
        for (index, codel) in service.codels.iter_enumerated() {
            if codel.kind == CodelKind::Fsm {
                let through = collisions(spec, own, codel);
                add(Excluded::Codel(CodelRef { owner, index }), through);
            }
        }
    }
    if task.is_some() {
        for (number, service) in component.services.iter_enumerated() {
            if service.task != task {
                let through = attribute_collisions(spec, own, &service.params);
                add(Excluded::Service(number), through);
            }
        }
    }
    found
}

/// Names of the excluded codels and attributes, each once.
pub fn excluded_names(spec: &Spec, component: &Component, codel: CodelRef) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for exclusion in exclusions(spec, component, codel) {
        let name = match exclusion.with {
            Excluded::Codel(codel) => component.codel(codel).name.to_string(),
            Excluded::Service(service) => component.services[service].name.to_string(),
        };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The codels that cannot run while a service reads or sets its parameters: those of tasks, then
/// those of services that run in another task.
pub fn service_exclusions(spec: &Spec, component: &Component, service: ServiceId) -> Vec<CodelRef> {
    let Some(own) = component.services.get(service) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let others = component.all_codels().filter(|codel| {
        component.codel(*codel).kind == CodelKind::Fsm && component.task_of(*codel) != own.task
    });
    for other in others {
        let codel = component.codel(other);
        if !attribute_collisions(spec, codel, &own.params).is_empty() {
            found.push(other);
        }
    }
    found
}

/// Returns true if a service interrupts the service that a codel belongs to.
fn interrupts(service: &super::Service, codel: CodelRef) -> bool {
    match codel.owner {
        Owner::Service(target) => {
            service.interrupts.all || service.interrupts.services.contains(&target)
        }
        Owner::Task(_) => false,
    }
}

/// The pairs of parameters through which two codels conflict.
pub fn collisions(spec: &Spec, own: &Codel, other: &Codel) -> Vec<SharedParameters> {
    pairs(spec, &own.params, &other.params, |a, b| a == ParamDir::In && b == ParamDir::In)
}

/// The pairs of parameters through which a codel conflicts with an attribute. The attribute's direction is
/// relative to the client: `in` sets the ids, `out` reads them.
fn attribute_collisions(spec: &Spec, own: &Codel, params: &[Param]) -> Vec<SharedParameters> {
    pairs(spec, &own.params, params, |a, b| a == ParamDir::In && b == ParamDir::Out)
}

fn pairs(
    spec: &Spec,
    own: &[Param],
    other: &[Param],
    both_read: impl Fn(ParamDir, ParamDir) -> bool,
) -> Vec<SharedParameters> {
    let mut found = Vec::new();
    for (i, a) in (0..).zip(own) {
        for (j, b) in (0..).zip(other) {
            if let Some(shared) = shared(spec, a, b, &both_read) {
                found.push(SharedParameters { shared, own: i, other: j });
            }
        }
    }
    found
}

fn shared(
    spec: &Spec,
    a: &Param,
    b: &Param,
    both_read: impl Fn(ParamDir, ParamDir) -> bool,
) -> Option<Shared> {
    match (a.source, b.source) {
        (ParamSource::Port(p), ParamSource::Port(q)) if p == q => Some(Shared::Port(p)),
        (ParamSource::Ids, ParamSource::Ids) => {
            let same = a.base == b.base || spec.resolve_alias(a.base) == spec.resolve_alias(b.base);
            if !same || both_read(a.dir, b.dir) {
                return None;
            }
            let (short, long) =
                if a.path.len() <= b.path.len() { (&a.path, &b.path) } else { (&b.path, &a.path) };
            long.starts_with(short).then(|| Shared::Ids(long.clone()))
        }
        _ => None,
    }
}
