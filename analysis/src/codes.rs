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
    /// Set if it is reported unless configured otherwise.
    pub on: bool,
    /// The meaning, in one sentence.
    pub meaning: &'static str,
    /// The reason for the rule, or what goes wrong.
    pub why: &'static str,
    /// A text that triggers it; `None` if a fixture of the tests has it.
    pub example: Option<&'static str>,
    /// The example as it should be; `None` if a fixture has it, or no text can show that.
    pub corrected: Option<&'static str>,
    /// Advice on how to mend the text.
    pub fix: &'static str,
    /// Set if the reference compiler reports it too.
    pub reference: bool,
}

/// What the codes begin with that come from a comparison with sources in C and C++.
pub const CODEL: &str = "codel/";

/// Whether a finding is about this machine and not about the text: a package that is not installed, a file
/// that is not found. GenoM3 refuses such a specification; where it is installed, nothing is wrong with it.
pub fn is_environment(code: &str) -> bool {
    matches!(code, "pp-requires-unresolved" | "pp-include-not-found")
}

/// The severity of a finding where what is missing on this machine is no error of the text.
pub fn severity_here(code: &str, severity: Severity) -> Severity {
    match severity {
        Severity::Error if is_environment(code) => Severity::Warning,
        severity => severity,
    }
}

/// All codes of this layer and those below.
pub fn all() -> impl Iterator<Item = Code> {
    let syntax = syntax::all().map(|it| Code {
        id: it.id,
        severity: match it.severity {
            preproc::Severity::Error => Severity::Error,
            preproc::Severity::Warning => Severity::Warning,
            preproc::Severity::Hint => Severity::Hint,
        },
        on: true,
        meaning: it.meaning,
        why: it.why,
        example: Some(it.example),
        corrected: shown(it.corrected),
        fix: it.fix,
        reference: it.reference,
    });
    let checks = checks::all().map(|it| Code {
        id: it.id,
        severity: it.severity,
        on: true,
        meaning: it.meaning,
        why: it.why,
        example: None,
        corrected: None,
        fix: it.fix,
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
            why: it.why,
            example: Some(it.example),
            corrected: shown(it.corrected),
            fix: it.fix,
            reference: false,
        });
    syntax.chain(checks).chain(lints)
}

/// A text of a table, unless it is empty.
fn shown(text: &'static str) -> Option<&'static str> {
    (!text.is_empty()).then_some(text)
}
