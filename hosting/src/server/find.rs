//! Components and ports by the names that clients write.

use dotgen_analysis::model::{PortDir, PortId};
use dotgen_syntax::suggestion::advice;

use super::Shared;
use dotgen_timing::system::ComponentId;

pub(super) fn component(shared: &Shared, name: &str) -> Result<ComponentId, String> {
    let mut all = shared.known.iter();
    let found = all.find(|(_, component)| component.component().name == name);
    found.map(|(id, _)| *id).ok_or_else(|| {
        let names: Vec<&str> =
            shared.known.values().map(|component| component.component().name.as_str()).collect();
        missing("the run", "component", name, &names)
    })
}

/// Finds an output port. Returns its component, and its number in the component.
pub(super) fn output(shared: &Shared, path: &str) -> Result<(ComponentId, PortId), String> {
    port(shared, path, PortDir::Out)
}

/// Finds an input port. Returns its component, and its number in the component.
pub(super) fn input(shared: &Shared, path: &str) -> Result<(ComponentId, PortId), String> {
    port(shared, path, PortDir::In)
}

fn port(shared: &Shared, path: &str, dir: PortDir) -> Result<(ComponentId, PortId), String> {
    let (name, port) = path.split_once('/').ok_or("write COMPONENT/PORT")?;
    let at = component(shared, name)?;
    let ports = &shared.known[&at].component().ports;
    let mut all = ports.iter_enumerated();
    let found = all.find(|(_, candidate)| candidate.name == port && candidate.dir == dir);
    found.map(|(port, _)| (at, port)).ok_or_else(|| {
        if dir == PortDir::In && ports.iter().any(|candidate| candidate.name == port) {
            return format!("`{path}` is an output port: only codels of `{name}` write it");
        }
        let kind = match dir {
            PortDir::In => "input port",
            PortDir::Out => "output port",
        };
        let others = ports.iter().filter(|port| port.dir == dir);
        let others: Vec<&str> = others.map(|port| port.name.as_str()).collect();
        missing(&format!("`{name}`"), kind, port, &others)
    })
}

/// Returns the message for an unknown name of a kind, with a similar name, or else all names.
pub(super) fn missing(owner: &str, kind: &str, name: &str, all: &[&str]) -> String {
    format!("{owner} has no {kind} `{name}`; {}", advice(name, all))
}
