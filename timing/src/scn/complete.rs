//! Completion in scenarios. It uses only the tokens before the cursor, so that incomplete text does not
//! matter.

mod paths;

use std::ops::Range;

use super::ast::{Durations, Item, Policy, Scenario};
use super::lexer::{Kind, Token, lex};
use super::names::{Names, Target};
use super::parser::{CHECKS, ITEMS, STEPS, TRIGGERS};
use super::semantics::{LockRule, PauseRule, PortRule, Preset, TickRule, TurnRule};
use super::words;

/// A proposal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Completion {
    /// Text to insert and to show.
    pub label: String,
    pub kind: CompletionKind,
    /// Meaning.
    pub detail: String,
}

/// The kind of a [`Completion`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompletionKind {
    /// A word of the language.
    Word,
    /// A unit of time.
    Unit,
    Component,
    Task,
    Service,
    Port,
    /// A codel state, or a codel.
    Codel,
    /// A client, or a step of one.
    Client,
    /// A status in a predicate.
    Status,
}

/// The proposals at a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Completions {
    /// The name of a file: the string around the cursor, without quotes.
    File(Range<usize>),
    /// Words and names that replace some bytes.
    Of {
        /// Bytes to replace.
        replace: Range<usize>,
        /// Proposals, in order.
        items: Vec<Completion>,
    },
}

/// The enclosing block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Block {
    File,
    Items,
    Steps,
}

/// The kind of path that is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PathKind {
    Task,
    TaskOrService,
    Service,
    TaskOrActivity,
    Activity,
    Codel,
    Input,
    Output,
    Port,
}

/// Returns the proposals at an offset. There are none inside comments.
pub fn complete(text: &str, scenario: &Scenario, names: &Names, offset: usize) -> Completions {
    let tokens = lex(text);
    let at = tokens.iter().find(|token| token.range.start < offset && offset <= token.range.end);
    let nothing = Completions::Of { replace: offset..offset, items: Vec::new() };
    match at.map(|token| (token.kind, &token.range)) {
        Some((Kind::LineComment | Kind::UnclosedComment, _)) => return nothing,
        Some((Kind::BlockComment, range)) if offset < range.end => return nothing,
        Some((Kind::Text, range)) if offset < range.end => {
            return Completions::File(range.start + 1..range.end - 1);
        }
        Some((Kind::UnclosedText, range)) => return Completions::File(range.start + 1..range.end),
        Some((Kind::Number, range)) if offset == range.end => return nothing,
        _ => {}
    }
    let before: Vec<&Token> = tokens
        .iter()
        .filter(|token| !token.kind.is_trivia() && token.range.end <= offset)
        .collect();
    // The name under the cursor is replaced; the path before it determines the proposals.
    let under = at.filter(|token| token.kind == Kind::Name);
    let replace = under.map_or(offset..offset, |token| token.range.clone());
    let done = match under {
        Some(token) => before.iter().filter(|b| b.range.end <= token.range.start).count(),
        None => before.len(),
    };
    let (block, statement) = statement(text, &before[..done]);
    let mut finder = Finder { text, scenario, names, replace, items: Vec::new() };
    finder.fill(block, statement);
    Completions::Of { replace: finder.replace, items: finder.items }
}

/// Returns the block around a place, and the tokens of the statement before it.
fn statement<'t, 's>(text: &str, tokens: &'s [&'t Token]) -> (Block, &'s [&'t Token]) {
    let mut blocks = vec![Block::File];
    let mut start = 0;
    for (i, token) in tokens.iter().enumerate() {
        match token.kind {
            Kind::OpenBrace => {
                let inner = match (blocks.last(), word(text, tokens.get(start))) {
                    (Some(Block::File) | None, _) => Block::Items,
                    _ => Block::Steps,
                };
                blocks.push(inner);
                start = i + 1;
            }
            Kind::CloseBrace => {
                if blocks.len() > 1 {
                    blocks.pop();
                }
                start = i + 1;
            }
            Kind::Semicolon => start = i + 1,
            _ => {}
        }
    }
    (blocks.last().copied().unwrap_or(Block::File), &tokens[start..])
}

fn word<'t>(text: &'t str, token: Option<&&Token>) -> &'t str {
    match token {
        Some(token) if matches!(token.kind, Kind::Name | Kind::Star) => &text[token.range.clone()],
        _ => "",
    }
}

struct Finder<'f> {
    text: &'f str,
    scenario: &'f Scenario,
    names: &'f Names<'f>,
    replace: Range<usize>,
    items: Vec<Completion>,
}

impl Finder<'_> {
    fn fill(&mut self, block: Block, mut statement: &[&Token]) {
        // `NAME :` before a step.
        if block == Block::Steps
            && statement.get(1).is_some_and(|statement| statement.kind == Kind::Colon)
        {
            statement = &statement[2..];
        }
        let first = word(self.text, statement.first());
        match block {
            Block::File if statement.is_empty() => self.words(&["scenario"]),
            Block::File => {}
            Block::Items => {
                if statement.is_empty() {
                    self.words(ITEMS);
                } else {
                    self.item(first, &statement[1..]);
                }
            }
            Block::Steps if statement.is_empty() => {
                let mut steps = STEPS.to_vec();
                if self.after_choice() {
                    steps.insert(0, "or");
                }
                self.words(&steps);
            }
            Block::Steps => self.step(first, &statement[1..]),
        }
    }

    /// Returns true if a block has just ended, after which a choice may continue.
    fn after_choice(&self) -> bool {
        let before = self.text[..self.replace.start].trim_end();
        before.ends_with('}')
    }

    fn item(&mut self, first: &str, rest: &[&Token]) {
        let begun = !rest.is_empty();
        match first {
            "cores" if !begun => self.words(&["free"]),
            "policy" if !begun => self.rules(Policy::ALL),
            "semantics" if !begun => self.rules(Preset::ALL),
            "ticks" if !begun => self.rules(TickRule::ALL),
            "turns" if !begun => self.rules(TurnRule::ALL),
            "ports" if !begun => self.rules(PortRule::ALL),
            "pause" if !begun => self.rules(PauseRule::ALL),
            "exceptions" | "order" if !begun => self.words(&["on", "off"]),
            "exceptions" => {
                self.path(PathKind::TaskOrService, &rest[1..]);
            }
            "affinity" => {
                self.path(PathKind::Task, rest);
            }
            "durations" if !begun => self.rules(Durations::ALL),
            "locks" if !begun => self.rules(LockRule::ALL),
            "async" if !begun => self.words(&["held", "free"]),
            "aperiodic" if !begun => self.words(&["core", "free"]),
            "idle" if !begun => self.words(&["drop", "keep"]),
            "loop" if !begun => self.words(&["once", "free"]),
            "idle" => {
                self.path(PathKind::Task, &rest[1..]);
            }
            "loop" => {
                self.path(PathKind::TaskOrService, &rest[1..]);
            }
            "unit" => {
                self.unit(rest);
            }
            "duration" => {
                let _ = self.path(PathKind::Codel, rest) || self.unit(rest);
            }
            "slots" => {
                self.path(PathKind::TaskOrActivity, rest);
            }
            "connect" => {
                let to = rest.iter().position(|token| word(self.text, Some(token)) == "to");
                match to {
                    Some(to) => {
                        if rest[to + 1..].is_empty() {
                            self.words(&["none"]);
                        }
                        self.path(PathKind::Output, &rest[to + 1..]);
                    }
                    None => {
                        if !self.path(PathKind::Input, rest) {
                            self.words(&["to"]);
                        }
                    }
                }
            }
            "check" => self.check(rest),
            "on" => self.measure(rest),
            _ => {}
        }
    }

    fn components(&mut self) {
        for (label, target) in self.names.after(None) {
            self.push(label, &target);
        }
    }

    fn measure(&mut self, mut rest: &[&Token]) {
        if rest.get(1).is_some_and(|token| token.kind == Kind::Colon) {
            rest = &rest[2..];
        }
        let Some((first, rest)) = rest.split_first() else {
            return self.rules(TRIGGERS);
        };
        let last = rest.iter().rposition(|token| token.kind == Kind::Comma);
        let path = &rest[last.map_or(0, |comma| comma + 1)..];
        match word(self.text, Some(first)) {
            "late" => {
                let _ = self.path(PathKind::Codel, path) || self.unit(rest);
            }
            "lost" if path.is_empty() => self.components(),
            "stale" => {
                let after = rest.iter().position(|token| word(self.text, Some(token)) == "after");
                match after {
                    Some(after) => {
                        self.unit(&rest[after + 1..]);
                    }
                    None => {
                        if !self.path(PathKind::Output, path) {
                            self.words(&["after"]);
                        }
                    }
                }
            }
            "violation" if rest.is_empty() => self.words(&["of"]),
            "violation" => {
                let checks = self.scenario.items.iter().filter_map(|item| match item {
                    Item::Check(check) => check.name.as_ref(),
                    _ => None,
                });
                self.items.extend(checks.map(|name| Completion {
                    label: name.value.clone(),
                    kind: CompletionKind::Word,
                    detail: "check".to_owned(),
                }));
            }
            _ => {}
        }
    }

    fn check(&mut self, mut rest: &[&Token]) {
        if rest.get(1).is_some_and(|token| token.kind == Kind::Colon) {
            rest = &rest[2..];
        }
        let whole = rest;
        let Some((first, rest)) = rest.split_first() else {
            return self.words(CHECKS);
        };
        match word(self.text, Some(first)) {
            "schedulable" | "no-overdue" => {
                if rest.is_empty() {
                    self.all();
                }
                self.path(PathKind::Task, rest);
            }
            "response" => {
                if rest.is_empty() {
                    self.all();
                }
                if !self.path(PathKind::Task, rest) {
                    self.unit(rest);
                }
            }
            "reaction" | "age" => self.chain(rest),
            "deadlock" => {}
            // All other checks are about predicates.
            check if CHECKS.contains(&check) => {
                let more: &[&str] = match check {
                    "within" if rest.iter().any(|token| token.kind == Kind::Implies) => {
                        &["then", "in"]
                    }
                    "absent" => &["after", "for"],
                    "before" => &["never", "always", "eventually"],
                    "after" => &["until", "never", "always"],
                    "between" => &["never", "always", "eventually"],
                    _ => &[],
                };
                let _ = self.unit(rest) || self.predicate(rest, more);
            }
            _ => {
                self.predicate(whole, &["precedes"]);
            }
        }
    }

    fn step(&mut self, first: &str, rest: &[&Token]) {
        match first {
            "send" => {
                self.path(PathKind::Service, rest);
            }
            "await" => match rest.split_first() {
                None => self.words(&["accepted", "ended"]),
                Some((first, rest)) => {
                    let how = word(self.text, rest.first());
                    if word(self.text, Some(first)) == "ended" && rest.is_empty() {
                        self.words(&["ok", "failed"]);
                    }
                    let chosen = matches!(how, "ok" | "failed") && rest.len() != 2;
                    self.path(PathKind::Service, &rest[usize::from(chosen)..]);
                }
            },
            "abort" => {
                if rest.is_empty() {
                    self.sent_labels();
                }
                self.path(PathKind::Activity, rest);
            }
            "kill" | "connect" if rest.is_empty() => self.components(),
            "delay" => {
                self.unit(rest);
            }
            _ => {}
        }
    }

    /// Adds the labels of requests of the client around the cursor, as far as the client is written: `NAME :
    /// send`.
    fn sent_labels(&mut self) {
        let tokens = lex(self.text);
        let before: Vec<&Token> = (tokens.iter())
            .filter(|token| !token.kind.is_trivia() && token.range.end <= self.replace.start)
            .collect();
        let is = |at: usize, what: &str| word(self.text, before.get(at)) == what;
        let Some(client) = (0..before.len()).rev().find(|&token| is(token, "client")) else {
            return;
        };
        let name = word(self.text, before.get(client + 1)).to_owned();
        let mut labels: Vec<String> = Vec::new();
        for at in client..before.len() {
            let colon = before.get(at + 1).is_some_and(|token| token.kind == Kind::Colon);
            let label = word(self.text, before.get(at)).to_owned();
            if colon && is(at + 2, "send") && !labels.contains(&label) {
                labels.push(label);
            }
        }
        for label in labels {
            let target = Target::Step(name.clone(), label.clone());
            self.push(label, &target);
        }
    }

    fn words(&mut self, words: &[&str]) {
        for &word in words {
            let known = words::find(word);
            self.items.push(Completion {
                label: word.to_owned(),
                kind: CompletionKind::Word,
                detail: known.map_or(String::new(), |word| word.meaning.to_owned()),
            });
        }
    }

    fn rules<T>(&mut self, rules: &[(&str, T)]) {
        let words: Vec<&str> = rules.iter().map(|rule| rule.0).collect();
        self.words(&words);
    }

    fn all(&mut self) {
        self.items.push(Completion {
            label: "*".to_owned(),
            kind: CompletionKind::Word,
            detail: "all tasks".to_owned(),
        });
    }

    /// Adds units after a number or interval. Returns true if this is such a place.
    fn unit(&mut self, rest: &[&Token]) -> bool {
        let after = rest
            .last()
            .is_some_and(|token| matches!(token.kind, Kind::Number | Kind::CloseBracket));
        if after {
            for unit in ["ms", "us", "s"] {
                self.items.push(Completion {
                    label: unit.to_owned(),
                    kind: CompletionKind::Unit,
                    detail: String::new(),
                });
            }
        }
        after
    }
}

#[cfg(test)]
mod tests {
    use super::super::names::STATUSES;
    use super::*;

    #[test]
    fn every_word_has_a_meaning() {
        for word in [ITEMS, CHECKS, STEPS, STATUSES, &["precedes", "until", "in", "for"]].concat() {
            assert!(words::find(word).is_some(), "{word}");
        }
    }
}
