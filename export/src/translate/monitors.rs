//! Monitors of patterns: one small integer each, moved after every action by the verifier's own rule.

use dotgen_timing::property::Monitor;
use dotgen_timing::scn::ast::MonitorKind;

use crate::model::{
    Clock, Edge, Guard, LocationKind, Network, Process, Relation, Term, Update, Variable, all, var,
};

use super::predicates::Conditions;

/// Greatest location of a monitor.
const MOST: u16 = 4;

/// Location of a monitor that watches for a time.
const WATCHES: usize = 2;

/// A monitor.
pub(super) struct Watch<'w> {
    /// Number of the check.
    pub(super) number: usize,
    pub(super) name: &'w String,
    pub(super) monitor: &'w Monitor,
}

impl Watch<'_> {
    fn location(&self) -> Term {
        var(&format!("monitor_{}", self.number))
    }

    fn holds(&self, predicate: usize) -> Term {
        var(&format!("holds_{}_{predicate}", self.number))
    }

    /// Returns the variable of the value of the first predicate before the last action.
    fn was(&self) -> Term {
        var(&format!("was_{}", self.number))
    }

    fn clock(&self) -> String {
        format!("y_{}", self.number)
    }

    fn is_timed(&self) -> bool {
        self.monitor.kind == MonitorKind::Absent
    }

    /// Returns the first location of the scheduler.
    pub(super) fn first(&self) -> String {
        format!("watches_{}", self.number)
    }

    /// Returns the condition that the pattern is violated.
    pub(super) fn violated(&self) -> Guard {
        self.location().is(usize::from(Monitor::VIOLATED))
    }

    /// Declares its variables and its clock.
    pub(super) fn declare(&self, network: &mut Network) {
        let number = self.number;
        let mut variable = |name: String, most: u16, comment: String| {
            network.variables.push(Variable { name, size: None, most: i64::from(most), comment });
        };
        let what = format!(
            "monitor of {}: 0 watches nothing, 1 is violated, 2 watches, 3 has seen the last \
             predicate, 4 is over",
            self.name
        );
        variable(format!("monitor_{number}"), MOST, what);
        for index in 0..self.monitor.predicates.len() {
            let what = format!("1: predicate {} of {} holds", index + 1, self.name);
            variable(format!("holds_{number}_{index}"), 1, what);
        }
        if self.is_timed() {
            let what = format!("1: predicate 1 of {} held before the last action", self.name);
            variable(format!("was_{number}"), 1, what);
            let comment = format!("time for which {} has watched", self.name);
            network.clocks.push(Clock { name: self.clock(), comment });
        }
    }

    /// Adds the locations of the scheduler, which lead to a target.
    pub(super) fn add(&self, conditions: &Conditions, target: &str, out: &mut Process) {
        let moves = format!("moves_{}", self.number);
        let comment = format!("evaluates the predicates of {}", self.name);
        out.location(&self.first(), LocationKind::Committed, comment);
        let comment = format!("moves the monitor of {}", self.name);
        out.location(&moves, LocationKind::Committed, comment);
        let mut edge = Edge::new(&self.first(), &moves, "the values after the action");
        for (index, predicate) in self.monitor.predicates.iter().enumerate() {
            let holds = conditions.after(predicate);
            edge.updates.push(self.holds(index).set_to(holds));
        }
        out.edge(edge);
        let mut rest: Vec<Update> = Vec::new();
        if self.is_timed() {
            rest.push(self.was().set_to(conditions.still(&self.monitor.predicates[0])));
        }
        let count = self.monitor.predicates.len();
        rest.extend((0..count).map(|index| self.holds(index).set(0_usize)));
        if self.is_timed() {
            self.timed(&moves, target, &rest, out);
            return;
        }
        for location in 0..=MOST {
            let mut cases = Vec::new();
            self.cases(location, &mut Vec::new(), &mut cases);
            for (values, next) in cases {
                let known = values.iter().enumerate();
                let holds = known.map(|(index, &value)| self.holds(index).is(usize::from(value)));
                let guard =
                    all(std::iter::once(self.location().is(usize::from(location))).chain(holds));
                let comment = match next {
                    _ if next == location => "the monitor stays",
                    Monitor::VIOLATED => "the pattern is violated",
                    _ => "the monitor moves",
                };
                let edge = Edge::new(&moves, target, comment).when(guard);
                let moved = self.location().set(usize::from(next));
                out.edge(edge.with([moved]).with(rest.clone()));
            }
        }
    }

    /// Collects the first values of predicates that decide the next location, each with that location.
    fn cases(&self, location: u16, values: &mut Vec<bool>, out: &mut Vec<(Vec<bool>, u16)>) {
        let count = self.monitor.predicates.len();
        let unknown = count - values.len();
        let next = |bits: usize| {
            let holds = |index: usize| match values.get(index) {
                Some(&value) => value,
                None => bits >> (index - values.len()) & 1 == 1,
            };
            self.monitor.next(location, false, &mut 0, holds)
        };
        let decided = next(0);
        if (1..1_usize << unknown).all(|bits| next(bits) == decided) {
            out.push((values.clone(), decided));
            return;
        }
        for value in [false, true] {
            values.push(value);
            self.cases(location, values, out);
            values.pop();
        }
    }

    /// The edges of a monitor that watches for a time after its first predicate became true.
    fn timed(&self, moves: &str, target: &str, rest: &[Update], out: &mut Process) {
        let at = |location: usize| self.location().is(location);
        let violated = usize::from(Monitor::VIOLATED);
        let rises = all([self.holds(0).is(1_usize), self.was().is(0_usize)]);
        let (seen, unseen) = (self.holds(1).is(1_usize), self.holds(1).is(0_usize));
        let lives = at(violated).negated();
        let time = i64::from(self.monitor.time);
        let mut add =
            |guards: Vec<Guard>, clock: Option<Relation>, to: Option<usize>, comment: &str| {
                let mut edge = Edge::new(moves, target, comment).when(all(guards));
                if let Some(relation) = clock {
                    edge = edge.when_clock(&self.clock(), relation, time);
                }
                edge.updates.extend(to.map(|to| self.location().set(to)));
                if to == Some(WATCHES) {
                    edge.updates.push(Update::Reset(self.clock()));
                }
                out.edge(edge.with(rest.to_vec()));
            };
        let violation = "the pattern is violated";
        add(vec![at(violated)], None, None, "the pattern is violated already");
        let begins = vec![lives.clone(), rises.clone(), unseen.clone()];
        add(begins, None, Some(WATCHES), "the time begins");
        if time > 0 {
            add(vec![lives.clone(), rises.clone(), seen.clone()], None, Some(violated), violation);
        } else {
            add(vec![lives.clone(), rises.clone(), seen.clone()], None, Some(0), "no time");
        }
        let stays = rises.negated();
        let watches = vec![at(WATCHES), stays.clone(), seen];
        add(watches.clone(), Some(Relation::Less), Some(violated), violation);
        add(watches, Some(Relation::AtLeast), Some(0), "the time is over");
        add(vec![at(WATCHES), stays.clone(), unseen], None, None, "the time goes on");
        add(vec![at(0), stays], None, None, "nothing is watched");
    }
}
