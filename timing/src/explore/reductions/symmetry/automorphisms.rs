//! Symmetric units: exchanges that change neither the system nor the watched properties.
//!
//! An exchange is found by pairing the parts of two components, clients or tasks, step by step. It is
//! accepted only after a comparison of the whole system with the exchanged system.

use super::Renaming;
use super::renaming::Id;
use crate::explore::reductions::Watched;
use crate::explore::rules::{Part, Parts};
use crate::property::{Atom, Predicate};
use crate::system::{
    AutomatonId, ClientAction, ClientId, CodelId, CodelSet, ComponentId, MachineId, Policy,
    ServiceId, TaskId, TimedSystem,
};

/// The watched properties of a task.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Label {
    /// Membership in the lists of the watch.
    pub(crate) watched: [bool; 2],
    /// Limits in base units, and whether the times are measured at present.
    pub(crate) measured: Vec<(Option<u32>, Option<u32>, bool)>,
}

/// Returns classes of symmetric units, each of at least two.
pub(super) fn classes(system: &TimedSystem, asked: &Watched) -> Vec<Vec<Parts>> {
    let seeds = (system.components.keys())
        .map(Seed::Component)
        .chain(system.clients.keys().map(Seed::Client))
        .chain(system.tasks.keys().map(Seed::Task));
    let seeds: Vec<Seed> = seeds.collect();
    let mut out: Vec<Vec<Parts>> = Vec::new();
    for (i, &first) in seeds.iter().enumerate() {
        let mut class: Vec<Parts> = Vec::new();
        for &other in &seeds[i + 1..] {
            let mut units = out.iter().flatten().chain(&class[class.len().min(1)..]);
            if !first.resembles(other, system)
                || units.any(|unit| holds(unit, first) || holds(unit, other))
            {
                continue;
            }
            let Some((one, two)) = exchange(system, asked, first, other) else {
                continue;
            };
            let mut others = out.iter().flatten();
            if others.any(|part| meet(part, &one) || meet(part, &two))
                || class.iter().any(|class| meet(class, &two))
            {
                continue;
            }
            match class.first() {
                Some(class) if *class != one => continue,
                Some(_) => {}
                None => class.push(one),
            }
            class.push(two);
        }
        if class.len() > 1 && closed(system, &class) {
            out.push(class);
        }
    }
    out
}

/// Returns true if the clients of each unit only send requests to services of their unit, or of no unit.
fn closed(system: &TimedSystem, class: &[Parts]) -> bool {
    class.iter().all(|unit| {
        let foreign = |service: ServiceId| {
            !unit[Part::Service].contains(&service.into())
                && class.iter().any(|class| class[Part::Service].contains(&service.into()))
        };
        let steps =
            unit[Part::Client].iter().flat_map(|&unit| &system.clients[ClientId::from(unit)].steps);
        let mut sends = steps.filter_map(|step| match step.action {
            ClientAction::Send { service, .. } => Some(service),
            _ => None,
        });
        !sends.any(foreign)
    })
}

/// The starting point of an exchange.
#[derive(Debug, Clone, Copy)]
enum Seed {
    Component(ComponentId),
    Client(ClientId),
    Task(TaskId),
}

impl Seed {
    /// Returns true if two seeds are worth a comparison: a quick test, as there are many pairs.
    fn resembles(self, other: Seed, system: &TimedSystem) -> bool {
        let task = |task: TaskId| {
            let task = &system.tasks[task];
            (task.period, task.delay, task.permanent.is_some(), task.slots.len())
        };
        match (self, other) {
            (Seed::Component(one), Seed::Component(other)) => {
                let (one, other) = (&system.components[one], &system.components[other]);
                one.services.len() == other.services.len()
                    && (one.tasks.iter().map(|&index| task(index)))
                        .eq(other.tasks.iter().map(|&index| task(index)))
            }
            (Seed::Client(one), Seed::Client(other)) => {
                let (one, other) = (&system.clients[one], &system.clients[other]);
                one.steps.len() == other.steps.len() && one.trackers == other.trackers
            }
            (Seed::Task(one), Seed::Task(other)) => task(one) == task(other),
            _ => false,
        }
    }
}

/// Returns the two units around two seeds, if exchanging them changes nothing.
fn exchange(
    system: &TimedSystem,
    asked: &Watched,
    one: Seed,
    other: Seed,
) -> Option<(Parts, Parts)> {
    let mut exchange = Exchange::new(system);
    match (one, other) {
        (Seed::Component(one), Seed::Component(other)) => exchange.component(one, other),
        (Seed::Client(one), Seed::Client(other)) => exchange.client(one, other),
        (Seed::Task(one), Seed::Task(other)) => exchange.task(one, other),
        _ => None,
    }?;
    exchange.changes_nothing(asked).then_some((exchange.one, exchange.other))
}

/// Returns true if a unit contains the starting point of an exchange.
fn holds(unit: &Parts, seed: Seed) -> bool {
    match seed {
        Seed::Component(component) => unit[Part::Component].contains(&component.into()),
        Seed::Client(client) => unit[Part::Client].contains(&client.into()),
        Seed::Task(task) => unit[Part::Task].contains(&task.into()),
    }
}

/// Returns true if two units have a part in common.
fn meet(one: &Parts, other: &Parts) -> bool {
    let meet =
        |(one, other): (&Vec<usize>, &Vec<usize>)| one.iter().any(|index| other.contains(index));
    one.lists().iter().zip(other.lists()).any(meet)
}

/// An exchange of two units.
struct Exchange<'s> {
    system: &'s TimedSystem,
    /// The new name of every part of the system.
    to: Renaming,
    one: Parts,
    other: Parts,
}

impl<'s> Exchange<'s> {
    fn new(system: &'s TimedSystem) -> Self {
        Exchange {
            system,
            to: Renaming::of_system(system),
            one: Parts::default(),
            other: Parts::default(),
        }
    }

    /// Pairs two parts of a kind. Returns `None` if either is already paired with another part, or must keep
    /// its name. Otherwise returns true if the pair is new.
    fn pair<I: Into<usize>>(&mut self, part: Part, x: I, y: I) -> Option<bool> {
        let (x, y) = (x.into(), y.into());
        let to = self.to.of_mut(part);
        if x == y {
            (to[x] == x).then_some(false)
        } else if to[x] == y && self.one[part].contains(&x) {
            Some(false)
        } else if to[x] == x && to[y] == y {
            (to[x], to[y]) = (y, x);
            self.one[part].push(x);
            self.other[part].push(y);
            Some(true)
        } else {
            None
        }
    }

    // ---- The parts of units ----------------------------------------------------------------

    fn each<I: Copy>(
        &mut self,
        one: &[I],
        other: &[I],
        mut pair: impl FnMut(&mut Self, I, I) -> Option<()>,
    ) -> Option<()> {
        if one.len() != other.len() {
            return None;
        }
        for (&one, &other) in one.iter().zip(other) {
            pair(self, one, other)?;
        }
        Some(())
    }

    fn component(&mut self, x: ComponentId, y: ComponentId) -> Option<()> {
        if self.pair(Part::Component, x, y)? {
            let (one, other) = (&self.system.components[x], &self.system.components[y]);
            self.each(&one.tasks, &other.tasks, Self::task)?;
            self.each(&one.services, &other.services, Self::service)?;
        }
        Some(())
    }

    fn task(&mut self, x: TaskId, y: TaskId) -> Option<()> {
        if self.pair(Part::Task, x, y)? {
            let (one, other) = (&self.system.tasks[x], &self.system.tasks[y]);
            self.component(one.component, other.component)?;
            let list = |optional: Option<AutomatonId>| optional.into_iter().collect::<Vec<_>>();
            self.each(&list(one.permanent), &list(other.permanent), Self::automaton)?;
            self.each(&one.slots, &other.slots, Self::automaton)?;
        }
        Some(())
    }

    fn automaton(&mut self, x: AutomatonId, y: AutomatonId) -> Option<()> {
        if self.pair(Part::Automaton, x, y)? {
            let (one, other) = (&self.system.automata[x], &self.system.automata[y]);
            self.task(one.task, other.task)?;
            self.machine(one.machine, other.machine)?;
            match (one.service, other.service) {
                (Some(one), Some(other)) => self.service(one, other)?,
                (None, None) => {}
                _ => return None,
            }
        }
        Some(())
    }

    fn machine(&mut self, x: MachineId, y: MachineId) -> Option<()> {
        if self.pair(Part::Machine, x, y)? {
            let codels = |machine: MachineId| -> Vec<CodelId> {
                let states = self.system.machines[machine].states.iter();
                states.map(|state| state.codel).collect()
            };
            let (one, other) = (codels(x), codels(y));
            self.each(&one, &other, Self::codel)?;
        }
        Some(())
    }

    fn service(&mut self, x: ServiceId, y: ServiceId) -> Option<()> {
        if self.pair(Part::Service, x, y)? {
            let (one, other) = (&self.system.services[x], &self.system.services[y]);
            self.component(one.component, other.component)?;
            let list = |optional: Option<CodelId>| optional.into_iter().collect::<Vec<_>>();
            self.each(&list(one.validate), &list(other.validate), Self::codel)?;
            self.each(&one.simple, &other.simple, Self::codel)?;
            self.each(&one.slots, &other.slots, Self::automaton)?;
        }
        Some(())
    }

    fn codel(&mut self, x: CodelId, y: CodelId) -> Option<()> {
        if self.pair(Part::Codel, x, y)? {
            let (one, other) = (&self.system.codels[x], &self.system.codels[y]);
            self.component(one.component, other.component)?;
        }
        Some(())
    }

    fn client(&mut self, x: ClientId, y: ClientId) -> Option<()> {
        if self.pair(Part::Client, x, y)? {
            let (one, other) = (&self.system.clients[x], &self.system.clients[y]);
            if one.steps.len() != other.steps.len() {
                return None;
            }
            for (one, other) in one.steps.iter().zip(&other.steps) {
                if let (
                    &ClientAction::Send { service: one, .. },
                    &ClientAction::Send { service: other, .. },
                ) = (&one.action, &other.action)
                {
                    self.service(one, other)?;
                }
            }
        }
        Some(())
    }

    // ---- The comparison of the systems ------------------------------------------------------

    fn changes_nothing(&self, asked: &Watched) -> bool {
        !meet(&self.one, &self.other)
            && self.keeps_components()
            && self.keeps_tasks(asked)
            && self.keeps_machines()
            && self.keeps_codels()
            && self.keeps_services()
            && self.keeps_clients()
            && asked.predicates.iter().all(|predicate| self.keeps_predicate(predicate))
    }

    fn keeps_components(&self) -> bool {
        let system = self.system;
        (system.components.keys()).all(|c| {
            let (from, to) =
                (&system.components[c], &system.components[self.name(Part::Component, c)]);
            // Tasks are started one after the other. In the published models, a task without a permanent
            // activity is started with the previous one.
            let together = system.platform.semantics.is_published();
            let blocks = |tasks: &mut dyn Iterator<Item = usize>| {
                let mut blocks: Vec<Vec<usize>> = vec![Vec::new()];
                for task in tasks {
                    if !together || system.tasks[TaskId::from(task)].permanent.is_some() {
                        blocks.push(vec![task]);
                        blocks.push(Vec::new());
                    } else {
                        blocks.last_mut().expect("there is one").push(task);
                    }
                }
                for block in &mut blocks {
                    block.sort_unstable();
                }
                blocks
            };
            let renamed = blocks(
                &mut from.tasks.iter().map(|&task| usize::from(self.name(Part::Task, task))),
            );
            renamed == blocks(&mut to.tasks.iter().map(|&task| usize::from(task)))
                && same_set(&from.services, &to.services, self.to.of(Part::Service))
        })
    }

    fn keeps_tasks(&self, asked: &Watched) -> bool {
        let system = self.system;
        let by_priority = system.platform.policy == Policy::Priority;
        let tasks = (0..system.tasks.len()).all(|t| {
            let (from, to) = (
                &system.tasks[TaskId::from(t)],
                &system.tasks[TaskId::from(self.name(Part::Task, t))],
            );
            asked.labels[t] == asked.labels[self.name(Part::Task, t)]
                && self.name(Part::Component, from.component) == to.component
                && (from.period, from.delay, from.keep_idle_tick)
                    == (to.period, to.delay, to.keep_idle_tick)
                && (from.places, from.affinity) == (to.places, to.affinity)
                && (!by_priority || from.priority == to.priority)
                && from.permanent.map(|index| self.name(Part::Automaton, index)) == to.permanent
                && same_list(&from.slots, &to.slots, self.to.of(Part::Automaton))
        });
        tasks
            && system.automata.keys().all(|a| {
                let (from, to) =
                    (&system.automata[a], &system.automata[self.name(Part::Automaton, a)]);
                self.name(Part::Task, from.task) == to.task
                    && self.name(Part::Machine, from.machine) == to.machine
                    && from.service.map(|service| self.name(Part::Service, service)) == to.service
            })
    }

    fn keeps_machines(&self) -> bool {
        let machines = &self.system.machines;
        machines.keys().all(|m| {
            let (from, to) = (&machines[m], &machines[self.name(Part::Machine, m)]);
            (from.start, from.stop, from.loop_limit, from.rounds)
                == (to.start, to.stop, to.loop_limit, to.rounds)
                && from.states.len() == to.states.len()
                && from.states.iter().zip(&to.states).all(|(from, to)| {
                    self.name(Part::Codel, from.codel) == to.codel
                        && from.yields == to.yields
                        && from.is_async == to.is_async
                })
        })
    }

    fn keeps_codels(&self) -> bool {
        let codels = &self.system.codels;
        codels.iter_enumerated().all(|(c, from)| {
            let to = &codels[self.name(Part::Codel, c)];
            let mut renamed = CodelSet::default();
            from.conflicts
                .iter()
                .for_each(|conflict| renamed.insert(self.name(Part::Codel, conflict)));
            self.name(Part::Component, from.component) == to.component
                && (from.lower, from.upper, from.throws) == (to.lower, to.upper, to.throws)
                && renamed.iter().eq(to.conflicts.iter())
        })
    }

    fn keeps_services(&self) -> bool {
        let services = &self.system.services;
        services.iter_enumerated().all(|(v, from)| {
            let to = &services[self.name(Part::Service, v)];
            self.name(Part::Component, from.component) == to.component
                && (from.activity, from.builtin) == (to.activity, to.builtin)
                && from.validate.map(|validate| self.name(Part::Codel, validate)) == to.validate
                && same_list(&from.simple, &to.simple, self.to.of(Part::Codel))
                && same_list(&from.slots, &to.slots, self.to.of(Part::Automaton))
                && [
                    (&from.interrupts, &to.interrupts),
                    (&from.after, &to.after),
                    (&from.before, &to.before),
                ]
                .iter()
                .all(|(from, to)| same_set(from, to, self.to.of(Part::Service)))
        })
    }

    fn keeps_clients(&self) -> bool {
        let clients = &self.system.clients;
        clients.iter_enumerated().all(|(k, from)| {
            let to = &clients[self.name(Part::Client, k)];
            (&from.first, from.trackers) == (&to.first, to.trackers)
                && from.steps.len() == to.steps.len()
                && from.steps.iter().zip(&to.steps).all(|(from, to)| {
                    let renamed = match &from.action {
                        ClientAction::Send { service, trackers, accepted, aborts } => {
                            ClientAction::Send {
                                service: self.name(Part::Service, *service),
                                trackers: trackers.clone(),
                                accepted: accepted.clone(),
                                aborts: *aborts,
                            }
                        }
                        other => other.clone(),
                    };
                    renamed == to.action && from.next == to.next
                })
        })
    }

    fn keeps_predicate(&self, predicate: &Predicate) -> bool {
        words(predicate, &|atom| format!("{atom:?}"))
            == words(predicate, &|atom| format!("{:?}", self.to.atom(atom)))
    }

    fn name<I: Id>(&self, part: Part, id: I) -> I {
        self.to.name(part, id)
    }
}

fn same_set<I: Id>(from: &[I], to: &[I], names: &[usize]) -> bool {
    let mut from: Vec<I> = from.iter().map(|&id| I::from(names[id.into()])).collect();
    let mut to = to.to_vec();
    from.sort_unstable();
    to.sort_unstable();
    from == to
}

fn same_list<I: Id>(from: &[I], to: &[I], names: &[usize]) -> bool {
    let renamed = from.iter().map(|&id| I::from(names[id.into()]));
    renamed.eq(to.iter().copied())
}

/// Returns a predicate in words, whatever the order of the operands of `and` and `or`.
fn words(predicate: &Predicate, atom: &dyn Fn(&Atom) -> String) -> String {
    fn parts(
        predicate: &Predicate,
        and: bool,
        atom: &dyn Fn(&Atom) -> String,
        out: &mut Vec<String>,
    ) {
        match (predicate, and) {
            (Predicate::And(one, other), true) | (Predicate::Or(one, other), false) => {
                parts(one, and, atom, out);
                parts(other, and, atom, out);
            }
            _ => out.push(words(predicate, atom)),
        }
    }
    let list = |and: bool| {
        let mut out = Vec::new();
        parts(predicate, and, atom, &mut out);
        out.sort_unstable();
        out
    };
    match predicate {
        Predicate::Atom(proposition) => atom(proposition),
        Predicate::Leave(proposition) => format!("leave {}", atom(proposition)),
        Predicate::Not(predicate) => format!("not ({})", words(predicate, atom)),
        Predicate::And(..) => format!("({})", list(true).join(" and ")),
        Predicate::Or(..) => format!("({})", list(false).join(" or ")),
    }
}
