//! The editor's settings and configuration files: requests for them, their combination, and reports of errors
//! in them.

use std::collections::BTreeSet;
use std::sync::Arc;

use camino::Utf8PathBuf;
use rustc_hash::FxHashSet;
use serde_json::Value;

use super::{Event, Mutation, State};
use crate::protocol::types::*;

/// The errors in settings that the client shows.
#[derive(Default)]
pub(super) struct Reported {
    /// Configuration files with diagnostics.
    files: FxHashSet<Utf8PathBuf>,
    /// The errors in the editor's settings.
    pub(super) settings: BTreeSet<String>,
}

impl State {
    /// Requests the settings of the client, if it supports that.
    pub(super) fn pull_settings(&self) {
        let Some(events) = self.events.upgrade().filter(|_| self.client.configuration) else {
            return;
        };
        let scopes = std::iter::once(None).chain(self.workspace.folder_uris().map(Some));
        let items = scopes
            .map(|scope_uri| ConfigurationItem { scope_uri, section: Some("dotgen".to_owned()) });
        let items = items.collect();
        self.outbox.run_conversation(|client| async move {
            match client.configuration(items).await {
                Ok(settings) => {
                    let _ = events.send(Event::Mutation(Mutation::SettingsPulled(settings)));
                }
                Err(error) => tracing::warn!("the client did not send its settings: {error}"),
            }
        });
    }

    pub(super) fn set_editor_settings(&mut self, settings: &[Value]) {
        let problems = self.workspace.set_editor_settings(settings);
        if self.reported.settings != problems {
            self.reported.settings = problems;
            self.show_settings_problems();
        }
        self.reconfigure();
    }

    pub(super) fn show_settings_problems(&self) {
        for problem in &self.reported.settings {
            let message = format!("dotgen, editor settings: {problem}");
            self.outbox.show(MessageType::WARNING, message);
        }
    }

    /// Computes the configuration again, and reports the errors in its files.
    pub(super) fn reconfigure(&mut self) {
        for file in self.workspace.config_files() {
            self.vfs.watch(&file);
        }
        let config = self.workspace.config();
        self.pending.packages |= self.vfs.set_packages(&config.packages);
        if *self.config != config {
            self.config = Arc::new(config);
            self.pending.config = true;
            self.publisher.refresh_wanted = true;
        }
        if self.initialized {
            self.report_problems();
        }
        self.register_documents();
    }

    /// Shows errors in configuration files, and clears those that are fixed.
    pub(super) fn report_problems(&mut self) {
        let problems = self.workspace.problems(self.client.encoding);
        let mut gone = std::mem::take(&mut self.reported.files);
        for (path, diagnostics) in problems {
            gone.remove(&path);
            self.reported.files.insert(path.clone());
            self.outbox.publish(&path, diagnostics);
        }
        for path in gone {
            self.outbox.publish(&path, Vec::new());
        }
    }
}
