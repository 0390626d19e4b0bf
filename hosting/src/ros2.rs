//! Components as ROS 2 nodes, by Zenoh: see `docs/ros2.md`. Names, types and payloads are those of
//! [`dotgen_ros2`].

mod replies;
mod requests;
mod topics;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use dotgen_ros2::cdr::Payloads;
use dotgen_ros2::conversion::{Conversion, Conversions};
use dotgen_ros2::node::{Endpoint, Node, Part, endpoints};
use dotgen_ros2::remap::{Remap, remap};
use dotgen_ros2::wire::{Kind, NodeId};
use dotgen_runtime::hosts::RequestReply;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::query::Queryable;
use zenoh::sample::Sample;
use zenoh::{Session, Wait as _};

use super::children::{InputSlot, RunInbox, RunListener};
use super::clients::MAX_REQUEST_BYTES;
use super::components::KnownComponent;
use super::network::{Notifier, SOURCES, config};
use dotgen_analysis::model::PortId;
use dotgen_timing::system::ComponentId;
use requests::Requests;
use topics::{Topic, now};

/// The endpoint of a router if none is given.
const ROUTER: &str = "tcp/localhost:7447";

/// The endpoints of this run, and its domain.
#[derive(Debug, Clone, Copy)]
pub struct Ros2Options<'a> {
    /// Zenoh endpoints at which this run listens, as a router.
    pub listen: &'a [String],
    /// Zenoh endpoints of routers.
    pub connect: &'a [String],
    /// The ROS domain.
    pub domain: u32,
    /// By component: the ports with common messages.
    pub conversions: &'a BTreeMap<ComponentId, Conversions>,
    /// Other names of topics, services and actions.
    pub remaps: &'a [Remap],
}

/// Adds the components of a run to the graph of ROS 2. `is_fed` returns true for input ports that get their
/// data from this run. Parts without a form in ROS 2 are reported.
///
/// # Errors
/// A message: an endpoint is invalid, another program listens there, or a name cannot be remapped.
pub fn join(
    wanted: Ros2Options<'_>,
    known: &BTreeMap<ComponentId, KnownComponent>,
    is_fed: &dyn Fn(ComponentId, PortId) -> bool,
    inbox: &RunInbox,
    tell: &Notifier,
) -> Result<Box<dyn RunListener>, String> {
    let failed = |error: zenoh::Error| format!("cannot join ROS 2 by Zenoh: {error}");
    let found = nodes(wanted, known, is_fed, tell)?;
    let session = open(wanted).map_err(failed)?;
    let mut nodes = Nodes {
        id: session.zid().to_string(),
        session,
        next: AtomicU32::new(0),
        requests: Requests::new(known.clone(), inbox.clone()),
        joined: BTreeMap::new(),
        unpublished: BTreeSet::new(),
        tell: tell.clone(),
    };
    for (component, node) in found {
        let joined = nodes.add(component, node).map_err(failed)?;
        nodes.joined.insert(component, joined);
    }
    Ok(Box::new(nodes))
}

/// The nodes of components, without the input ports that get their data from this run.
fn nodes(
    wanted: Ros2Options<'_>,
    known: &BTreeMap<ComponentId, KnownComponent>,
    is_fed: &dyn Fn(ComponentId, PortId) -> bool,
    tell: &Notifier,
) -> Result<BTreeMap<ComponentId, Node>, String> {
    let mut found = BTreeMap::new();
    for (&component, entry) in known {
        let conversions = wanted.conversions.get(&component);
        let conversions = conversions.cloned().unwrap_or_default();
        match endpoints(&entry.spec, entry.component(), wanted.domain, conversions) {
            Ok(mut node) => {
                let refused = node.refused.iter();
                refused.for_each(|refusal| tell(&refusal.to_string()));
                node.endpoints.retain(|endpoint| match (endpoint.kind, endpoint.part) {
                    (Kind::Subscription, Part::Port(port)) => !is_fed(component, port),
                    _ => true,
                });
                found.insert(component, node);
            }
            Err(all) => all.iter().for_each(|refusal| tell(&refusal.to_string())),
        }
    }
    if !wanted.remaps.is_empty() {
        remap(wanted.remaps, &mut found.values_mut().collect::<Vec<_>>())?;
    }
    Ok(found)
}

fn open(wanted: Ros2Options<'_>) -> zenoh::Result<Session> {
    // Nodes that connect to this run find each other only by a router.
    let mode = match wanted.listen {
        [] => "peer",
        _ => "router",
    };
    let default = [ROUTER.to_owned()];
    let connect = match (wanted.connect, wanted.listen) {
        ([], []) => &default[..],
        (connect, _) => connect,
    };
    let mut config = config(mode, wanted.listen, connect)?;
    // The last message of a topic is kept with its time.
    config.insert_json5("timestamping/enabled", "true")?;
    zenoh::open(config).wait()
}

/// The nodes of a run.
struct Nodes {
    session: Session,
    /// The id of the session.
    id: String,
    /// The number of the next node or endpoint.
    next: AtomicU32,
    requests: Arc<Requests>,
    joined: BTreeMap<ComponentId, Joined>,
    /// Ports, as component and index, with data that had no message, which was reported.
    unpublished: BTreeSet<(ComponentId, PortId)>,
    tell: Notifier,
}

/// A node in the graph. It leaves when it is dropped.
struct Joined {
    node: Node,
    number: u32,
    /// By output port and instance; `None` for an instance without a name in ROS 2.
    topics: HashMap<(PortId, String), Option<Topic>>,
    _tokens: Vec<LivelinessToken>,
    _subscribers: Vec<Subscriber<()>>,
    _queryables: Vec<Queryable<()>>,
}

impl Nodes {
    fn number(&self) -> u32 {
        self.next.fetch_add(1, Ordering::Relaxed)
    }

    fn id<'a>(&'a self, node: &'a Node, number: u32) -> NodeId<'a> {
        NodeId { domain: node.domain, session: &self.id, number, name: &node.name }
    }

    /// Declares a node with its endpoints.
    fn add(&self, component: ComponentId, node: Node) -> zenoh::Result<Joined> {
        let number = self.number();
        let id = self.id(&node, number);
        let declare = |token| self.session.liveliness().declare_token(token).wait();
        let mut tokens = vec![declare(id.token())?];
        let mut topics = HashMap::new();
        let (mut subscribers, mut queryables) = (Vec::new(), Vec::new());
        for endpoint in &node.endpoints {
            let (part, key) = (endpoint.part, endpoint.key(node.domain));
            let topic = || Topic::new(&self.session, id, endpoint, self.number());
            match (endpoint.kind, part) {
                (Kind::Publisher, Part::Status(service)) => {
                    self.requests.add_status(component, service, topic()?);
                }
                (Kind::Publisher, Part::Feedback(service)) => {
                    self.requests.add_feedback(component, service, topic()?);
                }
                (Kind::Publisher, Part::Port(port)) => {
                    if !endpoint.multiple {
                        topics.insert((port, String::new()), Some(topic()?));
                    }
                }
                (Kind::Subscription, Part::Port(port)) => {
                    let conversion = node.conversions.get(&port).cloned();
                    let input = self.input(component, port, endpoint.multiple, conversion);
                    let subscriber = self.session.declare_subscriber(key);
                    let subscriber = subscriber.callback(move |sample| input.hear(&sample));
                    subscribers.push(subscriber.wait()?);
                    if !endpoint.multiple {
                        tokens.push(declare(endpoint.token(id, self.number()))?);
                    }
                }
                (Kind::Server, _) => {
                    let requests = self.requests.clone();
                    let queryable = self.session.declare_queryable(key.clone()).complete(true);
                    let hear = move |query| requests.hear(component, part, &key, query);
                    queryables.push(queryable.callback(hear).wait()?);
                    tokens.push(declare(endpoint.token(id, self.number()))?);
                }
                (Kind::Publisher | Kind::Subscription | Kind::Client, _) => {}
            }
        }
        Ok(Joined {
            node,
            number,
            topics,
            _tokens: tokens,
            _subscribers: subscribers,
            _queryables: queryables,
        })
    }

    fn input(
        &self,
        component: ComponentId,
        port: PortId,
        multiple: bool,
        conversion: Option<Conversion>,
    ) -> Input {
        Input {
            known: self.requests.known[&component].clone(),
            component,
            port,
            multiple,
            conversion,
            inbox: self.requests.inbox.clone(),
            newest: Mutex::default(),
        }
    }

    /// Declares the topic of an instance of a `multiple` output port.
    fn instance(&self, node: &Node, number: u32, port: PortId, name: &str) -> Option<Topic> {
        let mut all = node.endpoints.iter();
        let endpoint: &Endpoint = all.find(|endpoint| endpoint.part == Part::Port(port))?;
        let topic = endpoint.instance(name).and_then(|instance| {
            let topic = Topic::new(&self.session, self.id(node, number), &instance, self.number());
            topic.map_err(|error| error.to_string())
        });
        topic
            .inspect_err(|why| {
                let topic = &endpoint.topic;
                (self.tell)(&format!(
                    "instance `{name}` of `{topic}` is not offered to ROS 2: {why}"
                ));
            })
            .ok()
    }
}

impl RunListener for Nodes {
    fn answer(&mut self, id: u64, answer: &RequestReply) {
        self.requests.answer(id, answer);
    }

    fn entered(&mut self, id: u64, state: &str) {
        self.requests.entered(id, state);
    }

    fn gone(&mut self, component: ComponentId, _: &str) {
        self.requests.leave(component);
        self.joined.remove(&component);
    }

    fn published(&mut self, component: ComponentId, port: PortId, id: &str, data: &[u8]) {
        let place = (port, id.to_owned());
        let Some(joined) = self.joined.get(&component) else {
            return;
        };
        if !joined.topics.contains_key(&place) {
            if joined.topics.len() >= SOURCES {
                return;
            }
            let topic = self.instance(&joined.node, joined.number, port, id);
            if let Some(joined) = self.joined.get_mut(&component) {
                joined.topics.insert(place.clone(), topic);
            }
        }
        let Some(joined) = self.joined.get(&component) else {
            return;
        };
        let Some(Some(topic)) = joined.topics.get(&place) else {
            return;
        };
        let known = &self.requests.known[&component];
        let declaration = known.component();
        let declared = &declaration.ports[port];
        let conversion = joined.node.conversions.get(&port);
        let message = match conversion {
            Some(conversion) => conversion.message(&known.spec, data, now()),
            None => Payloads::new(&known.spec, declaration).message(declared.data, data).map(Some),
        };
        match message {
            Ok(Some(message)) => topic.put(message),
            // An optional member is absent.
            Ok(None) => {}
            Err(error) if conversion.is_some() && self.unpublished.insert((component, port)) => {
                (self.tell)(&format!(
                    "data of port `{}.{}` are not published to ROS 2: {error}",
                    declaration.name, declared.name
                ));
            }
            Err(_) => {}
        }
    }
}

/// An input port that reads topics.
struct Input {
    known: KnownComponent,
    component: ComponentId,
    port: PortId,
    multiple: bool,
    /// The conversion from a common message.
    conversion: Option<Conversion>,
    inbox: RunInbox,
    /// The data that the engine has not taken yet, by the name of the instance.
    newest: Mutex<HashMap<String, Arc<InputSlot>>>,
}

impl Input {
    /// Feeds the port. A message that has another form, or is too long, is ignored.
    fn hear(&self, sample: &Sample) {
        let payload = sample.payload();
        if payload.len() > MAX_REQUEST_BYTES {
            return;
        }
        // DOMAIN/…/INSTANCE/TYPE/HASH
        let instance = sample.key_expr().as_str().rsplit('/').nth(2);
        let name = instance.filter(|_| self.multiple).unwrap_or_default();
        let component = self.known.component();
        let ty = component.ports[self.port].data;
        let (spec, payload) = (&self.known.spec, payload.to_bytes());
        let data = match &self.conversion {
            Some(conversion) => conversion.data(spec, &payload),
            None => Payloads::new(spec, component).data(ty, &payload),
        };
        let Ok(data) = data else {
            return;
        };
        let mut newest = self.newest.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if newest.len() >= SOURCES && !newest.contains_key(name) {
            return;
        }
        let slot = || Arc::new(InputSlot::new(self.component, self.port, name.to_owned()));
        let slot = newest.entry(name.to_owned()).or_insert_with(slot);
        self.inbox.feed(slot, data);
    }
}
