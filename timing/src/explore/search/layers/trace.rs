//! The reconstruction of runs, backwards from node to node.

use std::cell::RefCell;

use rustc_hash::FxHashMap;

use super::{Layers, STATES_PER_POLL};
use crate::explore::measure::Timing;
use crate::explore::observe;
use crate::explore::rules::{Action, Enabled};
use crate::explore::run::Run;
use crate::explore::search::goals::{Goal, GoalId};
use crate::explore::search::graph::NodeId;
use crate::explore::search::observations::Sight;
use crate::explore::state::State;
use crate::explore::store::{Encoded, encode, holds};
use crate::system::Ticks;

/// The description of a state that was seen.
pub(in crate::explore::search) enum Target<'g> {
    Goal(Goal<'g>),
    Lasts(Timing, Ticks),
    Calm(&'g [u8], &'g [Ticks]),
    Deadlock,
}

/// Reconstructed runs, by goal and place. A run that was reported is not reconstructed again, and does not
/// change.
pub(in crate::explore::search) type ReconstructedRuns =
    RefCell<FxHashMap<(GoalId, NodeId, u64), Run>>;

/// The remaining times of all executing executors at a point of a run, in base units.
type Point = Vec<Option<Ticks>>;

impl Layers<'_> {
    /// Returns the run to a goal, if the goal was reached.
    pub(in crate::explore::search) fn run_to(&self, goal: GoalId) -> Option<Run> {
        let at = self.observations.seen.goals[goal]?;
        let key = (goal, at.parent, at.time);
        let before = self.traced.borrow().get(&key).cloned();
        Some(before.unwrap_or_else(|| {
            let run = self.trace(at, &Target::Goal(self.observations.goals.get(goal)));
            self.traced.borrow_mut().insert(key, run.clone());
            run
        }))
    }

    /// Returns a run to a sight. The run has no steps if there is no time or memory to find them. Its
    /// segments lead from node to node, and are found backwards, with the remaining times that the later part
    /// of the run needs.
    pub(in crate::explore::search) fn trace(&self, at: Sight<NodeId>, goal: &Target) -> Run {
        let left_out = || Run { end: at.time, left_out: true, ..Run::default() };
        let mut segments: Vec<(u64, Vec<Action>)> = Vec::new();
        let mut node = at.parent;
        let mut point = if matches!(goal, Target::Deadlock) {
            self.any_point(&self.state_of(node))
        } else {
            let Some((actions, last)) = self.segment(node, at.time, goal) else {
                return left_out();
            };
            segments.push((at.time, actions));
            self.any_point(&last)
        };
        while node != NodeId::ROOT {
            if let Some(segment) = segments.last() {
                point = self.point_before(node, segment, &point);
            }
            // A part of a run is useless.
            let Some((parent, actions)) = self.segment_to(node, &point) else {
                return left_out();
            };
            segments.push((self.graph[node].time, actions));
            node = parent;
        }
        let mut run = Run::default();
        for (time, actions) in segments.into_iter().rev() {
            run.extend(time, actions);
        }
        run.end = at.time;
        run
    }

    fn state_of(&self, node: NodeId) -> State {
        self.graph.state(self.observations.rules.frame(), node)
    }

    fn any_point(&self, s: &State) -> Point {
        (0..self.observations.rules.frame().executors())
            .map(|e| {
                let executing = self.observations.rules.frame().is_executing(s, e);
                let (a, b) = self.observations.rules.frame().window(s, e);
                // Any end within the window is possible. The latest end is chosen, or the earliest if there
                // is no upper bound.
                executing.then_some(if b == crate::system::FOREVER { a } else { b })
            })
            .collect()
    }

    /// Returns the remaining times in a node, given those at the end of a segment that starts there.
    fn point_before(
        &self,
        node: NodeId,
        (time, actions): &(u64, Vec<Action>),
        after: &Point,
    ) -> Point {
        let s = self.state_of(node);
        let jump = (time - self.graph[node].time) as Ticks;
        (0..self.observations.rules.frame().executors())
            .map(|e| {
                if !self.observations.rules.frame().is_executing(&s, e) {
                    return None;
                }
                let ended = actions.iter().any(
                    |action| matches!(action, Action::Finish { executor, .. } if *executor == e),
                );
                // The remaining time of an executor without a core does not change.
                let progress = if self.observations.rules.progresses(&s, e) { jump } else { 0 };
                Some(if ended { progress } else { progress + after[e].unwrap_or(0) })
            })
            .collect()
    }

    /// Returns a segment from one of the parents of a node to the given point of the node.
    fn segment_to(&self, node: NodeId, point: &Point) -> Option<(NodeId, Vec<Action>)> {
        let time = self.graph[node].time;
        let mut s = self.state_of(node);
        for (e, remaining) in point.iter().enumerate() {
            if let Some(remaining) = *remaining {
                self.observations.rules.frame().set_window(&mut s, e, (remaining, remaining));
            }
        }
        let mut wanted = Encoded::default();
        encode(self.observations.rules.frame(), &s, &mut wanted);
        let goal = Target::Calm(&wanted.key, &wanted.dims);
        self.graph
            .parents(node)
            .find_map(|parent| Some((parent, self.segment(parent, time, &goal)?.0)))
    }

    /// Returns the actions at one moment after the jump of a node, up to a state that matches the target.
    fn segment(&self, parent: NodeId, time: u64, goal: &Target) -> Option<(Vec<Action>, State)> {
        let mut start = if parent == NodeId::ROOT {
            self.observations.initial()
        } else {
            let mut s = self.state_of(parent);
            self.observations.rules.elapse(&mut s, (time - self.graph[parent].time) as Ticks);
            s
        };
        self.observations.clamp_waiting(&mut start);
        let mut seen = rustc_hash::FxHashSet::default();
        // Breadth-first search, for short runs: (state, predecessor, action).
        let mut found: Vec<(State, usize, Option<Action>)> = vec![(start, usize::MAX, None)];
        let mut enabled = Enabled::default();
        let mut followed = Vec::new();
        let mut encoding = Encoded::default();
        // In states: as elements of the list, and as keys of the set.
        let room = self.room_for_run() / self.bytes_of_found();
        let mut at = 0;
        while at < found.len() {
            // A list that grows exists twice meanwhile, and so does a set.
            let full = found.len() * 2 > room;
            if full || at % STATES_PER_POLL == 0 && self.cancel.is_too_late() {
                return None;
            }
            let s = found[at].0.clone();
            let before = found.get(found[at].1).map(|(before, ..)| before.clone());
            self.observations.rules.enabled(&s, &mut enabled);
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
            self.observations.reductions.persistent(
                &self.observations.rules,
                &s,
                &enabled,
                &mut followed,
            );
            for &action in &followed {
                let mut next = s.clone();
                self.observations.rules.apply(&mut next, action);
                observe::observe(
                    &self.observations.rules,
                    &self.observations.observers,
                    Some(&s),
                    &mut next,
                );
                self.observations.begin_waiting(&mut next, action);
                encode(self.observations.rules.frame(), &next, &mut encoding);
                // Such a target is seen in a step, not in the state after the step.
                let by_step = matches!(
                    goal,
                    Target::Goal(Goal::Reached(_)) | Target::Lasts(Timing::Within(_), 0)
                ) && self.is_goal(Some(&s), &next, &enabled, goal);
                if seen.insert((encoding.clone(), by_step)) {
                    found.push((next, at, Some(action)));
                }
            }
            at += 1;
        }
        None
    }

    /// Returns the bytes of a state during the reconstruction, in the list and in the set.
    fn bytes_of_found(&self) -> usize {
        let list = size_of::<(usize, Option<Action>)>();
        let set = size_of::<(Encoded, bool)>() + size_of::<usize>();
        list + set + 2 * self.observations.rules.frame().state_bytes()
    }

    fn is_goal(&self, before: Option<&State>, s: &State, enabled: &Enabled, goal: &Target) -> bool {
        let l = self.observations.rules.frame();
        let lasts = |of: Timing, value| {
            of.runs(&self.observations.rules, s)
                && of.clock(l, s).is_none_or(|clock| s.t[clock] >= value)
        };
        match *goal {
            Target::Goal(Goal::Missed(task)) => self.observations.rules.missed(s, task),
            Target::Goal(Goal::Overdue(task)) => self.observations.rules.overdue(s, task),
            Target::Goal(Goal::Reached(predicate)) => {
                observe::predicate(&self.observations.rules, before, s, predicate)
            }
            Target::Lasts(of, value) => {
                lasts(of, value)
                    || value == 0 && self.observations.is_answered_at_once(before, s, of)
            }
            Target::Calm(key, dims) => {
                if enabled.committed || enabled.urgent {
                    return false;
                }
                let mut encoding = Encoded::default();
                encode(l, s, &mut encoding);
                encoding.key == key && holds(l, &encoding.dims, dims)
            }
            Target::Deadlock => false,
        }
    }
}
