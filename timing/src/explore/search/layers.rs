//! Layers: breadth-first search in order of time, from moment to moment.
//!
//! All simultaneous actions of a moment are followed, the calm states they lead to are kept as nodes, and
//! each node jumps to its next moment. Layers prove checks, and find the shortest runs.

mod effort;
pub(super) mod trace;

use rustc_hash::FxHashSet;

use self::trace::{ReconstructedRuns, Target};
use super::graph::{Graph, Links, NodeId};
use super::observations::{Observations, Sight};
use crate::cancel::Cancel;
use crate::explore::measure::{Divergence, Gauge, MeasurementMode};
use crate::explore::reductions::{Kind, SleepSet};
use crate::explore::rules::{Enabled, Rules};
use crate::explore::run::Run;
use crate::explore::state::State;
use crate::explore::store::{Covering, Encoded, Store, decode, encode, holds};
use crate::explore::watch::{Limits, Stop, Watch};
use crate::system::Ticks;

/// Number of states examined, per state of a layer, to find the states that are reached by postponed ends.
const CLOSURE_STATES_PER_STATE: usize = 1;

/// Bytes for a state that may reach others: the list of such states doubles as it grows, and sorting needs
/// half of its size in addition.
const SOURCE_BYTES: usize = 4 * size_of::<(usize, u32, &[Ticks], u32)>();

/// Bytes of a tag in a set of tags.
const TAG_BYTES: usize = size_of::<u32>() + 1;

/// Number of states between two polls of the limits.
pub(super) const STATES_PER_POLL: usize = 64;

/// Returns the covering of states within these limits.
pub(super) fn covering(limits: Limits) -> Covering {
    Covering {
        union: !limits.without.contains(Kind::WindowUnion),
        inclusion: !limits.without.contains(Kind::WindowInclusion),
    }
}

/// The states of one moment.
struct Layer {
    states: Store,
    /// Calm states, by state: time may pass.
    calm: Vec<bool>,
    /// Bytes of the initial states of the layer, and of data kept only while the layer is explored.
    under_way: usize,
    /// States and bytes of a finished exploration in addition to the graph. They are released before the
    /// reconstruction of runs.
    released: (usize, usize),
}

/// The controller of an exploration.
pub(super) trait PollControl<'a> {
    /// Polls an exploration every few steps: applies limits, and gives effort to other strategies. Returns
    /// true if the exploration is over.
    fn look(&mut self, layers: &mut Layers<'a>) -> bool;

    /// Is called at the end of the layers.
    fn end(&mut self, layers: &mut Layers<'a>);
}

/// A breadth-first exploration in order of time.
pub(super) struct Layers<'a> {
    pub(super) observations: Observations<'a, NodeId>,
    pub(super) graph: Graph,
    layer: Layer,
    pub(super) steps: u64,
    /// Present moment, in base units.
    pub(super) now: u64,
    pub(super) deadlock: Option<Sight<NodeId>>,
    /// Runs that were reconstructed already.
    pub(super) traced: ReconstructedRuns,
    /// Value of a clock above which the clock is examined for divergence, in base units.
    pub(super) divergence_threshold: Ticks,
    /// Search for a repetition until one is found.
    patient: bool,
    /// Divergence found while a layer was closed.
    pub(super) diverging: Option<Divergence>,
    pub(super) limits: Limits,
    pub(super) cancel: &'a Cancel,
    pub(super) stopped: Option<Stop>,
    /// States whose memory can be reused.
    spare: Vec<State>,
}

impl<'a> Layers<'a> {
    pub(super) fn new(
        rules: &Rules<'a>,
        watch: &'a Watch,
        gauges: &'a [Gauge],
        limits: Limits,
        cancel: &'a Cancel,
    ) -> Self {
        let observations = Observations::new(rules, watch, gauges, limits.without);
        let system = rules.system();
        let longest = system.tasks.iter().filter_map(|task| task.period).max().unwrap_or(0);
        let work = system
            .codels
            .iter()
            .map(
                |codel| {
                    if codel.upper == crate::system::FOREVER { codel.lower } else { codel.upper }
                },
            )
            .fold(0u32, u32::saturating_add);
        let clocks = observations.rules.frame().clocks();
        let covering = covering(limits);
        Layers {
            observations,
            graph: Graph::new(clocks, covering),
            layer: Layer {
                states: Store::new(clocks, covering),
                calm: Vec::new(),
                under_way: 0,
                released: (0, 0),
            },
            steps: 0,
            now: 0,
            deadlock: None,
            traced: ReconstructedRuns::default(),
            divergence_threshold: longest.saturating_add(work).max(16),
            patient: gauges.iter().any(|gauge| gauge.how == MeasurementMode::UntilRepetition),
            diverging: None,
            limits,
            cancel,
            stopped: None,
            spare: Vec::new(),
        }
    }

    // ---- From moment to moment -------------------------------------------------------------

    /// Explores until all states have been examined, the exploration is stopped, or a time diverges.
    pub(super) fn run(&mut self, by: &mut dyn PollControl<'a>) -> Option<Divergence> {
        let initial = self.observations.initial();
        self.close_layer(0, vec![(initial, NodeId::ROOT)], true, by);
        while self.continues()
            && let Some((time, parents)) = self.graph.next_moment()
        {
            self.now = time;
            self.layer.under_way = parents.len() * self.bytes_to_do();
            // Memory beyond the limit is never allocated.
            if by.look(self) {
                break;
            }
            let mut states = Vec::with_capacity(parents.len());
            for (i, parent) in parents.into_iter().enumerate() {
                if i % STATES_PER_POLL == STATES_PER_POLL - 1 && by.look(self) {
                    break;
                }
                let mut s = self.spare.pop().unwrap_or_default();
                let frame = self.observations.rules.frame();
                self.graph.state_to(frame, parent, &mut s);
                let at = Sight { parent, time };
                let jump = self.graph.since(at);
                self.limits_in_jump(&s, parent, jump);
                self.observations.rules.elapse(&mut s, jump);
                if self.diverging.is_none() {
                    self.diverging = self.clocks_after_jump(&mut s, at, by);
                }
                states.push((s, parent));
            }
            if self.continues() {
                self.close_layer(time, states, false, by);
            }
        }
        by.end(self);
        self.release();
        self.limits_under_way();
        let mut diverging = self.diverging.take()?;
        if let Some(excess_run) = self.excess_run(diverging.gauge) {
            diverging.excess = Some(excess_run);
        }
        Some(diverging)
    }

    /// Releases the memory that the reconstruction of runs does not need.
    fn release(&mut self) {
        self.layer.released = (self.layer.states.len(), self.memory_outside_graph());
        self.layer.under_way = 0;
        self.layer.calm = Vec::new();
        self.layer.states = Store::default();
        self.spare = Vec::new();
    }

    fn continues(&self) -> bool {
        self.diverging.is_none() && self.stopped.is_none()
    }

    /// Returns true if the search is over, possibly because all questions are answered.
    fn is_stopped(&mut self) -> bool {
        if self.observations.seen.enough {
            self.stopped.get_or_insert(Stop::Answered);
        }
        self.stopped.is_some()
    }

    /// Follows all simultaneous actions from the states of one moment, then keeps the calm states.
    fn close_layer(
        &mut self,
        time: u64,
        states: Vec<(State, NodeId)>,
        initial: bool,
        by: &mut dyn PollControl<'a>,
    ) {
        self.layer.states.clear();
        self.layer.calm.clear();
        let mut links = Links::default();
        let mut stack: Vec<(State, NodeId, SleepSet)> =
            states.into_iter().map(|(s, parent)| (s, parent, 0)).collect();
        if initial {
            for (s, parent, _) in &stack {
                let parent = *parent;
                self.observations.check(None, s, Sight { parent, time });
            }
        }
        let mut enabled = Enabled::default();
        let mut first = Vec::new();
        let mut followed = Vec::new();
        let mut encoding = Encoded::default();
        while let Some((mut s, parent, mut held)) = stack.pop() {
            self.steps += 1;
            if self.steps % 16 == 1 {
                self.layer.under_way = stack.capacity() * self.bytes_to_do() + links.memory();
            }
            if self.is_stopped() || (self.steps % 16 == 1 && by.look(self)) {
                return;
            }
            let at = Sight { parent, time };
            self.observations.settle(&mut s, &mut held, &mut enabled, |_| at);
            if self.observations.is_past_all(&s) {
                self.spare.push(s);
                continue;
            }
            encode(self.observations.rules.frame(), &s, &mut encoding);
            // States with different sleep sets have different actions to follow, and are different.
            if held != 0 {
                encoding.key.extend(held.to_le_bytes());
            }
            let tag = links.one(parent);
            let join = |one, other| links.join(one, other);
            let Some(key) = self.layer.states.insert(&encoding, tag, join) else {
                links.undo();
                self.spare.push(s);
                continue;
            };
            if key as usize == self.layer.calm.len() {
                self.layer.calm.push(!enabled.urgent);
            }
            self.observations.followed((&s, held), &enabled, &mut first, &mut followed);
            for &(action, mut held) in &followed {
                let mut next = self.spare.pop().unwrap_or_default();
                next.clone_from(&s);
                self.observations.step(&mut next, action, &mut held, at);
                stack.push((next, parent, held));
            }
            self.spare.push(s);
        }
        self.is_stopped();
        self.keep_calm(time, &links, by);
    }

    /// Turns the calm states of the layer into nodes, unless earlier nodes cover them.
    fn keep_calm(&mut self, time: u64, links: &Links, by: &mut dyn PollControl<'a>) {
        let layer = std::mem::take(&mut self.layer.states);
        self.layer.under_way = layer.memory() + links.memory();
        let redundant = self.redundant(&layer);
        self.layer.under_way += redundant.capacity() * TAG_BYTES;
        let mut encoding = Encoded::default();
        let mut s = State::default();
        for key in 0..layer.len() as u32 {
            if key % 64 == 63 && by.look(self) {
                break;
            }
            if !self.layer.calm[key as usize] {
                continue;
            }
            encoding.key.clear();
            encoding.key.extend(layer.key(key));
            for (dims, tag) in layer.covers(key) {
                if self.ends_now(dims) || redundant.contains(&tag) {
                    continue;
                }
                encoding.dims.clear();
                encoding.dims.extend(dims);
                let Some(node) = self.graph.keep(&encoding, time, links.list(tag)) else {
                    continue;
                };
                let Observations { rules, reductions, .. } = &self.observations;
                self.graph.state_to(rules.frame(), node, &mut s);
                if let Some(jump) = reductions.next_moment(rules, &s) {
                    self.graph.wait(node, time + u64::from(jump));
                } else {
                    let at = Sight { parent: node, time };
                    self.deadlock.get_or_insert(at);
                    self.waits_forever(&s, at);
                }
            }
        }
        self.layer.under_way = 0;
        self.layer.states = layer;
    }

    /// Returns true if time cannot pass in a box, because a window is at its end.
    fn ends_now(&self, dims: &[Ticks]) -> bool {
        let windows = dims.len() - self.observations.rules.frame().clocks();
        dims[..windows].chunks_exact(2).any(|w| w[1] == 0)
    }

    /// Returns the tags of calm states that others of the layer reach by postponed ends. The list is
    /// incomplete if there are very many, because finding them must not take longer than following them. It
    /// is empty if there is no memory for the search.
    fn redundant(&self, layer: &Store) -> FxHashSet<u32> {
        let Observations { rules, reductions, .. } = &self.observations;
        // States with the most executing codels reach the most other states.
        let mut sources: Vec<(usize, u32, &[Ticks], u32)> = Vec::new();
        let room = self.limits.bytes.saturating_sub(self.memory());
        if layer.count() > room / SOURCE_BYTES {
            return FxHashSet::default();
        }
        for key in (0..layer.len() as u32).filter(|&key| self.layer.calm[key as usize]) {
            let covers = layer.covers(key).filter(|(dims, _)| !self.ends_now(dims));
            sources.extend(covers.map(|(dims, tag)| (dims.len(), key, dims, tag)));
        }
        sources.sort_by_key(|source| std::cmp::Reverse(source.0));
        let mut out = FxHashSet::default();
        let mut budget = 1000 + CLOSURE_STATES_PER_STATE * layer.len();
        for (_, key, dims, tag) in sources {
            if budget == 0 || self.cancel.is_over() {
                break;
            }
            if out.contains(&tag) {
                continue;
            }
            let s = decode(rules.frame(), layer.key(key), dims);
            reductions.closure(rules, &s, &mut budget, |encoding| {
                for (other, other_tag) in layer.find(&encoding.key) {
                    if other_tag != tag && holds(rules.frame(), &encoding.dims, other) {
                        out.insert(other_tag);
                    }
                }
            });
        }
        out
    }

    // ---- Times that grow -------------------------------------------------------------------

    /// Handles a node after which no event follows: times measured there have no bound.
    fn waits_forever(&mut self, s: &State, at: Sight<NodeId>) {
        if self.diverging.is_some() {
            return;
        }
        let mut gauges = 0..self.observations.gauges.len();
        let gauge = gauges.find(|&gauge| self.observations.measures(gauge, s).is_some());
        if let Some(gauge) = gauge {
            self.limits_in_jump(s, at.parent, Ticks::MAX);
            self.diverging = Some(Divergence {
                gauge,
                proof: Some(self.trace(at, &Target::Deadlock)),
                excess: None,
            });
        }
    }

    /// Examines clocks after time has passed. If one has grown suspiciously, the run is searched for a
    /// repetition.
    fn clocks_after_jump(
        &mut self,
        s: &mut State,
        at: Sight<NodeId>,
        by: &mut dyn PollControl<'a>,
    ) -> Option<Divergence> {
        self.observations.waiting_after_jump(s, at);
        for gauge in 0..self.observations.gauges.len() {
            let Some(value) = self.observations.longest_after_jump(gauge, s, at) else {
                continue;
            };
            if value <= self.divergence_threshold || by.look(self) {
                continue;
            }
            self.divergence_threshold = self.divergence_threshold.saturating_mul(2);
            let Gauge { of, limit, .. } = self.observations.gauges[gauge];
            let run = self.trace(at, &Target::Lasts(of, value));
            let mut out = Divergence { gauge, proof: None, excess: None };
            let rules = &self.observations.rules;
            let recent = (&self.observations.observers, value);
            let age = |s: &State| of.age(rules, s);
            if let Some(cycle) = run.repetition(rules, recent, &age, self.cancel) {
                let left = limit.and_then(|limit| limit.checked_sub(value));
                out.excess = left.and_then(|left| run.prolonged(cycle, left + 1));
                out.proof = Some(run.repeating(cycle));
                return Some(out);
            }
            if !self.patient && !self.cancel.is_abandoned() {
                return Some(out);
            }
        }
        None
    }

    /// Records the limits that are exceeded in a jump from a node, and the times. The first moment counts,
    /// and jumps overlap.
    fn limits_in_jump(&mut self, s: &State, parent: NodeId, jump: Ticks) {
        let observations = &mut self.observations;
        for i in 0..observations.gauges.len() {
            let (Some(limit), Some(clock)) =
                (observations.gauges[i].limit, observations.measures(i, s))
            else {
                continue;
            };
            // Clocks beyond the limit were recorded when they passed the limit.
            let Some(left) = limit.checked_sub(s.t[clock]).filter(|&left| left < jump) else {
                continue;
            };
            let time = self.graph[parent].time + u64::from(left) + 1;
            if observations.seen.excess[i].is_none_or(|excess| time < excess.time) {
                observations.seen.excess[i] = Some(Sight { parent, time });
            }
        }
    }

    /// Records the limits that are exceeded in jumps under way at the end of the exploration.
    fn limits_under_way(&mut self) {
        if self.observations.gauges.iter().all(|gauge| gauge.limit.is_none()) {
            return;
        }
        for (time, parents) in self.graph.take_queue() {
            for (i, parent) in parents.into_iter().enumerate() {
                if i % STATES_PER_POLL == 0 && self.cancel.is_abandoned() {
                    return;
                }
                let s = self.graph.state(self.observations.rules.frame(), parent);
                let jump = self.graph.since(Sight { parent, time });
                self.limits_in_jump(&s, parent, jump);
            }
        }
    }

    /// Returns a run in which a gauge has just exceeded its limit.
    pub(super) fn excess_run(&self, gauge: usize) -> Option<Run> {
        let Gauge { of, limit, .. } = self.observations.gauges[gauge];
        let at = self.observations.seen.excess[gauge]?;
        Some(self.trace(at, &Target::Lasts(of, limit? + 1)))
    }
}
