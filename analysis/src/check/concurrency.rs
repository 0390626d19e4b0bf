//! Async codels, which run outside the mutual exclusion of their task (language reference,
//! section 14).

use crate::finding::role::Role;
use crate::{
    finding::{Finding, codels::CodelProblem},
    model::{
        CodelRef, Component, ComponentKind, Owner, OwnerName, Spec,
        fsm::Machine,
        mutex::{Excluded, Exclusion, exclusions},
    },
};

pub(super) fn check(spec: &Spec, component: &Component, found: &mut Vec<Finding>) {
    for codel in component.all_codels() {
        if !component.codel(codel).is_async {
            continue;
        }
        for exclusion in exclusions(spec, component, codel) {
            report(component, codel, &exclusion, found);
        }
    }
}

fn report(component: &Component, codel: CodelRef, exclusion: &Exclusion, found: &mut Vec<Finding>) {
    let own = component.codel(codel);
    let Some(through) = exclusion.through.first() else {
        return;
    };
    let shared = through.shared.describe(component).to_string();
    let codel_name = own.name.clone();
    let (kind, other, src, params) = match exclusion.with {
        Excluded::Codel(other) => {
            if !runs_meanwhile(component, other) {
                return;
            }
            let codel = component.codel(other);
            let owner = OwnerName::of(component, other.owner);
            let role = Role::Sharing { codel: codel.name.clone(), owner: owner.clone() };
            let kind = CodelProblem::SharedWithCodel {
                codel: codel_name,
                shared: shared.into(),
                with: codel.name.clone(),
                owner,
            };
            (kind, role, codel.src, &codel.params)
        }
        Excluded::Service(other) => {
            let service = &component.services[other];
            let role = Role::Attribute(service.name.clone());
            let kind = CodelProblem::SharedWithAttribute {
                codel: codel_name,
                shared: shared.into(),
                with: service.name.clone(),
            };
            (kind, role, service.src, &service.params)
        }
    };
    let mut diagnostic = Finding::new(kind, own.src).related(src, other);
    if let Some(param) = own.params.get(through.own as usize) {
        diagnostic = diagnostic.related(param.src, Role::Used);
    }
    if let Some(param) = params.get(through.other as usize) {
        diagnostic = diagnostic.related(param.src, Role::UsedToo);
    }
    found.push(diagnostic);
}

/// Returns true if a codel can run while services do: the first and the last codels of a task cannot.
fn runs_meanwhile(component: &Component, codel: CodelRef) -> bool {
    let Owner::Task(task) = codel.owner else {
        return true;
    };
    // Machines of tasks are completed by the component that imports the interface.
    if component.kind == ComponentKind::Interface {
        return false;
    }
    let machine = Machine::new(&component.tasks[task].codels);
    let reached = machine.reachable("start");
    let mut states = component.codel(codel).triggers.iter();
    states.any(|state| state.name != "start" && reached.contains(state.name.as_str()))
}
