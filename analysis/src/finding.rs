//! Findings: errors and warnings about a specification, as data.
//!
//! A [`Finding`] has its [`FindingKind`], its place, and related places. The message, the advice, the wording
//! of the reference compiler and the fixes are made from the kind when a finding is placed in a file
//! ([`crate::report`]); no code parses a message.
//!
//! Each family has a file of its own, with the code and the wording of every kind.

pub mod codels;
pub mod files;
pub mod lints;
pub mod names;
pub mod role;
pub mod services;
mod syntax;
pub mod values;

use dotgen_syntax::{
    SyntaxError,
    finding::{Wording, preprocessing::Preprocessing},
};
use smol_str::SmolStr;

use self::{
    codels::CodelProblem, files::FileProblem, lints::LintWarning, names::NameProblem, role::Role,
    services::DeclarationProblem, values::ValueProblem,
};
pub use crate::diagnostic::Severity;
use crate::{
    codes,
    fixes::{FixSite, TextFix},
    model::Src,
};

/// The kind of a finding.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum FindingKind {
    Preprocessing(Preprocessing),
    Parsing(Box<SyntaxError>),
    FileProblem(FileProblem),
    NameProblem(NameProblem),
    ValueProblem(ValueProblem),
    DeclarationProblem(DeclarationProblem),
    CodelProblem(CodelProblem),
    LintWarning(LintWarning),
}

macro_rules! families {
    ($($Family:ident),*) => {
        impl FindingKind {
            /// The stable identifier, as shown to users.
            pub fn code(&self) -> &'static str {
                match self {
                    FindingKind::Preprocessing(finding) => finding.code(),
                    FindingKind::Parsing(finding) => finding.code(),
                    $( FindingKind::$Family(finding) => finding.code() ),*
                }
            }

            /// The message of the kind alone.
            fn words(&self) -> Wording {
                match self {
                    FindingKind::Preprocessing(finding) => finding.wording(),
                    FindingKind::Parsing(finding) => finding.wording(),
                    $( FindingKind::$Family(finding) => finding.wording() ),*
                }
            }

            /// The fixes, the best first, made from the text around.
            pub(crate) fn fixes(&self, here: &FixSite<'_>) -> Vec<TextFix> {
                match self {
                    FindingKind::Preprocessing(finding) => syntax::preprocessing(finding, here),
                    FindingKind::Parsing(finding) => syntax::parsing(finding, here),
                    $( FindingKind::$Family(finding) => finding.fixes(here) ),*
                }
            }
        }

        $( impl From<$Family> for FindingKind {
            fn from(finding: $Family) -> FindingKind {
                FindingKind::$Family(finding)
            }
        } )*
    };
}

families!(FileProblem, NameProblem, ValueProblem, DeclarationProblem, CodelProblem, LintWarning);

impl FindingKind {
    /// The message: the error, then the advice.
    pub fn wording(&self, near: Option<&Near>, because: Option<&str>) -> Wording {
        let mut wording = self.words();
        let near = near.map(|near| format!("did you mean `{}`?", near.name));
        for advice in near.as_deref().into_iter().chain(because) {
            wording.advise(advice);
        }
        wording
    }

    /// The message of the reference compiler: the error, without quotes and without advice, since tools
    /// compare these lines.
    pub(crate) fn reference(&self) -> String {
        match self {
            FindingKind::Preprocessing(preprocessing) => preprocessing.reference(),
            FindingKind::NameProblem(NameProblem::Clash { name, what }) => {
                format!("declaration of '{name}' clashes with existing {}", what.noun)
            }
            _ => self.words().plain(),
        }
    }

    /// Returns true if an unknown name may be declared in a missing package or file: a type or constant, or
    /// an interface. A name close to a known one is considered misspelt.
    pub(crate) fn may_be_in_a_package(&self, is_near: bool) -> bool {
        match self {
            FindingKind::NameProblem(problem) => problem.may_be_in_a_package(is_near),
            _ => false,
        }
    }

    /// The severity unless configured otherwise.
    pub fn severity(&self) -> Severity {
        let code = self.code();
        let severity = dotgen_syntax::codes::find(code)
            .map(|code| code.severity)
            .or_else(|| codes::find(code).map(|code| code.severity));
        debug_assert!(severity.is_some(), "{code} is not in the table of codes");
        severity.unwrap_or(Severity::Error)
    }
}

/// A known name close to an unknown one.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Near {
    /// The misspelt token.
    pub at: Src,
    /// The intended name, as shown.
    pub name: SmolStr,
    /// The replacement of the token.
    pub text: SmolStr,
    /// True if no other name is close.
    pub plain: bool,
}

impl Near {
    /// A name that replaces the token as it is.
    pub fn new(at: Src, name: &str) -> Near {
        let name = SmolStr::new(name);
        Near { at, text: name.clone(), name, plain: false }
    }
}

/// A finding at a node of the item tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The kind.
    pub kind: FindingKind,
    /// The severity.
    pub severity: Severity,
    /// The place.
    pub at: Src,
    /// Related places, each with its role.
    pub related: Vec<(Src, Role)>,
    /// The probable intention.
    pub near: Option<Near>,
    /// The place at which the reference compiler reports it, if different.
    pub compiler_at: Option<Src>,
    /// The reason why an error in another text is reported here.
    pub because: Option<&'static str>,
}

impl Finding {
    /// A finding with the severity of its code.
    pub fn new(kind: impl Into<FindingKind>, at: Src) -> Finding {
        let kind = kind.into();
        Finding {
            severity: kind.severity(),
            kind,
            at,
            related: Vec::new(),
            near: None,
            compiler_at: None,
            because: None,
        }
    }

    /// Adds a related place.
    pub fn related(mut self, at: Src, role: Role) -> Finding {
        self.related.push((at, role));
        self
    }

    /// Adds the place at which the reference compiler reports it.
    pub(crate) fn compiler_at(mut self, at: Src) -> Finding {
        self.compiler_at = Some(at);
        self
    }

    /// Adds the probable intention.
    pub fn near(mut self, near: Option<Near>) -> Finding {
        self.near = near;
        self
    }

    /// The stable identifier, as shown to users.
    pub fn code(&self) -> &'static str {
        self.kind.code()
    }
}
