//! Checks of patterns of predicates in time.

use super::{CHECKS, Parser};
use crate::diagnostic::Diagnostic;
use crate::scn::ast::{
    Bound, Check, CheckKind, Interval, MonitorKind, Pattern, PatternForm, Pred, ScopeWord, Unit,
};
use crate::scn::lexer::Kind;

/// Claims of scopes.
const CLAIMS: &[(&str, ScopeWord)] = &[
    ("never", ScopeWord::Never),
    ("always", ScopeWord::Always),
    ("eventually", ScopeWord::Eventually),
];

impl Parser<'_> {
    /// Returns true if the check is `P precedes Q`, the only one that begins with a predicate.
    pub(super) fn is_precedence(&self) -> bool {
        let rest = self.tokens.get(self.at..).unwrap_or_default().iter();
        let mut words = rest
            .take_while(|token| token.kind != Kind::Semicolon)
            .map(|token| &self.text[token.range.clone()])
            .take_while(|word| *word != "check");
        !CHECKS.contains(&self.word()) && words.any(|word| word == "precedes")
    }

    pub(super) fn precedence(&mut self) -> Option<CheckKind> {
        let p = self.pred()?;
        self.expect_word("precedes")?;
        let q = self.pred()?;
        Some(pattern(PatternForm::Precedes, MonitorKind::Precedes, vec![p, q], None))
    }

    /// Parses `in [5, 20] ms` after `within P => Q`. With both bounds, the check is of the upper one, and one
    /// of the lower bound is left to follow it.
    pub(super) fn between_times(
        &mut self,
        (p, q): (Pred, Pred),
        start: usize,
    ) -> Option<CheckKind> {
        self.expect_word("in")?;
        let Interval { lower, upper } = self.interval()?;
        let unit = self.unit()?;
        let predicates = vec![p.clone(), q.clone()];
        let time = Some((lower, unit));
        let least = pattern(PatternForm::Lower, MonitorKind::Absent, predicates, time);
        match upper {
            None if lower == 0 => self.no_claim(start),
            // Q need not come.
            None => Some(least),
            Some(upper) => {
                if lower > 0 {
                    let range = start..self.end();
                    self.lower.push(Check { name: None, subject: None, kind: least, range });
                }
                Some(CheckKind::Within(p, vec![q], Some((upper, unit))))
            }
        }
    }

    /// Parses a pattern after its first word.
    pub(super) fn pattern(&mut self, word: &str) -> Option<CheckKind> {
        match word {
            "absent" => {
                let q = self.pred()?;
                self.expect_word("after")?;
                let p = self.pred()?;
                self.expect_word("for")?;
                let time = self.time()?;
                let predicates = vec![p, q];
                Some(pattern(PatternForm::Absent, MonitorKind::Absent, predicates, Some(time)))
            }
            "lasts" => {
                let p = self.pred()?;
                let ends = Pred::Not(Box::new(p.clone()));
                if self.peek() == Some(Kind::AtMost) {
                    return Some(CheckKind::Within(p, vec![ends], self.bound()?));
                }
                self.expect(Kind::AtLeast, "`>=` or `<=`")?;
                let time = self.time()?;
                let predicates = vec![p, ends];
                Some(pattern(PatternForm::Lasts, MonitorKind::Absent, predicates, Some(time)))
            }
            "before" => {
                let p = self.pred()?;
                let (word, claimed) = self.claim(CLAIMS)?;
                let (kind, predicates) = match word {
                    ScopeWord::Eventually => (MonitorKind::Precedes, vec![claimed, p]),
                    _ => (MonitorKind::NeverBefore, vec![p, claimed]),
                };
                Some(pattern(PatternForm::Scope(word), kind, predicates, None))
            }
            "after" => {
                let p = self.pred()?;
                let until = if self.eat_word("until") { Some(self.pred()?) } else { None };
                // That something comes at all is `leadsto`.
                let (word, claimed) = self.claim(&CLAIMS[..2])?;
                let kind = match until {
                    Some(_) => MonitorKind::NeverUntil,
                    None => MonitorKind::NeverAfter,
                };
                let predicates = [Some(p), until, Some(claimed)].into_iter().flatten().collect();
                Some(pattern(PatternForm::Scope(word), kind, predicates, None))
            }
            _ => {
                let p = self.factor()?;
                self.expect_word("and")?;
                let q = self.factor()?;
                let (word, claimed) = self.claim(CLAIMS)?;
                let kind = match word {
                    ScopeWord::Eventually => MonitorKind::SomeBetween,
                    _ => MonitorKind::NeverBetween,
                };
                Some(pattern(PatternForm::Scope(word), kind, vec![p, q, claimed], None))
            }
        }
    }

    /// Parses what is claimed in a scope: the word, and the predicate that the monitor needs.
    fn claim(&mut self, words: &[(&str, ScopeWord)]) -> Option<(ScopeWord, Pred)> {
        let word = self.choose(words)?;
        let claimed = self.formula()?;
        Some(match word {
            ScopeWord::Always => (word, Pred::Not(Box::new(claimed))),
            ScopeWord::Never | ScopeWord::Eventually => (word, claimed),
        })
    }

    fn time(&mut self) -> Option<(u64, Unit)> {
        let start = self.range().start;
        let count = self.number()?;
        let unit = self.unit()?;
        if count == 0 { self.no_claim(start) } else { Some((count, unit)) }
    }

    /// Reports a time that every run keeps.
    fn no_claim<T>(&mut self, start: usize) -> Option<T> {
        let message = "this time claims nothing; give at least 1".to_owned();
        self.errors.push(Diagnostic::error("scn-interval", start..self.end(), message));
        None
    }

    fn expect_word(&mut self, word: &str) -> Option<()> {
        if self.eat_word(word) {
            return Some(());
        }
        self.expected_word(&[word]);
        None
    }
}

fn pattern(form: PatternForm, kind: MonitorKind, predicates: Vec<Pred>, time: Bound) -> CheckKind {
    CheckKind::Pattern(Pattern { form, kind, predicates, time })
}
