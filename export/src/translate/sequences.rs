//! Observers of predicates that must follow each other: a trigger, then the responses in order.

use dotgen_timing::property::Predicate;

use crate::model::{
    Clock, Edge, Guard, LocationKind, Network, Process, Term, Update, Variable, all, any, var,
};

use super::predicates::Conditions;

/// An observer. Of the obligations that wait for the same response, the oldest is kept, as in the verifier.
pub(super) struct Sequence<'s> {
    /// Number of the check.
    pub(super) number: usize,
    pub(super) name: &'s String,
    pub(super) trigger: &'s Predicate,
    pub(super) responses: &'s [Predicate],
}

impl Sequence<'_> {
    fn is_single(&self) -> bool {
        self.responses.len() == 1
    }

    fn was(&self) -> Term {
        var(&format!("was_{}", self.number))
    }

    /// Returns the variable of the obligation that waits for a response: 1 if it is open, or with several
    /// responses the number of its clock.
    fn open(&self, response: usize) -> Term {
        let name = format!("open_{}", self.number);
        if self.is_single() { var(&name) } else { Term::element(&name, response) }
    }

    /// Returns the variable of the clock of the obligation that moves to the next response; 0: none.
    fn moves(&self) -> Term {
        var(&format!("moves_{}", self.number))
    }

    fn clock(&self, clock: usize) -> String {
        if self.is_single() {
            format!("y_{}", self.number)
        } else {
            format!("y_{}_{clock}", self.number)
        }
    }

    /// Returns the first location.
    pub(super) fn first(&self) -> String {
        format!("watches_{}", self.number)
    }

    fn location(&self, response: usize) -> String {
        format!("awaits_{}_{response}", self.number)
    }

    /// Declares its variables and clocks.
    pub(super) fn declare(&self, network: &mut Network) {
        let (number, name, count) = (self.number, self.name, self.responses.len());
        let mut variable = |name: String, size: Option<usize>, most: usize, comment: String| {
            network.variables.push(Variable { name, size, most: most as i64, comment });
        };
        if self.is_single() {
            let what = format!("1: {name} waits for its response");
            variable(format!("open_{number}"), None, 1, what);
        } else {
            let what = format!(
                "clock of the obligation of {name} that waits for each response, from 1; 0: none"
            );
            variable(format!("open_{number}"), Some(count), count, what);
            let what = "clock of the obligation that moves to the next response; 0: none";
            variable(format!("moves_{number}"), None, count, what.to_owned());
        }
        variable(format!("was_{number}"), None, 1, format!("1: {name} was triggered before"));
        for clock in 1..=count {
            let comment = format!("time since the trigger of {name}");
            network.clocks.push(Clock { name: self.clock(clock), comment });
        }
    }

    /// Returns the clocks of open obligations, each with the condition that it counts.
    pub(super) fn ages(&self) -> Vec<(Guard, String)> {
        let count = self.responses.len();
        let counts = |clock: usize| any((0..count).map(|at| self.open(at).is(clock)));
        (1..=count).map(|clock| (counts(clock), self.clock(clock))).collect()
    }

    /// Adds the locations, which lead to a target.
    pub(super) fn add(&self, conditions: &Conditions, target: &str, out: &mut Process) {
        let comment = format!("opens and closes the obligation of {}", self.name);
        out.location(&self.first(), LocationKind::Committed, comment);
        let was = self.was();
        let triggered = all([
            self.open(0).is(0_usize),
            conditions.after(self.trigger),
            was.clone().is(0_usize),
        ]);
        let remembers = was.set_to(conditions.still(self.trigger));
        if self.is_single() {
            let met = conditions.after(&self.responses[0]);
            self.single(target, (&triggered, &met), &remembers, out);
            return;
        }
        let mut free = Vec::new();
        let counts: Vec<Guard> = self.ages().into_iter().map(|age| age.0).collect();
        for (index, counts) in counts.iter().enumerate() {
            let clock = index + 1;
            let edge = Edge::new(&self.first(), &self.location(0), "an obligation begins");
            let is_first = all(free.iter().cloned());
            let edge = edge.when(all([triggered.clone(), counts.negated(), is_first]));
            let begins = [self.moves().set(clock), Update::Reset(self.clock(clock))];
            out.edge(edge.with(begins).with([remembers.clone()]));
            free.push(counts.clone());
        }
        let edge = Edge::new(&self.first(), &self.location(0), "no new obligation");
        out.edge(edge.when(triggered.negated()).with([remembers]));
        for (at, response) in self.responses.iter().enumerate() {
            let next = if at + 1 < self.responses.len() {
                self.location(at + 1)
            } else {
                target.to_owned()
            };
            self.response(at, &next, &conditions.after(response), out);
        }
    }

    /// The edges with one response.
    fn single(
        &self,
        target: &str,
        (triggered, met): (&Guard, &Guard),
        remembers: &Update,
        out: &mut Process,
    ) {
        let open = self.open(0);
        let mut add = |guards: [Guard; 2], updates: Vec<Update>, comment: &str| {
            let edge = Edge::new(&self.first(), target, comment).when(all(guards));
            out.edge(edge.with(updates).with([remembers.clone()]));
        };
        let opens = vec![open.clone().set(1_usize), Update::Reset(self.clock(1))];
        add([triggered.clone(), met.negated()], opens, "the obligation begins");
        add([triggered.clone(), met.clone()], Vec::new(), "triggered and met at once");
        let is_open = open.clone().is(1_usize);
        let closes = vec![open.clone().set(0_usize)];
        add([is_open.clone(), met.clone()], closes, "the obligation is met");
        add([is_open, met.negated()], Vec::new(), "the obligation stays open");
        add([open.is(0_usize), triggered.negated()], Vec::new(), "no obligation");
    }

    /// The edges of one of several responses.
    fn response(&self, at: usize, next: &str, met: &Guard, out: &mut Process) {
        let location = self.location(at);
        let comment = format!("response {} of {}", at + 1, self.name);
        out.location(&location, LocationKind::Committed, comment);
        let (open, moves) = (self.open(at), self.moves());
        let is_last = at + 1 == self.responses.len();
        let onwards = |term: Term| {
            let value = if is_last { Term::from(0_usize) } else { term };
            moves.clone().set(value)
        };
        let mut add = |guards: Vec<Guard>, updates: Vec<Update>, comment: &str| {
            out.edge(Edge::new(&location, next, comment).when(all(guards)).with(updates));
        };
        let is_open = open.clone().at_least(1_usize);
        let is_closed = open.clone().is(0_usize);
        let comes = moves.clone().at_least(1_usize);
        let updates = vec![onwards(open.clone()), open.clone().set(0_usize)];
        add(vec![is_open.clone(), met.clone()], updates, "the oldest obligation moves on");
        let updates = vec![moves.clone().set(0_usize)];
        add(vec![is_open, met.negated()], updates, "the oldest obligation waits");
        let updates = vec![onwards(moves.clone())];
        add(vec![is_closed.clone(), comes.clone(), met.clone()], updates, "it moves on at once");
        let updates = vec![open.set(moves.clone()), moves.clone().set(0_usize)];
        add(vec![is_closed.clone(), comes, met.negated()], updates, "the obligation waits");
        add(vec![is_closed, moves.is(0_usize)], Vec::new(), "no obligation");
    }
}
