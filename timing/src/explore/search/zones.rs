//! Zones: what can never be reached is also looked for in dense time.
//!
//! Where nothing is periodic, what matters is in which order codels and delays end. In whole numbers of time
//! there are the more states the longer they last; *zones*, sets of remaining times (see [`Zone`]), depend on
//! their order alone. So beside a search moment by moment, and with most of the effort, another one gives
//! states zones instead of windows. Rules, ample sets and symmetry are the same; a window is then the
//! shortest and longest time in the zone. What no state with a zone shows is proved. What one does show is
//! left to the other search, which comes to it with a run.

mod zone;

use std::collections::VecDeque;

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use self::zone::{GREATEST, Zone};
use super::layers::Layers;
use crate::explore::absent::Absent;
use crate::explore::observe;
use crate::explore::reductions::{Kind, Kinds, Reason, Reduced, Reductions, Watched};
use crate::explore::rules::{Action, Enabled, with_rules};
use crate::explore::state::{Clocks, State};
use crate::explore::watch::{Limits, Watch};
use crate::property::Predicate;
use crate::system::{ClientAction, FOREVER, Ticks, TimedSystem};

/// Steps after which a search is not small any more.
const SMALL: u64 = 1000;

/// Time from which on something lasts long.
const LONG: Ticks = 8;

/// Steps in zones for each step of the search they are beside.
const SHARE: u64 = 4;

/// Steps in zones between two looks at what may end the search.
const LOOKS: u64 = 128;

/// Bytes for a key besides what it says, with room to grow.
const KEY: usize = 2 * size_of::<(Box<[u16]>, Vec<(u32, Zone)>)>();

/// Committed steps that are taken at once. There is a bound because a client may go round in circles without
/// taking time.
const AT_ONCE: usize = 16;

/// A search in zones for predicates, and for states in which nothing will ever happen again.
pub(super) struct Zones<'a, R: Reduced> {
    rules: R,
    reductions: R::Reductions,
    goals: &'a [Predicate],
    /// Which of the goals were reached.
    reached: Vec<bool>,
    /// What no state has so far.
    absent: Absent,
    deadlock: bool,
    /// By what goes on, zones that were come to, with their numbers.
    passed: FxHashMap<Box<[u16]>, Vec<(u32, Zone)>>,
    /// By number: it was covered by another one before it was looked at.
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
        let mut out = Zones {
            reductions: R::Reductions::new(&rules, &asked, without),
            rules,
            goals,
            reached: vec![false; goals.len()],
            absent: Absent::of_predicates(goals),
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

    /// Goes on until it has taken so many steps.
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
            self.reductions
                .persistent(&self.rules, &s, &enabled, &mut followed);
            for &action in &followed {
                let (mut s, mut zone) = (s.clone(), zone.clone());
                self.step(&mut s, &mut zone, action);
                self.keep(s, zone);
            }
        }
    }

    /// Whether a request of a service was refused, or of one that is not told apart from it.
    fn refused(&self, service: usize) -> bool {
        let mut orbit = self.reductions.orbits().of_service(service).iter();
        orbit.any(|&it| self.rules.has_refused(it))
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

    /// Looks at a state that was just entered.
    fn look(&mut self, before: Option<&State>, s: &State) {
        for (goal, reached) in self.goals.iter().zip(&mut self.reached) {
            *reached = *reached || observe::predicate(&self.rules, before, s, goal);
        }
        let orbits = self.reductions.orbits();
        self.absent.look(&self.rules, s, orbits);
    }

    /// Brings the zone of a state, and its windows, up to what is being executed.
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

    /// Keeps a state to look at later, after the committed steps that follow without a choice, and any time
    /// if it can pass.
    fn keep(&mut self, mut s: State, mut zone: Zone) {
        let mut enabled = Enabled::default();
        self.rules.enabled(&s, &mut enabled);
        for _ in 0..AT_ONCE {
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
            zone = zone.renamed(|it| names.executor(it));
        }
        let number = self.covered.len() as u32;
        if let Some(known) = self.passed.get_mut(&s.d[..]) {
            if known.iter().any(|(_, it)| it.covers(&zone)) {
                return;
            }
            known.retain(|(number, it)| {
                let covered = zone.covers(it);
                if covered {
                    self.covered[*number as usize] = true;
                    self.bytes -= it.memory();
                }
                !covered
            });
            known.push((number, zone.clone()));
        } else {
            let first = vec![(number, zone.clone())];
            self.passed.insert(s.d.clone().into(), first);
            self.bytes += size_of_val(&s.d[..]) + KEY;
        }
        self.bytes += zone.memory() + self.bytes_to_do(&zone);
        self.covered.push(false);
        self.todo.push_back((number, s, zone));
    }

    /// Bytes of the table that are there twice when it grows, if that is near.
    fn growth(&self) -> usize {
        let left = self.passed.capacity() - self.passed.len();
        match left < 8 * LOOKS as usize {
            true => self.passed.capacity() * KEY,
            false => 0,
        }
    }

    fn bytes_to_do(&self, zone: &Zone) -> usize {
        zone.memory() + self.rules.frame().state_bytes()
    }
}

/// Whether there are zones of a system, and fewer of them than states with whole numbers of time: nothing is
/// periodic, something lasts long, and not everything takes as long each time.
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
    if system.tasks.iter().any(|it| it.period.is_some()) {
        return Err(Reason::Periodic);
    }
    let codels = system.codels.iter().map(|it| (it.lower, it.upper));
    let steps = system.clients.iter().flat_map(|it| &it.steps);
    let delays = steps.filter_map(|it| match it.action {
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
        long |= longest >= LONG;
        varies |= lower < upper;
    }
    match (long, varies) {
        (false, _) => Err(Reason::Short),
        (_, false) => Err(Reason::Fixed),
        _ => Ok(()),
    }
}

/// What a search in zones that has looked at everything has seen.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct InZones {
    /// Which predicates can be reached.
    pub reached: Vec<bool>,
    /// There is a state in which nothing will ever happen again.
    pub deadlock: bool,
    /// Services of which a request was refused.
    pub refused: Vec<usize>,
}

/// What is known from zones, and what it took.
#[derive(Debug, Clone)]
pub(super) struct Proof {
    seen: InZones,
    absent: Absent,
    states: usize,
    steps: u64,
    /// Bytes used in the end, with those of the search it was beside.
    bytes: usize,
}

impl<R: Reduced> Zones<'_, R> {
    /// What was seen, if that is everything.
    fn proof(&self) -> Option<Proof> {
        let services = 0..self.rules.system().services.len();
        self.todo.is_empty().then(|| Proof {
            seen: InZones {
                reached: self.reached.clone(),
                deadlock: self.deadlock,
                refused: services.filter(|&it| self.refused(it)).collect(),
            },
            absent: self.absent.clone(),
            states: self.covered.len(),
            steps: self.steps,
            bytes: self.bytes,
        })
    }
}

/// Looks in zones for predicates, in a system without periodic tasks. `None` if it takes more than so many
/// steps. Some reductions are switched off.
pub fn in_zones(
    system: &TimedSystem,
    goals: &[Predicate],
    steps: u64,
    without: Kinds,
) -> Option<InZones> {
    with_rules!(system, in_zones_by(goals, steps, without))
}

fn in_zones_by<R: Reduced>(
    rules: &R,
    goals: &[Predicate],
    steps: u64,
    without: Kinds,
) -> Option<InZones> {
    let mut zones = Zones::new(rules, goals, without);
    zones.run(steps);
    zones.proof().map(|it| it.seen)
}

/// A search in zones beside layers.
pub(super) enum Proving<'a, R: Reduced> {
    /// It does not suit the system, or what is asked.
    Unsuited(Reason),
    /// It has not begun, or goes on.
    Open(Option<Box<Zones<'a, R>>>),
    /// It has looked at everything.
    Done(Proof),
}

impl<'a, R: Reduced> Proving<'a, R> {
    /// A search that may be done already, or why there is none.
    pub(super) fn new(zones: Result<Option<Proof>, Reason>) -> Self {
        match zones {
            Err(reason) => Proving::Unsuited(reason),
            Ok(None) => Proving::Open(None),
            Ok(Some(proof)) => Proving::Done(proof),
        }
    }

    /// What another search may begin with.
    pub(super) fn into_proof(self) -> Result<Option<Proof>, Reason> {
        match self {
            Proving::Unsuited(reason) => Err(reason),
            Proving::Open(_) => Ok(None),
            Proving::Done(proof) => Ok(Some(proof)),
        }
    }

    /// Looks for what can never be reached, if it is time to.
    pub(super) fn work_if_due(&mut self, layers: &Layers<'a, R>) {
        let Proving::Open(zones) = self else { return };
        let watching = &layers.watching;
        let mut predicates = watching.goals.reached();
        let open = predicates.any(|it| watching.seen.goals[it.0].is_none())
            || (watching.watch.deadlock && layers.deadlock.is_none());
        if !open || layers.steps < SMALL {
            return;
        }
        let without = layers.limits.without;
        let new = || Box::new(Zones::new(&watching.rules, &watching.watch.reach, without));
        let zones = zones.get_or_insert_with(new);
        zones.run((SHARE * layers.steps).min(zones.steps + LOOKS));
        if let Some(mut proof) = zones.proof() {
            proof.bytes = layers.memory() + zones.bytes;
            *self = Proving::Done(proof);
        }
    }

    /// Why there is no such search.
    pub(super) fn unsuited(&self) -> Option<Reason> {
        match self {
            Proving::Unsuited(reason) => Some(*reason),
            _ => None,
        }
    }

    fn proof(&self) -> Option<&Proof> {
        match self {
            Proving::Done(proof) => Some(proof),
            _ => None,
        }
    }

    /// Whether everything was looked at in zones.
    pub(super) fn is_done(&self) -> bool {
        self.proof().is_some()
    }

    /// Whether a predicate can never be reached.
    pub(super) fn never_reached(&self, predicate: usize) -> bool {
        self.proof().is_some_and(|it| !it.seen.reached[predicate])
    }

    /// What no state has.
    pub(super) fn absent(&self) -> Option<&Absent> {
        self.proof().map(|it| &it.absent)
    }

    /// Whether something can always happen.
    pub(super) fn never_deadlocked(&self) -> bool {
        self.proof().is_some_and(|it| !it.seen.deadlock)
    }

    /// Whether a request of a service was refused in a state with a zone.
    pub(super) fn refused(&self, service: usize) -> bool {
        self.proof()
            .is_some_and(|it| it.seen.refused.contains(&service))
    }

    /// States looked at.
    pub(super) fn states(&self) -> usize {
        match self {
            Proving::Open(Some(zones)) => zones.covered.len(),
            Proving::Done(proof) => proof.states,
            _ => 0,
        }
    }

    /// Steps taken.
    pub(super) fn steps(&self) -> u64 {
        match self {
            Proving::Open(Some(zones)) => zones.steps,
            Proving::Done(proof) => proof.steps,
            _ => 0,
        }
    }

    /// Bytes in use now.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Proving::Open(Some(zones)) => zones.bytes + zones.growth(),
            _ => 0,
        }
    }

    /// Bytes in use when everything was looked at, with those of the layers.
    pub(super) fn bytes_in_the_end(&self) -> usize {
        self.proof().map_or(0, |it| it.bytes)
    }
}
