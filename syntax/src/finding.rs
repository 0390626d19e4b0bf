//! Findings: what is wrong, as data, and the words for it.
//!
//! A family of findings is an enum, one variant for each thing that can be wrong, with what it is about
//! in its fields. [`findings`](crate::findings) declares it together with the code and the wording of
//! each variant, so that one place has all that is ever said of it. Words are made from the data when a
//! finding is shown; nothing reads them back.

use std::fmt;

/// What is said of a finding.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Wording {
    /// What is wrong, and where the reference compiler says something: what it says.
    pub what: String,
    /// What to do about it, or why it is so.
    pub advice: Option<String>,
}

impl fmt::Display for Wording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        match &self.advice {
            Some(advice) => write!(f, "; {advice}"),
            None => Ok(()),
        }
    }
}

/// Declares a family of findings: an enum with `code` and `wording`.
///
/// Each variant is written `"code" Variant { field: Type } => "what is wrong", "what to do";`. The texts
/// are format strings over the fields, which are shown by their `Display`; the advice may be left out.
#[macro_export]
macro_rules! findings {
    (
        $(#[$meta:meta])*
        pub enum $Family:ident {
            $(
                $(#[$doc:meta])*
                $code:literal $Variant:ident $({ $($field:ident : $ty:ty),* $(,)? })?
                    => $what:literal $(, $advice:literal)?;
            )*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, Eq, Hash)]
        #[allow(missing_docs, reason = "code and wording say what variants and fields are")]
        pub enum $Family {
            $( $(#[$doc])* $Variant $({ $($field: $ty),* })? ),*
        }

        impl $Family {
            /// The stable identifier under which users know it.
            pub fn code(&self) -> &'static str {
                match self {
                    $( Self::$Variant { .. } => $code ),*
                }
            }

            /// The words for it.
            #[allow(unused_variables, reason = "not every field is part of the text")]
            pub fn wording(&self) -> $crate::finding::Wording {
                match self {
                    $( Self::$Variant $({ $($field),* })? => $crate::finding::Wording {
                        what: format!($what),
                        advice: [$(format!($advice))?].into_iter().next(),
                    } ),*
                }
            }
        }
    };
}

pub mod parsing;
pub mod preprocessing;
