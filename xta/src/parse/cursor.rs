//! The position of the parser in its tokens.

use std::collections::HashSet;

use crate::ast::Name;
use crate::error::{Res, fail};
use crate::lexer::{Kind, Token, tokens};

/// Deepest nesting of expressions and statements.
pub(crate) const DEEPEST: u16 = 128;

pub(super) struct Cursor<'a> {
    tokens: Vec<Token<'a>>,
    next: usize,
    depth: u16,
    /// Names of `typedef`s so far, which decide between a declaration and an expression.
    pub(super) types: HashSet<String>,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(text: &'a str) -> Res<Cursor<'a>> {
        Ok(Cursor { tokens: tokens(text)?, next: 0, depth: 0, types: HashSet::new() })
    }

    /// The token `ahead` tokens after the next one. Beyond the end, the token of the end.
    pub(super) fn ahead(&self, ahead: usize) -> Token<'a> {
        let last = self.tokens.len() - 1;
        self.tokens[(self.next + ahead).min(last)]
    }

    pub(super) fn peek(&self) -> Token<'a> {
        self.ahead(0)
    }

    pub(super) fn at(&self) -> u32 {
        self.peek().at
    }

    pub(super) fn bump(&mut self) -> Token<'a> {
        let token = self.peek();
        self.next += 1;
        token
    }

    pub(super) fn is(&self, text: &str) -> bool {
        let token = self.peek();
        matches!(token.kind, Kind::Word | Kind::Symbol) && token.text == text
    }

    pub(super) fn eat(&mut self, text: &str) -> bool {
        let found = self.is(text);
        self.next += usize::from(found);
        found
    }

    pub(super) fn expect(&mut self, text: &str) -> Res<u32> {
        let at = self.at();
        if self.eat(text) { Ok(at) } else { self.unexpected(&format!("`{text}`")) }
    }

    /// The error that something else was expected here.
    pub(super) fn unexpected<T>(&self, expected: &str) -> Res<T> {
        let token = self.peek();
        let found = match token.kind {
            Kind::End => "the end of the text".to_owned(),
            _ => format!("`{}`", token.text),
        };
        fail(token.at, format!("expected {expected}, found {found}"))
    }

    pub(super) fn name(&mut self) -> Res<Name> {
        let token = self.peek();
        if token.kind != Kind::Word || keyword(token.text) {
            return self.unexpected("a name");
        }
        self.next += 1;
        Ok(Name { at: token.at, text: token.text.to_owned() })
    }

    /// Names separated by commas, up to `;`.
    pub(super) fn names(&mut self) -> Res<Vec<Name>> {
        let mut out = vec![self.name()?];
        while self.eat(",") {
            out.push(self.name()?);
        }
        self.expect(";")?;
        Ok(out)
    }

    /// Runs a parser one level deeper.
    pub(super) fn nested<T>(&mut self, parse: impl FnOnce(&mut Self) -> Res<T>) -> Res<T> {
        if self.depth >= DEEPEST {
            return fail(self.at(), format!("nested more than {DEEPEST} levels deep"));
        }
        self.depth += 1;
        let out = parse(self);
        self.depth -= 1;
        out
    }
}

fn keyword(text: &str) -> bool {
    const KEYWORDS: [&str; 49] = [
        "const",
        "int",
        "bool",
        "clock",
        "chan",
        "void",
        "struct",
        "typedef",
        "urgent",
        "broadcast",
        "meta",
        "scalar",
        "double",
        "string",
        "hybrid",
        "process",
        "state",
        "commit",
        "branchpoint",
        "init",
        "trans",
        "select",
        "guard",
        "sync",
        "assign",
        "probability",
        "system",
        "priority",
        "default",
        "for",
        "while",
        "do",
        "if",
        "else",
        "return",
        "break",
        "continue",
        "switch",
        "case",
        "forall",
        "exists",
        "sum",
        "and",
        "or",
        "not",
        "imply",
        "true",
        "false",
        "deadlock",
    ];
    KEYWORDS.contains(&text)
}
