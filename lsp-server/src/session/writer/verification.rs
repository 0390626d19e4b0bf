//! When verification runs, and how its results reach the client.

use super::session::Stale;
use super::{Event, State};
use crate::features::verification::problems;
use crate::panic;

impl State {
    /// Verifies after a pause.
    pub(super) fn schedule_verification(&mut self) {
        if !self.config.verification.on_edit() {
            if self.verifier.stop() {
                self.show_verification();
            }
            return;
        }
        let (events, revision) = (self.events.clone(), self.revision);
        self.outbox.runtime().spawn(async move {
            tokio::time::sleep(crate::session::verifier::DEBOUNCE).await;
            if let Some(events) = events.upgrade() {
                let _ = events.send(Event::VerifyDue(revision));
            }
        });
    }

    /// Works out on the blocking pool what is to be verified.
    pub(super) fn verify(&mut self, revision: u64) {
        self.flush();
        let Some(events) = self.events.upgrade().filter(|_| revision == self.revision) else {
            return;
        };
        let snapshot = self.snapshot();
        self.outbox.runtime().spawn_blocking(move || {
            let wanted = panic::isolate(|| problems::wanted(&snapshot));
            drop(snapshot);
            match wanted {
                Ok(Ok(wanted)) => {
                    let _ = events.send(Event::Verify(wanted));
                }
                // A change came in between: it has scheduled the next run.
                Ok(Err(_)) => {}
                Err(message) => tracing::error!("verification panicked: {message}"),
            }
        });
    }

    /// What verification has to say has changed: diagnostics, lenses.
    pub(super) fn show_verification(&mut self) {
        self.publisher
            .changed(self.revision, &self.outbox, &self.events);
        self.refresh(Stale::Findings);
    }
}
