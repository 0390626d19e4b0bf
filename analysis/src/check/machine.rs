//! State machines (language reference, section 13).

use std::collections::BTreeMap;

use crate::finding::role::Role;
use smol_str::SmolStr;
use smol_str::format_smolstr;

use crate::{
    finding::{Finding, Near, codels::CodelProblem},
    model::{
        Codel, Component, ComponentKind, Name, OwnerName, Spec, Src, State, Type, TypeId, TypeKind,
        fsm::Machine,
    },
};

/// The task or activity a machine belongs to.
struct Owner<'a> {
    what: &'static str,
    name: &'a Name,
    src: Src,
    throws: &'a [TypeId],
}

impl Owner<'_> {
    fn name(&self) -> OwnerName {
        OwnerName { kind: self.what, name: self.name.clone() }
    }
}

pub(super) fn check(spec: &Spec, component: &Component, found: &mut Vec<Finding>) {
    // Interfaces may leave their machines to be completed by importing components.
    if component.kind != ComponentKind::Component {
        return;
    }
    for task in &component.tasks {
        let owner = Owner { what: "task", name: &task.name, src: task.src, throws: &task.throws };
        check_machine(spec, &owner, &Machine::new(&task.codels), found);
    }
    for service in &component.services {
        let owner = Owner {
            what: "activity",
            name: &service.name,
            src: service.src,
            throws: &service.throws,
        };
        check_machine(spec, &owner, &Machine::new(&service.codels), found);
    }
}

fn check_machine(spec: &Spec, owner: &Owner<'_>, machine: &Machine<'_>, found: &mut Vec<Finding>) {
    if machine.is_empty() {
        return;
    }
    // Without its yields, which is a syntax error, the reachable states are unknown.
    let complete = machine.codels.iter().all(|(_, codel)| !codel.yields.is_empty());
    let mut reached = machine.reachable("start");
    let from_stop = machine.reachable("stop");
    // With a codel of its own, `ether` is a state like any other, and the machine has no end.
    let ends = from_stop.contains("ether") && machine.codel("ether").is_none();
    if let Some((_, stop)) = machine.codel("stop")
        && complete
        && !ends
    {
        found.push(Finding::new(CodelProblem::StopWithoutEther { owner: owner.name() }, stop.src));
    }
    reached.extend(from_stop);
    let misnamed = misnamed(machine);
    for (&(state, src), used) in &misnamed {
        let kind = CodelProblem::Misnamed { state: state.clone(), owner: owner.name() };
        found.push(Finding::new(kind, src).near(Some(Near::new(src, used))));
    }
    let is_misnamed = |codel: &Codel| {
        let mut triggers = codel.triggers.iter();
        triggers.any(|trigger| misnamed.contains_key(&(&trigger.name, trigger.src)))
    };
    let before = std::iter::once(None).chain(machine.codels.iter().map(|codel| Some(codel.1)));
    for ((_, codel), before) in machine.codels.iter().zip(before) {
        let mut triggers = codel.triggers.iter();
        if triggers.any(|trigger| reached.contains(trigger.name.as_str())) {
            check_transitions(spec, owner, machine, &misnamed, codel, found);
        } else if complete && !is_misnamed(codel) {
            found.extend(unreachable(owner, machine, codel, before));
        }
    }
}

/// The finding for a codel that no transition leads to. The codel before it is the first candidate for one.
fn unreachable(
    owner: &Owner<'_>,
    machine: &Machine<'_>,
    codel: &Codel,
    before: Option<&Codel>,
) -> Option<Finding> {
    let state = codel.triggers.first()?;
    let in_cycle = before.is_some_and(|before| {
        let is_before = |name: &str| before.triggers.iter().any(|s| s.name == name);
        machine.reaches_without_pause(&state.name, is_before)
    });
    let kind =
        CodelProblem::Unreachable { state: state.name.clone(), owner: owner.name(), in_cycle };
    Some(Finding::new(kind, codel.src).related(owner.src, Role::Owner(owner.what)))
}

/// Checks the states of a reachable codel: its own, and those that it yields.
fn check_transitions(
    spec: &Spec,
    owner: &Owner<'_>,
    machine: &Machine<'_>,
    misnamed: &Misnamed<'_>,
    codel: &Codel,
    found: &mut Vec<Finding>,
) {
    let mut triggers = codel.triggers.iter();
    if let Some(ether) = triggers.find(|trigger| trigger.name == "ether") {
        found.push(Finding::new(CodelProblem::EtherCodel, ether.src));
    }
    let mut missing: Vec<&Name> = Vec::new();
    for state in &codel.yields {
        if state.name == "ether"
            || machine.codel(&state.name).is_some()
            || misnamed.values().any(|name| **name == state.name)
            || missing.contains(&&state.name)
        {
            continue;
        }
        missing.push(&state.name);
        found.push(match thrown_elsewhere(spec, owner, &state.name) {
            Some(exception) => {
                let kind = CodelProblem::UndeclaredThrow {
                    codel: codel.name.clone(),
                    state: state.name.clone(),
                    owner: owner.name(),
                    exception: spec
                        .full_name(exception)
                        .map_or_else(|| state.name.clone(), Into::into),
                };
                Finding::new(kind, state.src).related(owner.src, Role::Owner(owner.what))
            }
            None => undefined(owner, machine, codel, state),
        });
    }
}

/// The finding for a yielded state without codel, with the state of the most similar name.
fn undefined(owner: &Owner<'_>, machine: &Machine<'_>, codel: &Codel, state: &State) -> Finding {
    if let ("pause", false, Some(own)) = (&*state.name, state.paused, codel.triggers.first()) {
        let text = format_smolstr!("pause::{}", own.name);
        let near = Near { at: state.src, name: text.clone(), text, plain: false };
        return Finding::new(CodelProblem::PauseAlone, state.src)
            .related(codel.src, Role::Codel)
            .near(Some(near));
    }
    let states = machine.states().map(SmolStr::as_str);
    let near = dotgen_syntax::suggestion::nearest(&state.name, states.chain(["ether"]));
    let near = near.map(|name| {
        let pause = if state.paused { "pause::" } else { "" };
        Near {
            at: state.src,
            name: name.into(),
            text: format_smolstr!("{pause}{name}"),
            plain: false,
        }
    });
    let kind = CodelProblem::Undefined {
        codel: codel.name.clone(),
        state: state.name.clone(),
        owner: owner.name(),
    };
    Finding::new(kind, state.src).related(codel.src, Role::Codel).compiler_at(codel.src).near(near)
}

/// States of unreachable codels, each with a similarly named state that several transitions lead to and that
/// has no codel: the name of the former is misspelt.
type Misnamed<'m> = BTreeMap<(&'m Name, Src), &'m Name>;

fn misnamed<'m>(machine: &Machine<'m>) -> Misnamed<'m> {
    let used: Vec<&Name> = machine
        .codels
        .iter()
        .flat_map(|(_, codel)| codel.yields.iter().map(|state| &state.name))
        .collect();
    let given = |name: &str| matches!(name, "start" | "stop" | "ether");
    let is_often_used = |name: &&Name| used.iter().filter(|other| *other == name).count() > 1;
    let undefined = || {
        let used = used.iter().copied();
        used.filter(|name| !given(name) && machine.codel(name).is_none()).filter(is_often_used)
    };
    let mut out = BTreeMap::new();
    for state in machine.codels.iter().flat_map(|(_, codel)| &codel.triggers) {
        if given(&state.name) || used.contains(&&state.name) {
            continue;
        }
        let near = dotgen_syntax::suggestion::nearest(&state.name, undefined().map(Name::as_str));
        if let Some(meant) = undefined().find(|text| Some(text.as_str()) == near) {
            out.insert((&state.name, state.src), meant);
        }
    }
    out
}

/// The exception of this name, if there is one and the owner does not declare it in its `throws`.
fn thrown_elsewhere(spec: &Spec, owner: &Owner<'_>, name: &str) -> Option<TypeId> {
    let is_it = |ty: &Type| {
        matches!(ty.kind, TypeKind::Exception { .. })
            && ty.name.as_ref().is_some_and(|text| text.as_str() == name)
    };
    if owner.throws.iter().any(|&exception| is_it(spec.ty(exception))) {
        return None;
    }
    spec.types.position(is_it)
}
