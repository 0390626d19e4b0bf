//! Clients that subscribe to the progress of a run, or to the lines of its profile.

use std::io::{self, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

use dotgen_runtime::progress::{Progress, ProgressReceiver};
use serde_json::json;

use super::Shared;

/// Minimum time between two reports of progress.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Sends the progress of the run to clients.
pub struct ProgressSubscribers {
    pub(super) shared: Arc<Shared>,
    /// Time of the last report.
    pub(super) told: Option<Instant>,
}

impl ProgressReceiver for ProgressSubscribers {
    fn is_due(&mut self) -> bool {
        let due = self.told.is_none_or(|instant| instant.elapsed() >= PROGRESS_INTERVAL);
        if !due {
            return false;
        }
        self.told = Some(Instant::now());
        !self.shared.state().progress_subscribers.is_empty()
    }

    fn receive(&mut self, progress: Progress) {
        let Ok(mut told) = serde_json::to_value(&progress) else {
            return;
        };
        told["event"] = "progress".into();
        let remote = self.shared.remote.list();
        if !remote.is_empty() {
            told["remote"] = remote.into();
        }
        for (client, id) in &self.shared.state().progress_subscribers {
            // A missed report is contained in the next one.
            client.offer(told.clone(), id);
        }
    }
}

/// Sends lines of the profile to clients.
pub struct ProfileSubscribers(pub(super) Arc<Shared>);

impl Write for ProfileSubscribers {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let state = self.0.state();
        if !state.followers.is_empty() {
            let text = String::from_utf8_lossy(line);
            let told = json!({"event": "ran", "line": text.trim_end()});
            for (client, id) in &state.followers {
                client.say(told.clone(), id);
            }
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
