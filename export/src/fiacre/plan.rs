//! The processes and ports of a Fiacre program.
//!
//! Every transition has a port, since only ports have priorities. A port belongs to one process, or to two
//! that a channel synchronises. Ports that leave a committed location are immediate, and come before all
//! others. Ports that watch clocks come before these.

use std::collections::{BTreeMap, BTreeSet};

use super::clocks::{Clocks, Interval, Timed, Watch, names};
use crate::model::{Edge, Location, LocationKind, Network, Sync, Term, Update, Variable, var};
use crate::translate::Refusal;

/// Order in which ports are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    /// A clock reaches a value, or is reset.
    Watch,
    /// A process is in a committed location.
    Committed,
    Other,
}

/// A port.
#[derive(Debug, Clone, Copy)]
pub(super) struct Port {
    pub(super) class: Class,
    /// Time for which its transition has been possible.
    pub(super) time: Interval,
    /// The first of these times does not belong to them.
    pub(super) is_open: bool,
}

/// A port that is taken at once, before those of other processes.
const AT_ONCE: Port = Port { class: Class::Committed, time: (0, Some(0)), is_open: false };

/// A port that can be taken at any time.
const ANY_TIME: Port = Port { class: Class::Other, time: (0, None), is_open: false };

/// A transition of a process.
pub(super) struct Transition {
    pub(super) edge: Edge,
    pub(super) port: String,
}

/// A process.
pub(super) struct Machine {
    pub(super) name: String,
    pub(super) comment: String,
    pub(super) locations: Vec<Location>,
    pub(super) transitions: Vec<Transition>,
}

/// A Fiacre program.
pub(super) struct Plan {
    pub(super) machines: Vec<Machine>,
    /// By name.
    pub(super) ports: BTreeMap<String, Port>,
    pub(super) variables: Vec<Variable>,
}

/// A process without clocks.
struct Part<'n> {
    name: &'n str,
    comment: &'n str,
    locations: Vec<Location>,
    edges: Vec<Timed>,
}

impl Part<'_> {
    fn is_committed(&self, location: &str) -> bool {
        let mut committed =
            self.locations.iter().filter(|location| location.kind == LocationKind::Committed);
        committed.any(|committed| committed.name == location)
    }
}

impl Plan {
    pub(super) fn new(network: &Network) -> Result<Plan, Vec<Refusal>> {
        let clocks = Clocks::new(network);
        let (mut parts, mut refusals) = (Vec::new(), Vec::new());
        for process in &network.processes {
            match clocks.without(process) {
                Ok((locations, edges)) => {
                    let (name, comment) = (&*process.name, &*process.comment);
                    parts.push(Part { name, comment, locations, edges });
                }
                Err(refusal) => refusals.push(refusal),
            }
        }
        refusals.extend(dependent(network, &parts));
        if !refusals.is_empty() {
            return Err(refusals);
        }
        let (machines, ports) = (Vec::new(), BTreeMap::new());
        let mut out = Plan { machines, ports, variables: network.variables.clone() };
        for part in &parts {
            out.add(part, &parts);
        }
        for watch in &clocks.watches {
            out.watch(watch);
        }
        Ok(out)
    }

    /// Adds a process.
    fn add(&mut self, part: &Part, parts: &[Part]) {
        let mut transitions = Vec::new();
        for Timed { edge, interval } in &part.edges {
            let committed = part.is_committed(&edge.source);
            let name = part.name;
            let ports = match (&edge.sync, interval) {
                (Some(sync), _) => shared_ports(part, committed, sync, parts),
                (None, Some((lower, upper))) => {
                    let end = upper.map_or("on".to_owned(), |upper| upper.to_string());
                    let port = Port { time: (*lower, *upper), ..ANY_TIME };
                    vec![(format!("wait_{name}_{lower}_{end}"), port)]
                }
                (None, None) if committed => {
                    vec![(format!("now_{name}"), AT_ONCE)]
                }
                (None, None) => vec![(format!("some_time_{name}"), ANY_TIME)],
            };
            for (port, meaning) in ports {
                self.ports.insert(port.clone(), meaning);
                transitions.push(Transition { edge: edge.clone(), port });
            }
        }
        let (name, comment) = (part.name.to_owned(), part.comment.to_owned());
        let locations = part.locations.clone();
        self.machines.push(Machine { name, comment, locations, transitions });
    }

    /// Adds the process that watches a clock.
    fn watch(&mut self, watch: &Watch) {
        let Watch { clock, value, is_strict } = watch;
        let word = if *is_strict { "has passed" } else { "has reached" };
        let (name, flag, restart) = (watch.process(), var(&watch.flag()), var(&watch.restart()));
        let mut variable = |name: String, comment: String| {
            self.variables.push(Variable { name, size: None, most: 1, comment });
        };
        variable(watch.flag(), format!("1: the clock {clock} {word} {value}"));
        variable(watch.restart(), format!("1: the clock {clock} is reset, not noticed yet"));
        let (reaches, restarts) = (format!("reach_{name}"), format!("restart_{name}"));
        let reached = Port { class: Class::Watch, time: (*value, Some(*value)), is_open: false };
        let passed = Port { time: (*value, None), is_open: true, ..ANY_TIME };
        self.ports.insert(reaches.clone(), if *is_strict { passed } else { reached });
        self.ports.insert(restarts.clone(), Port { class: Class::Watch, ..AT_ONCE });
        let location = |name: &str, comment: &str| Location {
            name: name.to_owned(),
            kind: LocationKind::Normal,
            invariant: None,
            is_goal: false,
            comment: comment.to_owned(),
        };
        let reach =
            Edge::new("young", "old", "the value is there").with([flag.clone().set(1_usize)]);
        let mut transitions = vec![Transition { edge: reach, port: reaches }];
        for source in ["young", "old"] {
            let edge = Edge::new(source, "young", "the clock is reset");
            let edge = edge.when(restart.clone().is(1_usize));
            let edge = edge.with([flag.clone().set(0_usize), restart.clone().set(0_usize)]);
            transitions.push(Transition { edge, port: restarts.clone() });
        }
        let comment = format!("the clock {clock}: notes that it {word} {value}");
        let locations = vec![
            location("young", "the clock is below the value"),
            location("old", "the value is there"),
        ];
        self.machines.push(Machine { name, comment, locations, transitions });
    }
}

/// Returns the ports of an end of a channel: one for each process and kind of location at the other end.
fn shared_ports(part: &Part, committed: bool, sync: &Sync, parts: &[Part]) -> Vec<(String, Port)> {
    let mut out = BTreeMap::new();
    for other in parts.iter().filter(|other| other.name != part.name) {
        for edge in other.edges.iter().map(|timed| &timed.edge) {
            let there = other.is_committed(&edge.source);
            let (channel, sender, receiver) = match (sync, &edge.sync) {
                (Sync::Send(channel), Some(Sync::Receive(heard))) if channel == heard => {
                    (channel, (part.name, committed), (other.name, there))
                }
                (Sync::Receive(channel), Some(Sync::Send(sent))) if channel == sent => {
                    (channel, (other.name, there), (part.name, committed))
                }
                _ => continue,
            };
            let ends = match (sender.1, receiver.1) {
                (false, false) => "",
                (true, false) => "_now",
                (false, true) => "_then",
                (true, true) => "_both",
            };
            let name = format!("{channel}_{}_{}{ends}", sender.0, receiver.0);
            out.insert(name, if sender.1 || receiver.1 { AT_ONCE } else { ANY_TIME });
        }
    }
    out.into_iter().collect()
}

/// Returns the names of the variables that an edge changes.
fn changes(edge: &Edge) -> BTreeSet<&str> {
    let sets = edge.updates.iter().filter_map(|update| match update {
        Update::Set(Term::Variable(name) | Term::Element(name, _), _) => Some(&**name),
        _ => None,
    });
    sets.collect()
}

/// Returns the channels whose two ends change, or change and read, one variable: Fiacre gives the ends no
/// order.
fn dependent(network: &Network, parts: &[Part]) -> Vec<Refusal> {
    let edges = || parts.iter().flat_map(|part| part.edges.iter().map(|timed| &timed.edge));
    let with = |sync: &Sync| -> Vec<&Edge> {
        edges().filter(|edge| edge.sync.as_ref() == Some(sync)).collect()
    };
    let mut out = Vec::new();
    for (channel, _) in &network.channels {
        let receivers = with(&Sync::Receive(channel.clone()));
        let senders = with(&Sync::Send(channel.clone()));
        let meets = |sender: &Edge, receiver: &Edge| {
            changes(sender).iter().any(|name| updates_name(receiver, name))
                || changes(receiver).iter().any(|name| updates_name(sender, name))
        };
        if senders.iter().any(|sender| receivers.iter().any(|receiver| meets(sender, receiver))) {
            out.push(Refusal::new("updates in an order between processes", Some(channel.clone())));
        }
    }
    out
}

/// Returns true if the updates of an edge name a variable.
fn updates_name(edge: &Edge, name: &str) -> bool {
    let updates = Edge::new("", "", "").with(edge.updates.clone());
    names(&updates, name)
}
