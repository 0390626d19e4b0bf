//! The features of a language of documents: one table for specifications, scenarios, sources of codels and
//! templates.

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Diagnostic;
use dotgen_analysis::host::Cancellable;

use crate::protocol::types::request::*;
use crate::protocol::types::*;
use crate::protocol::user_result::UserResult;
use crate::workspace::snapshot::{Answer, Snapshot, Subject};

/// A function that answers a request about a document.
pub(crate) type Handler<P, A> = fn(&Snapshot, &Subject, &P) -> Answer<A>;

/// The handler of a request of the protocol.
type HandlerOf<R> = Handler<<R as Request>::Params, <R as Request>::Result>;

/// The features of a language. Those that a language lacks are taken from [`LanguageFeatures::NONE`].
pub(crate) struct LanguageFeatures {
    /// The diagnostics of a file.
    pub(crate) diagnostics: fn(&Snapshot, &Utf8Path) -> Cancellable<Vec<Diagnostic>>,
    /// False if the client also asks other servers about its documents: diagnostics are then sent without a
    /// request, and only the standard protocol is served.
    pub(crate) is_own: bool,
    /// Returns true if a file can have diagnostics.
    pub(crate) is_served: fn(&Snapshot, &Utf8Path) -> Cancellable<bool>,
    /// The outline.
    pub(crate) symbols: HandlerOf<DocumentSymbolRequest>,
    /// The ranges that can be folded.
    pub(crate) folds: HandlerOf<FoldingRangeRequest>,
    /// The nested ranges around some places, for growing selections.
    pub(crate) selections: HandlerOf<SelectionRangeRequest>,
    /// Links to the files that are named in a document.
    pub(crate) links: HandlerOf<DocumentLinkRequest>,
    /// The tokens of a document, for colours.
    pub(crate) tokens: HandlerOf<SemanticTokensFullRequest>,
    /// The tokens of a part of a document.
    pub(crate) tokens_in: HandlerOf<SemanticTokensRangeRequest>,
    /// The definition of a name.
    pub(crate) definition: HandlerOf<GotoDefinition>,
    /// The declaration of a name.
    pub(crate) declaration: HandlerOf<GotoDeclaration>,
    /// The definition of a name's type.
    pub(crate) type_definition: HandlerOf<GotoTypeDefinition>,
    /// The implementation of a name.
    pub(crate) implementation: HandlerOf<GotoImplementation>,
    /// All mentions of a name.
    pub(crate) references: HandlerOf<References>,
    /// The mentions of a name in the same document.
    pub(crate) highlights: HandlerOf<DocumentHighlightRequest>,
    /// The description of a name.
    pub(crate) hover: HandlerOf<HoverRequest>,
    /// The proposals at a place.
    pub(crate) completion: HandlerOf<Completion>,
    /// The parameters of the call at a place.
    pub(crate) signature: HandlerOf<SignatureHelpRequest>,
    /// The range of a name that can be renamed.
    pub(crate) prepare_rename:
        Handler<TextDocumentPositionParams, UserResult<PrepareRenameResponse>>,
    /// The edits that rename a declaration.
    pub(crate) rename: Handler<RenameParams, UserResult<WorkspaceEdit>>,
    /// The edits that format a document.
    pub(crate) format: HandlerOf<Formatting>,
    /// The edits that format a part of a document.
    pub(crate) format_range: HandlerOf<RangeFormatting>,
    /// The edits that format newly typed text.
    pub(crate) format_typed: HandlerOf<OnTypeFormatting>,
    /// Hints between the words.
    pub(crate) hints: HandlerOf<InlayHintRequest>,
    /// Lenses between the lines.
    pub(crate) lenses: HandlerOf<CodeLensRequest>,
    /// The caller or callee at a place.
    pub(crate) calls: HandlerOf<CallHierarchyPrepare>,
    /// The actions at a place.
    pub(crate) actions: HandlerOf<CodeActionRequest>,
}

impl LanguageFeatures {
    /// No features: every answer is empty.
    pub(crate) const NONE: LanguageFeatures = LanguageFeatures {
        diagnostics: |_, _| Ok(Vec::new()),
        is_own: false,
        is_served: |_, _| Ok(true),
        symbols: nothing,
        folds: nothing,
        selections: nothing,
        links: nothing,
        tokens: nothing,
        tokens_in: nothing,
        definition: nothing,
        declaration: nothing,
        type_definition: nothing,
        implementation: nothing,
        references: nothing,
        highlights: nothing,
        hover: nothing,
        completion: nothing,
        signature: nothing,
        prepare_rename: nothing,
        rename: nothing,
        format: nothing,
        format_range: nothing,
        format_typed: nothing,
        hints: nothing,
        lenses: nothing,
        calls: nothing,
        actions: nothing,
    };
}

/// The empty answer.
fn nothing<P, A: Default>(_: &Snapshot, _: &Subject, _: &P) -> Answer<A> {
    Ok(A::default())
}
