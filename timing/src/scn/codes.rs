//! Every diagnostic code of scenarios, by family, for the manual.

mod checks;
mod model;
mod names;
mod text;

use crate::diagnostic::Severity;

/// An entry of the table: one code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// Code, as shown.
    pub id: &'static str,
    /// Severity.
    pub severity: Severity,
    /// Meaning, in one sentence.
    pub meaning: &'static str,
    /// Reason for the rule, or the consequence.
    pub why: &'static str,
    /// Advice on how to correct the scenario.
    pub fix: &'static str,
    /// Specification of the example; empty if the example works with any specification that has its names.
    pub specification: &'static str,
    /// Scenario that triggers the code, or a comment if none is short enough.
    pub example: &'static str,
    /// Corrected scenario or specification; empty if no text can show a correction.
    pub corrected: &'static str,
}

/// The families.
const FAMILIES: &[&[Code]] = &[text::CODES, names::CODES, model::CODES, checks::CODES];

const fn error(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    fix: &'static str,
    example: &'static str,
    corrected: &'static str,
) -> Code {
    Code { id, severity: Severity::Error, meaning, why, fix, specification: "", example, corrected }
}

const fn warning(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    fix: &'static str,
    example: &'static str,
    corrected: &'static str,
) -> Code {
    Code { severity: Severity::Warning, ..error(id, meaning, why, fix, example, corrected) }
}

/// Adds the specification of the example.
const fn of_specification(specification: &'static str, code: Code) -> Code {
    Code { specification, ..code }
}

/// All codes of scenarios.
pub fn all() -> impl Iterator<Item = &'static Code> {
    FAMILIES.iter().copied().flatten()
}
