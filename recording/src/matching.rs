//! The assignment of log lines to codels of the specifications.

use dotgen_analysis::model::{Codel, CodelKind, CodelRef, Component, Owner, TaskId};
use dotgen_timing::scn::names::Names;

use crate::log::LineKind;

/// Task name of the lines of a control task.
pub const CONTROL: &str = "<control>";

/// A codel in a place of use.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Site {
    /// Component, as numbered by [`Names`].
    pub component: usize,
    pub codel: CodelRef,
    /// State in which the codel runs; `None` for codels of the control task.
    pub state: Option<String>,
}

/// The reason why a line belongs to no codel of the specifications.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mismatch {
    /// There is no such component.
    Component,
    /// The component has no such task.
    Task,
    /// Neither the service nor the task has such a state, or the service has no such codel.
    State,
    /// The codel there has another function.
    Function,
    /// The activity belongs to another task.
    WrongTask,
    /// The service has no codel: it is an attribute that is set or read.
    NoCodel,
}

/// The parts of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event<'k> {
    /// Component, if the event names one.
    pub component: Option<&'k str>,
    /// State or exception, without `pause::`.
    pub name: &'k str,
    /// The event has `pause::`.
    pub paused: bool,
}

/// Parses `::component::pause::state`.
pub fn event(text: &str) -> Event<'_> {
    let names: Vec<&str> = text.trim_start_matches("::").split("::").collect();
    match *names.as_slice() {
        [] => Event { component: None, name: "", paused: false },
        [name] => Event { component: None, name, paused: false },
        [first, .., last] => Event {
            component: Some(first),
            name: last,
            paused: names.len() > 2 && names.get(names.len() - 2) == Some(&"pause"),
        },
    }
}

/// Returns the codel of a line.
///
/// # Errors
///
/// Returns the reason if the line belongs to no codel of the specifications.
pub fn site(names: &Names<'_>, kind: &LineKind) -> Result<Site, Mismatch> {
    let from = event(&kind.from);
    let component = component(names, kind, &from).ok_or(Mismatch::Component)?;
    let Some(member) = names.components.get(component) else {
        return Err(Mismatch::Component);
    };
    let model = member.component;
    let (codel, state) = match from.component {
        Some(_) => {
            let task = model.tasks.position(|task| task.name == kind.task);
            let task = task.ok_or(Mismatch::Task)?;
            (of_machine(model, task, kind, from.name)?, Some(from.name.to_owned()))
        }
        None => (of_control(model, kind).ok_or_else(|| without(model, kind))?, None),
    };
    if model.codel(codel).name != kind.function {
        return Err(Mismatch::Function);
    }
    Ok(Site { component, codel, state })
}

/// Returns the component of a line. The event names it. For codels of the control task, it is the instance,
/// or the only component with such a codel, because a server may have been started under another name.
fn component(names: &Names<'_>, kind: &LineKind, from: &Event<'_>) -> Option<usize> {
    let all = &names.components;
    let named = |name: &str| all.iter().position(|component| component.component.name == name);
    if let Some(component) = from.component {
        return named(component);
    }
    named(&kind.instance).or_else(|| {
        let mut fitting = (0..all.len()).filter(|&component| {
            let of = all.get(component);
            of.is_some_and(|member| of_control(member.component, kind).is_some())
        });
        fitting.next().filter(|_| fitting.next().is_none())
    })
}

fn of_machine(
    component: &Component,
    task: TaskId,
    kind: &LineKind,
    state: &str,
) -> Result<CodelRef, Mismatch> {
    let service = component.services.position(|of| of.name == kind.service);
    let in_service = service.and_then(|it_is| in_state(component, Owner::Service(it_is), state));
    if let (Some(service), Some(codel)) = (service, in_service) {
        let of = component.services.get(service).and_then(|service| service.task);
        return if of == Some(task) { Ok(codel) } else { Err(Mismatch::WrongTask) };
    }
    // Recorders differ in their name for the service of a permanent activity. No service has such a name.
    match service {
        Some(_) => Err(Mismatch::State),
        None => in_state(component, Owner::Task(task), state).ok_or(Mismatch::State),
    }
}

fn in_state(component: &Component, owner: Owner, state: &str) -> Option<CodelRef> {
    let has = |codel: &Codel| {
        codel.kind == CodelKind::Fsm && codel.triggers.iter().any(|trigger| trigger.name == state)
    };
    let index = component.codels_of(owner).position(has)?;
    Some(CodelRef { owner, index })
}

fn of_control(component: &Component, kind: &LineKind) -> Option<CodelRef> {
    let service = component.services.position(|of| of.name == kind.service)?;
    let owner = Owner::Service(service);
    let validates = kind.from == "validate";
    let index = component.codels_of(owner).position(|codel| {
        let wanted = if validates { CodelKind::Validate } else { CodelKind::Simple };
        codel.kind == wanted && codel.name == kind.function
    })?;
    Some(CodelRef { owner, index })
}

/// Returns the reason why a control task executes no codel.
fn without(component: &Component, kind: &LineKind) -> Mismatch {
    let service = component.services.iter().find(|of| of.name == kind.service);
    let of = |service: &dotgen_analysis::model::Service| {
        let attribute = service.kind == dotgen_analysis::model::ServiceKind::Attribute;
        attribute && service.codels.iter().all(|codel| codel.kind == CodelKind::Validate)
    };
    if service.is_some_and(of) { Mismatch::NoCodel } else { Mismatch::State }
}

/// Returns `component.task.state`, `component.service.state` or `component.service.codel`, as in scenarios.
pub fn path(names: &Names<'_>, site: &Site) -> String {
    let Some(member) = names.components.get(site.component) else {
        return String::new();
    };
    let model = member.component;
    let last = match &site.state {
        Some(state) => state.as_str(),
        None => model.codel(site.codel).name.as_str(),
    };
    format!("{}.{}.{last}", model.name, model.owner_name(site.codel.owner))
}

/// Returns every codel of the specifications in each of its states.
pub fn sites(names: &Names<'_>) -> Vec<Site> {
    let mut out = Vec::new();
    for (component, member) in names.components.iter().enumerate() {
        for codel in member.component.all_codels() {
            let declaration = member.component.codel(codel);
            let site = |state| Site { component, codel, state };
            match declaration.kind {
                CodelKind::Fsm => {
                    let states = declaration.triggers.iter();
                    out.extend(states.map(|state| site(Some(state.name.to_string()))));
                }
                _ => out.push(site(None)),
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_have_parts() {
        let parts = |text| {
            let event = event(text);
            (event.component, event.name, event.paused)
        };
        assert_eq!(parts("::pump::start"), (Some("pump"), "start", false));
        assert_eq!(parts("::pump::pause::pause"), (Some("pump"), "pause", true));
        assert_eq!(parts("::pump::pause"), (Some("pump"), "pause", false));
        assert_eq!(parts("validate"), (None, "validate", false));
        assert_eq!(parts("::genom::ok"), (Some("genom"), "ok", false));
        assert_eq!(parts(""), (None, "", false));
    }
}
