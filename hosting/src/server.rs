//! Services as JSON over a socket: see `docs/socket.md`.

mod data;
mod find;
mod inputs;
mod subscribers;
mod token;

use std::collections::{BTreeMap, HashMap};
use std::io::{self, BufReader, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use dotgen_codegen::codels::value::Values;
use dotgen_runtime::hosts::{Message, OutsideRequest, RequestReply};
use dotgen_runtime::live::DataFlow;
use rustix::fs::Mode;
use rustix::process::umask;
use serde_json::{Value, json};

use super::children::{InputSlot, RunInbox, RunListener};
use super::clients::{
    Client, Line, MAX_CLIENTS, MAX_REQUEST_BYTES, MAX_WAITING, VERSION, read_line, skip_line,
};
use super::components::{CONNECT, KnownComponent, describe, inputs_of, reply_of};
use super::remote::RemoteComponents;
use super::stream::{Stream, TimedInput};
use dotgen_analysis::model::{PortId, ServiceId};
use dotgen_platform::files::disk::TemporaryFile;
use dotgen_timing::system::ComponentId;
use find::{component, output};
use subscribers::{ProfileSubscribers, ProgressSubscribers, ViolationSubscribers};
use token::Token;

/// Maximum time in which a client of a TCP port sends the token. Without a limit, other users of this machine
/// could hold all connections.
const TOKEN_TIMEOUT: Duration = Duration::from_secs(10);

/// A server that listens until it is dropped. Dropping it removes the socket.
pub struct Server {
    _socket: TemporaryFile,
    /// The file with the token of the TCP port.
    token: Option<TemporaryFile>,
    shared: Arc<Shared>,
}

/// The clients that a TCP port serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clients {
    /// Processes of this user, which can read the file with the token.
    OfThisUser,
    /// All processes on this machine.
    Anyone,
}

impl Server {
    /// Listens at a TCP port as well, on loopback. Port 0 selects a free port. Returns the address, and the
    /// file with the token that clients have to send.
    ///
    /// # Errors
    /// A message: another program listens there, the system refuses, or the file cannot be written.
    pub fn listen_on_loopback(
        &mut self,
        port: u16,
        clients: Clients,
    ) -> Result<(SocketAddr, Option<PathBuf>), String> {
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        let wrong = |error: io::Error| format!("cannot listen at {address}: {error}");
        let listener = TcpListener::bind(address).map_err(wrong)?;
        let taken = listener.local_addr().map_err(wrong)?;
        let mut token = None;
        if clients == Clients::OfThisUser {
            let no_file = |error: io::Error| format!("cannot make the token of {taken}: {error}");
            let (text, file) = Token::new(taken.port()).map_err(no_file)?;
            self.token = Some(file);
            token = Some(Arc::new(text));
        }
        let shared = self.shared.clone();
        // The thread ends with the process.
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                accept(&shared, Stream::Tcp(stream), token.clone());
            }
        });
        let file = self.token.as_ref().map(TemporaryFile::path);
        Ok((taken, file.map(Path::to_owned)))
    }

    /// Returns the subscribers of the progress of the run.
    pub fn progress_subscribers(&self) -> ProgressSubscribers {
        ProgressSubscribers { shared: self.shared.clone(), told: None }
    }

    /// Returns the subscribers of the lines of the profile. Each gets the lines that name the source of its
    /// times first.
    pub fn followers(&self, origins: &str) -> ProfileSubscribers {
        let mut state = self.shared.state();
        state.origins = origins.lines().map(subscribers::ran).collect();
        for (client, id) in &state.followers {
            state.origins.iter().for_each(|line| client.say(line.clone(), id));
        }
        ProfileSubscribers(self.shared.clone())
    }

    pub fn violation_subscribers(&self) -> ViolationSubscribers {
        ViolationSubscribers(self.shared.clone())
    }
}

/// The state that the threads of clients share with the engine.
struct Shared {
    /// By component of the system.
    known: BTreeMap<ComponentId, KnownComponent>,
    /// Flows between ports at the start of the run.
    feeds: Vec<DataFlow>,
    inbox: RunInbox,
    remote: RemoteComponents,
    state: Mutex<State>,
}

/// An input port, by component and number, and the name by which it finds a source.
type Place = (ComponentId, PortId, String);

#[derive(Default)]
struct State {
    /// Number of connections so far.
    clients: u64,
    /// Number of open connections: by TCP, and to the Unix socket.
    open: [usize; 2],
    requests: HashMap<u64, PendingRequest>,
    watchers: Vec<Watcher>,
    /// Subscribers of executions of codels, with the `id` of their request.
    followers: Vec<(Client, Value)>,
    /// The events of the lines that name the source of the times of the profile.
    origins: Vec<Value>,
    /// Subscribers of the progress of the run, with the `id` of their request.
    progress_subscribers: Vec<(Client, Value)>,
    /// Subscribers of violations, with the `id` of their request.
    violation_subscribers: Vec<(Client, Value)>,
    /// The first violations, as the last event of each.
    violations: Vec<Value>,
    /// The newest data of output ports.
    data: HashMap<(ComponentId, PortId, String), Vec<u8>>,
    /// Input ports that clients have connected: the component, output port and instance of each source.
    connected: HashMap<Place, (ComponentId, PortId, String)>,
    /// Input ports that clients have written, with the data that the engine has not taken yet.
    written: HashMap<Place, Arc<InputSlot>>,
    /// Components that have ended, with the way in which each ended.
    gone: HashMap<ComponentId, String>,
}

struct PendingRequest {
    client: Client,
    /// The `id` that the client gave the request.
    id: Value,
    component: ComponentId,
    index: ServiceId,
}

struct Watcher {
    component: ComponentId,
    port: PortId,
    client: Client,
    id: Value,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Listens at a path. Only this user may connect.
///
/// # Errors
/// A message: another program listens there, or the path cannot be used.
pub fn listen(
    path: &Path,
    known: BTreeMap<ComponentId, KnownComponent>,
    feeds: Vec<DataFlow>,
    inbox: RunInbox,
    remote: RemoteComponents,
) -> Result<(Server, Box<dyn RunListener>), String> {
    let shown = path.display();
    if UnixStream::connect(path).is_ok() {
        return Err(format!(
            "another run listens at `{shown}`; end it, or choose another path with --socket"
        ));
    }
    if std::fs::symlink_metadata(path).is_ok_and(|metadata| {
        use std::os::unix::fs::FileTypeExt as _;
        metadata.file_type().is_socket()
    }) {
        // The socket was left behind by a run that was killed.
        let _ = std::fs::remove_file(path);
    }
    let wrong = |error: std::io::Error| format!("cannot listen at `{shown}`: {error}");
    // The socket is private from its first moment.
    let before = umask(Mode::from_raw_mode(0o177));
    let listener = UnixListener::bind(path);
    umask(before);
    let listener = listener.map_err(wrong)?;
    let socket = TemporaryFile::new(path.to_owned());
    let shared = Arc::new(Shared { state: Mutex::default(), known, feeds, inbox, remote });
    let accepting = shared.clone();
    // The thread ends with the process.
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            accept(&accepting, Stream::Unix(stream), None);
        }
    });
    let server = Server { _socket: socket, token: None, shared: shared.clone() };
    Ok((server, Box::new(EngineListener { shared })))
}

fn accept(shared: &Arc<Shared>, stream: Stream, token: Option<Arc<Token>>) {
    let mut state = shared.state();
    let kind = usize::from(stream.is_private());
    if state.open[kind] >= MAX_CLIENTS {
        drop(state);
        let why = format!("too many connections: {MAX_CLIENTS} are open; close one of them");
        let told = json!({"event": "error", "message": why, "id": null, "version": VERSION});
        // The buffer of a new connection has room for a line.
        let _ = (&stream).write_all(format!("{told}\n").as_bytes());
        return;
    }
    state.open[kind] += 1;
    let number = state.clients;
    state.clients += 1;
    drop(state);
    let shared = shared.clone();
    std::thread::spawn(move || {
        serve(&shared, stream, number, token.as_deref());
        shared.state().open[kind] -= 1;
    });
}

fn serve(shared: &Shared, stream: Stream, number: u64, token: Option<&Token>) {
    let stream = Arc::new(stream);
    let client = Client::new(number, stream.clone());
    let stays = read_requests(shared, &stream, &client, token);
    // From now on only the requests of the client keep the connection open.
    drop(client);
    if stays {
        stream.wait_for_end();
    }
    let mut state = shared.state();
    state.watchers.retain(|watcher| watcher.client.number != number);
    state.followers.retain(|follower| follower.0.number != number);
    state.progress_subscribers.retain(|subscriber| subscriber.0.number != number);
    state.violation_subscribers.retain(|subscriber| subscriber.0.number != number);
    // The requests go on, without a receiver of their results.
    state.requests.retain(|_, request| request.client.number != number);
    drop(state);
    stream.wait_for_end();
}

/// Reads requests until the client has sent all. The first one is the token, if one is required. Returns true
/// if the client may get answers after that.
fn read_requests(
    shared: &Shared,
    stream: &Stream,
    client: &Client,
    mut token: Option<&Token>,
) -> bool {
    let mut input = BufReader::new(TimedInput::new(stream, &Instant::now));
    let mut line = Vec::new();
    if token.is_some() {
        input.get_mut().limit(Some(TOKEN_TIMEOUT));
    }
    loop {
        match read_line(&mut input, &mut line) {
            Line::Whole => {}
            Line::TooLong => {
                let why =
                    format!("too long: a request has at most {} MiB", MAX_REQUEST_BYTES >> 20);
                // At once: the client may wait for an answer before it ends the line.
                client.say(json!({"event": "error", "message": why}), &Value::Null);
                skip_line(&mut input);
                continue;
            }
            Line::End => return token.is_none(),
        }
        let request: Value = match serde_json::from_slice(&line) {
            Ok(slice) => slice,
            Err(error) => {
                let why = format!("the request is not JSON: {error}");
                client.say(json!({"event": "error", "message": why}), &Value::Null);
                // A page in a browser can connect to the port too, but its request begins with text that is
                // not JSON.
                if stream.is_private() {
                    continue;
                }
                return false;
            }
        };
        let id = request.get("id").cloned().unwrap_or(Value::Null);
        if let Some(wanted) = token.take() {
            if wanted.is_in(&request) {
                input.get_mut().limit(None);
                continue;
            }
            let file = wanted.path().display();
            let why = format!("first send {{\"token\": \"…\"}}, the text of `{file}`");
            client.say(json!({"event": "error", "message": why}), &id);
            return false;
        }
        if request.get("token").is_some() {
            // The client has a token of an earlier run that was killed. This run requires none.
            continue;
        }
        match answer(shared, client, &request, &id) {
            Ok(Some(answer)) => client.say(answer, &id),
            Ok(None) => {}
            Err(why) => client.say(json!({"event": "error", "message": why}), &id),
        }
    }
}

/// Refuses a request that does not end at once if the connection has too many, or one with the same `id`.
fn admit(state: &State, client: &Client, id: &Value) -> Result<(), String> {
    let requests = state.requests.values().map(|request| (&request.client, &request.id));
    let watchers = state.watchers.iter().map(|watcher| (&watcher.client, &watcher.id));
    let others = state.followers.iter().chain(&state.progress_subscribers);
    let others = others.chain(&state.violation_subscribers);
    let all = requests.chain(watchers).chain(others.map(|follower| (&follower.0, &follower.1)));
    let mut waiting = 0;
    for (_, other) in all.filter(|(other, _)| other.number == client.number) {
        // Requests without an `id` cannot be distinguished. The client has chosen this.
        if other == id && !id.is_null() {
            return Err(format!(
                "request {id} has not ended: give each request an `id` of its own"
            ));
        }
        waiting += 1;
    }
    if waiting < MAX_WAITING {
        Ok(())
    } else {
        Err(format!(
            "too many requests: {MAX_WAITING} of this connection have not ended; wait for some of them"
        ))
    }
}

/// Returns the answer to a request, if the answer is known at once.
fn answer(
    shared: &Shared,
    client: &Client,
    request: &Value,
    id: &Value,
) -> Result<Option<Value>, String> {
    let text = |key: &str| request.get(key).and_then(Value::as_str);
    if let Some(path) = text("call") {
        return call(shared, client, path, request.get("input"), id).map(|()| None);
    }
    if let Some(path) = text("watch") {
        return watch(shared, client, path, request, id);
    }
    if let Some(path) = text("read") {
        let (component, port) = output(shared, path)?;
        let instances = data::newest(shared, &shared.state(), component, port);
        let value = instances.get("").cloned().unwrap_or(Value::Null);
        return Ok(Some(json!({"event": "data", "value": value, "instances": instances})));
    }
    if let Some(path) = text("write") {
        return inputs::write(shared, path, request).map(Some);
    }
    if let Some(of) = request.get("abort") {
        let mut state = shared.state();
        if state.unsubscribe_violations(client, of) {
            return Ok(Some(json!({"event": "aborting"})));
        }
        let mut all = state.requests.iter();
        let found =
            all.find(|(_, request)| request.client.number == client.number && request.id == *of);
        let Some((&number, _)) = found else {
            return Err("the request to abort has ended, or is from another client".to_owned());
        };
        drop(state);
        shared.inbox.bring(Message::Abort(number));
        return Ok(Some(json!({"event": "aborting"})));
    }
    if request.get("profile").is_some() {
        let mut state = shared.state();
        admit(&state, client, id)?;
        // The answer comes before the lines.
        client.say(json!({"event": "profiling"}), id);
        state.origins.iter().for_each(|line| client.say(line.clone(), id));
        state.followers.push((client.clone(), id.clone()));
        return Ok(None);
    }
    if request.get("progress").is_some() {
        let mut state = shared.state();
        admit(&state, client, id)?;
        client.say(json!({"event": "following"}), id);
        state.progress_subscribers.push((client.clone(), id.clone()));
        return Ok(None);
    }
    if request.get("violations").is_some() {
        let mut state = shared.state();
        admit(&state, client, id)?;
        client.say(json!({"event": "following"}), id);
        state.violations.iter().for_each(|event| client.say(event.clone(), id));
        state.violation_subscribers.push((client.clone(), id.clone()));
        return Ok(None);
    }
    if request.get("describe").is_some() {
        let all: Vec<Value> = shared.known.values().map(describe).collect();
        return Ok(Some(json!({"event": "description", "components": all})));
    }
    let known = "`call`, `abort`, `watch`, `read`, `write`, `profile`, `progress`, `violations` or";
    Err(format!("a request has {known} `describe`"))
}

/// Adds a watcher of an output port. Returns the answer if the component has ended.
fn watch(
    shared: &Shared,
    client: &Client,
    path: &str,
    request: &Value,
    id: &Value,
) -> Result<Option<Value>, String> {
    let (component, port) = output(shared, path)?;
    let mut state = shared.state();
    if let Some(why) = state.gone.get(&component) {
        return Ok(Some(lost(&shared.known[&component], why)));
    }
    admit(&state, client, id)?;
    client.say(json!({"event": "watching"}), id);
    if request.get("newest") == Some(&Value::Bool(true)) {
        for (instance, value) in data::newest(shared, &state, component, port) {
            client.offer(json!({"event": "data", "instance": instance, "value": value}), id);
        }
    }
    state.watchers.push(Watcher { client: client.clone(), id: id.clone(), component, port });
    Ok(None)
}

/// The message to watchers of a component that has ended.
fn lost(known: &KnownComponent, why: &str) -> Value {
    let name = &known.component().name;
    json!({"event": "lost", "message": format!("`{name}` {why}")})
}

fn call(
    shared: &Shared,
    client: &Client,
    path: &str,
    input: Option<&Value>,
    id: &Value,
) -> Result<(), String> {
    let (name, service) = path.split_once('.').ok_or("write COMPONENT.SERVICE")?;
    let at = component(shared, name)?;
    let known = &shared.known[&at];
    let services = &known.component().services;
    let found = services.position(|candidate| candidate.name == service);
    if found.is_none() && service == CONNECT {
        client.say(inputs::connect(shared, at, input)?, id);
        return Ok(());
    }
    let Some(index) = found else {
        let names: Vec<&str> = services.iter().map(|service| service.name.as_str()).collect();
        return Err(find::missing(&format!("`{name}`"), "service", service, &names));
    };
    let (wanted, inputs) = inputs_of(known, index, input)?;
    let mut state = shared.state();
    admit(&state, client, id)?;
    let number = shared.inbox.number();
    state.requests.insert(
        number,
        PendingRequest { client: client.clone(), id: id.clone(), component: at, index },
    );
    drop(state);
    let wanted = OutsideRequest { id: number, service: wanted, inputs };
    if shared.inbox.bring(Message::OutsideRequest(wanted)) {
        Ok(())
    } else {
        shared.state().requests.remove(&number);
        Err("the run has ended".to_owned())
    }
}

/// The listener that passes events of the engine to clients.
struct EngineListener {
    shared: Arc<Shared>,
}

impl RunListener for EngineListener {
    fn answer(&mut self, id: u64, answer: &RequestReply) {
        let mut state = self.shared.state();
        let Some(asked) = state.requests.get(&id) else {
            return;
        };
        let known = &self.shared.known[&asked.component];
        let told = reply_of(known, asked.index, answer);
        asked.client.say(told, &asked.id);
        if *answer != RequestReply::Accepted {
            state.requests.remove(&id);
        }
    }

    fn gone(&mut self, component: ComponentId, why: &str) {
        let mut state = self.shared.state();
        state.gone.insert(component, why.to_owned());
        let Some(known) = self.shared.known.get(&component) else {
            return;
        };
        let told = lost(known, why);
        state.watchers.retain(|watcher| {
            let stays = watcher.component != component;
            if !stays {
                watcher.client.say(told.clone(), &watcher.id);
            }
            stays
        });
    }

    fn published(&mut self, component: ComponentId, port: PortId, id: &str, data: &[u8]) {
        let mut state = self.shared.state();
        let Some(known) = self.shared.known.get(&component) else {
            return;
        };
        let ty = known.component().ports[port].data;
        let mut value = None;
        let of = state.watchers.iter();
        for watcher in of.filter(|watcher| (watcher.component, watcher.port) == (component, port)) {
            let value = value.get_or_insert_with(|| {
                let value = Values::new(&known.spec).decode(ty, data);
                value.unwrap_or(Value::Null)
            });
            let told = json!({"event": "data", "instance": id, "value": value});
            watcher.client.offer(told, &watcher.id);
        }
        state.data.insert((component, port, id.to_owned()), data.to_vec());
    }
}
