//! The scenario language (`.scn`): what to verify, on which platform, and under which assumptions.
//!
//! Text becomes tokens, tokens become an [`ast::Scenario`] with a range on every name, and problems
//! become [`Diagnostic`]s; none of it ever fails. Paths are looked up in the components by
//! [`names`], which is also what editor features ask.

pub mod ast;
pub mod complete;
mod default;
pub mod describe;
mod format;
pub mod lexer;
pub mod names;
pub mod outline;
mod parser;
mod words;

use std::ops::Range;

pub use default::{default_text, default_text_on};
pub use format::format;
pub use parser::{Parse, parse, parse_check};

/// Severity of a [`Diagnostic`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Nothing can be verified.
    Error,
    /// Verification goes on under an assumption that the user should know.
    Warning,
}

/// A problem in a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable name: `scn-…`.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong and what to do.
    pub message: String,
    /// Bytes of the scenario; empty at 0 if it is about no place in it.
    pub range: Range<usize>,
}

impl Diagnostic {
    pub(crate) fn error(code: &'static str, range: Range<usize>, message: String) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            message,
            range,
        }
    }

    pub(crate) fn warning(code: &'static str, range: Range<usize>, message: String) -> Self {
        Diagnostic {
            code,
            severity: Severity::Warning,
            message,
            range,
        }
    }
}
