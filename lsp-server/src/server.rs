//! The server around the backend: transport, custom methods, and a look at what the protocol types
//! would lose.

use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll};

use serde_json::Value;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::watch;
use tower_lsp::jsonrpc::Request;
use tower_service::Service;

use crate::backend::Backend;
use crate::proto::{LspService, Server};

/// Messages that may be in work at once. The library's default of 4 counts notifications too: four
/// waiting requests would keep `didChange` and `$/cancelRequest` out.
const CONCURRENCY: usize = 256;

/// Serves one client until it sends `exit` or closes its end. Whether it said `shutdown` before.
pub async fn serve(input: impl AsyncRead + Unpin, output: impl AsyncWrite) -> bool {
    let initialize = Arc::new(OnceLock::new());
    let shut_down = Arc::new(AtomicBool::new(false));
    let (close, closed) = watch::channel(false);
    let input = Input { input, close };
    let (service, socket) = {
        let (initialize, shut_down) = (initialize.clone(), shut_down.clone());
        let backend = |client| Backend::new(client, initialize, shut_down, closed);
        let builder = LspService::build(backend);
        custom_methods(builder).finish()
    };
    Server::new(input, output, socket)
        .concurrency_level(CONCURRENCY)
        .serve(Listen {
            service,
            initialize,
        })
        .await;
    shut_down.load(Ordering::Acquire)
}

type Builder = tower_lsp::LspServiceBuilder<Backend>;

/// Methods beyond the protocol; see `docs/protocol.md`.
fn custom_methods(builder: Builder) -> Builder {
    let builder = builder
        .custom_method("dotgen/syntaxTree", Backend::syntax_tree)
        .custom_method("dotgen/itemTree", Backend::item_tree)
        .custom_method("dotgen/expandMacro", Backend::expand_macro)
        .custom_method("dotgen/includingRoots", Backend::including_roots)
        .custom_method("dotgen/release", Backend::release)
        .custom_method("dotgen/diagram", Backend::diagram)
        .custom_method("dotgen/verification", Backend::verification)
        .custom_method("dotgen/sensitivity", Backend::sensitivity)
        .custom_method("dotgen/codelHeaders", Backend::codel_headers)
        .custom_method("dotgen/model", Backend::model)
        .custom_method("window/workDoneProgress/cancel", Backend::cancel_progress);
    #[cfg(test)]
    let builder = crate::tests::custom_methods(builder);
    builder
}

/// Keeps the parameters of `initialize` as they came: the typed ones lose capabilities that are
/// not of the protocol, such as clangd's inactive regions.
struct Listen<S> {
    service: S,
    initialize: Arc<OnceLock<Value>>,
}

impl<S: Service<Request>> Service<Request> for Listen<S> {
    type Response = S::Response;
    type Error = S::Error;
    type Future = S::Future;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Self::Error>> {
        self.service.poll_ready(context)
    }

    fn call(&mut self, request: Request) -> Self::Future {
        tracing::debug!(method = request.method(), id = ?request.id(), "received");
        if request.method() == "initialize"
            && let Some(params) = request.params()
        {
            self.initialize.get_or_init(|| params.clone());
        }
        self.service.call(request)
    }
}

/// Tells when the client has closed its end: nobody waits for news then.
struct Input<I> {
    input: I,
    close: watch::Sender<bool>,
}

impl<I: AsyncRead + Unpin> AsyncRead for Input<I> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<std::io::Result<()>> {
        let before = buffer.filled().len();
        let poll = Pin::new(&mut self.input).poll_read(context, buffer);
        let ended = match &poll {
            Poll::Ready(Ok(())) => buffer.filled().len() == before && buffer.capacity() > before,
            Poll::Ready(Err(_)) => true,
            Poll::Pending => false,
        };
        if ended {
            self.close.send_replace(true);
        }
        poll
    }
}
