//! Components and ports by the names that clients write.

use dotgen_analysis::model::PortDir;

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
        format!(
            "there is no component `{name}`; there are {}",
            names.join(", ")
        )
    })
}

pub(super) fn port(shared: &Shared, path: &str) -> Result<(usize, u32), String> {
    let (name, port) = path.split_once('/').ok_or("write COMPONENT/PORT")?;
    let at = component(shared, name)?;
    let ports = &shared.known[&at].component().ports;
    let found = (0u32..)
        .zip(ports)
        .find(|(_, it)| it.name == port && it.dir == PortDir::Out);
    let names = || {
        let outputs = ports.iter().filter(|it| it.dir == PortDir::Out);
        outputs
            .map(|it| it.name.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    match found {
        Some((port, _)) => Ok((at, port)),
        None => Err(format!(
            "`{name}` has no output port `{port}`; it has {}",
            names()
        )),
    }
}
