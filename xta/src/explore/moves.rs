//! The semantics: the transitions of a state.

use crate::code::Code;
use crate::eval::{Machine, Trap};
use crate::network::edges::{Bound, Edge, Location, Process, Sync, Update};
use crate::network::scope::Program;
use crate::zone::{Constraint, LARGEST_BOUND, Zone, at_most, below};

/// Largest number of combinations of receivers of one broadcast.
const LARGEST_BROADCAST: usize = 1 << 12;

/// A network with what its exploration needs.
pub(crate) struct System<'n> {
    pub(crate) program: &'n Program,
    pub(crate) processes: &'n [Process],
    pub(crate) machine: Machine<'n>,
    /// Set if channels or processes have different priorities.
    pub(crate) priorities: bool,
}

/// A transition. Indices of constraints are clocks, from 1. Index 0 is the constant 0.
#[derive(Debug, Clone)]
pub(crate) struct Move {
    /// Processes with their edges. The sender is first.
    pub(crate) edges: Vec<(u32, u32)>,
    pub(crate) channel: Option<u32>,
    pub(crate) constraints: Vec<Constraint>,
    /// Priority of the channel, then the highest of the processes.
    priority: (i32, i32),
}

/// The effect of a transition.
#[derive(Debug, Clone)]
pub(crate) struct Effect {
    /// The transition, with the invariants of its target among the constraints.
    pub(crate) step: Move,
    pub(crate) discrete: Vec<i32>,
    /// Clocks that are reset, with their values. Later entries override earlier ones.
    pub(crate) resets: Vec<(u32, i32)>,
}

/// An edge whose conditions on integers hold.
struct Ready {
    process: u32,
    edge: u32,
    constraints: Vec<Constraint>,
}

/// Ready edges by their role. Those with a channel are with its index.
#[derive(Default)]
struct Roles {
    internal: Vec<Ready>,
    senders: Vec<(u32, Ready)>,
    receivers: Vec<(u32, Ready)>,
}

/// Constraints on the clocks of a state, as constraints on the rows of its zone.
pub(crate) fn local(constraints: &[Constraint], rows: &[u32]) -> Vec<Constraint> {
    let row = |clock: u32| match clock {
        0 => Some(0),
        clock => rows.iter().position(|row| *row + 1 == clock).map(|row| row as u32 + 1),
    };
    // All clocks that are compared are active, so that none is left out.
    let translated = constraints.iter().filter_map(|constraint| {
        Some(Constraint { i: row(constraint.i)?, j: row(constraint.j)?, bound: constraint.bound })
    });
    translated.collect()
}

/// The disjoint alternatives in which a conjunction does not hold.
fn negations(constraints: &[Constraint]) -> Vec<Vec<Constraint>> {
    let part = |index: usize| {
        let mut part = constraints[..index].to_vec();
        part.push(constraints[index].negated());
        part
    };
    (0..constraints.len()).map(part).collect()
}

impl System<'_> {
    fn edge(&self, process: u32, edge: u32) -> &Edge {
        &self.processes[process as usize].edges[edge as usize]
    }

    fn location(&self, discrete: &[i32], process: usize) -> &Location {
        &self.processes[process].locations[discrete[process] as usize]
    }

    /// The constraint of a bound of a clock in the memory.
    pub(crate) fn constraint(&mut self, bound: &Bound) -> Result<Constraint, Trap> {
        let value = self.machine.pure(&bound.value)?;
        if !(-LARGEST_BOUND..=LARGEST_BOUND).contains(&value) {
            return Err(format!("a clock is compared with {value}, which is too large"));
        }
        let clock = bound.clock + 1;
        let cell = |value: i32| if bound.strict { below(value) } else { at_most(value) };
        let (i, j) = if bound.upper { (clock, 0) } else { (0, clock) };
        Ok(Constraint { i, j, bound: cell(if bound.upper { value } else { -value }) })
    }

    /// The invariants of the current locations on clocks, or `None` if an invariant on integers is false.
    pub(crate) fn invariants(&mut self, discrete: &[i32]) -> Result<Option<Vec<Constraint>>, Trap> {
        self.machine.load(discrete);
        let mut out = Vec::new();
        let processes = self.processes;
        for (process, location) in processes.iter().zip(discrete) {
            let invariant = &process.locations[*location as usize].invariant;
            if !self.machine.all(&invariant.conditions)? {
                return Ok(None);
            }
            for bound in &invariant.bounds {
                out.push(self.constraint(bound)?);
            }
        }
        Ok(Some(out))
    }

    /// Reports whether time may pass: no location is committed or urgent, and no urgent channel is enabled.
    pub(crate) fn can_delay(&mut self, discrete: &[i32]) -> Result<bool, Trap> {
        let processes = self.processes;
        let stops = |location: &Location| location.committed || location.urgent;
        if (0..processes.len()).any(|process| stops(self.location(discrete, process))) {
            return Ok(false);
        }
        let urgent = |sync: &Sync| sync.urgent && (sync.sends || !sync.broadcast);
        let roles = self.roles(discrete, |edge| edge.sync.as_ref().is_some_and(urgent))?;
        for (channel, sender) in &roles.senders {
            let broadcast = self.program.channels[*channel as usize].broadcast;
            let fits = |(other, receiver): &(u32, Ready)| {
                other == channel && receiver.process != sender.process
            };
            if broadcast || roles.receivers.iter().any(fits) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The edges that pass a filter and whose conditions on integers hold.
    fn roles(&mut self, discrete: &[i32], filter: impl Fn(&Edge) -> bool) -> Result<Roles, Trap> {
        self.machine.load(discrete);
        let processes = self.processes;
        let mut roles = Roles::default();
        for (number, process) in processes.iter().enumerate() {
            for index in &process.outgoing[discrete[number] as usize] {
                let edge = &process.edges[*index as usize];
                if !filter(edge) || !self.machine.all(&edge.guard.conditions)? {
                    continue;
                }
                let bounds = edge.guard.bounds.iter().map(|bound| self.constraint(bound));
                let constraints = bounds.collect::<Result<_, _>>()?;
                let ready = Ready { process: number as u32, edge: *index, constraints };
                match &edge.sync {
                    None => roles.internal.push(ready),
                    Some(sync) => {
                        let channel = self.channel(&sync.channel)?;
                        let role =
                            if sync.sends { &mut roles.senders } else { &mut roles.receivers };
                        role.push((channel, ready));
                    }
                }
            }
        }
        Ok(roles)
    }

    fn channel(&mut self, code: &Code) -> Result<u32, Trap> {
        Ok(self.machine.pure(code)? as u32)
    }

    /// The transitions of a state by the conditions on integers, before priorities. A constraint may be false
    /// in the whole zone.
    fn candidates(&mut self, discrete: &[i32]) -> Result<Vec<Move>, Trap> {
        let roles = self.roles(discrete, |_| true)?;
        let mut out: Vec<Move> = Vec::new();
        out.extend(roles.internal.iter().map(|ready| self.join(None, &[ready], &[])));
        for (channel, sender) in &roles.senders {
            let fits = |(other, ready): &&(u32, Ready)| {
                other == channel && ready.process != sender.process
            };
            let receivers = roles.receivers.iter().filter(fits).map(|(_, ready)| ready);
            if !self.program.channels[*channel as usize].broadcast {
                out.extend(
                    receivers.map(|receiver| self.join(Some(*channel), &[sender, receiver], &[])),
                );
                continue;
            }
            for (members, absent) in broadcasts(sender, &receivers.collect::<Vec<_>>())? {
                out.push(self.join(Some(*channel), &members, &absent));
            }
        }
        let committed = |process: usize| self.location(discrete, process).committed;
        if (0..self.processes.len()).any(committed) {
            out.retain(|step| step.edges.iter().any(|(process, _)| committed(*process as usize)));
        }
        Ok(out)
    }

    fn join(&self, channel: Option<u32>, members: &[&Ready], more: &[Constraint]) -> Move {
        let highest =
            members.iter().map(|ready| self.processes[ready.process as usize].priority).max();
        let of_channel =
            channel.map_or(0, |channel| self.program.channels[channel as usize].priority);
        let mut constraints: Vec<Constraint> =
            members.iter().flat_map(|ready| ready.constraints.iter().copied()).collect();
        constraints.extend_from_slice(more);
        let edges = members.iter().map(|ready| (ready.process, ready.edge)).collect();
        Move { edges, channel, constraints, priority: (of_channel, highest.unwrap_or(0)) }
    }

    /// The transitions that are enabled in a part of a zone, whose rows are the given clocks.
    pub(crate) fn outcomes(
        &mut self,
        discrete: &[i32],
        zone: &Zone,
        rows: &[u32],
    ) -> Result<Vec<Effect>, Trap> {
        let mut moves = self.candidates(discrete)?;
        let enabled = |step: &Move| zone.clone().constrain_all(&local(&step.constraints, rows));
        moves.retain(enabled);
        if self.priorities {
            moves.sort_by_key(|step| std::cmp::Reverse(step.priority));
        }
        let mut out: Vec<Effect> = Vec::new();
        for step in moves {
            let higher: Vec<&Effect> = if self.priorities {
                out.iter().filter(|outcome| outcome.step.priority > step.priority).collect()
            } else {
                Vec::new()
            };
            for step in remaining(step, &higher, zone, rows)? {
                if let Some(outcome) = self.apply(discrete, step)?
                    && zone.clone().constrain_all(&local(&outcome.step.constraints, rows))
                {
                    out.push(outcome);
                }
            }
        }
        Ok(out)
    }

    /// The effect of a transition, or `None` if an invariant of the target on integers is false.
    fn apply(&mut self, discrete: &[i32], mut step: Move) -> Result<Option<Effect>, Trap> {
        self.machine.load(discrete);
        let mut resets = Vec::new();
        let (processes, mut targets) = (self.processes, Vec::new());
        for (process, edge) in &step.edges {
            let edge = &processes[*process as usize].edges[*edge as usize];
            targets.push((*process as usize, edge.target));
            for update in &edge.updates {
                match update {
                    Update::Run(code) => {
                        self.machine.run(code).map_err(|trap| self.describe(&step, &trap))?;
                    }
                    Update::Reset(clock, code) => {
                        let value =
                            self.machine.run(code).map_err(|trap| self.describe(&step, &trap))?;
                        if !(0..=LARGEST_BOUND).contains(&value) {
                            return Err(self.describe(&step, &format!("a clock is set to {value}")));
                        }
                        resets.push((*clock, value));
                    }
                }
            }
        }
        for (process, target) in targets {
            self.machine.memory[process] = target;
        }
        let discrete = self.machine.memory.clone();
        let Some(invariants) = self.invariants(&discrete)? else { return Ok(None) };
        for invariant in invariants {
            let reset = resets.iter().rev().find(|(clock, _)| clock + 1 == invariant.i);
            match reset {
                None => step.constraints.push(invariant),
                Some((_, value)) if at_most(*value) > invariant.bound => return Ok(None),
                Some(_) => {}
            }
        }
        Ok(Some(Effect { step, discrete, resets }))
    }

    fn describe(&self, step: &Move, trap: &str) -> Trap {
        format!("{trap}, at {}", self.label(step))
    }

    /// The edges of a transition in words.
    pub(crate) fn label(&self, step: &Move) -> String {
        let edges = step.edges.iter().map(|(process, edge)| {
            let (edge, process) = (self.edge(*process, *edge), &self.processes[*process as usize]);
            let name = |location: i32| &process.locations[location as usize].name;
            format!("{}.{} -> {}", process.name, name(edge.source), name(edge.target))
        });
        edges.collect::<Vec<_>>().join(", ")
    }
}

/// The combinations of receivers of a broadcast, with constraints under which the others do not take part.
#[expect(clippy::type_complexity, reason = "a pair in a list")]
fn broadcasts<'r>(
    sender: &'r Ready,
    receivers: &[&'r Ready],
) -> Result<Vec<(Vec<&'r Ready>, Vec<Constraint>)>, Trap> {
    let mut out = vec![(vec![sender], Vec::new())];
    for group in receivers.chunk_by(|a, b| a.process == b.process) {
        let mut next = Vec::new();
        // A process that can take part does.
        let mut absent: Vec<Vec<Constraint>> = vec![Vec::new()];
        for receiver in group {
            let negations = negations(&receiver.constraints);
            absent = absent
                .iter()
                .flat_map(|before| {
                    negations.iter().map(move |more| [before.as_slice(), more].concat())
                })
                .collect();
        }
        for (members, constraints) in &out {
            for receiver in group {
                let mut members = members.clone();
                members.push(receiver);
                next.push((members, constraints.clone()));
            }
            for more in &absent {
                next.push((members.clone(), [constraints.as_slice(), more].concat()));
            }
        }
        if next.len() > LARGEST_BROADCAST {
            return Err(format!(
                "a broadcast has more than {LARGEST_BROADCAST} combinations of receivers"
            ));
        }
        out = next;
    }
    Ok(out)
}

/// The parts of a transition that transitions of higher priority leave.
fn remaining(step: Move, higher: &[&Effect], zone: &Zone, rows: &[u32]) -> Result<Vec<Move>, Trap> {
    let mut parts = vec![step];
    for outcome in higher {
        let negations = negations(&outcome.step.constraints);
        let mut next = Vec::new();
        for part in &parts {
            for more in &negations {
                let constraints = [part.constraints.as_slice(), more].concat();
                if zone.clone().constrain_all(&local(&constraints, rows)) {
                    next.push(Move { constraints, ..part.clone() });
                }
            }
        }
        if next.len() > LARGEST_BROADCAST {
            return Err("priorities split a transition into too many parts".to_owned());
        }
        parts = next;
    }
    Ok(parts)
}
