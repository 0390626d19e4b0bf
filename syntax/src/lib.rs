//! Text to tree: lexer, preprocessor, lossless syntax tree and typed AST of GenoM3 specifications.

pub mod ast;
pub mod codes;
pub mod directive;
mod dump;
pub mod encoding;
mod expansion;
pub mod finding;
pub mod format;
mod fragment;
pub mod kind;
pub mod lexer;
pub mod line_index;
pub mod packages;
mod parse;
pub mod parser;
pub mod preproc;
pub mod release;
mod sink;
pub mod suggestion;

pub use dump::dump;
pub use expansion::ExpansionMap;
pub use fragment::Fragment;
pub use kind::SyntaxKind;
pub use parse::{Parse, parse, parse_text};
pub use parser::{Severity, SyntaxError};
pub use rowan::{
    GreenNode, GreenNodeData, NodeOrToken, TextRange, TextSize, TokenAtOffset, WalkEvent,
};

/// The language tag of the trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum GenomLanguage {}

impl rowan::Language for GenomLanguage {
    type Kind = SyntaxKind;

    fn kind_from_raw(raw: rowan::SyntaxKind) -> SyntaxKind {
        SyntaxKind::from_raw(raw.0)
    }

    fn kind_to_raw(kind: SyntaxKind) -> rowan::SyntaxKind {
        kind.into()
    }
}

/// A node of the tree.
pub type SyntaxNode = rowan::SyntaxNode<GenomLanguage>;
/// A leaf of the tree.
pub type SyntaxToken = rowan::SyntaxToken<GenomLanguage>;
/// A node or a leaf.
pub type SyntaxElement = rowan::SyntaxElement<GenomLanguage>;

// The tests of the crate as others use it, in the program of the unit tests: each program takes seconds to
// link.
#[cfg(test)]
extern crate self as dotgen_syntax;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod suite;
