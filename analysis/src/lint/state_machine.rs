//! Rules about state machines that are legal but suspicious.

use typed_index_collections::{TiVec, ti_vec};

use crate::finding::role::Role;
use crate::finding::{
    Severity,
    lints::{CyclePath, LintWarning, ListedNames},
};
use crate::model::fsm::Machine;
use crate::model::{
    Component, Name, Owner, ParamDir, ParamSource, ServiceId, ServiceKind, Src, State,
};

use super::Lint;

pub(super) fn check(lint: &mut Lint) {
    let interrupters = interrupters(lint.component);
    for owner in lint.component.owners() {
        let machine = Machine::new(lint.component.codels_of(owner));
        if !machine.is_empty() {
            loops(lint, owner, &machine);
            dead_ends(lint, &machine);
        }
        if let Owner::Service(index) = owner
            && let Some(by) = interrupters[index]
        {
            missing_stop(lint, index, by);
        }
    }
    pause_in_aperiodic_task(lint);
    names_of_events(lint);
}

/// `fsm/codel-named-as-event`: in C the mapping defines `COMPONENT_state` and `COMPONENT_pause_state`, so no
/// function can have that name. In C++ they are in the component's namespace.
fn names_of_events(lint: &mut Lint) {
    let component = lint.component;
    if component.lang.as_deref().is_some_and(|language| language != "c") {
        return;
    }
    let prefix = format!("{}_", component.name);
    let codels = || component.all_codels().map(|codel| component.codel(codel));
    let states = || codels().flat_map(|codel| codel.triggers.iter().chain(&codel.yields));
    // The state whose event has a name.
    let event = |name: &str| -> Option<Name> {
        let rest = name.strip_prefix(&prefix)?;
        let (paused, state) = match rest.strip_prefix("pause_") {
            Some(state) => (true, state),
            None => (false, rest),
        };
        let same = |other: &State| {
            other.name == rest && !other.paused || paused && other.paused && other.name == state
        };
        // Every machine ends in `ether`, even if it is not written.
        let ether = || (rest == "ether").then(|| Name::from(rest));
        states().find(|state| same(state)).map(|state| state.name.clone()).or_else(ether)
    };
    let mut found: Vec<(Src, LintWarning)> = Vec::new();
    for at in component.all_codels() {
        let codel = component.codel(at);
        if let Some(state) = event(&codel.name) {
            let owner = component.owner_name(at.owner);
            let mut free = format!("{prefix}{owner}_{}", &codel.name[prefix.len()..]);
            while event(&free).is_some() || codels().any(|other| *other.name == *free) {
                free.push('_');
            }
            let (codel_name, free) = (codel.name.clone(), free.into());
            found.push((codel.src, LintWarning::NamedAsEvent { codel: codel_name, state, free }));
        }
    }
    for (at, warning) in found {
        lint.report(at, warning);
    }
}

/// `fsm/busy-loop` and `fsm/no-termination`: cycles without `pause::`.
fn loops(lint: &mut Lint, owner: Owner, machine: &Machine) {
    let cycles = machine.cycles_without_pause();
    let ends = machine.reachable("start").contains("ether");
    let throws = match owner {
        Owner::Task(i) => !lint.component.tasks[i].throws.is_empty(),
        Owner::Service(i) => !lint.component.services[i].throws.is_empty(),
    } || !lint.component.throws.is_empty();
    let is_activity = matches!(owner, Owner::Service(_));
    let periodic = lint.period_of(owner).is_some();
    for cycle in cycles {
        let first = machine.at(cycle[0]);
        let names: Vec<Name> = cycle
            .iter()
            .filter_map(|&v| Some(machine.at(v).triggers.first()?.name.clone()))
            .collect();
        let Some(closing) = names.first().cloned() else {
            continue;
        };
        let round = CyclePath(names);
        let at = first.triggers.first().map_or(first.src, |s| s.src);
        let owner = lint.owner_name(owner);
        let never_ends = is_activity && !ends && !throws && machine.position("start").is_some();
        let found = if never_ends {
            lint.report(at, LintWarning::NoTermination { owner, round, closing })
        } else {
            let cost = if periodic {
                "within one period it can go round any number of times, so its execution time has no bound"
            } else {
                "the task can be kept busy by it for any time"
            };
            lint.report(at, LintWarning::BusyLoop { owner, round, cost, closing })
        };
        if !periodic && !never_ends {
            found.severity = Severity::Hint;
        }
        let next = cycle.iter().cycle().skip(1);
        for (&v, &to) in cycle.iter().zip(next) {
            let codel = machine.at(v);
            if let Some(state) =
                codel.yields.iter().find(|s| !s.paused && machine.position(&s.name) == Some(to))
            {
                found.related.push((
                    state.src,
                    Role::Yields { codel: codel.name.clone(), state: state.name.clone() },
                ));
            }
        }
    }
}

/// `fsm/pause-in-aperiodic-task`: once for each task in which nothing ever ends the pause. A pause ends with
/// an internal event: a request for a service, or a transition of another task.
fn pause_in_aperiodic_task(lint: &mut Lint) {
    let with_codels = lint.component.tasks.iter();
    let with_codels = with_codels.filter(|codel| !codel.codels.is_empty()).count();
    if !lint.component.services.is_empty() || with_codels > 1 {
        return;
    }
    for task in &lint.component.tasks {
        if task.period.is_some() {
            continue;
        }
        let yields = task.codels.iter().flat_map(|c| &c.yields);
        let paused: Vec<&State> = yields.filter(|s| s.paused).collect();
        let Some(&first) = paused.first() else {
            continue;
        };
        let (at, name) = (first.src, &first.name);
        let found = lint.report(
            at,
            LintWarning::AperiodicPause { task: task.name.clone(), state: name.clone() },
        );
        found.related.push((task.src, Role::NoPeriod));
        let others = paused[1..].iter().map(|s| (s.src, Role::PauseToo(s.name.clone())));
        found.related.extend(others);
    }
}

/// `fsm/dead-end`: several successors, none of which exists. A single undefined successor has its own
/// finding.
fn dead_ends(lint: &mut Lint, machine: &Machine) {
    for (_, codel) in &machine.codels {
        let undefined = |name: &str| name != "ether" && machine.position(name).is_none();
        if codel.yields.len() > 1 && codel.yields.iter().all(|s| undefined(&s.name)) {
            let names = codel.yields.iter().map(|s| s.name.clone()).collect();
            let at = codel.triggers.first().map_or(codel.src, |s| s.src);
            lint.report(
                at,
                LintWarning::DeadEnd { codel: codel.name.clone(), states: ListedNames(names) },
            );
        }
    }
}

/// For each service, the first one that interrupts it.
fn interrupters(component: &Component) -> TiVec<ServiceId, Option<ServiceId>> {
    let services = &component.services;
    let of_all = services.iter_enumerated().find(|(_, service)| service.interrupts.all);
    let mut first = ti_vec![of_all.map(|(by, _)| by); services.len()];
    for (by, service) in services.iter_enumerated() {
        for &service in &service.interrupts.services {
            if let Some(first) = first.get_mut(service) {
                *first = Some(first.map_or(by, |number| number.min(by)));
            }
        }
    }
    first
}

/// `fsm/missing-stop`: an activity that others interrupt and that changes data.
fn missing_stop(lint: &mut Lint, index: ServiceId, by: ServiceId) {
    let component = lint.component;
    let service = &component.services[index];
    if service.kind != ServiceKind::Activity
        || service.codels.iter().flat_map(|c| &c.triggers).any(|s| s.name == "stop")
    {
        return;
    }
    let interrupter = &component.services[by];
    // One codel that ends at once leaves no partial change.
    let steps = service.codels.iter().filter(|c| !c.triggers.is_empty()).count();
    let pauses = service.codels.iter().flat_map(|c| &c.yields).any(|s| s.paused);
    if steps < 2 && !pauses {
        return;
    }
    let written = service.codels.iter().flat_map(|c| &c.params).find(|p| {
        matches!(p.dir, ParamDir::Out | ParamDir::Inout)
            && matches!(p.source, ParamSource::Ids | ParamSource::Port(_))
    });
    if let Some(param) = written {
        let what = if matches!(param.source, ParamSource::Ids) { "ids" } else { "port" };
        let (name, by) = (&service.name, &interrupter.name);
        let (param_name, param_src, by_src) = (param.name.clone(), param.src, interrupter.src);
        let found = lint.report(
            service.src,
            LintWarning::MissingStop {
                name: name.clone(),
                by: by.clone(),
                what,
                param: param_name,
            },
        );
        found.related.push((param_src, Role::Written));
        found.related.push((by_src, Role::Interrupting));
    }
}
