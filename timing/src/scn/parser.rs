//! Recursive-descent parser of scenarios. An item with a syntax error is skipped up to its `;` or `}` and
//! reported once.

mod checks;
mod items;
mod measures;
mod patterns;
mod steps;
mod tokens;
mod values;

use super::ast::{Check, Scenario};
use super::lexer::{Kind, Token, lex};
use crate::diagnostic::Diagnostic;

pub(super) use checks::CHECKS;
pub(super) use items::ITEMS;
pub(super) use measures::TRIGGERS;
pub(super) use steps::STEPS;

/// A parsed scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parse {
    /// Syntax tree of the valid items.
    pub scenario: Scenario,
    /// Syntax errors.
    pub errors: Vec<Diagnostic>,
}

/// Parses a scenario.
pub fn parse(text: &str) -> Parse {
    let mut parser = Parser::new(text);
    let scenario = parser.scenario();
    Parse { scenario, errors: parser.errors }
}

/// Parses a check: the text after `check`, without the `;`. An interval of time is two checks.
///
/// # Errors
///
/// Returns the first syntax error.
pub fn parse_check(text: &str) -> Result<Vec<Check>, Diagnostic> {
    let mut parser = Parser::new(text);
    let check = parser.check_body(0);
    if parser.errors.is_empty() && parser.peek().is_some() {
        parser.expected("the end of the check");
    }
    match (parser.errors.into_iter().next(), check) {
        (None, Some(check)) => Ok([vec![check], parser.lower].concat()),
        (Some(error), _) => Err(error),
        (None, None) => {
            Err(Diagnostic::error("scn-syntax", 0..text.len(), "not a check".to_owned()))
        }
    }
}

/// Greatest nesting depth. Deeper nesting is refused, because it could exhaust the stack.
const DEPTH: u32 = 100;

struct Parser<'t> {
    text: &'t str,
    tokens: Vec<Token>,
    at: usize,
    errors: Vec<Diagnostic>,
    depth: u32,
    /// Checks of the lower bounds of intervals of time, each of which belongs to the check before it.
    lower: Vec<Check>,
}

impl<'t> Parser<'t> {
    fn new(text: &'t str) -> Self {
        let mut errors = Vec::new();
        let tokens = lex(text);
        for token in &tokens {
            let message = match token.kind {
                Kind::UnclosedComment => "this comment is never closed; add `*/`",
                Kind::UnclosedText => "this string has no end; add `\"` on the same line",
                Kind::Unknown => "this character means nothing here; remove it",
                _ => continue,
            };
            errors.push(Diagnostic::error("scn-lexical", token.range.clone(), message.to_owned()));
        }
        errors.truncate(50);
        let tokens = tokens
            .into_iter()
            .filter(|token| !token.kind.is_trivia() && token.kind != Kind::Unknown)
            .collect();
        Parser { text, tokens, at: 0, errors, depth: 0, lower: Vec::new() }
    }

    fn nested<T>(&mut self, body: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        if self.depth == DEPTH {
            let message = "nested too deeply; write it simpler".to_owned();
            self.errors.push(Diagnostic::error("scn-nesting", self.range(), message));
            return None;
        }
        self.depth += 1;
        let out = body(self);
        self.depth -= 1;
        out
    }
}
