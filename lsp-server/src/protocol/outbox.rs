//! Messages to the client, sent in order from threads that must not wait.

use std::future::Future;
use std::pin::Pin;

use camino::Utf8Path;
use tokio::runtime::Handle;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use crate::protocol::convert::uri;
use crate::protocol::types::{
    Client, Diagnostic, MessageType, Notification, PublishDiagnosticsParams, notification,
};

type Job = Pin<Box<dyn Future<Output = ()> + Send>>;

/// See the module. Cheap to clone.
#[derive(Clone)]
pub(crate) struct Outbox {
    client: Client,
    jobs: UnboundedSender<Job>,
    runtime: Handle,
}

impl Outbox {
    /// To be called on the runtime.
    pub(crate) fn new(client: Client) -> Outbox {
        let (jobs, mut queue) = unbounded_channel::<Job>();
        let runtime = Handle::current();
        runtime.spawn(async move {
            while let Some(job) = queue.recv().await {
                job.await;
            }
        });
        Outbox {
            client,
            jobs,
            runtime,
        }
    }

    /// Sends a notification after all earlier ones.
    pub(crate) fn notify<N>(&self, params: N::Params)
    where
        N: Notification + 'static,
        N::Params: Send,
    {
        let client = self.client.clone();
        let job: Job = Box::pin(async move { client.send_notification::<N>(params).await });
        // Fails only when the runtime is gone, and then there is nobody to tell.
        let _ = self.jobs.send(job);
    }

    /// Publishes diagnostics of a file that is not open, or all the same of every version.
    pub(crate) fn publish(&self, path: &Utf8Path, diagnostics: Vec<Diagnostic>) {
        if let Some(uri) = uri::from_path(path) {
            let params = PublishDiagnosticsParams::new(uri, diagnostics, None);
            self.notify::<notification::PublishDiagnostics>(params);
        }
    }

    /// Shows a message to the user.
    pub(crate) fn show(&self, typ: MessageType, message: String) {
        self.notify::<notification::ShowMessage>(crate::protocol::types::ShowMessageParams {
            typ,
            message,
        });
    }

    /// Runs a conversation with the client (requests that wait for answers) beside everything else.
    pub(crate) fn converse<F>(&self, conversation: impl FnOnce(Client) -> F)
    where
        F: Future<Output = ()> + Send + 'static,
    {
        self.runtime.spawn(conversation(self.client.clone()));
    }

    /// The client, to talk to it directly.
    pub(crate) fn client(&self) -> &Client {
        &self.client
    }

    /// The runtime.
    pub(crate) fn runtime(&self) -> &Handle {
        &self.runtime
    }
}
