//! The capabilities of the client. Every decision that depends on the client uses them.

use serde_json::Value;

use super::convert::Encoding;
use super::types::{InitializeParams, MarkupKind};

/// The capabilities that dotgen uses.
#[derive(Debug, Clone, Default)]
pub struct ClientCaps {
    /// Unit of `character` in positions.
    pub encoding: Encoding,
    /// The client pulls diagnostics, so none are pushed.
    pub pull_diagnostics: bool,
    /// The client also pulls diagnostics of codels' sources (`initializationOptions.pullSources`).
    pub pull_sources: bool,
    /// `workspace/diagnostic/refresh`.
    pub diagnostic_refresh: bool,
    /// `workspace/semanticTokens/refresh`.
    pub semantic_tokens_refresh: bool,
    /// The client colours by a grammar first: semantic tokens that add nothing to the grammar are omitted.
    pub augments_syntax_tokens: bool,
    /// Related information in diagnostics.
    pub related_information: bool,
    /// `codeDescription` in diagnostics.
    pub code_description: bool,
    /// Nested document symbols.
    pub hierarchical_symbols: bool,
    /// `LocationLink` as the answer to definition, declaration, type definition.
    pub definition_link: bool,
    /// Folding by whole lines only.
    pub line_folding_only: bool,
    pub markdown_hover: bool,
    /// Snippets in completion.
    pub snippets: bool,
    /// Offsets in the labels of parameters.
    pub label_offsets: bool,
    /// Answers `dotgen/documentText` (`initializationOptions.documentText`).
    pub document_text: bool,
    /// Status of verifications (`initializationOptions.verificationStatus`).
    pub verification_status: bool,
    /// Runs components: executes `dotgen.run` and `dotgen.simulate` (`initializationOptions.runs`).
    pub runs: bool,
    /// `CodeAction` literals.
    pub code_action_literals: bool,
    /// Versioned document changes in workspace edits.
    pub document_changes: bool,
    /// clangd's notification `textDocument/inactiveRegions`.
    pub inactive_regions: bool,
    /// `workspace/configuration`.
    pub configuration: bool,
    /// Dynamic registration of watched files.
    pub watched_files: bool,
    /// Dynamic registration of configuration changes.
    pub configuration_registration: bool,
    /// Changes of workspace folders.
    pub workspace_folders: bool,
    /// `workspace/applyEdit`.
    pub applies_edits: bool,
    /// `window/workDoneProgress/create`.
    pub progress: bool,
    /// New files in workspace edits.
    pub creates_files: bool,
    /// Changes that the user confirms before they are made.
    pub change_annotations: bool,
    /// Disabled actions, shown with the reason.
    pub disabled_actions: bool,
    /// `codeAction/resolve` for edits.
    pub resolves_edits: bool,
    /// `workspace/codeLens/refresh`.
    pub code_lens_refresh: bool,
    /// `window/showDocument`.
    pub show_document: bool,
    /// Dynamic registration of features for documents in other languages.
    pub documents_registration: bool,
    /// Dynamic registration of definitions.
    pub definition_registration: bool,
    /// Dynamic registration of hovers.
    pub hover_registration: bool,
}

impl ClientCaps {
    /// The capabilities in the parameters of `initialize`. `raw` is the same message as JSON: it contains
    /// fields that the protocol types lack.
    pub fn new(params: &InitializeParams, raw: &Value) -> ClientCaps {
        let capabilities = &params.capabilities;
        let text = capabilities.text_document.clone().unwrap_or_default();
        let workspace = capabilities.workspace.clone().unwrap_or_default();
        let window = capabilities.window.clone().unwrap_or_default();
        let diagnostics = text.publish_diagnostics.clone().unwrap_or_default();
        let links = |link_support: Option<bool>| link_support.unwrap_or(false);
        ClientCaps {
            encoding: Encoding::negotiate(
                capabilities
                    .general
                    .as_ref()
                    .and_then(|capabilities| capabilities.position_encodings.as_deref()),
            ),
            pull_diagnostics: text.diagnostic.is_some(),
            // ls-types calls the capability `diagnostic`; the protocol says `diagnostics`.
            diagnostic_refresh: flag(raw, "/capabilities/workspace/diagnostics/refreshSupport")
                || flag(raw, "/capabilities/workspace/diagnostic/refreshSupport"),
            semantic_tokens_refresh: flag(
                raw,
                "/capabilities/workspace/semanticTokens/refreshSupport",
            ),
            augments_syntax_tokens: flag(
                raw,
                "/capabilities/textDocument/semanticTokens/augmentsSyntaxTokens",
            ),
            related_information: diagnostics.related_information.unwrap_or(false)
                || flag(raw, "/capabilities/textDocument/diagnostic/relatedInformation")
                || text.diagnostic.is_some(),
            code_description: diagnostics.code_description_support.unwrap_or(false)
                || text.diagnostic.is_some(),
            hierarchical_symbols: text
                .document_symbol
                .and_then(|symbol| symbol.hierarchical_document_symbol_support)
                .unwrap_or(false),
            definition_link: links(text.definition.and_then(|definition| definition.link_support)),
            line_folding_only: text
                .folding_range
                .and_then(|range| range.line_folding_only)
                .unwrap_or(false),
            markdown_hover: text
                .hover
                .and_then(|hover| hover.content_format)
                .is_none_or(|format| format.contains(&MarkupKind::Markdown)),
            snippets: flag(
                raw,
                "/capabilities/textDocument/completion/completionItem/snippetSupport",
            ),
            label_offsets: flag(
                raw,
                "/capabilities/textDocument/signatureHelp/signatureInformation/parameterInformation/labelOffsetSupport",
            ),
            pull_sources: flag(raw, "/initializationOptions/pullSources"),
            document_text: flag(raw, "/initializationOptions/documentText"),
            verification_status: flag(raw, "/initializationOptions/verificationStatus"),
            runs: flag(raw, "/initializationOptions/runs"),
            code_action_literals: text
                .code_action
                .is_some_and(|action| action.code_action_literal_support.is_some()),
            document_changes: workspace
                .workspace_edit
                .and_then(|edit| edit.document_changes)
                .unwrap_or(false),
            inactive_regions: flag(
                raw,
                "/capabilities/textDocument/inactiveRegionsCapabilities/inactiveRegions",
            ),
            configuration: workspace.configuration.unwrap_or(false),
            watched_files: workspace
                .did_change_watched_files
                .and_then(|file| file.dynamic_registration)
                .unwrap_or(false),
            configuration_registration: workspace
                .did_change_configuration
                .and_then(|configuration| configuration.dynamic_registration)
                .unwrap_or(false),
            workspace_folders: workspace.workspace_folders.unwrap_or(false),
            applies_edits: flag(raw, "/capabilities/workspace/applyEdit"),
            progress: window.work_done_progress.unwrap_or(false),
            creates_files: operations(raw, "create"),
            change_annotations: raw
                .pointer("/capabilities/workspace/workspaceEdit/changeAnnotationSupport")
                .is_some_and(Value::is_object),
            disabled_actions: flag(raw, "/capabilities/textDocument/codeAction/disabledSupport"),
            resolves_edits: flag(raw, "/capabilities/textDocument/codeAction/dataSupport")
                && raw
                    .pointer("/capabilities/textDocument/codeAction/resolveSupport/properties")
                    .and_then(Value::as_array)
                    .is_some_and(|array| array.iter().any(|array| array == "edit")),
            code_lens_refresh: flag(raw, "/capabilities/workspace/codeLens/refreshSupport"),
            show_document: flag(raw, "/capabilities/window/showDocument/support"),
            documents_registration: ["synchronization", "codeAction", "codeLens", "references"]
                .iter()
                .all(|request| registers(raw, request)),
            definition_registration: registers(raw, "definition"),
            hover_registration: registers(raw, "hover"),
        }
    }
}

/// True if a request about documents can be registered later.
fn registers(raw: &Value, request: &str) -> bool {
    let path = format!("/capabilities/textDocument/{request}/dynamicRegistration");
    flag(raw, &path)
}

/// True if workspace edits support an operation on files.
fn operations(raw: &Value, wanted: &str) -> bool {
    let all = raw.pointer("/capabilities/workspace/workspaceEdit/resourceOperations");
    let mut all = all.and_then(Value::as_array).into_iter().flatten();
    all.any(|array| array == wanted)
}

fn flag(raw: &Value, pointer: &str) -> bool {
    raw.pointer(pointer).and_then(Value::as_bool) == Some(true)
}
