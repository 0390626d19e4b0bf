//! The server of a run: the socket, other machines, and the descriptions of components.

use std::collections::BTreeMap;

use anyhow::Context;
use camino::Utf8Path;
use dotgen_analysis::model::{PortDir, PortId};
use dotgen_runtime::live::HostedComponents;
use dotgen_timing::scn::names::Names;
use dotgen_timing::verify::Prepared;
use std::os::unix::fs::DirBuilderExt as _;

use super::Arguments;
use super::params::Params;
use crate::report;
#[cfg(feature = "zenoh")]
use crate::session::{ConfigProblems, Session, told_rules};
use dotgen_hosting::children::Children;
use dotgen_hosting::components::KnownComponent;
#[cfg(feature = "zenoh")]
use dotgen_hosting::network::Network;
use dotgen_hosting::remote::RemoteComponents;
use dotgen_hosting::server::{Clients, Server, listen};
use dotgen_hosting::sockets;
#[cfg(feature = "zenoh")]
use dotgen_ros2::conversion::{self, Conversions};
use dotgen_timing::system::ComponentId;
use dotgen_views::verification::Problem;

/// The server. Dropping it ends all connections.
pub(super) struct RunServer {
    pub(super) server: Server,
    #[cfg(feature = "zenoh")]
    _network: Option<Network>,
}

/// Starts the server.
pub(super) fn start(
    arguments: &Arguments,
    #[cfg(feature = "zenoh")] session: &Session,
    problem: &Problem,
    names: &Names<'_>,
    prepared: &Prepared,
    parts: &HostedComponents<'_>,
    children: &mut Children,
) -> anyhow::Result<RunServer> {
    let path = if let Some(path) = &arguments.socket {
        let folder = path.parent().filter(|parent| !parent.as_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.exists()) {
            let made = std::fs::DirBuilder::new().mode(0o700).create(folder);
            made.with_context(|| format!("cannot make the folder `{folder}` for the socket"))?;
        }
        path.clone().into_std_path_buf()
    } else {
        let name = problem.path.file_stem().unwrap_or("run");
        sockets::socket(name)?
    };
    let params = arguments.params.as_ref();
    let params = params.map(|path| Params::read(path, names)).transpose()?;
    let built = &prepared.built;
    let mut known: BTreeMap<ComponentId, KnownComponent> = BTreeMap::new();
    for (name, member) in names.components.iter().enumerate() {
        let Some(&at) = built.components.get(&name) else {
            continue;
        };
        let spec = problem.units[member.spec_index].spec.clone();
        let mut all = spec.components.iter_enumerated();
        let Some((component, _)) = all.find(|(_, of)| of.name == member.component.name) else {
            continue;
        };
        let services = member.component.services.keys();
        let services = services.map(|service| built.services.get(&(name, service)).copied());
        let known_here = KnownComponent {
            services: services.collect(),
            executed: parts.of(at).is_some(),
            component,
            spec,
        };
        known.insert(at, known_here);
    }
    let remote = RemoteComponents::default();
    #[cfg(feature = "zenoh")]
    let network = join(arguments, session, &known, parts, children, &remote)?;
    #[cfg(not(feature = "zenoh"))]
    if arguments.has_network() || arguments.ros2 {
        anyhow::bail!(crate::report::NO_ZENOH);
    }
    let hint = hint(&known, arguments.socket.as_deref());
    let (feeds, inbox) = (parts.feeds.clone(), children.inbox());
    let (mut server, outside) =
        listen(&path, known, feeds, inbox, remote).map_err(anyhow::Error::msg)?;
    children.subscribe(outside);
    if let Some(port) = arguments.listen {
        let clients = if arguments.listen_anyone { Clients::Anyone } else { Clients::OfThisUser };
        let (address, token) =
            server.listen_on_loopback(port, clients).map_err(anyhow::Error::msg)?;
        report::note(&match token {
            Some(file) => format!("listening at {address}, with the token in `{}`", file.display()),
            None => format!("listening at {address}, for all users of this machine"),
        });
    }
    report::note(&format!("listening at `{}`", path.display()));
    report::note(&hint);
    if let Some(params) = params {
        params.set_at(path);
    }
    Ok(RunServer {
        server,
        #[cfg(feature = "zenoh")]
        _network: network,
    })
}

/// Returns how to call a service, to watch a port and to stop the run.
fn hint(known: &BTreeMap<ComponentId, KnownComponent>, socket: Option<&Utf8Path>) -> String {
    let socket = socket.map_or(String::new(), |path| format!("--socket {path} "));
    let components = || known.values().map(KnownComponent::component);
    let service = components().find_map(|component| {
        let service = component.services.first()?;
        Some(format!("`dotgen call {socket}{} {}` calls a service", component.name, service.name))
    });
    let port = components().find_map(|component| {
        let port = component.ports.iter().find(|port| port.dir == PortDir::Out)?;
        Some(format!("`dotgen watch {socket}{}/{}` prints a port", component.name, port.name))
    });
    let hints = service.into_iter().chain(port).chain(["Ctrl-C ends the run".to_owned()]);
    hints.collect::<Vec<_>>().join("; ")
}

/// Connects to ROS 2, or to other machines if endpoints are given.
#[cfg(feature = "zenoh")]
fn join(
    arguments: &Arguments,
    session: &Session,
    known: &BTreeMap<ComponentId, KnownComponent>,
    parts: &HostedComponents<'_>,
    children: &mut Children,
    remote: &RemoteComponents,
) -> anyhow::Result<Option<Network>> {
    use dotgen_hosting::network::{self, NetworkOptions};

    let is_fed = |component, port| {
        let mut feeds = parts.feeds.iter();
        feeds.any(|flow| flow.to == (component, port))
    };
    let tell: network::Notifier = std::sync::Arc::new(|what: &str| report::note(what));
    if arguments.ros2 {
        use dotgen_hosting::ros2::{self, Ros2Options};
        let wanted = Ros2Options {
            listen: &arguments.zenoh_listen,
            connect: &arguments.zenoh_connect,
            domain: arguments.ros_domain()?,
            conversions: &conversions(session, known).map_err(anyhow::Error::msg)?,
            remaps: &arguments.remaps,
        };
        let outside = ros2::join(wanted, known, &is_fed, &children.inbox(), &tell);
        children.subscribe(outside.map_err(anyhow::Error::msg)?);
        return Ok(None);
    }
    if !arguments.has_network() {
        return Ok(None);
    }
    let mut reads = Vec::new();
    for name in &arguments.zenoh_reads {
        reads.push(read(name, known)?);
    }
    let wanted = NetworkOptions {
        listen: &arguments.zenoh_listen,
        connect: &arguments.zenoh_connect,
        reads: &reads,
        remote,
    };
    let joined = network::join(wanted, known, &is_fed, &children.inbox(), &tell);
    let (network, outside) = joined.map_err(anyhow::Error::msg)?;
    children.subscribe(outside);
    Ok(Some(network))
}

/// Returns the conversions of ports with common messages.
#[cfg(feature = "zenoh")]
fn conversions(
    session: &Session,
    known: &BTreeMap<ComponentId, KnownComponent>,
) -> Result<BTreeMap<ComponentId, Conversions>, String> {
    let config = session.config.as_ref();
    config.map_or(Ok(()), ConfigProblems::first_error)?;
    let (mut out, mut errors) = (BTreeMap::new(), Vec::new());
    for (&at, entry) in known {
        match conversion::conversions(&entry.spec, entry.component(), &session.ros2) {
            Ok(found) => {
                out.insert(at, found);
            }
            Err(some) => errors.extend(some),
        }
    }
    for component in session.ros2.keys() {
        if known.values().all(|entry| entry.component().name != component.as_str()) {
            report::note(&format!(
                "`ros2.messages.{component}` is not used: no component `{component}` runs"
            ));
        }
    }
    if errors.is_empty() { Ok(out) } else { Err(told_rules(config, &errors)) }
}

/// `pump.goal=planner/goal`
#[cfg(feature = "zenoh")]
fn read(
    text: &str,
    known: &BTreeMap<ComponentId, KnownComponent>,
) -> anyhow::Result<(ComponentId, PortId, String)> {
    let split = text.split_once('=').and_then(|(port, key)| {
        let (component, port) = port.split_once('.')?;
        Some((component, port, key))
    });
    let Some((component, port, key)) = split else {
        anyhow::bail!(
            "`--zenoh-read {text}`: write COMPONENT.PORT=KEY, for example pump.goal=planner/goal"
        );
    };
    let mut all = known.iter();
    let Some((&at, declaration)) = all.find(|(_, of)| of.component().name == component) else {
        anyhow::bail!("`--zenoh-read {text}`: no component `{component}` runs");
    };
    let mut ports = declaration.component().ports.iter_enumerated();
    let found = ports.find(|candidate| candidate.1.name == port && candidate.1.dir == PortDir::In);
    match found {
        Some((index, _)) => Ok((at, index, key.to_owned())),
        None => anyhow::bail!("`--zenoh-read {text}`: `{component}` has no input port `{port}`"),
    }
}
