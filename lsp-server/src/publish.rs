//! Diagnostics and inactive regions, pushed: computed after a pause in typing, sent with the
//! version they hold for, and only when they differ from what the client has.
//!
//! Clients that pull diagnostics get those of specifications that way (see `handlers::diagnostic`),
//! and only those of sources of codels and files of templates pushed: editors ask other servers for
//! these.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Cancellable, Cancelled};
use rustc_hash::{FxHashMap, FxHashSet};
use tokio::runtime::Handle;
use tokio::sync::mpsc::{UnboundedSender, WeakUnboundedSender};

use crate::caps::ClientCaps;
use crate::codels::{around, fingerprint, sources_with_findings};
use crate::ext::{InactiveRegions, InactiveRegionsParams};
use crate::handlers::{
    self,
    diagnostic::{file_diagnostics, inactive_ranges, least, survived},
};
use crate::outbox::Outbox;
use crate::panic;
use crate::proto::{
    Diagnostic, PublishDiagnosticsParams, Range, Uri, VersionedTextDocumentIdentifier, notification,
};
use crate::snapshot::{OpenFile, Snapshot};
use crate::state::Event;

/// The pause in typing that is waited for.
const DEBOUNCE: Duration = Duration::from_millis(60);
/// Whoever types without a pause sees diagnostics at least this often.
const PATIENCE: Duration = Duration::from_millis(1000);

/// What a run of the computation found.
pub(crate) enum Computed {
    /// About one file.
    File(Box<FileResult>),
    /// About all of them.
    Finished {
        /// These files have something to say, the others nothing.
        files: BTreeSet<Utf8PathBuf>,
        /// Stands for what specifications and sources say of each other.
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

/// What the client was told, and what it is yet to be told.
#[derive(Default)]
pub(crate) struct Publisher {
    push: bool,
    regions: bool,
    dirty_since: Option<Instant>,
    sent: FxHashMap<Utf8PathBuf, Sent>,
    codels: Option<u64>,
    /// Something else than an open document changed since the client was last asked to refresh.
    pub(crate) refresh_wanted: bool,
}

#[derive(Default)]
struct Sent {
    diagnostics: Vec<Diagnostic>,
    regions: Vec<Range>,
}

impl Publisher {
    /// Learns what the client wants to be told.
    pub(crate) fn initialize(&mut self, client: &ClientCaps) {
        self.push = !client.pull_diagnostics;
        self.regions = client.inactive_regions;
    }

    /// The database has a new revision: computes after a pause.
    pub(crate) fn changed(
        &mut self,
        revision: u64,
        outbox: &Outbox,
        events: &WeakUnboundedSender<Event>,
    ) {
        self.dirty_since.get_or_insert_with(Instant::now);
        let events = events.clone();
        outbox.runtime().spawn(async move {
            tokio::time::sleep(DEBOUNCE).await;
            if let Some(events) = events.upgrade() {
                let _ = events.send(Event::PublishDue(revision));
            }
        });
    }

    /// Whether the pause has come: nothing changed since, or it has been put off for too long.
    pub(crate) fn is_due(&mut self, revision: u64, current: u64) -> bool {
        let since = self.dirty_since;
        let due = revision == current || since.is_some_and(|it| it.elapsed() > PATIENCE);
        if due {
            self.dirty_since = None;
        }
        due
    }

    /// Computes on the blocking pool; open documents first.
    pub(crate) fn compute(
        &self,
        snapshot: Snapshot,
        events: UnboundedSender<Event>,
        runtime: &Handle,
    ) {
        let (push, regions) = (self.push, self.regions);
        runtime.spawn_blocking(move || {
            let run = panic::isolate(|| compute(&snapshot, push, regions, &events));
            drop(snapshot);
            match run {
                // A change came in between: it has scheduled the next run.
                // `PropagatedPanic` too: see `dispatch`.
                Ok(
                    Ok(())
                    | Err(Cancelled::PendingWrite | Cancelled::Local | Cancelled::PropagatedPanic),
                ) => {}
                Err(message) => tracing::error!("diagnostics panicked: {message}"),
            }
        });
    }

    /// Sends what is new of a result. Whether what one file says of another has changed, so that a
    /// client that asks should ask again.
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
                let gone: Vec<_> = self.sent.keys().filter(|it| !files.contains(*it)).collect();
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
        let FileResult {
            path, uri, version, ..
        } = result;
        if open.get(&path).map(|it| it.version) != version {
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

    /// Takes back what was said about a file.
    pub(crate) fn clear(&mut self, path: &Utf8Path, outbox: &Outbox) {
        let Some(sent) = self.sent.get_mut(path) else {
            return;
        };
        if !std::mem::take(&mut sent.diagnostics).is_empty() {
            outbox.publish(path, Vec::new());
        }
    }

    /// A document was opened: what is known of it is sent again, under the URI that its client uses now.
    pub(crate) fn reopen(&mut self, path: &Utf8Path) {
        self.sent.remove(path);
    }

    /// A document was closed: its client forgets the regions.
    pub(crate) fn forget(&mut self, path: &Utf8Path) {
        if let Some(sent) = self.sent.get_mut(path) {
            sent.regions.clear();
        }
    }
}

fn compute(
    snapshot: &Snapshot,
    push: bool,
    regions: bool,
    events: &UnboundedSender<Event>,
) -> Cancellable<()> {
    let mut files = BTreeSet::new();
    let mut seen = FxHashSet::default();
    let mut one = |path: &Utf8Path, files: &mut BTreeSet<Utf8PathBuf>| -> Cancellable<()> {
        if !seen.insert(path.to_owned()) {
            return Ok(());
        }
        let result = panic::isolate(|| file(snapshot, path, push, regions));
        let result = survived(path, result)?.flatten();
        if let Some(result) = result {
            files.insert(path.to_owned());
            let _ = events.send(Event::Computed(Computed::File(Box::new(result))));
        }
        Ok(())
    };
    for path in snapshot.open.keys() {
        one(path, &mut files)?;
    }
    if push {
        for path in handlers::diagnostic::files(snapshot)? {
            one(&path, &mut files)?;
        }
    }
    let sources = survived(
        "sources".into(),
        panic::isolate(|| sources_with_findings(snapshot)),
    )?;
    for path in sources.into_iter().flatten() {
        one(&path, &mut files)?;
    }
    let codels = survived("codels".into(), panic::isolate(|| fingerprint(snapshot)))?;
    let codels = codels.unwrap_or_default();
    let _ = events.send(Event::Computed(Computed::Finished { files, codels }));
    Ok(())
}

/// What is to be said about a file; `None` for one that has no text or is of no concern.
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
    let is_code = snapshot.is_code(path);
    if is_code && around(snapshot, path)?.is_empty() {
        return Ok(None);
    }
    let is_template = snapshot.is_template(path);
    let diagnostics = match push || is_code || is_template {
        true => Some(file_diagnostics(snapshot, path, least(snapshot, path))?),
        false => None,
    };
    let regions = match regions && open.is_some() && !is_code && !is_template {
        true => Some(inactive_ranges(snapshot, path)?),
        false => None,
    };
    Ok(Some(FileResult {
        path: path.to_owned(),
        uri,
        version: open.map(|it| it.version),
        diagnostics,
        regions,
    }))
}
