//! The transport between the standard channels and the service: messages in order in both directions, and an
//! answer to every request, even a malformed one.
//!
//! The protocol library has a transport of its own. It ends the session at the first message that is not
//! JSON, trusts wrong lengths, and answers `shutdown` with an error while `initialize` is in progress.

mod client_process;
mod frame;
mod lenient;
mod message;
mod spelling;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::task::Poll;
use std::time::Duration;

use futures_util::stream::FuturesUnordered;
use futures_util::{FutureExt, Sink, SinkExt, Stream, StreamExt};
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::oneshot;
use tower_lsp::jsonrpc::{Request, Response};
use tower_lsp::{ClientSocket, LspService};
use tower_service::Service;

use crate::protocol::types::Uri;
use crate::session::backend::Backend;
use frame::{Frame, Frames};
use message::{Incoming, code, failure};
use spelling::Spelling;

/// Maximum number of requests in progress; the input is not read beyond that.
const CONCURRENCY: usize = 256;
/// Timeout for writing the last answers after `exit`.
const FINAL_WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// The phase of the session, as the protocol defines it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Only `initialize` and `exit` are served.
    Before,
    Serving,
    /// Only `exit` is served.
    ShutDown,
    /// `exit` was sent.
    Exited,
}

/// Serves messages until the client sends `exit` or closes its end.
pub(crate) async fn serve(
    input: impl AsyncRead + Unpin,
    output: impl AsyncWrite,
    service: LspService<Backend>,
    socket: ClientSocket,
    initialize: Arc<OnceLock<Value>>,
) {
    let (requests, responses) = socket.split();
    let (answers, outgoing) = unbounded_channel();
    let spelling = Arc::new(Mutex::new(Spelling::default()));
    let (client_gone, gone) = oneshot::channel();
    let session = Transport {
        client_gone: Some(client_gone),
        service,
        initialize,
        answers,
        spelling: spelling.clone(),
        phase: Phase::Before,
    };
    let writing = write(output, outgoing, requests, spelling);
    tokio::pin!(writing);
    tokio::select! {
        // The client has closed its end.
        _ = &mut writing => return,
        () = session.run(input, responses) => {}
        Ok(()) = gone => return,
    }
    // A client may not read its last answers.
    let _ = tokio::time::timeout(FINAL_WRITE_TIMEOUT, writing).await;
}

struct Transport {
    service: LspService<Backend>,
    /// The parameters of `initialize` as JSON. The typed parameters lose capabilities beyond the protocol,
    /// such as clangd's inactive regions.
    initialize: Arc<OnceLock<Value>>,
    answers: UnboundedSender<Value>,
    spelling: Arc<Mutex<Spelling>>,
    /// Receives the end of the client's process, if its id is known.
    client_gone: Option<oneshot::Sender<()>>,
    phase: Phase,
}

/// A request in progress, with its answer if it needs one.
type Call = futures_util::future::BoxFuture<'static, Option<Value>>;

impl Transport {
    /// Reads and serves until `exit` or the end of the input. The writer ends with the session.
    async fn run(
        mut self,
        mut input: impl AsyncRead + Unpin,
        mut responses: impl Sink<Response> + Unpin,
    ) {
        let mut calls = FuturesUnordered::<Call>::new();
        let mut frames = Frames::default();
        let mut piece = vec![0; 64 << 10];
        while self.phase != Phase::Exited {
            tokio::select! {
                Some(answer) = calls.next(), if !calls.is_empty() => self.answer(answer),
                read = input.read(&mut piece), if calls.len() < CONCURRENCY => {
                    let count = read.unwrap_or(0);
                    if count == 0 {
                        break;
                    }
                    frames.push(&piece[..count]);
                    while self.phase != Phase::Exited && let Some(frame) = frames.next() {
                        let body = match frame {
                            Frame::Body(body) => body,
                            Frame::Malformed(what) => {
                                self.refuse(&Value::Null, code::PARSE_ERROR, what);
                                continue;
                            }
                        };
                        match message::parse(&body) {
                            Ok(parsed) => {
                                if !parsed.rest.is_empty() {
                                    frames.unread(&parsed.rest);
                                }
                                let incoming = message::classify(parsed.value);
                                let call = self.take(incoming, parsed.mended, &mut responses).await;
                                calls.extend(call);
                            }
                            Err(error) => {
                                if let Some(at) = frame::header_at_end(&body) {
                                    frames.unread(&body[at..]);
                                }
                                let message = format!("this message is not valid JSON: {error}");
                                self.refuse(&Value::Null, code::PARSE_ERROR, &message);
                            }
                        }
                    }
                }
            }
        }
        // `exit` has cancelled the requests in progress; their answers report that.
        while let Some(Some(answer)) = calls.next().now_or_never() {
            self.answer(answer);
        }
    }

    fn answer(&self, answer: Option<Value>) {
        if let Some(answer) = answer {
            // Fails only if the client has closed its end.
            let _ = self.answers.send(answer);
        }
    }

    fn refuse(&self, id: &Value, code: i64, message: &str) {
        tracing::warn!("a message of the client is refused: {message}");
        self.answer(Some(failure(id, code, message)));
    }

    async fn take(
        &mut self,
        incoming: Incoming,
        mended: bool,
        responses: &mut (impl Sink<Response> + Unpin),
    ) -> Option<Call> {
        match incoming {
            Incoming::Request(request) => return self.serve(request, mended).await,
            Incoming::Response(response) => {
                // Fails only after `exit`.
                let _ = responses.send(response).await;
            }
            Incoming::Invalid(id, what) => self.refuse(&id, code::INVALID_REQUEST, &what),
        }
        None
    }

    /// Begins to serve a request. Returns the rest of its work.
    async fn serve(&mut self, request: Request, mended: bool) -> Option<Call> {
        let method = request.method().to_owned();
        let id = request.id().map(|id| json!(id));
        tracing::debug!(method, ?id, "received");
        if let Some((code, why)) = self.refusal(&method) {
            if let Some(id) = &id {
                self.refuse(id, code, why);
            }
            return None;
        }
        // The spellings are those of the message as it came.
        if let Some(params) = request.params() {
            lock(&self.spelling).store_uris(&method, params);
        }
        let request = self.mend(request)?;
        if method == "initialize"
            && let Some(params) = request.params()
        {
            self.watch_client(&params["processId"]);
            self.initialize.get_or_init(|| params.clone());
        }
        let changes = matches!(&*method, "textDocument/didOpen" | "textDocument/didChange");
        let document =
            (mended && changes).then(|| request.params().and_then(document_of)).flatten();
        let ready = std::future::poll_fn(|context| self.service.poll_ready(context));
        if ready.await.is_err() {
            self.phase = Phase::Exited;
            return None;
        }
        let mut call = answered(self.service.call(request), id, method.clone());
        // A message enters the queue of the writer before its first `await`, so messages keep their order.
        let first = match method.as_str() {
            // Later messages depend on the result of these two.
            "initialize" | "shutdown" => Poll::Ready((&mut call).await),
            _ => futures_util::poll!(&mut call),
        };
        match (method.as_str(), &first) {
            ("initialize", Poll::Ready(Some(answer))) if answer.get("result").is_some() => {
                self.phase = Phase::Serving;
            }
            ("shutdown", _) => self.phase = Phase::ShutDown,
            ("exit", _) => self.phase = Phase::Exited,
            _ => {}
        }
        if let Some(document) = document {
            self.service.inner().mended(document);
        }
        match first {
            Poll::Ready(answer) => {
                self.answer(answer);
                None
            }
            Poll::Pending => Some(call),
        }
    }

    /// Changes the parameters of a message to what the protocol types accept. `None`: the message is a
    /// notification that cannot be read.
    fn mend(&self, request: Request) -> Option<Request> {
        let is_notification = request.id().is_none();
        let (method, id, params) = request.into_parts();
        let params = params.map(|mut params| {
            for removed in lenient::mend(&method, &mut params) {
                tracing::warn!("{method}: ignored {removed}");
            }
            params
        });
        if is_notification
            && let Some(error) = lenient::error(&method, params.as_ref().unwrap_or(&Value::Null))
        {
            let document = params.as_ref().and_then(document_of);
            let name = document.as_ref().map_or("no document", |uri| uri.as_str());
            tracing::error!("{method} cannot be read ({name}): {error}");
            if let Some(document) = document {
                self.service.inner().unreadable(document);
            }
            return None;
        }
        let mut request = Request::build(method);
        if let Some(params) = params {
            request = request.params(params);
        }
        if let Some(id) = id {
            request = request.id(id);
        }
        Some(request.finish())
    }

    fn watch_client(&mut self, process: &Value) {
        if let (Some(id), Some(tell)) = (process.as_i64(), self.client_gone.take()) {
            let gone = client_process::gone(id);
            tokio::spawn(async move {
                if gone.await.is_ok() {
                    // Fails when the session has ended.
                    let _ = tell.send(());
                }
            });
        }
    }

    /// The error for a method that is not served in this phase, or never.
    fn refusal(&self, method: &str) -> Option<(i64, &'static str)> {
        if method == "exit" {
            return None;
        }
        match self.phase {
            Phase::Before if method != "initialize" => {
                let why = "the server is not initialized: `initialize` comes first";
                Some((code::NOT_INITIALIZED, why))
            }
            Phase::Serving if method == "initialize" => {
                Some((code::INVALID_REQUEST, "the server is initialized already"))
            }
            Phase::ShutDown | Phase::Exited => {
                let why = "the server was shut down: only `exit` may follow";
                Some((code::INVALID_REQUEST, why))
            }
            _ => None,
        }
    }
}

/// The document of a notification.
fn document_of(params: &Value) -> Option<Uri> {
    params["textDocument"]["uri"].as_str()?.parse().ok()
}

/// Ensures that a message with an `id` gets an answer.
fn answered<E: Send + 'static>(
    call: impl Future<Output = Result<Option<Response>, E>> + Send + 'static,
    id: Option<Value>,
    method: String,
) -> Call {
    Box::pin(async move {
        let answer = call.await.ok().flatten();
        let answer = answer.and_then(|answer| serde_json::to_value(answer).ok());
        match (answer, id) {
            (Some(answer), _) => Some(answer),
            (None, None) => None,
            // The library does not answer unknown methods of the protocol, nor notifications.
            (None, Some(id)) if method.starts_with("$/") && method != "$/cancelRequest" => {
                let message = format!("there is no method `{method}`");
                Some(failure(&id, code::METHOD_NOT_FOUND, &message))
            }
            (None, Some(id)) if method == "shutdown" => {
                Some(failure(&id, code::INTERNAL_ERROR, "the server cannot be shut down"))
            }
            (None, Some(id)) => Some(json!({ "jsonrpc": "2.0", "id": id, "result": null })),
        }
    })
}

/// Sends answers and the server's own messages until both sources are closed.
async fn write(
    output: impl AsyncWrite,
    mut answers: UnboundedReceiver<Value>,
    mut requests: impl Stream<Item = Request> + Unpin,
    spelling: Arc<Mutex<Spelling>>,
) -> std::io::Result<()> {
    tokio::pin!(output);
    let mut open = true;
    loop {
        tokio::select! {
            answer = answers.recv() => {
                let Some(answer) = answer else { break };
                // Parts of an answer (`$/progress`) are sent before the answer, but through another channel.
                // The client drops parts that arrive after their answer, so all messages sent so far are
                // written first.
                let mut earlier = Vec::new();
                while let Some(Some(request)) = requests.next().now_or_never() {
                    earlier.push(json!(request));
                }
                for message in earlier.into_iter().chain([answer]) {
                    send(output.as_mut(), message, &spelling).await?;
                }
            }
            request = requests.next(), if open => match request {
                Some(request) => send(output.as_mut(), json!(request), &spelling).await?,
                None => open = false,
            },
        }
    }
    while open && let Some(Some(request)) = requests.next().now_or_never() {
        send(output.as_mut(), json!(request), &spelling).await?;
    }
    output.flush().await
}

async fn send(
    mut output: std::pin::Pin<&mut impl AsyncWrite>,
    mut message: Value,
    spelling: &Mutex<Spelling>,
) -> std::io::Result<()> {
    let before = lock(spelling).apply(&mut message);
    for message in before.iter().chain([&message]) {
        let body = message.to_string();
        let head = format!("Content-Length: {}\r\n\r\n", body.len());
        output.write_all(head.as_bytes()).await?;
        output.write_all(body.as_bytes()).await?;
    }
    output.flush().await
}

fn lock(spelling: &Mutex<Spelling>) -> std::sync::MutexGuard<'_, Spelling> {
    spelling.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A client drops a part of an answer that arrives after the answer.
    #[tokio::test]
    async fn what_was_handed_over_before_an_answer_is_sent_before_it() {
        let parts = (0..32).map(|part| Request::build("$/progress").params(json!(part)).finish());
        let (answers, outgoing) = unbounded_channel();
        answers.send(json!({ "jsonrpc": "2.0", "id": 1, "result": [] })).unwrap();
        drop(answers);
        let mut output = Vec::new();
        let parts = futures_util::stream::iter(parts);
        write(&mut output, outgoing, parts, Arc::default()).await.unwrap();

        let mut frames = Frames::default();
        frames.push(&output);
        let mut order = Vec::new();
        while let Some(Frame::Body(body)) = frames.next() {
            order.push(message::parse(&body).unwrap().value["method"].clone());
        }
        let mut expected = vec![json!("$/progress"); 32];
        expected.push(Value::Null);
        assert_eq!(order, expected);
    }
}
