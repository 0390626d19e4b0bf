//! Updates of the database after changes.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::Change;
use dotgen_analysis::language::Language;
use rustc_hash::FxHashSet;

use super::State;
use super::session::Stale;
use crate::session::post::Post;
use crate::workspace::codels;
use dotgen_platform::files::vfs;

/// Changes that are not in the database yet.
#[derive(Default)]
pub(super) struct Pending {
    pub(super) files: FxHashSet<Utf8PathBuf>,
    pub(super) roots: bool,
    pub(super) config: bool,
    pub(super) packages: bool,
    pub(super) active: bool,
    pub(super) chosen: bool,
    pub(super) indexed: Option<bool>,
}

impl Pending {
    /// All files and settings. `indexed`: see [`Change::indexed`].
    pub(super) fn everything(files: FxHashSet<Utf8PathBuf>, indexed: bool) -> Pending {
        let (roots, config, packages, active, chosen) = (true, true, true, true, true);
        Pending { files, roots, config, packages, active, chosen, indexed: indexed.then_some(true) }
    }
}

impl State {
    /// Updates the database.
    pub(super) fn flush(&mut self) {
        let pending = std::mem::take(&mut self.pending);
        let settings = pending.roots || pending.config || pending.packages;
        if !(settings || pending.indexed.is_some() || !pending.files.is_empty()) {
            return;
        }
        if pending.roots {
            let open = self.documents.open_files().keys();
            let (mut code, mut specifications) = (Vec::new(), Vec::new());
            for path in open.filter(|path| !self.documents.is_lost(path)) {
                match self.language_of(path) {
                    Language::Specification => specifications.push(path),
                    Language::Codel => code.push(path),
                    Language::Scenario | Language::Template => {}
                }
            }
            let mut roots: Vec<_> =
                self.workspace.files.iter().chain(specifications).cloned().collect();
            // A source finds its specification even if its folder is not searched.
            let home = |source: &&Utf8PathBuf| codels::home(self.config.codels_of(source)?, source);
            let homes = code.iter().filter_map(home);
            roots.extend(homes.flat_map(|home| vfs::specifications_in(&home)));
            roots.sort();
            roots.dedup();
            self.roots = Arc::new(roots);
        }
        let mut pending = pending;
        if pending.config {
            // A text that was too large may be within the new limit.
            let open = self.documents.open_files().keys();
            pending.files.extend(open.cloned());
        }
        let touched: Vec<Utf8PathBuf> = pending.files.iter().cloned().collect();
        if self.verifier.touched(&touched, &self.outbox) {
            self.show_verification();
        }
        let text = |path: &Utf8Path| match self.documents.text(path) {
            Some(text) => Some(text.to_string()),
            // A document that differs from the client's text gets no findings.
            None => self.documents.is_lost(path).then(String::new),
        };
        let files = pending.files.into_iter().map(|file| (text(&file), file));
        let change = Change {
            files: files.map(|(text, path)| (path, text)).collect(),
            roots: pending.roots.then(|| self.roots.to_vec()),
            active: self.focus.active.clone().filter(|_| pending.active),
            chosen: pending.chosen.then(|| self.focus.chosen.clone()),
            config: pending.config.then(|| self.config.for_analysis()),
            reload_packages: pending.packages,
            indexed: pending.indexed,
        };
        if change.reload_packages {
            // It knows the packages as they were.
            codels::lock(&self.codels.workshop).take();
        }
        {
            let _span = tracing::debug_span!("apply", files = change.files.len()).entered();
            self.host.apply(change);
        }
        self.revisions.send_modify(|revision| *revision += 1);
        self.publisher.changed(self.revision(), &self.outbox, &Post::new(&self.events));
        self.schedule_verification();
        if std::mem::take(&mut self.publisher.refresh_wanted) {
            self.refresh(Stale::Meaning);
        }
    }
}
