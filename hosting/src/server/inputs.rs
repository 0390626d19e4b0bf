//! Input ports that clients connect or write.

use std::sync::Arc;

use dotgen_analysis::model::{PortDir, PortId};
use dotgen_codegen::codels::value::Values;
use dotgen_runtime::hosts::{Connection, Message};
use serde_json::{Value, json};

use super::find::input;
use super::{Place, Shared, State};
use crate::children::InputSlot;
use crate::components::CONNECT;
use dotgen_timing::system::ComponentId;

/// Maximum number of instances of an input port that clients may write or connect.
const INSTANCES: usize = 256;

/// The error of a request after the end of the run.
const ENDED: &str = "the run has ended";

/// Connects an input port of a component, as the service of that name does in servers. `local` is the port,
/// with its instance after a slash if it is `multiple`. `remote` is `COMPONENT/PORT`, also with an instance.
pub(super) fn connect(
    shared: &Shared,
    at: ComponentId,
    input: Option<&Value>,
) -> Result<Value, String> {
    let text = |key: &str| {
        let given = input.and_then(|input| input.get(key)).and_then(Value::as_str);
        given.ok_or_else(|| format!("`{CONNECT}` needs `local` and `remote`; `{key}` is not text"))
    };
    let (local, remote) = (text("local")?, text("remote")?);
    let failed = |exception: &str| {
        let exception = format!("::genom::{exception}");
        Ok(json!({"event": "failed", "exception": exception, "detail": null}))
    };
    let find = |at: ComponentId, dir: PortDir, path: &str| {
        let (port, instance) = path.split_once('/').unwrap_or((path, ""));
        let known = shared.known.get(&at)?;
        let mut ports = known.component().ports.iter_enumerated();
        let (number, port) =
            ports.find(|(_, candidate)| candidate.name == port && candidate.dir == dir)?;
        let fits = port.multiple != instance.is_empty();
        let layout = Values::new(&known.spec).layout(port.data);
        fits.then(|| (number, instance.to_owned(), layout))
    };
    let Some((to, name, wanted)) = find(at, PortDir::In, local) else {
        return failed("no_such_inport");
    };
    let (component, path) = remote.split_once('/').unwrap_or((remote, ""));
    let mut all = shared.known.iter();
    let from = all.find(|(_, candidate)| candidate.component().name == component);
    let from = from.and_then(|(&from, _)| Some((from, find(from, PortDir::Out, path)?)));
    let Some((from, (port, id, written))) = from else {
        return failed("no_such_outport");
    };
    // Servers compare the names of the types; here their contents are compared.
    if wanted != written {
        return failed("port_io");
    }
    let connection = Connection { from: (from, port), to: (at, to), id, name };
    let place = (at, to, connection.name.clone());
    let source = (from, port, connection.id.clone());
    // Under the lock: writes and connections reach the engine in the order of their answers.
    let mut state = shared.state();
    if is_full(state.connected.keys(), &place) {
        return Err(format!("`{local}`: {INSTANCES} instances of the port are connected"));
    }
    state.connected.insert(place, source);
    if shared.inbox.bring(Message::Connect(connection)) {
        Ok(json!({"event": "done", "output": {}}))
    } else {
        Err(ENDED.to_owned())
    }
}

/// Gives an input port a new value. A value that the engine has not taken yet is replaced.
pub(super) fn write(shared: &Shared, path: &str, request: &Value) -> Result<Value, String> {
    let (at, number) = input(shared, path)?;
    let known = &shared.known[&at];
    let component = known.component();
    let port = &component.ports[number];
    let value = request.get("value");
    let value = value.ok_or_else(|| format!("`write` needs a `value` for `{path}`"))?;
    let instance = match request.get("instance") {
        None | Some(Value::Null) => "",
        Some(Value::String(text)) => text.as_str(),
        Some(request) => return Err(format!("the instance {request} of `{path}` is not text")),
    };
    match (port.multiple, instance) {
        (true, "") => {
            return Err(format!("`{path}` is `multiple`: give the `instance` to write"));
        }
        (false, instance) if !instance.is_empty() => {
            return Err(format!(
                "`{path}` has no instance `{instance}`: it is not `multiple`; leave the `instance` out"
            ));
        }
        _ => {}
    }
    let bytes = Values::new(&known.spec).encode(port.data, value);
    let bytes = bytes.map_err(|error| format!("`{path}`: {error}"))?;
    if !known.executed {
        return Err(format!(
            "`{path}` is read by no codel: `{}` is simulated in this run",
            component.name
        ));
    }
    let place = (at, number, instance.to_owned());
    let mut state = shared.state();
    if let Some(why) = state.gone.get(&at) {
        return Err(format!("`{}` {why}", component.name));
    }
    if let Some(source) = source(shared, &state, &place) {
        return Err(format!(
            "`{path}` is connected to `{source}`, which writes it; `connect_port` of `{}` connects it to \
             another output port",
            component.name
        ));
    }
    if is_full(state.written.keys(), &place) {
        return Err(format!("`{path}` has {INSTANCES} instances; write one of them"));
    }
    let new = || Arc::new(InputSlot::new(at, number, instance.to_owned()));
    let newest = state.written.entry(place).or_insert_with(new);
    if shared.inbox.feed(newest, bytes) {
        Ok(json!({"event": "written"}))
    } else {
        Ok(json!({"event": "lost", "message": ENDED}))
    }
}

/// Returns true if a port has [`INSTANCES`] places among `all`, and `further` is not one of them.
fn is_full<'p>(all: impl Iterator<Item = &'p Place>, further: &Place) -> bool {
    let mut of_port = all.filter(|place| (place.0, place.1) == (further.0, further.1));
    let mut count = 0;
    of_port.all(|port| {
        count += 1;
        port != further
    }) && count >= INSTANCES
}

/// Returns the output port of the run that an input port reads, or would read.
fn source(shared: &Shared, state: &State, place: &Place) -> Option<String> {
    let name = |component: ComponentId, port: PortId| {
        let component = shared.known.get(&component)?.component();
        let port = component.ports.get(port)?;
        Some((component, port))
    };
    if let Some((component, port, instance)) = state.connected.get(place) {
        let (component, port) = name(*component, *port)?;
        let path = format!("{}/{}", component.name, port.name);
        return Some(match instance.as_str() {
            "" => path,
            instance => format!("{path}/{instance}"),
        });
    }
    let (at, number, instance) = place;
    let mut feeds = shared.feeds.iter().filter(|flow| flow.to == (*at, *number));
    feeds.find_map(|feed| {
        let (component, port) = name(feed.from.0, feed.from.1)?;
        // A `multiple` output may open an instance of any name.
        let reads = !feed.multiple || port.multiple || component.name == instance.as_str();
        reads.then(|| format!("{}/{}", component.name, port.name))
    })
}
