//! Every diagnostic code of the lexer, the preprocessor and the parser.
//!
//! Conditions are those of the language reference, section 19. Each code has a page in `docs/diagnostics`.

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
    Lexer,
    Parser,
}

/// An entry of the table: one code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The code, as shown and as used in configuration.
    pub id: &'static str,
    /// Severity unless configured otherwise.
    pub severity: Severity,
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

const fn error(id: &'static str) -> Code {
    Code {
        id,
        severity: Severity::Error,
        reference: true,
        stage: Stage::Preprocessor,
        cut: false,
        stops: true,
        environment: false,
    }
}

const fn warning(id: &'static str) -> Code {
    Code { severity: Severity::Warning, ..error(id) }
}

const fn hint(id: &'static str) -> Code {
    Code { severity: Severity::Hint, ..error(id) }
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

/// All codes, in the order of the reference.
const CODES: &[Code] = &[
    error("pp-include-not-found").environment(),
    error("pp-include-bad"),
    error("pp-include-depth"),
    error("pp-define-bad"),
    error("pp-define-dup-param"),
    error("pp-va-args"),
    error("pp-stringize"),
    warning("pp-redefined"),
    error("pp-undef-bad"),
    error("pp-line-bad"),
    error("pp-macro-args"),
    error("pp-macro-eof").cut(),
    error("pp-macro-limit"),
    error("pp-bad-char"),
    error("pp-pragma-bad"),
    error("pp-pragma-operator"),
    error("pp-requires-empty"),
    error("pp-requires-many"),
    error("pp-requires-unresolved").environment(),
    hint("pp-requires-own"),
    error("pp-cond-unterminated").cut(),
    error("pp-else-without-if"),
    error("pp-elif-without-if"),
    error("pp-endif-without-if"),
    error("pp-else-twice"),
    error("pp-extra-tokens"),
    warning("pp-extra-tokens-tail"),
    warning("pp-no-newline"),
    error("pp-ifdef-bad"),
    error("pp-if-syntax"),
    error("pp-if-div-zero"),
    error("pp-if-operator"),
    error("pp-if-range"),
    error("pp-error-directive"),
    warning("pp-warning-directive"),
    error("pp-input"),
    ours(error("pp-include-place")),
    ours(error("pp-misspelt-directive")),
    ours(hint("pp-unknown-directive")),
    ours(hint("inactive-code").at(Stage::File).goes_on()),
    ours(warning("not-utf8").at(Stage::File).goes_on()),
    error("lex-stray").at(Stage::Lexer).goes_on(),
    error("lex-comment-open").at(Stage::Lexer).goes_on().cut(),
    error("syntax").at(Stage::Parser),
    error(AT_END).at(Stage::Parser).cut(),
    error("missing-semicolon").at(Stage::Parser).goes_on(),
    error("missing-yield").at(Stage::Parser).goes_on().cut(),
];

/// All codes of this layer.
pub fn all() -> impl Iterator<Item = &'static Code> {
    CODES.iter()
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
