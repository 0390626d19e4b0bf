//! Verification on edit, in the background, after a pause in typing. It verifies every scenario that concerns
//! an open document, and every open specification with timing that no scenario uses.
//!
//! The writer owns a [`Verifier`]; requests see its [`Results`] in their snapshot. An edit of a file that a
//! verification read cancels the verification at once and makes its answer *stale*. The answer is used again
//! if its inputs turn out to be unchanged, now or later.

mod job;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};

use crate::config::Verification as Settings;
use crate::features::verification::problems::VerificationRequest;
use crate::protocol::messages::{VerificationStatus, VerificationStatusParams};
use crate::protocol::outbox::Outbox;
use crate::session::post::Post;
use dotgen_views::verification::results::{Answer, Entry, Results, Status};
use dotgen_views::verification::run::Interim;

pub(crate) use job::JobResult;

/// The pause in typing before a verification.
const DEBOUNCE: Duration = Duration::from_millis(120);
/// The pause before a verification that is expected to be quick.
const QUICK_DEBOUNCE: Duration = Duration::from_millis(30);
/// The longest quick verification, in seconds.
const QUICK_SECONDS: f64 = 0.05;

/// Maximum number of old answers that are kept, in case an edit is undone.
const MAX_CACHED_ANSWERS: usize = 24;

/// The verifications of the open documents.
#[derive(Default)]
pub(crate) struct Verifier {
    results: Arc<Results>,
    remembered: VecDeque<Arc<Answer>>,
    jobs: u64,
    /// All verifications have ended, each within [`QUICK_SECONDS`].
    is_quick: bool,
    told: SentStatuses,
}

/// Messages to the writer.
pub(crate) enum News {
    /// The pause for this revision is over.
    Due(u64),
    /// The problems to verify.
    VerificationRequest(Vec<VerificationRequest>),
    /// A verification has a result.
    JobResult(Box<JobResult>),
}

/// The last status sent to the client, by document; `None` if the client does not support it.
type SentStatuses = Option<BTreeMap<Utf8PathBuf, VerificationStatusParams>>;

impl Verifier {
    /// Sets if the client wants the status of verifications.
    pub(crate) fn initialize(&mut self, tell: bool) {
        self.told = tell.then(BTreeMap::new);
    }

    /// The results, for snapshots.
    pub(crate) fn results(&self) -> &Arc<Results> {
        &self.results
    }

    /// The pause in typing before the next verification: short if the last ones were quick.
    pub(crate) fn debounce(&self) -> Duration {
        if self.is_quick { QUICK_DEBOUNCE } else { DEBOUNCE }
    }

    /// Handles changes of files: results computed from them become stale, and work on them is cancelled.
    /// Returns true if a shown result was affected.
    pub(crate) fn touched(&mut self, files: &[Utf8PathBuf], outbox: &Outbox) -> bool {
        let read = |entry: &Entry| files.iter().any(|file| entry.problem.reads(file));
        if !self.results.values().any(read) {
            return false;
        }
        let mut changed = false;
        for (path, entry) in Arc::make_mut(&mut self.results) {
            if entry.status != Status::Stale && read(entry) {
                entry.cancel.abandon();
                entry.status = Status::Stale;
                entry.holds = false;
                changed = true;
                notify(&mut self.told, path, entry, outbox);
            }
        }
        changed
    }

    /// Starts new verifications, cancels those no longer wanted, and uses known answers again.
    pub(crate) fn start(
        &mut self,
        wanted: Vec<VerificationRequest>,
        settings: &Settings,
        outbox: &Outbox,
        events: &Post<News>,
    ) {
        let options = settings.options();
        let results = Arc::make_mut(&mut self.results);
        results.retain(|path, entry| {
            let stays = wanted.iter().any(|request| request.path == *path);
            if !stays {
                entry.cancel.abandon();
                if let Some(told) = &mut self.told {
                    told.remove(path);
                }
            }
            stays
        });
        for VerificationRequest { path, version, problem } in wanted {
            let before = results.remove(&path);
            if let Some(mut entry) = before.clone()
                && entry.problem.is_same(&problem)
                && entry.options == options
                && (entry.status == Status::Running || entry.settled().is_some())
                && !entry.cancel.is_abandoned()
            {
                entry.version = version;
                // The problem is equal, but its places may differ.
                entry.problem = Arc::new(problem);
                notify(&mut self.told, &path, &entry, outbox);
                results.insert(path, entry);
                continue;
            }
            if let Some(entry) = &before {
                entry.cancel.abandon();
            }
            self.jobs += 1;
            let mut known = self.remembered.iter();
            let known =
                known.find(|answer| answer.problem.is_same(&problem) && answer.options == options);
            let known = known.cloned();
            let status = match &known {
                _ if !problem.errors.is_empty() => Status::Blocked,
                Some(answer) => answer.status(),
                None => Status::Running,
            };
            let bounds = known.as_ref().map(|answer| answer.bounds.clone());
            let holds = known.is_some();
            let entry = Entry {
                status,
                version,
                // Places must refer to the present text.
                problem: Arc::new(problem),
                answer: match status {
                    Status::Blocked => None,
                    _ => known.or(before.and_then(|change| change.answer)),
                },
                holds,
                bounds: bounds.unwrap_or_default(),
                options: options.clone(),
                job: self.jobs,
                cancel: Arc::default(),
            };
            notify(&mut self.told, &path, &entry, outbox);
            if status == Status::Running {
                let job = job::Job {
                    path: path.clone(),
                    number: entry.job,
                    problem: entry.problem.clone(),
                    options: options.clone(),
                    limit: settings.time_limit(),
                };
                job.spawn(entry.cancel.clone(), events.clone(), outbox.runtime());
                self.is_quick = false;
            }
            results.insert(path, entry);
        }
    }

    /// Cancels all work.
    pub(crate) fn stop(&mut self) -> bool {
        let any = !self.results.is_empty();
        for entry in std::mem::take(&mut self.results).values() {
            entry.cancel.abandon();
        }
        self.remembered.clear();
        any
    }

    /// Stores a result. Returns true if the result was awaited.
    pub(crate) fn finish(&mut self, finished: JobResult, outbox: &Outbox) -> bool {
        let Some(entry) = self.results.get(&finished.path) else {
            return false;
        };
        if entry.job != finished.number || entry.cancel.is_abandoned() {
            return false;
        }
        let results = Arc::make_mut(&mut self.results);
        let Some(entry) = results.get_mut(&finished.path) else {
            return false;
        };
        match finished.found {
            Interim::Bounds(bounds) => entry.bounds = bounds,
            // An interim result that arrives after the full answer.
            Interim::SoFar(_) if entry.status != Status::Running => return false,
            Interim::SoFar(answer) => (entry.answer, entry.holds) = (Some(answer), true),
            Interim::Answer(answer) => {
                self.remembered.retain(|known| {
                    !known.problem.is_same(&answer.problem) || known.options != answer.options
                });
                self.remembered.push_front(answer.clone());
                self.remembered.truncate(MAX_CACHED_ANSWERS);
                entry.status = answer.status();
                (entry.answer, entry.holds) = (Some(answer), true);
            }
        }
        notify(&mut self.told, &finished.path, entry, outbox);
        let quick = |entry: &Entry| {
            let answer = entry.settled();
            answer.is_some_and(|answer| answer.report.seconds <= QUICK_SECONDS)
        };
        self.is_quick = self.results.values().all(quick);
        true
    }
}

impl Drop for Verifier {
    /// Cancels the work when the server ends.
    fn drop(&mut self) {
        self.stop();
    }
}

fn notify(told: &mut SentStatuses, path: &Utf8Path, entry: &Entry, outbox: &Outbox) {
    let (Some(uri), Some(told)) = (crate::protocol::convert::uri::from_path(path), told) else {
        return;
    };
    let (known, settled) = (entry.known(), entry.settled());
    let params = VerificationStatusParams {
        uri,
        version: entry.version,
        status: entry.status,
        scenario: entry.problem.scenario.name.clone(),
        written: entry.problem.is_written(),
        answered: known.map(|answer| answer.report.answered()),
        checks: known.map(|answer| answer.report.checks.len()),
        minimum_cores: settled.and_then(|answer| answer.cores.as_ref()?.cores),
        states: settled.map(|answer| answer.report.states),
        seconds: settled.map(|answer| answer.report.seconds),
    };
    if told.get(path) != Some(&params) {
        told.insert(path.to_owned(), params.clone());
        outbox.notify::<VerificationStatus>(params);
    }
}
