//! Recursive descent over the tokens of a scenario. An item that cannot be understood is skipped up to
//! its `;` or `}` and reported once.

use std::ops::Range;

use super::Diagnostic;
use super::ast::{
    Bound, Check, CheckKind, Client, Durations, Interval, Item, Path, Policy, Pred, Scenario,
    Spanned, Step, StepKind, Unit,
};
use super::lexer::{Kind, Token, lex};

/// A parsed scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parse {
    /// What could be understood.
    pub scenario: Scenario,
    /// What could not.
    pub errors: Vec<Diagnostic>,
}

/// Parses a scenario.
pub fn parse(text: &str) -> Parse {
    let mut parser = Parser::new(text);
    let scenario = parser.scenario();
    Parse {
        scenario,
        errors: parser.errors,
    }
}

/// Parses a check as it stands after `check`, without the `;`.
pub fn parse_check(text: &str) -> Result<Check, Diagnostic> {
    let mut parser = Parser::new(text);
    let check = parser.check_body(0);
    if parser.errors.is_empty() && parser.peek().is_some() {
        parser.expected("the end of the check");
    }
    match (parser.errors.into_iter().next(), check) {
        (None, Some(check)) => Ok(check),
        (Some(error), _) => Err(error),
        (None, None) => Err(Diagnostic::error(
            "scn-syntax",
            0..text.len(),
            "not a check".to_owned(),
        )),
    }
}

/// Nesting deeper than this is refused instead of exhausting the stack.
const DEPTH: u32 = 100;

/// Repetitions larger than this are unrolled no more.
const REPEAT: u64 = 1000;

struct Parser<'t> {
    text: &'t str,
    tokens: Vec<Token>,
    at: usize,
    errors: Vec<Diagnostic>,
    depth: u32,
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
            errors.push(Diagnostic::error(
                "scn-lexical",
                token.range.clone(),
                message.to_owned(),
            ));
        }
        errors.truncate(50);
        let tokens = tokens
            .into_iter()
            .filter(|it| !it.kind.is_trivia() && it.kind != Kind::Unknown)
            .collect();
        Parser {
            text,
            tokens,
            at: 0,
            errors,
            depth: 0,
        }
    }

    // ---- Tokens ----------------------------------------------------------------------------

    fn peek(&self) -> Option<Kind> {
        self.tokens.get(self.at).map(|it| it.kind)
    }

    fn word(&self) -> &'t str {
        match self.tokens.get(self.at) {
            Some(it) if it.kind == Kind::Name => &self.text[it.range.clone()],
            _ => "",
        }
    }

    fn range(&self) -> Range<usize> {
        match self.tokens.get(self.at) {
            Some(it) => it.range.clone(),
            None => self.text.len()..self.text.len(),
        }
    }

    /// End of the token before.
    fn end(&self) -> usize {
        self.at
            .checked_sub(1)
            .map_or(0, |it| self.tokens[it].range.end)
    }

    fn eat(&mut self, kind: Kind) -> bool {
        let found = self.peek() == Some(kind);
        self.at += usize::from(found);
        found
    }

    fn eat_word(&mut self, word: &str) -> bool {
        let found = self.word() == word;
        self.at += usize::from(found);
        found
    }

    fn expected(&mut self, what: &str) {
        let range = self.range();
        let found = match self.tokens.get(self.at) {
            Some(it) => format!("found `{}`", &self.text[it.range.clone()]),
            None => "the file ends here".to_owned(),
        };
        self.errors.push(Diagnostic::error(
            "scn-syntax",
            range,
            format!("expected {what}, {found}"),
        ));
    }

    fn expect(&mut self, kind: Kind, what: &str) -> Option<()> {
        if self.eat(kind) {
            return Some(());
        }
        self.expected(what);
        None
    }

    /// Skips to the end of a broken item.
    fn recover(&mut self) {
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
                    // The next item begins on a new line: the `;` was forgotten.
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

    // ---- Items -----------------------------------------------------------------------------

    fn scenario(&mut self) -> Scenario {
        let mut out = Scenario::default();
        if !self.eat_word("scenario") {
            self.expected("`scenario NAME { … }`");
            return out;
        }
        if self.peek() == Some(Kind::Name) {
            out.name = self.word().to_owned();
            out.name_range = self.range();
            self.at += 1;
        } else {
            self.expected("the name of the scenario");
        }
        if self.expect(Kind::OpenBrace, "`{`").is_none() {
            return out;
        }
        loop {
            match self.peek() {
                None => {
                    self.expected("`}` at the end of the scenario");
                    break;
                }
                Some(Kind::CloseBrace) => {
                    self.at += 1;
                    break;
                }
                Some(Kind::Semicolon) => self.at += 1,
                Some(_) => {
                    let start = self.at;
                    match self.item() {
                        Some(item) => out.items.push(item),
                        None => {
                            self.at += usize::from(self.at == start);
                            self.recover();
                        }
                    }
                }
            }
        }
        if self.peek().is_some() {
            self.expected("nothing after the end of the scenario: one scenario per file");
        }
        out
    }

    fn item(&mut self) -> Option<Item> {
        let start = self.range().start;
        let word = self.word();
        if !ITEMS.contains(&word) {
            self.expected(&format!("one of {}", ITEMS.join(", ")));
            return None;
        }
        self.at += 1;
        let item = match word {
            "use" => {
                let range = self.range();
                self.expect(Kind::Text, "the name of a `.gen` file in quotes")?;
                let value = self.text[range.start + 1..range.end - 1].to_owned();
                Item::Use(Spanned { value, range })
            }
            "unit" => {
                let count = self.number()?;
                let range = self.range();
                let unit = self.unit()?;
                if count == 0 {
                    let message = "the unit is zero; give at least 1".to_owned();
                    self.errors
                        .push(Diagnostic::error("scn-zero-unit", range, message));
                    return None;
                }
                Item::Unit(count, unit)
            }
            "cores" if self.eat_word("free") => Item::Cores(None),
            "cores" => {
                let range = self.range();
                let count = self.small()?;
                if count == 0 {
                    let message =
                        "without a core nothing runs; give at least 1, or `free`".to_owned();
                    self.errors
                        .push(Diagnostic::error("scn-no-core", range, message));
                    return None;
                }
                Item::Cores(Some(count))
            }
            "policy" => Item::Policy(self.choose(&[
                ("fifo", Policy::Fifo),
                ("edf", Policy::Edf),
                ("any", Policy::Any),
            ])?),
            "durations" => Item::Durations(self.choose(&[
                ("interval", Durations::Interval),
                ("fixed", Durations::Fixed),
                ("open", Durations::Open),
            ])?),
            "duration" => {
                let path = self.path()?;
                let interval = self.interval()?;
                Item::Duration(path, interval, self.unit()?)
            }
            "loop" => {
                let limit = if self.peek() == Some(Kind::Number) {
                    let range = self.range();
                    let limit = self.small()?;
                    if limit == 0 {
                        let message = "a turn enters a state at least once".to_owned();
                        self.errors
                            .push(Diagnostic::error("scn-loop-zero", range, message));
                        return None;
                    }
                    Some(limit)
                } else {
                    self.choose(&[("free", None), ("once", Some(1))])?
                };
                let path = self.optional_path()?;
                Item::Loop(limit, path, start..self.end())
            }
            "idle" => {
                let keep = self.choose(&[("drop", false), ("keep", true)])?;
                Item::Idle(keep, self.optional_path()?)
            }
            "locks" => Item::LocksFifo(self.choose(&[("free", false), ("fifo", true)])?),
            "async" => Item::AsyncFree(self.choose(&[("held", false), ("free", true)])?),
            "aperiodic" => Item::AperiodicCore(self.choose(&[("core", true), ("free", false)])?),
            "connect" => {
                let from = self.path()?;
                if !self.eat_word("to") {
                    self.expected("`to`");
                    return None;
                }
                let to = if self.eat_word("none") {
                    None
                } else {
                    Some(self.path()?)
                };
                Item::Connect(from, to)
            }
            "slots" => {
                let path = self.path()?;
                Item::Slots(path, self.small()?)
            }
            "client" => {
                let name = self.name("the name of the client")?;
                return Some(Item::Client(Client {
                    name,
                    steps: self.steps()?,
                }));
            }
            _ => {
                let check = self.check_body(start)?;
                self.expect(Kind::Semicolon, "`;`")?;
                let range = start..self.end();
                return Some(Item::Check(Check { range, ..check }));
            }
        };
        self.expect(Kind::Semicolon, "`;`")?;
        Some(item)
    }

    fn check_body(&mut self, start: usize) -> Option<Check> {
        let mut name = None;
        if self
            .tokens
            .get(self.at + 1)
            .is_some_and(|it| it.kind == Kind::Colon)
        {
            name = Some(self.name("the name of the check")?);
            self.at += 1;
        }
        let word = self.word();
        if !CHECKS.contains(&word) {
            self.expected(&format!("one of {}", CHECKS.join(", ")));
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
                CheckKind::Within(p, q, self.bound()?)
            }
            "leadsto" => {
                let (p, q) = self.implication()?;
                CheckKind::LeadsTo(p, q)
            }
            "eventually" => CheckKind::Eventually(self.pred()?),
            "always" => CheckKind::Always(self.pred()?),
            "deadlock" => CheckKind::Deadlock,
            _ => CheckKind::Reachable(self.pred()?),
        };
        Some(Check {
            name,
            kind,
            range: start..self.end(),
        })
    }

    fn implication(&mut self) -> Option<(Pred, Pred)> {
        let p = self.pred()?;
        self.expect(Kind::Implies, "`=>`")?;
        Some((p, self.pred()?))
    }

    fn bound(&mut self) -> Option<Bound> {
        if !self.eat(Kind::AtMost) {
            return Some(None);
        }
        let count = self.number()?;
        Some(Some((count, self.unit()?)))
    }

    // ---- Clients ---------------------------------------------------------------------------

    fn steps(&mut self) -> Option<Vec<Step>> {
        self.nested(|it| {
            it.expect(Kind::OpenBrace, "`{`")?;
            let mut steps = Vec::new();
            loop {
                match it.peek() {
                    None => {
                        it.expected("`}`");
                        return None;
                    }
                    Some(Kind::CloseBrace) => {
                        it.at += 1;
                        return Some(steps);
                    }
                    Some(Kind::Semicolon) => it.at += 1,
                    Some(_) => {
                        let start = it.at;
                        match it.step() {
                            Some(step) => steps.push(step),
                            None => {
                                it.at += usize::from(it.at == start);
                                it.recover();
                            }
                        }
                    }
                }
            }
        })
    }

    fn step(&mut self) -> Option<Step> {
        let start = self.range().start;
        let mut label = None;
        if self
            .tokens
            .get(self.at + 1)
            .is_some_and(|it| it.kind == Kind::Colon)
        {
            label = Some(self.name("a label")?);
            self.at += 1;
        }
        let word = self.word();
        if !STEPS.contains(&word) {
            self.expected(&format!("one of {}", STEPS.join(", ")));
            return None;
        }
        self.at += 1;
        let kind = match word {
            "send" => StepKind::Send(self.path()?),
            "await" => {
                let ended = self.choose(&[("accepted", false), ("ended", true)])?;
                let path = self.optional_path()?;
                if ended {
                    StepKind::AwaitEnded(path)
                } else {
                    StepKind::AwaitAccepted(path)
                }
            }
            "delay" => {
                let interval = self.interval()?;
                StepKind::Delay(interval, self.unit()?)
            }
            "repeat" => {
                let count = if self.eat(Kind::Star) {
                    None
                } else {
                    let range = self.range();
                    let count = self.number()?;
                    if count > REPEAT {
                        let message = format!("more than {REPEAT} repetitions; use `*` for no end");
                        self.errors
                            .push(Diagnostic::error("scn-repeat", range, message));
                        return None;
                    }
                    Some(count as u32)
                };
                let body = self.steps()?;
                let kind = StepKind::Repeat(count, body);
                return Some(Step {
                    label,
                    kind,
                    range: start..self.end(),
                });
            }
            _ => {
                let mut branches = vec![self.steps()?];
                while self.eat_word("or") {
                    branches.push(self.steps()?);
                }
                let kind = StepKind::Choice(branches);
                return Some(Step {
                    label,
                    kind,
                    range: start..self.end(),
                });
            }
        };
        self.expect(Kind::Semicolon, "`;`")?;
        Some(Step {
            label,
            kind,
            range: start..self.end(),
        })
    }

    // ---- Predicates ------------------------------------------------------------------------

    fn pred(&mut self) -> Option<Pred> {
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

    fn factor(&mut self) -> Option<Pred> {
        self.nested(|it| {
            if it.eat_word("not") {
                return Some(Pred::Not(Box::new(it.factor()?)));
            }
            if it.eat_word("leave") {
                return Some(Pred::Leave(it.path()?));
            }
            if it.eat(Kind::OpenParen) {
                let pred = it.pred()?;
                it.expect(Kind::CloseParen, "`)`")?;
                return Some(pred);
            }
            Some(Pred::Atom(it.path()?))
        })
    }

    fn nested<T>(&mut self, body: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        if self.depth == DEPTH {
            let message = "nested too deeply; write it simpler".to_owned();
            self.errors
                .push(Diagnostic::error("scn-nesting", self.range(), message));
            return None;
        }
        self.depth += 1;
        let out = body(self);
        self.depth -= 1;
        out
    }

    // ---- Small things ----------------------------------------------------------------------

    fn name(&mut self, what: &str) -> Option<Spanned<String>> {
        let range = self.range();
        self.expect(Kind::Name, what)?;
        Some(Spanned {
            value: self.text[range.clone()].to_owned(),
            range,
        })
    }

    fn path(&mut self) -> Option<Path> {
        let mut path = Path {
            names: vec![self.name("a name such as component.task")?],
        };
        while self.eat(Kind::Dot) {
            path.names.push(self.name("a name after `.`")?);
        }
        Some(path)
    }

    fn optional_path(&mut self) -> Option<Option<Path>> {
        if self.peek() == Some(Kind::Name) {
            self.path().map(Some)
        } else {
            Some(None)
        }
    }

    fn path_or_all(&mut self) -> Option<Option<Path>> {
        if self.eat(Kind::Star) {
            Some(None)
        } else {
            self.path().map(Some)
        }
    }

    fn number(&mut self) -> Option<u64> {
        let range = self.range();
        self.expect(Kind::Number, "a whole number")?;
        match self.text[range.clone()].parse() {
            Ok(number) => Some(number),
            Err(_) => {
                let message = "this number is too large".to_owned();
                self.errors
                    .push(Diagnostic::error("scn-number", range, message));
                None
            }
        }
    }

    fn small(&mut self) -> Option<u32> {
        let range = self.range();
        let number = self.number()?;
        if number > 255 {
            let message = "this number is too large; at most 255".to_owned();
            self.errors
                .push(Diagnostic::error("scn-number", range, message));
            return None;
        }
        Some(number as u32)
    }

    fn interval(&mut self) -> Option<Interval> {
        if !self.eat(Kind::OpenBracket) {
            let exact = self.number()?;
            return Some(Interval {
                lower: exact,
                upper: Some(exact),
            });
        }
        let start = self.range().start;
        let lower = self.number()?;
        self.expect(Kind::Comma, "`,`")?;
        let upper = if self.eat(Kind::Star) {
            None
        } else {
            Some(self.number()?)
        };
        let range = start..self.end();
        self.expect(Kind::CloseBracket, "`]`")?;
        if upper.is_some_and(|upper| upper < lower) {
            let message = "the bounds are in the wrong order".to_owned();
            self.errors
                .push(Diagnostic::error("scn-interval", range, message));
            return None;
        }
        Some(Interval { lower, upper })
    }

    fn unit(&mut self) -> Option<Unit> {
        self.choose(&[
            ("s", Unit::Seconds),
            ("ms", Unit::Milliseconds),
            ("us", Unit::Microseconds),
        ])
    }

    fn choose<T: Copy>(&mut self, of: &[(&str, T)]) -> Option<T> {
        if let Some(&(_, value)) = of.iter().find(|(word, _)| *word == self.word()) {
            self.at += 1;
            return Some(value);
        }
        let words: Vec<&str> = of.iter().map(|(word, _)| *word).collect();
        self.expected(&words.join(" or "));
        None
    }
}

/// Words that begin an item.
pub(crate) const ITEMS: &[&str] = &[
    "use",
    "unit",
    "cores",
    "policy",
    "durations",
    "duration",
    "loop",
    "idle",
    "locks",
    "async",
    "aperiodic",
    "connect",
    "slots",
    "client",
    "check",
];

/// Words that begin a check.
pub(crate) const CHECKS: &[&str] = &[
    "schedulable",
    "no-overdue",
    "response",
    "within",
    "leadsto",
    "eventually",
    "always",
    "reachable",
    "deadlock",
];

/// Words that begin a step of a client.
pub(crate) const STEPS: &[&str] = &["send", "await", "delay", "repeat", "choice"];
