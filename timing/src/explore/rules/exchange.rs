//! Where a state has the numbers of a part of the system, and where it names parts.

use std::ops::{Index, IndexMut};

use super::SystemRules;
use super::layout::{EdfTimes, OF_COMPONENT, OF_TASK};
use super::points::Cycle;
use super::status::tracker;
use crate::explore::state::State;
use crate::system::{ClientId, ComponentId, Policy, ServiceId};

/// The kinds of parts that a state can name, or that belong to a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    Task,
    Automaton,
    Service,
    Component,
    Client,
    Machine,
    Codel,
    /// Executors, as the rules number them.
    Executor,
    /// Places of activities, as the rules number them ([`Rules::places`](super::Rules::places)).
    Place,
}

impl Part {
    pub(crate) const COUNT: usize = 9;
}

/// Lists of numbers of parts, by kind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Parts([Vec<usize>; Part::COUNT]);

impl Parts {
    /// Returns the lists, by kind.
    pub(crate) fn lists(&self) -> &[Vec<usize>; Part::COUNT] {
        &self.0
    }

    /// Returns the lists, by kind, for changes.
    pub(crate) fn lists_mut(&mut self) -> &mut [Vec<usize>; Part::COUNT] {
        &mut self.0
    }
}

impl Index<Part> for Parts {
    type Output = Vec<usize>;

    fn index(&self, part: Part) -> &Vec<usize> {
        &self.0[part as usize]
    }
}

impl IndexMut<Part> for Parts {
    fn index_mut(&mut self, part: Part) -> &mut Vec<usize> {
        &mut self.0[part as usize]
    }
}

/// The numbers in a state that belong to a unit: indices in the discrete part, and in the times.
#[derive(Debug, Clone, Default)]
pub(crate) struct UnitPlaces {
    pub(crate) discrete: Vec<usize>,
    pub(crate) times: Vec<usize>,
}

/// Where a state names parts of the system.
#[derive(Debug, Clone, Default)]
pub(crate) struct Names {
    /// Single numbers: index in the discrete part, kind, and the number that names the first part; smaller
    /// numbers are no names.
    pub(crate) single: Vec<(usize, Part, u16)>,
    /// Lists: the index of the length, which the names follow, the greatest length, and the kind of the
    /// names.
    pub(crate) lists: Vec<(usize, usize, Part)>,
    /// Lists in an order that is only a normal form: sets.
    pub(crate) sets: Vec<(usize, usize, Part)>,
}

impl SystemRules<'_> {
    /// Adds the executors of a unit, and its places of activities.
    pub(crate) fn complete(&self, parts: &mut Parts) {
        let l = &self.layout;
        let threads = match self.points.cycle {
            Cycle::Jobs => {
                parts[Part::Place] = parts[Part::Automaton].clone();
                &parts[Part::Automaton]
            }
            Cycle::Passes => {
                let slots = parts[Part::Task].iter().flat_map(|&task| l.slots(task));
                parts[Part::Place] = slots.copied().collect();
                &parts[Part::Task]
            }
        };
        let controls = parts[Part::Component].iter();
        let controls = controls.map(|&component| l.control_executor(component.into()));
        let clients = parts[Part::Client].iter();
        let clients = clients.map(|&client| l.client_executor(client.into()));
        let executors = threads.iter().copied().chain(controls).chain(clients);
        parts[Part::Executor] = executors.collect();
    }

    /// Returns the numbers of a unit, in the same order for all units that can be exchanged.
    pub(crate) fn unit_places(&self, parts: &Parts) -> UnitPlaces {
        let l = &self.layout;
        let (mut d, mut t) = (Vec::new(), Vec::new());
        for &task in &parts[Part::Task] {
            let base = l.task_base + OF_TASK * task;
            d.extend(base..base + OF_TASK);
            t.push(task);
            match l.edf {
                Some(EdfTimes::Ages { tick, kept }) => t.extend([tick + task, kept + task]),
                Some(EdfTimes::Slack(base)) => t.push(base + task),
                None => {}
            }
            t.extend(l.response[task].into_iter().chain(l.kept(task)));
        }
        for &slot in &parts[Part::Place] {
            let base = l.slot_base + l.of_slot * slot;
            d.extend(base..base + l.of_slot);
            let (visits, most) = l.visits[slot];
            d.extend(visits..visits + most);
        }
        d.extend(
            (parts[Part::Service].iter())
                .filter_map(|&service| l.success[ServiceId::from(service)]),
        );
        for component in parts[Part::Component].iter().map(|&id| ComponentId::from(id)) {
            let base = l.component_place(component);
            d.extend(base..base + OF_COMPONENT);
            if let (Some(base), Cycle::Passes) = (l.lock_queue[component], self.points.cycle) {
                d.extend(base..base + 2 + self.system.components[component].tasks.len());
            }
            d.extend(l.shutdown[component]);
        }
        for client in parts[Part::Client].iter().map(|&id| ClientId::from(id)) {
            let base = l.client_base[client];
            d.extend(base..base + 2 + self.system.clients[client].trackers);
        }
        for &executor in &parts[Part::Executor] {
            d.push(l.phase_place(executor));
            t.extend([l.window_place(executor), l.window_place(executor) + 1]);
        }
        UnitPlaces { discrete: d, times: t }
    }

    /// Returns the names in a state.
    pub(crate) fn names(&self) -> Names {
        let l = &self.layout;
        let mut out = Names::default();
        if self.points.cycle == Cycle::Passes {
            let automata = (0..l.all_slots()).map(|slot| l.slot_base + l.of_slot * slot + 2);
            (out.single).extend(automata.map(|place| (place, Part::Automaton, 1)));
        }
        for component in self.system.components.keys() {
            let base = l.component_place(component);
            out.single.push((base + 2, Part::Service, 1));
            out.single.push((base + 4, Part::Client, 1));
            out.single.push((base + 5, Part::Place, 1));
        }
        for (client, &base) in l.client_base.iter_enumerated() {
            let trackers = base + 2..base + 2 + self.system.clients[client].trackers;
            (out.single).extend(trackers.map(|place| (place, Part::Place, tracker::SLOT)));
        }
        for (component, base) in l.lock_queue.iter_enumerated() {
            let Some(base) = *base else { continue };
            let capacity = match self.points.cycle {
                Cycle::Passes => 1 + self.system.components[component].tasks.len(),
                Cycle::Jobs if usize::from(component) == 0 => l.executors(),
                // The queue that all components share.
                Cycle::Jobs => continue,
            };
            out.lists.push((base, capacity, Part::Executor));
        }
        if let Some((base, capacity)) = l.core_queue {
            let part = match self.points.cycle {
                Cycle::Passes => Part::Executor,
                Cycle::Jobs => Part::Task,
            };
            match self.system.platform.policy {
                Policy::Any => out.sets.push((base, capacity, part)),
                _ => out.lists.push((base, capacity, part)),
            }
        }
        out
    }

    /// Restores the normal form of sets after a renaming.
    pub(crate) fn restore_order(&self, s: &mut State) {
        if let (Some((base, _)), Policy::Any) =
            (self.layout.core_queue, self.system.platform.policy)
        {
            let length = s.d[base] as usize;
            s.d[base + 1..=base + length].sort_unstable();
        }
    }
}
