//! A scenario and its items.

use super::Parser;
use crate::diagnostic::Diagnostic;
use crate::scn::ast::{Check, Client, Durations, Item, Policy, SLOTS, Scenario, Spanned};
use crate::scn::lexer::Kind;
use crate::scn::semantics::{LockRule, PauseRule, PortRule, Preset, TickRule, TurnRule};

/// Words that begin an item.
pub(in crate::scn) const ITEMS: &[&str] = &[
    "use",
    "times",
    "weights",
    "unit",
    "semantics",
    "cores",
    "policy",
    "affinity",
    "durations",
    "duration",
    "loop",
    "idle",
    "ticks",
    "turns",
    "locks",
    "ports",
    "pause",
    "exceptions",
    "order",
    "async",
    "aperiodic",
    "connect",
    "slots",
    "client",
    "on",
    "check",
];

impl Parser<'_> {
    pub(super) fn scenario(&mut self) -> Scenario {
        let mut out = Scenario::default();
        if !self.eat_word("scenario") {
            self.expected("`scenario NAME { … }`");
            return out;
        }
        if self.peek() == Some(Kind::Name) {
            self.word().clone_into(&mut out.name);
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
                    if let Some(item) = self.item() {
                        out.items.push(item);
                        out.items.extend(self.lower.drain(..).map(Item::Check));
                    } else {
                        self.at += usize::from(self.at == start);
                        self.recover();
                    }
                }
            }
        }
        if self.peek().is_some() {
            self.expected("nothing after the end of the scenario: one scenario per file");
        }
        out
    }

    fn file(&mut self, what: &str) -> Option<Spanned<String>> {
        let range = self.range();
        self.expect(Kind::Text, what)?;
        let value = self.text[range.start + 1..range.end - 1].to_owned();
        Some(Spanned { value, range })
    }

    fn item(&mut self) -> Option<Item> {
        let start = self.range().start;
        let word = self.word();
        if !ITEMS.contains(&word) {
            self.expected_word(ITEMS);
            return None;
        }
        self.at += 1;
        let item = match word {
            "use" => Item::Use(self.file("the name of a `.gen` file in quotes")?),
            "times" => Item::Times(self.file("the name of a `.wcet` file in quotes")?),
            "weights" => Item::Weights(self.file("the name of a `.proba` file in quotes")?),
            "unit" => {
                let count = self.number()?;
                let range = self.range();
                let unit = self.unit()?;
                if count == 0 {
                    let message = "the unit is zero; give at least 1".to_owned();
                    self.errors.push(Diagnostic::error("scn-zero-unit", range, message));
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
                    self.errors.push(Diagnostic::error("scn-no-core", range, message));
                    return None;
                }
                Item::Cores(Some(count))
            }
            "policy" => Item::Policy(self.choose(Policy::ALL)?),
            "affinity" => {
                let path = self.path()?;
                let range = self.range();
                let core = self.small()?;
                if core == 0 {
                    let message = "cores are numbered from 1".to_owned();
                    self.errors.push(Diagnostic::error("scn-affinity", range, message));
                    return None;
                }
                Item::Affinity(path, core)
            }
            "semantics" => Item::Semantics(self.choose(Preset::ALL)?),
            "ticks" => Item::Ticks(self.choose(TickRule::ALL)?),
            "turns" => Item::Turns(self.choose(TurnRule::ALL)?),
            "locks" => Item::Locks(self.choose(LockRule::ALL)?),
            "ports" => Item::Ports(self.choose(PortRule::ALL)?),
            "pause" => Item::Pause(self.choose(PauseRule::ALL)?),
            "exceptions" => {
                let on = self.choose(&[("on", true), ("off", false)])?;
                Item::Exceptions(on, self.optional_path()?)
            }
            "order" => Item::Order(self.choose(&[("on", true), ("off", false)])?),
            "durations" => Item::Durations(self.choose(Durations::ALL)?),
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
                        self.errors.push(Diagnostic::error("scn-loop-zero", range, message));
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
            "async" => Item::AsyncFree(self.choose(&[("held", false), ("free", true)])?),
            "aperiodic" => Item::AperiodicCore(self.choose(&[("core", true), ("free", false)])?),
            "connect" => {
                let from = self.path()?;
                if !self.eat_word("to") {
                    self.expected_word(&["to"]);
                    return None;
                }
                let to = if self.eat_word("none") { None } else { Some(self.path()?) };
                Item::Connect(from, to)
            }
            "slots" => {
                let path = self.path()?;
                let range = self.range();
                let count = self.number()?;
                let Some(count) = u32::try_from(count).ok().filter(|number| SLOTS.contains(number))
                else {
                    let message = format!(
                        "a task or an activity can have {} to {} slots, not {count}: without one it never \
                            runs, and each one more multiplies what has to be explored",
                        SLOTS.start(),
                        SLOTS.end()
                    );
                    self.errors.push(Diagnostic::error("scn-slots", range, message));
                    return None;
                };
                Item::Slots(path, count)
            }
            "client" => {
                let name = self.name("the name of the client")?;
                let steps = self.steps()?;
                self.refuse_stops(&steps);
                return Some(Item::Client(Client { name, steps, trigger: None }));
            }
            "on" => return self.measure(start).map(Item::Client),
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
}
