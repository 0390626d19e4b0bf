//! The C preprocessor, as far as `.gen` files have one (language reference, section 2).
//!
//! `preprocess` walks the raw tokens of one file, in order, with the macro environment at its start, and
//! classifies each token. It never copies included text: an active `#include` is passed to the host, which
//! returns the environment after it.
//!
//! The parser reads the `Real` and `Virtual` elements only; the tree builder writes every raw token exactly
//! once, so that the text of a tree is the text of the file.

mod body;
mod cond;
pub mod definition;
mod env;
mod expand;
mod host;
mod output;
mod token;
mod walk;

use smol_str::SmolStr;

use crate::kind::SyntaxKind;

pub use definition::{Macro, MacroKind};
pub use env::{MacroEnv, MentionedWords, mentioned};
pub use host::{Host, IncludeError, IncludeRequest, NoIncludes, RequiredPackages};
pub use output::{ActiveInclude, MacroUse, PpError, Preprocessed, Severity};
pub use walk::preprocess;

/// The preprocessor's reading of the next raw tokens of a file, in text order.
///
/// `first..end` are indexes into the raw tokens; consecutive elements cover them all without gap.
/// [`Element::Virtual`] covers none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Element {
    /// One token that the grammar skips: white space, a comment, a splice, or a character that does not start
    /// a token (reported in the errors).
    Trivia(u32),
    /// One token passed on as it is.
    Real(u32),
    /// One token expanded from a macro; zero width, it follows the [`Element::Call`] it comes from.
    Virtual(Box<VirtualToken>),
    /// The raw tokens of a macro call, name and arguments; they are not read by the parser. A token
    /// broken by a splice is presented likewise, as if it were a macro for its clean text.
    Call {
        /// First raw token.
        first: u32,
        /// One past the last.
        end: u32,
    },
    /// A directive line, from `#` to the line end (excluded), or a `_Pragma("…")`. One that comes out
    /// of a macro covers no token and follows the call.
    Directive {
        /// First raw token.
        first: u32,
        /// One past the last.
        end: u32,
        /// Index into the directives of the file.
        index: u32,
    },
    /// Text left out by a conditional.
    Inactive {
        /// First raw token.
        first: u32,
        /// One past the last.
        end: u32,
    },
}

/// A token that exists only after macro expansion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VirtualToken {
    /// Kind after re-lexing (pasting and stringizing included).
    pub kind: SyntaxKind,
    pub text: SmolStr,
    /// The origin of its spelling.
    pub origin: Origin,
    /// No blank before it in the expansion (matters for units glued to numbers).
    pub glued: bool,
}

/// The origin of the spelling of a virtual token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// A token of an argument written at the call: index of the raw token in this file.
    Argument(u32),
    Body(MacroSite),
    /// Pasted, stringized, or predefined.
    Synthetic,
}

/// The definition of a macro: the `ordinal`-th `#define` of a file. `None` in [`MacroSite::file`] means the
/// command line or a predefined macro.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MacroSite {
    /// Path of the file as the host names it.
    pub file: Option<SmolStr>,
    /// Ordinal among the `#define` directives of that file.
    pub ordinal: u32,
}
