//! Listings of the files of the workspace, and what waits for them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use camino::Utf8PathBuf;
use dotgen_analysis::host::Cancelled;
use dotgen_analysis::language::{self, SCENARIO, SPECIFICATION};

use super::{Event, Mutation, State};
use crate::protocol::progress;
use crate::protocol::types::MessageType;
use crate::session::dispatch::ReadRequest;
use dotgen_platform::files::vfs;

/// The state of the listings.
#[derive(Default)]
pub(super) struct Listings {
    /// Number of listings in progress.
    pub(super) running: usize,
    /// True after the first listing.
    pub(super) is_listed: bool,
    /// The number of the last requested listing.
    pub(super) last: u64,
    /// Requests that wait for the end of the listing.
    pub(super) waiting: Vec<ReadRequest>,
    /// The last message about folders that cannot be listed, which is shown once.
    shown: Arc<Mutex<Option<String>>>,
}

impl State {
    /// Sets the files of the workspace.
    pub(super) fn set_listed(&mut self, files: Vec<Utf8PathBuf>) {
        // Only requests about the whole workspace wait for the first listing.
        if !std::mem::replace(&mut self.listings.is_listed, true) {
            self.pending.indexed = Some(false);
        }
        let configured = self.workspace.set_files(files);
        self.pending.roots = true;
        if configured { self.reconfigure() } else { self.register_documents() }
    }

    /// Reads the includes of every root on the blocking pool. Returns true if that has begun.
    pub(super) fn index(&mut self) -> bool {
        let Some(events) = self.events.upgrade() else {
            return false;
        };
        self.flush();
        let analysis = self.host.analysis();
        self.outbox.runtime().spawn_blocking(move || {
            let looked = catch_unwind(AssertUnwindSafe(|| analysis.index()));
            drop(analysis);
            let found = match looked {
                Ok(Ok(found)) => Some(found),
                Ok(Err(Cancelled::PendingWrite)) => None,
                // After a panic, the request for the affected file reports it.
                _ => Some(true),
            };
            let _ = events.send(Event::Mutation(Mutation::Indexed(found)));
        });
        true
    }

    /// Handles the end of a listing: admits the waiting requests.
    pub(super) fn settle_listing(&mut self) {
        self.listings.running = self.listings.running.saturating_sub(1);
        if self.listings.running == 0 {
            for read in std::mem::take(&mut self.listings.waiting) {
                self.admit(read);
            }
        }
    }

    /// Lists the files of the workspace folders, with progress.
    pub(super) fn scan(&mut self) {
        self.listings.last += 1;
        let number = self.listings.last;
        let folders = self.workspace.scanned_folders();
        let Some(events) = self.events.upgrade().filter(|_| !folders.is_empty()) else {
            return;
        };
        self.listings.running += 1;
        let wants_progress = self.client.progress;
        let last_shown = self.listings.shown.clone();
        self.outbox.run_conversation(move |client| async move {
            let shown = progress::begin(&client, wants_progress, "Indexing").await;
            let listing = tokio::task::spawn_blocking(move || {
                let below = |path: &Utf8PathBuf| {
                    vfs::files_below(path, &[SPECIFICATION, SCENARIO, "tcl", "toml"])
                };
                let mut found = vfs::FilesBelow::default();
                for one in folders.iter().map(below) {
                    found.files.extend(one.files);
                    found.unreadable.extend(one.unreadable);
                }
                found
            });
            let vfs::FilesBelow { files, unreadable } = listing.await.unwrap_or_default();
            let message = told_unreadable(&unreadable);
            let before = std::mem::replace(
                &mut *last_shown.lock().unwrap_or_else(PoisonError::into_inner),
                message.clone(),
            );
            if let Some(message) = message.filter(|message| before.as_ref() != Some(message)) {
                client.show_message(MessageType::WARNING, message).await;
            }
            let specifications = files.iter().filter(|file| language::is_specification(file));
            let summary = match specifications.count() {
                1 => "1 specification".to_owned(),
                count => format!("{count} specifications"),
            };
            let _ = events.send(Event::Mutation(Mutation::Scanned(number, files)));
            progress::end(shown, summary).await;
        });
    }
}

/// The message about folders that cannot be listed: their specifications are not part of the workspace.
fn told_unreadable(folders: &[vfs::UnreadableFolder]) -> Option<String> {
    let first = folders.first()?;
    let more = match folders.len() - 1 {
        0 => String::new(),
        more => format!(" (and {more} more)"),
    };
    Some(format!("{first}{more}. The specifications below are not part of the workspace."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_cannot_be_listed_are_one_message() {
        let folder = |path: &str| vfs::UnreadableFolder {
            path: path.into(),
            reason: "permission denied".to_owned(),
        };
        assert_eq!(told_unreadable(&[]), None);
        let told = told_unreadable(&[folder("/a"), folder("/b")]);
        let expected = "cannot list the folder `/a`: permission denied (and 1 more). The specifications below \
                        are not part of the workspace.";
        assert_eq!(told.as_deref(), Some(expected));
    }
}
