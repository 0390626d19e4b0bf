//! Every diagnostic code of the lexer, the preprocessor and the parser, by family.
//!
//! Conditions are those of the language reference, section 19; each has the smallest text that
//! triggers it, for the manual.

mod grammar;
mod preprocessor;

use crate::preproc::Severity;

/// The code of a declaration that does not end in its file.
pub const AT_END: &str = "syntax-eof";

/// The stage of reading that reports a code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The bytes of a file, and the parts of it that are excluded. GenoM3 has no such messages.
    File,
    /// The preprocessor. GenoM3 prints its messages in a form of their own.
    Preprocessor,
    /// The lexer.
    Lexer,
    /// The parser.
    Parser,
}

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
    /// A text that triggers it.
    pub example: &'static str,
    /// The corrected example; empty if no text can show the correction.
    pub corrected: &'static str,
    /// Set if the reference compiler reports it too.
    pub reference: bool,
    /// The stage that reports it.
    pub stage: Stage,
    /// Set if the text may be incomplete, as it is while an author types.
    pub cut: bool,
    /// Set if GenoM3 reads no further. After other errors it goes on.
    pub stops: bool,
    /// Set if it is about this machine and not about the text.
    pub environment: bool,
}

/// The families, in the order of the reference.
const FAMILIES: &[&[Code]] = &[preprocessor::CODES, grammar::CODES];

const fn error(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    fix: &'static str,
    example: &'static str,
    corrected: &'static str,
) -> Code {
    Code {
        id,
        severity: Severity::Error,
        meaning,
        why,
        fix,
        example,
        corrected,
        reference: true,
        stage: Stage::Preprocessor,
        cut: false,
        stops: true,
        environment: false,
    }
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

const fn hint(
    id: &'static str,
    meaning: &'static str,
    why: &'static str,
    fix: &'static str,
    example: &'static str,
    corrected: &'static str,
) -> Code {
    Code { severity: Severity::Hint, ..error(id, meaning, why, fix, example, corrected) }
}

/// Marks a code that the reference compiler does not report.
const fn ours(code: Code) -> Code {
    Code { reference: false, ..code }
}

impl Code {
    const fn at(self, stage: Stage) -> Code {
        Code { stage, ..self }
    }

    /// Marks a code after which GenoM3 reads on.
    const fn goes_on(self) -> Code {
        Code { stops: false, ..self }
    }

    /// Marks a code of a text that may be incomplete.
    const fn cut(self) -> Code {
        Code { cut: true, ..self }
    }

    /// Marks a code about this machine: a package that is not installed, a file that is not found.
    const fn environment(self) -> Code {
        Code { environment: true, ..self }
    }
}

/// All codes of this layer.
pub fn all() -> impl Iterator<Item = &'static Code> {
    FAMILIES.iter().copied().flatten()
}

/// Returns true for the code of a text that may be incomplete.
pub fn is_cut(id: &str) -> bool {
    find(id).is_some_and(|code| code.cut)
}

/// Returns true for the code of an error after which GenoM3 reads no further.
pub fn stops(id: &str) -> bool {
    find(id).is_some_and(|code| code.stops)
}

/// The stage of reading that reports a code; `None` for a code of a later layer.
pub fn stage(id: &str) -> Option<Stage> {
    find(id).map(|code| code.stage)
}

/// The entry of a code.
pub fn find(id: &str) -> Option<&'static Code> {
    all().find(|code| code.id == id)
}
