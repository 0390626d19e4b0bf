//! The table of requests: method, parameters, answer and handler.
//!
//! Rows of the protocol name a feature of [`Language`](crate::features::language::Language): the language of
//! the document answers. Rows beyond the protocol name a handler, or a method of [`Backend`] if it talks to
//! the client during the request.

use std::sync::atomic::Ordering;

use serde_json::Value;
use tokio::sync::oneshot;

use super::backend::{Backend, document_of, retriggered};
use super::writer::{Event, Mutation};
use crate::features::specification::{call_hierarchy, code_lens, completion, rename};
use crate::features::{codels, commands, diagnostics, inspect, language_of, workspace_symbol};
use crate::protocol::messages::{
    ChooseRoot, DocumentParams, IncludingRoots, MacroExpansion, PositionParams, ReleaseInfo,
};
use crate::protocol::types::*;

/// The URI of the document in parameters.
macro_rules! uri_of {
    ($params:ident, document) => {
        $params.text_document.uri
    };
    ($params:ident, position) => {
        $params.text_document_position.text_document.uri
    };
    // The protocol library has two names for one field.
    ($params:ident, position_params) => {
        $params.text_document_position_params.text_document.uri
    };
}

/// Methods of the protocol that the language of a document answers: parameters, answer, feature, and the
/// field with the document.
macro_rules! answered_by_language {
    ($($method:ident($params:ty) -> $answer:ty = $feature:ident of $place:ident;)*) => {
        $(
            async fn $method(&self, params: $params) -> Result<$answer> {
                let uri = uri_of!(params, $place).clone();
                let answer = self.dispatch.language(uri, params, |features, snapshot, subject, params| {
                    features.$feature(snapshot, subject, params)
                });
                answer.await
            }
        )*
    };
}

/// Methods beyond the protocol; see `docs/protocol.md`.
macro_rules! beyond_the_protocol {
    (
        handlers { $($name:literal $method:ident($params:ty) -> $answer:ty = $handler:path;)* }
        methods { $($other:literal $path:path;)* }
    ) => {
        impl Backend {
            $(
                async fn $method(&self, params: $params) -> Result<$answer> {
                    let uri = params.text_document.uri.clone();
                    self.dispatch.document(uri, params, $handler).await
                }
            )*
        }

        /// Registers the methods beyond the protocol.
        pub(super) fn custom_methods(builder: Builder) -> Builder {
            builder
                $(.custom_method($name, Backend::$method))*
                $(.custom_method($other, $path))*
        }
    };
}

/// The builder of the service.
pub(super) type Builder = tower_lsp::LspServiceBuilder<Backend>;

beyond_the_protocol! {
    handlers {
        "dotgen/syntaxTree" syntax_tree(DocumentParams) -> Option<String> = inspect::syntax_tree;
        "dotgen/itemTree" item_tree(DocumentParams) -> Option<String> = inspect::item_tree;
        "dotgen/expandMacro" expand_macro(PositionParams) -> Option<MacroExpansion> = inspect::expand_macro;
        "dotgen/includingRoots" including_roots(DocumentParams) -> IncludingRoots = inspect::including_roots;
        "dotgen/release" release(DocumentParams) -> ReleaseInfo = inspect::release;
        "dotgen/model" model(DocumentParams) -> Value = inspect::model;
    }
    methods {
        "dotgen/diagram" Backend::diagram;
        "dotgen/verification" Backend::verification;
        "dotgen/trace" Backend::trace;
        "dotgen/sensitivity" Backend::sensitivity;
        "dotgen/codelHeaders" Backend::codel_headers;
        "dotgen/interfaces" Backend::interfaces;
        "dotgen/newComponent" Backend::new_component;
        "window/workDoneProgress/cancel" Backend::cancel_progress;
    }
}

impl LanguageServer for Backend {
    answered_by_language! {
        document_symbol(DocumentSymbolParams) -> Option<DocumentSymbolResponse> = symbols of document;
        folding_range(FoldingRangeParams) -> Option<Vec<FoldingRange>> = folds of document;
        selection_range(SelectionRangeParams) -> Option<Vec<SelectionRange>> = selections of document;
        document_link(DocumentLinkParams) -> Option<Vec<DocumentLink>> = links of document;
        semantic_tokens_range(SemanticTokensRangeParams) -> Option<SemanticTokensRangeResult>
            = tokens_in of document;
        goto_definition(GotoDefinitionParams) -> Option<GotoDefinitionResponse>
            = definition of position_params;
        goto_declaration(GotoDeclarationParams) -> Option<GotoDeclarationResponse>
            = declaration of position_params;
        goto_type_definition(GotoTypeDefinitionParams) -> Option<GotoTypeDefinitionResponse>
            = type_definition of position_params;
        goto_implementation(GotoImplementationParams) -> Option<GotoImplementationResponse>
            = implementation of position_params;
        references(ReferenceParams) -> Option<Vec<Location>> = references of position;
        document_highlight(DocumentHighlightParams) -> Option<Vec<DocumentHighlight>>
            = highlights of position_params;
        hover(HoverParams) -> Option<Hover> = hover of position_params;
        completion(CompletionParams) -> Option<CompletionResponse> = completion of position;
        signature_help(SignatureHelpParams) -> Option<SignatureHelp> = signature of position_params;
        formatting(DocumentFormattingParams) -> Option<Vec<TextEdit>> = format of document;
        range_formatting(DocumentRangeFormattingParams) -> Option<Vec<TextEdit>> = format_range of document;
        on_type_formatting(DocumentOnTypeFormattingParams) -> Option<Vec<TextEdit>>
            = format_typed of position;
        inlay_hint(InlayHintParams) -> Option<Vec<InlayHint>> = hints of document;
        code_lens(CodeLensParams) -> Option<Vec<CodeLens>> = lenses of document;
        prepare_call_hierarchy(CallHierarchyPrepareParams) -> Option<Vec<CallHierarchyItem>>
            = calls of position_params;
        code_action(CodeActionParams) -> Option<CodeActionResponse> = actions of document;
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
        self.tokens.forget(&params.text_document.uri);
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
        if let Some(form) = form {
            let argument = params.arguments.into_iter().next().unwrap_or_default();
            return self.diagram_text(form, argument).await;
        }
        if params.command == commands::SHOW_CODEL {
            let argument = params.arguments.into_iter().next().unwrap_or_default();
            let place: Location = serde_json::from_value(argument)
                .map_err(|error| Error::invalid_params(error.to_string()))?;
            self.dispatch.show(place);
            return Ok(None);
        }
        if crate::features::generation::COMMANDS.contains(&params.command.as_str()) {
            let argument = params.arguments.into_iter().next().unwrap_or_default();
            return self.generation_command(&params.command, argument).await;
        }
        if params.command != commands::CHOOSE_ROOT {
            let message = format!("there is no command `{}`", params.command);
            return Err(Error::invalid_params(message));
        }
        let argument = params.arguments.into_iter().next().unwrap_or_default();
        let choice: ChooseRoot = serde_json::from_value(argument)
            .map_err(|error| Error::invalid_params(error.to_string()))?;
        let path = |uri: &Uri| crate::protocol::convert::uri::to_path(uri);
        let root = choice.root.as_ref().map(path);
        self.mutate(Mutation::Choose(path(&choice.uri), root));
        Ok(None)
    }

    async fn symbol(
        &self,
        params: WorkspaceSymbolParams,
    ) -> Result<Option<WorkspaceSymbolResponse>> {
        let symbols = self.dispatch.workspace(params, workspace_symbol::handle);
        Ok(Some(WorkspaceSymbolResponse::Nested(symbols.await?)))
    }

    async fn completion_resolve(&self, item: CompletionItem) -> Result<CompletionItem> {
        let resolved = self.dispatch.anywhere(item.clone(), completion::resolve);
        Ok(resolved.await?.unwrap_or(item))
    }

    async fn prepare_rename(
        &self,
        params: TextDocumentPositionParams,
    ) -> Result<Option<PrepareRenameResponse>> {
        let uri = document_of(&params);
        let answer = self
            .dispatch
            .language(uri, params, |features, snapshot, subject, params| {
                features.prepare_rename(snapshot, subject, params)
            });
        answer.await?.into_response()
    }

    async fn rename(&self, params: RenameParams) -> Result<Option<WorkspaceEdit>> {
        let uri = document_of(&params.text_document_position);
        let answer = self.dispatch.everywhere(
            "Renaming",
            Some(uri),
            params,
            |snapshot, subject, params| match subject {
                Some(subject) => {
                    let language = language_of(snapshot, &subject.path);
                    language.rename(snapshot, subject, params)
                }
                None => Ok(Default::default()),
            },
        );
        answer.await?.into_response()
    }

    async fn will_rename_files(&self, params: RenameFilesParams) -> Result<Option<WorkspaceEdit>> {
        let files = |snapshot: &_, _: Option<&_>, params: &_| rename::files(snapshot, params);
        let answer = self
            .dispatch
            .everywhere("Updating includes", None, params, files);
        answer.await?.into_response()
    }

    async fn code_lens_resolve(&self, lens: CodeLens) -> Result<CodeLens> {
        let resolved = self.dispatch.anywhere(lens.clone(), code_lens::resolve);
        Ok(resolved.await?.unwrap_or(lens))
    }

    async fn incoming_calls(
        &self,
        params: CallHierarchyIncomingCallsParams,
    ) -> Result<Option<Vec<CallHierarchyIncomingCall>>> {
        self.dispatch
            .anywhere(params, call_hierarchy::incoming)
            .await
    }

    async fn outgoing_calls(
        &self,
        params: CallHierarchyOutgoingCallsParams,
    ) -> Result<Option<Vec<CallHierarchyOutgoingCall>>> {
        self.dispatch
            .anywhere(params, call_hierarchy::outgoing)
            .await
    }

    async fn code_action_resolve(&self, action: CodeAction) -> Result<CodeAction> {
        let resolved = self
            .dispatch
            .anywhere(action.clone(), codels::actions::resolve);
        let resolved = resolved.await?.into_response()?;
        Ok(resolved.unwrap_or(action))
    }

    async fn diagnostic(
        &self,
        params: DocumentDiagnosticParams,
    ) -> Result<DocumentDiagnosticReportResult> {
        let uri = params.text_document.uri.clone();
        let report = self.dispatch.language(uri, params, diagnostics::document);
        Ok(report.await.map_err(retriggered)?.into_document())
    }

    async fn workspace_diagnostic(
        &self,
        params: WorkspaceDiagnosticParams,
    ) -> Result<WorkspaceDiagnosticReportResult> {
        Ok(self.diagnose(params).await?.into())
    }

    async fn semantic_tokens_full(
        &self,
        params: SemanticTokensParams,
    ) -> Result<Option<SemanticTokensResult>> {
        let uri = params.text_document.uri.clone();
        let question =
            self.dispatch
                .language(uri.clone(), params, |row, snapshot, subject, params| {
                    row.tokens(snapshot, subject, params)
                });
        let tokens = question.await?;
        Ok(tokens.map(|data| self.tokens.remember(uri, data).into()))
    }

    async fn semantic_tokens_full_delta(
        &self,
        params: SemanticTokensDeltaParams,
    ) -> Result<Option<SemanticTokensFullDeltaResult>> {
        let uri = params.text_document.uri.clone();
        let known = self.tokens.recall(&uri, &params.previous_result_id);
        let params = SemanticTokensParams {
            text_document: params.text_document,
            work_done_progress_params: params.work_done_progress_params,
            partial_result_params: params.partial_result_params,
        };
        let question =
            self.dispatch
                .language(uri.clone(), params, |row, snapshot, subject, params| {
                    row.tokens(snapshot, subject, params)
                });
        let Some(data) = question.await? else {
            return Ok(None);
        };
        Ok(Some(self.tokens.remember_changes(uri, known, data)))
    }
}
