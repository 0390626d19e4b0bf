//! One moment: following all simultaneous actions, and keeping the calm states they lead to.

use rustc_hash::FxHashSet;

use super::{Node, Search, Sight};
use crate::explore::observe;
use crate::explore::reductions::{Held, Kind, Reduced, Reductions};
use crate::explore::rules::{Action, Enabled};
use crate::explore::state::State;
use crate::explore::store::{Encoded, Store, decode, decode_to, encode, holds};
use crate::system::Ticks;

/// States looked at per state of a layer to find those that are reached by ends that can wait.
const CLOSURES: usize = 1;

impl<R: Reduced> Search<'_, R> {
    /// Follows all simultaneous actions from states at one moment, then keeps the calm ones.
    pub(super) fn close_layer(&mut self, time: u64, states: Vec<(State, u32)>, initial: bool) {
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
                observe::observe(&self.rules, &self.observers, None, s);
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
            let at = Sight { parent, time };
            self.settle(&mut s, &mut held, &mut enabled, |_| at);
            encode(self.rules.frame(), &s, &mut it);
            if held != 0 {
                it.key.extend(held.to_le_bytes());
            }
            if self.crowd.holds(&it) {
                self.spare.push(s);
                continue;
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
            self.followed((&s, held), &enabled, &mut first, &mut followed);
            for &(action, mut held) in &followed {
                let mut next = self.spare.pop().unwrap_or_default();
                next.clone_from(&s);
                self.step(&mut next, action, &mut held, at);
                stack.push((next, parent, held));
            }
            self.spare.push(s);
        }
        self.keep_calm(time, &links);
        self.keep_crowd();
    }

    /// Where very much happens at each moment, most of it happens again at later ones: whatever states of
    /// this one lead to is known then.
    fn keep_crowd(&mut self) {
        if !self.is_crowded() || self.limits.without.contains(Kind::MomentCovering) {
            return;
        }
        let layer = std::mem::take(&mut self.layer);
        let mut it = Encoded::default();
        for key in 0..layer.len() as u32 {
            if key % 64 == 63 && self.out_of_bounds() {
                break;
            }
            it.key.clear();
            it.key.extend(layer.key(key));
            for (dims, _) in layer.covers(key) {
                it.dims.clear();
                it.dims.extend(dims);
                self.crowd.insert(&it, 0, |_, _| 0);
            }
        }
        self.layer = layer;
    }

    /// Performs committed steps without a choice, which need not be kept, and puts the state in order. `at`
    /// tells where a step leads to. Whether the state was not in order.
    pub(super) fn settle(
        &mut self,
        s: &mut State,
        held: &mut Held,
        enabled: &mut Enabled,
        mut at: impl FnMut(Action) -> Sight,
    ) -> bool {
        self.rules.enabled(s, enabled);
        // The bound is there because a client may go round in circles without taking time.
        for _ in 0..16 {
            if !enabled.committed || enabled.actions.len() != 1 {
                break;
            }
            let action = enabled.actions[0];
            self.step(s, action, held, at(action));
            self.rules.enabled(s, enabled);
        }
        let ordered = *held == 0 && self.reductions.order(&self.rules, s).is_some();
        if ordered {
            self.rules.enabled(s, enabled);
        }
        ordered
    }

    /// Writes the actions to follow in a state, with what they hold back.
    pub(super) fn followed(
        &self,
        (s, held): (&State, Held),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, Held)>,
    ) {
        let at = (s, held);
        self.reductions.follow(&self.rules, at, enabled, first, out);
    }

    /// Performs an action, and looks at the state it leads to.
    pub(super) fn step(&mut self, s: &mut State, action: Action, held: &mut Held, at: Sight) {
        let needs_before = !self.observers.is_empty() || !self.watch.reach.is_empty() || *held != 0;
        let before = needs_before.then(|| s.clone());
        self.rules.apply(s, action);
        if let Some(before) = &before {
            observe::observe(&self.rules, &self.observers, Some(before), s);
            *held = (self.reductions).held_after(&self.rules, before, action, s, *held);
        }
        if let Action::Grant { task } = action
            && self.waiting_only[task]
            && let Some(clock) = self.rules.frame().response[task]
        {
            s.t[clock] = 0;
        }
        self.overdue_at_once(s, action, at);
        self.check(before.as_ref(), s, at);
    }

    /// Turns the calm states of the layer that are not passed yet into nodes.
    pub(super) fn keep_calm(&mut self, time: u64, links: &[(u32, u32)]) {
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
                decode_to(self.rules.frame(), &it.key, dims, &mut s);
                match self.reductions.next_moment(&self.rules, &s) {
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
    pub(super) fn ends_now(&self, dims: &[Ticks]) -> bool {
        let windows = dims.len() - self.rules.frame().clocks();
        dims[..windows].chunks_exact(2).any(|w| w[1] == 0)
    }

    /// Tags of calm states that others of the layer reach by ends that can wait. Not all of them if there are
    /// very many: finding them must not take longer than following them.
    pub(super) fn redundant(&self, layer: &Store) -> FxHashSet<u32> {
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
            let s = decode(self.rules.frame(), layer.key(key), dims);
            self.reductions.closure(&self.rules, &s, &mut budget, |it| {
                for (other, other_tag) in layer.find(&it.key) {
                    if other_tag != tag && holds(self.rules.frame(), &it.dims, other) {
                        out.insert(other_tag);
                    }
                }
            });
        }
        out
    }
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
