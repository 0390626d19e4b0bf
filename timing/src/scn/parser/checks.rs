//! Checks and predicates.

use super::Parser;
use crate::scn::ast::{
    Bound, ChainKind, ChainPath, Check, CheckKind, Comparison, Operator, Path, Pred, Spanned,
};
use crate::scn::lexer::Kind;

/// Words that begin a check.
pub(in crate::scn) const CHECKS: &[&str] = &[
    "schedulable",
    "no-overdue",
    "response",
    "within",
    "reaction",
    "age",
    "leadsto",
    "eventually",
    "always",
    "never",
    "reachable",
    "deadlock",
    "absent",
    "lasts",
    "before",
    "after",
    "between",
];

/// Words that may follow a predicate.
const CONTINUES: &[&str] = &[
    "and",
    "or",
    "then",
    "in",
    "after",
    "for",
    "until",
    "precedes",
    "never",
    "always",
    "eventually",
];

impl Parser<'_> {
    pub(super) fn check_body(&mut self, start: usize) -> Option<Check> {
        let mut name = None;
        if self.tokens.get(self.at + 1).is_some_and(|token| token.kind == Kind::Colon) {
            name = Some(self.name("the name of the check")?);
            self.at += 1;
        }
        if self.is_precedence() {
            let kind = self.precedence()?;
            return Some(Check { name, subject: None, kind, range: start..self.end() });
        }
        let word = self.word();
        if !CHECKS.contains(&word) {
            self.expected_word(CHECKS);
            return None;
        }
        self.at += 1;
        let kind = match word {
            "schedulable" => CheckKind::Schedulable(self.path_or_all()?),
            "no-overdue" => CheckKind::NoOverdue(self.path_or_all()?),
            "response" => {
                let path = self.path_or_all()?;
                CheckKind::Response(path, self.bound()?)
            }
            "within" => {
                let (p, q) = self.implication()?;
                if self.word() == "in" {
                    self.between_times((p, q), start)?
                } else {
                    let mut responses = vec![q];
                    while self.eat_word("then") {
                        responses.push(self.pred()?);
                    }
                    CheckKind::Within(p, responses, self.bound()?)
                }
            }
            "absent" | "lasts" | "before" | "after" | "between" => self.pattern(word)?,
            "reaction" => CheckKind::Chain(ChainKind::Reaction, self.chain()?, self.bound()?),
            "age" => CheckKind::Chain(ChainKind::Age, self.chain()?, self.bound()?),
            "leadsto" => {
                let (p, q) = self.implication()?;
                CheckKind::LeadsTo(p, q)
            }
            "eventually" => CheckKind::Eventually(self.formula()?),
            "always" => CheckKind::Always(self.formula()?),
            "never" => CheckKind::Always(Pred::Not(Box::new(self.formula()?))),
            "deadlock" => CheckKind::Deadlock,
            _ => CheckKind::Reachable(self.formula()?),
        };
        for lower in &mut self.lower {
            lower.name.clone_from(&name);
        }
        Some(Check { name, subject: None, kind, range: start..self.end() })
    }

    fn chain(&mut self) -> Option<ChainPath> {
        let from = self.path()?;
        self.expect(Kind::Arrow, "`->`")?;
        let to = self.path()?;
        let mut via = Vec::new();
        if self.eat_word("via") {
            via.push(self.path()?);
            while self.eat(Kind::Comma) {
                via.push(self.path()?);
            }
        }
        Some(ChainPath { from, to, via })
    }

    fn implication(&mut self) -> Option<(Pred, Pred)> {
        let p = self.pred()?;
        self.expect(Kind::Implies, "`=>`")?;
        Some((p, self.pred()?))
    }

    pub(super) fn bound(&mut self) -> Option<Bound> {
        if !self.eat(Kind::AtMost) {
            return Some(None);
        }
        let count = self.number()?;
        Some(Some((count, self.unit()?)))
    }

    /// A predicate in which `P => Q` stands for `not P or Q`. `=>` binds weaker than `or`, to the right.
    pub(super) fn formula(&mut self) -> Option<Pred> {
        self.nested(|parser| {
            let left = parser.pred()?;
            if !parser.eat(Kind::Implies) {
                return Some(left);
            }
            let not = Pred::Not(Box::new(left));
            Some(Pred::Or(Box::new(not), Box::new(parser.formula()?)))
        })
    }

    pub(super) fn pred(&mut self) -> Option<Pred> {
        let mut left = self.conjunction()?;
        while self.eat_word("or") {
            left = Pred::Or(Box::new(left), Box::new(self.conjunction()?));
        }
        Some(left)
    }

    fn conjunction(&mut self) -> Option<Pred> {
        let mut left = self.factor()?;
        while self.eat_word("and") {
            left = Pred::And(Box::new(left), Box::new(self.factor()?));
        }
        Some(left)
    }

    pub(super) fn factor(&mut self) -> Option<Pred> {
        self.nested(|parser| {
            if parser.eat_word("not") {
                return Some(Pred::Not(Box::new(parser.factor()?)));
            }
            if parser.eat_word("leave") {
                return Some(Pred::Leave(parser.path()?));
            }
            if parser.eat(Kind::OpenParen) {
                let pred = parser.formula()?;
                parser.expect(Kind::CloseParen, "`)`")?;
                return Some(pred);
            }
            let path = parser.path()?;
            match parser.operator() {
                Some(operator) => parser.comparison(path, operator),
                None => Some(Pred::Atom(path)),
            }
        })
    }

    /// Returns the operator of a comparison of data at this place. In `P <= 50 ms` the operator limits a
    /// time.
    fn operator(&self) -> Option<Operator> {
        let operator = match self.peek()? {
            Kind::Below => Operator::Below,
            Kind::AtMost => Operator::AtMost,
            Kind::Above => Operator::Above,
            Kind::AtLeast => Operator::AtLeast,
            Kind::Equal => Operator::Equal,
            Kind::Unequal => Operator::Unequal,
            _ => return None,
        };
        let mut rest = self.tokens.get(self.at + 1..).unwrap_or_default().iter();
        let is_limit = match rest.next().map(|token| token.kind) {
            Some(Kind::Number) => rest.next().is_some_and(|token| {
                token.kind == Kind::Name && !CONTINUES.contains(&&self.text[token.range.clone()])
            }),
            Some(Kind::Name | Kind::Real) => false,
            _ => true,
        };
        let can_limit = matches!(operator, Operator::AtMost | Operator::AtLeast);
        (!(can_limit && is_limit)).then_some(operator)
    }

    fn comparison(&mut self, path: Path, operator: Operator) -> Option<Pred> {
        self.at += 1;
        let range = self.range();
        if !matches!(self.peek(), Some(Kind::Number | Kind::Real | Kind::Name)) {
            self.expected("a number, `true`, `false` or an enumerator");
            return None;
        }
        self.at += 1;
        let operand = Spanned { value: self.text[range.clone()].to_owned(), range };
        Some(Pred::Comparison(Comparison { path, operator, operand }))
    }
}
