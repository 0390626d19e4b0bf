//! Work-done progress, for clients that show it.

use crate::protocol::types::{Client, ProgressToken};

/// Begins to show progress; `None` if the client cannot.
pub(crate) async fn begin(client: &Client, wanted: bool, title: &str) -> Option<Progress> {
    if !wanted {
        return None;
    }
    let token = ProgressToken::String(format!("dotgen/{}", title.to_lowercase()));
    client.create_work_done_progress(token.clone()).await.ok()?;
    Some(client.progress(token, title.to_owned()).begin().await)
}

/// Ends it.
pub(crate) async fn end(progress: Option<Progress>, message: String) {
    if let Some(progress) = progress {
        progress.finish_with_message(message).await;
    }
}

type Progress = tower_lsp::OngoingProgress<tower_lsp::Unbounded, tower_lsp::NotCancellable>;
