//! Tokens of the scenario language. Every byte belongs to a token.

use std::ops::Range;

use logos::Logos;

/// Kinds of token.
#[derive(Logos, Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Blanks and line ends.
    #[regex(r"[ \t\r\n\x0c\u{feff}]+")]
    Space,
    /// `// …`
    #[regex(r"//[^\n]*", allow_greedy = true)]
    LineComment,
    /// `/* … */`, or up to the end of the file.
    #[regex(r"/\*([^*]|\*+[^*/])*\*+/")]
    BlockComment,
    /// A `/*` that is never closed.
    #[token("/*", unclosed)]
    UnclosedComment,
    /// Names and keywords; `no-overdue` is one.
    #[regex(r"[A-Za-z_][A-Za-z0-9_]*")]
    #[token("no-overdue")]
    Name,
    #[regex(r"[0-9]+")]
    Number,
    /// A number with a sign or a fraction.
    #[regex(r"-[0-9]+|-?[0-9]+\.[0-9]+([eE][+-]?[0-9]+)?")]
    Real,
    /// `"…"` on one line.
    #[regex(r#""[^"\n]*""#)]
    Text,
    /// A string without end.
    #[regex(r#""[^"\n]*"#)]
    UnclosedText,
    /// `=>`
    #[token("=>")]
    Implies,
    /// `->`
    #[token("->")]
    Arrow,
    /// `<=`
    #[token("<=")]
    AtMost,
    /// `>=`
    #[token(">=")]
    AtLeast,
    /// `<`
    #[token("<")]
    Below,
    /// `>`
    #[token(">")]
    Above,
    /// `==`
    #[token("==")]
    Equal,
    /// `!=`
    #[token("!=")]
    Unequal,
    #[doc = "`{`"]
    #[token("{")]
    OpenBrace,
    #[doc = "`}`"]
    #[token("}")]
    CloseBrace,
    #[doc = "`[`"]
    #[token("[")]
    OpenBracket,
    #[doc = "`]`"]
    #[token("]")]
    CloseBracket,
    #[doc = "`(`"]
    #[token("(")]
    OpenParen,
    #[doc = "`)`"]
    #[token(")")]
    CloseParen,
    #[doc = "`;`"]
    #[token(";")]
    Semicolon,
    #[doc = "`:`"]
    #[token(":")]
    Colon,
    #[doc = "`,`"]
    #[token(",")]
    Comma,
    #[doc = "`.`"]
    #[token(".")]
    Dot,
    #[doc = "`*`"]
    #[token("*")]
    Star,
    /// Any other character.
    Unknown,
}

fn unclosed(lex: &mut logos::Lexer<Kind>) {
    lex.bump(lex.remainder().len());
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token {
    pub kind: Kind,
    /// Range of bytes.
    pub range: Range<usize>,
}

impl Kind {
    /// Returns true for blanks and comments.
    pub fn is_trivia(self) -> bool {
        matches!(self, Kind::Space | Kind::LineComment | Kind::BlockComment | Kind::UnclosedComment)
    }
}

/// Splits a scenario into tokens.
pub fn lex(text: &str) -> Vec<Token> {
    Kind::lexer(text)
        .spanned()
        .map(|(kind, range)| Token { kind: kind.unwrap_or(Kind::Unknown), range })
        .collect()
}
