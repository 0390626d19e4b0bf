//! Names, paths, numbers, times, and words to choose from.

use super::Parser;
use crate::diagnostic::Diagnostic;
use crate::scn::ast::{Interval, Path, Spanned, Unit};
use crate::scn::lexer::Kind;

impl Parser<'_> {
    pub(super) fn name(&mut self, what: &str) -> Option<Spanned<String>> {
        let range = self.range();
        self.expect(Kind::Name, what)?;
        Some(Spanned { value: self.text[range.clone()].to_owned(), range })
    }

    pub(super) fn path(&mut self) -> Option<Path> {
        let mut path = Path { names: vec![self.name("a name such as component.task")?] };
        while self.eat(Kind::Dot) {
            path.names.push(self.name("a name after `.`")?);
        }
        Some(path)
    }

    pub(super) fn optional_path(&mut self) -> Option<Option<Path>> {
        if self.peek() == Some(Kind::Name) { self.path().map(Some) } else { Some(None) }
    }

    pub(super) fn path_or_all(&mut self) -> Option<Option<Path>> {
        if self.eat(Kind::Star) { Some(None) } else { self.path().map(Some) }
    }

    pub(super) fn number(&mut self) -> Option<u64> {
        let range = self.range();
        self.expect(Kind::Number, "a whole number")?;
        if let Ok(number) = self.text[range.clone()].parse() {
            Some(number)
        } else {
            let message = "this number is too large".to_owned();
            self.errors.push(Diagnostic::error("scn-number", range, message));
            None
        }
    }

    pub(super) fn small(&mut self) -> Option<u32> {
        let range = self.range();
        let number = self.number()?;
        if number > 255 {
            let message = "this number is too large; at most 255".to_owned();
            self.errors.push(Diagnostic::error("scn-number", range, message));
            return None;
        }
        Some(number as u32)
    }

    pub(super) fn interval(&mut self) -> Option<Interval> {
        if !self.eat(Kind::OpenBracket) {
            let exact = self.number()?;
            return Some(Interval { lower: exact, upper: Some(exact) });
        }
        let start = self.range().start;
        let lower = self.number()?;
        self.expect(Kind::Comma, "`,`")?;
        let upper = if self.eat(Kind::Star) { None } else { Some(self.number()?) };
        let range = start..self.end();
        self.expect(Kind::CloseBracket, "`]`")?;
        if upper.is_some_and(|upper| upper < lower) {
            let message = "the bounds are in the wrong order".to_owned();
            self.errors.push(Diagnostic::error("scn-interval", range, message));
            return None;
        }
        Some(Interval { lower, upper })
    }

    pub(super) fn unit(&mut self) -> Option<Unit> {
        self.choose(&[("s", Unit::Seconds), ("ms", Unit::Milliseconds), ("us", Unit::Microseconds)])
    }

    pub(super) fn choose<T: Copy>(&mut self, of: &[(&str, T)]) -> Option<T> {
        if let Some(&(_, value)) = of.iter().find(|(word, _)| *word == self.word()) {
            self.at += 1;
            return Some(value);
        }
        let words: Vec<&str> = of.iter().map(|(word, _)| *word).collect();
        self.expected_word(&words);
        None
    }
}
