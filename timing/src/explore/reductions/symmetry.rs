//! Symmetry reduction: symmetric parts of a system are not distinguished.
//!
//! *Units* are components, clients or tasks, with all their parts. Two units are symmetric if exchanging
//! them, with everything else in its place, changes neither the system nor the watched properties (see
//! [`automorphisms`]). Then a state and the state with the two units exchanged have the same future, with the
//! units exchanged, and it is enough to keep one of them: the one whose units are in ascending order of their
//! present state. (A quotient by automorphisms: C. Ip and D. Dill, *Better verification through symmetry*,
//! 1996.)
//!
//! The rules say where a state holds the numbers of a unit, and where it names parts of the system
//! (`explore::rules::exchange`). An exchange moves the numbers and renames the names. This is sound for
//! rules that use the index of a part for nothing else than to find it; where an order of indices is only
//! a normal form, the rules restore it ([`SystemRules::restore_order`]).
//!
//! The reconstruction of runs does not use symmetry, see `explore::search::layers::trace`: after a state was
//! put in order on the way, the rest of the run is renamed to the units as they were before.

mod automorphisms;
mod renaming;

use std::cell::OnceCell;
use std::cmp::Ordering;

use smallvec::SmallVec;
use typed_index_collections::TiVec;

pub(crate) use self::automorphisms::Label;
pub(crate) use self::renaming::Renaming;
use super::{Kind, Reason, Reduction, Setting};
use crate::explore::rules::{Names, Part, Parts, Rules, SystemRules, UnitPlaces};
use crate::explore::state::State;
use crate::property::Atom;
use crate::system::{Policy, ServiceId};

/// A unit, and its numbers in a state.
#[derive(Debug, Clone)]
struct Unit {
    parts: Parts,
    /// All numbers of the unit in the discrete part: plain, named and lists.
    discrete: Vec<usize>,
    /// Numbers that are no names.
    plain: Vec<usize>,
    /// Numbers that may be names.
    named: Vec<usize>,
    /// Lists of names: the index of the length, and the kind of the names.
    lists: Vec<(usize, Part)>,
    times: Vec<usize>,
}

/// The symmetric units of a system.
#[derive(Debug)]
pub(super) struct Symmetry {
    orbits: Orbits,
    classes: Vec<Vec<Unit>>,
    names: Names,
    /// By index in the discrete part, the kind of a single name and the number of the first part.
    at: Vec<Option<(Part, u16)>>,
    /// By kind and number of a part, its class, unit and index there.
    members: [Vec<Option<Member>>; Part::COUNT],
    /// By class, the names that belong to no unit of the class.
    outside: Vec<Names>,
}

/// The class and the unit of a part, and its index in the unit.
type Member = (u16, u16, u16);

/// A place that names a part of a unit, and the index of the part in the unit.
type Named = (usize, u16);

/// The places outside a class that name parts of its units, in ascending order of the units.
struct NamedOutside(SmallVec<[(u16, Named); 16]>);

impl NamedOutside {
    /// Returns the places that name parts of a unit.
    fn of(&self, unit: usize) -> impl Iterator<Item = &Named> {
        let begin = self.0.partition_point(|&(of, _)| usize::from(of) < unit);
        let all = self.0[begin..].iter();
        all.take_while(move |&&(of, _)| usize::from(of) == unit).map(|(_, named)| named)
    }
}

/// The symmetric parts, by kind.
#[derive(Debug)]
pub(crate) struct Orbits {
    /// Classes of units that can be exchanged with each other, of at least two units.
    classes: Vec<Vec<Parts>>,
    /// By task, the tasks of its orbit, including itself.
    tasks: Vec<Vec<usize>>,
    /// By service, the services of its orbit, including itself.
    services: TiVec<ServiceId, Vec<ServiceId>>,
    /// Renaming that changes nothing.
    identity: Renaming,
}

impl Orbits {
    /// Returns the orbits of a system without symmetry.
    pub(super) fn none<R: Rules>(rules: &R) -> Self {
        Orbits::new(rules, Vec::new())
    }

    fn new<R: Rules>(rules: &R, classes: Vec<Vec<Parts>>) -> Self {
        let identity = Renaming::identity(rules);
        let orbits = |part: Part| {
            let mut out: Vec<Vec<usize>> =
                identity.of(part).iter().map(|&index| vec![index]).collect();
            for class in &classes {
                for place in 0..class[0][part].len() {
                    let orbit: Vec<usize> = class.iter().map(|unit| unit[part][place]).collect();
                    for &part in &orbit {
                        out[part].clone_from(&orbit);
                    }
                }
            }
            out
        };
        Orbits {
            tasks: orbits(Part::Task),
            services: (orbits(Part::Service).into_iter())
                .map(|orbit| orbit.into_iter().map(ServiceId::from).collect())
                .collect(),
            identity,
            classes,
        }
    }

    /// Returns the tasks in the orbit of a task, including itself.
    pub(crate) fn of_task(&self, task: usize) -> &[usize] {
        &self.tasks[task]
    }

    /// Returns the services in the orbit of a service, including itself.
    pub(crate) fn of_service(&self, service: ServiceId) -> &[ServiceId] {
        &self.services[service]
    }

    /// Returns the atoms into which exchanges of units turn an atom, except itself.
    pub(crate) fn of_atom(&self, atom: &Atom) -> Vec<Atom> {
        let mut out = vec![atom.clone()];
        for class in &self.classes {
            for atom in out.clone() {
                for (at, one) in class.iter().enumerate() {
                    for other in &class[at + 1..] {
                        let exchanged = self.exchange_units(one, other).atom(&atom);
                        if !out.contains(&exchanged) {
                            out.push(exchanged);
                        }
                    }
                }
            }
        }
        out.split_off(1)
    }

    /// Returns the renaming that exchanges a task with another one of its orbit.
    pub(crate) fn exchange(&self, one: usize, other: usize) -> Renaming {
        for class in &self.classes {
            let of = |task: usize| class.iter().find(|unit| unit[Part::Task].contains(&task));
            if let (Some(one), Some(other)) = (of(one), of(other)) {
                return self.exchange_units(one, other);
            }
        }
        self.identity()
    }

    fn exchange_units(&self, one: &Parts, other: &Parts) -> Renaming {
        let mut out = self.identity();
        out.put(one, other);
        out.put(other, one);
        out
    }

    /// Returns the renaming that changes nothing.
    pub(crate) fn identity(&self) -> Renaming {
        self.identity.clone()
    }
}

impl Reduction for Symmetry {
    const KIND: Kind = Kind::Symmetry;

    fn applies(setting: &Setting) -> Result<Self, Reason> {
        let system = setting.system();
        // A free core goes to the ready thread of the lowest number, without an action.
        if system.preempts() && system.platform.policy == Policy::Fair {
            return Err(Reason::FairCores);
        }
        let mut classes = automorphisms::classes(system, setting.asked);
        if classes.is_empty() {
            return Err(Reason::NothingAlike);
        }
        let rules = setting.rules;
        for parts in classes.iter_mut().flatten() {
            rules.complete(parts);
        }
        Ok(Symmetry::new(rules, classes))
    }
}

impl Symmetry {
    fn new(rules: &SystemRules, classes: Vec<Vec<Parts>>) -> Self {
        let names = rules.names();
        let orbits = Orbits::new(rules, classes);
        let numbers = rules.frame().blank().d.len();
        let mut at = vec![None; numbers];
        for &(place, part, first) in &names.single {
            at[place] = Some((part, first));
        }
        let unit = |parts: &Parts| {
            let UnitPlaces { discrete, times } = rules.unit_places(parts);
            let own = names.lists.iter().filter(|triple| discrete.contains(&triple.0));
            let of_lists: Vec<usize> =
                (own.clone()).flat_map(|&(base, capacity, _)| base..=base + capacity).collect();
            let rest = discrete.iter().filter(|index| !of_lists.contains(index));
            let (named, plain) = rest.partition(|&&index| at[index].is_some());
            Unit {
                parts: parts.clone(),
                lists: own.map(|&(base, _, part)| (base, part)).collect(),
                discrete,
                plain,
                named,
                times,
            }
        };
        let classes: Vec<Vec<Unit>> =
            (orbits.classes.iter()).map(|class| class.iter().map(unit).collect()).collect();
        let mut members: [Vec<Option<Member>>; Part::COUNT] = Default::default();
        for (list, all) in members.iter_mut().zip(orbits.identity.all()) {
            list.resize(all.len(), None);
        }
        for (c, class) in classes.iter().enumerate() {
            for (u, unit) in class.iter().enumerate() {
                for (list, numbers) in members.iter_mut().zip(unit.parts.lists()) {
                    for (i, &number) in numbers.iter().enumerate() {
                        list[number] = Some((c as u16, u as u16, i as u16));
                    }
                }
            }
        }
        let outside = (classes.iter())
            .map(|class| {
                let own = |place: usize| class.iter().any(|class| class.discrete.contains(&place));
                Names {
                    single: names.single.iter().filter(|triple| !own(triple.0)).copied().collect(),
                    lists: names.lists.iter().filter(|triple| !own(triple.0)).copied().collect(),
                    sets: Vec::new(),
                }
            })
            .collect();
        Symmetry { orbits, classes, names, at, members, outside }
    }

    pub(super) fn orbits(&self) -> &Orbits {
        &self.orbits
    }

    /// Puts the units of a state in order. Returns `None` if they already are.
    pub(super) fn order(&self, rules: &SystemRules, s: &mut State) -> Option<Renaming> {
        let mut moves: SmallVec<[(&Unit, &Unit); 8]> = SmallVec::new();
        for (c, class) in self.classes.iter().enumerate() {
            let outside = OnceCell::new();
            let compare = |&one: &usize, &other: &usize| self.compare(s, c, (one, other), &outside);
            let mut order: SmallVec<[usize; 8]> = (0..class.len()).collect();
            if order.is_sorted_by(|one, other| compare(one, other).is_le()) {
                continue;
            }
            order.sort_by(compare);
            let from = order.into_iter().enumerate();
            moves.extend(from.map(|(to, from)| (&class[from], &class[to])));
        }
        if moves.is_empty() {
            return None;
        }
        let mut renaming = self.orbits.identity();
        moves.iter().for_each(|(from, to)| renaming.put(&from.parts, &to.parts));
        let before = s.clone();
        for (one, other) in moves {
            for (&x, &y) in one.discrete.iter().zip(&other.discrete) {
                s.d[y] = before.d[x];
            }
            for (&x, &y) in one.times.iter().zip(&other.times) {
                s.t[y] = before.t[x];
            }
        }
        self.rename(&renaming, s);
        rules.restore_order(s);
        Some(renaming)
    }

    /// Compares the present states of two units of a class. Units that are equal can be exchanged without a
    /// change of the state, except for their order in sets.
    fn compare(
        &self,
        s: &State,
        class: usize,
        (one, other): (usize, usize),
        outside: &OnceCell<NamedOutside>,
    ) -> Ordering {
        let units = &self.classes[class];
        let (x, y) = (&units[one], &units[other]);
        let plain = |index: &'_ usize| s.d[*index];
        let time = |index: &'_ usize| s.t[*index];
        let named = |unit: usize| {
            let places = units[unit].named.iter();
            places.map(move |&place| self.relative(s, place, (class, unit)))
        };
        let listed = |unit: usize| {
            units[unit].lists.iter().map(move |&(base, part)| {
                let list = &s.d[base + 1..=base + s.d[base] as usize];
                let index =
                    |&number: &u16| self.index_in(part, number, (class, unit)).ok_or(number);
                list.iter().map(index).collect::<SmallVec<[_; 8]>>()
            })
        };
        (x.plain.iter().map(plain).cmp(y.plain.iter().map(plain)))
            .then_with(|| named(one).cmp(named(other)))
            .then_with(|| listed(one).cmp(listed(other)))
            .then_with(|| {
                let outside = outside.get_or_init(|| self.named_outside(s, class));
                outside.of(one).cmp(outside.of(other))
            })
            .then_with(|| x.times.iter().map(time).cmp(y.times.iter().map(time)))
    }

    /// Returns the number at a place: the index of the named part in a unit, or the number itself.
    fn relative(&self, s: &State, place: usize, unit: (usize, usize)) -> Result<u16, u16> {
        let number = s.d[place];
        let index = self.at[place].and_then(|(part, first)| {
            let named = number.checked_sub(first)?;
            self.index_in(part, named, unit)
        });
        index.ok_or(number)
    }

    /// Returns the index of a part in a unit; `None` if it belongs to another unit or to none.
    fn index_in(&self, part: Part, number: u16, unit: (usize, usize)) -> Option<u16> {
        let (c, u, index) = self.members[part as usize][number as usize]?;
        ((c as usize, u as usize) == unit).then_some(index)
    }

    /// Returns where the rest of the state names parts of the units of a class.
    fn named_outside(&self, s: &State, class: usize) -> NamedOutside {
        let mut found: SmallVec<[(u16, Named); 16]> = SmallVec::new();
        let mut look = |place: usize, part: Part, number: u16| {
            if let Some((c, unit, index)) = self.members[part as usize][number as usize]
                && c as usize == class
            {
                found.push((unit, (place, index)));
            }
        };
        let outside = &self.outside[class];
        for &(place, part, first) in &outside.single {
            if let Some(number) = s.d[place].checked_sub(first) {
                look(place, part, number);
            }
        }
        for &(base, _, part) in &outside.lists {
            for place in base + 1..=base + s.d[base] as usize {
                look(place, part, s.d[place]);
            }
        }
        // The sort is stable: the names of a unit stay in the order of their places in `outside`.
        found.sort_by_key(|&(unit, _)| unit);
        NamedOutside(found)
    }

    /// Renames all names of a state.
    fn rename(&self, to: &Renaming, s: &mut State) {
        for &(place, part, first) in &self.names.single {
            if let Some(named) = s.d[place].checked_sub(first) {
                s.d[place] = first + to.of(part)[named as usize] as u16;
            }
        }
        for &(base, _, part) in self.names.lists.iter().chain(&self.names.sets) {
            for place in base + 1..=base + s.d[base] as usize {
                s.d[place] = to.of(part)[s.d[place] as usize] as u16;
            }
        }
    }
}
