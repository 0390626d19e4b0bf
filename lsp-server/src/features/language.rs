//! The features of a language of documents: one interface for specifications, scenarios, sources of codels
//! and template files.

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::Cancellable;

use crate::protocol::types::*;
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Declares [`Language`]: features by parameters and answer. The default answer of every feature is empty.
macro_rules! language {
    ($($(#[$doc:meta])+ $name:ident: $params:ty => $answer:ty;)*) => {
        /// A language of documents.
        pub(crate) trait Language: Sync {
            /// The diagnostics of a file.
            fn diagnostics(&self, snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>>;

            /// True if no other server serves its documents. For other documents the client also asks other
            /// servers: diagnostics are then sent without a request, and only the standard protocol is
            /// served.
            fn is_own(&self) -> bool {
                false
            }

            /// True if a file can have diagnostics.
            fn is_served(&self, _: &Snapshot, _: &Utf8Path) -> Cancellable<bool> {
                Ok(true)
            }

            $(
                $(#[$doc])+
                fn $name(&self, _: &Snapshot, _: &Subject, _: &$params) -> Cancellable<$answer> {
                    Ok(Default::default())
                }
            )*
        }
    };
}

language! {
    /// The outline.
    symbols: DocumentSymbolParams => Option<DocumentSymbolResponse>;
    /// The ranges that can be folded.
    folds: FoldingRangeParams => Option<Vec<FoldingRange>>;
    /// The nested ranges around some places, for growing selections.
    selections: SelectionRangeParams => Option<Vec<SelectionRange>>;
    /// Links to the files that are named in a document.
    links: DocumentLinkParams => Option<Vec<DocumentLink>>;
    /// The tokens of a document, for colours.
    tokens: SemanticTokensParams => Option<Vec<SemanticToken>>;
    /// The tokens of a part of a document.
    tokens_in: SemanticTokensRangeParams => Option<SemanticTokensRangeResult>;
    /// The definition of a name.
    definition: GotoDefinitionParams => Option<GotoDefinitionResponse>;
    /// The declaration of a name.
    declaration: GotoDeclarationParams => Option<GotoDeclarationResponse>;
    /// The definition of a name's type.
    type_definition: GotoTypeDefinitionParams => Option<GotoTypeDefinitionResponse>;
    /// The implementation of a name.
    implementation: GotoImplementationParams => Option<GotoImplementationResponse>;
    /// All mentions of a name.
    references: ReferenceParams => Option<Vec<Location>>;
    /// The mentions of a name in the same document.
    highlights: DocumentHighlightParams => Option<Vec<DocumentHighlight>>;
    /// The description of a name.
    hover: HoverParams => Option<Hover>;
    /// The proposals at a place.
    completion: CompletionParams => Option<CompletionResponse>;
    /// The parameters of the call at a place.
    signature: SignatureHelpParams => Option<SignatureHelp>;
    /// The range of a name that can be renamed.
    prepare_rename: TextDocumentPositionParams => UserResult<PrepareRenameResponse>;
    /// The edits that rename a declaration.
    rename: RenameParams => UserResult<WorkspaceEdit>;
    /// The edits that format a document.
    format: DocumentFormattingParams => Option<Vec<TextEdit>>;
    /// The edits that format a part of a document.
    format_range: DocumentRangeFormattingParams => Option<Vec<TextEdit>>;
    /// The edits that format newly typed text.
    format_typed: DocumentOnTypeFormattingParams => Option<Vec<TextEdit>>;
    /// Hints between the words.
    hints: InlayHintParams => Option<Vec<InlayHint>>;
    /// Lenses between the lines.
    lenses: CodeLensParams => Option<Vec<CodeLens>>;
    /// The caller or callee at a place.
    calls: CallHierarchyPrepareParams => Option<Vec<CallHierarchyItem>>;
    /// The actions at a place.
    actions: CodeActionParams => Option<CodeActionResponse>;
}

/// Methods of [`Language`] that call a function of the same signature.
macro_rules! answered_by {
    ($($name:ident: $params:ty => $answer:ty = $handler:path;)*) => {
        $(
            fn $name(
                &self,
                snapshot: &crate::workspace::snapshot::Snapshot,
                subject: &crate::workspace::snapshot::Subject,
                params: &$params,
            ) -> dotgen_analysis::host::Cancellable<$answer> {
                $handler(snapshot, subject, params)
            }
        )*
    };
}

pub(crate) use answered_by;
