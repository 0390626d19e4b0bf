//! Exploration in order of time: from moment to moment.

mod hunt;
mod layer;
mod news;
mod trace;
mod watching;
mod zones;

use std::collections::BTreeMap;

use self::hunt::Hunt;
pub use self::hunt::chase;
use self::news::{News, Teller};
use self::trace::Traced;
pub use self::zones::{InZones, in_zones};
use self::zones::{Proof, Zones};
use super::findings::Findings;
use super::measure::{Diverging, Gauge, How, Timing};
use super::observe::Observer;
use super::reductions::{Activity, Kind, Label, Reason, Reduced, Reductions, Watched};
use super::rules::with_rules;
use super::state::{Clocks, Stages, State};
use super::store::{Covering, Store, decode_to};
use super::watch::{Limits, Stop, Watch};
use crate::cancel::Cancel;
use crate::property::Predicate;
use crate::system::{Ticks, TimedSystem};

/// Explores all runs of a system.
pub fn explore(system: &TimedSystem, watch: &Watch, limits: Limits, cancel: &Cancel) -> Findings {
    explore_telling(system, watch, limits, cancel, &mut |_| {})
}

/// Explores all runs of a system, and tells of failures and of predicates that are reached as soon as they
/// are seen. Findings that are told have nothing else in them; the same may be told again.
pub fn explore_telling(
    system: &TimedSystem,
    watch: &Watch,
    limits: Limits,
    cancel: &Cancel,
    news: &mut dyn FnMut(&Findings),
) -> Findings {
    with_rules!(system, explore_by(watch, limits, cancel, news))
}

pub(super) fn explore_by<R: Reduced>(
    rules: &R,
    watch: &Watch,
    limits: Limits,
    cancel: &Cancel,
    news: &mut dyn FnMut(&Findings),
) -> Findings {
    let mut gauges = Gauge::of(watch, &How::Shared);
    let mut findings = until_measured(rules, watch, &mut gauges, limits, cancel, news);
    // What grew suspiciously is measured alone, so that clocks do not multiply.
    for (i, gauge) in gauges.iter().enumerate() {
        let given_up = findings.stopped.is_some_and(|it| it != Stop::Answered);
        if gauge.how != How::Alone || given_up {
            continue;
        }
        let mut alone = Watch::default();
        let place = match gauge.of {
            Timing::Response(_) => {
                alone.response.push(watch.response[i]);
                &mut findings.response[i]
            }
            Timing::Within(i) => {
                alone.within.push(watch.within[i].clone());
                &mut findings.within[i]
            }
        };
        let mut own = Gauge::of(&alone, &How::Patient);
        own[0].excess.clone_from(&gauge.excess);
        let mut found = until_measured(rules, &alone, &mut own, limits, cancel, &mut |_| {});
        *place = found.response.pop().or(found.within.pop()).flatten();
        findings.absorb(&found);
    }
    findings
}

/// Explores, again without what turns out to diverge.
fn until_measured<R: Reduced>(
    rules: &R,
    watch: &Watch,
    gauges: &mut [Gauge],
    limits: Limits,
    cancel: &Cancel,
    news: Teller,
) -> Findings {
    let zones = zones::suit(rules.system(), watch, limits);
    let random = hunt::suits(watch, limits);
    let mut proof = None;
    let mut hunt = random.is_ok().then(|| Hunt::new(watch));
    loop {
        let mut search = Search::new(rules, watch, gauges, limits, cancel);
        search.hunt = hunt;
        search.zones_suit = zones.is_ok();
        search.beside = [
            (Kind::Zones, zones.err()),
            (Kind::RandomSearch, random.err()),
        ];
        search.proof = proof;
        search.news = Some(News::new(&mut *news));
        let diverging = search.run();
        cancel.ended(search.states());
        proof = search.proof.take_if(|_| diverging.is_some());
        match diverging {
            Some(diverging) => {
                hunt = search.hand_on_hunt();
                for (gauge, it) in search.of_all_alike(diverging) {
                    gauges[gauge].note(it);
                }
            }
            None => return search.findings(),
        }
    }
}

/// States looked at between two looks at what may end the search.
const LOOKS: usize = 64;

/// Steps for each state kept from which on moments are crowded: what happens in them is what takes long.
const CROWDED: u64 = 64;

/// Bytes of a node in the queue.
const QUEUED: usize = 2 * size_of::<u32>();

const ROOT: u32 = u32::MAX;

/// A state in which time passes: a key of the set of passed states, and its own box.
struct Node {
    key: u32,
    start: usize,
    len: u32,
    time: u64,
    /// First of the nodes it was reached from.
    edges: u32,
}

/// Where something was seen: after the jump of a node.
#[derive(Clone, Copy)]
struct Sight {
    parent: u32,
    time: u64,
}

/// A longest time seen.
#[derive(Clone, Copy)]
struct Longest {
    value: Ticks,
    at: Sight,
}

struct Search<'a, R: Reduced> {
    rules: R,
    reductions: R::Reductions,
    watch: &'a Watch,
    observers: Vec<Observer>,
    limits: Limits,
    cancel: &'a Cancel,
    passed: Store,
    nodes: Vec<Node>,
    dims: Vec<Ticks>,
    edges: Vec<(u32, u32)>,
    queue: BTreeMap<u64, Vec<u32>>,
    layer: Store,
    layer_calm: Vec<bool>,
    /// All states of former moments that were crowded.
    crowd: Store,
    steps: u64,
    missed: Vec<Option<Sight>>,
    overdue: Vec<Option<Sight>>,
    reached: Vec<Option<Sight>>,
    gauges: &'a [Gauge],
    /// Of each gauge.
    longest: Vec<Option<Longest>>,
    /// Where each gauge exceeds its limit first.
    excess: Vec<Option<Sight>>,
    deadlock: Option<Sight>,
    /// Told what is seen for good.
    news: Option<News<'a>>,
    /// Runs that were found again already.
    traced: Traced,
    /// Clocks are examined for divergence when they exceed this.
    patience: Ticks,
    /// Tasks whose clock only serves the overdue check.
    waiting_only: Vec<bool>,
    stopped: Option<Stop>,
    /// Steps until which to go on after everything was answered.
    until: Option<u64>,
    /// The moment that is looked at.
    now: u64,
    /// What is done beside, unless this is part of it.
    hunt: Option<Hunt>,
    /// Zones suit the system, and what is asked.
    zones_suit: bool,
    /// What is tried beside, or why not.
    beside: [(Kind, Option<Reason>); 2],
    /// What is looked for in them, once there is more than a little.
    zones: Option<Zones<'a, R>>,
    /// What they have shown, once everything was looked at.
    proof: Option<Proof>,
    /// Found while a layer was closed.
    diverging: Option<Diverging>,
    /// Bytes of the states that a layer begins with.
    under_way: usize,
    /// States whose memory is used again.
    spare: Vec<State>,
    /// Look for repetition until it is found.
    patient: bool,
}

impl<'a, R: Reduced> Search<'a, R> {
    fn new(
        rules: &R,
        watch: &'a Watch,
        gauges: &'a [Gauge],
        limits: Limits,
        cancel: &'a Cancel,
    ) -> Self {
        let system = rules.system();
        let measured = |of: Timing| gauges.iter().any(|it| it.of == of && it.active());
        let measured_task = |task: usize| measured(Timing::Response(task));
        let waiting_only: Vec<bool> = (0..system.tasks.len())
            .map(|t| {
                !measured_task(t) && watch.overdue.contains(&t) && system.tasks[t].period.is_some()
            })
            .collect();
        let observed: Vec<bool> = (0..system.tasks.len())
            .map(|t| measured_task(t) || waiting_only[t])
            .collect();
        let clocked: Vec<Stages> = (watch.within.iter().enumerate())
            .map(|(i, it)| Stages {
                count: it.responses.len(),
                measured: measured(Timing::Within(i)),
            })
            .collect();
        let patient = gauges.iter().any(|it| it.how == How::Patient);
        let clocks = Clocks {
            response: observed,
            within: clocked,
            token: 0,
        };
        let own = rules.with_clocks(&clocks);
        let predicates: Vec<&Predicate> = (watch.within.iter())
            .flat_map(|it| it.responses.iter().chain([&it.trigger]))
            .chain(&watch.reach)
            .collect();
        let longest = system
            .tasks
            .iter()
            .filter_map(|it| it.period)
            .max()
            .unwrap_or(0);
        let work = system
            .codels
            .iter()
            .map(|it| {
                if it.upper == crate::system::FOREVER {
                    it.lower
                } else {
                    it.upper
                }
            })
            .fold(0u32, |sum, it| sum.saturating_add(it));
        let label = |task: usize| Label {
            watched: [
                watch.schedulable.contains(&task),
                watch.overdue.contains(&task),
            ],
            measured: (gauges.iter())
                .filter(|it| it.of == Timing::Response(task))
                .map(|it| (it.limit, it.most, it.active()))
                .collect(),
        };
        let asked = Watched {
            labels: (0..system.tasks.len()).map(label).collect(),
            predicates,
            measured: clocks.response,
        };
        let reductions = R::Reductions::new(&own, &asked, limits.without);
        let clocks = own.frame().clocks();
        let covering = Covering {
            union: !limits.without.contains(Kind::WindowUnion),
            inclusion: !limits.without.contains(Kind::WindowInclusion),
        };
        Search {
            rules: own,
            reductions,
            watch,
            observers: watch
                .within
                .iter()
                .map(|it| Observer {
                    trigger: it.trigger.clone(),
                    responses: it.responses.clone(),
                })
                .collect(),
            limits,
            cancel,
            passed: Store::new(clocks, covering),
            nodes: Vec::new(),
            dims: Vec::new(),
            edges: Vec::new(),
            queue: BTreeMap::new(),
            layer: Store::new(clocks, covering),
            layer_calm: Vec::new(),
            crowd: Store::new(clocks, covering),
            steps: 0,
            missed: vec![None; watch.schedulable.len()],
            overdue: vec![None; watch.overdue.len()],
            reached: vec![None; watch.reach.len()],
            gauges,
            longest: vec![None; gauges.len()],
            excess: vec![None; gauges.len()],
            deadlock: None,
            news: None,
            traced: Traced::default(),
            patience: longest.saturating_add(work).max(16),
            waiting_only,
            stopped: None,
            until: None,
            now: 0,
            hunt: None,
            zones_suit: false,
            beside: [Kind::Zones, Kind::RandomSearch].map(|it| (it, Some(Reason::NothingToFind))),
            zones: None,
            proof: None,
            diverging: None,
            under_way: 0,
            spare: Vec::new(),
            patient,
        }
    }
}

impl<R: Reduced> Search<'_, R> {
    fn run(&mut self) -> Option<Diverging> {
        let initial = self.rules.initial();
        self.close_layer(0, vec![(initial, ROOT)], true);
        while self.diverging.is_none()
            && self.stopped.is_none()
            && let Some((time, parents)) = self.queue.pop_first()
        {
            self.now = time;
            let mut states = Vec::with_capacity(parents.len());
            self.under_way =
                states.capacity() * (size_of::<u32>() + self.rules.frame().state_bytes());
            for (i, parent) in parents.into_iter().enumerate() {
                if i % LOOKS == LOOKS - 1 && self.out_of_bounds() {
                    break;
                }
                let mut s = self.spare.pop().unwrap_or_default();
                self.node_state_to(parent, &mut s);
                let jump = (time - self.nodes[parent as usize].time) as Ticks;
                self.limits_in_jump(&s, parent, jump);
                self.rules.elapse(&mut s, jump);
                if self.diverging.is_none() {
                    self.diverging = self.clocks_after_jump(&mut s, Sight { parent, time });
                }
                states.push((s, parent));
            }
            if self.diverging.is_none() && self.stopped.is_none() {
                self.close_layer(time, states, false);
            }
        }
        if self.stopped == Some(Stop::States) && self.may_end_earlier() {
            self.chase_earlier(self.further());
        }
        self.limits_under_way();
        let mut diverging = self.diverging.take()?;
        if let Some(it) = self.excess_run(diverging.gauge) {
            diverging.excess = Some(it);
        }
        Some(diverging)
    }

    fn node_state(&self, node: u32) -> State {
        let mut s = State::default();
        self.node_state_to(node, &mut s);
        s
    }

    fn node_state_to(&self, node: u32, s: &mut State) {
        let node = &self.nodes[node as usize];
        let dims = &self.dims[node.start..node.start + node.len as usize];
        decode_to(self.rules.frame(), self.passed.key(node.key), dims, s);
    }

    /// Which reductions are used.
    fn activities(&self) -> Vec<Activity> {
        let switched = [
            Kind::WindowUnion,
            Kind::WindowInclusion,
            Kind::MomentCovering,
        ]
        .map(|kind| {
            let off = self.limits.without.contains(kind);
            (kind, off.then_some(Reason::SwitchedOff))
        });
        let own = self.reductions.activities().iter().copied();
        let others = switched.into_iter().chain(self.beside);
        own.chain(others.map(|(kind, off)| Activity { kind, off }))
            .collect()
    }

    fn is_crowded(&self) -> bool {
        self.steps > CROWDED * self.nodes.len() as u64
    }

    fn out_of_bounds(&mut self) -> bool {
        let states = self.nodes.len() + self.layer.len() + self.states_beside();
        let reason = Stop::reason(states, self.memory(), self.limits, self.cancel);
        let too_many = (self.steps > self.limits.steps).then_some(Stop::States);
        if let Some(reason) = reason.or(too_many) {
            self.stopped = Some(reason);
            return true;
        }
        self.hunt_if_due();
        self.prove_if_due();
        if self.answered() && !self.goes_on() {
            self.stopped = Some(Stop::Answered);
        } else {
            self.tell_news();
        }
        self.stopped.is_some() || self.diverging.is_some()
    }

    /// States kept, or looked at beside; where the exploration was broken off also those of the moment at
    /// which that happened.
    fn states(&self) -> usize {
        let moment = match self.stopped {
            None | Some(Stop::Answered) => 0,
            Some(_) => self.layer.len(),
        };
        self.nodes.len() + moment + self.states_beside()
    }

    /// States looked at beside.
    fn states_beside(&self) -> usize {
        self.hunted() + self.in_zones().0
    }

    fn memory(&self) -> usize {
        self.passed.memory()
            + self.layer.memory()
            + self.crowd.memory()
            + self.nodes.capacity() * size_of::<Node>()
            + self.dims.capacity() * size_of::<Ticks>()
            + self.edges.capacity() * size_of::<(u32, u32)>()
            + self.nodes.len() * QUEUED
            + self.under_way
            + self.in_zones().2
            + self.spare.len() * self.rules.frame().state_bytes()
    }
}
