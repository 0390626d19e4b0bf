//! The output of the preprocessor for one file.

use rowan::TextRange;
use serde::{Deserialize, Serialize};
use smol_str::SmolStr;

use super::{Element, IncludeRequest, MacroEnv, MacroSite};
use crate::{
    directive::{Directive, DirectiveKind},
    finding::preprocessing::Preprocessing,
};

/// An active `#include` and its result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ActiveInclude {
    /// Index of the directive.
    pub directive: u32,
    /// The requested file; `None` if the directive is malformed.
    pub request: Option<IncludeRequest>,
    /// The operand in the text, delimiters included.
    pub range: TextRange,
    /// True if the host included the file.
    pub included: bool,
}

/// A macro name in the text that was looked up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MacroUse {
    pub name: SmolStr,
    /// The name in the text.
    pub range: TextRange,
    /// The definition in force; `None` if there is none (in `#ifdef`, `defined`, `#undef`).
    pub site: Option<MacroSite>,
}

/// The severity of a finding. Only errors reject a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    Error,
    Warning,
    Information,
    Hint,
}

/// An error or warning about the characters or directives of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PpError {
    /// The error as data.
    pub kind: Preprocessing,
    /// The range in the text of the file.
    pub range: TextRange,
    pub severity: Severity,
    /// Another range that explains the error, and its description.
    pub related: Option<(TextRange, &'static str)>,
}

/// The preprocessor's result for one file in one environment.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Preprocessed {
    /// The classification of the raw tokens, in text order.
    pub elements: Vec<Element>,
    /// All directives, in text order; directives in inactive text are not elements of their own.
    pub directives: Vec<Directive>,
    /// The active `#include`s; an `#include`'s ordinal is its index here.
    pub includes: Vec<ActiveInclude>,
    /// All errors, in text order.
    pub errors: Vec<PpError>,
    /// Names of macros in the text, in text order.
    pub macro_uses: Vec<MacroUse>,
    /// Text left out by conditionals, whole lines.
    pub inactive: Vec<TextRange>,
    /// The environment at the end of the file.
    pub exit_env: MacroEnv,
}

impl Preprocessed {
    /// The `ordinal`-th `#define` of the file, active or not; see [`MacroSite`].
    pub(crate) fn define_directive(&self, ordinal: u32) -> Option<&Directive> {
        self.directives.iter().find(
            |directive| matches!(&directive.kind, DirectiveKind::Define(define) if define.ordinal == ordinal),
        )
    }

    /// The ordinal of an active `#include`, by the index of its directive.
    pub fn include_ordinal(&self, directive: u32) -> Option<u32> {
        let found = self.includes.binary_search_by_key(&directive, |include| include.directive);
        found.ok().map(|ordinal| ordinal as u32)
    }
}
