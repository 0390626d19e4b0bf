//! Diagnostics and inactive regions that the server pushes. They are computed after a pause in typing, and
//! sent with the document's version if they differ from those of the client.
//!
//! Clients that pull diagnostics get those of specifications by pull (see `features::diagnostics`). Only
//! diagnostics of sources of codels and template files are then pushed: editors ask other servers for these.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Cancellable, Cancelled};
use rustc_hash::{FxHashMap, FxHashSet};
use tokio::runtime::Handle;

use crate::features::codels::{fingerprint, sources_with_findings};
use crate::features::diagnostics::{self, file_diagnostics, inactive_ranges, least, survived};
use crate::features::features_of;
use crate::protocol::client::ClientCaps;
use crate::protocol::messages::{InactiveRegions, InactiveRegionsParams};
use crate::protocol::outbox::Outbox;
use crate::protocol::types::{
    Diagnostic, PublishDiagnosticsParams, Range, Uri, VersionedTextDocumentIdentifier, notification,
};
use crate::session::post::Post;
use crate::workspace::documents::Documents;
use crate::workspace::snapshot::{OpenFile, Snapshot};
use dotgen_platform::panic;

/// The pause in typing before a computation.
const DEBOUNCE: Duration = Duration::from_millis(60);
/// Maximum delay of diagnostics while the user types without a pause.
const MAX_DELAY: Duration = Duration::from_secs(1);

/// Messages to the writer.
pub(crate) enum News {
    /// The pause for this revision is over.
    Due(u64),
    /// Diagnostics and regions of a file were computed.
    Computed(Computed),
    /// A part of the computation is done.
    Step(Box<Run>),
}

/// Results of a computation.
pub(crate) enum Computed {
    /// About one file.
    File(Box<FileResult>),
    /// The end of the computation.
    Finished {
        /// The files with diagnostics; all other files have none.
        files: BTreeSet<Utf8PathBuf>,
        /// Hash of the findings about specifications and sources.
        codels: u64,
    },
}

/// See [`Computed`].
pub(crate) struct FileResult {
    path: Utf8PathBuf,
    uri: Uri,
    version: Option<i32>,
    diagnostics: Option<Vec<Diagnostic>>,
    regions: Option<Vec<Range>>,
}

/// The diagnostics of the client, and the state of the computation.
#[derive(Default)]
pub(crate) struct Publisher {
    push: bool,
    regions: bool,
    dirty_since: Option<Instant>,
    sent: FxHashMap<Utf8PathBuf, SentDiagnostics>,
    codels: Option<u64>,
    /// The revision of the present or last computation.
    started: Option<u64>,
    /// True if anything but an open document changed since the last refresh request to the client.
    pub(crate) refresh_wanted: bool,
}

#[derive(Default)]
struct SentDiagnostics {
    diagnostics: Vec<Diagnostic>,
    regions: Vec<Range>,
}

impl Publisher {
    /// Reads the capabilities of the client.
    pub(crate) fn initialize(&mut self, client: &ClientCaps) {
        self.push = !client.pull_diagnostics;
        self.regions = client.inactive_regions;
    }

    /// The database has a new revision: computes after a pause.
    pub(crate) fn changed(&mut self, revision: u64, outbox: &Outbox, events: &Post<News>) {
        self.dirty_since.get_or_insert_with(Instant::now);
        let events = events.clone();
        outbox.runtime().spawn(async move {
            tokio::time::sleep(DEBOUNCE).await;
            events.send(News::Due(revision));
        });
    }

    /// True if the pause is over: nothing changed since, or the maximum delay has passed.
    pub(crate) fn is_due(&mut self, revision: u64, current: u64) -> bool {
        let since = self.dirty_since;
        let due = revision == current || since.is_some_and(|instant| instant.elapsed() > MAX_DELAY);
        if due {
            self.dirty_since = None;
        }
        due
    }

    /// Begins a computation for a revision. `None` if that computation was begun before.
    pub(crate) fn start(&mut self, revision: u64) -> Option<Run> {
        let started = self.started.replace(revision) == Some(revision);
        (!started).then(|| Run {
            revision,
            push: self.push,
            regions: self.regions,
            left: None,
            seen: FxHashSet::default(),
            files: BTreeSet::new(),
            done: false,
        })
    }

    /// Sends the changed part of a result. Returns true if findings about specifications and sources together
    /// have changed, so that a client that pulls has to ask again.
    pub(crate) fn publish(
        &mut self,
        computed: Computed,
        open: &FxHashMap<Utf8PathBuf, OpenFile>,
        outbox: &Outbox,
    ) -> bool {
        match computed {
            Computed::File(result) => {
                self.publish_file(*result, open, outbox);
                false
            }
            Computed::Finished { files, codels } => {
                let gone: Vec<_> = self.sent.keys().filter(|key| !files.contains(*key)).collect();
                for path in gone.into_iter().cloned().collect::<Vec<_>>() {
                    self.clear(&path, outbox);
                    self.sent.remove(&path);
                }
                let before = self.codels.replace(codels);
                before.unwrap_or_default() != codels
            }
        }
    }

    fn publish_file(
        &mut self,
        result: FileResult,
        open: &FxHashMap<Utf8PathBuf, OpenFile>,
        outbox: &Outbox,
    ) {
        let FileResult { path, uri, version, .. } = result;
        if open.get(&path).map(|file| file.version) != version {
            return;
        }
        let is_new = !self.sent.contains_key(&path);
        let sent = self.sent.entry(path).or_default();
        if let Some(diagnostics) = result.diagnostics
            && (sent.diagnostics != diagnostics || is_new && version.is_some())
        {
            sent.diagnostics.clone_from(&diagnostics);
            outbox.notify::<notification::PublishDiagnostics>(PublishDiagnosticsParams {
                uri: uri.clone(),
                diagnostics,
                version,
            });
        }
        if let (Some(regions), Some(version)) = (result.regions, version)
            && sent.regions != regions
        {
            sent.regions.clone_from(&regions);
            outbox.notify::<InactiveRegions>(InactiveRegionsParams {
                text_document: VersionedTextDocumentIdentifier { uri, version },
                regions,
            });
        }
    }

    /// Clears the diagnostics of a file.
    pub(crate) fn clear(&mut self, path: &Utf8Path, outbox: &Outbox) {
        let Some(sent) = self.sent.get_mut(path) else {
            return;
        };
        if !std::mem::take(&mut sent.diagnostics).is_empty() {
            outbox.publish(path, Vec::new());
        }
    }

    /// Clears the diagnostics of the closed files below a folder that are outside the workspace.
    pub(crate) fn clear_below(
        &mut self,
        folder: &Utf8Path,
        is_outside: impl Fn(&Utf8Path) -> bool,
        documents: &Documents,
        outbox: &Outbox,
    ) {
        let paths = self.sent.keys().filter(|path| path.starts_with(folder) && is_outside(path));
        let paths = paths.filter(|path| !documents.open_files().contains_key(*path));
        for path in paths.cloned().collect::<Vec<_>>() {
            self.clear(&path, outbox);
            self.sent.remove(&path);
        }
    }

    /// Handles the opening of a document: its diagnostics are sent again, under the URI that the client uses
    /// now.
    pub(crate) fn resend_diagnostics(&mut self, path: &Utf8Path) {
        self.sent.remove(path);
    }

    /// Handles the closing of a document: the client drops its regions.
    pub(crate) fn forget(&mut self, path: &Utf8Path) {
        if let Some(sent) = self.sent.get_mut(path) {
            sent.regions.clear();
        }
    }
}

/// Number of files whose diagnostics are computed together. In between, changes and requests are served, and
/// analysis evicts what it stored about the files.
const BATCH: usize = 32;

/// The computation of all diagnostics of a revision, in parts: open documents first.
pub(crate) struct Run {
    revision: u64,
    push: bool,
    regions: bool,
    /// Remaining files, the next one last. `None`: open documents are next.
    left: Option<Vec<Utf8PathBuf>>,
    seen: FxHashSet<Utf8PathBuf>,
    /// The files with diagnostics.
    files: BTreeSet<Utf8PathBuf>,
    done: bool,
}

impl Run {
    /// The revision of the computation.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// True if every part is done.
    pub(crate) fn is_done(&self) -> bool {
        self.done
    }

    /// Computes the next part on the blocking pool and sends it to the writer.
    pub(crate) fn step(mut self, snapshot: Snapshot, events: Post<News>, runtime: &Handle) {
        runtime.spawn_blocking(move || {
            let step = panic::isolate(|| self.compute(&snapshot, &events));
            drop(snapshot);
            match step {
                Ok(Ok(())) => {
                    events.send(News::Step(Box::new(self)));
                }
                // A change came in between and has scheduled the next run. The same holds for
                // `PropagatedPanic`, see `dispatch`.
                Ok(Err(
                    Cancelled::PendingWrite | Cancelled::Local | Cancelled::PropagatedPanic,
                )) => {}
                Err(message) => tracing::error!("diagnostics panicked: {message}"),
            }
        });
    }

    fn compute(&mut self, snapshot: &Snapshot, events: &Post<News>) -> Cancellable<()> {
        let Some(left) = &mut self.left else {
            let open = snapshot.open.keys().cloned().collect();
            self.compute_files(open, snapshot, events)?;
            let mut left =
                if self.push { diagnostics::listing(snapshot, &())?.rest } else { Vec::new() };
            left.reverse();
            self.left = Some(left);
            return Ok(());
        };
        if !left.is_empty() {
            let next = left.split_off(left.len().saturating_sub(BATCH));
            return self.compute_files(next, snapshot, events);
        }
        let sources =
            survived("sources".into(), panic::isolate(|| sources_with_findings(snapshot)))?;
        self.compute_files(sources.unwrap_or_default(), snapshot, events)?;
        let codels = survived("codels".into(), panic::isolate(|| fingerprint(snapshot)))?;
        events.send(News::Computed(Computed::Finished {
            files: std::mem::take(&mut self.files),
            codels: codels.unwrap_or_default(),
        }));
        self.done = true;
        Ok(())
    }

    /// Computes the diagnostics of some files, each separately.
    fn compute_files(
        &mut self,
        mut paths: Vec<Utf8PathBuf>,
        snapshot: &Snapshot,
        events: &Post<News>,
    ) -> Cancellable<()> {
        paths.retain(|path| self.seen.insert(path.clone()));
        let (push, regions) = (self.push, self.regions);
        let found = snapshot.on_all_cores(&paths, |snapshot, path| {
            let result = panic::isolate(|| file(snapshot, path, push, regions));
            let result = survived(path, result)?.flatten();
            let is_some = result.is_some();
            if let Some(result) = result {
                events.send(News::Computed(Computed::File(Box::new(result))));
            }
            Ok::<_, Cancelled>(is_some)
        });
        for (path, is_some) in std::iter::zip(paths, found) {
            if is_some? {
                self.files.insert(path);
            }
        }
        Ok(())
    }
}

/// The diagnostics of a file; `None` for a file without text or without diagnostics to push.
fn file(
    snapshot: &Snapshot,
    path: &Utf8Path,
    push: bool,
    regions: bool,
) -> Cancellable<Option<FileResult>> {
    let open = snapshot.open.get(path);
    let Some(uri) = snapshot.uri(path) else {
        return Ok(None);
    };
    let features = features_of(snapshot, path);
    if !(features.is_served)(snapshot, path)? {
        return Ok(None);
    }
    let own = features.is_own;
    let diagnostics = if push || !own {
        Some(file_diagnostics(snapshot, path, least(snapshot, path))?)
    } else {
        None
    };
    let regions = if regions && open.is_some() && own {
        Some(inactive_ranges(snapshot, path)?)
    } else {
        None
    };
    Ok(Some(FileResult {
        path: path.to_owned(),
        uri,
        version: open.map(|file| file.version),
        diagnostics,
        regions,
    }))
}
