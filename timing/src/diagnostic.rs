//! Problems of scenarios and of verified systems: message, place and specifications concerned.

pub mod remark;

use std::ops::Range;

use dotgen_analysis::model::Src;
use dotgen_syntax::finding::Wording;

use self::remark::Remark;

/// Severity of a [`Diagnostic`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Nothing can be verified.
    Error,
    /// Verification goes on under an assumption.
    Warning,
}

/// A problem in a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable code: `scn-…`.
    pub code: &'static str,
    pub severity: Severity,
    /// Says what is wrong and what to do.
    pub message: Wording,
    /// Range of bytes in the scenario; empty at 0 if the problem has no place there.
    pub range: Range<usize>,
    /// Places in the specifications, the most important one first.
    pub places: Vec<Place>,
    /// The text that the author probably meant at [`Diagnostic::range`].
    pub suggestion: Option<Box<Suggestion>>,
    /// The remark, if several problems of its kind can be reported as one, see [`remark::together`].
    pub remark: Option<Box<Remark>>,
}

/// A text that the author probably meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Suggestion {
    pub text: String,
    /// A word of the language, of which there are few; otherwise a name, and another one may be meant.
    pub is_word: bool,
}

/// A place in a specification.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Number of the specification, in the order of `use`.
    pub spec: usize,
    /// Place in the specification.
    pub src: Src,
    /// Description of the place, in a few words.
    pub what: String,
}

impl Place {
    /// Returns the place without its description.
    pub(crate) fn at(&self) -> (usize, Src) {
        (self.spec, self.src)
    }
}

impl Diagnostic {
    pub(crate) fn error(
        code: &'static str,
        range: Range<usize>,
        message: impl Into<Wording>,
    ) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            message: message.into(),
            range,
            places: Vec::new(),
            suggestion: None,
            remark: None,
        }
    }

    /// Adds the name that the author probably meant, also to the message.
    pub(crate) fn suggest_name(self, name: &str) -> Self {
        self.suggest(name, false)
    }

    /// Adds the word of the language that the author probably meant, also to the message.
    pub(crate) fn suggest_word(self, word: &str) -> Self {
        self.suggest(word, true)
    }

    fn suggest(mut self, text: &str, is_word: bool) -> Self {
        self.message.advise(&format!("did you mean `{text}`?"));
        self.suggestion = Some(Box::new(Suggestion { text: text.to_owned(), is_word }));
        self
    }

    /// Adds a place in a specification.
    pub(crate) fn about(self, place: Place) -> Self {
        Diagnostic { places: vec![place], ..self }
    }

    pub(crate) fn warning(
        code: &'static str,
        range: Range<usize>,
        message: impl Into<Wording>,
    ) -> Self {
        Diagnostic {
            code,
            severity: Severity::Warning,
            message: message.into(),
            range,
            places: Vec::new(),
            suggestion: None,
            remark: None,
        }
    }
}
