//! A run that listens: the socket, and what is known of the components there.

use std::collections::BTreeMap;

use anyhow::Context;
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::Prepared;
use std::os::unix::fs::DirBuilderExt as _;

use super::Arguments;
use crate::cli::report;
use crate::hosting::children::Children;
use crate::hosting::known::Known;
use crate::hosting::places;
use crate::hosting::server::{Server, listen};
use crate::verification::Problem;

/// Listens for whoever wants something of a run.
pub(super) fn start(
    arguments: &Arguments,
    problem: &Problem,
    names: &Names<'_>,
    prepared: &Prepared,
    children: &mut Children,
) -> anyhow::Result<Server> {
    let path = match &arguments.socket {
        Some(path) => {
            let folder = path.parent().filter(|it| !it.as_str().is_empty());
            if let Some(folder) = folder.filter(|it| !it.exists()) {
                let made = std::fs::DirBuilder::new().mode(0o700).create(folder);
                made.with_context(|| format!("cannot make the folder `{folder}` for the socket"))?;
            }
            path.clone().into_std_path_buf()
        }
        None => {
            let name = problem.path.file_stem().unwrap_or("run");
            places::socket(name)?
        }
    };
    let built = &prepared.built;
    let mut known: BTreeMap<usize, Known> = BTreeMap::new();
    for (name, member) in names.components.iter().enumerate() {
        let Some(&at) = built.components.get(&name) else {
            continue;
        };
        let spec = problem.units[member.spec_index].spec.clone();
        let mut all = (0u32..).zip(&spec.components);
        let Some((component, _)) = all.find(|it| it.1.name == member.component.name) else {
            continue;
        };
        let count = member.component.services.len() as u32;
        let services = (0..count).map(|it| built.services.get(&(name, it)).copied());
        let known_here = Known {
            services: services.collect(),
            component,
            spec,
        };
        known.insert(at, known_here);
    }
    let (server, outside) = listen(&path, known, children.door()).map_err(anyhow::Error::msg)?;
    children.tell(outside);
    if let Some(port) = arguments.listen {
        let address = server
            .listen_on_loopback(port)
            .map_err(anyhow::Error::msg)?;
        report::note(&format!("for all users of this machine at {address}"));
    }
    report::note(&format!("listening at `{}`", path.display()));
    Ok(server)
}
