//! The requests: parameters, answer and handler.
//!
//! Most requests of the protocol are answered by the language of the document, with one of its
//! [features](crate::features::language::LanguageFeatures). Requests beyond the protocol name a handler, or
//! are methods of [`Backend`] if they talk to the client during the request.

use std::sync::atomic::Ordering;

use serde_json::Value;
use tokio::sync::oneshot;

use super::backend::{Backend, document_of, retriggered};
use super::dispatch::RequestScope;
use super::writer::{Event, Mutation};
use crate::features::language::LanguageFeatures;
use crate::features::specification::{call_hierarchy, code_lens, completion, rename};
use crate::features::{codels, commands, diagnostics, features_of, inspect, workspace_symbol};
use crate::protocol::messages::{
    ChooseRoot, DocumentParams, IncludingRoots, PositionParams, ReleaseInfo,
};
use crate::protocol::types::request::*;
use crate::protocol::types::*;
use crate::workspace::snapshot::or_empty;

pub(super) type Builder = tower_lsp::LspServiceBuilder<Backend>;

/// Registers the methods beyond the protocol; see `docs/protocol.md`.
pub(super) fn custom_methods(builder: Builder) -> Builder {
    builder
        .custom_method("dotgen/syntaxTree", Backend::syntax_tree)
        .custom_method("dotgen/itemTree", Backend::item_tree)
        .custom_method("dotgen/expandMacro", Backend::expand_macro)
        .custom_method("dotgen/includingRoots", Backend::including_roots)
        .custom_method("dotgen/release", Backend::release)
        .custom_method("dotgen/model", Backend::model)
        .custom_method("dotgen/diagram", Backend::diagram)
        .custom_method("dotgen/verification", Backend::verification)
        .custom_method("dotgen/trace", Backend::trace)
        .custom_method("dotgen/sensitivity", Backend::sensitivity)
        .custom_method("dotgen/exportModel", Backend::export_model)
        .custom_method("dotgen/codelHeaders", Backend::codel_headers)
        .custom_method("dotgen/interfaces", Backend::interfaces)
        .custom_method("dotgen/newComponent", Backend::new_component)
        .custom_method("window/workDoneProgress/cancel", Backend::cancel_progress)
}

/// Requests beyond the protocol about one document: method, answer, parameters. Their handlers are in
/// [`inspect`].
macro_rules! inspections {
    ($($method:ident -> $answer:ty, $params:ty;)*) => {
        $(async fn $method(&self, params: $params) -> Result<$answer> {
            let uri = params.text_document.uri.clone();
            self.dispatch.document(uri, params, inspect::$method).await
        })*
    };
}

impl Backend {
    inspections! {
        syntax_tree -> Option<String>, DocumentParams;
        item_tree -> Option<String>, DocumentParams;
        expand_macro -> Option<Value>, PositionParams;
        including_roots -> IncludingRoots, DocumentParams;
        release -> ReleaseInfo, DocumentParams;
        model -> Value, DocumentParams;
    }
}

/// The document in the parameters of a request.
macro_rules! document_in {
    (document, $params:ident) => {
        $params.text_document.uri.clone()
    };
    (position, $params:ident) => {
        $params.text_document_position.text_document.uri.clone()
    };
    (place, $params:ident) => {
        $params.text_document_position_params.text_document.uri.clone()
    };
}

/// Requests of the protocol that the language of the document answers: method, request, where its parameters
/// have the [document](document_in), feature.
macro_rules! features {
    ($($method:ident, $request:ident, $document:ident => $feature:ident;)*) => {
        $(async fn $method(
            &self,
            params: <$request as Request>::Params,
        ) -> Result<<$request as Request>::Result> {
            let uri = document_in!($document, params);
            self.dispatch.feature(uri, params, |features| features.$feature).await
        })*
    };
}

impl LanguageServer for Backend {
    features! {
        document_symbol, DocumentSymbolRequest, document => symbols;
        folding_range, FoldingRangeRequest, document => folds;
        selection_range, SelectionRangeRequest, document => selections;
        document_link, DocumentLinkRequest, document => links;
        semantic_tokens_full, SemanticTokensFullRequest, document => tokens;
        semantic_tokens_range, SemanticTokensRangeRequest, document => tokens_in;
        goto_definition, GotoDefinition, place => definition;
        goto_declaration, GotoDeclaration, place => declaration;
        goto_type_definition, GotoTypeDefinition, place => type_definition;
        goto_implementation, GotoImplementation, place => implementation;
        references, References, position => references;
        document_highlight, DocumentHighlightRequest, place => highlights;
        hover, HoverRequest, place => hover;
        completion, Completion, position => completion;
        signature_help, SignatureHelpRequest, place => signature;
        formatting, Formatting, document => format;
        range_formatting, RangeFormatting, document => format_range;
        on_type_formatting, OnTypeFormatting, position => format_typed;
        inlay_hint, InlayHintRequest, document => hints;
        code_lens, CodeLensRequest, document => lenses;
        prepare_call_hierarchy, CallHierarchyPrepare, place => calls;
    }

    async fn code_action(&self, params: CodeActionParams) -> Result<Option<CodeActionResponse>> {
        let uri = params.text_document.uri.clone();
        let actions = |features: &LanguageFeatures, snapshot: &_, subject: &_, params: &_| {
            or_empty((features.actions)(snapshot, subject, params))
        };
        self.dispatch.language(RequestScope::EDITS, uri, params, actions).await
    }

    async fn initialize(&self, params: InitializeParams) -> Result<InitializeResult> {
        let (reply, answer) = oneshot::channel();
        let raw = self.raw_initialize.get().cloned().unwrap_or_default();
        self.send(Event::Initialize(Box::new(params), raw, reply));
        answer.await.map_err(|_| Error::internal_error())
    }

    async fn initialized(&self, _: InitializedParams) {
        self.send(Event::Initialized);
    }

    async fn shutdown(&self) -> Result<()> {
        self.shut_down.store(true, Ordering::Release);
        Ok(())
    }

    async fn did_open(&self, params: DidOpenTextDocumentParams) {
        self.mutate(Mutation::Open(params));
    }

    async fn did_change(&self, params: DidChangeTextDocumentParams) {
        self.mutate(Mutation::Change(params));
    }

    async fn did_save(&self, params: DidSaveTextDocumentParams) {
        self.mutate(Mutation::Saved(params.text_document.uri));
    }

    async fn did_close(&self, params: DidCloseTextDocumentParams) {
        self.mutate(Mutation::Close(params));
    }

    async fn did_change_watched_files(&self, params: DidChangeWatchedFilesParams) {
        self.mutate(Mutation::Watched(params));
    }

    async fn did_change_configuration(&self, params: DidChangeConfigurationParams) {
        self.mutate(Mutation::SettingsPushed(params.settings));
    }

    async fn did_change_workspace_folders(&self, params: DidChangeWorkspaceFoldersParams) {
        self.mutate(Mutation::Folders(params));
    }

    async fn execute_command(&self, params: ExecuteCommandParams) -> Result<Option<LSPAny>> {
        let form = match params.command.as_str() {
            commands::MERMAID => Some(dotgen_views::pictures::Form::Mermaid),
            commands::DOT => Some(dotgen_views::pictures::Form::Dot),
            _ => None,
        };
        let argument = params.arguments.into_iter().next().unwrap_or_default();
        let invalid = |error: serde_json::Error| Error::invalid_params(error.to_string());
        if let Some(form) = form {
            return self.diagram_text(form, argument).await;
        }
        if params.command == commands::SHOW_CODEL {
            self.dispatch.show(serde_json::from_value(argument).map_err(invalid)?);
            return Ok(None);
        }
        if crate::features::generation::COMMANDS.contains(&params.command.as_str()) {
            return self.generation_command(&params.command, argument).await;
        }
        if params.command != commands::CHOOSE_ROOT {
            let message = format!("there is no command `{}`", params.command);
            return Err(Error::invalid_params(message));
        }
        let choice: ChooseRoot = serde_json::from_value(argument).map_err(invalid)?;
        let path = |uri: &Uri| crate::protocol::convert::uri::to_path(uri);
        let root = choice.root.as_ref().map(path);
        self.mutate(Mutation::Choose(path(&choice.uri), root));
        Ok(None)
    }

    async fn symbol(
        &self,
        params: WorkspaceSymbolParams,
    ) -> Result<Option<WorkspaceSymbolResponse>> {
        let symbols = self.dispatch.anywhere(RequestScope::BULK, params, workspace_symbol::handle);
        Ok(Some(WorkspaceSymbolResponse::Nested(symbols.await?)))
    }

    async fn completion_resolve(&self, item: CompletionItem) -> Result<CompletionItem> {
        let resolved =
            self.dispatch.anywhere(RequestScope::default(), item.clone(), completion::resolve);
        Ok(resolved.await?.unwrap_or(item))
    }

    async fn prepare_rename(
        &self,
        params: TextDocumentPositionParams,
    ) -> Result<Option<PrepareRenameResponse>> {
        let uri = document_of(&params);
        let answer = (self.dispatch).feature(uri, params, |features| features.prepare_rename);
        answer.await?.into_response()
    }

    async fn rename(&self, params: RenameParams) -> Result<Option<WorkspaceEdit>> {
        let uri = document_of(&params.text_document_position);
        let answer =
            self.dispatch.everywhere("Renaming", Some(uri), params, |snapshot, subject, params| {
                match subject {
                    Some(subject) => {
                        let features = features_of(snapshot, &subject.path);
                        or_empty((features.rename)(snapshot, subject, params))
                    }
                    None => Ok(Default::default()),
                }
            });
        answer.await?.into_response()
    }

    async fn will_rename_files(&self, params: RenameFilesParams) -> Result<Option<WorkspaceEdit>> {
        let files = |snapshot: &_, _: Option<&_>, params: &_| rename::files(snapshot, params);
        let answer = self.dispatch.everywhere("Updating includes", None, params, files);
        answer.await?.into_response()
    }

    async fn code_lens_resolve(&self, lens: CodeLens) -> Result<CodeLens> {
        let resolved =
            self.dispatch.anywhere(RequestScope::default(), lens.clone(), code_lens::resolve);
        Ok(resolved.await?.unwrap_or(lens))
    }

    async fn incoming_calls(
        &self,
        params: CallHierarchyIncomingCallsParams,
    ) -> Result<Option<Vec<CallHierarchyIncomingCall>>> {
        self.dispatch.anywhere(RequestScope::default(), params, call_hierarchy::incoming).await
    }

    async fn outgoing_calls(
        &self,
        params: CallHierarchyOutgoingCallsParams,
    ) -> Result<Option<Vec<CallHierarchyOutgoingCall>>> {
        self.dispatch.anywhere(RequestScope::default(), params, call_hierarchy::outgoing).await
    }

    async fn code_action_resolve(&self, action: CodeAction) -> Result<CodeAction> {
        let resolved =
            self.dispatch.anywhere(RequestScope::EDITS, action.clone(), codels::actions::resolve);
        let resolved = resolved.await?.into_response()?;
        Ok(resolved.unwrap_or(action))
    }

    async fn diagnostic(
        &self,
        params: DocumentDiagnosticParams,
    ) -> Result<DocumentDiagnosticReportResult> {
        let uri = params.text_document.uri.clone();
        let report =
            self.dispatch.language(RequestScope::default(), uri, params, diagnostics::document);
        Ok(report.await.map_err(retriggered)?.into_document())
    }

    async fn workspace_diagnostic(
        &self,
        params: WorkspaceDiagnosticParams,
    ) -> Result<WorkspaceDiagnosticReportResult> {
        Ok(self.diagnose(params).await?.into())
    }
}
