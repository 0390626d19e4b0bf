//! The server around the backend: custom methods, and the end of the session.

use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::watch;

use crate::protocol::types::LspService;
use crate::session::backend::Backend;
use crate::session::{requests, transport};

/// Serves one client until it sends `exit` or closes its end. Returns true if it sent `shutdown` before.
pub async fn serve(input: impl AsyncRead + Unpin, output: impl AsyncWrite) -> bool {
    let initialize = Arc::new(OnceLock::new());
    let shut_down = Arc::new(AtomicBool::new(false));
    let (close, closed) = watch::channel(false);
    let input = Input { input, close };
    let (service, socket) = {
        let (initialize, shut_down) = (initialize.clone(), shut_down.clone());
        let backend = |client| Backend::new(client, initialize, shut_down, closed);
        let builder = LspService::build(backend);
        let builder = requests::custom_methods(builder);
        #[cfg(test)]
        let builder = crate::tests::custom_methods(builder);
        builder.finish()
    };
    transport::serve(input, output, service, socket, initialize).await;
    shut_down.load(Ordering::Acquire)
}

/// The input, which reports that the client has closed its end: requests that wait for a change then end.
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
