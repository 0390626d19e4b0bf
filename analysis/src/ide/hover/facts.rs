//! Facts from the model about a task, service, codel or state beyond its declaration: callers, transitions,
//! exclusions, loads.

use crate::{
    elab::{DefKind, Definition, Elaborated},
    model::{
        Codel, CodelKind, CodelRef, Component, Owner, OwnerName, Seconds, ServiceList, Spec, State,
        fsm::Machine,
        mutex::{self, Excluded},
        system,
    },
    quantity,
};

/// Maximum number of names in a hover.
const MANY: usize = 6;

/// A fact, and the task or service that it is about.
struct Fact {
    owner: Option<Owner>,
    text: String,
}

impl Fact {
    fn new(text: String) -> Fact {
        Fact { owner: None, text }
    }
}

/// A Markdown list, if there are facts. Facts about `owner`, a task or a service by name, come first.
pub(super) fn facts(
    elaborated: &Elaborated,
    definition: &Definition,
    owner: Option<(bool, &str)>,
) -> Option<String> {
    let spec = &elaborated.spec;
    let component = component_of(elaborated, definition)?;
    let mut lines = match definition.kind {
        DefKind::Task => task(component, &definition.name),
        DefKind::Function | DefKind::Activity | DefKind::Attribute => {
            service(component, &definition.name)
        }
        DefKind::Codel => codel(spec, component, &definition.name),
        DefKind::State => state(component, &definition.name),
        _ => Vec::new(),
    };
    if let Some((is_task, name)) = owner {
        let is_it = |owner: Owner| {
            matches!(owner, Owner::Task(_)) == is_task && *component.owner_name(owner) == name
        };
        lines.sort_by_key(|line| !line.owner.is_some_and(is_it));
    }
    list(&lines)
}

/// Facts about a service in a component.
pub(super) fn of_service(component: &Component, name: &str) -> Option<String> {
    list(&service(component, name))
}

fn list(lines: &[Fact]) -> Option<String> {
    let lines: Vec<String> = lines.iter().map(|line| format!("* {}", line.text)).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// The component or interface of an entity. A codel is a function: it belongs to any component that declares
/// it there.
pub(super) fn component_of<'e>(
    elaborated: &'e Elaborated,
    definition: &Definition,
) -> Option<&'e Component> {
    let spec = &elaborated.spec;
    if definition.kind == DefKind::Codel {
        let has = |component: &&Component, exactly: bool| {
            let mut codels = component.all_codels().map(|at| component.codel(at));
            codels.any(|codel| {
                codel.name == definition.name && (!exactly || codel.src == definition.src)
            })
        };
        let mut all = spec.components.iter();
        return all
            .find(|component| has(component, true))
            .or_else(|| spec.components.iter().find(|component| has(component, false)));
    }
    let container = elaborated.definitions.get(definition.container?)?;
    spec.components.iter().find(|c| c.name == container.name)
}

fn task(component: &Component, name: &str) -> Vec<Fact> {
    let mut out = Vec::new();
    let Some((index, task)) =
        component.tasks.iter_enumerated().find(|(_, number)| number.name.as_str() == name)
    else {
        return out;
    };
    if let (Some(share), Some(period)) = (component.utilisation(index), &task.period) {
        out.push(Fact::new(format!(
            "load {} of {}",
            quantity::load(share),
            quantity::time(period.value)
        )));
    }
    let services = component.services.iter();
    let services = services.filter(|service| service.task == Some(index));
    let names: Vec<String> = services.map(|service| format!("`{}`", service.name)).collect();
    if !names.is_empty() {
        out.push(Fact::new(format!("runs {}", listed(&names))));
    }
    out
}

fn service(component: &Component, name: &str) -> Vec<Fact> {
    let index = component
        .services
        .iter_enumerated()
        .find_map(|(index, service)| (service.name.as_str() == name).then_some(index));
    let names_it =
        |list: &ServiceList| list.all || index.is_some_and(|it| list.services.contains(&it));
    let by = component.services.iter();
    let by = by.filter(|service| names_it(&service.interrupts));
    let by: Vec<String> = by.map(|service| format!("`{}`", service.name)).collect();
    if by.is_empty() {
        Vec::new()
    } else {
        vec![Fact::new(format!("interrupted by {}", listed(&by)))]
    }
}

fn codel(spec: &Spec, component: &Component, name: &str) -> Vec<Fact> {
    let mut out = Vec::new();
    let uses = component.all_codels();
    for usage in uses.filter(|usage| component.codel(*usage).name.as_str() == name) {
        let codel = component.codel(usage);
        let owner = OwnerName::of(component, usage.owner);
        let about = |text| Fact { owner: Some(usage.owner), text };
        if codel.kind == CodelKind::Fsm {
            let machine = Machine::new(component.codels_of(usage.owner));
            out.push(about(format!("{owner}: {}", callers(&machine, codel))));
        } else {
            let word = if codel.kind == CodelKind::Validate {
                "validates the parameters"
            } else {
                "run by the control task"
            };
            out.push(about(format!("{owner}: {word}")));
        }
        if let (Some(wcet), Some(task)) = (&codel.wcet, component.task_of(usage))
            && let Some(period) = &component.tasks[task].period
            && period.value > Seconds::from_integer(0)
        {
            out.push(about(format!(
                "at most {}, {} of the period of {}",
                quantity::time(wcet.value),
                quantity::load(wcet.value / period.value),
                quantity::time(period.value)
            )));
        }
        out.extend(exclusions(spec, component, usage).into_iter().map(about));
    }
    out.dedup_by(|a, b| a.text == b.text);
    out
}

/// The codels from which a codel is reached.
fn callers(machine: &Machine<'_>, codel: &Codel) -> String {
    let mut from: Vec<String> = Vec::new();
    for (_, other) in &machine.codels {
        for state in &other.yields {
            if codel.triggers.iter().any(|trigger| trigger.name == state.name) {
                let paused = if state.paused { ", after a pause" } else { "" };
                let text = format!("`{}`{paused}", other.name);
                if !from.contains(&text) {
                    from.push(text);
                }
            }
        }
    }
    for (state, text) in [("start", "the start"), ("stop", "an interruption")] {
        if codel.triggers.iter().any(|trigger| trigger.name == state) {
            from.insert(0, text.to_owned());
        }
    }
    if from.is_empty() {
        "called from nowhere".to_owned()
    } else {
        format!("called from {}", listed(&from))
    }
}

/// The codels that a codel excludes, by the data they share: `excludes 2 through x of the ids: f, g`.
fn exclusions(spec: &Spec, component: &Component, codel: CodelRef) -> Vec<String> {
    let mut groups: Vec<(Option<String>, Vec<String>)> = Vec::new();
    for exclusion in mutex::exclusions(spec, component, codel) {
        let name = match exclusion.with {
            Excluded::Codel(other) => format!("`{}`", component.codel(other).name),
            Excluded::Service(other) => {
                format!("attribute `{}`", component.services[other].name)
            }
        };
        // Counted once, as in lenses.
        if groups.iter().any(|group| group.1.contains(&name)) {
            continue;
        }
        let through = exclusion.through.first();
        let through = through.map(|through| through.shared.describe(component).to_string());
        let group = match groups.iter_mut().find(|group| group.0 == through) {
            Some(group) => group,
            None => groups.push_mut((through, Vec::new())),
        };
        group.1.push(name);
    }
    groups
        .into_iter()
        .map(|(through, names)| {
            let through = through.map(|through| format!(" through {through}")).unwrap_or_default();
            match names.as_slice() {
                [name] => format!("excludes {name}{through}"),
                _ => format!("excludes {}{through}: {}", names.len(), listed(&names)),
            }
        })
        .collect()
}

fn state(component: &Component, name: &str) -> Vec<Fact> {
    let mut out = Vec::new();
    for owner_index in component.owners() {
        let machine = Machine::new(component.codels_of(owner_index));
        let yielding = machine
            .codels
            .iter()
            .filter(|(_, codel)| codel.yields.iter().any(|state| state.name == name));
        let from: Vec<String> = yielding.map(|(_, codel)| format!("`{}`", codel.name)).collect();
        let codel = machine.codel(name);
        if from.is_empty() && codel.is_none() {
            continue;
        }
        let mut line = OwnerName::of(component, owner_index).to_string();
        if !from.is_empty() {
            line += &format!(": from {}", listed(&from));
        }
        if let Some((_, codel)) = codel {
            let to: Vec<String> = codel.yields.iter().map(state_text).collect();
            line += &format!(" → `{}` → {}", codel.name, listed(&to));
        }
        out.push(Fact { owner: Some(owner_index), text: line });
    }
    out
}

fn state_text(state: &State) -> String {
    if state.paused { format!("`pause::{}`", state.name) } else { format!("`{}`", state.name) }
}

fn listed(names: &[String]) -> String {
    system::listed(names, MANY)
}
