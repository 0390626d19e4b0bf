//! The session with the client: what it was told and asked at the start, and what it is asked again later.

use std::sync::Arc;

use serde_json::Value;

use super::State;
use crate::protocol::client::ClientCaps;
use crate::protocol::types::*;
use crate::session::capabilities::{self, ForeignDocuments};

/// What the client has to ask for again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stale {
    /// Diagnostics and lenses.
    Findings,
    /// Colours as well: what names mean.
    Meaning,
}

impl State {
    pub(super) fn initialize(
        &mut self,
        params: &InitializeParams,
        raw: &Value,
    ) -> InitializeResult {
        self.client = Arc::new(ClientCaps::new(params, raw));
        self.settings_problems = self.workspace.initialize(params);
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
            self.outbox.converse(|client| async move {
                if let Err(error) = client.register_capability(registrations).await {
                    tracing::warn!("the client refused a registration: {error}");
                }
            });
        }
        self.register_documents();
        self.pull_settings();
        self.scan();
    }

    /// Asks the client for sources of codels and files of templates, again when others are wanted.
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
        let (definition, hover) = (
            self.client.definition_registration,
            self.client.hover_registration,
        );
        let offered = move |method: &str| match method {
            "textDocument/definition" => definition,
            "textDocument/hover" => hover,
            _ => true,
        };
        self.outbox.converse(move |client| async move {
            let mut gone = before.unregistrations();
            gone.retain(|it| offered(&it.method));
            if !gone.is_empty() {
                let _ = client.unregister_capability(gone).await;
            }
            let mut new = wanted.registrations();
            new.retain(|it| offered(&it.method));
            if !new.is_empty()
                && let Err(error) = client.register_capability(new).await
            {
                tracing::warn!("the client refused a registration: {error}");
            }
        });
    }

    /// Asks the client to ask again: something else than the open document has changed.
    pub(super) fn refresh(&self, stale: Stale) {
        let diagnostics = self.client.pull_diagnostics && self.client.diagnostic_refresh;
        let tokens = stale == Stale::Meaning && self.client.semantic_tokens_refresh;
        let lenses = self.client.code_lens_refresh;
        self.outbox.converse(move |client| async move {
            // A client that refuses shows what it has until the next edit.
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
