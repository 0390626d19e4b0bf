//! Findings: what is wrong with a specification, as data.
//!
//! A [`Finding`] says what it is about ([`Kind`]), where, and which other places matter. Words, advice,
//! the wording of the reference compiler and fixes are made from the kind when a finding is brought to
//! its place in a file ([`crate::report`]); nothing looks into a text to find out what it is about.
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
    codels::Using, files::Reading, lints::Noticing, names::Naming, role::Role, services::Declaring,
    values::Valuing,
};
pub use crate::diagnostic::Severity;
use crate::{
    codes,
    fixes::{FixSite, TextFix},
    model::Src,
};

/// What a finding is about.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the families say what they are about")]
pub enum Kind {
    Preprocessing(Preprocessing),
    Parsing(Box<SyntaxError>),
    Reading(Reading),
    Naming(Naming),
    Valuing(Valuing),
    Declaring(Declaring),
    Using(Using),
    Noticing(Noticing),
}

macro_rules! families {
    ($($Family:ident),*) => {
        impl Kind {
            /// The stable identifier under which users know it.
            pub fn code(&self) -> &'static str {
                match self {
                    Kind::Preprocessing(it) => it.code(),
                    Kind::Parsing(it) => it.code(),
                    $( Kind::$Family(it) => it.code() ),*
                }
            }

            /// The words for it alone.
            fn words(&self) -> Wording {
                match self {
                    Kind::Preprocessing(it) => it.wording(),
                    Kind::Parsing(it) => it.wording(),
                    $( Kind::$Family(it) => it.wording() ),*
                }
            }

            /// What mends it, the best first, made from the text around.
            pub(crate) fn fixes(&self, here: &FixSite<'_>) -> Vec<TextFix> {
                match self {
                    Kind::Preprocessing(it) => syntax::preprocessing(it, here),
                    Kind::Parsing(it) => syntax::parsing(it, here),
                    $( Kind::$Family(it) => it.fixes(here) ),*
                }
            }
        }

        $( impl From<$Family> for Kind {
            fn from(it: $Family) -> Kind {
                Kind::$Family(it)
            }
        } )*
    };
}

families!(Reading, Naming, Valuing, Declaring, Using, Noticing);

impl Kind {
    /// What is wrong, and then what to do.
    pub fn wording(&self, near: Option<&Near>, because: Option<&str>) -> Wording {
        let mut wording = self.words();
        let near = near.map(|it| format!("did you mean `{}`?", it.name));
        let parts = [wording.advice, near, because.map(str::to_owned)];
        let advice: Vec<String> = parts.into_iter().flatten().collect();
        wording.advice = (!advice.is_empty()).then(|| advice.join("; "));
        wording
    }

    /// What the reference compiler says: what is wrong, without quotes. What to do about it is for people
    /// at an editor; tools compare these lines.
    pub(crate) fn reference(&self) -> String {
        match self {
            Kind::Preprocessing(it) => it.reference(),
            Kind::Naming(Naming::Clash { name, what }) => {
                let kind = what.trim_start_matches("an ").trim_start_matches("a ");
                format!("declaration of '{name}' clashes with existing {kind}")
            }
            _ => self.words().what.replace('`', ""),
        }
    }

    /// Whether what is not found may be declared in a package or file that is missing: a type or constant, or
    /// an interface. A name that comes close to one that is known is taken for that one misspelt.
    pub(crate) fn may_be_in_a_package(&self, is_near: bool) -> bool {
        match self {
            Kind::Naming(it) => it.may_be_in_a_package(is_near),
            _ => false,
        }
    }

    /// How bad it is unless configured otherwise.
    pub fn severity(&self) -> Severity {
        let code = self.code();
        let syntax = dotgen_syntax::codes::find(code).map(|it| match it.severity {
            dotgen_syntax::Severity::Error => Severity::Error,
            dotgen_syntax::Severity::Warning => Severity::Warning,
            dotgen_syntax::Severity::Hint => Severity::Hint,
        });
        let severity = syntax
            .or_else(|| codes::checks::find(code).map(|it| it.severity))
            .or_else(|| codes::lints::find(code).map(|it| it.severity));
        debug_assert!(severity.is_some(), "{code} is not in the table of codes");
        severity.unwrap_or(Severity::Error)
    }
}

/// A name that comes close to one that means nothing.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Near {
    /// The very token that is misspelt.
    pub at: Src,
    /// The name that was meant, as it is shown.
    pub name: SmolStr,
    /// What has to stand in the place of the token.
    pub text: SmolStr,
    /// Nothing else can be meant.
    pub plain: bool,
}

impl Near {
    /// A name that replaces the token as it is.
    pub fn new(at: Src, name: &str) -> Near {
        let name = SmolStr::new(name);
        Near {
            at,
            text: name.clone(),
            name,
            plain: false,
        }
    }
}

/// Something wrong, at a node of the item tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// What it is about.
    pub kind: Kind,
    /// How bad it is.
    pub severity: Severity,
    /// Where.
    pub at: Src,
    /// Other places that matter, each with what it is.
    pub related: Vec<(Src, Role)>,
    /// What was probably meant.
    pub near: Option<Near>,
    /// Where the reference compiler reports it, if that is another place.
    pub said_at: Option<Src>,
    /// Why something that stands elsewhere is reported here.
    pub because: Option<&'static str>,
}

impl Finding {
    /// A finding with the severity that the table of codes gives it.
    pub fn new(kind: impl Into<Kind>, at: Src) -> Finding {
        let kind = kind.into();
        Finding {
            severity: kind.severity(),
            kind,
            at,
            related: Vec::new(),
            near: None,
            said_at: None,
            because: None,
        }
    }

    /// Adds another place that matters.
    pub fn related(mut self, at: Src, role: Role) -> Finding {
        self.related.push((at, role));
        self
    }

    /// Adds where the reference compiler reports it.
    pub fn said_at(mut self, at: Src) -> Finding {
        self.said_at = Some(at);
        self
    }

    /// Adds what was probably meant.
    pub fn near(mut self, near: Option<Near>) -> Finding {
        self.near = near;
        self
    }

    /// The stable identifier under which users know it.
    pub fn code(&self) -> &'static str {
        self.kind.code()
    }
}
