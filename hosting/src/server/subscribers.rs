//! Clients that subscribe to the progress of a run, to its violations, or to the lines of its profile.

use std::io::{self, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

use dotgen_runtime::progress::{Progress, ProgressReceiver};
use dotgen_runtime::report::ViolationReport;
use dotgen_timing::report::TimeUnit;
use serde_json::{Value, json};

use super::{Client, Shared, State};

/// Violations that are kept for clients that subscribe later: fewer than lines that a client may be behind.
const MAX_VIOLATIONS: usize = 512;

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

/// Sends violations to clients.
pub struct ViolationSubscribers(pub(super) Arc<Shared>);

impl ViolationSubscribers {
    /// Sends a violation: its place in the report, and what is violated, in words. A repeated one comes
    /// again.
    pub fn receive(&self, number: usize, violation: &ViolationReport, unit: TimeUnit, what: &str) {
        let event = json!({
            "event": "violation",
            "number": number,
            "unit": unit,
            "what": what,
            "violation": violation,
        });
        let mut state = self.0.state();
        for (client, id) in &state.violation_subscribers {
            client.say(event.clone(), id);
        }
        match state.violations.get_mut(number) {
            Some(last) => *last = event,
            None if number < MAX_VIOLATIONS => state.violations.push(event),
            None => {}
        }
    }
}

impl State {
    /// Ends a subscription of a client. Returns false if it has none with this `id`.
    pub(super) fn unsubscribe_violations(&mut self, client: &Client, id: &Value) -> bool {
        let all = &mut self.violation_subscribers;
        let before = all.len();
        all.retain(|(other, other_id)| other.number != client.number || other_id != id);
        all.len() < before
    }
}

/// Returns the event of a line of the profile.
pub(super) fn ran(line: &str) -> Value {
    json!({"event": "ran", "line": line.trim_end()})
}

/// Sends lines of the profile to clients.
pub struct ProfileSubscribers(pub(super) Arc<Shared>);

impl Write for ProfileSubscribers {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let state = self.0.state();
        if !state.followers.is_empty() {
            let told = ran(&String::from_utf8_lossy(line));
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
