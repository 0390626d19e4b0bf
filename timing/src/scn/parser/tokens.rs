//! Access to tokens, and recovery after an invalid item.

use std::ops::Range;

use dotgen_syntax::suggestion::nearest;

use super::{ITEMS, Parser};
use crate::diagnostic::Diagnostic;
use crate::scn::lexer::Kind;

impl<'t> Parser<'t> {
    pub(super) fn peek(&self) -> Option<Kind> {
        self.tokens.get(self.at).map(|token| token.kind)
    }

    pub(super) fn word(&self) -> &'t str {
        match self.tokens.get(self.at) {
            Some(token) if token.kind == Kind::Name => &self.text[token.range.clone()],
            _ => "",
        }
    }

    pub(super) fn range(&self) -> Range<usize> {
        match self.tokens.get(self.at) {
            Some(token) => token.range.clone(),
            None => self.text.len()..self.text.len(),
        }
    }

    /// Returns the end of the previous token.
    pub(super) fn end(&self) -> usize {
        self.at.checked_sub(1).map_or(0, |before| self.tokens[before].range.end)
    }

    pub(super) fn eat(&mut self, kind: Kind) -> bool {
        let found = self.peek() == Some(kind);
        self.at += usize::from(found);
        found
    }

    pub(super) fn eat_word(&mut self, word: &str) -> bool {
        let found = self.word() == word;
        self.at += usize::from(found);
        found
    }

    pub(super) fn expected(&mut self, what: &str) {
        let range = self.range();
        let found = match self.tokens.get(self.at) {
            Some(token) => format!("found `{}`", &self.text[token.range.clone()]),
            None => "the file ends here".to_owned(),
        };
        self.errors.push(Diagnostic::error(
            "scn-syntax",
            range,
            format!("expected {what}, {found}"),
        ));
    }

    /// Reports that one of some words is expected: the one that is nearest to the present word, or all.
    pub(super) fn expected_word(&mut self, words: &[&str]) {
        let word = self.word();
        match nearest(word, words.iter().copied()) {
            Some(near) => {
                let message = format!("`{word}` has no meaning here");
                let error = Diagnostic::error("scn-syntax", self.range(), message);
                self.errors.push(error.suggest_word(near));
            }
            None => self.expected(&match words {
                [one] => format!("`{one}`"),
                _ => format!("one of {}", words.join(", ")),
            }),
        }
    }

    pub(super) fn expect(&mut self, kind: Kind, what: &str) -> Option<()> {
        if self.eat(kind) {
            return Some(());
        }
        self.expected(what);
        None
    }

    /// Skips to the end of an invalid item.
    pub(super) fn recover(&mut self) {
        let mut depth = 0;
        while let Some(kind) = self.peek() {
            match kind {
                Kind::Semicolon if depth == 0 => {
                    self.at += 1;
                    return;
                }
                Kind::OpenBrace => depth += 1,
                Kind::CloseBrace if depth == 0 => return,
                Kind::CloseBrace => {
                    depth -= 1;
                    if depth == 0 {
                        self.at += 1;
                        return;
                    }
                }
                Kind::Name if depth == 0 && ITEMS.contains(&self.word()) => {
                    // The next item begins on a new line: the `;` is missing.
                    let before = &self.text[self.end()..self.range().start];
                    if before.contains('\n') {
                        return;
                    }
                }
                _ => {}
            }
            self.at += 1;
        }
    }
}
