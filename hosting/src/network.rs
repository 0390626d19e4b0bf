//! Ports between machines, by Zenoh: see `docs/run.md`.
//!
//! An output port is the key `COMPONENT/PORT`, an instance of a `multiple` one `COMPONENT/PORT/INSTANCE`; the
//! data is CDR. Data that arrives is handed to the engine, which leads the hosts there.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex};

use dotgen_analysis::model::{Port, PortDir, Spec, TypeId};
use dotgen_codegen::codels::cdr::{from_cdr, to_cdr};
use dotgen_codegen::codels::value::Values;
use dotgen_runtime::hosts::RequestReply;
use zenoh::bytes::Encoding;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::sample::{Locality, Sample};
use zenoh::{Config, Session, Wait as _};

use super::children::{InputSlot, RunInbox, RunListener};
use super::components::KnownComponent;

/// Sources of a `multiple` port, and keys of which something is told: others are left, so that nobody else
/// fills the memory of this machine.
const SOURCES: usize = 256;

/// Whom to reach, and what to read there.
#[derive(Debug, Clone, Copy)]
pub struct NetworkOptions<'a> {
    /// Zenoh endpoints where others reach this run.
    pub listen: &'a [String],
    /// Zenoh endpoints of others, or of routers.
    pub connect: &'a [String],
    /// Component, input port, and the key that it reads.
    pub reads: &'a [(usize, u32, String)],
}

/// Tells the user something, once.
pub type Notifier = Arc<dyn Fn(&str) + Send + Sync>;

/// Is connected until it is dropped.
pub struct Network {
    _subscribers: Vec<Subscriber<()>>,
}

/// Joins others. `is_fed` says which input ports have their data from this run.
///
/// # Errors
/// In words: where an endpoint is none, or somebody else listens there.
pub fn join(
    wanted: NetworkOptions<'_>,
    known: &BTreeMap<usize, KnownComponent>,
    is_fed: &dyn Fn(usize, u32) -> bool,
    inbox: &RunInbox,
    tell: &Notifier,
) -> Result<(Network, Box<dyn RunListener>), String> {
    let config = config(wanted).map_err(|it| format!("an endpoint of Zenoh is wrong: {it}"))?;
    let session = zenoh::open(config).wait();
    let session = session.map_err(|it| format!("cannot join by Zenoh: {it}"))?;
    let mut subscribers = Vec::new();
    for (&component, it) in known {
        for (index, port) in (0u32..).zip(&it.component().ports) {
            if port.dir == PortDir::Out {
                continue;
            }
            let chosen = wanted
                .reads
                .iter()
                .filter(|it| it.0 == component && it.1 == index);
            let mut keys: Vec<String> = chosen.map(|it| it.2.clone()).collect();
            if keys.is_empty() && !is_fed(component, index) {
                keys.push(format!("*/{}", port.name));
                if port.multiple {
                    keys.push(format!("*/{}/*", port.name));
                }
            }
            for key in keys {
                let input = Input {
                    spec: it.spec.clone(),
                    ty: port.data,
                    path: format!("{}.{}", it.component().name, port.name),
                    component,
                    port: index,
                    multiple: port.multiple,
                    inbox: inbox.clone(),
                    tell: tell.clone(),
                    state: Mutex::default(),
                };
                let subscriber = session.declare_subscriber(key.clone());
                // What this run writes it reads without a network.
                let subscriber = subscriber.allowed_origin(Locality::Remote);
                let subscriber = subscriber.callback(move |it| input.hear(&it)).wait();
                subscribers.push(subscriber.map_err(|it| format!("cannot read `{key}`: {it}"))?);
            }
        }
    }
    let outputs = Outputs {
        session,
        known: known.clone(),
        publishers: HashMap::new(),
        tell: tell.clone(),
    };
    let network = Network {
        _subscribers: subscribers,
    };
    Ok((network, Box::new(outputs)))
}

/// Nobody is sought, and nobody finds this run, but where it was said.
fn config(wanted: NetworkOptions<'_>) -> zenoh::Result<Config> {
    let list = |all: &[String]| serde_json::json!(all).to_string();
    let mut config = Config::default();
    config.insert_json5("mode", "\"peer\"")?;
    config.insert_json5("scouting/multicast/enabled", "false")?;
    // The engine does not wait where the network does not take more.
    let drop = "transport/link/tx/queue/congestion_control/drop";
    config.insert_json5(&format!("{drop}/wait_before_drop"), "0")?;
    config.insert_json5(&format!("{drop}/max_wait_before_drop_fragments"), "0")?;
    config.insert_json5("listen/endpoints", &list(wanted.listen))?;
    config.insert_json5("connect/endpoints", &list(wanted.connect))?;
    Ok(config)
}

/// An input port that reads a key, or several.
struct Input {
    spec: Arc<Spec>,
    ty: TypeId,
    path: String,
    component: usize,
    port: u32,
    multiple: bool,
    inbox: RunInbox,
    tell: Notifier,
    state: Mutex<SubscriberState>,
}

#[derive(Default)]
struct SubscriberState {
    /// By the name of the source: what the engine has not taken yet.
    newest: HashMap<String, Arc<InputSlot>>,
    /// The key that a port reads which is not `multiple`.
    source: Option<String>,
    /// Keys of which something was told.
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
        let mut heard = self.state.lock().unwrap_or_else(|it| it.into_inner());
        let tell_once = |told: &mut BTreeSet<String>, what: &str| {
            if told.len() < SOURCES && told.insert(key.to_owned()) {
                (self.tell)(what);
            }
        };
        let data = match data {
            Ok(it) => it,
            Err(wrong) => {
                let path = &self.path;
                let what =
                    format!("`{key}` is not read by `{path}`: it holds something else ({wrong})");
                tell_once(&mut heard.told, &what);
                return;
            }
        };
        // One source at a time: two of the same name would take turns.
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

/// The output ports of this run.
struct Outputs {
    session: Session,
    known: BTreeMap<usize, KnownComponent>,
    /// By component, port and instance; `None` for a key that cannot be.
    publishers: HashMap<(usize, u32, String), Option<Publisher<'static>>>,
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
            Ok(it) => Some(it),
            Err(why) => {
                (self.tell)(&format!("`{key}` is not seen by other machines: {why}"));
                None
            }
        }
    }
}

impl RunListener for Outputs {
    fn answer(&mut self, _: u64, _: &RequestReply) {}

    fn gone(&mut self, component: usize, _: &str) {
        self.publishers.retain(|it, _| it.0 != component);
    }

    fn published(&mut self, component: usize, port: u32, id: &str, data: &[u8]) {
        let Some(known) = self.known.get(&component) else {
            return;
        };
        let Some(of) = known.component().ports.get(port as usize) else {
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
            // Whoever is too slow misses some: the engine waits for nobody.
            let _ = publisher.put(cdr).wait();
        }
    }
}
