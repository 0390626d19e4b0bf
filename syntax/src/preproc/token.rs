//! Tokens of an expansion, and the operators `#` and `##` on them.

use smol_str::SmolStr;

use super::Origin;
use crate::{
    kind::SyntaxKind::{self, *},
    lexer::{is_trivia, lex},
};

/// A token on its way through expansion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) kind: SyntaxKind,
    /// Without splices.
    pub(crate) text: SmolStr,
    /// A blank stands before it.
    pub(crate) spaced: bool,
    pub(crate) origin: Origin,
    /// The name of a macro met in its own expansion: never expanded again.
    pub(crate) painted: bool,
}

/// The tokens of an argument as a string.
pub(crate) fn stringize(tokens: &[Token]) -> Token {
    let mut text = String::from("\"");
    for (i, token) in tokens.iter().enumerate() {
        if i > 0 && token.spaced {
            text.push(' ');
        }
        let quoted = matches!(token.kind, STRING | CHAR | OPEN_STRING);
        for char in token.text.chars() {
            if quoted && matches!(char, '"' | '\\') {
                text.push('\\');
            }
            text.push(char);
        }
    }
    text.push('"');
    Token {
        kind: STRING,
        text: text.into(),
        spaced: true,
        origin: Origin::Synthetic,
        painted: false,
    }
}

/// Joins two tokens. The result may again be several tokens; they then have no blank between them.
pub(crate) fn paste(lhs: &Token, rhs: &Token, out: &mut Vec<Token>) {
    let joined = format!("{}{}", lhs.text, rhs.text);
    let raw = lex(&joined);
    for i in (0..raw.len()).filter(|&i| !is_trivia(raw.kind(i))) {
        out.push(Token {
            kind: raw.kind(i),
            text: raw.text(&joined, i).into(),
            spaced: i == 0 && lhs.spaced,
            origin: Origin::Synthetic,
            painted: false,
        });
    }
}
