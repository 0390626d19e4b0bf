//! Problems of scenarios and of what is verified: what is wrong, where, and in which specifications.

pub mod remark;

use std::ops::Range;

use dotgen_analysis::model::Src;

use self::remark::Remark;

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
    /// Places in the specifications that it is about, the first of them most.
    pub places: Vec<Place>,
    /// Set for what can be said of several things at once, see [`remark::together`].
    pub remark: Option<Box<Remark>>,
}

/// A place in a specification.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Number of the specification, in the order of `use`.
    pub spec: usize,
    /// Where in it.
    pub src: Src,
    /// What is there, in few words.
    pub what: String,
}

impl Place {
    /// Without words.
    pub(crate) fn at(&self) -> (usize, Src) {
        (self.spec, self.src)
    }
}

impl Diagnostic {
    pub(crate) fn error(code: &'static str, range: Range<usize>, message: String) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            message,
            range,
            places: Vec::new(),
            remark: None,
        }
    }

    /// Likewise, about a place in a specification.
    pub(crate) fn about(self, place: Place) -> Self {
        Diagnostic {
            places: vec![place],
            ..self
        }
    }

    pub(crate) fn warning(code: &'static str, range: Range<usize>, message: String) -> Self {
        Diagnostic {
            code,
            severity: Severity::Warning,
            message,
            range,
            places: Vec::new(),
            remark: None,
        }
    }
}
