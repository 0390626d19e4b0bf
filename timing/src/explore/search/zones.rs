//! Zones: a search in dense time for predicates that are never reached.
//!
//! Without periodic tasks, only the order matters in which codels and delays end. With integer times, the
//! number of states grows with their durations; *zones*, sets of remaining times (see [`Zone`]), depend on
//! the order alone. So a second search next to the breadth-first search, with most of the effort, gives
//! states zones instead of windows. Rules, ample sets and symmetry are the same; a window is then the
//! shortest and longest time in the zone. A property that no state with a zone has is proved never to hold. A
//! property that some state has is left to the other search, which reaches the property with a run.

mod zone;

use std::collections::VecDeque;

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use self::zone::{GREATEST, Zone};
use super::layers::Layers;
use crate::explore::never_observed::NeverObserved;
use crate::explore::observe;
use crate::explore::reductions::{Kind, Kinds, Reason, Reduced, Reductions, Watched};
use crate::explore::rules::{Action, Enabled, SystemRules};
use crate::explore::state::{Clocks, State};
use crate::explore::watch::{Limits, Watch};
use crate::property::Predicate;
use crate::system::{ClientAction, FOREVER, ServiceId, Ticks, TimedSystem};

/// Steps after which a search counts as large.
const STEPS_OF_LARGE_SEARCH: u64 = 1000;

/// Time from which on a duration counts as long, in base units.
const MIN_LONG_TIME: Ticks = 8;

/// Number of steps in zones for each step of the breadth-first search.
const ZONE_STEPS_PER_STEP: u64 = 4;

/// Steps between two polls of the limits.
const STEPS_PER_POLL: u64 = 128;

/// Bytes for a key in addition to its contents, with room to grow.
const KEY_BYTES: usize = 2 * size_of::<(Box<[u16]>, Vec<(u32, Zone)>)>();

/// Upper limit on committed steps that are performed at once. It is needed because a client may loop without
/// time passing.
const MAX_COMMITTED_STEPS: usize = 16;

/// A search in zones for predicates and for deadlocks.
pub(super) struct Zones<'a, R: Reduced> {
    rules: R,
    reductions: R::Reductions,
    goals: &'a [Predicate],
    /// Goals that were reached.
    reached: Vec<bool>,
    /// Jobs and atoms that no state has had so far.
    absent: NeverObserved,
    deadlock: bool,
    /// Reached zones with their numbers, by discrete state.
    passed: FxHashMap<Box<[u16]>, Vec<(u32, Zone)>>,
    /// Zones that were covered by another one before their examination, by number.
    covered: Vec<bool>,
    todo: VecDeque<(u32, State, Zone)>,
    steps: u64,
    bytes: usize,
}

impl<'a, R: Reduced> Zones<'a, R> {
    fn new(rules: &R, goals: &'a [Predicate], without: Kinds) -> Self {
        let system = rules.system();
        let asked = Watched::only(system, goals.iter().collect());
        let rules = rules.with_clocks(&Clocks::none(system.tasks.len()));
        let reductions = R::Reductions::new(&rules, &asked, without);
        let mut out = Zones {
            absent: NeverObserved::of_predicates(goals, reductions.orbits()),
            reductions,
            rules,
            goals,
            reached: vec![false; goals.len()],
            deadlock: false,
            passed: FxHashMap::default(),
            covered: Vec::new(),
            todo: VecDeque::new(),
            steps: 0,
            bytes: 0,
        };
        let mut s = out.rules.initial();
        let mut zone = Zone::new();
        out.look(None, &s);
        out.set_zone(&mut s, &mut zone);
        out.keep(s, zone);
        out
    }

    /// Continues until this many steps have been taken.
    fn run(&mut self, steps: u64) {
        let mut enabled = Enabled::default();
        let mut followed = Vec::new();
        while self.steps < steps
            && let Some((number, s, zone)) = self.todo.pop_front()
        {
            self.bytes -= self.bytes_to_do(&zone);
            if self.covered[number as usize] {
                continue;
            }
            self.rules.enabled(&s, &mut enabled);
            self.reductions.persistent(&self.rules, &s, &enabled, &mut followed);
            for &action in &followed {
                let (mut s, mut zone) = (s.clone(), zone.clone());
                self.step(&mut s, &mut zone, action);
                self.keep(s, zone);
            }
        }
    }

    /// Returns true if a request for a service, or for one of its orbit, was refused.
    fn refused(&self, service: ServiceId) -> bool {
        let mut orbit = self.reductions.orbits().of_service(service).iter();
        orbit.any(|&orbit| self.rules.has_refused(orbit))
    }

    /// Performs an action.
    fn step(&mut self, s: &mut State, zone: &mut Zone, action: Action) {
        self.steps += 1;
        let before = s.clone();
        if let Action::Finish { executor, .. } = action {
            zone.end(executor);
        }
        self.rules.apply(s, action);
        self.look(Some(&before), s);
        self.set_zone(s, zone);
    }

    /// Checks a state that was just entered.
    fn look(&mut self, before: Option<&State>, s: &State) {
        for (goal, reached) in self.goals.iter().zip(&mut self.reached) {
            *reached = *reached || observe::predicate(&self.rules, before, s, goal);
        }
        let orbits = self.reductions.orbits();
        self.absent.look(&self.rules, s, orbits);
    }

    /// Updates the zone of a state, and its windows, to the present executions.
    fn set_zone(&self, s: &mut State, zone: &mut Zone) {
        let l = self.rules.frame();
        let executors: SmallVec<[usize; 12]> = l.executing(s).collect();
        zone.set_executors(&executors, |executor| l.window(s, executor));
        self.set_windows(s, zone);
    }

    fn set_windows(&self, s: &mut State, zone: &Zone) {
        for (executor, window) in zone.windows() {
            self.rules.frame().set_window(s, executor, window);
        }
    }

    /// Keeps a state for examination, after the committed steps that follow without a choice and, if time can
    /// pass, after any time.
    fn keep(&mut self, mut s: State, mut zone: Zone) {
        let mut enabled = Enabled::default();
        self.rules.enabled(&s, &mut enabled);
        for _ in 0..MAX_COMMITTED_STEPS {
            if !enabled.committed || enabled.actions.len() != 1 {
                break;
            }
            self.step(&mut s, &mut zone, enabled.actions[0]);
            self.rules.enabled(&s, &mut enabled);
        }
        if !enabled.urgent {
            self.deadlock |= self.rules.frame().executing(&s).next().is_none();
            zone.pass();
            self.set_windows(&mut s, &zone);
        }
        if let Some(names) = self.reductions.order(&self.rules, &mut s) {
            zone = zone.renamed(|executor| names.executor(executor));
        }
        let number = self.covered.len() as u32;
        if let Some(known) = self.passed.get_mut(&s.d[..]) {
            if known.iter().any(|(_, other)| other.covers(&zone)) {
                return;
            }
            known.retain(|(number, other)| {
                let covered = zone.covers(other);
                if covered {
                    self.covered[*number as usize] = true;
                    self.bytes -= other.memory();
                }
                !covered
            });
            known.push((number, zone.clone()));
        } else {
            let first = vec![(number, zone.clone())];
            self.passed.insert(s.d.clone().into(), first);
            self.bytes += size_of_val(&s.d[..]) + KEY_BYTES;
        }
        self.bytes += zone.memory() + self.bytes_to_do(&zone);
        self.covered.push(false);
        self.todo.push_back((number, s, zone));
    }

    /// Returns the bytes that the growth of the table takes in addition, if it is about to grow.
    fn growth(&self) -> usize {
        let left = self.passed.capacity() - self.passed.len();
        if left < 8 * STEPS_PER_POLL as usize { self.passed.capacity() * KEY_BYTES } else { 0 }
    }

    fn bytes_to_do(&self, zone: &Zone) -> usize {
        zone.memory() + self.rules.frame().state_bytes()
    }
}

/// Checks that a search in zones is possible and promising: no task is periodic, some duration is long, and
/// not all durations are fixed.
///
/// # Errors
///
/// Returns the reason against such a search.
pub(super) fn suit(system: &TimedSystem, watch: &Watch, limits: Limits) -> Result<(), Reason> {
    if limits.without.contains(Kind::Zones) {
        return Err(Reason::SwitchedOff);
    }
    if watch.in_order {
        return Err(Reason::InOrder);
    }
    if watch.reach.is_empty() && !watch.deadlock {
        return Err(Reason::NothingToFind);
    }
    if !watch.monitors.is_empty() {
        return Err(Reason::Patterns);
    }
    if system.tasks.iter().any(|task| task.period.is_some()) {
        return Err(Reason::Periodic);
    }
    let codels = system.codels.iter().map(|codel| (codel.lower, codel.upper));
    let steps = system.clients.iter().flat_map(|client| &client.steps);
    let delays = steps.filter_map(|step| match step.action {
        ClientAction::Delay(lower, upper) => Some((lower, upper)),
        _ => None,
    });
    let mut long = false;
    let mut varies = false;
    for (lower, upper) in codels.chain(delays) {
        let longest = if upper == FOREVER { lower } else { upper };
        if longest > GREATEST {
            return Err(Reason::TooLong);
        }
        long |= longest >= MIN_LONG_TIME;
        varies |= lower < upper;
    }
    match (long, varies) {
        (false, _) => Err(Reason::Short),
        (_, false) => Err(Reason::Fixed),
        _ => Ok(()),
    }
}

/// The findings of a complete search in zones.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ZoneFindings {
    /// Predicates that can be reached.
    pub reached: Vec<bool>,
    /// There is a deadlock.
    pub deadlock: bool,
    /// Services with a refused request.
    pub refused: Vec<ServiceId>,
}

/// The results of a search in zones, and its effort.
#[derive(Debug, Clone)]
pub(super) struct ZoneResult {
    seen: ZoneFindings,
    absent: NeverObserved,
    states: usize,
    steps: u64,
    /// Bytes used at the end, including those of the breadth-first search.
    bytes: usize,
}

impl<R: Reduced> Zones<'_, R> {
    /// Returns the results, if the search is complete.
    fn proof(&self) -> Option<ZoneResult> {
        let services = self.rules.system().services.keys();
        self.todo.is_empty().then(|| ZoneResult {
            seen: ZoneFindings {
                reached: self.reached.clone(),
                deadlock: self.deadlock,
                refused: services.filter(|&service| self.refused(service)).collect(),
            },
            absent: self.absent.clone(),
            states: self.covered.len(),
            steps: self.steps,
            bytes: self.bytes,
        })
    }
}

/// Searches for predicates in zones, in a system without periodic tasks. Returns `None` after too many steps.
/// The reductions in `without` are switched off.
pub fn search_zones(
    system: &TimedSystem,
    goals: &[Predicate],
    steps: u64,
    without: Kinds,
) -> Option<ZoneFindings> {
    search_zones_by(&SystemRules::new(system), goals, steps, without)
}

fn search_zones_by<R: Reduced>(
    rules: &R,
    goals: &[Predicate],
    steps: u64,
    without: Kinds,
) -> Option<ZoneFindings> {
    let mut zones = Zones::new(rules, goals, without);
    zones.run(steps);
    zones.proof().map(|proof| proof.seen)
}

/// A search in zones next to layers.
pub(super) enum ZoneSearch<'a, R: Reduced> {
    /// The search does not suit the system, or the watched properties.
    Unsuited(Reason),
    /// The search has not begun, or is under way.
    Open(Option<Box<Zones<'a, R>>>),
    /// The search is complete.
    Done(ZoneResult),
}

impl<'a, R: Reduced> ZoneSearch<'a, R> {
    /// Creates a search, possibly with known results, or the reason against one.
    pub(super) fn new(zones: Result<Option<ZoneResult>, Reason>) -> Self {
        match zones {
            Err(reason) => ZoneSearch::Unsuited(reason),
            Ok(None) => ZoneSearch::Open(None),
            Ok(Some(proof)) => ZoneSearch::Done(proof),
        }
    }

    /// Returns the results for another search, or the reason against one.
    pub(super) fn into_proof(self) -> Result<Option<ZoneResult>, Reason> {
        match self {
            ZoneSearch::Unsuited(reason) => Err(reason),
            ZoneSearch::Open(_) => Ok(None),
            ZoneSearch::Done(proof) => Ok(Some(proof)),
        }
    }

    /// Searches for a while, if it is due.
    pub(super) fn run_if_due(&mut self, layers: &Layers<'a, R>) {
        let ZoneSearch::Open(zones) = self else {
            return;
        };
        let observations = &layers.observations;
        let mut predicates = observations.goals.reached();
        let open = predicates.any(|predicate| observations.seen.goals[predicate.0].is_none())
            || (observations.watch.deadlock && layers.deadlock.is_none());
        if !open || layers.steps < STEPS_OF_LARGE_SEARCH {
            return;
        }
        let without = layers.limits.without;
        let new = || Box::new(Zones::new(&observations.rules, &observations.watch.reach, without));
        let zones = zones.get_or_insert_with(new);
        zones.run((ZONE_STEPS_PER_STEP * layers.steps).min(zones.steps + STEPS_PER_POLL));
        if let Some(mut proof) = zones.proof() {
            proof.bytes = layers.memory() + zones.bytes;
            *self = ZoneSearch::Done(proof);
        }
    }

    /// Returns the reason against a search in zones.
    pub(super) fn reason_against(&self) -> Option<Reason> {
        match self {
            ZoneSearch::Unsuited(reason) => Some(*reason),
            _ => None,
        }
    }

    fn proof(&self) -> Option<&ZoneResult> {
        match self {
            ZoneSearch::Done(proof) => Some(proof),
            _ => None,
        }
    }

    /// Returns true if the search in zones is complete.
    pub(super) fn is_done(&self) -> bool {
        self.proof().is_some()
    }

    /// Returns true if a predicate is proved never to hold.
    pub(super) fn never_reached(&self, predicate: usize) -> bool {
        self.proof().is_some_and(|proof| !proof.seen.reached[predicate])
    }

    /// Returns the jobs and atoms that no state has.
    pub(super) fn absent(&self) -> Option<&NeverObserved> {
        self.proof().map(|proof| &proof.absent)
    }

    /// Returns true if there is certainly no deadlock.
    pub(super) fn never_deadlocked(&self) -> bool {
        self.proof().is_some_and(|proof| !proof.seen.deadlock)
    }

    /// Returns true if a request for a service was refused in a state with a zone.
    pub(super) fn refused(&self, service: ServiceId) -> bool {
        self.proof().is_some_and(|proof| proof.seen.refused.contains(&service))
    }

    /// Returns the number of examined states.
    pub(super) fn states(&self) -> usize {
        match self {
            ZoneSearch::Open(Some(zones)) => zones.covered.len(),
            ZoneSearch::Done(proof) => proof.states,
            _ => 0,
        }
    }

    /// Returns the number of steps.
    pub(super) fn steps(&self) -> u64 {
        match self {
            ZoneSearch::Open(Some(zones)) => zones.steps,
            ZoneSearch::Done(proof) => proof.steps,
            _ => 0,
        }
    }

    /// Returns the bytes in use.
    pub(super) fn bytes(&self) -> usize {
        match self {
            ZoneSearch::Open(Some(zones)) => zones.bytes + zones.growth(),
            _ => 0,
        }
    }

    /// Returns the bytes in use at the end of the search, including those of the layers.
    pub(super) fn final_bytes(&self) -> usize {
        self.proof().map_or(0, |proof| proof.bytes)
    }
}
