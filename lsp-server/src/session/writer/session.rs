//! The session with the client: notifications and requests at the start, and refresh requests later.

use std::sync::Arc;

use serde_json::Value;

use super::State;
use crate::protocol::client::ClientCaps;
use crate::protocol::types::*;
use crate::session::capabilities::{self, ForeignDocuments};

/// The results that the client has to request again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stale {
    /// Diagnostics and lenses.
    Findings,
    /// Diagnostics, lenses and semantic tokens: the meaning of names has changed.
    Meaning,
}

impl State {
    pub(super) fn initialize(
        &mut self,
        params: &InitializeParams,
        raw: &Value,
    ) -> InitializeResult {
        self.client = Arc::new(ClientCaps::new(params, raw));
        self.reported.settings = self.workspace.initialize(params);
        self.publisher.initialize(&self.client);
        self.verifier.initialize(self.client.verification_status);
        self.reconfigure();
        InitializeResult {
            capabilities: capabilities::server_capabilities(&self.client),
            server_info: Some(ServerInfo {
                name: "dotgen".to_owned(),
                version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            }),
            offset_encoding: None,
        }
    }

    pub(super) fn initialized(&mut self) {
        self.initialized = true;
        self.report_problems();
        self.show_settings_problems();
        let registrations = capabilities::registrations(&self.client);
        if !registrations.is_empty() {
            self.outbox.run_conversation(|client| async move {
                if let Err(error) = client.register_capability(registrations).await {
                    tracing::warn!("the client refused a registration: {error}");
                }
            });
        }
        self.register_documents();
        self.pull_settings();
        self.scan();
    }

    /// Registers sources of codels and template files with the client, again if other files are needed.
    pub(super) fn register_documents(&mut self) {
        if !self.initialized || !self.client.documents_registration {
            return;
        }
        let wanted = ForeignDocuments {
            codels: self.config.codel_folders(),
            templates: self.workspace.templates.globs(),
        };
        if self.foreign == wanted {
            return;
        }
        let before = std::mem::replace(&mut self.foreign, wanted.clone());
        let (definition, hover) =
            (self.client.definition_registration, self.client.hover_registration);
        let offered = move |method: &str| match method {
            "textDocument/definition" => definition,
            "textDocument/hover" => hover,
            _ => true,
        };
        self.outbox.run_conversation(move |client| async move {
            let mut gone = before.unregistrations();
            gone.retain(|unregistration| offered(&unregistration.method));
            if !gone.is_empty() {
                let _ = client.unregister_capability(gone).await;
            }
            let mut new = wanted.registrations();
            new.retain(|registration| offered(&registration.method));
            if !new.is_empty()
                && let Err(error) = client.register_capability(new).await
            {
                tracing::warn!("the client refused a registration: {error}");
            }
        });
    }

    /// Requests a refresh from the client: something other than the open document has changed.
    pub(super) fn refresh(&self, stale: Stale) {
        let diagnostics = self.client.pull_diagnostics && self.client.diagnostic_refresh;
        let tokens = stale == Stale::Meaning && self.client.semantic_tokens_refresh;
        let lenses = self.client.code_lens_refresh;
        self.outbox.run_conversation(move |client| async move {
            // A client that refuses shows old results until the next edit.
            if diagnostics {
                let _ = client.workspace_diagnostic_refresh().await;
            }
            if tokens {
                let _ = client.semantic_tokens_refresh().await;
            }
            if lenses {
                let _ = client.code_lens_refresh().await;
            }
        });
    }
}
