//! Exploration in order of time, and what is watched meanwhile.

mod trace;

use std::collections::BTreeMap;

use rustc_hash::FxHashSet;

use self::trace::Goal;
use super::ample::{Ample, Visible};
use super::lazy::{self, Lazy};
use super::measure::{Diverging, Gauge, How, Timing};
use super::observe::{self, Observer};
use super::overtake::{Held, Now, Overtake};
use super::run::Run;
use super::state::{Layout, State, TaskStatus};
use super::step::{Action, Enabled, Stepper};
use super::store::{Encoded, Store, decode, decode_to, encode, holds};
use super::symmetry::{Asked, Label, Symmetry};
use crate::cancel::Cancel;
use crate::property::Predicate;
use crate::system::{Ticks, TimedSystem};

/// What is to be found out in one exploration.
#[derive(Debug, Clone, Default)]
pub struct Watch {
    /// Tasks whose ticks must not come before their jobs have ended.
    pub schedulable: Vec<usize>,
    /// Tasks that must not wait for a core as long as their period.
    pub overdue: Vec<usize>,
    /// Response times that are wanted.
    pub response: Vec<ResponseTime>,
    /// Predicates to be reached.
    pub reach: Vec<Predicate>,
    /// Pairs of predicates whose least bound is wanted.
    pub within: Vec<Within>,
    /// Look for states in which nothing will ever happen again.
    pub deadlock: bool,
    /// Stop as soon as a tick came too early.
    pub stop_at_first: bool,
}

/// The response time of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResponseTime {
    /// The task.
    pub task: usize,
    /// If the time exceeds this, the shortest run that does so is wanted.
    pub limit: Option<Ticks>,
    /// No job takes longer, as is known from analysis: one that takes as long ends the search for this time.
    pub most: Option<Ticks>,
}

/// The time that passes until one predicate follows another.
#[derive(Debug, Clone)]
pub struct Within {
    /// Whenever this becomes true,
    pub trigger: Predicate,
    /// this is awaited.
    pub response: Predicate,
    /// If the time exceeds this, the shortest run that does so is wanted.
    pub limit: Option<Ticks>,
}

/// Bounds on the effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Greatest number of states kept.
    pub states: usize,
    /// Greatest number of bytes for them.
    pub bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            states: 20_000_000,
            bytes: 4 << 30,
        }
    }
}

/// Why an exploration did not finish.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stop {
    /// Too many states.
    States,
    /// Too much memory.
    Memory,
    /// Time is up.
    Time,
    /// Nobody wants to know any more.
    Cancelled,
    /// Everything that was asked has been found, or with [`Watch::stop_at_first`] the first of it.
    Answered,
}

impl Stop {
    /// What ends an exploration of this size, if anything.
    pub(super) fn reason(
        states: usize,
        bytes: usize,
        limits: Limits,
        cancel: &Cancel,
    ) -> Option<Stop> {
        cancel.at_work(states, bytes);
        if cancel.is_over() {
            Some(match cancel.is_abandoned() {
                true => Stop::Cancelled,
                false => Stop::Time,
            })
        } else if states > limits.states {
            Some(Stop::States)
        } else if bytes > limits.bytes {
            Some(Stop::Memory)
        } else {
            None
        }
    }
}

/// A supremum of a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Bound {
    /// Reached, and never exceeded.
    Finite(Ticks),
    /// There is none.
    Unbounded,
}

/// Something found, with a run that shows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// From time 0 to the state in question.
    pub run: Run,
}

/// A time that was measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measured {
    /// Its supremum.
    pub bound: Bound,
    /// A run that reaches it, or shows that there is none.
    pub longest: Found,
    /// The limit is exceeded: by this run, which ends when that has happened. If the time has a bound, no
    /// run exceeds the limit earlier.
    pub excess: Option<Found>,
}

/// What an exploration found. Lists follow those of the [`Watch`].
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// Runs in which a tick came too early.
    pub missed: Vec<Option<Found>>,
    /// Runs in which a task waited too long.
    pub overdue: Vec<Option<Found>>,
    /// Response times; `None` if the task was never released.
    pub response: Vec<Option<Measured>>,
    /// Runs to the predicates.
    pub reached: Vec<Option<Found>>,
    /// Least bounds; `None` if the first predicate never became true.
    pub within: Vec<Option<Measured>>,
    /// A run to a deadlock.
    pub deadlock: Option<Found>,
    /// Services of which a request was refused because no slot was free.
    pub refused: Vec<usize>,
    /// States kept.
    pub states: usize,
    /// Steps taken.
    pub steps: u64,
    /// Bytes used for states.
    pub bytes: usize,
    /// Set when the exploration is not complete: what was not found may still exist, and bounds are
    /// lower bounds.
    pub stopped: Option<Stop>,
}

/// Explores all runs of a system.
pub fn explore(system: &TimedSystem, watch: &Watch, limits: Limits, cancel: &Cancel) -> Findings {
    let mut gauges = Gauge::of(watch, &How::Shared);
    let mut findings = until_measured(system, watch, &mut gauges, limits, cancel);
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
        let mut found = until_measured(system, &alone, &mut own, limits, cancel);
        *place = found.response.pop().or(found.within.pop()).flatten();
        findings.absorb(&found);
    }
    findings
}

/// Explores, again without what turns out to diverge.
fn until_measured(
    system: &TimedSystem,
    watch: &Watch,
    gauges: &mut [Gauge],
    limits: Limits,
    cancel: &Cancel,
) -> Findings {
    loop {
        let mut search = Search::new(system, watch, gauges, limits, cancel);
        let diverging = search.run();
        cancel.ended(search.states());
        match diverging {
            Some(diverging) => {
                for (gauge, it) in search.of_all_alike(diverging) {
                    gauges[gauge].note(it);
                }
            }
            None => return search.findings(),
        }
    }
}

impl Findings {
    fn absorb(&mut self, other: &Findings) {
        self.states += other.states;
        self.steps += other.steps;
        self.bytes = self.bytes.max(other.bytes);
        // What one exploration has answered says nothing about the next.
        self.stopped = match self.stopped {
            None | Some(Stop::Answered) => other.stopped.or(self.stopped),
            given_up => given_up,
        };
    }
}

/// States looked at per state of a layer to find those that are reached by ends that can wait.
const CLOSURES: usize = 1;

/// States looked at between two looks at what may end the search.
const LOOKS: usize = 64;

/// Steps for which an exploration that has answered everything goes on, to see requests that are refused.
const LINGER: u64 = 20_000;

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

struct Search<'a> {
    stepper: Stepper<'a>,
    lazy: Lazy,
    ample: Ample,
    overtake: Overtake,
    symmetry: Symmetry,
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
    /// Clocks are examined for divergence when they exceed this.
    patience: Ticks,
    /// Tasks whose clock only serves the overdue check.
    waiting_only: Vec<bool>,
    stopped: Option<Stop>,
    /// Steps taken when everything was answered.
    answered_at: Option<u64>,
    /// Found while a layer was closed.
    diverging: Option<Diverging>,
    /// Bytes of the states that a layer begins with.
    under_way: usize,
    /// States whose memory is used again.
    spare: Vec<State>,
    /// Look for repetition until it is found.
    patient: bool,
}

impl<'a> Search<'a> {
    fn new(
        system: &'a TimedSystem,
        watch: &'a Watch,
        gauges: &'a [Gauge],
        limits: Limits,
        cancel: &'a Cancel,
    ) -> Self {
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
        let clocked: Vec<bool> = (0..watch.within.len())
            .map(|it| measured(Timing::Within(it)))
            .collect();
        let patient = gauges.iter().any(|it| it.how == How::Patient);
        let layout = Layout::new(system, &observed, &clocked);
        let predicates: Vec<&Predicate> = (watch.within.iter())
            .flat_map(|it| [&it.trigger, &it.response])
            .chain(&watch.reach)
            .collect();
        let visible = Visible::new(system, predicates.iter().copied());
        let clocks = layout.clocks();
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
        let asked = Asked {
            labels: (0..system.tasks.len()).map(label).collect(),
            predicates,
        };
        let symmetry = Symmetry::new(system, &layout, &asked);
        let lazy = Lazy::new(system, &visible, &observed);
        let ample = Ample::new(system, visible, &observed);
        Search {
            stepper: Stepper::new(system, layout),
            lazy,
            overtake: Overtake::new(system, &ample),
            ample,
            symmetry,
            watch,
            observers: watch
                .within
                .iter()
                .map(|it| Observer {
                    trigger: it.trigger.clone(),
                    response: it.response.clone(),
                })
                .collect(),
            limits,
            cancel,
            passed: Store::new(clocks),
            nodes: Vec::new(),
            dims: Vec::new(),
            edges: Vec::new(),
            queue: BTreeMap::new(),
            layer: Store::new(clocks),
            layer_calm: Vec::new(),
            steps: 0,
            missed: vec![None; watch.schedulable.len()],
            overdue: vec![None; watch.overdue.len()],
            reached: vec![None; watch.reach.len()],
            gauges,
            longest: vec![None; gauges.len()],
            excess: vec![None; gauges.len()],
            deadlock: None,
            patience: longest.saturating_add(work).max(16),
            waiting_only,
            stopped: None,
            answered_at: None,
            diverging: None,
            under_way: 0,
            spare: Vec::new(),
            patient,
        }
    }
}

// ---- Exploration ------------------------------------------------------------------------------

impl Search<'_> {
    fn run(&mut self) -> Option<Diverging> {
        let initial = self.stepper.initial();
        self.close_layer(0, vec![(initial, ROOT)], true);
        while self.diverging.is_none()
            && self.stopped.is_none()
            && let Some((time, parents)) = self.queue.pop_first()
        {
            let mut states = Vec::with_capacity(parents.len());
            self.under_way =
                states.capacity() * (size_of::<u32>() + self.stepper.layout.state_bytes());
            for (i, parent) in parents.into_iter().enumerate() {
                if i % LOOKS == LOOKS - 1 && self.out_of_bounds() {
                    break;
                }
                let mut s = self.spare.pop().unwrap_or_default();
                self.node_state_to(parent, &mut s);
                let jump = (time - self.nodes[parent as usize].time) as Ticks;
                self.limits_in_jump(&s, parent, jump);
                self.stepper.elapse(&mut s, jump);
                if self.diverging.is_none() {
                    self.diverging = self.clocks_after_jump(&mut s, Sight { parent, time });
                }
                states.push((s, parent));
            }
            if self.diverging.is_none() && self.stopped.is_none() {
                self.close_layer(time, states, false);
            }
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
        decode_to(&self.stepper, self.passed.key(node.key), dims, s);
    }

    /// Follows all simultaneous actions from states at one moment, then keeps the calm ones.
    fn close_layer(&mut self, time: u64, states: Vec<(State, u32)>, initial: bool) {
        self.layer.clear();
        self.layer_calm.clear();
        // Parents of a merged state: lists in `links`, by number.
        let mut links: Vec<(u32, u32)> = Vec::new();
        let mut stack: Vec<(State, u32, Held)> = states
            .into_iter()
            .map(|(s, parent)| (s, parent, 0))
            .collect();
        if initial {
            for (s, parent, _) in &mut stack {
                observe::observe(&self.stepper, &self.observers, None, s);
                self.check(
                    None,
                    s,
                    Sight {
                        parent: *parent,
                        time,
                    },
                );
            }
        }
        let mut enabled = Enabled::default();
        let mut first = Vec::new();
        let mut followed = Vec::new();
        let mut it = Encoded::default();
        while let Some((mut s, parent, mut held)) = stack.pop() {
            self.steps += 1;
            if self.stopped.is_some() || (self.steps % 16 == 1 && self.out_of_bounds()) {
                return;
            }
            // Committed steps without a choice need not be kept; the bound is there because
            // a client may go round in circles without taking time.
            self.stepper.enabled(&s, &mut enabled);
            for _ in 0..16 {
                if !enabled.committed || enabled.actions.len() != 1 {
                    break;
                }
                self.step(
                    &mut s,
                    enabled.actions[0],
                    &mut held,
                    Sight { parent, time },
                );
                self.stepper.enabled(&s, &mut enabled);
            }
            if held == 0 && self.symmetry.order(&self.stepper.layout, &mut s).is_some() {
                self.stepper.enabled(&s, &mut enabled);
            }
            encode(&self.stepper, &s, &mut it);
            if held != 0 {
                it.key.extend(held.to_le_bytes());
            }
            let tag = links.len() as u32;
            links.push((parent, u32::MAX));
            let Some(key) = self
                .layer
                .insert(&it, tag, |one, other| join(&mut links, one, other))
            else {
                links.pop();
                self.spare.push(s);
                continue;
            };
            if key as usize == self.layer_calm.len() {
                self.layer_calm.push(!enabled.urgent);
            }
            let calm = !enabled.urgent && !enabled.forced;
            let waiters = calm.then(|| self.lazy.waiters(&self.stepper, &s)).flatten();
            self.ample.select(&self.stepper, &s, &enabled, &mut first);
            let now = Now {
                stepper: &self.stepper,
                ample: &self.ample,
                s: &s,
                enabled: &enabled,
            };
            self.overtake.select(now, held, &first, &mut followed);
            for &(action, mut held) in &followed {
                if let Action::Finish { executor, .. } = action
                    && let Some(waiters) = &waiters
                    && lazy::can_wait(waiters, &self.stepper, executor)
                {
                    continue;
                }
                let mut next = self.spare.pop().unwrap_or_default();
                next.clone_from(&s);
                self.step(&mut next, action, &mut held, Sight { parent, time });
                stack.push((next, parent, held));
            }
            self.spare.push(s);
        }
        self.keep_calm(time, &links);
    }

    /// Performs an action, and looks at the state it leads to.
    fn step(&mut self, s: &mut State, action: Action, held: &mut Held, at: Sight) {
        let needs_before = !self.observers.is_empty() || !self.watch.reach.is_empty() || *held != 0;
        let before = needs_before.then(|| s.clone());
        self.stepper.apply(s, action);
        if let Some(before) = &before {
            observe::observe(&self.stepper, &self.observers, Some(before), s);
            *held = (self.overtake).after(&self.stepper, before, action, s, *held);
        }
        if let Action::Grant { task } = action
            && self.waiting_only[task]
            && let Some(clock) = self.stepper.layout.response[task]
        {
            s.t[clock] = 0;
        }
        self.check(before.as_ref(), s, at);
    }

    /// Turns the calm states of the layer that are not passed yet into nodes.
    fn keep_calm(&mut self, time: u64, links: &[(u32, u32)]) {
        let layer = std::mem::take(&mut self.layer);
        let redundant = self.redundant(&layer);
        let mut it = Encoded::default();
        let mut s = State::default();
        for key in 0..layer.len() as u32 {
            if key % 64 == 63 && self.out_of_bounds() {
                break;
            }
            if !self.layer_calm[key as usize] {
                continue;
            }
            it.key.clear();
            it.key.extend(layer.key(key));
            for (dims, tag) in layer.covers(key) {
                if self.ends_now(dims) || redundant.contains(&tag) {
                    continue;
                }
                it.dims.clear();
                it.dims.extend(dims);
                let Some(key) = self.passed.insert(&it, 0, |_, _| 0) else {
                    continue;
                };
                let node = self.nodes.len() as u32;
                let mut edges = u32::MAX;
                let mut link = tag;
                while link != u32::MAX {
                    let (parent, next) = links[link as usize];
                    self.edges.push((parent, edges));
                    edges = self.edges.len() as u32 - 1;
                    link = next;
                }
                let start = self.dims.len();
                self.dims.extend(dims);
                self.nodes.push(Node {
                    key,
                    start,
                    len: dims.len() as u32,
                    time,
                    edges,
                });
                decode_to(&self.stepper, &it.key, dims, &mut s);
                match lazy::next_moment(&self.lazy, &self.stepper, &s) {
                    Some(jump) => {
                        self.queue
                            .entry(time + u64::from(jump))
                            .or_default()
                            .push(node);
                    }
                    None => {
                        if self.deadlock.is_none() {
                            self.deadlock = Some(Sight { parent: node, time });
                        }
                        self.waits_forever(&s, Sight { parent: node, time });
                    }
                }
            }
        }
        self.layer = layer;
    }

    /// Whether time cannot pass in a box, as a window is at its end.
    fn ends_now(&self, dims: &[Ticks]) -> bool {
        let windows = dims.len() - self.stepper.layout.clocks();
        dims[..windows].chunks_exact(2).any(|w| w[1] == 0)
    }

    /// Tags of calm states that others of the layer reach by ends that can wait. Not all of them if there are
    /// very many: finding them must not take longer than following them.
    fn redundant(&self, layer: &Store) -> FxHashSet<u32> {
        // Those with most codels executing reach most others.
        let mut sources: Vec<(usize, u32, &[Ticks], u32)> = Vec::new();
        for key in (0..layer.len() as u32).filter(|&it| self.layer_calm[it as usize]) {
            let covers = layer.covers(key).filter(|it| !self.ends_now(it.0));
            sources.extend(covers.map(|(dims, tag)| (dims.len(), key, dims, tag)));
        }
        sources.sort_by_key(|it| std::cmp::Reverse(it.0));
        let mut out = FxHashSet::default();
        let mut budget = 1000 + CLOSURES * layer.len();
        for (_, key, dims, tag) in sources {
            if budget == 0 || self.cancel.is_over() {
                break;
            }
            if out.contains(&tag) {
                continue;
            }
            let s = decode(&self.stepper, layer.key(key), dims);
            self.lazy.closure(&self.stepper, &s, &mut budget, |it| {
                for (other, other_tag) in layer.find(&it.key) {
                    if other_tag != tag && holds(&self.stepper.layout, &it.dims, other) {
                        out.insert(other_tag);
                    }
                }
            });
        }
        out
    }

    /// Nothing will happen after a node: whatever is measured there has no bound.
    fn waits_forever(&mut self, s: &State, at: Sight) {
        if self.diverging.is_some() {
            return;
        }
        let gauge = (0..self.gauges.len()).find(|&it| self.measures(it, s).is_some());
        if let Some(gauge) = gauge {
            self.limits_in_jump(s, at.parent, Ticks::MAX);
            self.diverging = Some(Diverging {
                gauge,
                proof: Some(self.trace(at, &Goal::Deadlock)),
                excess: None,
            });
        }
    }

    fn out_of_bounds(&mut self) -> bool {
        let states = self.nodes.len() + self.layer.len();
        let reason = Stop::reason(states, self.memory(), self.limits, self.cancel);
        if reason.is_some() {
            self.stopped = reason;
        } else if self.answered() && !self.lingers() {
            self.stopped = Some(Stop::Answered);
        }
        self.stopped.is_some()
    }

    /// Whether everything that is asked has been seen.
    fn answered(&self) -> bool {
        (0..self.gauges.len()).all(|it| self.is_longest(it))
            && self.missed.iter().all(Option::is_some)
            && self.overdue.iter().all(Option::is_some)
            && self.reached.iter().all(Option::is_some)
            && (!self.watch.deadlock || self.deadlock.is_some())
    }

    /// Whether to go on for a while when everything is answered, as requests may turn out to be refused.
    fn lingers(&mut self) -> bool {
        let at = *self.answered_at.get_or_insert(self.steps);
        self.stepper.system.may_refuse() && self.steps < at + LINGER
    }

    /// Whether the longest time of a gauge has been seen, and nothing else is wanted of it.
    fn is_longest(&self, gauge: usize) -> bool {
        let it = &self.gauges[gauge];
        it.most.is_some_and(|most| {
            it.active()
                && it.limit.is_none_or(|limit| most <= limit)
                && self.longest[gauge].is_some_and(|it| it.value >= most)
        })
    }

    /// States kept; where the exploration was broken off also those of the moment at which that happened.
    fn states(&self) -> usize {
        match self.stopped {
            None | Some(Stop::Answered) => self.nodes.len(),
            Some(_) => self.nodes.len() + self.layer.len(),
        }
    }

    fn memory(&self) -> usize {
        self.passed.memory()
            + self.layer.memory()
            + self.nodes.capacity() * size_of::<Node>()
            + self.dims.capacity() * size_of::<Ticks>()
            + self.edges.capacity() * size_of::<(u32, u32)>()
            + self.nodes.len() * QUEUED
            + self.under_way
            + self.spare.len() * self.stepper.layout.state_bytes()
    }

    // ---- What is watched -------------------------------------------------------------------

    /// Looks at a state that was just entered.
    fn check(&mut self, before: Option<&State>, s: &State, at: Sight) {
        for (i, &task) in self.watch.schedulable.iter().enumerate() {
            if self.missed[i].is_none() && missed(&self.stepper, s, task) {
                for it in self.symmetry.alike(task, &self.watch.schedulable) {
                    self.missed[it] = Some(at);
                }
                if self.watch.stop_at_first {
                    self.stopped = Some(Stop::Answered);
                }
            }
        }
        for (i, it) in self.watch.reach.iter().enumerate() {
            if self.reached[i].is_none() && observe::predicate(&self.stepper, before, s, it) {
                self.reached[i] = Some(at);
            }
        }
        for (i, gauge) in self.gauges.iter().enumerate() {
            if self.longest[i].is_none() && gauge.of.runs(&self.stepper.layout, s) {
                for it in self.alike(i) {
                    self.longest[it] = Some(Longest { value: 0, at });
                }
            }
        }
    }

    /// Gauges of what is not told apart, itself included.
    fn alike(&self, gauge: usize) -> Vec<usize> {
        let it = &self.gauges[gauge];
        let Timing::Response(task) = it.of else {
            return vec![gauge];
        };
        let orbit = self.symmetry.orbit(task);
        let same = |other: &Gauge| {
            let alike = matches!(other.of, Timing::Response(task) if orbit.contains(&task));
            alike && (other.limit, other.most) == (it.limit, it.most)
        };
        (0..self.gauges.len())
            .filter(|&other| same(&self.gauges[other]))
            .collect()
    }

    /// What has been found of one gauge holds for all that are not told apart.
    fn of_all_alike(&self, found: Diverging) -> Vec<(usize, Diverging)> {
        let Timing::Response(from) = self.gauges[found.gauge].of else {
            return vec![(found.gauge, found)];
        };
        let of = |gauge: usize| {
            let Timing::Response(to) = self.gauges[gauge].of else {
                return (gauge, found.clone());
            };
            let run = |it: &Option<Run>| it.as_ref().map(|it| self.exchanged(it, from, to));
            let renamed = Diverging {
                gauge,
                proof: run(&found.proof),
                excess: run(&found.excess),
            };
            (gauge, renamed)
        };
        self.alike(found.gauge).into_iter().map(of).collect()
    }

    /// A run with one task in the place of another that is not told apart from it.
    fn exchanged(&self, run: &Run, from: usize, to: usize) -> Run {
        let renaming = self.symmetry.exchange(&self.stepper.layout, from, to);
        let steps = run.steps.iter();
        Run {
            steps: steps
                .map(|&(time, it)| (time, renaming.action(it)))
                .collect(),
            ..run.clone()
        }
    }

    /// The clock of a gauge, if it measures now.
    fn measures(&self, gauge: usize, s: &State) -> Option<usize> {
        let (l, of) = (&self.stepper.layout, self.gauges[gauge].of);
        let other = matches!(of, Timing::Response(task) if self.waiting_only[task]);
        of.clock(l).filter(|_| !other && of.runs(l, s))
    }

    /// Notes the limits that are exceeded in a jump from a node, and when. The first moment counts, and jumps
    /// overlap.
    fn limits_in_jump(&mut self, s: &State, parent: u32, jump: Ticks) {
        for i in 0..self.gauges.len() {
            let (Some(limit), Some(clock)) = (self.gauges[i].limit, self.measures(i, s)) else {
                continue;
            };
            // Clocks beyond the limit were seen when they passed it.
            let Some(left) = limit.checked_sub(s.t[clock]).filter(|&it| it < jump) else {
                continue;
            };
            let time = self.nodes[parent as usize].time + u64::from(left) + 1;
            if self.excess[i].is_none_or(|it| time < it.time) {
                for it in self.alike(i) {
                    self.excess[it] = Some(Sight { parent, time });
                }
            }
        }
    }

    /// The same for the jumps that have begun when the exploration ends.
    fn limits_under_way(&mut self) {
        if self.gauges.iter().all(|it| it.limit.is_none()) {
            return;
        }
        for (time, parents) in std::mem::take(&mut self.queue) {
            for (i, parent) in parents.into_iter().enumerate() {
                if i % LOOKS == 0 && self.cancel.is_abandoned() {
                    return;
                }
                let s = self.node_state(parent);
                let jump = (time - self.nodes[parent as usize].time) as Ticks;
                self.limits_in_jump(&s, parent, jump);
            }
        }
    }

    fn excess_run(&self, gauge: usize) -> Option<Run> {
        let Gauge { of, limit, .. } = self.gauges[gauge];
        Some(self.trace(self.excess[gauge]?, &Goal::Lasts(of, limit? + 1)))
    }

    /// Looks at clocks after time has passed.
    fn clocks_after_jump(&mut self, s: &mut State, at: Sight) -> Option<Diverging> {
        for (i, &task) in self.watch.overdue.iter().enumerate() {
            if self.overdue[i].is_none() && overdue(&self.stepper, s, task) {
                for it in self.symmetry.alike(task, &self.watch.overdue) {
                    self.overdue[it] = Some(at);
                }
            }
            if self.waiting_only[task]
                && let Some(clock) = self.stepper.layout.response[task]
            {
                let running = self.stepper.layout.status(s, task) == TaskStatus::Running;
                let most = self.stepper.system.tasks[task].period.unwrap_or(0);
                s.t[clock] = if running { 0 } else { s.t[clock].min(most) };
            }
        }
        for i in 0..self.gauges.len() {
            let Some(clock) = self.measures(i, s) else {
                continue;
            };
            let value = s.t[clock];
            if self.longest[i].is_some_and(|it| it.value >= value) {
                continue;
            }
            for it in self.alike(i) {
                self.longest[it] = Some(Longest { value, at });
            }
            if value <= self.patience || self.out_of_bounds() {
                continue;
            }
            self.patience = self.patience.saturating_mul(2);
            let run = self.trace(at, &Goal::Lasts(self.gauges[i].of, value));
            let mut out = Diverging {
                gauge: i,
                proof: None,
                excess: None,
            };
            let clock = (&self.observers[..], value);
            if let Some(cycle) = run.repetition(&self.stepper, clock, self.cancel) {
                let limit = self.gauges[i].limit;
                let left = limit.and_then(|it| it.checked_sub(value));
                out.excess = left.and_then(|it| run.prolonged(cycle, it + 1));
                out.proof = Some(run.repeating(cycle));
                return Some(out);
            }
            if !self.patient && !self.cancel.is_abandoned() {
                return Some(out);
            }
        }
        None
    }

    /// What is known of each gauge.
    fn measured(&self) -> Vec<Option<Measured>> {
        let found = |run| Found { run };
        (0..self.gauges.len())
            .map(|i| {
                let gauge = &self.gauges[i];
                let excess = gauge
                    .excess
                    .clone()
                    .or_else(|| self.excess_run(i))
                    .map(found);
                if let How::Unbounded(run) = &gauge.how {
                    return Some(Measured {
                        bound: Bound::Unbounded,
                        longest: found(run.clone()),
                        excess,
                    });
                }
                let (reached, limit) = (self.longest[i].map(|it| it.value), gauge.limit);
                if let (Some(run), Some(limit)) =
                    (&gauge.excess, limit.filter(|it| reached <= Some(*it)))
                {
                    // Known from an exploration before, which this one has not come up with.
                    return Some(Measured {
                        bound: Bound::Finite(limit + 1),
                        longest: found(run.clone()),
                        excess,
                    });
                }
                self.longest[i].map(|it| Measured {
                    bound: Bound::Finite(it.value),
                    longest: found(self.trace(it.at, &Goal::Lasts(gauge.of, it.value))),
                    excess,
                })
            })
            .collect()
    }

    fn findings(self) -> Findings {
        let found = |at: Sight, goal: Goal| Found {
            run: self.trace(at, &goal),
        };
        let mut response = self.measured();
        let within = response.split_off(self.watch.response.len());
        Findings {
            missed: (self.watch.schedulable.iter().zip(&self.missed))
                .map(|(&task, at)| at.map(|at| found(at, Goal::Missed(task))))
                .collect(),
            overdue: (self.watch.overdue.iter().zip(&self.overdue))
                .map(|(&task, at)| at.map(|at| found(at, Goal::Overdue(task))))
                .collect(),
            response,
            reached: (self.watch.reach.iter().zip(&self.reached))
                .map(|(it, at)| at.map(|at| found(at, Goal::Reach(it))))
                .collect(),
            within,
            deadlock: self
                .deadlock
                .filter(|_| self.watch.deadlock)
                .map(|at| found(at, Goal::Deadlock)),
            refused: (0..self.stepper.refused.len())
                .filter(|&service| {
                    let mut orbit = self.symmetry.service_orbit(service).iter();
                    orbit.any(|&it| self.stepper.refused[it].get())
                })
                .collect(),
            states: self.states(),
            steps: self.steps,
            bytes: self.memory(),
            stopped: self.stopped,
        }
    }
}

fn missed(stepper: &Stepper, s: &State, task: usize) -> bool {
    stepper.layout.pending(s, task) && stepper.layout.status(s, task) != TaskStatus::Idle
}

fn overdue(stepper: &Stepper, s: &State, task: usize) -> bool {
    let l = &stepper.layout;
    let (Some(period), Some(clock)) = (stepper.system.tasks[task].period, l.response[task]) else {
        return false;
    };
    l.status(s, task) == TaskStatus::Waiting && s.t[clock] >= period
}

/// Concatenates two lists of parents.
fn join(links: &mut [(u32, u32)], one: u32, other: u32) -> u32 {
    // Lists are short; parents already present are not repeated.
    let mut last = one;
    loop {
        if links[last as usize].0 == links[other as usize].0 && links[other as usize].1 == u32::MAX
        {
            return one;
        }
        if links[last as usize].1 == u32::MAX {
            break;
        }
        last = links[last as usize].1;
    }
    links[last as usize].1 = other;
    one
}
