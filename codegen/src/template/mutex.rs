//! Mutual exclusion: codels and services that must not run at the same time.

use dotgen_analysis::model::{
    Codel, CodelKind, CodelRef, Component, Owner, Param, ParamDir, ParamSource, ServiceId, Spec,
    TaskId,
};
use rustc_hash::FxHashSet;

/// The other side of a comparison: a codel's parameters, or a service's inputs and outputs.
#[derive(Clone, Copy, PartialEq)]
enum MutexOperand {
    Codel,
    Service,
}

/// Codels, then services, that exclude a codel.
pub(crate) fn codel_mutex(
    spec: &Spec,
    component: &Component,
    at: CodelRef,
) -> (Vec<CodelRef>, Vec<ServiceId>) {
    let codel = component.codel(at);
    let task = component.task_of(at);
    let service = match at.owner {
        Owner::Service(service) => Some(service),
        Owner::Task(_) => None,
    };
    let mut found = SeenCodels::new(component);
    let conflict =
        |other: &Codel| conflicts(spec, &codel.params, &other.params, MutexOperand::Codel);
    for other in component.tasks.keys().filter(|other| Some(*other) != task) {
        found.add_state_machine(Owner::Task(other), conflict);
    }
    for (index, other) in component.services.iter_enumerated() {
        if task.is_some() {
            found.add(Owner::Service(index), |codel| {
                codel.kind != CodelKind::Fsm && conflict(codel)
            });
        }
        if other.task == task {
            continue;
        }
        let interrupts = other.interrupts.all
            || service.is_some_and(|service| other.interrupts.services.contains(&service));
        if task.is_some() && interrupts {
            continue;
        }
        found.add_state_machine(Owner::Service(index), conflict);
    }
    let services = component.services.iter_enumerated();
    let services = services
        .filter(|(_, other)| other.task != task)
        .filter(|(_, other)| conflicts(spec, &codel.params, &other.params, MutexOperand::Service))
        .map(|(index, _)| index);
    (found.codels, services.collect())
}

/// Codels that exclude a service.
pub(crate) fn service_mutex(
    spec: &Spec,
    component: &Component,
    service: ServiceId,
) -> Vec<CodelRef> {
    let service = &component.services[service];
    let mut found = SeenCodels::new(component);
    let conflict =
        |other: &Codel| conflicts(spec, &other.params, &service.params, MutexOperand::Service);
    for other in component.tasks.keys().filter(|task| Some(*task) != service.task) {
        found.add_state_machine(Owner::Task(other), conflict);
    }
    for (index, other) in component.services.iter_enumerated() {
        if other.task != service.task {
            found.add_state_machine(Owner::Service(index), conflict);
        }
    }
    found.codels
}

/// Codels found so far, each once, identified by task, service and name.
struct SeenCodels<'a> {
    component: &'a Component,
    codels: Vec<CodelRef>,
    seen: FxHashSet<(Option<TaskId>, Option<ServiceId>, &'a str)>,
}

impl<'a> SeenCodels<'a> {
    fn new(component: &'a Component) -> SeenCodels<'a> {
        SeenCodels { component, codels: Vec::new(), seen: FxHashSet::default() }
    }

    fn add(&mut self, owner: Owner, wanted: impl Fn(&Codel) -> bool) {
        for (index, codel) in self.component.codels_of(owner).iter_enumerated() {
            let at = CodelRef { owner, index };
            let service = match owner {
                Owner::Service(service) => Some(service),
                Owner::Task(_) => None,
            };
            let key = (self.component.task_of(at), service, codel.name.as_str());
            if wanted(codel) && self.seen.insert(key) {
                self.codels.push(at);
            }
        }
    }

    /// Codels that are reached by a state, in order of their first state.
    fn add_state_machine(&mut self, owner: Owner, wanted: impl Fn(&Codel) -> bool) {
        self.add(owner, |codel| {
            codel.kind == CodelKind::Fsm && !codel.triggers.is_empty() && wanted(codel)
        });
    }
}

fn conflicts(spec: &Spec, left: &[Param], right: &[Param], against: MutexOperand) -> bool {
    left.iter().any(|p| right.iter().any(|q| conflict(spec, p, q, against)))
}

fn conflict(spec: &Spec, p: &Param, q: &Param, against: MutexOperand) -> bool {
    match (p.source, q.source) {
        (ParamSource::Port(a), ParamSource::Port(b)) => return a == b,
        (ParamSource::Remote(a), ParamSource::Remote(b)) if a == b => {}
        (ParamSource::Ids, ParamSource::Ids)
            if spec.resolve_alias(p.base) == spec.resolve_alias(q.base) => {}
        _ => return false,
    }
    // An input of a service is written to the ids by an attribute.
    let harmless = match against {
        MutexOperand::Codel => ParamDir::In,
        MutexOperand::Service => ParamDir::Out,
    };
    if p.dir == ParamDir::In && q.dir == harmless {
        return false;
    }
    p.path.iter().zip(&q.path).all(|(a, b)| a == b)
}
