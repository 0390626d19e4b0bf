//! Exploration in order of time, and what is watched meanwhile.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use rustc_hash::FxHashSet;

use super::ample::{Ample, visible_tasks};
use super::lazy::{self, Lazy};
use super::observe::{self, Observer};
use super::overtake::{Held, Now, Overtake};
use super::run::Run;
use super::state::{Layout, State, TaskStatus, phase};
use super::step::{Action, Enabled, Stepper};
use super::store::{Encoded, Store, decode, encode, holds};
use crate::property::Predicate;
use crate::system::{Ticks, TimedSystem};

/// What is to be found out in one exploration.
#[derive(Debug, Clone, Default)]
pub struct Watch {
    /// Tasks whose ticks must not come before their jobs have ended.
    pub schedulable: Vec<usize>,
    /// Tasks that must not wait for a core as long as their period.
    pub overdue: Vec<usize>,
    /// Tasks whose response time is wanted.
    pub response: Vec<usize>,
    /// Predicates to be reached.
    pub reach: Vec<Predicate>,
    /// Pairs of predicates whose least bound is wanted.
    pub within: Vec<(Predicate, Predicate)>,
    /// Look for states in which nothing will ever happen again.
    pub deadlock: bool,
    /// Stop as soon as a tick came too early.
    pub stop_at_first: bool,
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Too many states or too much memory.
    Limit,
    /// Cancelled from outside.
    Cancelled,
    /// Everything that was asked has been found, or with [`Watch::stop_at_first`] the first of it.
    Answered,
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

/// What an exploration found. Lists follow those of the [`Watch`].
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// Runs in which a tick came too early.
    pub missed: Vec<Option<Found>>,
    /// Runs in which a task waited too long.
    pub overdue: Vec<Option<Found>>,
    /// Response times and runs that reach them; `None` if the task was never released.
    pub response: Vec<Option<(Bound, Found)>>,
    /// Runs to the predicates.
    pub reached: Vec<Option<Found>>,
    /// Least bounds; `None` if the first predicate never became true.
    pub within: Vec<Option<(Bound, Found)>>,
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
pub fn explore(
    system: &TimedSystem,
    watch: &Watch,
    limits: Limits,
    cancel: &AtomicBool,
) -> Findings {
    let mut state = Measures {
        response: vec![Measure::Shared; watch.response.len()],
        within: vec![Measure::Shared; watch.within.len()],
    };
    let mut findings = loop {
        let mut search = Search::new(system, watch, &state, limits, cancel);
        match search.run() {
            Some(diverging) => state.note(diverging),
            None => break search.findings(&state),
        }
    };
    // What grew suspiciously is measured alone, so that clocks do not multiply.
    for i in 0..state.response.len() {
        if state.response[i] == Measure::Alone && findings.stopped.is_none() {
            let alone = Watch {
                response: vec![watch.response[i]],
                ..Watch::default()
            };
            let mut found = explore_alone(system, &alone, limits, cancel);
            findings.response[i] = found.response.pop().flatten();
            findings.absorb(&found);
        }
    }
    for i in 0..state.within.len() {
        if state.within[i] == Measure::Alone && findings.stopped.is_none() {
            let alone = Watch {
                within: vec![watch.within[i].clone()],
                ..Watch::default()
            };
            let mut found = explore_alone(system, &alone, limits, cancel);
            findings.within[i] = found.within.pop().flatten();
            findings.absorb(&found);
        }
    }
    findings
}

fn explore_alone(
    system: &TimedSystem,
    watch: &Watch,
    limits: Limits,
    cancel: &AtomicBool,
) -> Findings {
    let mut state = Measures {
        response: vec![Measure::Patient; watch.response.len()],
        within: vec![Measure::Patient; watch.within.len()],
    };
    loop {
        let mut search = Search::new(system, watch, &state, limits, cancel);
        match search.run() {
            Some(diverging) => state.note(diverging),
            None => return search.findings(&state),
        }
    }
}

impl Findings {
    fn absorb(&mut self, other: &Findings) {
        self.states += other.states;
        self.steps += other.steps;
        self.bytes = self.bytes.max(other.bytes);
        self.stopped = self.stopped.or(other.stopped);
    }
}

/// How a time is measured.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Measure {
    /// Together with others.
    Shared,
    /// Not now, as it grew suspiciously; later on its own.
    Alone,
    /// On its own, until it repeats itself.
    Patient,
    /// No more, as this run proves that there is no bound.
    Unbounded(Run),
}

impl Measure {
    fn active(&self) -> bool {
        matches!(self, Measure::Shared | Measure::Patient)
    }
}

struct Measures {
    response: Vec<Measure>,
    within: Vec<Measure>,
}

impl Measures {
    fn note(&mut self, diverging: Diverging) {
        let of = |run: Option<Run>| run.map_or(Measure::Alone, Measure::Unbounded);
        match diverging {
            Diverging::Response(i, run) => self.response[i] = of(run),
            Diverging::Within(i, run) => self.within[i] = of(run),
        }
    }
}

/// What grows, with a run that proves that it has no bound; without one it is only suspected.
enum Diverging {
    Response(usize, Option<Run>),
    Within(usize, Option<Run>),
}

/// States looked at per state of a layer to find those that are reached by ends that can wait.
const CLOSURES: usize = 1;

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
    watch: &'a Watch,
    observers: Vec<Observer>,
    limits: Limits,
    cancel: &'a AtomicBool,
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
    response: Vec<Option<Longest>>,
    within: Vec<Option<Longest>>,
    deadlock: Option<Sight>,
    /// Clocks are examined for divergence when they exceed this.
    patience: Ticks,
    /// Tasks whose clock only serves the overdue check.
    waiting_only: Vec<bool>,
    stopped: Option<Stop>,
    /// Found while a layer was closed.
    diverging: Option<Diverging>,
    /// Look for repetition until it is found.
    patient: bool,
}

/// What a state that was sighted looks like.
enum Goal<'g> {
    Missed(usize),
    Overdue(usize),
    Reach(&'g Predicate),
    Response(usize, Ticks),
    Within(usize, Ticks),
    Calm(&'g [u8], &'g [Ticks]),
    Deadlock,
}

impl<'a> Search<'a> {
    fn new(
        system: &'a TimedSystem,
        watch: &'a Watch,
        measures: &Measures,
        limits: Limits,
        cancel: &'a AtomicBool,
    ) -> Self {
        let measured = |task: usize| {
            watch
                .response
                .iter()
                .zip(&measures.response)
                .any(|(&t, measure)| t == task && measure.active())
        };
        let waiting_only: Vec<bool> = (0..system.tasks.len())
            .map(|t| !measured(t) && watch.overdue.contains(&t) && system.tasks[t].period.is_some())
            .collect();
        let observed: Vec<bool> = (0..system.tasks.len())
            .map(|t| measured(t) || waiting_only[t])
            .collect();
        let clocked: Vec<bool> = measures.within.iter().map(Measure::active).collect();
        let patient = measures
            .response
            .iter()
            .chain(&measures.within)
            .any(|it| *it == Measure::Patient);
        let layout = Layout::new(system, &observed, &clocked);
        let predicates = watch.within.iter().flat_map(|(p, q)| [p, q]);
        let visible = visible_tasks(system, predicates.chain(&watch.reach));
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
        let lazy = Lazy::new(system, &visible, &observed);
        let ample = Ample::new(system, visible, &observed);
        Search {
            stepper: Stepper::new(system, layout),
            lazy,
            overtake: Overtake::new(system, &ample),
            ample,
            watch,
            observers: watch
                .within
                .iter()
                .map(|(trigger, response)| Observer {
                    trigger: trigger.clone(),
                    response: response.clone(),
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
            response: vec![None; watch.response.len()],
            within: vec![None; watch.within.len()],
            deadlock: None,
            patience: longest.saturating_add(work).max(16),
            waiting_only,
            stopped: None,
            diverging: None,
            patient,
        }
    }
}

// ---- Exploration ------------------------------------------------------------------------------

impl Search<'_> {
    fn run(&mut self) -> Option<Diverging> {
        let initial = self.stepper.initial();
        self.close_layer(0, vec![(initial, ROOT)], true);
        if self.diverging.is_some() {
            return self.diverging.take();
        }
        while let Some((time, parents)) = self.queue.pop_first() {
            let mut states = Vec::with_capacity(parents.len());
            for parent in parents {
                let mut s = self.node_state(parent);
                let jump = (time - self.nodes[parent as usize].time) as Ticks;
                self.stepper.elapse(&mut s, jump);
                if let Some(diverging) = self.clocks_after_jump(&mut s, Sight { parent, time }) {
                    return Some(diverging);
                }
                states.push((s, parent));
            }
            self.close_layer(time, states, false);
            if self.diverging.is_some() {
                return self.diverging.take();
            }
            if self.stopped.is_some() {
                return None;
            }
        }
        self.diverging.take()
    }

    fn node_state(&self, node: u32) -> State {
        let node = &self.nodes[node as usize];
        let dims = &self.dims[node.start..node.start + node.len as usize];
        decode(&self.stepper, self.passed.key(node.key), dims)
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
                let mut next = s.clone();
                self.step(&mut next, action, &mut held, Sight { parent, time });
                stack.push((next, parent, held));
            }
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
        for key in 0..layer.len() as u32 {
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
                let s = decode(&self.stepper, &it.key, dims);
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
            if budget == 0 {
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
        let l = &self.stepper.layout;
        let response = self.watch.response.iter().position(|&task| {
            !self.waiting_only[task]
                && l.response[task].is_some()
                && l.status(s, task) != TaskStatus::Idle
        });
        let within =
            (0..self.observers.len()).find(|&i| l.observer_clock[i].is_some() && l.open(s, i) != 0);
        if let Some(i) = response {
            self.diverging = Some(Diverging::Response(
                i,
                Some(self.trace(at, &Goal::Deadlock)),
            ));
        } else if let Some(i) = within {
            self.diverging = Some(Diverging::Within(i, Some(self.trace(at, &Goal::Deadlock))));
        }
    }

    fn out_of_bounds(&mut self) -> bool {
        if self.cancel.load(Ordering::Relaxed) {
            self.stopped = Some(Stop::Cancelled);
        } else if self.nodes.len() + self.layer.len() > self.limits.states
            || ((self.steps >> 4).is_multiple_of(1 << 10) && self.memory() > self.limits.bytes)
        {
            self.stopped = Some(Stop::Limit);
        } else if self.answered() {
            self.stopped = Some(Stop::Answered);
        }
        self.stopped.is_some()
    }

    /// Whether everything that is asked has been seen. With clients the rest may still show that a request is refused.
    fn answered(&self) -> bool {
        self.watch.response.is_empty()
            && self.watch.within.is_empty()
            && self.stepper.system.clients.is_empty()
            && self.missed.iter().all(Option::is_some)
            && self.overdue.iter().all(Option::is_some)
            && self.reached.iter().all(Option::is_some)
            && (!self.watch.deadlock || self.deadlock.is_some())
    }

    fn memory(&self) -> usize {
        self.passed.memory()
            + self.layer.memory()
            + self.nodes.capacity() * size_of::<Node>()
            + self.dims.capacity() * size_of::<Ticks>()
            + self.edges.capacity() * 8
    }

    // ---- What is watched -------------------------------------------------------------------

    /// Looks at a state that was just entered.
    fn check(&mut self, before: Option<&State>, s: &State, at: Sight) {
        for (i, &task) in self.watch.schedulable.iter().enumerate() {
            if self.missed[i].is_none() && missed(&self.stepper, s, task) {
                self.missed[i] = Some(at);
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
        for (i, &task) in self.watch.response.iter().enumerate() {
            if self.response[i].is_none() && self.stepper.layout.status(s, task) != TaskStatus::Idle
            {
                self.response[i] = Some(Longest { value: 0, at });
            }
        }
        for i in 0..self.observers.len() {
            if self.within[i].is_none() && self.stepper.layout.open(s, i) != 0 {
                self.within[i] = Some(Longest { value: 0, at });
            }
        }
    }

    /// Looks at clocks after time has passed.
    fn clocks_after_jump(&mut self, s: &mut State, at: Sight) -> Option<Diverging> {
        for (i, &task) in self.watch.overdue.iter().enumerate() {
            if self.overdue[i].is_none() && overdue(&self.stepper, s, task) {
                self.overdue[i] = Some(at);
            }
            if self.waiting_only[task]
                && let Some(clock) = self.stepper.layout.response[task]
            {
                let running = self.stepper.layout.status(s, task) == TaskStatus::Running;
                let most = self.stepper.system.tasks[task].period.unwrap_or(0);
                s.t[clock] = if running { 0 } else { s.t[clock].min(most) };
            }
        }
        for (i, &task) in self.watch.response.iter().enumerate() {
            let Some(clock) = self.stepper.layout.response[task] else {
                continue;
            };
            if self.waiting_only[task] || self.stepper.layout.status(s, task) == TaskStatus::Idle {
                continue;
            }
            let value = s.t[clock];
            if self.response[i].is_none_or(|it| it.value < value) {
                self.response[i] = Some(Longest { value, at });
                if value > self.patience {
                    self.patience = self.patience.saturating_mul(2);
                    let run = self.trace(at, &Goal::Response(task, value));
                    if run.repeats(&self.stepper, &self.observers, value) {
                        return Some(Diverging::Response(i, Some(run)));
                    }
                    if !self.patient {
                        return Some(Diverging::Response(i, None));
                    }
                }
            }
        }
        for i in 0..self.observers.len() {
            let Some(clock) = self.stepper.layout.observer_clock[i] else {
                continue;
            };
            if self.stepper.layout.open(s, i) == 0 {
                continue;
            }
            let value = s.t[clock];
            if self.within[i].is_none_or(|it| it.value < value) {
                self.within[i] = Some(Longest { value, at });
                if value > self.patience {
                    self.patience = self.patience.saturating_mul(2);
                    let run = self.trace(at, &Goal::Within(i, value));
                    if run.repeats(&self.stepper, &self.observers, value) {
                        return Some(Diverging::Within(i, Some(run)));
                    }
                    if !self.patient {
                        return Some(Diverging::Within(i, None));
                    }
                }
            }
        }
        None
    }

    fn findings(self, measures: &Measures) -> Findings {
        let found = |at: Sight, goal: Goal| Found {
            run: self.trace(at, &goal),
        };
        let responses = self
            .watch
            .response
            .iter()
            .zip(&self.response)
            .zip(&measures.response);
        let withins = self.within.iter().zip(&measures.within).enumerate();
        Findings {
            missed: (self.watch.schedulable.iter().zip(&self.missed))
                .map(|(&task, at)| at.map(|at| found(at, Goal::Missed(task))))
                .collect(),
            overdue: (self.watch.overdue.iter().zip(&self.overdue))
                .map(|(&task, at)| at.map(|at| found(at, Goal::Overdue(task))))
                .collect(),
            response: responses
                .map(|((&task, longest), measure)| match measure {
                    Measure::Unbounded(run) => Some((Bound::Unbounded, Found { run: run.clone() })),
                    _ => longest.map(|it| {
                        let goal = Goal::Response(task, it.value);
                        (Bound::Finite(it.value), found(it.at, goal))
                    }),
                })
                .collect(),
            reached: (self.watch.reach.iter().zip(&self.reached))
                .map(|(it, at)| at.map(|at| found(at, Goal::Reach(it))))
                .collect(),
            within: withins
                .map(|(i, (longest, measure))| match measure {
                    Measure::Unbounded(run) => Some((Bound::Unbounded, Found { run: run.clone() })),
                    _ => longest.map(|it| {
                        (
                            Bound::Finite(it.value),
                            found(it.at, Goal::Within(i, it.value)),
                        )
                    }),
                })
                .collect(),
            deadlock: self
                .deadlock
                .filter(|_| self.watch.deadlock)
                .map(|at| found(at, Goal::Deadlock)),
            refused: (self.stepper.refused.iter().enumerate())
                .filter_map(|(service, refused)| refused.get().then_some(service))
                .collect(),
            states: self.nodes.len(),
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

// ---- Runs -------------------------------------------------------------------------------------

/// Remaining time of each executing executor at some point of a run.
type Point = Vec<Option<Ticks>>;

impl Search<'_> {
    /// A run to what was seen: segments from node to node, found backwards with the remaining times
    /// that the later part of the run needs.
    fn trace(&self, at: Sight, goal: &Goal) -> Run {
        let mut segments = Vec::new();
        let mut node = at.parent;
        if !matches!(goal, Goal::Deadlock) {
            let Some((actions, last)) = self.segment(at.parent, at.time, goal) else {
                return Run::default();
            };
            let mut point = self.any_point(&last);
            segments.push((at.time, actions));
            while node != ROOT {
                point = self.point_before(node, segments.last().expect("pushed above"), &point);
                let Some((parent, actions)) = self.segment_to(node, &point) else {
                    break;
                };
                segments.push((self.nodes[node as usize].time, actions));
                node = parent;
            }
        } else {
            let mut point = self.any_point(&self.node_state(node));
            while let Some((parent, actions)) = self.segment_to(node, &point) {
                segments.push((self.nodes[node as usize].time, actions));
                node = parent;
                if node == ROOT {
                    break;
                }
                point = self.point_before(node, segments.last().expect("pushed above"), &point);
            }
        }
        let mut run = Run::default();
        for (time, actions) in segments.into_iter().rev() {
            run.extend(time, actions);
        }
        run.end = at.time;
        run
    }

    fn any_point(&self, s: &State) -> Point {
        (0..self.stepper.layout.executors())
            .map(|e| {
                let executing = self.stepper.layout.phase(s, e) & !phase::ASYNC == phase::EXECUTING;
                let (a, b) = self.stepper.layout.window(s, e);
                executing.then_some(if b == crate::system::FOREVER { a } else { b })
            })
            .collect()
    }

    /// The remaining times in a node, given a segment that starts there and those at its end.
    fn point_before(
        &self,
        node: u32,
        (time, actions): &(u64, Vec<Action>),
        after: &Point,
    ) -> Point {
        let s = self.node_state(node);
        let jump = (time - self.nodes[node as usize].time) as Ticks;
        (0..self.stepper.layout.executors())
            .map(|e| {
                if self.stepper.layout.phase(&s, e) & !phase::ASYNC != phase::EXECUTING {
                    return None;
                }
                let ended = actions
                    .iter()
                    .any(|it| matches!(it, Action::Finish { executor, .. } if *executor == e));
                Some(if ended {
                    jump
                } else {
                    jump + after[e].unwrap_or(0)
                })
            })
            .collect()
    }

    /// A way from one of the parents of a node to the given point of it.
    fn segment_to(&self, node: u32, point: &Point) -> Option<(u32, Vec<Action>)> {
        let record = &self.nodes[node as usize];
        let mut s = self.node_state(node);
        for (e, remaining) in point.iter().enumerate() {
            if let Some(remaining) = *remaining {
                self.stepper
                    .layout
                    .set_window(&mut s, e, (remaining, remaining));
            }
        }
        let mut wanted = Encoded::default();
        encode(&self.stepper, &s, &mut wanted);
        let mut edge = record.edges;
        while let Some(&(parent, next)) = self.edges.get(edge as usize) {
            let goal = Goal::Calm(&wanted.key, &wanted.dims);
            if let Some((actions, _)) = self.segment(parent, record.time, &goal) {
                return Some((parent, actions));
            }
            edge = next;
        }
        None
    }

    /// Actions at one moment after the jump of a node, up to a state like the goal.
    fn segment(&self, parent: u32, time: u64, goal: &Goal) -> Option<(Vec<Action>, State)> {
        let mut start = if parent == ROOT {
            let mut s = self.stepper.initial();
            observe::observe(&self.stepper, &self.observers, None, &mut s);
            s
        } else {
            let mut s = self.node_state(parent);
            self.stepper
                .elapse(&mut s, (time - self.nodes[parent as usize].time) as Ticks);
            s
        };
        self.clamp_waiting(&mut start);
        let mut seen = rustc_hash::FxHashSet::default();
        // Breadth first, for short runs: (state, predecessor, action).
        let mut found: Vec<(State, usize, Option<Action>)> = vec![(start, usize::MAX, None)];
        let mut enabled = Enabled::default();
        let mut followed = Vec::new();
        let mut it = Encoded::default();
        let mut at = 0;
        while at < found.len() {
            let s = found[at].0.clone();
            let before = found.get(found[at].1).map(|it| it.0.clone());
            self.stepper.enabled(&s, &mut enabled);
            if self.is_goal(before.as_ref(), &s, &enabled, goal) {
                let mut actions = Vec::new();
                let mut back = at;
                while let Some(action) = found[back].2 {
                    actions.push(action);
                    back = found[back].1;
                }
                actions.reverse();
                return Some((actions, s));
            }
            self.ample
                .select(&self.stepper, &s, &enabled, &mut followed);
            for &action in &followed {
                let mut next = s.clone();
                self.stepper.apply(&mut next, action);
                observe::observe(&self.stepper, &self.observers, Some(&s), &mut next);
                if let Action::Grant { task } = action
                    && self.waiting_only[task]
                    && let Some(clock) = self.stepper.layout.response[task]
                {
                    next.t[clock] = 0;
                }
                encode(&self.stepper, &next, &mut it);
                // What is left is seen in a step, not in the state it leads to.
                let by_step =
                    matches!(goal, Goal::Reach(_)) && self.is_goal(Some(&s), &next, &enabled, goal);
                if seen.insert((it.clone(), by_step)) {
                    found.push((next, at, Some(action)));
                }
            }
            at += 1;
        }
        None
    }

    fn clamp_waiting(&self, s: &mut State) {
        let l = &self.stepper.layout;
        for (task, only) in self.waiting_only.iter().enumerate() {
            if *only && let Some(clock) = l.response[task] {
                let running = l.status(s, task) == TaskStatus::Running;
                let most = self.stepper.system.tasks[task].period.unwrap_or(0);
                s.t[clock] = if running { 0 } else { s.t[clock].min(most) };
            }
        }
    }

    fn is_goal(&self, before: Option<&State>, s: &State, enabled: &Enabled, goal: &Goal) -> bool {
        let l = &self.stepper.layout;
        match *goal {
            Goal::Missed(task) => missed(&self.stepper, s, task),
            Goal::Overdue(task) => overdue(&self.stepper, s, task),
            Goal::Reach(it) => observe::predicate(&self.stepper, before, s, it),
            Goal::Response(task, value) => {
                l.status(s, task) != TaskStatus::Idle
                    && l.response[task].is_none_or(|clock| s.t[clock] >= value)
            }
            Goal::Within(i, value) => {
                l.open(s, i) != 0 && l.observer_clock[i].is_none_or(|clock| s.t[clock] >= value)
            }
            Goal::Calm(key, dims) => {
                if enabled.committed || enabled.urgent {
                    return false;
                }
                let mut it = Encoded::default();
                encode(&self.stepper, s, &mut it);
                it.key == key && holds(l, &it.dims, dims)
            }
            Goal::Deadlock => false,
        }
    }
}
