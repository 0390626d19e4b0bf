//! All diagnostic codes of all layers.
//!
//! Each layer has a table of its own: [`dotgen_syntax::codes`], [`checks`], [`lints`] and [`verification`].
//! The manual and the configuration use them as one table. The layer above, which compares specifications
//! with their codels, adds its own: those that begin with [`CODEL`].

pub mod checks;
pub mod lints;
pub mod verification;

use dotgen_syntax::codes as syntax;

use crate::diagnostic::Severity;

/// A diagnostic code as shown to users and as used in configuration. Its page is in `docs/diagnostics`.
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
    /// Set if the rule reports something missing, so it runs only if the specification is accepted.
    pub absence: bool,
    /// Set if the marked text can be removed; editors fade it.
    pub unnecessary: bool,
    /// The causes of which the finding can be a mere consequence.
    pub follows: &'static [Cause],
}

impl Code {
    /// A code that dotgen reports unless configured otherwise, and the reference compiler does not.
    pub const fn new(id: &'static str, severity: Severity) -> Code {
        Code {
            id,
            severity,
            on: true,
            reference: false,
            absence: false,
            unnecessary: false,
            follows: &[],
        }
    }

    /// A code of an error that the reference compiler reports too.
    pub const fn error(id: &'static str) -> Code {
        Code::new(id, Severity::Error).of_reference(true)
    }

    const fn of_reference(self, reference: bool) -> Code {
        Code { reference, ..self }
    }

    const fn off(self) -> Code {
        Code { on: false, ..self }
    }

    const fn absence(self) -> Code {
        Code { absence: true, ..self }
    }

    const fn unnecessary(self) -> Code {
        Code { unnecessary: true, ..self }
    }

    const fn follows(self, follows: &'static [Cause]) -> Code {
        Code { follows, ..self }
    }
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
    find(code).map(|code| code.follows).unwrap_or_default()
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
    let syntax =
        syntax::all().map(|code| Code::new(code.id, code.severity).of_reference(code.reference));
    syntax.chain([checks::CODES, lints::CODES, verification::CODES].into_iter().flatten().copied())
}

/// The entry of a code of elaboration, of the checks of components or of a lint.
pub fn find(id: &str) -> Option<&'static Code> {
    checks::CODES.iter().chain(lints::CODES).find(|code| code.id == id)
}
