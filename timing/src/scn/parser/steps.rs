//! The steps of clients.

use super::Parser;
use crate::diagnostic::Diagnostic;
use crate::scn::ast::{Ending, Step, StepKind};
use crate::scn::lexer::Kind;

/// Words that begin a step of a client.
pub(in crate::scn) const STEPS: &[&str] =
    &["send", "await", "delay", "repeat", "choice", "abort", "kill", "connect", "stop"];

/// Greatest number of repetitions that are unrolled.
const REPEAT: u64 = 1000;

impl Parser<'_> {
    pub(super) fn steps(&mut self) -> Option<Vec<Step>> {
        self.nested(|parser| {
            parser.expect(Kind::OpenBrace, "`{`")?;
            let mut steps = Vec::new();
            loop {
                match parser.peek() {
                    None => {
                        parser.expected("`}`");
                        return None;
                    }
                    Some(Kind::CloseBrace) => {
                        parser.at += 1;
                        return Some(steps);
                    }
                    Some(Kind::Semicolon) => parser.at += 1,
                    Some(_) => {
                        let start = parser.at;
                        if let Some(step) = parser.step() {
                            steps.push(step);
                        } else {
                            parser.at += usize::from(parser.at == start);
                            parser.recover();
                        }
                    }
                }
            }
        })
    }

    /// Parses `ok`, `failed` or nothing; a component may have such a name as well.
    fn ending(&mut self) -> Ending {
        let is_path = (self.tokens.get(self.at + 1)).is_some_and(|token| token.kind == Kind::Dot);
        if !is_path && self.eat_word("ok") {
            Ending::Ok
        } else if !is_path && self.eat_word("failed") {
            Ending::Failed
        } else {
            Ending::Any
        }
    }

    fn step(&mut self) -> Option<Step> {
        let start = self.range().start;
        let mut label = None;
        if self.tokens.get(self.at + 1).is_some_and(|token| token.kind == Kind::Colon) {
            label = Some(self.name("a label")?);
            self.at += 1;
        }
        let word = self.word();
        if !STEPS.contains(&word) {
            self.expected_word(STEPS);
            return None;
        }
        self.at += 1;
        let kind = match word {
            "send" => StepKind::Send(self.path()?),
            "await" => {
                let ended = self.choose(&[("accepted", false), ("ended", true)])?;
                let ending = if ended { self.ending() } else { Ending::Any };
                let path = self.optional_path()?;
                if ended {
                    StepKind::AwaitEnded(ending, path)
                } else {
                    StepKind::AwaitAccepted(path)
                }
            }
            "abort" => StepKind::Abort(self.path()?),
            "stop" => StepKind::Stop,
            "kill" => StepKind::Kill(self.path()?),
            "connect" => StepKind::Connect(self.path()?),
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
                        self.errors.push(Diagnostic::error("scn-repeat", range, message));
                        return None;
                    }
                    Some(count as u32)
                };
                let body = self.steps()?;
                let kind = StepKind::Repeat(count, body);
                return Some(Step { label, kind, range: start..self.end() });
            }
            _ => {
                let mut branches = vec![self.steps()?];
                while self.eat_word("or") {
                    branches.push(self.steps()?);
                }
                let kind = StepKind::Choice(branches);
                return Some(Step { label, kind, range: start..self.end() });
            }
        };
        self.expect(Kind::Semicolon, "`;`")?;
        Some(Step { label, kind, range: start..self.end() })
    }
}
