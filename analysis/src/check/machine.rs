//! State machines (language reference, section 13).

use crate::{
    elab::ElabDiagnostic,
    model::{
        Codel, Component, ComponentKind, Name, Spec, Src, Type, TypeId, TypeKind, fsm::Machine,
    },
};

/// The task or activity a machine belongs to.
struct Owner<'a> {
    what: &'static str,
    name: &'a Name,
    src: Src,
    throws: &'a [TypeId],
}

pub(super) fn check(spec: &Spec, component: &Component, found: &mut Vec<ElabDiagnostic>) {
    // Interfaces may leave their machines to be completed by whoever imports them.
    if component.kind != ComponentKind::Component {
        return;
    }
    for task in &component.tasks {
        let owner = Owner {
            what: "task",
            name: &task.name,
            src: task.src,
            throws: &task.throws,
        };
        check_machine(spec, &owner, &task.codels, found);
    }
    for service in &component.services {
        let owner = Owner {
            what: "activity",
            name: &service.name,
            src: service.src,
            throws: &service.throws,
        };
        check_machine(spec, &owner, &service.codels, found);
    }
}

fn check_machine(
    spec: &Spec,
    owner: &Owner<'_>,
    codels: &[Codel],
    found: &mut Vec<ElabDiagnostic>,
) {
    let Owner { what, name, .. } = owner;
    let machine = Machine::new(codels);
    if machine.is_empty() {
        return;
    }
    // Without its yields, which is a syntax error, nothing can be said about what is reached.
    let complete = machine.codels.iter().all(|(_, it)| !it.yields.is_empty());
    let mut reached = machine.reachable("start");
    let from_stop = machine.reachable("stop");
    // With a codel of its own, `ether` is a state as any other, and nothing ends the machine.
    let ends = from_stop.contains("ether") && machine.codel("ether").is_none();
    if let Some((_, stop)) = machine.codel("stop")
        && complete
        && !ends
    {
        let message = format!(
            "in {what} `{name}`, no path leads from `stop` to `ether`, so it could never be \
             interrupted; let a codel reached from `stop` yield `ether`"
        );
        found.push(ElabDiagnostic::new(
            "fsm/stop-without-ether",
            stop.src,
            message,
        ));
    }
    reached.extend(from_stop);
    for (_, codel) in &machine.codels {
        let is_reached = codel
            .triggers
            .iter()
            .any(|it| reached.contains(it.name.as_str()));
        if !is_reached {
            if complete && let Some(state) = codel.triggers.first() {
                let message = format!(
                    "state `{}` of {what} `{name}` can be reached neither from `start` nor from \
                     `stop`",
                    state.name
                );
                found.push(
                    ElabDiagnostic::new("fsm/unreachable-state", codel.src, message)
                        .related(owner.src, format!("the {what}")),
                );
            }
            continue;
        }
        if let Some(ether) = codel.triggers.iter().find(|it| it.name == "ether") {
            found.push(ElabDiagnostic::new(
                "ether-codel",
                ether.src,
                "`ether` is the end of the state machine; a codel for it keeps the machine from \
                 ending there",
            ));
        }
        let mut missing: Vec<&Name> = Vec::new();
        for state in &codel.yields {
            if state.name == "ether"
                || machine.codel(&state.name).is_some()
                || missing.contains(&&state.name)
            {
                continue;
            }
            missing.push(&state.name);
            if let Some(exception) = thrown_elsewhere(spec, owner, &state.name) {
                let message = format!(
                    "codel `{}` yields `{}`, which is an exception that {what} `{name}` does not \
                     throw; declare `throw {}` and leave it out of the states: a codel leaves with \
                     an exception from wherever it is",
                    codel.name,
                    state.name,
                    spec.full_name(exception)
                        .unwrap_or_else(|| state.name.to_string()),
                );
                found.push(
                    ElabDiagnostic::new("throw/undeclared-use", state.src, message)
                        .related(owner.src, format!("the {what}")),
                );
                continue;
            }
            let states = machine.states().map(|it| it.as_str());
            let hint = crate::elab::suggest::hint(&state.name, states.chain(["ether"]));
            let message = format!(
                "codel `{}` leads to state `{}`, which no codel of {what} `{name}` implements{hint}",
                codel.name, state.name
            );
            found.push(
                ElabDiagnostic::new("fsm/undefined-state", codel.src, message)
                    .related(state.src, "this state"),
            );
        }
    }
}

/// The exception of this name, if there is one and the owner does not declare that it throws it.
fn thrown_elsewhere(spec: &Spec, owner: &Owner<'_>, name: &str) -> Option<TypeId> {
    let is_it = |ty: &Type| {
        matches!(ty.kind, TypeKind::Exception { .. })
            && ty.name.as_ref().is_some_and(|it| it.as_str() == name)
    };
    if owner.throws.iter().any(|&it| is_it(spec.ty(it))) {
        return None;
    }
    let index = spec.types.iter().position(is_it)?;
    u32::try_from(index).ok().map(TypeId)
}
