//! The schedule of verification, and the delivery of its results to the client.

use super::State;
use super::session::Stale;
use crate::features::verification::problems;
use crate::session::post::Post;
use crate::session::verifier::News;
use dotgen_platform::panic;

impl State {
    /// Schedules a verification after a pause.
    pub(super) fn schedule_verification(&mut self) {
        if !self.config.verification.on_edit() {
            if self.verifier.stop() {
                self.show_verification();
            }
            return;
        }
        let (events, revision) = (Post::new(&self.events), self.revision());
        let pause = self.verifier.debounce();
        self.outbox.runtime().spawn(async move {
            tokio::time::sleep(pause).await;
            events.send(News::Due(revision));
        });
    }

    /// Computes the problems to verify, on the blocking pool.
    pub(super) fn verify(&mut self, revision: u64) {
        self.flush();
        if revision != self.revision() {
            return;
        }
        let events = Post::new(&self.events);
        let snapshot = self.snapshot();
        self.outbox.runtime().spawn_blocking(move || {
            let wanted = panic::isolate(|| problems::wanted(&snapshot));
            drop(snapshot);
            match wanted {
                Ok(Ok(wanted)) => {
                    events.send(News::VerificationRequest(wanted));
                }
                // A change came in between and has scheduled the next run.
                Ok(Err(_)) => {}
                Err(message) => tracing::error!("verification panicked: {message}"),
            }
        });
    }

    /// Updates diagnostics and lenses after a change of the results of verification.
    pub(super) fn show_verification(&mut self) {
        self.publisher.changed(self.revision(), &self.outbox, &Post::new(&self.events));
        self.refresh(Stale::Findings);
    }
}
