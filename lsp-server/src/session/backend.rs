//! The protocol's methods. Each hands its message to the writer or to the dispatcher before it
//! first waits: that is what keeps messages in order.

mod generation;
mod pull;
mod tokens;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use serde_json::Value;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::sync::{oneshot, watch};

use crate::features::specification::{
    self, call_hierarchy, code_action, code_lens, completion, document_highlight, document_link,
    document_symbol, folding_range, formatting, goto, hover, inlay_hint, references, rename,
    semantic_tokens, signature_help,
};
use crate::features::{
    codels, commands, diagnostics, diagram, inspect, verification, workspace_symbol,
};
use crate::protocol::messages::{
    ChooseRoot, DocumentParams, IncludingRoots, MacroExpansion, PositionParams, ReleaseInfo,
};
use crate::protocol::outbox::Outbox;
use crate::protocol::types::*;
use crate::session::dispatch::Dispatcher;
use crate::session::post::Post;
use crate::session::writer::{Event, Mutation, State};

use tokens::TokenResults;

/// See the module.
pub(crate) struct Backend {
    pub(crate) dispatch: Dispatcher,
    /// Keeps the writer alive.
    events: UnboundedSender<Event>,
    revisions: watch::Receiver<u64>,
    /// Becomes true when the client has closed its end.
    closed: watch::Receiver<bool>,
    /// Parameters of `initialize` before they became typed.
    raw_initialize: Arc<OnceLock<Value>>,
    shut_down: Arc<AtomicBool>,
    tokens: TokenResults,
    /// Pictures to show while a text cannot be read.
    last_pictures: Arc<diagram::LastGood>,
    pub(crate) generation: generation::Generation,
}

impl Backend {
    /// Starts the writer. To be called on the runtime.
    pub(crate) fn new(
        client: Client,
        raw_initialize: Arc<OnceLock<Value>>,
        shut_down: Arc<AtomicBool>,
        closed: watch::Receiver<bool>,
    ) -> Backend {
        let outbox = Outbox::new(client);
        let (events, queue) = unbounded_channel();
        let (revision, revisions) = watch::channel(0);
        let state = {
            let (outbox, events) = (outbox.clone(), events.downgrade());
            move || State::new(outbox, events, revision)
        };
        std::thread::Builder::new()
            .name("writer".to_owned())
            // Deep trees are dropped here.
            .stack_size(32 << 20)
            .spawn(move || state().run(queue))
            .expect("the operating system starts one more thread");
        Backend {
            dispatch: Dispatcher::new(Post::new(&events.downgrade()), outbox),
            events,
            revisions,
            closed,
            raw_initialize,
            shut_down,
            tokens: TokenResults::default(),
            last_pictures: Arc::default(),
            generation: generation::Generation::default(),
        }
    }

    /// Tells the writer something.
    fn send(&self, event: Event) {
        // Fails only after `exit`.
        let _ = self.events.send(event);
    }

    fn mutate(&self, mutation: Mutation) {
        self.send(Event::Mutation(mutation));
    }

    /// The text of a document came with something that is no text; see `transport`.
    pub(crate) fn mended(&self, document: Uri) {
        self.mutate(Mutation::Mended(document));
    }

    /// Waits for a change; false if there will be none, for the client has gone.
    async fn changed(&self, revisions: &mut watch::Receiver<u64>) -> bool {
        let mut closed = self.closed.clone();
        tokio::select! {
            changed = revisions.changed() => changed.is_ok(),
            _ = closed.wait_for(|it| *it) => false,
        }
    }

    /// `dotgen/syntaxTree`
    pub(crate) async fn syntax_tree(&self, params: DocumentParams) -> Result<Option<String>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, inspect::syntax_tree)
            .await
    }

    /// `dotgen/itemTree`
    pub(crate) async fn item_tree(&self, params: DocumentParams) -> Result<Option<String>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, inspect::item_tree)
            .await
    }

    /// `dotgen/expandMacro`
    pub(crate) async fn expand_macro(
        &self,
        params: PositionParams,
    ) -> Result<Option<MacroExpansion>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, inspect::expand_macro)
            .await
    }

    /// `dotgen/includingRoots`
    pub(crate) async fn including_roots(&self, params: DocumentParams) -> Result<IncludingRoots> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, inspect::including_roots)
            .await
    }

    /// `dotgen/release`
    pub(crate) async fn release(&self, params: DocumentParams) -> Result<ReleaseInfo> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::release).await
    }

    /// `dotgen/diagram`
    pub(crate) async fn diagram(&self, params: diagram::DiagramParams) -> Result<Option<Value>> {
        let uri = params.text_document.uri.clone();
        let last = self.last_pictures.clone();
        let question = diagram::Question { params, last };
        self.dispatch.document(uri, question, diagram::handle).await
    }

    /// The commands that give a picture as text.
    async fn diagram_text(
        &self,
        form: crate::views::pictures::Form,
        argument: Value,
    ) -> Result<Option<Value>> {
        let mut params: diagram::DiagramParams = serde_json::from_value(argument)
            .map_err(|error| Error::invalid_params(error.to_string()))?;
        params.format = form;
        let uri = params.text_document.uri.clone();
        let last = self.last_pictures.clone();
        let question = diagram::Question { params, last };
        self.dispatch.document(uri, question, diagram::text).await
    }

    /// `dotgen/verification`
    pub(crate) async fn verification(
        &self,
        params: verification::VerificationParams,
    ) -> Result<Option<verification::VerificationResult>> {
        let uri = params.text_document.uri.clone();
        let found = self
            .dispatch
            .document(uri.clone(), params.clone(), verification::prepare);
        let Some(prepared) = found.await? else {
            return Ok(None);
        };
        // A variation takes its time: without a snapshot, which would keep edits waiting.
        let question = verification::Question {
            shown: prepared.answer().await,
            params,
        };
        self.dispatch
            .document(uri, question, verification::present)
            .await
    }

    /// `dotgen/sensitivity`
    pub(crate) async fn sensitivity(
        &self,
        params: verification::SensitivityParams,
    ) -> Result<Option<verification::SensitivityResult>> {
        let uri = params.text_document.uri.clone();
        let question = params.verification();
        let found = self
            .dispatch
            .document(uri.clone(), question, verification::prepare);
        let Some(prepared) = found.await? else {
            return Ok(None);
        };
        let token = params.work_done_token;
        let asked = verification::ask(prepared, token, self.dispatch.outbox()).await;
        let answer = self.dispatch.document(uri, asked, verification::shown);
        answer.await.map(Some)
    }

    /// `dotgen/codelHeaders`
    pub(crate) async fn codel_headers(
        &self,
        params: DocumentParams,
    ) -> Result<Option<codels::headers::CodelHeaders>> {
        let uri = params.text_document.uri.clone();
        let answer = self
            .dispatch
            .any_document(uri, params, codels::headers::handle);
        answer.await?.into_response()
    }

    /// `dotgen/model`
    pub(crate) async fn model(&self, params: DocumentParams) -> Result<Value> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, inspect::model).await
    }
}

impl LanguageServer for Backend {
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
            commands::MERMAID => Some(crate::views::pictures::Form::Mermaid),
            commands::DOT => Some(crate::views::pictures::Form::Dot),
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

    async fn document_symbol(
        &self,
        params: DocumentSymbolParams,
    ) -> Result<Option<DocumentSymbolResponse>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, document_symbol::handle)
            .await
    }

    async fn symbol(
        &self,
        params: WorkspaceSymbolParams,
    ) -> Result<Option<WorkspaceSymbolResponse>> {
        let symbols = self.dispatch.workspace(params, workspace_symbol::handle);
        Ok(Some(WorkspaceSymbolResponse::Nested(symbols.await?)))
    }

    async fn folding_range(&self, params: FoldingRangeParams) -> Result<Option<Vec<FoldingRange>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, folding_range::handle)
            .await
    }

    async fn selection_range(
        &self,
        params: SelectionRangeParams,
    ) -> Result<Option<Vec<SelectionRange>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, specification::selection_range::handle)
            .await
    }

    async fn document_link(&self, params: DocumentLinkParams) -> Result<Option<Vec<DocumentLink>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, document_link::handle)
            .await
    }

    async fn goto_definition(
        &self,
        params: GotoDefinitionParams,
    ) -> Result<Option<GotoDefinitionResponse>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch.document(uri, params, goto::definition).await
    }

    async fn goto_declaration(
        &self,
        params: GotoDeclarationParams,
    ) -> Result<Option<GotoDeclarationResponse>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch.document(uri, params, goto::declaration).await
    }

    async fn goto_type_definition(
        &self,
        params: GotoTypeDefinitionParams,
    ) -> Result<Option<GotoTypeDefinitionResponse>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch
            .document(uri, params, goto::type_definition)
            .await
    }

    async fn references(&self, params: ReferenceParams) -> Result<Option<Vec<Location>>> {
        let uri = document_of(&params.text_document_position);
        self.dispatch
            .any_document(uri, params, references::handle)
            .await
    }

    async fn document_highlight(
        &self,
        params: DocumentHighlightParams,
    ) -> Result<Option<Vec<DocumentHighlight>>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch
            .document(uri, params, document_highlight::handle)
            .await
    }

    async fn hover(&self, params: HoverParams) -> Result<Option<Hover>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch.document(uri, params, hover::handle).await
    }

    async fn goto_implementation(
        &self,
        params: GotoImplementationParams,
    ) -> Result<Option<GotoImplementationResponse>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch
            .document(uri, params, goto::implementation)
            .await
    }

    async fn completion(&self, params: CompletionParams) -> Result<Option<CompletionResponse>> {
        let uri = document_of(&params.text_document_position);
        self.dispatch
            .document(uri, params, completion::handle)
            .await
    }

    async fn completion_resolve(&self, item: CompletionItem) -> Result<CompletionItem> {
        let resolved = self.dispatch.anywhere(item.clone(), completion::resolve);
        Ok(resolved.await?.unwrap_or(item))
    }

    async fn signature_help(&self, params: SignatureHelpParams) -> Result<Option<SignatureHelp>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch
            .document(uri, params, signature_help::handle)
            .await
    }

    async fn prepare_rename(
        &self,
        params: TextDocumentPositionParams,
    ) -> Result<Option<PrepareRenameResponse>> {
        let uri = document_of(&params);
        let answer = self.dispatch.document(uri, params, rename::prepare);
        answer.await?.into_response()
    }

    async fn rename(&self, params: RenameParams) -> Result<Option<WorkspaceEdit>> {
        let uri = document_of(&params.text_document_position);
        let answer =
            self.dispatch.everywhere(
                Some(uri),
                params,
                |snapshot, subject, params| match subject {
                    Some(subject) => rename::rename(snapshot, subject, params),
                    None => Ok(Default::default()),
                },
            );
        answer.await?.into_response()
    }

    async fn will_rename_files(&self, params: RenameFilesParams) -> Result<Option<WorkspaceEdit>> {
        let files = |snapshot: &_, _: Option<&_>, params: &_| rename::files(snapshot, params);
        let answer = self.dispatch.everywhere(None, params, files);
        answer.await?.into_response()
    }

    async fn formatting(&self, params: DocumentFormattingParams) -> Result<Option<Vec<TextEdit>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, formatting::document)
            .await
    }

    async fn range_formatting(
        &self,
        params: DocumentRangeFormattingParams,
    ) -> Result<Option<Vec<TextEdit>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch.document(uri, params, formatting::range).await
    }

    async fn on_type_formatting(
        &self,
        params: DocumentOnTypeFormattingParams,
    ) -> Result<Option<Vec<TextEdit>>> {
        let uri = document_of(&params.text_document_position);
        self.dispatch
            .document(uri, params, formatting::on_type)
            .await
    }

    async fn inlay_hint(&self, params: InlayHintParams) -> Result<Option<Vec<InlayHint>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, inlay_hint::handle)
            .await
    }

    async fn code_lens(&self, params: CodeLensParams) -> Result<Option<Vec<CodeLens>>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .any_document(uri, params, code_lens::handle)
            .await
    }

    async fn code_lens_resolve(&self, lens: CodeLens) -> Result<CodeLens> {
        let resolved = self.dispatch.anywhere(lens.clone(), code_lens::resolve);
        Ok(resolved.await?.unwrap_or(lens))
    }

    async fn prepare_call_hierarchy(
        &self,
        params: CallHierarchyPrepareParams,
    ) -> Result<Option<Vec<CallHierarchyItem>>> {
        let uri = document_of(&params.text_document_position_params);
        self.dispatch
            .document(uri, params, call_hierarchy::prepare)
            .await
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

    async fn code_action(&self, params: CodeActionParams) -> Result<Option<CodeActionResponse>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .any_document(uri, params, code_action::handle)
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
        let report = self.dispatch.document(uri, params, diagnostics::document);
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
        let question = self
            .dispatch
            .document(uri.clone(), params, semantic_tokens::full);
        let tokens = question.await?;
        Ok(tokens.map(|data| self.tokens.remember(uri, data).into()))
    }

    async fn semantic_tokens_full_delta(
        &self,
        params: SemanticTokensDeltaParams,
    ) -> Result<Option<SemanticTokensFullDeltaResult>> {
        let uri = params.text_document.uri.clone();
        let known = self.tokens.recall(&uri, &params.previous_result_id);
        let question = self
            .dispatch
            .document(uri.clone(), params, semantic_tokens::full);
        let Some(data) = question.await? else {
            return Ok(None);
        };
        Ok(Some(self.tokens.remember_changes(uri, known, data)))
    }

    async fn semantic_tokens_range(
        &self,
        params: SemanticTokensRangeParams,
    ) -> Result<Option<SemanticTokensRangeResult>> {
        let uri = params.text_document.uri.clone();
        self.dispatch
            .document(uri, params, semantic_tokens::range)
            .await
    }
}

fn document_of(place: &TextDocumentPositionParams) -> Uri {
    place.text_document.uri.clone()
}

/// Diagnostics that a change overtook are to be asked for again (LSP 3.17,
/// `DiagnosticServerCancellationData`).
fn retriggered(mut error: Error) -> Error {
    if error.code == ErrorCode::ContentModified {
        error.code = ErrorCode::ServerError(-32802);
        error.data = Some(serde_json::json!({ "retriggerRequest": true }));
    }
    error
}
