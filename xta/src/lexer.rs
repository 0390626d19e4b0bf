//! Text to tokens, without comments and blanks.

use logos::{Lexer, Logos};

use crate::error::{Res, fail};

/// Largest text that is read, in bytes.
pub(crate) const LARGEST_TEXT: usize = 16 << 20;

#[derive(Logos, Debug, Clone, Copy, PartialEq, Eq)]
#[logos(skip r"[ \t\r\n\f\u{feff}]+")]
#[logos(skip(r"//[^\n]*", allow_greedy = true))]
enum Raw {
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*")]
    Word,
    #[regex(r"[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?")]
    Number,
    #[regex(r#""[^"\n]*""#)]
    Text,
    #[token("/*", comment)]
    Comment,
    #[token("-->")]
    #[token("->")]
    #[token("-u->")]
    #[token(":=")]
    #[token("+=")]
    #[token("-=")]
    #[token("*=")]
    #[token("/=")]
    #[token("%=")]
    #[token("&=")]
    #[token("|=")]
    #[token("^=")]
    #[token("<<=")]
    #[token(">>=")]
    #[token("++")]
    #[token("--")]
    #[token("&&")]
    #[token("||")]
    #[token("==")]
    #[token("!=")]
    #[token("<=")]
    #[token(">=")]
    #[token("<<")]
    #[token(">>")]
    #[token("<?")]
    #[token(">?")]
    #[token("[]")]
    #[token("<>")]
    #[regex(r"[-+*/%&|^~!<>=?:;,.(){}'\[\]@#]")]
    Symbol,
}

/// Skips to the end of a block comment. Returns whether the end exists.
fn comment(lexer: &mut Lexer<'_, Raw>) -> bool {
    match lexer.remainder().find("*/") {
        Some(end) => {
            lexer.bump(end + 2);
            true
        }
        None => false,
    }
}

/// Kind of a token. Keywords are words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Word,
    Number,
    Text,
    Symbol,
    End,
}

/// A token with its spelling and the byte offset of its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Token<'a> {
    pub(crate) kind: Kind,
    pub(crate) text: &'a str,
    pub(crate) at: u32,
}

/// The tokens of a text, of which the last has the kind [`Kind::End`].
pub(crate) fn tokens(text: &str) -> Res<Vec<Token<'_>>> {
    if text.len() > LARGEST_TEXT {
        return fail(
            0,
            format!("text of {} bytes is too large: at most {LARGEST_TEXT}", text.len()),
        );
    }
    let mut out = Vec::new();
    for (raw, span) in Raw::lexer(text).spanned() {
        let (at, spelling) = (span.start as u32, &text[span.clone()]);
        let kind = match raw {
            Ok(Raw::Comment) => continue,
            Ok(Raw::Word) => Kind::Word,
            Ok(Raw::Number) => Kind::Number,
            Ok(Raw::Text) => Kind::Text,
            Ok(Raw::Symbol) => Kind::Symbol,
            Err(()) if spelling.starts_with("/*") => {
                return fail(at, "comment without an end: expected `*/`");
            }
            Err(()) => return fail(at, format!("unexpected character `{spelling}`")),
        };
        out.push(Token { kind, text: spelling, at });
    }
    out.push(Token { kind: Kind::End, text: "", at: text.len() as u32 });
    Ok(out)
}
