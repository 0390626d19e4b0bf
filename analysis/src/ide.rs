//! Editor features over plain types: one module per feature, byte offsets in, byte offsets out.
//!
//! Names are never resolved here: features read the resolution table of the unit that serves the
//! file (references and definitions of the elaborator) and the syntax tree.

pub(crate) mod allow;
pub(crate) mod assists;
pub(crate) mod call_hierarchy;
pub(crate) mod code_lens;
pub(crate) mod completion;
pub(crate) mod context;
pub(crate) mod context_hover;
pub(crate) mod document_links;
pub(crate) mod document_symbols;
pub(crate) mod expand_macro;
pub(crate) mod folding_ranges;
pub(crate) mod formatting;
pub(crate) mod goto;
pub(crate) mod highlights;
pub(crate) mod hover;
pub(crate) mod implementation;
pub(crate) mod inlay_hints;
pub(crate) mod keyword_hover;
pub(crate) mod named;
pub(crate) mod references;
pub(crate) mod rename;
mod render;
mod resolve;
pub(crate) mod selection_ranges;
pub(crate) mod semantic_tokens;
pub(crate) mod signature_help;
pub(crate) mod speculate;
pub(crate) mod syntax_tree;
mod view;
pub(crate) mod workspace_symbols;

use std::ops::Range;

use camino::Utf8PathBuf;
use smol_str::SmolStr;

pub use crate::elab::AccessKind;
use crate::{elab::DefKind, model::ServiceKind};
pub use allow::is_about_comment;
pub use assists::{Assist, AssistKind, TaskTime};
pub use call_hierarchy::{Call, CallItem, CallKey};
pub use code_lens::{CodeLens, LensConfig, LensKind, LensText};
pub use completion::{CodelPlace, CompletionDoc, CompletionItem, CompletionKind, plain_snippet};
pub use document_links::{MissingInclude, MissingPackages};
pub use inlay_hints::{InlayConfig, InlayHint, InlayKind, InlayTypes};
pub use rename::RenameError;
pub use rename::relative as relative_path;
pub use signature_help::SignatureHelp;
pub(crate) use view::FileView;

/// A cursor.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FilePosition {
    /// Absolute path.
    pub path: Utf8PathBuf,
    /// Byte offset.
    pub offset: usize,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FileRange {
    /// Absolute path.
    pub path: Utf8PathBuf,
    /// Byte offsets.
    pub range: Range<usize>,
}

/// A value with the range of the name under the cursor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RangeInfo<T> {
    /// The name, path or macro under the cursor.
    pub range: Range<usize>,
    /// The value.
    pub info: T,
}

/// Kinds of named things, in the words of the language.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SymbolKind {
    File,
    Macro,
    Module,
    Component,
    Interface,
    Ids,
    Struct,
    Union,
    Enum,
    Enumerator,
    Typedef,
    Native,
    Exception,
    Const,
    Member,
    Task,
    Port,
    Attribute,
    Function,
    Activity,
    Remote,
    Parameter,
    Local,
    Codel,
    State,
}

/// A target of navigation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NavTarget {
    /// Absolute path.
    pub path: Utf8PathBuf,
    /// The whole declaration.
    pub full_range: Range<usize>,
    /// The range of its name, or the place for the cursor.
    pub focus_range: Range<usize>,
    pub name: SmolStr,
    pub kind: SymbolKind,
    /// Name of the declaration that contains it.
    pub container: Option<SmolStr>,
}

/// An entry of the outline.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DocumentSymbol {
    pub name: String,
    /// Type, direction, period…
    pub detail: Option<String>,
    pub kind: SymbolKind,
    /// The whole declaration.
    pub range: Range<usize>,
    /// The name; always inside `range`.
    pub selection_range: Range<usize>,
    /// The declarations in it.
    pub children: Vec<DocumentSymbol>,
}

/// A named declaration anywhere in the workspace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkspaceSymbol {
    pub name: SmolStr,
    pub kind: SymbolKind,
    /// Name of the declaration that contains it.
    pub container: Option<SmolStr>,
    /// The name token.
    pub target: FileRange,
}

/// A declaration that was found by its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedDeclaration {
    /// Its name, after the names of the declarations that contain it, outermost first.
    pub names: Vec<String>,
    pub kind: SymbolKind,
    /// Absolute path.
    pub path: Utf8PathBuf,
    /// The name token.
    pub range: Range<usize>,
    /// The whole declaration.
    pub full_range: Range<usize>,
}

impl NamedDeclaration {
    /// The qualified name: `component.service.state`.
    pub fn qualified(&self) -> String {
        self.names.join(".")
    }
}

/// The content of a folded region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FoldKind {
    Comment,
    Imports,
    Region,
}

/// A region that can be folded; it spans several lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FoldingRange {
    /// From the first character folded to the last.
    pub range: Range<usize>,
    /// The content; `None` for the body of a declaration.
    pub kind: Option<FoldKind>,
}

/// Text that links to a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DocumentLink {
    /// The path in the directive, without quotes.
    pub range: Range<usize>,
    /// The target file.
    pub target: Utf8PathBuf,
}

/// Types of semantic tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum TokenType {
    Comment,
    Keyword,
    String,
    Number,
    Operator,
    Macro,
    Namespace,
    Type,
    Struct,
    Enum,
    EnumMember,
    Interface,
    Class,
    Property,
    Parameter,
    Variable,
    Function,
    Method,
    Event,
    /// An execution task.
    Task,
    Port,
    /// Text excluded by a conditional.
    Inactive,
    /// A preprocessor directive's own words.
    Directive,
}

impl TokenType {
    /// Returns true for a token type that a grammar without name resolution gives too. Editors with a finer
    /// grammar of their own can omit these tokens.
    pub fn is_lexical(self) -> bool {
        matches!(
            self,
            TokenType::Comment
                | TokenType::Keyword
                | TokenType::String
                | TokenType::Number
                | TokenType::Operator
                | TokenType::Directive
        )
    }
}

/// Modifiers of semantic tokens: a set of bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct TokenModifiers(pub u32);

impl TokenModifiers {
    pub const NONE: TokenModifiers = TokenModifiers(0);
    pub const DECLARATION: TokenModifiers = TokenModifiers(1);
    pub const DEFINITION: TokenModifiers = TokenModifiers(1 << 1);
    pub const READONLY: TokenModifiers = TokenModifiers(1 << 2);
    pub const MODIFICATION: TokenModifiers = TokenModifiers(1 << 3);
    pub const ASYNC: TokenModifiers = TokenModifiers(1 << 4);
    pub const DOCUMENTATION: TokenModifiers = TokenModifiers(1 << 5);
    pub const DEFAULT_LIBRARY: TokenModifiers = TokenModifiers(1 << 6);

    /// Both sets.
    #[must_use]
    pub fn with(self, other: TokenModifiers) -> TokenModifiers {
        TokenModifiers(self.0 | other.0)
    }

    /// Returns true if every bit of `other` is set.
    pub fn contains(self, other: TokenModifiers) -> bool {
        self.0 & other.0 == other.0
    }
}

/// A coloured token. Tokens do not overlap and come in text order; one may span lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SemanticToken {
    /// Byte offsets.
    pub range: Range<usize>,
    pub ty: TokenType,
    pub modifiers: TokenModifiers,
}

/// One mention of a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReferenceAt {
    pub place: FileRange,
    pub access: AccessKind,
}

/// One mention of the name under the cursor, in the same file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Highlight {
    /// The byte range.
    pub range: Range<usize>,
    pub access: AccessKind,
}

/// The content of a hover.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hover {
    pub markdown: String,
    /// The codels it describes, as names of component and codel: their prototypes in a programming language
    /// are not known here.
    pub codels: Vec<(String, String)>,
}

impl From<DefKind> for SymbolKind {
    fn from(kind: DefKind) -> SymbolKind {
        match kind {
            DefKind::Module => SymbolKind::Module,
            DefKind::Component => SymbolKind::Component,
            DefKind::Interface => SymbolKind::Interface,
            DefKind::Typedef => SymbolKind::Typedef,
            DefKind::Struct => SymbolKind::Struct,
            DefKind::Union => SymbolKind::Union,
            DefKind::Enum => SymbolKind::Enum,
            DefKind::Enumerator => SymbolKind::Enumerator,
            DefKind::Member | DefKind::IdsMember => SymbolKind::Member,
            DefKind::Exception => SymbolKind::Exception,
            DefKind::Native => SymbolKind::Native,
            DefKind::Const => SymbolKind::Const,
            DefKind::Ids => SymbolKind::Ids,
            DefKind::Task => SymbolKind::Task,
            DefKind::Port => SymbolKind::Port,
            DefKind::Attribute => SymbolKind::Attribute,
            DefKind::Function => SymbolKind::Function,
            DefKind::Activity => SymbolKind::Activity,
            DefKind::Parameter | DefKind::CodelParameter => SymbolKind::Parameter,
            DefKind::Local => SymbolKind::Local,
            DefKind::Codel => SymbolKind::Codel,
            DefKind::State => SymbolKind::State,
        }
    }
}

impl From<ServiceKind> for SymbolKind {
    fn from(kind: ServiceKind) -> SymbolKind {
        match kind {
            ServiceKind::Attribute => SymbolKind::Attribute,
            ServiceKind::Function => SymbolKind::Function,
            ServiceKind::Activity => SymbolKind::Activity,
        }
    }
}

/// The expansion of a macro call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MacroExpansion {
    /// Name of the macro.
    pub name: SmolStr,
    /// The tokens of the expansion, spaced as they were written.
    pub expansion: String,
}
