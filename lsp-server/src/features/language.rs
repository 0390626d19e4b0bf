//! What a language of documents has: one interface for specifications, scenarios, sources of codels and files
//! of templates.

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::Cancellable;

use crate::protocol::refusable::Refusable;
use crate::protocol::types::*;
use crate::workspace::snapshot::{Snapshot, Subject};

/// Declares [`Language`]: features by parameters and answer. By default a language has nothing to say.
macro_rules! language {
    ($($(#[$doc:meta])+ $name:ident: $params:ty => $answer:ty;)*) => {
        /// A language of documents.
        pub(crate) trait Language: Sync {
            /// What is wrong with a file.
            fn diagnostics(&self, snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<Vec<Diagnostic>>;

            /// Whether its documents are this server's alone. About those of others the client asks other
            /// servers too: what is wrong is told unasked, and nothing beyond the protocol is served.
            fn is_own(&self) -> bool {
                false
            }

            /// Whether something can be said of a file.
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
    /// What can be folded.
    folds: FoldingRangeParams => Option<Vec<FoldingRange>>;
    /// What is selected by and by around some places.
    selections: SelectionRangeParams => Option<Vec<SelectionRange>>;
    /// Names of files that can be followed.
    links: DocumentLinkParams => Option<Vec<DocumentLink>>;
    /// The tokens of a document, for colours.
    tokens: SemanticTokensParams => Option<Vec<SemanticToken>>;
    /// The tokens of a part of a document.
    tokens_in: SemanticTokensRangeParams => Option<SemanticTokensRangeResult>;
    /// Where a name is defined.
    definition: GotoDefinitionParams => Option<GotoDefinitionResponse>;
    /// Where a name is declared.
    declaration: GotoDeclarationParams => Option<GotoDeclarationResponse>;
    /// Where the type of a name is defined.
    type_definition: GotoTypeDefinitionParams => Option<GotoTypeDefinitionResponse>;
    /// Where a name is implemented.
    implementation: GotoImplementationParams => Option<GotoImplementationResponse>;
    /// All mentions of a name.
    references: ReferenceParams => Option<Vec<Location>>;
    /// The mentions of a name in the same document.
    highlights: DocumentHighlightParams => Option<Vec<DocumentHighlight>>;
    /// What a name means.
    hover: HoverParams => Option<Hover>;
    /// What may be written at a place.
    completion: CompletionParams => Option<CompletionResponse>;
    /// The parameters at a place.
    signature: SignatureHelpParams => Option<SignatureHelp>;
    /// Whether a name can be changed.
    prepare_rename: TextDocumentPositionParams => Refusable<PrepareRenameResponse>;
    /// The edits that give something another name.
    rename: RenameParams => Refusable<WorkspaceEdit>;
    /// The edits that format a document.
    format: DocumentFormattingParams => Option<Vec<TextEdit>>;
    /// The edits that format a part of a document.
    format_range: DocumentRangeFormattingParams => Option<Vec<TextEdit>>;
    /// The edits that format what was just typed.
    format_typed: DocumentOnTypeFormattingParams => Option<Vec<TextEdit>>;
    /// What is shown between the words.
    hints: InlayHintParams => Option<Vec<InlayHint>>;
    /// What is shown between the lines.
    lenses: CodeLensParams => Option<Vec<CodeLens>>;
    /// What at a place calls something or is called.
    calls: CallHierarchyPrepareParams => Option<Vec<CallHierarchyItem>>;
    /// What can be done at a place.
    actions: CodeActionParams => Option<CodeActionResponse>;
}

/// Methods of [`Language`] that a function of the same form answers.
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
