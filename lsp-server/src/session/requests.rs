//! The requests: parameters, answer and handler.
//!
//! Most requests of the protocol are answered by the language of the document, with one of its
//! [features](crate::features::language::LanguageFeatures). Requests beyond the protocol name a handler, or
//! are methods of [`Backend`] if they talk to the client during the request.

use std::sync::atomic::Ordering;

use serde_json::Value;
use tokio::sync::oneshot;

use super::backend::{Backend, document_of, retriggered};
use super::writer::{Event, Mutation};
use crate::features::specification::{call_hierarchy, code_lens, completion, rename};
use crate::features::{codels, commands, diagnostics, features_of, inspect, workspace_symbol};
use crate::protocol::messages::{
    ChooseRoot, DocumentParams, IncludingRoots, MacroExpansion, PositionParams, ReleaseInfo,
};
use crate::protocol::types::*;

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

impl Backend {
    async fn syntax_tree(&self, params: DocumentParams) -> Result<Option<String>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::syntax_tree).await
    }

    async fn item_tree(&self, params: DocumentParams) -> Result<Option<String>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::item_tree).await
    }

    async fn expand_macro(&self, params: PositionParams) -> Result<Option<MacroExpansion>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::expand_macro).await
    }

    async fn including_roots(&self, params: DocumentParams) -> Result<IncludingRoots> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::including_roots).await
    }

    async fn release(&self, params: DocumentParams) -> Result<ReleaseInfo> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::release).await
    }

    async fn model(&self, params: DocumentParams) -> Result<Value> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::model).await
    }
}

impl LanguageServer for Backend {
    async fn document_symbol(
        &self,
        params: DocumentSymbolParams,
    ) -> Result<Option<DocumentSymbolResponse>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.symbols).await
    }

    async fn folding_range(&self, params: FoldingRangeParams) -> Result<Option<Vec<FoldingRange>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.folds).await
    }

    async fn selection_range(
        &self,
        params: SelectionRangeParams,
    ) -> Result<Option<Vec<SelectionRange>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.selections).await
    }

    async fn document_link(&self, params: DocumentLinkParams) -> Result<Option<Vec<DocumentLink>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.links).await
    }

    async fn semantic_tokens_range(
        &self,
        params: SemanticTokensRangeParams,
    ) -> Result<Option<SemanticTokensRangeResult>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.tokens_in).await
    }

    async fn goto_definition(
        &self,
        params: GotoDefinitionParams,
    ) -> Result<Option<GotoDefinitionResponse>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.definition).await
    }

    async fn goto_declaration(
        &self,
        params: GotoDeclarationParams,
    ) -> Result<Option<GotoDeclarationResponse>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.declaration).await
    }

    async fn goto_type_definition(
        &self,
        params: GotoTypeDefinitionParams,
    ) -> Result<Option<GotoTypeDefinitionResponse>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.type_definition).await
    }

    async fn goto_implementation(
        &self,
        params: GotoImplementationParams,
    ) -> Result<Option<GotoImplementationResponse>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.implementation).await
    }

    async fn references(&self, params: ReferenceParams) -> Result<Option<Vec<Location>>> {
        let uri = params.text_document_position.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.references).await
    }

    async fn document_highlight(
        &self,
        params: DocumentHighlightParams,
    ) -> Result<Option<Vec<DocumentHighlight>>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.highlights).await
    }

    async fn hover(&self, params: HoverParams) -> Result<Option<Hover>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.hover).await
    }

    async fn completion(&self, params: CompletionParams) -> Result<Option<CompletionResponse>> {
        let uri = params.text_document_position.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.completion).await
    }

    async fn signature_help(&self, params: SignatureHelpParams) -> Result<Option<SignatureHelp>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.signature).await
    }

    async fn formatting(&self, params: DocumentFormattingParams) -> Result<Option<Vec<TextEdit>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.format).await
    }

    async fn range_formatting(
        &self,
        params: DocumentRangeFormattingParams,
    ) -> Result<Option<Vec<TextEdit>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.format_range).await
    }

    async fn on_type_formatting(
        &self,
        params: DocumentOnTypeFormattingParams,
    ) -> Result<Option<Vec<TextEdit>>> {
        let uri = params.text_document_position.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.format_typed).await
    }

    async fn inlay_hint(&self, params: InlayHintParams) -> Result<Option<Vec<InlayHint>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.hints).await
    }

    async fn code_lens(&self, params: CodeLensParams) -> Result<Option<Vec<CodeLens>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.lenses).await
    }

    async fn prepare_call_hierarchy(
        &self,
        params: CallHierarchyPrepareParams,
    ) -> Result<Option<Vec<CallHierarchyItem>>> {
        let uri = params.text_document_position_params.text_document.uri.clone();
        self.dispatch.feature(uri, params, |features| features.calls).await
    }

    async fn code_action(&self, params: CodeActionParams) -> Result<Option<CodeActionResponse>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.edits(uri, params, |features| features.actions).await
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
                        (features.rename)(snapshot, subject, params)
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
        let resolved = self.dispatch.anywhere(lens.clone(), code_lens::resolve);
        Ok(resolved.await?.unwrap_or(lens))
    }

    async fn incoming_calls(
        &self,
        params: CallHierarchyIncomingCallsParams,
    ) -> Result<Option<Vec<CallHierarchyIncomingCall>>> {
        self.dispatch.anywhere(params, call_hierarchy::incoming).await
    }

    async fn outgoing_calls(
        &self,
        params: CallHierarchyOutgoingCallsParams,
    ) -> Result<Option<Vec<CallHierarchyOutgoingCall>>> {
        self.dispatch.anywhere(params, call_hierarchy::outgoing).await
    }

    async fn code_action_resolve(&self, action: CodeAction) -> Result<CodeAction> {
        let resolved = self.dispatch.edits_anywhere(action.clone(), codels::actions::resolve);
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
        let question = (self.dispatch).feature(uri.clone(), params, |features| features.tokens);
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
        let question = (self.dispatch).feature(uri.clone(), params, |features| features.tokens);
        let Some(data) = question.await? else {
            return Ok(None);
        };
        Ok(Some(self.tokens.remember_changes(uri, known, data)))
    }
}
