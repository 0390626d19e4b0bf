//! Runs to what was seen: found again, backwards from node to node.

use std::cell::RefCell;

use rustc_hash::FxHashMap;

use super::{LOOKS, ROOT, Search, Sight};
use crate::explore::measure::Timing;
use crate::explore::observe;
use crate::explore::reductions::{Reduced, Reductions, Renaming};
use crate::explore::rules::{Action, Enabled};
use crate::explore::run::Run;
use crate::explore::state::{State, TaskStatus};
use crate::explore::store::{Encoded, encode, holds};
use crate::property::Predicate;
use crate::system::Ticks;

/// What a state that was sighted looks like.
pub(super) enum Goal<'g> {
    Missed(usize),
    Overdue(usize),
    Reach(&'g Predicate),
    Lasts(Timing, Ticks),
    Calm(&'g [u8], &'g [Ticks]),
    Deadlock,
}

/// Runs by what was seen and where: what was told once is not looked for again, and does not change.
pub(super) type Traced = RefCell<FxHashMap<(Kind, u32, u64), Run>>;

/// What can be told before the end.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Missed(usize),
    Overdue(usize),
    /// By its place in memory.
    Reached(usize),
}

/// How a state is like the goal.
#[derive(Default)]
struct Hit {
    /// The task of which it is true, of those that are not told apart.
    task: Option<usize>,
    /// How it was put in order.
    order: Option<Renaming>,
}

/// Remaining time of each executing executor at some point of a run.
type Point = Vec<Option<Ticks>>;

impl<R: Reduced> Search<'_, R> {
    /// A run to what was seen, without steps if it is too late for that: segments from node to node, found
    /// backwards with the remaining times that the later part of the run needs.
    pub(super) fn trace(&self, at: Sight, goal: &Goal) -> Run {
        let Some(kind) = goal.kind() else {
            return self.traced_back(at, goal);
        };
        let key = (kind, at.parent, at.time);
        let before = self.traced.borrow().get(&key).cloned();
        before.unwrap_or_else(|| {
            let run = self.traced_back(at, goal);
            self.traced.borrow_mut().insert(key, run.clone());
            run
        })
    }

    fn traced_back(&self, at: Sight, goal: &Goal) -> Run {
        let left_out = || Run {
            end: at.time,
            left_out: true,
            ..Run::default()
        };
        let mut segments: Vec<(u64, Vec<Action>)> = Vec::new();
        let mut node = at.parent;
        let mut task = None;
        let mut point = if matches!(goal, Goal::Deadlock) {
            self.any_point(&self.node_state(node))
        } else {
            let Some((actions, last, hit)) = self.segment(node, at.time, goal) else {
                return left_out();
            };
            task = hit.task;
            segments.push((at.time, actions));
            self.any_point(&last)
        };
        while node != ROOT {
            if let Some(segment) = segments.last() {
                point = self.point_before(node, segment, &point);
            }
            // A part of a run would be of no use.
            let Some((parent, actions, order)) = self.segment_to(node, &point) else {
                return left_out();
            };
            if let Some(back) = order.map(|it| it.inverse()) {
                for (_, later) in &mut segments {
                    later.iter_mut().for_each(|it| *it = back.action(*it));
                }
                task = task.map(|it| back.task(it));
                let after = std::mem::take(&mut point);
                point = vec![None; after.len()];
                for (e, remaining) in after.into_iter().enumerate() {
                    point[back.executor(e)] = remaining;
                }
            }
            segments.push((self.nodes[node as usize].time, actions));
            node = parent;
        }
        let mut run = Run::default();
        for (time, actions) in segments.into_iter().rev() {
            run.extend(time, actions);
        }
        run.end = at.time;
        match (task, goal.task()) {
            (Some(from), Some(to)) if from != to => self.exchanged(&run, from, to),
            _ => run,
        }
    }

    fn any_point(&self, s: &State) -> Point {
        (0..self.rules.frame().executors())
            .map(|e| {
                let executing = self.rules.frame().is_executing(s, e);
                let (a, b) = self.rules.frame().window(s, e);
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
        (0..self.rules.frame().executors())
            .map(|e| {
                if !self.rules.frame().is_executing(&s, e) {
                    return None;
                }
                let ended = actions
                    .iter()
                    .any(|it| matches!(it, Action::Finish { executor, .. } if *executor == e));
                // What has no core stays as it is.
                let progress = if self.rules.gets_on(&s, e) { jump } else { 0 };
                Some(if ended {
                    progress
                } else {
                    progress + after[e].unwrap_or(0)
                })
            })
            .collect()
    }

    /// A way from one of the parents of a node to the given point of it, and how the state there is put in
    /// order.
    fn segment_to(&self, node: u32, point: &Point) -> Option<(u32, Vec<Action>, Option<Renaming>)> {
        let record = &self.nodes[node as usize];
        let mut s = self.node_state(node);
        for (e, remaining) in point.iter().enumerate() {
            if let Some(remaining) = *remaining {
                self.rules
                    .frame()
                    .set_window(&mut s, e, (remaining, remaining));
            }
        }
        let mut wanted = Encoded::default();
        encode(self.rules.frame(), &s, &mut wanted);
        let mut edge = record.edges;
        while let Some(&(parent, next)) = self.edges.get(edge as usize) {
            let goal = Goal::Calm(&wanted.key, &wanted.dims);
            if let Some((actions, _, hit)) = self.segment(parent, record.time, &goal) {
                return Some((parent, actions, hit.order));
            }
            edge = next;
        }
        None
    }

    /// Actions at one moment after the jump of a node, up to a state like the goal.
    fn segment(&self, parent: u32, time: u64, goal: &Goal) -> Option<(Vec<Action>, State, Hit)> {
        let mut start = if parent == ROOT {
            let mut s = self.rules.initial();
            observe::observe(&self.rules, &self.observers, None, &mut s);
            s
        } else {
            let mut s = self.node_state(parent);
            self.rules
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
        let mut ordered = State::default();
        let mut at = 0;
        while at < found.len() {
            if at % LOOKS == 0 && self.cancel.is_too_late() {
                return None;
            }
            let s = found[at].0.clone();
            let before = found.get(found[at].1).map(|it| it.0.clone());
            self.rules.enabled(&s, &mut enabled);
            if let Some(hit) = self.is_goal(before.as_ref(), &s, &enabled, goal) {
                let mut actions = Vec::new();
                let mut back = at;
                while let Some(action) = found[back].2 {
                    actions.push(action);
                    back = found[back].1;
                }
                actions.reverse();
                return Some((actions, s, hit));
            }
            self.reductions
                .persistent(&self.rules, &s, &enabled, &mut followed);
            for &action in &followed {
                let mut next = s.clone();
                self.rules.apply(&mut next, action);
                observe::observe(&self.rules, &self.observers, Some(&s), &mut next);
                if let Action::Grant { task } = action
                    && self.waiting_only[task]
                    && let Some(clock) = self.rules.frame().response[task]
                {
                    next.t[clock] = 0;
                }
                ordered.clone_from(&next);
                self.reductions.order(&self.rules, &mut ordered);
                encode(self.rules.frame(), &ordered, &mut it);
                // What is left, or answered at once, is seen in a step, not in the state it leads to.
                let by_step = matches!(goal, Goal::Reach(_) | Goal::Lasts(Timing::Within(_), 0))
                    && self.is_goal(Some(&s), &next, &enabled, goal).is_some();
                if seen.insert((it.clone(), by_step)) {
                    found.push((next, at, Some(action)));
                }
            }
            at += 1;
        }
        None
    }

    fn clamp_waiting(&self, s: &mut State) {
        let l = self.rules.frame();
        for (task, only) in self.waiting_only.iter().enumerate() {
            if *only && let Some(clock) = l.response[task] {
                let running = self.rules.job(s, task) == TaskStatus::Running;
                let most = self.rules.system().tasks[task].period.unwrap_or(0);
                s.t[clock] = if running { 0 } else { s.t[clock].min(most) };
            }
        }
    }

    fn is_goal(
        &self,
        before: Option<&State>,
        s: &State,
        enabled: &Enabled,
        goal: &Goal,
    ) -> Option<Hit> {
        let l = self.rules.frame();
        let some_task = |task: usize, found: &dyn Fn(usize) -> bool| {
            let mut orbit = self.reductions.orbits().of_task(task).iter().copied();
            let task = orbit.find(|&it| found(it));
            task.map(|it| Hit {
                task: Some(it),
                order: None,
            })
        };
        let lasts = |of: Timing, value| {
            of.runs(&self.rules, s) && of.clock(l, s).is_none_or(|clock| s.t[clock] >= value)
        };
        match *goal {
            Goal::Missed(task) => some_task(task, &|it| self.rules.missed(s, it)),
            Goal::Overdue(task) => some_task(task, &|it| self.rules.overdue(s, it)),
            Goal::Reach(it) => observe::predicate(&self.rules, before, s, it).then(Hit::default),
            Goal::Lasts(Timing::Response(task), value) => {
                some_task(task, &|it| lasts(Timing::Response(it), value))
            }
            Goal::Lasts(of, value) => (lasts(of, value)
                || value == 0 && self.is_answered_at_once(before, s, of))
            .then(Hit::default),
            Goal::Calm(key, dims) => {
                if enabled.committed || enabled.urgent {
                    return None;
                }
                let mut s = s.clone();
                let order = self.reductions.order(&self.rules, &mut s);
                let mut it = Encoded::default();
                encode(self.rules.frame(), &s, &mut it);
                let same = it.key == key && holds(l, &it.dims, dims);
                same.then_some(Hit { task: None, order })
            }
            Goal::Deadlock => None,
        }
    }
}

impl Goal<'_> {
    fn kind(&self) -> Option<Kind> {
        match *self {
            Goal::Missed(task) => Some(Kind::Missed(task)),
            Goal::Overdue(task) => Some(Kind::Overdue(task)),
            Goal::Reach(predicate) => Some(Kind::Reached(std::ptr::from_ref(predicate).addr())),
            _ => None,
        }
    }

    /// The task it is about.
    fn task(&self) -> Option<usize> {
        match *self {
            Goal::Missed(task) | Goal::Overdue(task) | Goal::Lasts(Timing::Response(task), _) => {
                Some(task)
            }
            _ => None,
        }
    }
}
