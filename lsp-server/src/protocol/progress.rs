//! Work-done progress, for clients that show it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::protocol::types::{
    Client, ProgressParams, ProgressParamsValue, ProgressToken, WorkDoneProgress,
    WorkDoneProgressBegin, WorkDoneProgressEnd, WorkDoneProgressReport, notification,
};

/// The progress shown by the client, and the functions that cancel the work.
#[derive(Clone)]
pub(crate) struct ProgressReporter {
    client: Client,
    inner: Arc<Mutex<Inner>>,
}

#[derive(Default)]
struct Inner {
    next: u64,
    /// The function that cancels the work, by token.
    stops: BTreeMap<String, Box<dyn Fn() + Send>>,
}

/// One progress that is shown. The owner must call `end`.
pub(crate) struct Running {
    shown: ProgressReporter,
    name: String,
}

impl ProgressReporter {
    pub(crate) fn new(client: Client) -> ProgressReporter {
        ProgressReporter { client, inner: Arc::default() }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins to show a progress that can be cancelled; `None` if the client refuses.
    pub(crate) async fn begin(
        &self,
        title: &str,
        stop: impl Fn() + Send + 'static,
    ) -> Option<Running> {
        let running = self.create().await?;
        running.show(title, stop).await;
        Some(running)
    }

    /// Asks the client for a token. The progress is not shown yet.
    pub(crate) async fn create(&self) -> Option<Running> {
        let name = {
            let mut inner = self.inner();
            inner.next += 1;
            format!("dotgen/{}", inner.next)
        };
        let token = ProgressToken::String(name.clone());
        self.client.create_work_done_progress(token).await.ok()?;
        Some(Running { shown: self.clone(), name })
    }

    /// `window/workDoneProgress/cancel`
    pub(crate) fn cancel(&self, token: &ProgressToken) {
        if let ProgressToken::String(name) = token
            && let Some(stop) = self.inner().stops.get(name)
        {
            stop();
        }
    }
}

impl Running {
    /// Shows the progress.
    pub(crate) async fn show(&self, title: &str, stop: impl Fn() + Send + 'static) {
        let name = self.name.clone();
        self.shown.inner().stops.insert(name, Box::new(stop));
        let begin = WorkDoneProgressBegin {
            title: title.to_owned(),
            cancellable: Some(true),
            ..WorkDoneProgressBegin::default()
        };
        self.tell(WorkDoneProgress::Begin(begin)).await;
    }

    /// Reports the progress in percent.
    pub(crate) async fn report(&self, percentage: u32) {
        let report = WorkDoneProgressReport {
            cancellable: Some(true),
            percentage: Some(percentage),
            ..WorkDoneProgressReport::default()
        };
        self.tell(WorkDoneProgress::Report(report)).await;
    }

    /// Ends the progress, after the work is finished or cancelled.
    pub(crate) async fn end(self) {
        self.shown.inner().stops.remove(&self.name);
        let end = WorkDoneProgressEnd::default();
        self.tell(WorkDoneProgress::End(end)).await;
    }

    async fn tell(&self, value: WorkDoneProgress) {
        let params = ProgressParams {
            token: ProgressToken::String(self.name.clone()),
            value: ProgressParamsValue::WorkDone(value),
        };
        let client = &self.shown.client;
        client.send_notification::<notification::Progress>(params).await;
    }
}

/// Begins to show a progress that cannot be cancelled; `None` if the client does not support it.
pub(crate) async fn begin(client: &Client, wanted: bool, title: &str) -> Option<Unstoppable> {
    if !wanted {
        return None;
    }
    let token = ProgressToken::String(format!("dotgen/{}", title.to_lowercase()));
    client.create_work_done_progress(token.clone()).await.ok()?;
    Some(client.progress(token, title.to_owned()).begin().await)
}

pub(crate) async fn end(progress: Option<Unstoppable>, message: String) {
    if let Some(progress) = progress {
        progress.finish_with_message(message).await;
    }
}

type Unstoppable = tower_lsp::OngoingProgress<tower_lsp::Unbounded, tower_lsp::NotCancellable>;
