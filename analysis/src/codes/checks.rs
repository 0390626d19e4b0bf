//! Every diagnostic code of specifications, by family.
//!
//! The codes are those of the language reference, section 19; additional codes, which the reference compiler
//! does not have, are marked with [`ours`].

mod advice;
mod codels;
mod components;
mod names;
mod services;
mod times;
mod values;

use super::Cause;
use crate::diagnostic::Severity;

/// An entry of the table: one code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The code, as shown and as used in configuration.
    pub id: &'static str,
    /// Severity unless configured otherwise.
    pub severity: Severity,
    /// The meaning, in one sentence.
    pub meaning: &'static str,
    /// The reason for the rule, or the consequence of breaking it.
    pub why: &'static str,
    /// Advice on how to correct the text.
    pub fix: &'static str,
    /// Set if the reference compiler reports it too.
    pub reference: bool,
    /// The causes of which the finding can be a mere consequence.
    pub follows: &'static [Cause],
}

impl Code {
    const fn follows(self, follows: &'static [Cause]) -> Code {
        Code { follows, ..self }
    }
}

/// The families, in the order of the reference.
const FAMILIES: &[&[Code]] = &[
    names::CODES,
    values::CODES,
    components::CODES,
    services::CODES,
    codels::CODES,
    times::CODES,
    advice::CODES,
];

const fn error(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    fix: &'static str,
) -> Code {
    Code { id, severity: Severity::Error, meaning, why, fix, reference: true, follows: &[] }
}

const fn warning(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    fix: &'static str,
) -> Code {
    Code { severity: Severity::Warning, ..error(id, meaning, why, fix) }
}

const fn hint(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    fix: &'static str,
) -> Code {
    Code { severity: Severity::Hint, ..error(id, meaning, why, fix) }
}

/// Marks a code that the reference compiler does not report.
const fn ours(code: Code) -> Code {
    Code { reference: false, ..code }
}

/// All codes that elaboration and the checks of components report.
pub fn all() -> impl Iterator<Item = &'static Code> {
    FAMILIES.iter().copied().flatten()
}

/// The entry of a code.
pub fn find(id: &str) -> Option<&'static Code> {
    all().find(|code| code.id == id)
}
