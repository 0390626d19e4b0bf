//! Networks of timed automata, as far as both UPPAAL and TChecker know them.
//!
//! A network has processes that share bounded integers and clocks. An edge has a guard over integers, a guard
//! over clocks, at most one synchronisation of two processes, and updates that are performed in order. There
//! are no functions, no broadcasts, no urgent channels and no priorities: *urgent* locations stop time,
//! *committed* ones also stop every process that is not in a committed location.

use std::collections::{BTreeMap, BTreeSet};

use dotgen_timing::explore::Action;

/// A network of timed automata.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Network {
    /// Name of the system: that of the scenario.
    pub name: String,
    /// Lines of the head comment.
    pub header: Vec<String>,
    /// Length of the base unit of time; `None` if it is not a whole number of nanoseconds.
    pub nanoseconds: Option<i64>,
    pub variables: Vec<Variable>,
    pub clocks: Vec<Clock>,
    /// Channels, each with a comment. A channel synchronises exactly two processes.
    pub channels: Vec<(String, String)>,
    pub processes: Vec<Process>,
    pub queries: Vec<Query>,
}

/// A bounded integer, or an array of bounded integers, that all processes share. It begins with its least
/// value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    pub name: String,
    /// Number of elements; `None` for a single integer.
    pub size: Option<usize>,
    /// Greatest value; the least is 0.
    pub most: i64,
    /// Meaning of the values.
    pub comment: String,
}

/// A clock, which begins at 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clock {
    pub name: String,
    /// Meaning.
    pub comment: String,
}

/// A process: an automaton of its own, with one instance.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Process {
    pub name: String,
    /// Meaning, with the place of the declaration.
    pub comment: String,
    /// Locations; the first is initial.
    pub locations: Vec<Location>,
    pub edges: Vec<Edge>,
}

/// A location of a process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    pub name: String,
    pub kind: LocationKind,
    /// Clock that must not exceed a value, in base units, while the process is here.
    pub invariant: Option<(String, i64)>,
    /// The location is the failure, or the witness, of a query.
    pub is_goal: bool,
    /// Meaning, with a place in a specification if there is one.
    pub comment: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LocationKind {
    /// Time may pass.
    Normal,
    /// No time passes.
    Urgent,
    /// No time passes, and processes in other locations do nothing by themselves.
    Committed,
}

/// An edge of a process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edge {
    pub source: String,
    pub target: String,
    /// Condition over integers.
    pub guard: Guard,
    /// Comparisons of clocks, all of which must hold.
    pub clocks: Vec<ClockGuard>,
    /// Synchronisation; `None` if the process acts alone.
    pub sync: Option<Sync>,
    /// Updates, in order.
    pub updates: Vec<Update>,
    /// Action of the verifier that begins with the edge. The edges that follow through committed locations
    /// are parts of the action.
    pub action: Option<Action>,
    /// Meaning.
    pub comment: String,
}

/// One end of a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sync {
    /// Its updates come first.
    Send(String),
    Receive(String),
}

/// Comparison of a clock with a number of base units.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClockGuard {
    pub clock: String,
    pub relation: Relation,
    pub value: i64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    Equal,
    NotEqual,
    Less,
    AtLeast,
    Greater,
}

impl Relation {
    /// Returns the operator, which is the same in both languages.
    pub fn text(self) -> &'static str {
        match self {
            Relation::Equal => "==",
            Relation::NotEqual => "!=",
            Relation::Less => "<",
            Relation::AtLeast => ">=",
            Relation::Greater => ">",
        }
    }

    /// Returns true if the comparison of two numbers holds.
    pub fn holds(self, left: i64, right: i64) -> bool {
        match self {
            Relation::Equal => left == right,
            Relation::NotEqual => left != right,
            Relation::Less => left < right,
            Relation::AtLeast => left >= right,
            Relation::Greater => left > right,
        }
    }
}

/// Condition over integers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Guard {
    Compare(Term, Relation, Term),
    /// All of them hold; true if there is none.
    And(Vec<Guard>),
    /// Some of them hold; false if there is none.
    Or(Vec<Guard>),
}

/// Integer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Term {
    Number(i64),
    Variable(String),
    /// An element of an array.
    Element(String, Box<Term>),
    Sum(Box<Term>, i64),
    /// The first term if the condition holds, else the second.
    If(Box<Guard>, Box<Term>, Box<Term>),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Update {
    /// Sets a variable or an element.
    Set(Term, Term),
    /// Sets a clock to 0.
    Reset(String),
}

/// A question to the tool.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Query {
    /// Number of the check among those of the system, from 0.
    pub check: usize,
    /// Kind and subject of the check, after its name if it has one.
    pub name: String,
    /// The answer that confirms the check, and what it means.
    pub comment: Vec<String>,
    pub kind: QueryKind,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum QueryKind {
    /// A location that must never be reached.
    Never { process: String, location: String },
    /// A location that must be reachable.
    Reachable { process: String, location: String },
    /// Some action always follows, now or later, while a process is in a location.
    Lively { process: String, location: String },
    /// The greatest value of each clock while its condition holds.
    Greatest(Vec<(Guard, String)>),
}

impl Network {
    /// Removes the edges that no other process can synchronise with, and channels without edges. Tools
    /// differ: one blocks such an edge, another one lets its process act alone.
    pub(crate) fn drop_unmatched(&mut self) {
        // By channel, the processes that send, and those that receive.
        let mut ends: BTreeMap<String, [BTreeSet<usize>; 2]> = BTreeMap::new();
        for (number, process) in self.processes.iter().enumerate() {
            for sync in process.edges.iter().filter_map(|edge| edge.sync.as_ref()) {
                let (Sync::Send(channel) | Sync::Receive(channel)) = sync;
                let receives = usize::from(matches!(sync, Sync::Receive(_)));
                ends.entry(channel.clone()).or_default()[receives].insert(number);
            }
        }
        for (number, process) in self.processes.iter_mut().enumerate() {
            process.edges.retain(|edge| {
                let (channel, others) = match &edge.sync {
                    None => return true,
                    Some(Sync::Send(channel)) => (channel, 1),
                    Some(Sync::Receive(channel)) => (channel, 0),
                };
                ends[channel][others].iter().any(|&other| other != number)
            });
        }
        let edges = self.processes.iter().flat_map(|process| &process.edges);
        let used: BTreeSet<String> = edges
            .filter_map(|edge| match edge.sync.as_ref()? {
                Sync::Send(channel) | Sync::Receive(channel) => Some(channel.clone()),
            })
            .collect();
        self.channels.retain(|(channel, _)| used.contains(channel));
    }
}

impl Query {
    /// Returns the process and the location that answer the query when they are reached, and whether the
    /// check holds then; `None` if the query is not about a location.
    pub fn goal(&self) -> Option<(&str, &str, bool)> {
        match &self.kind {
            QueryKind::Never { process, location } => Some((process, location, false)),
            QueryKind::Reachable { process, location } => Some((process, location, true)),
            QueryKind::Greatest(_) | QueryKind::Lively { .. } => None,
        }
    }
}

impl Guard {
    /// The condition that always holds.
    pub fn always() -> Guard {
        Guard::And(Vec::new())
    }

    /// Returns the negation.
    pub fn negated(&self) -> Guard {
        match self {
            Guard::Compare(left, relation, right) => {
                let (left, right) = (left.clone(), right.clone());
                match relation {
                    Relation::Equal => Guard::Compare(left, Relation::NotEqual, right),
                    Relation::NotEqual => Guard::Compare(left, Relation::Equal, right),
                    Relation::Less => Guard::Compare(left, Relation::AtLeast, right),
                    Relation::AtLeast => Guard::Compare(left, Relation::Less, right),
                    Relation::Greater => Guard::Compare(right, Relation::AtLeast, left),
                }
            }
            Guard::And(all) => any(all.iter().map(Guard::negated)),
            Guard::Or(all) => self::all(all.iter().map(Guard::negated)),
        }
    }

    /// Returns true if the condition always holds.
    pub fn is_true(&self) -> bool {
        matches!(self, Guard::And(all) if all.is_empty())
    }
}

/// Returns the conjunction, without conjunctions as its direct parts.
pub fn all(guards: impl IntoIterator<Item = Guard>) -> Guard {
    let mut out = Vec::new();
    for guard in guards {
        match guard {
            Guard::And(inner) => out.extend(inner),
            Guard::Or(inner) if inner.is_empty() => return Guard::Or(inner),
            other => out.push(other),
        }
    }
    match <[Guard; 1]>::try_from(out) {
        Ok([only]) => only,
        Err(several) => Guard::And(several),
    }
}

/// Returns the disjunction, without disjunctions as its direct parts.
pub fn any(guards: impl IntoIterator<Item = Guard>) -> Guard {
    let mut out = Vec::new();
    for guard in guards {
        match guard {
            Guard::Or(inner) => out.extend(inner),
            other if other.is_true() => return Guard::always(),
            other => out.push(other),
        }
    }
    match <[Guard; 1]>::try_from(out) {
        Ok([only]) => only,
        Err(several) => Guard::Or(several),
    }
}

impl From<i64> for Term {
    fn from(number: i64) -> Term {
        Term::Number(number)
    }
}

impl From<usize> for Term {
    fn from(number: usize) -> Term {
        Term::Number(number as i64)
    }
}

impl From<&str> for Term {
    fn from(name: &str) -> Term {
        Term::Variable(name.to_owned())
    }
}

impl From<&String> for Term {
    fn from(name: &String) -> Term {
        Term::Variable(name.clone())
    }
}

impl Term {
    /// Returns an element of an array.
    pub fn element(array: &str, index: impl Into<Term>) -> Term {
        Term::Element(array.to_owned(), Box::new(index.into()))
    }

    /// Returns the term plus a number.
    pub fn plus(self, number: i64) -> Term {
        Term::Sum(Box::new(self), number)
    }

    pub fn is(self, value: impl Into<Term>) -> Guard {
        Guard::Compare(self, Relation::Equal, value.into())
    }

    pub fn is_not(self, value: impl Into<Term>) -> Guard {
        Guard::Compare(self, Relation::NotEqual, value.into())
    }

    pub fn at_least(self, value: impl Into<Term>) -> Guard {
        Guard::Compare(self, Relation::AtLeast, value.into())
    }

    pub fn below(self, value: impl Into<Term>) -> Guard {
        Guard::Compare(self, Relation::Less, value.into())
    }

    /// Returns the update that gives the variable or element a value.
    pub fn set(self, value: impl Into<Term>) -> Update {
        Update::Set(self, value.into())
    }

    /// Returns the update that gives the variable or element 1 if a condition holds, else 0.
    pub fn set_to(self, condition: Guard) -> Update {
        let (yes, no) = (Box::new(1_usize.into()), Box::new(0_usize.into()));
        Update::Set(self, Term::If(Box::new(condition), yes, no))
    }

    /// Returns the update that gives the variable or element a value if a condition holds.
    pub fn set_if(self, condition: Guard, value: impl Into<Term>) -> Update {
        let old = Box::new(self.clone());
        Update::Set(self, Term::If(Box::new(condition), Box::new(value.into()), old))
    }
}

/// Returns the variable of a name.
pub fn var(name: &str) -> Term {
    name.into()
}

impl Edge {
    /// Returns an edge without guard, synchronisation and updates.
    pub fn new(source: &str, target: &str, comment: impl Into<String>) -> Edge {
        Edge {
            source: source.to_owned(),
            target: target.to_owned(),
            guard: Guard::always(),
            clocks: Vec::new(),
            sync: None,
            updates: Vec::new(),
            action: None,
            comment: comment.into(),
        }
    }

    pub fn when(mut self, guard: Guard) -> Edge {
        self.guard = all([self.guard, guard]);
        self
    }

    /// Adds the comparison of a clock with a number of base units.
    pub fn when_clock(mut self, clock: &str, relation: Relation, value: impl Into<i64>) -> Edge {
        // A clock is never negative.
        let value = value.into();
        if value > 0 || relation != Relation::AtLeast {
            self.clocks.push(ClockGuard { clock: clock.to_owned(), relation, value });
        }
        self
    }

    /// Returns true if an update sets a clock to 0.
    pub fn resets(&self, clock: &str) -> bool {
        self.updates.iter().any(|update| matches!(update, Update::Reset(name) if name == clock))
    }

    pub fn sends(mut self, channel: &str) -> Edge {
        self.sync = Some(Sync::Send(channel.to_owned()));
        self
    }

    pub fn receives(mut self, channel: &str) -> Edge {
        self.sync = Some(Sync::Receive(channel.to_owned()));
        self
    }

    pub fn with(mut self, updates: impl IntoIterator<Item = Update>) -> Edge {
        self.updates.extend(updates);
        self
    }

    /// Sets the action of the verifier that begins with the edge.
    pub fn begins(mut self, action: Action) -> Edge {
        self.action = Some(action);
        self
    }
}

impl Process {
    /// Returns a process without locations.
    pub fn new(name: &str, comment: impl Into<String>) -> Process {
        Process { name: name.to_owned(), comment: comment.into(), ..Process::default() }
    }

    /// Adds a location.
    pub fn location(&mut self, name: &str, kind: LocationKind, comment: impl Into<String>) {
        self.locations.push(Location {
            name: name.to_owned(),
            kind,
            invariant: None,
            is_goal: false,
            comment: comment.into(),
        });
    }

    /// Adds a location in which a clock must not exceed a value, if there is one, in base units.
    pub fn bounded(
        &mut self,
        name: &str,
        clock: &str,
        most: Option<i64>,
        comment: impl Into<String>,
    ) {
        self.location(name, LocationKind::Normal, comment);
        if let (Some(most), Some(location)) = (most, self.locations.last_mut()) {
            location.invariant = Some((clock.to_owned(), most));
        }
    }

    /// Returns true if an invariant or an edge compares or resets a clock.
    pub fn names_clock(&self, clock: &str) -> bool {
        let mut invariants =
            self.locations.iter().filter_map(|location| location.invariant.as_ref());
        invariants.any(|(name, _)| name == clock)
            || self.edges.iter().any(|edge| {
                edge.resets(clock) || edge.clocks.iter().any(|guard| guard.clock == clock)
            })
    }

    /// Adds an edge.
    pub fn edge(&mut self, edge: Edge) {
        self.edges.push(edge);
    }
}
