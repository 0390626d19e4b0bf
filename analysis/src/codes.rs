//! All diagnostic codes, whatever layer reports them.
//!
//! Each layer has a table of its own: [`dotgen_syntax::codes`], [`checks`], [`lints`] and [`verification`].
//! The manual and the configuration see them as one. The layer above, which compares specifications with
//! their codels, adds its own: those that begin with [`CODEL`].

pub mod checks;
pub mod lints;
pub mod verification;

use dotgen_syntax::{codes as syntax, preproc};

use crate::diagnostic::Severity;

/// A diagnostic code as its users know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The code.
    pub id: &'static str,
    /// Severity unless configured otherwise.
    pub severity: Severity,
    /// Whether it is reported unless configured otherwise.
    pub on: bool,
    /// What it means, in one line.
    pub meaning: &'static str,
    /// Why it matters, when that is not plain.
    pub why: Option<&'static str>,
    /// A text that triggers it, where the table has one.
    pub example: Option<&'static str>,
    /// What to do about it.
    pub fix: Option<&'static str>,
    /// Whether the reference compiler reports it too.
    pub reference: bool,
}

/// What the codes begin with that come from a comparison with sources in C and C++.
pub const CODEL: &str = "codel/";

/// Whether a finding is about this machine and not about the text: a package that is not installed, a file
/// that is not found. GenoM3 refuses such a specification; where it is installed, nothing is wrong with it.
pub fn is_environment(code: &str) -> bool {
    matches!(code, "pp-requires-unresolved" | "pp-include-not-found")
}

/// All codes of this layer and those below.
pub fn all() -> impl Iterator<Item = Code> {
    let syntax = syntax::CODES.iter().map(|it| Code {
        id: it.id,
        severity: match it.severity {
            preproc::Severity::Error => Severity::Error,
            preproc::Severity::Warning => Severity::Warning,
            preproc::Severity::Hint => Severity::Hint,
        },
        on: true,
        meaning: it.meaning,
        why: None,
        example: Some(it.example),
        fix: None,
        reference: it.reference,
    });
    let checks = checks::CODES.iter().map(|it| Code {
        id: it.id,
        severity: it.severity,
        on: true,
        meaning: it.meaning,
        why: None,
        example: None,
        fix: None,
        reference: it.reference,
    });
    let lints = lints::CODES
        .iter()
        .chain(verification::CODES)
        .map(|it| Code {
            id: it.id,
            severity: it.severity,
            on: it.on,
            meaning: it.meaning,
            why: Some(it.why),
            example: Some(it.example),
            fix: Some(it.fix),
            reference: false,
        });
    syntax.chain(checks).chain(lints)
}
