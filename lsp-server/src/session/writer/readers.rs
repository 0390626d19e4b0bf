//! Readers: requests and the computation of diagnostics get a snapshot in their turn and work on other
//! threads.

use std::cell::RefCell;
use std::sync::Arc;

use super::State;
use crate::protocol::convert::uri;
use crate::session::dispatch::{Admission, ReadRequest};
use crate::session::post::Post;
use crate::session::publish::Run;
use crate::workspace::snapshot::{Snapshot, Subject};

/// The requests and computations that read a snapshot.
#[derive(Default)]
pub(super) struct Readers {
    /// Every snapshot has a clone of it: the count shows the number of readers.
    count: Arc<()>,
    /// True if many requests were served since memory was last released.
    have_worked: bool,
}

impl State {
    pub(super) fn snapshot(&self) -> Snapshot {
        Snapshot {
            analysis: self.host.analysis(),
            open: self.documents.open_files().clone(),
            roots: self.roots.clone(),
            folders: Arc::new(self.workspace.scanned_folders()),
            config: self.config.clone(),
            client: self.client.clone(),
            revision: self.revision(),
            verification: self.verifier.results().clone(),
            scenarios: self.workspace.scenarios.clone(),
            templates: self.workspace.templates.clone(),
            vfs: self.vfs.clone(),
            codels: self.codels.clone(),
            progress: Arc::default(),
            readers: self.readers.count.clone(),
            lines: RefCell::default(),
        }
    }

    /// Admits a request in its turn and sends it to the blocking pool.
    pub(super) fn admit(&mut self, read: ReadRequest) {
        if read.control.is_cancelled() {
            return;
        }
        let mut read = read;
        // A client that watches files may be late, which is rare and costs little here. A list of all actions
        // is requested at every move of the cursor.
        if read.edits && (read.whole || !self.client.watched_files) {
            self.reread_changed();
        }
        if read.whole && !self.client.watched_files && !read.is_listed {
            self.scan();
        }
        if read.whole && self.listings.running > 0 {
            read.is_listed = true;
            // The request is about the present text.
            let subject = read.subject.as_ref().map(uri::to_path);
            let version = subject.and_then(|subject| {
                self.documents.open_files().get(&subject).map(|file| file.version)
            });
            read.expected.get_or_insert(version);
            return self.listings.waiting.push(read);
        }
        let subject = read.subject.map(|uri| {
            let path = uri::to_path(&uri);
            let version = self.documents.open_files().get(&path).map(|file| file.version);
            Subject { path, uri, version }
        });
        if let Some(subject) = &subject {
            let unknown = match subject.version {
                Some(_) => self.documents.is_lost(&subject.path),
                None => !subject.path.is_file(),
            };
            if unknown {
                return (read.work)(Admission::UnknownDocument);
            }
            if read.expected.is_some_and(|version| version != subject.version) {
                return (read.work)(Admission::Outdated);
            }
        }
        self.flush();
        if read.bulk {
            self.rest();
        }
        let snapshot = self.snapshot();
        read.control.attach(snapshot.analysis.cancellation_token());
        let work = read.work;
        self.outbox
            .runtime()
            .spawn_blocking(move || work(Admission::Admitted(Box::new(snapshot), subject)));
    }

    pub(super) fn publish(&mut self, revision: u64) {
        self.flush();
        if self.publisher.is_due(revision, self.revision())
            && let Some(run) = self.publisher.start(self.revision())
        {
            self.continue_run(run);
        }
    }

    /// Continues a computation of diagnostics, unless a change has cancelled it and scheduled the next one.
    pub(super) fn continue_run(&mut self, run: Run) {
        self.rest();
        if run.revision() != self.revision() || run.is_done() {
            return;
        }
        let snapshot = self.snapshot();
        run.step(snapshot, Post::new(&self.events), self.outbox.runtime());
    }

    /// Releases memory of results that can be computed again, after many requests. Runs only without readers,
    /// which it would cancel.
    pub(super) fn rest(&mut self) {
        let idle = Arc::strong_count(&self.readers.count) == 1;
        if idle && std::mem::take(&mut self.readers.have_worked) {
            self.host.evict_cache();
        }
        self.readers.have_worked = true;
    }
}
