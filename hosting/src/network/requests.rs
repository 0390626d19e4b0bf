//! Requests of other machines to services of this run: `COMPONENT/SERVICE`, with JSON as at the socket.

use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard};

use dotgen_analysis::model::ServiceId;
use dotgen_runtime::hosts::{Message, OutsideRequest, RequestReply};
use dotgen_timing::system::ComponentId;
use serde_json::{Value, json};
use zenoh::bytes::Encoding;
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait as _};

use crate::children::RunInbox;
use crate::clients::{MAX_REQUEST_BYTES, MAX_WAITING, VERSION};
use crate::components::{KnownComponent, inputs_of, reply_of};

/// Replies that have not been sent. More requests are refused, and if there are even more replies, clients
/// whose requests are refused get none.
const QUEUED: usize = 1024;

/// The requests of other machines that have not ended.
pub(super) struct Requests {
    known: BTreeMap<ComponentId, KnownComponent>,
    inbox: RunInbox,
    replies: Sender<(Query, Value)>,
    /// Number of replies that have not been sent.
    queued: Arc<AtomicUsize>,
    /// By their numbers, with the component and the index of the service.
    pending: Mutex<HashMap<u64, (ComponentId, ServiceId, Query)>>,
}

impl Requests {
    /// Starts the thread that replies. The engine never waits for a client.
    pub(super) fn new(
        known: BTreeMap<ComponentId, KnownComponent>,
        inbox: RunInbox,
    ) -> Arc<Requests> {
        let (replies, queue) = channel();
        let queued = Arc::<AtomicUsize>::default();
        let unsent = queued.clone();
        std::thread::spawn(move || send(&queue, &unsent));
        Arc::new(Requests { known, inbox, replies, queued, pending: Mutex::default() })
    }

    /// Declares the services of all components.
    pub(super) fn declare(
        self: &Arc<Requests>,
        session: &Session,
    ) -> zenoh::Result<Vec<Queryable<()>>> {
        let mut queryables = Vec::new();
        for (&component, entry) in &self.known {
            let entry = entry.component();
            for (index, service) in entry.services.iter_enumerated() {
                let requests = self.clone();
                let key = format!("{}/{}", entry.name, service.name);
                // Of several runs with the service, one gets a request.
                let queryable = session.declare_queryable(key).complete(true);
                let hear = move |query| requests.hear(component, index, query);
                queryables.push(queryable.callback(hear).wait()?);
            }
        }
        Ok(queryables)
    }

    fn pending(&self) -> MutexGuard<'_, HashMap<u64, (ComponentId, ServiceId, Query)>> {
        self.pending.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn hear(&self, component: ComponentId, index: ServiceId, query: Query) {
        if let Err(why) = self.begin(component, index, &query)
            && self.queued.load(Ordering::Relaxed) < 2 * QUEUED
        {
            self.reply(query, json!({"event": "error", "message": why}));
        }
    }

    /// Sends a request to the engine.
    fn begin(&self, component: ComponentId, index: ServiceId, query: &Query) -> Result<(), String> {
        let known = &self.known[&component];
        let service = &known.component().services[index];
        let path = format!("{}.{}", known.component().name, service.name);
        if query.key_expr().is_wild() {
            return Err(format!("request one service: `{path}` matches `{}`", query.key_expr()));
        }
        let payload = query.payload();
        if payload.is_some_and(|payload| payload.len() > MAX_REQUEST_BYTES) {
            let most = MAX_REQUEST_BYTES >> 20;
            return Err(format!("too long: a request has at most {most} MiB"));
        }
        let payload = payload.filter(|payload| !payload.is_empty());
        let input: Option<Value> = payload
            .map(|payload| serde_json::from_reader(payload.reader()))
            .transpose()
            .map_err(|error| format!("the request is not JSON: {error}"))?;
        let (wanted, inputs) = inputs_of(known, index, input.as_ref())?;
        let mut pending = self.pending();
        if pending.len() >= MAX_WAITING || self.queued.load(Ordering::Relaxed) >= QUEUED {
            return Err(format!(
                "too many requests: {MAX_WAITING} of other machines have not ended; wait for some of them"
            ));
        }
        let id = self.inbox.number();
        pending.insert(id, (component, index, query.clone()));
        let request = OutsideRequest { id, service: wanted, inputs };
        // After the end of the run, the queries end with the session.
        self.inbox.bring(Message::OutsideRequest(request));
        Ok(())
    }

    /// Passes an answer of the engine on.
    pub(super) fn answer(&self, id: u64, answer: &RequestReply) {
        let mut pending = self.pending();
        let Some(&(component, index, ref query)) = pending.get(&id) else {
            return;
        };
        let reply = reply_of(&self.known[&component], index, answer);
        self.reply(query.clone(), reply);
        if *answer != RequestReply::Accepted {
            pending.remove(&id);
        }
    }

    fn reply(&self, query: Query, mut reply: Value) {
        reply["version"] = VERSION.into();
        self.queued.fetch_add(1, Ordering::Relaxed);
        let _ = self.replies.send((query, reply));
    }
}

fn send(queue: &Receiver<(Query, Value)>, unsent: &AtomicUsize) {
    for (query, reply) in queue {
        let text = reply.to_string();
        // The client may be gone.
        let _ = if reply["event"] == "error" {
            query.reply_err(text).encoding(Encoding::APPLICATION_JSON).wait()
        } else {
            query.reply(query.key_expr(), text).encoding(Encoding::APPLICATION_JSON).wait()
        };
        unsent.fetch_sub(1, Ordering::Relaxed);
    }
}
