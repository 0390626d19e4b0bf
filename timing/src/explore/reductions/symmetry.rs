//! Symmetry reduction: symmetric parts of a system are not distinguished.
//!
//! *Units* are components, clients or tasks, with all their parts. Two units are symmetric if exchanging
//! them, with everything else in its place, changes neither the system nor the watched properties (see
//! [`automorphisms`]). Then a state and the state with the two units exchanged have the same future, with the
//! units exchanged, and it is enough to keep one of them: the one whose units are in ascending order of their
//! present state. (A quotient by automorphisms: C. Ip and D. Dill, *Better verification through symmetry*,
//! 1996.)
//!
//! The reconstruction of runs does not use symmetry, see `explore::search::layers::trace`: after a state was
//! put in order on the way, the rest of the run is renamed to the units as they were before.

mod automorphisms;

use std::cmp::Ordering;

use smallvec::SmallVec;

pub(crate) use self::automorphisms::Label;
use super::{Kind, Reason, Reduction, Setting};
use crate::explore::rules::Action;
use crate::explore::rules::published::Published;
use crate::explore::rules::published::layout::{Layout, control, tracker};
use crate::explore::state::State;
use crate::system::{Policy, Ticks, TimedSystem};

/// The symmetric units of a system.
#[derive(Debug)]
pub(super) struct Symmetry {
    orbits: Orbits,
    /// The order of tasks that wait for a core is irrelevant.
    any_order: bool,
}

/// The symmetric parts, by kind.
#[derive(Debug)]
pub(crate) struct Orbits {
    /// Classes of units that can be exchanged with each other, of at least two units.
    classes: Vec<Vec<Unit>>,
    /// By task, the tasks of its orbit, including itself.
    tasks: Vec<Vec<usize>>,
    /// By service, the services of its orbit, including itself.
    services: Vec<Vec<usize>>,
    /// Renaming that changes nothing.
    identity: Renaming,
}

/// The parts of a unit. Symmetric units list corresponding parts at the same index.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Unit {
    tasks: Vec<usize>,
    automata: Vec<usize>,
    services: Vec<usize>,
    components: Vec<usize>,
    clients: Vec<usize>,
    machines: Vec<usize>,
    codels: Vec<usize>,
    /// Places of the unit in a state, see [`Layout::places`].
    places: (Vec<usize>, Vec<usize>),
}

/// The numbering of executors.
#[derive(Debug, Clone, Copy)]
struct Executors {
    automata: usize,
    components: usize,
}

/// New names of all tasks, automata, services, components and clients after an exchange of units.
#[derive(Debug, Clone)]
pub(crate) struct Renaming {
    tasks: Vec<usize>,
    automata: Vec<usize>,
    components: Vec<usize>,
    services: Vec<usize>,
    clients: Vec<usize>,
    executors: Executors,
}

impl Orbits {
    /// Returns the orbits of a system without symmetry.
    pub(super) fn none(system: &TimedSystem) -> Self {
        Orbits::new(system, Vec::new())
    }

    fn new(system: &TimedSystem, classes: Vec<Vec<Unit>>) -> Self {
        let all = |n: usize| (0..n).collect();
        Orbits {
            tasks: orbits(&classes, system.tasks.len(), |it| &it.tasks),
            services: orbits(&classes, system.services.len(), |it| &it.services),
            classes,
            identity: Renaming {
                tasks: all(system.tasks.len()),
                automata: all(system.automata.len()),
                components: all(system.components.len()),
                services: all(system.services.len()),
                clients: all(system.clients.len()),
                executors: Executors {
                    automata: system.automata.len(),
                    components: system.components.len(),
                },
            },
        }
    }

    /// Returns the tasks in the orbit of a task, including itself.
    pub(crate) fn of_task(&self, task: usize) -> &[usize] {
        &self.tasks[task]
    }

    /// Returns the services in the orbit of a service, including itself.
    pub(crate) fn of_service(&self, service: usize) -> &[usize] {
        &self.services[service]
    }

    /// Returns the renaming that exchanges a task with another one of its orbit.
    pub(crate) fn exchange(&self, one: usize, other: usize) -> Renaming {
        let mut out = self.identity();
        for class in &self.classes {
            let of = |task: usize| class.iter().position(|unit| unit.tasks.contains(&task));
            if let (Some(one), Some(other)) = (of(one), of(other)) {
                out.put(&class[one], &class[other]);
                out.put(&class[other], &class[one]);
            }
        }
        out
    }

    /// Returns the renaming that changes nothing.
    pub(crate) fn identity(&self) -> Renaming {
        self.identity.clone()
    }
}

impl Reduction<Published<'_>> for Symmetry {
    const KIND: Kind = Kind::Symmetry;

    fn applies(setting: &Setting<Published>) -> Result<Self, Reason> {
        let (system, layout) = (setting.system(), &setting.rules.layout);
        let mut classes = automorphisms::classes(system, setting.asked);
        if classes.is_empty() {
            return Err(Reason::NothingAlike);
        }
        for it in classes.iter_mut().flatten() {
            it.places = layout.places(&it.tasks, &it.automata, &it.components, &it.clients);
        }
        Ok(Symmetry {
            orbits: Orbits::new(system, classes),
            any_order: system.platform.policy == Policy::Any,
        })
    }
}

impl Symmetry {
    /// Returns the orbits.
    pub(super) fn orbits(&self) -> &Orbits {
        &self.orbits
    }

    /// Puts the units of a state in order. Returns `None` if they already are.
    pub(super) fn order(&self, layout: &Layout, s: &mut State) -> Option<Renaming> {
        let mut moves: SmallVec<[(&Unit, &Unit); 8]> = SmallVec::new();
        for class in &self.orbits.classes {
            let compare = |one: &Unit, other: &Unit| self.compare(layout, s, one, other);
            if class.is_sorted_by(|one, other| compare(one, other).is_le()) {
                continue;
            }
            let mut order: SmallVec<[usize; 8]> = (0..class.len()).collect();
            order.sort_by(|&one, &other| compare(&class[one], &class[other]));
            let from = order.into_iter().enumerate();
            moves.extend(from.map(|(to, from)| (&class[from], &class[to])));
        }
        if moves.is_empty() {
            return None;
        }
        let mut renaming = self.orbits.identity();
        moves.iter().for_each(|(from, to)| renaming.put(from, to));
        let before = s.clone();
        self.rename(layout, (&moves, &renaming), &before, s);
        Some(renaming)
    }

    /// Compares the present states of two units. They are equal only if exchanging the units does not change
    /// the state.
    fn compare(&self, l: &Layout, s: &State, one: &Unit, other: &Unit) -> Ordering {
        let place = |list: &[u16], it: usize| list.iter().position(|&other| other as usize == it);
        let waiting = |unit: &Unit| -> SmallVec<[Option<usize>; 16]> {
            let queued = unit.tasks.iter().map(|&it| place(l.queue(s), it));
            let queued = queued.filter(|_| !self.any_order);
            let locks = self
                .executors_of(l, unit)
                .map(|e| place(l.lock_queue(s), e));
            queued.chain(locks).collect()
        };
        let times = |unit: &Unit| -> SmallVec<[Ticks; 32]> {
            unit.places.1.iter().map(|&it| s.t[it]).collect()
        };
        let discrete =
            (one.places.0.iter().map(|&it| s.d[it])).cmp(other.places.0.iter().map(|&it| s.d[it]));
        discrete
            .then_with(|| requests(l, s, one).cmp(requests(l, s, other)))
            .then_with(
                || match l.queue(s).is_empty() && l.lock_queue(s).is_empty() {
                    true => Ordering::Equal,
                    false => waiting(one).cmp(&waiting(other)),
                },
            )
            .then_with(|| self.handled(l, s, one).cmp(self.handled(l, s, other)))
            .then_with(|| times(one).cmp(&times(other)))
    }

    fn executors_of<'u>(&self, l: &'u Layout, unit: &'u Unit) -> impl Iterator<Item = usize> + 'u {
        let controls = unit.components.iter().map(|&it| l.control_executor(it));
        let clients = unit.clients.iter().map(|&it| l.client_executor(it));
        unit.automata.iter().copied().chain(controls).chain(clients)
    }

    /// Returns the components of a unit that handle requests, with the indices of client and service in the
    /// unit.
    fn handled<'u>(
        &self,
        l: &'u Layout,
        s: &'u State,
        unit: &'u Unit,
    ) -> impl Iterator<Item = (Result<usize, usize>, Option<usize>, Option<usize>)> + 'u {
        let at = |list: &[usize], it: u16| list.iter().position(|&other| other == it as usize);
        let busy = (0..l.components).filter(|&it| busy(l, s, it));
        busy.filter_map(move |component| {
            let client = at(&unit.clients, l.requester(s, component));
            let service = at(&unit.services, l.handled(s, component));
            let own = at(&unit.components, component as u16);
            (own.is_some() || client.is_some() || service.is_some())
                .then(|| (own.ok_or(component), client, service))
        })
    }

    /// Writes a state with units moved and all names changed accordingly.
    fn rename(
        &self,
        l: &Layout,
        (moves, to): (&[(&Unit, &Unit)], &Renaming),
        from: &State,
        out: &mut State,
    ) {
        for (one, other) in moves {
            for (&x, &y) in one.places.0.iter().zip(&other.places.0) {
                out.d[y] = from.d[x];
            }
            for (&x, &y) in one.places.1.iter().zip(&other.places.1) {
                out.t[y] = from.t[x];
            }
            for (&x, &y) in one.components.iter().zip(&other.components) {
                l.set_requester(out, y, l.requester(from, x));
                l.set_handled(out, y, l.handled(from, x));
            }
        }
        for component in (0..l.components).filter(|&it| busy(l, from, it)) {
            let at = to.components[component];
            let client = l.requester(from, component) as usize;
            l.set_requester(out, at, to.clients[client] as u16);
            let service = l.handled(from, component) as usize;
            l.set_handled(out, at, to.services[service] as u16);
        }
        for (x, &y) in to.clients.iter().enumerate() {
            for (t, &value) in l.trackers(from, x).iter().enumerate() {
                let slot = value.checked_sub(tracker::SLOT);
                let slot = slot.map(|a| tracker::SLOT + to.automata[a as usize] as u16);
                l.set_tracker(out, y, t, slot.unwrap_or(value));
            }
        }
        l.rename_queues(out, |task| to.tasks[task], |e| to.executor(e));
        if self.any_order {
            l.sort_queue(out);
        }
    }
}

/// Returns, for each of `n` parts of units, the parts of its orbit.
fn orbits(
    classes: &[Vec<Unit>],
    n: usize,
    parts: impl Fn(&Unit) -> &Vec<usize>,
) -> Vec<Vec<usize>> {
    let mut out: Vec<Vec<usize>> = (0..n).map(|it| vec![it]).collect();
    for class in classes {
        for place in 0..parts(&class[0]).len() {
            let orbit: Vec<usize> = class.iter().map(|unit| parts(unit)[place]).collect();
            for &it in &orbit {
                out[it].clone_from(&orbit);
            }
        }
    }
    out
}

/// Returns true if the control task of a component is handling a request.
fn busy(l: &Layout, s: &State, component: usize) -> bool {
    matches!(l.control(s, component), control::VALIDATE | control::SIMPLE)
}

/// Returns the trackers of the clients of a unit: slots of the unit by their index in it, other values as
/// they are.
fn requests<'u>(
    l: &'u Layout,
    s: &'u State,
    unit: &'u Unit,
) -> impl Iterator<Item = Result<usize, u16>> + 'u {
    let trackers = unit.clients.iter().flat_map(|&it| l.trackers(s, it));
    trackers.map(|&value| {
        let slot = value.checked_sub(tracker::SLOT);
        let own = slot.and_then(|a| unit.automata.iter().position(|&it| it == a as usize));
        own.ok_or(value)
    })
}

impl Renaming {
    /// Renames the parts of one unit to those of another.
    fn put(&mut self, from: &Unit, to: &Unit) {
        let parts = [
            (&mut self.tasks, &from.tasks, &to.tasks),
            (&mut self.automata, &from.automata, &to.automata),
            (&mut self.components, &from.components, &to.components),
            (&mut self.services, &from.services, &to.services),
            (&mut self.clients, &from.clients, &to.clients),
        ];
        for (map, from, to) in parts {
            for (&from, &to) in from.iter().zip(to) {
                map[from] = to;
            }
        }
    }

    /// Returns the inverse renaming.
    pub(crate) fn inverse(&self) -> Renaming {
        let inverse = |map: &[usize]| {
            let mut out = vec![0; map.len()];
            for (from, &to) in map.iter().enumerate() {
                out[to] = from;
            }
            out
        };
        Renaming {
            tasks: inverse(&self.tasks),
            automata: inverse(&self.automata),
            components: inverse(&self.components),
            services: inverse(&self.services),
            clients: inverse(&self.clients),
            executors: self.executors,
        }
    }

    /// Returns the composition of two renamings, `first` before this one.
    pub(crate) fn after(&self, first: &Renaming) -> Renaming {
        let both = |first: &[usize], then: &[usize]| first.iter().map(|&it| then[it]).collect();
        Renaming {
            tasks: both(&first.tasks, &self.tasks),
            automata: both(&first.automata, &self.automata),
            components: both(&first.components, &self.components),
            services: both(&first.services, &self.services),
            clients: both(&first.clients, &self.clients),
            executors: self.executors,
        }
    }

    pub(crate) fn task(&self, task: usize) -> usize {
        self.tasks[task]
    }

    pub(crate) fn executor(&self, executor: usize) -> usize {
        let Executors {
            automata,
            components,
        } = self.executors;
        if executor < automata {
            self.automata[executor]
        } else if executor < automata + components {
            automata + self.components[executor - automata]
        } else {
            // Other rules number executors in another way, and exchange nothing: each keeps its number.
            let client = self.clients.get(executor - automata - components);
            client.map_or(executor, |it| automata + components + it)
        }
    }

    pub(crate) fn action(&self, action: Action) -> Action {
        match action {
            Action::Proceed { client, next } => Action::Proceed {
                client: self.clients[client],
                next,
            },
            Action::Release { task } => Action::Release {
                task: self.tasks[task],
            },
            Action::Grant { task } => Action::Grant {
                task: self.tasks[task],
            },
            Action::Tick { task } => Action::Tick {
                task: self.tasks[task],
            },
            Action::Acquire { executor } => Action::Acquire {
                executor: self.executor(executor),
            },
            Action::Finish { executor, outcome } => Action::Finish {
                executor: self.executor(executor),
                outcome,
            },
            Action::Preempt { executor, by } => Action::Preempt {
                executor: self.executor(executor),
                by: self.executor(by),
            },
            Action::Ready { executor } => Action::Ready {
                executor: self.executor(executor),
            },
            Action::Begin { task } => Action::Begin {
                task: self.tasks[task],
            },
            Action::Wake { task } => Action::Wake {
                task: self.tasks[task],
            },
            Action::Ticket { executor } => Action::Ticket {
                executor: self.executor(executor),
            },
            Action::Mark { executor, taken } => Action::Mark {
                executor: executor.map(|it| self.executor(it)),
                taken,
            },
            Action::Reply { component } => Action::Reply {
                component: self.components[component],
            },
            Action::Shut { component } => Action::Shut {
                component: self.components[component],
            },
            Action::Signal { component } => Action::Signal {
                component: self.components[component],
            },
            Action::Request { client, next } => Action::Request {
                client: self.clients[client],
                next,
            },
        }
    }
}
