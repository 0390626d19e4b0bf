//! Definitions of macros: their parameters and bodies.

use smol_str::SmolStr;

use super::MacroSite;
use crate::{
    kind::SyntaxKind::{self, SPLICE},
    lexer::{RawTokens, is_trivia, lex},
};

/// A macro definition.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Macro {
    pub name: SmolStr,
    /// The form.
    pub kind: MacroKind,
    /// The replacement.
    pub(crate) body: Vec<BodyToken>,
    /// The directive that defines it.
    pub site: MacroSite,
}

/// The forms of a macro.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum MacroKind {
    /// A name that stands for its body.
    Object,
    /// Called with arguments.
    Function {
        /// Names of the parameters, `...` excluded.
        params: Vec<SmolStr>,
        /// Takes any number of further arguments as `__VA_ARGS__`.
        variadic: bool,
    },
    /// `__FILE__`
    File,
    /// `__LINE__`
    Line,
}

impl Macro {
    /// An object-like macro that comes from no file.
    pub(super) fn from_text(name: &str, body: &str) -> Macro {
        let raw = lex(body);
        Macro {
            name: name.into(),
            kind: MacroKind::Object,
            body: (0..raw.len()).map(|i| BodyToken::plain(body, &raw, i as u32)).collect(),
            site: MacroSite { file: None, ordinal: 0 },
        }
    }

    /// Returns true if a redefinition is the same: blanks do not count (language reference, 2.4).
    pub(crate) fn same_meaning(&self, other: &Macro) -> bool {
        self.kind == other.kind
            && self.body.len() == other.body.len()
            && std::iter::zip(&self.body, &other.body)
                .all(|(a, b)| a.kind == b.kind && a.text == b.text && a.role == b.role)
    }

    /// The definition without its name, as written in source text.
    pub fn definition_text(&self) -> String {
        let mut text = String::new();
        if let MacroKind::Function { params, variadic } = &self.kind {
            let mut names: Vec<&str> = params.iter().map(SmolStr::as_str).collect();
            if *variadic {
                names.push("...");
            }
            text = format!("({})", names.join(", "));
        }
        for (i, token) in self.body.iter().enumerate() {
            if i == 0 && !text.is_empty() || i > 0 && token.spaced {
                text.push(' ');
            }
            if matches!(token.role, Role::Stringize(_)) {
                text.push('#');
            }
            text.push_str(&token.text);
        }
        text
    }
}

/// One token of the body of a macro.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct BodyToken {
    pub(crate) kind: SyntaxKind,
    /// Without splices.
    pub(crate) text: SmolStr,
    /// A blank stands before it in the body.
    pub(crate) spaced: bool,
    pub(crate) role: Role,
}

/// The role of a body token when the macro is expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Role {
    /// Copied.
    Plain,
    /// Replaced by the argument of this parameter; `__VA_ARGS__` comes after the named ones.
    Param(u32),
    /// Replaced by a string of the argument of this parameter.
    Stringize(u32),
    /// Joins its neighbours.
    Paste,
}

impl BodyToken {
    /// A token that is copied.
    pub(crate) fn plain(text: &str, raw: &RawTokens, i: u32) -> BodyToken {
        let i = i as usize;
        BodyToken {
            kind: raw.kind(i),
            text: SmolStr::new(raw.clean_text(text, i)),
            spaced: spaced(raw, i),
            role: Role::Plain,
        }
    }

    pub(crate) fn is_paste(&self) -> bool {
        self.role == Role::Paste
    }
}

/// Returns true if there is a blank before the token `i`.
pub(crate) fn spaced(raw: &RawTokens, i: usize) -> bool {
    let before = (0..i).rev().map(|i| raw.kind(i)).find(|&kind| kind != SPLICE);
    before.is_none_or(is_trivia)
}
