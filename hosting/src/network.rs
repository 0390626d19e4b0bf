//! Ports and services between machines, by Zenoh: see `docs/run.md`.
//!
//! An output port has the key `COMPONENT/PORT`, an instance of a `multiple` one `COMPONENT/PORT/INSTANCE`.
//! The data is CDR. Data that arrives goes to the engine, which puts it into the memory shared with hosts.

mod client;
mod presence;
mod requests;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex};

use dotgen_analysis::model::{Port, PortDir, PortId, Spec, TypeId};
use dotgen_codegen::codels::cdr::{from_cdr, to_cdr};
use dotgen_codegen::codels::value::Values;
use dotgen_runtime::hosts::RequestReply;
use zenoh::bytes::Encoding;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::query::Queryable;
use zenoh::sample::{Locality, Sample};
use zenoh::{Config, Session, Wait as _};

use super::children::{InputSlot, RunInbox, RunListener};
use super::components::KnownComponent;
use super::remote::RemoteComponents;
pub use client::request;
use dotgen_timing::system::ComponentId;
use requests::Requests;

/// Maximum number of sources of a `multiple` port, and of keys that are reported. Others are ignored, so that
/// no peer can fill the memory of this machine.
pub(super) const SOURCES: usize = 256;

/// Time after which a silent machine counts as gone, in milliseconds.
const LEASE: u64 = 800;

/// Maximum time of an attempt to connect again, in milliseconds. The end of a run waits for it.
const OPEN_TIMEOUT: u64 = 1000;

/// The endpoints of this run, and the keys that its ports read.
#[derive(Debug, Clone, Copy)]
pub struct NetworkOptions<'a> {
    /// Zenoh endpoints at which this run listens.
    pub listen: &'a [String],
    /// Zenoh endpoints of other runs, or of routers.
    pub connect: &'a [String],
    /// Component, input port, and the key that the port reads.
    pub reads: &'a [(ComponentId, PortId, String)],
    /// Receives the components of other runs.
    pub remote: &'a RemoteComponents,
}

/// A function that shows a message to the user.
pub type Notifier = Arc<dyn Fn(&str) + Send + Sync>;

/// A connection to other machines, which ends when it is dropped.
pub struct Network {
    _subscribers: Vec<Subscriber<()>>,
    _services: Vec<Queryable<()>>,
}

/// Connects to other machines. `is_fed` returns true for input ports that get their data from this run.
///
/// # Errors
/// A message: an endpoint is invalid, or another program listens there.
pub fn join(
    wanted: NetworkOptions<'_>,
    known: &BTreeMap<ComponentId, KnownComponent>,
    is_fed: &dyn Fn(ComponentId, PortId) -> bool,
    inbox: &RunInbox,
    tell: &Notifier,
) -> Result<(Network, Box<dyn RunListener>), String> {
    let mut config = config("peer", wanted.listen, wanted.connect)
        .map_err(|error| format!("an endpoint of Zenoh is wrong: {error}"))?;
    let failed = |error: zenoh::Error| format!("cannot join by Zenoh: {error}");
    for (name, value) in
        [("transport/link/tx/lease", LEASE), ("transport/unicast/open_timeout", OPEN_TIMEOUT)]
    {
        let set = config.insert_json5(name, &value.to_string());
        set.map_err(failed)?;
    }
    let session = zenoh::open(config).wait().map_err(failed)?;
    presence::follow(&session, wanted.remote, tell).map_err(failed)?;
    let mut subscribers = Vec::new();
    for (&component, entry) in known {
        for (index, port) in entry.component().ports.iter_enumerated() {
            if port.dir == PortDir::Out {
                continue;
            }
            let chosen =
                wanted.reads.iter().filter(|entry| entry.0 == component && entry.1 == index);
            let mut keys: Vec<String> = chosen.map(|(.., key)| key.clone()).collect();
            if keys.is_empty() && !is_fed(component, index) {
                keys.push(format!("*/{}", port.name));
                if port.multiple {
                    keys.push(format!("*/{}/*", port.name));
                }
            }
            for key in keys {
                let input = Input {
                    spec: entry.spec.clone(),
                    ty: port.data,
                    path: format!("{}.{}", entry.component().name, port.name),
                    component,
                    port: index,
                    multiple: port.multiple,
                    inbox: inbox.clone(),
                    tell: tell.clone(),
                    state: Mutex::default(),
                };
                let subscriber = session.declare_subscriber(key.clone());
                // The data of this run does not pass through the network.
                let subscriber = subscriber.allowed_origin(Locality::Remote);
                let subscriber = subscriber.callback(move |sample| input.hear(&sample)).wait();
                subscribers
                    .push(subscriber.map_err(|error| format!("cannot read `{key}`: {error}"))?);
            }
        }
    }
    let requests = Requests::new(known.clone(), inbox.clone());
    let services = requests.declare(&session).map_err(failed)?;
    let outputs = Outputs {
        requests,
        tokens: presence::declare(&session, known).map_err(failed)?,
        session,
        known: known.clone(),
        publishers: HashMap::new(),
        tell: tell.clone(),
    };
    let network = Network { _subscribers: subscribers, _services: services };
    Ok((network, Box::new(outputs)))
}

/// Returns a configuration without discovery: only the given endpoints are used.
pub(super) fn config(mode: &str, listen: &[String], connect: &[String]) -> zenoh::Result<Config> {
    let list = |all: &[String]| serde_json::json!(all).to_string();
    let mut config = Config::default();
    config.insert_json5("mode", &format!("\"{mode}\""))?;
    config.insert_json5("scouting/multicast/enabled", "false")?;
    // Data that does not fit into the queue is dropped, so that the engine does not wait. The queue has its
    // greatest size, of 16 batches of 64 KiB.
    config.insert_json5("transport/link/tx/queue/size/data", "16")?;
    let drop = "transport/link/tx/queue/congestion_control/drop";
    config.insert_json5(&format!("{drop}/wait_before_drop"), "0")?;
    config.insert_json5(&format!("{drop}/max_wait_before_drop_fragments"), "0")?;
    config.insert_json5("listen/endpoints", &list(listen))?;
    config.insert_json5("connect/endpoints", &list(connect))?;
    Ok(config)
}

/// An input port that reads one or several keys.
struct Input {
    spec: Arc<Spec>,
    ty: TypeId,
    path: String,
    component: ComponentId,
    port: PortId,
    multiple: bool,
    inbox: RunInbox,
    tell: Notifier,
    state: Mutex<SubscriberState>,
}

#[derive(Default)]
struct SubscriberState {
    /// The data that the engine has not taken yet, by the name of the source.
    newest: HashMap<String, Arc<InputSlot>>,
    /// The key of the source, for a port that is not `multiple`.
    source: Option<String>,
    /// Keys that have been reported.
    told: BTreeSet<String>,
}

impl Input {
    fn hear(&self, sample: &Sample) {
        let key = sample.key_expr().as_str();
        let mut words = key.splitn(3, '/');
        let (component, instance) = (words.next().unwrap_or(key), words.nth(1));
        let name = match (self.multiple, instance) {
            (false, _) => "",
            (true, None) => component,
            (true, Some(instance)) => instance,
        };
        let bytes = sample.payload().to_bytes();
        let data = from_cdr(Values::new(&self.spec), self.ty, &bytes);
        let mut heard = self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let tell_once = |told: &mut BTreeSet<String>, what: &str| {
            if told.len() < SOURCES && told.insert(key.to_owned()) {
                (self.tell)(what);
            }
        };
        let data = match data {
            Ok(data) => data,
            Err(wrong) => {
                let path = &self.path;
                let what =
                    format!("`{key}` is not read by `{path}`: it holds something else ({wrong})");
                tell_once(&mut heard.told, &what);
                return;
            }
        };
        // The port keeps its first source: two sources of the same name would alternate.
        let source = heard.source.get_or_insert_with(|| key.to_owned()).clone();
        if !self.multiple && source != key {
            let path = &self.path;
            let what = format!(
                "`{path}` reads `{source}`, so `{key}` is not read: say which with \
                 `--zenoh-read {path}=KEY`"
            );
            tell_once(&mut heard.told, &what);
            return;
        }
        if heard.newest.len() >= SOURCES && !heard.newest.contains_key(name) {
            let what = format!("`{}` has {SOURCES} sources: `{key}` is not read", self.path);
            tell_once(&mut heard.told, &what);
            return;
        }
        let newest = heard.newest.entry(name.to_owned()).or_insert_with(|| {
            Arc::new(InputSlot::new(self.component, self.port, name.to_owned()))
        });
        self.inbox.feed(newest, data);
    }
}

/// The components of this run, with their requests and output ports.
struct Outputs {
    requests: Arc<Requests>,
    tokens: presence::Tokens,
    session: Session,
    known: BTreeMap<ComponentId, KnownComponent>,
    /// By component, port and instance; `None` for an invalid key.
    publishers: HashMap<(ComponentId, PortId, String), Option<Publisher<'static>>>,
    tell: Notifier,
}

impl Outputs {
    fn declare(&self, known: &KnownComponent, port: &Port, id: &str) -> Option<Publisher<'static>> {
        let component = &known.component().name;
        let key = match id {
            "" => format!("{component}/{}", port.name),
            id => format!("{component}/{}/{id}", port.name),
        };
        let name = known.spec.full_name(port.data).unwrap_or_default();
        let encoding = Encoding::APPLICATION_CDR.with_schema(name.trim_start_matches("::"));
        let publisher = self.session.declare_publisher(key.clone());
        match publisher.encoding(encoding).wait() {
            Ok(wait) => Some(wait),
            Err(why) => {
                (self.tell)(&format!("`{key}` is not seen by other machines: {why}"));
                None
            }
        }
    }
}

impl RunListener for Outputs {
    fn answer(&mut self, id: u64, answer: &RequestReply) {
        self.requests.answer(id, answer);
    }

    fn gone(&mut self, component: ComponentId, _: &str) {
        self.tokens.remove(&component);
        self.publishers.retain(|publisher, _| publisher.0 != component);
    }

    fn published(&mut self, component: ComponentId, port: PortId, id: &str, data: &[u8]) {
        let Some(known) = self.known.get(&component) else {
            return;
        };
        let Some(of) = known.component().ports.get(port) else {
            return;
        };
        let place = (component, port, id.to_owned());
        if !self.publishers.contains_key(&place) {
            let declared = self.declare(known, of, id);
            self.publishers.insert(place.clone(), declared);
        }
        let Some(Some(publisher)) = self.publishers.get(&place) else {
            return;
        };
        if let Ok(cdr) = to_cdr(Values::new(&known.spec), of.data, data) {
            // A slow reader misses data. The engine does not wait.
            let _ = publisher.put(cdr).wait();
        }
    }
}
