//! A trace, followed in the network: each transition is an edge, or two edges of a channel, whose guards
//! hold.

use std::collections::HashMap;

use super::times::{Constraint, Followed, Taken};
use super::{Error, Goal, Moved, State, Transition, Written};
use crate::model::{Edge, Guard, LocationKind, Network, Process, Relation, Sync, Term, Update};

/// Values of integers; those that are not an array have one element.
type Values<'n> = HashMap<&'n str, Vec<i64>>;

struct Follower<'n> {
    network: &'n Network,
    /// Number of each process.
    numbers: HashMap<&'n str, usize>,
    /// Index of the location of each process.
    at: Vec<usize>,
    values: Values<'n>,
    most: HashMap<&'n str, i64>,
    /// Last transition that has set each clock to 0.
    resets: HashMap<&'n str, usize>,
    out: Followed,
}

/// Follows a trace in a network.
pub(super) fn follow(network: &Network, written: &Written) -> Result<Followed, Error> {
    let names = network.processes.iter().map(|process| &*process.name);
    let variables = network.variables.iter();
    let initial = |variable: &crate::model::Variable| vec![0; variable.size.unwrap_or(1)];
    let mut follower = Follower {
        network,
        numbers: names.enumerate().map(|(number, name)| (name, number)).collect(),
        at: vec![0; network.processes.len()],
        values: variables.clone().map(|variable| (&*variable.name, initial(variable))).collect(),
        most: variables.map(|variable| (&*variable.name, variable.most)).collect(),
        resets: network.clocks.iter().map(|clock| (&*clock.name, 0)).collect(),
        out: Followed::default(),
    };
    let first = written.states.first().ok_or_else(|| Error::new("the trace has no state"))?;
    let at = follower.locations(first)?;
    if let Some(number) = (0..at.len()).find(|&number| at[number] != 0) {
        let process = &network.processes[number];
        let (name, first) = (&process.name, &process.locations[0].name);
        return Err(Error::at(
            written.states[0].line,
            format!("`{name}` begins in `{first}` in the model"),
        ));
    }
    follower.compare(first, &follower.values)?;
    follower.settle();
    for (number, transition) in written.transitions.iter().enumerate() {
        follower.step(number + 1, transition, &written.states[number + 1])?;
        follower.settle();
    }
    let reached = network.queries.iter().find_map(|query| {
        let (process, location, holds) = query.goal()?;
        let number = *follower.numbers.get(process)?;
        let is_there = follower.location(number).name == location;
        is_there.then(|| Goal { check: query.check, name: query.name.clone(), holds })
    });
    follower.out.end = reached;
    Ok(follower.out)
}

impl<'n> Follower<'n> {
    fn process(&self, number: usize) -> &'n Process {
        &self.network.processes[number]
    }

    fn location(&self, number: usize) -> &'n crate::model::Location {
        &self.process(number).locations[self.at[number]]
    }

    /// Returns the indices of the locations of a state.
    fn locations(&self, state: &State) -> Result<Vec<usize>, Error> {
        let processes = &self.network.processes;
        if state.locations.len() != processes.len() {
            let (has, wanted) = (state.locations.len(), processes.len());
            let message = format!("{has} locations, but the model has {wanted} processes");
            return Err(Error::at(state.line, message));
        }
        let locations = processes.iter().zip(&state.locations).map(|(process, written)| {
            let name = match written.split_once('.') {
                Some((owner, name)) if owner == process.name => Some(name),
                Some(_) => None,
                None => Some(*written),
            };
            let index = process.locations.iter().position(|location| Some(&*location.name) == name);
            index.ok_or_else(|| {
                let message =
                    format!("`{written}` is not a location of `{}` in the model", process.name);
                Error::at(state.line, message)
            })
        });
        locations.collect()
    }

    /// Compares the values of a state with those of the network.
    fn compare(&self, state: &State, values: &Values) -> Result<(), Error> {
        // `#depth`, and the clock `t(0)` that is always 0.
        let is_other = |name: &str| name.starts_with('#') || name == "t(0)";
        let is_clock = |name: &str| is_other(name) || self.resets.contains_key(name);
        for &(name, written) in &state.values {
            let (base, index) = name.split_once('[').unwrap_or((name, "0]"));
            let index = index.strip_suffix(']').and_then(|index| index.parse::<usize>().ok());
            let value = index.and_then(|index| values.get(base)?.get(index));
            match value {
                Some(value) if written.parse() == Ok(*value) => {}
                Some(value) => {
                    let message = format!("`{name}` is {written}, but {value} in the model");
                    return Err(Error::at(state.line, message));
                }
                None if name.split('-').all(is_clock) => {}
                None => {
                    return Err(Error::at(state.line, format!("`{name}` is not in the model")));
                }
            }
        }
        Ok(())
    }

    /// Notes the conditions on the time after a transition.
    fn settle(&mut self) {
        let all = 0..self.at.len();
        let stops =
            { all.clone() }.any(|number| self.location(number).kind != LocationKind::Normal);
        self.out.stops.push(stops);
        // Without time, nothing changes after the entry.
        let now = self.out.stops.len() - 1;
        let until = if stops { now } else { now + 1 };
        let invariants = all.filter_map(|number| self.location(number).invariant.as_ref());
        let constraint = |(clock, most): &(String, i64)| {
            Constraint::at_most(self.resets[&**clock], until, *most)
        };
        let constraints: Vec<Constraint> = invariants.map(constraint).collect();
        self.out.constraints.extend(constraints);
    }

    /// Takes a transition to a state.
    fn step(&mut self, number: usize, transition: &Transition, to: &State) -> Result<(), Error> {
        let at = self.locations(to)?;
        let mut moved = Vec::new();
        for edge in &transition.edges {
            let process =
                self.numbers.get(edge.process).copied().filter(|process| !moved.contains(process));
            let process = process.ok_or_else(|| {
                let message = format!("`{}` is not another process of the model", edge.process);
                Error::at(transition.line, message)
            })?;
            moved.push(process);
        }
        let stays = |process: usize| moved.contains(&process) || self.at[process] == at[process];
        if let Some(other) = (0..at.len()).find(|&process| !stays(process)) {
            let message = format!("`{}` moves without a transition", self.process(other).name);
            return Err(Error::at(to.line, message));
        }
        self.out.lines.push(transition.line);
        if moved.is_empty() {
            return self.compare(to, &self.values);
        }
        let is_committed = |process: usize| self.location(process).kind == LocationKind::Committed;
        if (0..at.len()).any(is_committed) && !moved.iter().any(|&process| is_committed(process)) {
            let message = "a process in a committed location must move first";
            return Err(Error::at(transition.line, message));
        }
        let chosen = self.choose(transition, &moved, &at, to)?;
        let words = self.words(transition, &moved, &at);
        for edge in &chosen.edges {
            for guard in &edge.clocks {
                self.out.clock(number, self.resets[&*guard.clock], guard.relation, guard.value);
            }
        }
        for edge in chosen.edges {
            for update in &edge.updates {
                if let Update::Reset(clock) = update {
                    self.resets.insert(clock, number);
                }
            }
            if let Some(action) = edge.action {
                let line = transition.line;
                self.out.actions.push(Taken {
                    transition: number,
                    line,
                    action,
                    words: words.clone(),
                });
            }
        }
        self.at = at;
        self.values = chosen.values;
        Ok(())
    }

    /// Returns the edges of a transition to a state, and the values after them.
    fn choose(
        &self,
        transition: &Transition,
        moved: &[usize],
        at: &[usize],
        to: &State,
    ) -> Result<Choice<'n>, Error> {
        let edges: Vec<Vec<&Edge>> = (transition.edges.iter().zip(moved))
            .map(|(written, &process)| self.candidates(written, process, at[process]))
            .collect();
        let sets: Vec<Vec<&Edge>> = match &edges[..] {
            [alone] => {
                alone.iter().filter(|edge| edge.sync.is_none()).map(|edge| vec![*edge]).collect()
            }
            [one, other] => {
                let pairs =
                    one.iter().flat_map(|one| other.iter().map(move |other| (*one, *other)));
                pairs.filter_map(|(one, other)| synchronised(one, other)).collect()
            }
            _ => Vec::new(),
        };
        let mut fit: Vec<Choice> = Vec::new();
        let mut differs = None;
        for edges in sets {
            let Some(values) = self.after(&edges) else { continue };
            match self.compare(to, &values) {
                Ok(()) => fit.push(Choice { edges, values }),
                Err(error) => differs = Some(error),
            }
        }
        let words = || self.words(transition, moved, at);
        // Of edges with one effect, the clock that began first allows the earliest times.
        fit.sort_by_key(|choice| {
            choice
                .edges
                .iter()
                .flat_map(|edge| &edge.clocks)
                .map(|guard| self.resets[&*guard.clock])
                .sum::<usize>()
        });
        match &fit[..] {
            [] => Err(differs.unwrap_or_else(|| {
                let message = format!("the model has no transition {} here", words());
                Error::at(transition.line, message)
            })),
            [first, rest @ ..] if rest.iter().any(|other| other.values != first.values) => {
                let message = format!(
                    "several transitions {} fit: the values of integers are missing",
                    words()
                );
                Err(Error::at(to.line, message))
            }
            _ => Ok(fit.swap_remove(0)),
        }
    }

    /// Returns the edges of a process to a location whose guards hold.
    fn candidates(&self, written: &Moved, process: usize, to: usize) -> Vec<&'n Edge> {
        let (source, target) =
            (&*self.location(process).name, &*self.process(process).locations[to].name);
        let is_same = written.between.is_none_or(|between| between == (source, target));
        let edges = self.process(process).edges.iter();
        edges
            .filter(|edge| is_same && edge.source == source && edge.target == target)
            .filter(|edge| match (&edge.sync, written.event) {
                (Some(Sync::Send(name) | Sync::Receive(name)), Some(event)) => name == event,
                (None, Some(event)) => event == crate::tchecker::ALONE,
                (_, None) => true,
            })
            .filter(|edge| holds(&edge.guard, &self.values) == Some(true))
            .collect()
    }

    /// Returns the values after edges; `None` if one is out of range.
    fn after(&self, edges: &[&'n Edge]) -> Option<Values<'n>> {
        let mut values = self.values.clone();
        for update in edges.iter().flat_map(|edge| &edge.updates) {
            let Update::Set(target, value) = update else { continue };
            let value = number(value, &values)?;
            let (name, index) = match target {
                Term::Variable(name) => (name, 0),
                Term::Element(name, index) => {
                    (name, usize::try_from(number(index, &values)?).ok()?)
                }
                _ => return None,
            };
            let range = 0..=*self.most.get(&**name)?;
            *values.get_mut(&**name)?.get_mut(index)? = range.contains(&value).then_some(value)?;
        }
        Some(values)
    }

    /// Returns a transition in words.
    fn words(&self, transition: &Transition, moved: &[usize], at: &[usize]) -> String {
        let edge = |&process: &usize| {
            let Process { name, locations, .. } = self.process(process);
            format!("`{name}: {} -> {}`", self.location(process).name, locations[at[process]].name)
        };
        let edges: Vec<String> = moved.iter().map(edge).collect();
        let event = transition.edges.iter().find_map(|edge| edge.event);
        let event = event.map_or(String::new(), |event| format!(" with `{event}`"));
        format!("{}{event}", edges.join(" and "))
    }
}

/// Edges, the sender first, and the values after them.
struct Choice<'n> {
    edges: Vec<&'n Edge>,
    values: Values<'n>,
}

/// Returns two edges of one channel, the sender first.
fn synchronised<'n>(one: &'n Edge, other: &'n Edge) -> Option<Vec<&'n Edge>> {
    match (&one.sync, &other.sync) {
        (Some(Sync::Send(sent)), Some(Sync::Receive(received))) if sent == received => {
            Some(vec![one, other])
        }
        (Some(Sync::Receive(received)), Some(Sync::Send(sent))) if sent == received => {
            Some(vec![other, one])
        }
        _ => None,
    }
}

/// Returns the value of a condition; `None` if an index is out of range.
fn holds(guard: &Guard, values: &Values) -> Option<bool> {
    match guard {
        Guard::Compare(left, relation, right) => {
            Some(relation.holds(number(left, values)?, number(right, values)?))
        }
        Guard::And(all) => {
            for part in all {
                if !holds(part, values)? {
                    return Some(false);
                }
            }
            Some(true)
        }
        Guard::Or(some) => {
            for part in some {
                if holds(part, values)? {
                    return Some(true);
                }
            }
            Some(false)
        }
    }
}

/// Returns the value of a term; `None` if an index is out of range.
fn number(term: &Term, values: &Values) -> Option<i64> {
    match term {
        Term::Number(number) => Some(*number),
        Term::Variable(name) => values.get(&**name)?.first().copied(),
        Term::Element(name, index) => {
            let index = usize::try_from(number(index, values)?).ok()?;
            values.get(&**name)?.get(index).copied()
        }
        Term::Sum(left, more) => number(left, values)?.checked_add(*more),
        Term::If(condition, yes, no) => {
            number(if holds(condition, values)? { yes } else { no }, values)
        }
    }
}

impl Followed {
    /// Notes the guard of a clock that was reset by a transition.
    fn clock(&mut self, now: usize, reset: usize, relation: Relation, value: i64) {
        let (least, most) = match relation {
            Relation::Equal => (Some(value), Some(value)),
            Relation::Less => (None, Some(value - 1)),
            Relation::AtLeast => (Some(value), None),
            Relation::Greater => (Some(value + 1), None),
            // No edge of an exported network has this guard.
            Relation::NotEqual => (None, None),
        };
        self.constraints.extend(least.map(|least| Constraint::at_least(reset, now, least)));
        self.constraints.extend(most.map(|most| Constraint::at_most(reset, now, most)));
    }
}
