//! Symmetric units: exchanges that change neither the system nor the watched properties.
//!
//! An exchange is found by pairing the parts of two components, clients or tasks, step by step. It is
//! accepted only after a comparison of the whole system with the exchanged system.

use super::Unit;
use crate::explore::reductions::Watched;
use crate::property::{Atom, Predicate};
use crate::system::{ClientAction, CodelSet, TimedSystem};

/// The watched properties of a task.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Label {
    /// Membership in the lists of the watch.
    pub(crate) watched: [bool; 2],
    /// Limits in base units, and whether the times are measured at present.
    pub(crate) measured: Vec<(Option<u32>, Option<u32>, bool)>,
}

/// Returns classes of symmetric units, each of at least two.
pub(super) fn classes(system: &TimedSystem, asked: &Watched) -> Vec<Vec<Unit>> {
    let seeds = (0..system.components.len())
        .map(Seed::Component)
        .chain((0..system.clients.len()).map(Seed::Client))
        .chain((0..system.tasks.len()).map(Seed::Task));
    let seeds: Vec<Seed> = seeds.collect();
    let mut out: Vec<Vec<Unit>> = Vec::new();
    for (i, &first) in seeds.iter().enumerate() {
        let mut class: Vec<Unit> = Vec::new();
        for &other in &seeds[i + 1..] {
            let mut units = out.iter().flatten().chain(&class[class.len().min(1)..]);
            if !first.resembles(other, system) || units.any(|it| it.holds(first) || it.holds(other))
            {
                continue;
            }
            let Some((one, two)) = exchange(system, asked, first, other) else {
                continue;
            };
            let mut others = out.iter().flatten();
            if others.any(|it| it.meets(&one) || it.meets(&two))
                || class.iter().any(|it| it.meets(&two))
            {
                continue;
            }
            match class.first() {
                Some(it) if *it != one => continue,
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
fn closed(system: &TimedSystem, class: &[Unit]) -> bool {
    class.iter().all(|unit| {
        let foreign = |service: usize| {
            !unit.services.contains(&service)
                && class.iter().any(|it| it.services.contains(&service))
        };
        let steps = unit
            .clients
            .iter()
            .flat_map(|&it| &system.clients[it].steps);
        let mut sends = steps.filter_map(|it| match it.action {
            ClientAction::Send { service, .. } => Some(service),
            _ => None,
        });
        !sends.any(foreign)
    })
}

/// The starting point of an exchange.
#[derive(Debug, Clone, Copy)]
enum Seed {
    Component(usize),
    Client(usize),
    Task(usize),
}

impl Seed {
    /// Returns true if two seeds are worth a comparison: a quick test, as there are many pairs.
    fn resembles(self, other: Seed, system: &TimedSystem) -> bool {
        let task = |it: usize| {
            let it = &system.tasks[it];
            (it.period, it.delay, it.permanent.is_some(), it.slots.len())
        };
        match (self, other) {
            (Seed::Component(one), Seed::Component(other)) => {
                let (one, other) = (&system.components[one], &system.components[other]);
                one.services.len() == other.services.len()
                    && (one.tasks.iter().map(|&it| task(it)))
                        .eq(other.tasks.iter().map(|&it| task(it)))
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
fn exchange(system: &TimedSystem, asked: &Watched, one: Seed, other: Seed) -> Option<(Unit, Unit)> {
    let mut it = Exchange::new(system);
    match (one, other) {
        (Seed::Component(one), Seed::Component(other)) => it.component(one, other),
        (Seed::Client(one), Seed::Client(other)) => it.client(one, other),
        (Seed::Task(one), Seed::Task(other)) => it.task(one, other),
        _ => None,
    }?;
    it.changes_nothing(asked).then_some((it.one, it.other))
}

impl Unit {
    fn holds(&self, seed: Seed) -> bool {
        match seed {
            Seed::Component(it) => self.components.contains(&it),
            Seed::Client(it) => self.clients.contains(&it),
            Seed::Task(it) => self.tasks.contains(&it),
        }
    }

    fn meets(&self, other: &Unit) -> bool {
        let meet = |one: &[usize], other: &[usize]| one.iter().any(|it| other.contains(it));
        meet(&self.tasks, &other.tasks)
            || meet(&self.automata, &other.automata)
            || meet(&self.services, &other.services)
            || meet(&self.components, &other.components)
            || meet(&self.clients, &other.clients)
            || meet(&self.machines, &other.machines)
            || meet(&self.codels, &other.codels)
    }
}

/// An exchange: the new name of every part of the system.
struct Exchange<'s> {
    system: &'s TimedSystem,
    tasks: Vec<usize>,
    automata: Vec<usize>,
    services: Vec<usize>,
    components: Vec<usize>,
    clients: Vec<usize>,
    machines: Vec<usize>,
    codels: Vec<usize>,
    one: Unit,
    other: Unit,
}

/// Pairs two parts of a kind. Returns `None` if either is already paired with another part, or must keep its
/// name. Otherwise returns true if the pair is new.
macro_rules! pair {
    ($self:ident, $kind:ident, $x:expr, $y:expr) => {{
        let (x, y) = ($x, $y);
        if x == y {
            if $self.$kind[x] != x {
                return None;
            }
            false
        } else if $self.$kind[x] == y && $self.one.$kind.contains(&x) {
            false
        } else if $self.$kind[x] == x && $self.$kind[y] == y {
            $self.$kind[x] = y;
            $self.$kind[y] = x;
            $self.one.$kind.push(x);
            $self.other.$kind.push(y);
            true
        } else {
            return None;
        }
    }};
}

impl<'s> Exchange<'s> {
    fn new(system: &'s TimedSystem) -> Self {
        let all = |n: usize| (0..n).collect();
        Exchange {
            system,
            tasks: all(system.tasks.len()),
            automata: all(system.automata.len()),
            services: all(system.services.len()),
            components: all(system.components.len()),
            clients: all(system.clients.len()),
            machines: all(system.machines.len()),
            codels: all(system.codels.len()),
            one: Unit::default(),
            other: Unit::default(),
        }
    }

    // ---- The parts of units ----------------------------------------------------------------

    fn each(
        &mut self,
        one: &[usize],
        other: &[usize],
        mut pair: impl FnMut(&mut Self, usize, usize) -> Option<()>,
    ) -> Option<()> {
        if one.len() != other.len() {
            return None;
        }
        for (&one, &other) in one.iter().zip(other) {
            pair(self, one, other)?;
        }
        Some(())
    }

    fn component(&mut self, x: usize, y: usize) -> Option<()> {
        if pair!(self, components, x, y) {
            let (one, other) = (&self.system.components[x], &self.system.components[y]);
            self.each(&one.tasks, &other.tasks, Self::task)?;
            self.each(&one.services, &other.services, Self::service)?;
        }
        Some(())
    }

    fn task(&mut self, x: usize, y: usize) -> Option<()> {
        if pair!(self, tasks, x, y) {
            let (one, other) = (&self.system.tasks[x], &self.system.tasks[y]);
            self.component(one.component, other.component)?;
            let list = |it: Option<usize>| it.into_iter().collect::<Vec<_>>();
            self.each(
                &list(one.permanent),
                &list(other.permanent),
                Self::automaton,
            )?;
            self.each(&one.slots, &other.slots, Self::automaton)?;
        }
        Some(())
    }

    fn automaton(&mut self, x: usize, y: usize) -> Option<()> {
        if pair!(self, automata, x, y) {
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

    fn machine(&mut self, x: usize, y: usize) -> Option<()> {
        if pair!(self, machines, x, y) {
            let codels = |it: usize| -> Vec<usize> {
                let states = self.system.machines[it].states.iter();
                states.map(|it| it.codel).collect()
            };
            let (one, other) = (codels(x), codels(y));
            self.each(&one, &other, Self::codel)?;
        }
        Some(())
    }

    fn service(&mut self, x: usize, y: usize) -> Option<()> {
        if pair!(self, services, x, y) {
            let (one, other) = (&self.system.services[x], &self.system.services[y]);
            self.component(one.component, other.component)?;
            let list = |it: Option<usize>| it.into_iter().collect::<Vec<_>>();
            self.each(&list(one.validate), &list(other.validate), Self::codel)?;
            self.each(&one.simple, &other.simple, Self::codel)?;
            self.each(&one.slots, &other.slots, Self::automaton)?;
        }
        Some(())
    }

    fn codel(&mut self, x: usize, y: usize) -> Option<()> {
        if pair!(self, codels, x, y) {
            let (one, other) = (&self.system.codels[x], &self.system.codels[y]);
            self.component(one.component, other.component)?;
        }
        Some(())
    }

    fn client(&mut self, x: usize, y: usize) -> Option<()> {
        if pair!(self, clients, x, y) {
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
        let parts = [
            (&self.one.tasks, &self.other.tasks),
            (&self.one.automata, &self.other.automata),
            (&self.one.services, &self.other.services),
            (&self.one.components, &self.other.components),
            (&self.one.clients, &self.other.clients),
        ];
        let apart = parts
            .iter()
            .all(|(one, other)| !one.iter().any(|it| other.contains(it)));
        apart
            && self.keeps_components()
            && self.keeps_tasks(asked)
            && self.keeps_machines()
            && self.keeps_codels()
            && self.keeps_services()
            && self.keeps_clients()
            && asked.predicates.iter().all(|it| self.keeps_predicate(it))
    }

    fn keeps_components(&self) -> bool {
        let system = self.system;
        (0..system.components.len()).all(|c| {
            let (from, to) = (
                &system.components[c],
                &system.components[self.components[c]],
            );
            // Tasks are started one after the other; a task without a permanent activity is started with the
            // previous one.
            let blocks = |tasks: &mut dyn Iterator<Item = usize>| {
                let mut blocks: Vec<Vec<usize>> = vec![Vec::new()];
                for task in tasks {
                    if system.tasks[task].permanent.is_some() {
                        blocks.push(vec![task]);
                        blocks.push(Vec::new());
                    } else {
                        blocks.last_mut().expect("there is one").push(task);
                    }
                }
                blocks.iter_mut().for_each(|it| it.sort_unstable());
                blocks
            };
            let renamed = blocks(&mut from.tasks.iter().map(|&it| self.tasks[it]));
            renamed == blocks(&mut to.tasks.iter().copied())
                && self.same_set(&from.services, &to.services, &self.services)
        })
    }

    fn keeps_tasks(&self, asked: &Watched) -> bool {
        let system = self.system;
        let tasks = (0..system.tasks.len()).all(|t| {
            let (from, to) = (&system.tasks[t], &system.tasks[self.tasks[t]]);
            asked.labels[t] == asked.labels[self.tasks[t]]
                && self.components[from.component] == to.component
                && (from.period, from.delay, from.keep_idle_tick)
                    == (to.period, to.delay, to.keep_idle_tick)
                && from.permanent.map(|it| self.automata[it]) == to.permanent
                && same_list(&from.slots, &to.slots, &self.automata)
        });
        tasks
            && (0..system.automata.len()).all(|a| {
                let (from, to) = (&system.automata[a], &system.automata[self.automata[a]]);
                self.tasks[from.task] == to.task
                    && self.machines[from.machine] == to.machine
                    && from.service.map(|it| self.services[it]) == to.service
            })
    }

    fn keeps_machines(&self) -> bool {
        let machines = &self.system.machines;
        (0..machines.len()).all(|m| {
            let (from, to) = (&machines[m], &machines[self.machines[m]]);
            (from.start, from.stop, from.loop_limit, from.rounds)
                == (to.start, to.stop, to.loop_limit, to.rounds)
                && from.states.len() == to.states.len()
                && from.states.iter().zip(&to.states).all(|(from, to)| {
                    self.codels[from.codel] == to.codel
                        && from.yields == to.yields
                        && from.is_async == to.is_async
                })
        })
    }

    fn keeps_codels(&self) -> bool {
        let codels = &self.system.codels;
        (0..codels.len()).all(|c| {
            let (from, to) = (&codels[c], &codels[self.codels[c]]);
            let mut renamed = CodelSet::default();
            from.conflicts
                .iter()
                .for_each(|it| renamed.insert(self.codels[it]));
            self.components[from.component] == to.component
                && (from.lower, from.upper) == (to.lower, to.upper)
                && renamed.iter().eq(to.conflicts.iter())
        })
    }

    fn keeps_services(&self) -> bool {
        let services = &self.system.services;
        (0..services.len()).all(|v| {
            let (from, to) = (&services[v], &services[self.services[v]]);
            self.components[from.component] == to.component
                && from.activity == to.activity
                && from.validate.map(|it| self.codels[it]) == to.validate
                && same_list(&from.simple, &to.simple, &self.codels)
                && same_list(&from.slots, &to.slots, &self.automata)
                && self.same_set(&from.interrupts, &to.interrupts, &self.services)
        })
    }

    fn keeps_clients(&self) -> bool {
        let clients = &self.system.clients;
        (0..clients.len()).all(|k| {
            let (from, to) = (&clients[k], &clients[self.clients[k]]);
            (&from.first, from.trackers) == (&to.first, to.trackers)
                && from.steps.len() == to.steps.len()
                && from.steps.iter().zip(&to.steps).all(|(from, to)| {
                    let renamed = match &from.action {
                        ClientAction::Send {
                            service,
                            trackers,
                            accepted,
                            aborts,
                        } => ClientAction::Send {
                            service: self.services[*service],
                            trackers: trackers.clone(),
                            accepted: accepted.clone(),
                            aborts: *aborts,
                        },
                        other => other.clone(),
                    };
                    renamed == to.action && from.next == to.next
                })
        })
    }

    fn keeps_predicate(&self, it: &Predicate) -> bool {
        words(it, &|atom| format!("{atom:?}"))
            == words(it, &|atom| format!("{:?}", self.atom(atom)))
    }

    fn atom(&self, it: &Atom) -> Atom {
        match it.clone() {
            Atom::Task(task, state) => Atom::Task(self.tasks[task], state),
            Atom::State {
                machine,
                state,
                phase,
            } => Atom::State {
                machine: self.machines[machine],
                state,
                phase,
            },
            Atom::Slot(service, status) => Atom::Slot(self.services[service], status),
            Atom::Handling {
                service,
                codel,
                phase,
            } => Atom::Handling {
                codel: codel.map(|it| self.codels[it]),
                service: self.services[service],
                phase,
            },
            Atom::ControlBusy(component) => Atom::ControlBusy(self.components[component]),
            Atom::Client(client, steps) => Atom::Client(self.clients[client], steps),
        }
    }

    fn same_set(&self, from: &[usize], to: &[usize], names: &[usize]) -> bool {
        let mut from: Vec<usize> = from.iter().map(|&it| names[it]).collect();
        let mut to = to.to_vec();
        from.sort_unstable();
        to.sort_unstable();
        from == to
    }
}

fn same_list(from: &[usize], to: &[usize], names: &[usize]) -> bool {
    from.iter().map(|&it| names[it]).eq(to.iter().copied())
}

/// Returns a predicate in words, whatever the order of the operands of `and` and `or`.
fn words(it: &Predicate, atom: &dyn Fn(&Atom) -> String) -> String {
    fn parts(it: &Predicate, and: bool, atom: &dyn Fn(&Atom) -> String, out: &mut Vec<String>) {
        match (it, and) {
            (Predicate::And(one, other), true) | (Predicate::Or(one, other), false) => {
                parts(one, and, atom, out);
                parts(other, and, atom, out);
            }
            _ => out.push(words(it, atom)),
        }
    }
    let list = |and: bool| {
        let mut out = Vec::new();
        parts(it, and, atom, &mut out);
        out.sort_unstable();
        out
    };
    match it {
        Predicate::Atom(it) => atom(it),
        Predicate::Leave(it) => format!("leave {}", atom(it)),
        Predicate::Not(it) => format!("not ({})", words(it, atom)),
        Predicate::And(..) => format!("({})", list(true).join(" and ")),
        Predicate::Or(..) => format!("({})", list(false).join(" or ")),
    }
}
