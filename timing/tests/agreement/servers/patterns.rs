//! Patterns, read from their written form: what each remembers of a run, and when it is violated.

use std::collections::BTreeSet;

use dotgen_timing::scn::ast::{self, MonitorKind};

use super::Interpreter;
use super::model::System;
use super::predicates::{Predicate, predicate};
use super::state::State;

#[derive(Debug)]
pub(crate) struct Pattern {
    kind: MonitorKind,
    predicates: Vec<Predicate>,
    time: u32,
}

impl Pattern {
    /// Times are in milliseconds.
    pub(crate) fn new(system: &System, written: &ast::Pattern) -> Pattern {
        Pattern {
            kind: written.kind,
            predicates: written
                .predicates
                .iter()
                .map(|operand| predicate(system, operand))
                .collect(),
            time: written.time.map_or(0, |(count, _)| count as u32),
        }
    }
}

/// The memory that a pattern has of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(super) struct Memory {
    /// Times since each moment at which the first predicate became true, as long as they count.
    ages: BTreeSet<u32>,
    /// The first predicate has held.
    first: bool,
    /// The last predicate has held, in the present interval if there are intervals.
    last: bool,
    /// An interval has begun.
    open: bool,
    pub(super) violated: bool,
}

impl Interpreter<'_> {
    pub(super) fn remember(&self, before: Option<&State>, now: &mut State) {
        for (i, pattern) in self.patterns.iter().enumerate() {
            let mut memory = std::mem::take(&mut now.patterns[i]);
            let first = &pattern.predicates[0];
            let was = before.is_some_and(|before| self.holds(Some(before), before, first));
            let values: Vec<bool> =
                pattern.predicates.iter().map(|operand| self.holds(before, now, operand)).collect();
            memory.violated |= violates(pattern, &mut memory, was, &values);
            now.patterns[i] = memory;
        }
    }
}

fn violates(pattern: &Pattern, memory: &mut Memory, was: bool, values: &[bool]) -> bool {
    let last = values[values.len() - 1];
    match pattern.kind {
        MonitorKind::Absent => {
            if values[0] && !was {
                memory.ages.insert(0);
            }
            last && !memory.ages.is_empty()
        }
        MonitorKind::Precedes => {
            memory.first |= values[0];
            last && !memory.first
        }
        MonitorKind::NeverAfter => {
            memory.first |= values[0];
            last && memory.first
        }
        MonitorKind::NeverBefore => {
            let violated = values[0] && !memory.first && memory.last;
            memory.first |= values[0];
            memory.last |= last;
            violated
        }
        MonitorKind::NeverBetween | MonitorKind::SomeBetween | MonitorKind::NeverUntil => {
            if values[1] {
                let wrong = match pattern.kind {
                    MonitorKind::NeverBetween => memory.last,
                    MonitorKind::SomeBetween => !memory.last,
                    _ => false,
                };
                return std::mem::take(&mut memory.open) && wrong;
            }
            if values[0] && !memory.open {
                (memory.open, memory.last) = (true, false);
            }
            memory.last |= last;
            pattern.kind == MonitorKind::NeverUntil && memory.open && last
        }
    }
}

impl Memory {
    /// Lets a unit of time pass.
    pub(super) fn pass(&mut self, pattern: &Pattern) {
        let ages = std::mem::take(&mut self.ages).into_iter();
        self.ages = ages.map(|age| age + 1).filter(|&age| age < pattern.time).collect();
    }
}
