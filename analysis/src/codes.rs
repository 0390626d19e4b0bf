//! All diagnostic codes of all layers.
//!
//! Each layer has a table of its own: [`dotgen_syntax::codes`], [`checks`], [`lints`] and [`verification`].
//! The manual and the configuration use them as one table. The layer above, which compares specifications
//! with their codels, adds its own: those that begin with [`CODEL`].

pub mod checks;
pub mod lints;
pub mod verification;

use dotgen_syntax::{codes as syntax, preproc};

use crate::diagnostic::Severity;

/// A diagnostic code as shown to users. Its page is in `docs/diagnostics`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The code.
    pub id: &'static str,
    /// Severity unless configured otherwise.
    pub severity: Severity,
    /// Set if it is reported unless configured otherwise.
    pub on: bool,
    /// Set if the reference compiler reports it too.
    pub reference: bool,
}

/// An error of which other findings can be mere consequences. These are left out while the cause is reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Text was not read, so that declarations may be missing.
    UnreadText,
    /// Some data, task or service has no name yet: codels may mention its future name.
    NamelessDeclaration,
    /// The text of a task or service cannot be parsed, so that codels may be missing.
    BrokenMachine,
    /// The list of yields of a codel of the task or service is not finished.
    OpenMachine,
}

/// The causes of which a finding with a code can be a mere consequence.
pub(crate) fn follows(code: &str) -> &'static [Cause] {
    checks::find(code)
        .map(|check| check.follows)
        .or_else(|| lints::find(code).map(|lint| lint.follows))
        .unwrap_or_default()
}

/// The prefix of the codes that come from a comparison with sources in C and C++.
pub const CODEL: &str = "codel/";

/// Returns true if a finding is about this machine and not about the text: a package that is not installed, a
/// file that is not found. GenoM3 rejects such a specification; with the package installed, it is valid.
pub fn is_environment(code: &str) -> bool {
    syntax::find(code).is_some_and(|code| code.environment)
}

/// The severity of a finding if files or packages missing on this machine are not errors of the text.
pub fn severity_here(code: &str, severity: Severity) -> Severity {
    match severity {
        Severity::Error if is_environment(code) => Severity::Warning,
        severity => severity,
    }
}

/// All codes of this layer and the layers below.
pub fn all() -> impl Iterator<Item = Code> {
    let syntax = syntax::all().map(|code| Code {
        id: code.id,
        severity: match code.severity {
            preproc::Severity::Error => Severity::Error,
            preproc::Severity::Warning => Severity::Warning,
            preproc::Severity::Hint => Severity::Hint,
        },
        on: true,
        reference: code.reference,
    });
    let checks = checks::all().map(|code| Code {
        id: code.id,
        severity: code.severity,
        on: true,
        reference: code.reference,
    });
    let lints = lints::CODES.iter().chain(verification::CODES).map(|code| Code {
        id: code.id,
        severity: code.severity,
        on: code.on,
        reference: false,
    });
    syntax.chain(checks).chain(lints)
}
