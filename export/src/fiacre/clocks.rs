//! The clocks of a network as what Fiacre has: intervals of transitions.
//!
//! A clock that one process resets whenever it enters a location, and compares there only, is the interval of
//! the location's transitions. Any other clock gets a process for each value that it is compared with. The
//! process notes in a variable that the value is reached (`>=`, `<`) or passed (`>`).

use std::collections::{BTreeMap, BTreeSet};

use crate::model::{
    ClockGuard, Edge, Guard, Location, LocationKind, Network, Process, Relation, Term, Update, all,
    any, var,
};
use crate::translate::Refusal;

/// An interval of time in base units. `None` as the second number means no upper bound.
pub(super) type Interval = (i64, Option<i64>);

/// Limit on the values for which the guards of a location are tried.
const MOST_VALUES: i64 = 4096;

/// An edge that compares no clock.
pub(super) struct Timed {
    pub(super) edge: Edge,
    /// Time after the source is entered; `None` if the edge depends on no clock.
    pub(super) interval: Option<Interval>,
}

/// A value that a clock is compared with.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Watch {
    pub(super) clock: String,
    pub(super) value: i64,
    /// The clock must be greater than the value, not at least the value.
    pub(super) is_strict: bool,
}

impl Watch {
    fn of(guard: &ClockGuard) -> Watch {
        let is_strict = guard.relation == Relation::Greater;
        Watch { clock: guard.clock.clone(), value: guard.value, is_strict }
    }

    fn name(&self, word: &str) -> String {
        let kind = if self.is_strict { "passed" } else { "reached" };
        format!("{word}{kind}_{}_{}", self.clock, self.value)
    }

    /// Returns the variable that is 1 once the value is reached or passed.
    pub(super) fn flag(&self) -> String {
        self.name("")
    }

    /// Returns the variable that is 1 from a reset of the clock until the process has seen the reset.
    pub(super) fn restart(&self) -> String {
        self.name("restart_")
    }

    /// Returns the name of the process.
    pub(super) fn process(&self) -> String {
        self.name("watch_")
    }
}

/// The clocks of a network.
pub(super) struct Clocks<'n> {
    network: &'n Network,
    /// Process of each clock that is an interval.
    own: BTreeMap<&'n str, &'n str>,
    pub(super) watches: BTreeSet<Watch>,
}

impl<'n> Clocks<'n> {
    pub(super) fn new(network: &'n Network) -> Clocks<'n> {
        let mut out = Clocks { network, own: BTreeMap::new(), watches: BTreeSet::new() };
        for clock in &network.clocks {
            let mut users =
                network.processes.iter().filter(|process| process.names_clock(&clock.name));
            if let (Some(only), None) = (users.next(), users.next())
                && is_reset_on_entry(only, &clock.name)
            {
                out.own.insert(&clock.name, &only.name);
            }
        }
        let edges = network.processes.iter().flat_map(|process| &process.edges);
        let guards = edges.flat_map(|edge| &edge.clocks);
        let watched = guards.filter(|guard| !out.own.contains_key(&*guard.clock));
        out.watches = watched.map(Watch::of).collect();
        out
    }

    /// Returns the locations and edges of a process without clocks.
    pub(super) fn without(
        &self,
        process: &Process,
    ) -> Result<(Vec<Location>, Vec<Timed>), Refusal> {
        let (mut locations, mut out) = (Vec::new(), Vec::new());
        for location in &process.locations {
            let place = || Some(format!("{}.{}", process.name, location.name));
            let own: Vec<&str> = compared(process, location)
                .into_iter()
                .filter(|clock| self.own.contains_key(clock))
                .collect();
            let [clock] = own[..] else {
                if location.invariant.is_some() || own.len() > 1 {
                    return Err(Refusal::new("clock that is not reset on entry", place()));
                }
                locations.push(location.clone());
                for edge in from(process, location) {
                    out.push(Timed { edge: self.converted(edge, location)?, interval: None });
                }
                continue;
            };
            let mut groups: BTreeMap<Interval, Vec<Edge>> = BTreeMap::new();
            for edge in from(process, location) {
                let interval = interval(location, edge, clock)
                    .ok_or_else(|| Refusal::new("guard that is not an interval", place()))?;
                groups.entry(interval).or_default().push(self.converted(edge, location)?);
            }
            locations.push(Location { invariant: None, ..location.clone() });
            for (interval, edges) in groups {
                self.after(interval, edges, location, (&mut locations, &mut out))?;
            }
        }
        Ok((locations, out))
    }

    /// Adds edges that follow an interval. Guards and synchronisations are examined at its end, in a location
    /// of their own: a change of a variable would restart the interval.
    fn after(
        &self,
        interval: Interval,
        edges: Vec<Edge>,
        location: &Location,
        (locations, out): (&mut Vec<Location>, &mut Vec<Timed>),
    ) -> Result<(), Refusal> {
        let interval = Some(interval);
        if edges.iter().all(|edge| edge.guard.is_true() && edge.sync.is_none()) {
            out.extend(edges.into_iter().map(|edge| Timed { edge, interval }));
            return Ok(());
        }
        if !self.always_holds(&any(edges.iter().map(|edge| edge.guard.clone()))) {
            let place = Some(location.name.clone());
            return Err(Refusal::new("time that ends while no guard holds", place));
        }
        let lower = interval.map_or(0, |(lower, _)| lower);
        let name = format!("due_{}_{lower}", location.name);
        let edge = Edge::new(&location.name, &name, "the time is over");
        out.push(Timed { edge, interval });
        let comment = format!("the time of {} is over", location.name);
        let due = Location {
            name: name.clone(),
            kind: LocationKind::Committed,
            comment,
            ..location.clone()
        };
        locations.push(Location { invariant: None, ..due });
        out.extend(edges.into_iter().map(|edge| {
            let edge = Edge { source: name.clone(), ..edge };
            Timed { edge, interval: None }
        }));
        Ok(())
    }

    /// Returns an edge whose comparisons of watched clocks are guards over their variables.
    fn converted(&self, edge: &Edge, location: &Location) -> Result<Edge, Refusal> {
        let mut out = edge.clone();
        out.updates.clear();
        for guard in std::mem::take(&mut out.clocks) {
            if self.own.contains_key(&*guard.clock) {
                continue;
            }
            let flag = var(&Watch::of(&guard).flag());
            let is_lazy = location.kind == LocationKind::Normal;
            let condition = match guard.relation {
                Relation::AtLeast => flag.is(1_usize),
                Relation::Less => flag.is(0_usize),
                Relation::Greater if is_lazy => flag.is(1_usize),
                relation => {
                    let construct = format!("{} {} {}", guard.clock, relation.text(), guard.value);
                    return Err(Refusal::new(&construct, Some(location.name.clone())));
                }
            };
            out.guard = all([out.guard, condition]);
        }
        for update in &edge.updates {
            match update {
                Update::Set(..) => out.updates.push(update.clone()),
                Update::Reset(clock) => {
                    let watches = self.watches.iter().filter(|watch| watch.clock == *clock);
                    out.updates.extend(watches.map(|watch| var(&watch.restart()).set(1_usize)));
                }
            }
        }
        Ok(out)
    }

    /// Returns true if a condition over single variables holds for all their values.
    fn always_holds(&self, condition: &Guard) -> bool {
        let known = &self.network.variables;
        let used: Vec<_> =
            known.iter().filter(|variable| uses(condition, &variable.name)).collect();
        let most = used.iter().map(|variable| variable.most + 1).try_fold(1, i64::checked_mul);
        let Some(most) = most.filter(|&most| most <= MOST_VALUES) else { return false };
        (0..most).all(|number| {
            let mut rest = number;
            let values: BTreeMap<&str, i64> = (used.iter())
                .map(|variable| {
                    let value = rest % (variable.most + 1);
                    rest /= variable.most + 1;
                    (&*variable.name, value)
                })
                .collect();
            holds(condition, &values) == Some(true)
        })
    }
}

/// Returns the edges of a location.
fn from<'p>(process: &'p Process, location: &Location) -> impl Iterator<Item = &'p Edge> {
    let name = location.name.clone();
    process.edges.iter().filter(move |edge| edge.source == name)
}

/// Returns the clocks that a location and its edges compare.
fn compared<'p>(process: &'p Process, location: &'p Location) -> BTreeSet<&'p str> {
    let guards = from(process, location).flat_map(|edge| &edge.clocks);
    let invariant = location.invariant.iter().map(|(clock, _)| &**clock);
    guards.map(|guard| &*guard.clock).chain(invariant).collect()
}

/// Returns true if a clock is 0 whenever a location that compares the clock is entered.
fn is_reset_on_entry(process: &Process, clock: &str) -> bool {
    let mut comparing =
        process.locations.iter().filter(|location| compared(process, location).contains(clock));
    comparing.all(|location| {
        let mut entering = process.edges.iter().filter(|edge| edge.target == location.name);
        location.kind == LocationKind::Normal && entering.all(|edge| edge.resets(clock))
    })
}

/// Returns the times at which an edge of a location can be taken.
fn interval(location: &Location, edge: &Edge, clock: &str) -> Option<Interval> {
    let most = location.invariant.as_ref().map(|(_, most)| *most);
    let mut guards = edge.clocks.iter().filter(|guard| guard.clock == clock);
    let (guard, second) = (guards.next(), guards.next());
    let interval = match guard.map(|guard| (guard.relation, guard.value)) {
        None => (0, most),
        Some((Relation::AtLeast, value)) => (value, most),
        Some((Relation::Equal, value)) => (value, Some(value)),
        Some(_) => return None,
    };
    let is_inside =
        interval.1.is_none_or(|end| end >= interval.0 && most.is_none_or(|most| end <= most));
    (second.is_none() && is_inside).then_some(interval)
}

/// Returns true if a condition reads a variable.
fn uses(condition: &Guard, name: &str) -> bool {
    match condition {
        Guard::Compare(left, _, right) => reads(left, name) || reads(right, name),
        Guard::And(list) | Guard::Or(list) => list.iter().any(|part| uses(part, name)),
    }
}

/// Returns true if a term reads a variable.
pub(super) fn reads(term: &Term, name: &str) -> bool {
    match term {
        Term::Number(_) => false,
        Term::Variable(variable) => variable == name,
        Term::Element(array, index) => array == name || reads(index, name),
        Term::Sum(of, _) => reads(of, name),
        Term::If(condition, yes, no) => {
            uses(condition, name) || reads(yes, name) || reads(no, name)
        }
    }
}

/// Returns true if an edge's guard or updates name a variable.
pub(super) fn names(edge: &Edge, name: &str) -> bool {
    let updates = edge.updates.iter();
    let mut sets = updates.filter_map(|update| match update {
        Update::Set(target, value) => Some((target, value)),
        Update::Reset(_) => None,
    });
    uses(&edge.guard, name) || sets.any(|(target, value)| reads(target, name) || reads(value, name))
}

/// Returns the truth of a condition for values of its variables; `None` if a variable has no value.
fn holds(condition: &Guard, values: &BTreeMap<&str, i64>) -> Option<bool> {
    Some(match condition {
        Guard::Compare(left, relation, right) => {
            let (left, right) = (value(left, values)?, value(right, values)?);
            relation.holds(left, right)
        }
        Guard::And(list) => {
            let parts: Option<Vec<bool>> = list.iter().map(|part| holds(part, values)).collect();
            parts?.into_iter().all(|part| part)
        }
        Guard::Or(list) => {
            let parts: Option<Vec<bool>> = list.iter().map(|part| holds(part, values)).collect();
            parts?.into_iter().any(|part| part)
        }
    })
}

fn value(term: &Term, values: &BTreeMap<&str, i64>) -> Option<i64> {
    match term {
        Term::Number(number) => Some(*number),
        Term::Variable(name) => values.get(&**name).copied(),
        Term::Sum(of, number) => Some(value(of, values)? + number),
        // An array has no single value.
        Term::Element(..) | Term::If(..) => None,
    }
}
