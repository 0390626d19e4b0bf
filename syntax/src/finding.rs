//! Findings: errors and warnings as data, with their messages.
//!
//! A family of findings is an enum, with one variant for each possible error and the details of the error in
//! its fields. [`findings`](crate::findings) declares it together with the code and the wording of each
//! variant, so that all messages about a finding are in one place. Messages are made from the data when a
//! finding is shown; nothing parses them.

use std::fmt;

/// The message of a finding.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Wording {
    /// The error itself; if the reference compiler reports it too, the words of that compiler.
    pub what: String,
    /// Advice on how to correct it, or the reason for it.
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
        pub enum $Family {
            $( $(#[$doc])* $Variant $({ $($field: $ty),* })? ),*
        }

        impl $Family {
            /// The stable identifier of the finding, as shown to users.
            pub fn code(&self) -> &'static str {
                match self {
                    $( Self::$Variant { .. } => $code ),*
                }
            }

            /// The message of the finding.
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
