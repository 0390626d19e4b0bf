//! Messages to the client, in order, from threads that must not block.

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

/// The queue of messages. Cheap to clone.
#[derive(Clone)]
pub(crate) struct Outbox {
    client: Client,
    jobs: UnboundedSender<Job>,
    runtime: Handle,
}

impl Outbox {
    /// Creates the queue. Must be called on the runtime.
    pub(crate) fn new(client: Client) -> Outbox {
        let (jobs, mut queue) = unbounded_channel::<Job>();
        let runtime = Handle::current();
        runtime.spawn(async move {
            while let Some(job) = queue.recv().await {
                job.await;
            }
        });
        Outbox { client, jobs, runtime }
    }

    /// Sends a notification after all earlier ones.
    pub(crate) fn notify<N>(&self, params: N::Params)
    where
        N: Notification + 'static,
        N::Params: Send,
    {
        let client = self.client.clone();
        let job: Job = Box::pin(async move { client.send_notification::<N>(params).await });
        // Fails only after the end of the runtime.
        let _ = self.jobs.send(job);
    }

    /// Publishes diagnostics of a file without a version: it is not open, or they hold for every version.
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

    /// Runs a conversation with the client (requests that await answers) in the background.
    pub(crate) fn run_conversation<F>(&self, conversation: impl FnOnce(Client) -> F)
    where
        F: Future<Output = ()> + Send + 'static,
    {
        self.runtime.spawn(conversation(self.client.clone()));
    }

    /// The client, for direct requests.
    pub(crate) fn client(&self) -> &Client {
        &self.client
    }

    pub(crate) fn runtime(&self) -> &Handle {
        &self.runtime
    }
}
