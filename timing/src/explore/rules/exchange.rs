//! Where a state has the numbers of a part of the system, and where it names parts.

use std::ops::{Index, IndexMut};

use super::Rules;
use crate::explore::state::State;

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
    /// Places of activities, as the rules number them ([`Rules::places`]).
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

/// Rules whose states can be renamed.
pub(crate) trait Exchangeable: Rules {
    /// Adds the executors of a unit, and its places of activities.
    fn complete(&self, parts: &mut Parts);

    /// Returns the numbers of a unit, in the same order for all units that can be exchanged.
    fn unit_places(&self, parts: &Parts) -> UnitPlaces;

    /// Returns the names in a state.
    fn names(&self) -> Names;

    /// Restores the normal form of sets after a renaming.
    fn restore_order(&self, s: &mut State);
}
