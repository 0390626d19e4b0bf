//! Specifications (`.gen`) and the files they include: one module per feature.

pub(crate) mod call_hierarchy;
pub(crate) mod code_action;
pub(crate) mod code_lens;
pub(crate) mod completion;
pub(crate) mod document_highlight;
pub(crate) mod document_link;
pub(crate) mod document_symbol;
pub(crate) mod folding_range;
pub(crate) mod formatting;
pub(crate) mod goto;
pub(crate) mod hover;
pub(crate) mod inlay_hint;
pub(crate) mod references;
pub(crate) mod rename;
pub(crate) mod search_paths;
pub(crate) mod selection_range;
pub(crate) mod semantic_tokens;
pub(crate) mod signature_help;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::Cancellable;

use super::language::{Language, answered_by};
use super::{codels, verification};
use crate::protocol::types::*;
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::Snapshot;

/// Specifications and the files they include.
pub(crate) struct Specification;

impl Language for Specification {
    fn diagnostics(&self, snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>> {
        let mut all = codels::unrefuted_findings(snapshot, path)?;
        all.extend(verification::in_specification(snapshot, path)?);
        all.extend(codels::file_diagnostics(snapshot, path)?);
        Ok(all)
    }

    fn is_own(&self) -> bool {
        true
    }

    answered_by! {
        symbols: DocumentSymbolParams => Option<DocumentSymbolResponse> = document_symbol::handle;
        folds: FoldingRangeParams => Option<Vec<FoldingRange>> = folding_range::handle;
        selections: SelectionRangeParams => Option<Vec<SelectionRange>> = selection_range::handle;
        links: DocumentLinkParams => Option<Vec<DocumentLink>> = document_link::handle;
        tokens: SemanticTokensParams => Option<Vec<SemanticToken>> = semantic_tokens::full;
        tokens_in: SemanticTokensRangeParams => Option<SemanticTokensRangeResult> = semantic_tokens::range;
        definition: GotoDefinitionParams => Option<GotoDefinitionResponse> = goto::definition;
        declaration: GotoDeclarationParams => Option<GotoDeclarationResponse> = goto::declaration;
        type_definition: GotoTypeDefinitionParams => Option<GotoTypeDefinitionResponse> = goto::type_definition;
        implementation: GotoImplementationParams => Option<GotoImplementationResponse> = goto::implementation;
        references: ReferenceParams => Option<Vec<Location>> = references::handle;
        highlights: DocumentHighlightParams => Option<Vec<DocumentHighlight>> = document_highlight::handle;
        hover: HoverParams => Option<Hover> = hover::handle;
        completion: CompletionParams => Option<CompletionResponse> = completion::handle;
        signature: SignatureHelpParams => Option<SignatureHelp> = signature_help::handle;
        prepare_rename: TextDocumentPositionParams => UserResult<PrepareRenameResponse> = rename::prepare;
        rename: RenameParams => UserResult<WorkspaceEdit> = rename::rename;
        format: DocumentFormattingParams => Option<Vec<TextEdit>> = formatting::document;
        format_range: DocumentRangeFormattingParams => Option<Vec<TextEdit>> = formatting::range;
        format_typed: DocumentOnTypeFormattingParams => Option<Vec<TextEdit>> = formatting::on_type;
        hints: InlayHintParams => Option<Vec<InlayHint>> = inlay_hint::handle;
        lenses: CodeLensParams => Option<Vec<CodeLens>> = code_lens::handle;
        calls: CallHierarchyPrepareParams => Option<Vec<CallHierarchyItem>> = call_hierarchy::prepare;
        actions: CodeActionParams => Option<CodeActionResponse> = code_action::handle;
    }
}
