//! Findings: errors and warnings as data, with their messages.
//!
//! A family of findings is an enum, with one variant for each possible error and the details of the error in
//! its fields. [`findings`](crate::findings) declares it together with the code and the wording of each
//! variant, so that all messages about a finding are in one place. Messages are made from the data when a
//! finding is shown; nothing parses them.

use std::fmt;

/// A message. Code can show and extend the text, and compare whole messages; it has no access to the words,
/// so that nothing depends on them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Wording {
    text: Box<str>,
    /// The length of the error itself; if the reference compiler reports it too, the words of that compiler.
    /// The rest is advice on how to correct it, or the reason for it.
    what: u32,
}

impl Wording {
    /// The error, with advice or a reason.
    pub fn new(what: impl Into<String>, advice: Option<String>) -> Wording {
        let text = what.into().into_boxed_str();
        let mut wording = Wording { what: text.len() as u32, text };
        if let Some(advice) = advice {
            wording.advise(&advice);
        }
        wording
    }

    /// Appends advice.
    pub fn advise(&mut self, more: &str) {
        self.text = format!("{}; {more}", self.text).into();
    }

    /// Appends a text to the last sentence.
    pub(crate) fn append(&mut self, text: &str) {
        let has_advice = self.text.len() > self.what as usize;
        self.text = format!("{}{text}", self.text).into();
        if !has_advice {
            self.what = self.text.len() as u32;
        }
    }

    /// The error without advice and without the marks of names.
    pub fn plain(&self) -> String {
        unmarked(&self.text[..self.what as usize])
    }

    /// The error and the advice, without the marks of names.
    pub(crate) fn plain_with_advice(&self) -> String {
        unmarked(&self.text)
    }
}

/// Removes the marks of names.
fn unmarked(text: &str) -> String {
    text.replace('`', "")
}

impl<T: Into<String>> From<T> for Wording {
    fn from(what: T) -> Wording {
        Wording::new(what, None)
    }
}

impl serde::Serialize for Wording {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text)
    }
}

impl fmt::Display for Wording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
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
                    $( Self::$Variant $({ $($field),* })? => $crate::finding::Wording::new(
                        format!($what),
                        [$(format!($advice))?].into_iter().next(),
                    ) ),*
                }
            }
        }
    };
}

pub mod parsing;
pub mod preprocessing;
