//! The atoms and interactions of a BIP program.

use std::collections::{BTreeMap, BTreeSet};

use super::scalars;
use crate::model::{
    Edge, Guard, Location, LocationKind, Network, Process, Relation, Sync, Update, var,
};
use crate::translate::Refusal;
use crate::uppaal::{operand, term};

/// Number of processes in committed locations.
pub(super) const COMMITTED: &str = "committed";

/// Clock of an atom that is 0 where no time passes.
pub(super) const NOW: &str = "now";

/// A transition of an atom.
pub(super) struct Transition {
    pub(super) port: String,
    pub(super) source: String,
    pub(super) target: String,
    /// All of them hold.
    pub(super) conditions: Vec<String>,
    pub(super) urgency: &'static str,
    pub(super) updates: Vec<String>,
    pub(super) comment: String,
}

/// The atom of a process.
pub(super) struct Machine<'n> {
    pub(super) process: &'n Process,
    /// Own clocks, with their meaning.
    pub(super) clocks: Vec<(&'n str, &'n str)>,
    /// Ports, without repetition.
    pub(super) ports: Vec<String>,
    /// By the edges of the process.
    pub(super) transitions: Vec<Transition>,
    /// Places in which a clock must not exceed a value, in the unit of the clocks.
    pub(super) invariants: Vec<(&'n str, &'n str, i64)>,
}

/// A connector: ports of one process or two, and of the store.
pub(super) struct Interaction<'n> {
    /// Name, which is that of the port of the store.
    pub(super) name: String,
    /// Process and port; the sender first.
    pub(super) parts: Vec<(&'n str, String)>,
    /// The transition of the store.
    pub(super) transition: Transition,
}

/// A BIP program.
pub(super) struct Plan<'n> {
    pub(super) network: &'n Network,
    /// Unit of all clocks.
    pub(super) unit: &'static str,
    /// Units of a base unit of the network.
    factor: i64,
    pub(super) machines: Vec<Machine<'n>>,
    /// Clocks of the store, with their meaning.
    pub(super) clocks: Vec<(&'n str, &'n str)>,
    /// Number of processes that begin in a committed location.
    pub(super) committed: usize,
    pub(super) interactions: Vec<Interaction<'n>>,
}

impl<'n> Plan<'n> {
    pub(super) fn new(network: &'n Network) -> Result<Plan<'n>, Vec<Refusal>> {
        let Some((unit, factor)) = unit(network) else {
            return Err(vec![Refusal::new("a unit below 1 ns (no clock of BIP has one)", None)]);
        };
        let owners = |clock: &str| {
            network.processes.iter().filter(|process| process.names_clock(clock)).count()
        };
        let (mut own, mut clocks) = (Vec::new(), Vec::new());
        for clock in &network.clocks {
            let list = if owners(&clock.name) == 1 { &mut own } else { &mut clocks };
            list.push((&*clock.name, &*clock.comment));
        }
        let refusals = refusals(network, &clocks);
        if !refusals.is_empty() {
            return Err(refusals);
        }
        let first = |process: &&Process| {
            process.locations.first().is_some_and(|location| is(location, LocationKind::Committed))
        };
        let committed = network.processes.iter().filter(first).count();
        let (machines, interactions) = (Vec::new(), Vec::new());
        let mut out = Plan { network, unit, factor, machines, clocks, committed, interactions };
        for process in &network.processes {
            let clocks = own.iter().filter(|(clock, _)| process.names_clock(clock));
            let machine = out.machine(process, clocks.copied().collect());
            out.machines.push(machine);
        }
        out.interactions = out.interactions();
        Ok(out)
    }

    fn is_shared(&self, clock: &str) -> bool {
        self.clocks.iter().any(|(name, _)| *name == clock)
    }

    /// Returns the comparisons of an edge with the clocks of the store, or with those of its process.
    fn clock_conditions(&self, edge: &Edge, shared: bool) -> Vec<String> {
        let own = edge.clocks.iter().filter(|guard| self.is_shared(&guard.clock) == shared);
        let text = own.map(|guard| {
            format!("{} {} {}", guard.clock, guard.relation.text(), guard.value * self.factor)
        });
        text.collect()
    }

    fn resets(&self, edge: &Edge, shared: bool) -> Vec<String> {
        let resets = edge.updates.iter().filter_map(|update| match update {
            Update::Reset(clock) if self.is_shared(clock) == shared => {
                Some(format!("{clock} = 0;"))
            }
            _ => None,
        });
        resets.collect()
    }

    /// Returns the atom of a process. A place in which no time passes has an invariant over a clock that is
    /// reset on entry.
    fn machine(&self, process: &'n Process, mut clocks: Vec<(&'n str, &'n str)>) -> Machine<'n> {
        let stops = |location: &Location| !is(location, LocationKind::Normal);
        if process.locations.iter().any(stops) {
            clocks.push((NOW, "0 in places where no time passes"));
        }
        let mut invariants = Vec::new();
        for location in &process.locations {
            let name = &*location.name;
            match &location.invariant {
                _ if stops(location) => invariants.push((name, NOW, 0)),
                Some((clock, most)) => invariants.push((name, &**clock, most * self.factor)),
                None => {}
            }
        }
        let names = self.ports(process);
        let mut transitions = Vec::new();
        for (edge, port) in process.edges.iter().zip(&names) {
            let (source, target) =
                (location(process, &edge.source), location(process, &edge.target));
            let mut conditions = self.clock_conditions(edge, false);
            let mut updates = self.resets(edge, false);
            let bound = invariants.iter().find(|(place, ..)| *place == edge.source);
            let urgency = match bound {
                _ if source.is_some_and(stops) => "eager",
                Some((_, clock, most)) if self.is_delayable(process, edge) => {
                    if !edge.clocks.iter().any(|guard| guard.relation == Relation::Equal) {
                        conditions.push(format!("{clock} <= {most}"));
                    }
                    "delayable"
                }
                _ => "lazy",
            };
            if target.is_some_and(stops) && !source.is_some_and(stops) {
                updates.push(format!("{NOW} = 0;"));
            }
            let (source, target) = (edge.source.clone(), edge.target.clone());
            let (port, comment) = (port.clone(), edge.comment.clone());
            let one = Transition { port, source, target, conditions, urgency, updates, comment };
            transitions.push(one);
        }
        let mut known = BTreeSet::new();
        let ports = names.into_iter().filter(|name| known.insert(name.clone())).collect();
        Machine { process, clocks, ports, transitions, invariants }
    }

    /// Returns true if the last moment of an edge is that of its location: no comparison with a clock ends
    /// before the invariant, neither in the edge nor in those at the other end of its channel.
    fn is_delayable(&self, process: &Process, edge: &Edge) -> bool {
        let wanted = edge.sync.as_ref().map(|sync| match sync {
            Sync::Send(channel) => Sync::Receive(channel.clone()),
            Sync::Receive(channel) => Sync::Send(channel.clone()),
        });
        let others = self.network.processes.iter().flat_map(|process| {
            let ends = |edge: &&Edge| wanted.is_some() && edge.sync == wanted;
            process.edges.iter().filter(ends).map(move |edge| (process, edge))
        });
        std::iter::once((process, edge)).chain(others).all(|(process, edge)| {
            let most = location(process, &edge.source).and_then(|place| place.invariant.as_ref());
            edge.clocks.iter().all(|guard| match guard.relation {
                Relation::AtLeast | Relation::Greater => true,
                Relation::Equal => {
                    most.is_some_and(|(clock, most)| (&guard.clock, guard.value) == (clock, *most))
                }
                Relation::Less | Relation::NotEqual => false,
            })
        })
    }

    /// Returns the port of each edge. Receiving edges for which the store does nothing else have one port for
    /// a channel and a target: at most one of them leaves the present place.
    fn ports(&self, process: &Process) -> Vec<String> {
        let mut out: Vec<String> = Vec::new();
        let mut common: BTreeMap<(&str, &str), (String, Vec<&str>)> = BTreeMap::new();
        for edge in &process.edges {
            let channel = match &edge.sync {
                Some(Sync::Receive(channel)) if self.is_free(process, edge) => Some(&**channel),
                _ => None,
            };
            let Edge { source, target, .. } = edge;
            if let Some((name, sources)) = channel.and_then(|name| common.get_mut(&(name, target)))
                && !sources.contains(&&**source)
            {
                sources.push(source);
                out.push(name.clone());
                continue;
            }
            let base = format!("{}_to_{target}", channel.unwrap_or(source));
            let name = unused(&base, |name| out.iter().any(|known| known == name));
            if let Some(channel) = channel {
                common.insert((channel, target), (name.clone(), vec![source]));
            }
            out.push(name);
        }
        out
    }

    /// Returns true if the store has no condition for an edge from a location that is not committed, and
    /// changes no variable.
    fn is_free(&self, process: &Process, edge: &Edge) -> bool {
        edge.guard.is_true()
            && self.clock_conditions(edge, true).is_empty()
            && self.resets(edge, true).is_empty()
            && edge.updates.iter().all(|update| matches!(update, Update::Reset(_)))
            && !is_committed(process, &edge.source)
    }

    /// Returns the interactions: edges without synchronisation, and each sender of a channel with each port
    /// of a receiver.
    fn interactions(&self) -> Vec<Interaction<'n>> {
        let mut out: Vec<Interaction> = Vec::new();
        for machine in &self.machines {
            for (edge, transition) in machine.process.edges.iter().zip(&machine.transitions) {
                let first = (machine.process, edge, &*transition.port);
                match &edge.sync {
                    None => self.add(&[first], &mut out),
                    Some(Sync::Send(channel)) => {
                        for second in self.receivers(machine.process, channel) {
                            self.add(&[first, second], &mut out);
                        }
                    }
                    Some(Sync::Receive(_)) => {}
                }
            }
        }
        out
    }

    /// Returns the ports of other processes that receive a channel, each with its first edge.
    fn receivers(&self, sender: &Process, channel: &str) -> Vec<(&'n Process, &'n Edge, &str)> {
        let mut out: Vec<(&'n Process, &'n Edge, &str)> = Vec::new();
        for machine in self.machines.iter().filter(|machine| machine.process.name != sender.name) {
            for (edge, transition) in machine.process.edges.iter().zip(&machine.transitions) {
                let port = &*transition.port;
                let is_new = !out.iter().any(|(process, _, known)| {
                    process.name == machine.process.name && *known == port
                });
                if is_new && edge.sync == Some(Sync::Receive(channel.to_owned())) {
                    out.push((machine.process, edge, port));
                }
            }
        }
        out
    }

    /// Adds an interaction.
    fn add(&self, parts: &[(&'n Process, &'n Edge, &str)], out: &mut Vec<Interaction<'n>>) {
        let names: Vec<String> =
            parts.iter().map(|(process, _, port)| format!("{}__{port}", process.name)).collect();
        let is_taken = |name: &str| out.iter().any(|known| known.name == name);
        let name = unused(&names.join("__"), is_taken);
        let (mut conditions, mut committed) = (Vec::new(), 0);
        if !parts.iter().any(|(process, edge, _)| is_committed(process, &edge.source)) {
            conditions.push(format!("{COMMITTED} == 0"));
        }
        for (process, edge, _) in parts {
            match scalars::condition(&edge.guard, self.network) {
                Guard::And(list) => conditions.extend(list.iter().map(in_lines)),
                other => conditions.push(in_lines(&other)),
            }
            conditions.extend(self.clock_conditions(edge, true));
            committed += i64::from(is_committed(process, &edge.target))
                - i64::from(is_committed(process, &edge.source));
        }
        let count = var(COMMITTED).plus(committed);
        let sets = parts.iter().flat_map(|(_, edge, _)| &edge.updates);
        let sets = sets.filter_map(|update| match update {
            Update::Set(target, value) => Some((target.clone(), value.clone())),
            Update::Reset(_) => None,
        });
        let mut updates = scalars::statements(&sets.collect::<Vec<_>>(), self.network);
        if committed != 0 {
            updates.push(format!("{COMMITTED} = {};", term(&count)));
        }
        updates.extend(parts.iter().flat_map(|(_, edge, _)| self.resets(edge, true)));
        let mut comments: Vec<String> = Vec::new();
        for (process, edge, _) in parts {
            comments.push(format!("{}: {}", process.name, edge.comment));
        }
        let transition = Transition {
            port: name.clone(),
            source: "here".to_owned(),
            target: "here".to_owned(),
            conditions,
            urgency: "lazy",
            updates,
            comment: comments.join("; "),
        };
        let parts = parts.iter().map(|(process, _, port)| (&*process.name, (*port).to_owned()));
        out.push(Interaction { name, parts: parts.collect(), transition });
    }
}

/// Returns a name with the first number that makes it new.
fn unused(base: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let mut name = base.to_owned();
    let mut count = 1;
    while is_taken(&name) {
        count += 1;
        name = format!("{base}_{count}");
    }
    name
}

/// Prints a condition, with a line for each alternative.
fn in_lines(of: &Guard) -> String {
    match of {
        Guard::Or(list) if !list.is_empty() => {
            let parts: Vec<String> = list.iter().map(operand).collect();
            format!("({})", parts.join("\n        || "))
        }
        other => operand(other),
    }
}

fn location<'p>(process: &'p Process, name: &str) -> Option<&'p Location> {
    process.locations.iter().find(|location| location.name == name)
}

fn is(location: &Location, kind: LocationKind) -> bool {
    location.kind == kind
}

fn is_committed(process: &Process, name: &str) -> bool {
    location(process, name).is_some_and(|location| is(location, LocationKind::Committed))
}

/// Returns the greatest unit of clocks of which a base unit is a multiple, and the multiple.
fn unit(network: &Network) -> Option<(&'static str, i64)> {
    let base = network.nanoseconds?;
    let units = [
        ("second", 1_000_000_000),
        ("millisecond", 1_000_000),
        ("microsecond", 1_000),
        ("nanosecond", 1),
    ];
    let (unit, nanoseconds) = units.into_iter().find(|(_, nanoseconds)| base % nanoseconds == 0)?;
    Some((unit, base / nanoseconds))
}

/// Returns what BIP cannot say. No model known to us has such a part.
fn refusals(network: &Network, shared: &[(&str, &str)]) -> Vec<Refusal> {
    let mut out = Vec::new();
    for process in &network.processes {
        let invariants =
            process.locations.iter().filter_map(|location| location.invariant.as_ref());
        for (clock, _) in invariants {
            if shared.iter().any(|(name, _)| name == clock) {
                let why = "invariant over a clock of several processes";
                out.push(Refusal::new(why, Some(clock.clone())));
            }
        }
    }
    let mut names = vec![COMMITTED.to_owned()];
    names.extend(network.variables.iter().flat_map(scalars::names));
    names.extend(shared.iter().map(|(clock, _)| (*clock).to_owned()));
    names.sort_unstable();
    for same in names.windows(2).filter(|names| names[0] == names[1]) {
        out.push(Refusal::new("two variables with one name", Some(same[0].clone())));
    }
    out
}
