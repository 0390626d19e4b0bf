//! Components and ports by the names that clients write.

use dotgen_analysis::model::PortDir;
use dotgen_syntax::near::advice;

use super::Shared;

pub(super) fn component(shared: &Shared, name: &str) -> Result<usize, String> {
    let mut all = shared.known.iter();
    let found = all.find(|(_, it)| it.component().name == name);
    found.map(|it| *it.0).ok_or_else(|| {
        let names: Vec<&str> = shared
            .known
            .values()
            .map(|it| it.component().name.as_str())
            .collect();
        missing("the run", "component", name, &names)
    })
}

pub(super) fn port(shared: &Shared, path: &str) -> Result<(usize, u32), String> {
    let (name, port) = path.split_once('/').ok_or("write COMPONENT/PORT")?;
    let at = component(shared, name)?;
    let ports = &shared.known[&at].component().ports;
    let found = (0u32..)
        .zip(ports)
        .find(|(_, it)| it.name == port && it.dir == PortDir::Out);
    found.map(|(port, _)| (at, port)).ok_or_else(|| {
        let outputs = ports.iter().filter(|it| it.dir == PortDir::Out);
        let outputs: Vec<&str> = outputs.map(|it| it.name.as_str()).collect();
        missing(&format!("`{name}`"), "output port", port, &outputs)
    })
}

/// The message for a name that is not among those of a kind: the name that is near, or else all names.
pub(super) fn missing(owner: &str, kind: &str, name: &str, all: &[&str]) -> String {
    format!("{owner} has no {kind} `{name}`; {}", advice(name, all))
}
