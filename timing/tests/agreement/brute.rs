//! An independent interpreter of timed systems, written from the semantics by the obvious method: states are
//! plain structures with a clock per executing codel, time passes unit by unit, every order of simultaneous
//! actions is followed, and no states are merged.

pub(crate) mod chains;
mod control_task;
mod perform;
mod possible;
mod predicates;
mod state;
mod time;

use std::collections::HashSet;

use dotgen_timing::explore::{Action, Within};
use dotgen_timing::property::Predicate;
use dotgen_timing::system::{TaskId, TimedSystem};

use state::{State, Status};

/// Age above which a time counts as unbounded.
pub(crate) const CAP: u32 = 150;

pub(crate) struct Brute<'s> {
    pub(crate) system: &'s TimedSystem,
    pub(crate) within: &'s [Within],
    pub(crate) reach: &'s [Predicate],
}

#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Results {
    pub(crate) missed: Vec<bool>,
    pub(crate) overdue: Vec<bool>,
    /// `Some(CAP)`: unbounded.
    pub(crate) response: Vec<Option<u32>>,
    pub(crate) within: Vec<Option<u32>>,
    pub(crate) reached: Vec<bool>,
    /// Earliest time at which each response time, and each obligation, has reached each age.
    pub(crate) response_at: Vec<Vec<u64>>,
    pub(crate) within_at: Vec<Vec<u64>>,
    pub(crate) deadlock: bool,
    pub(crate) refused: Vec<bool>,
    pub(crate) states: usize,
}

impl Brute<'_> {
    fn inspect(&self, s: &State, now: u64, out: &mut Results) {
        let reach = |ages: &mut Vec<u64>, age: u32| {
            ages.resize(ages.len().max(age as usize + 1), now);
        };
        for (t, task) in s.tasks.iter().enumerate() {
            if task.status == Status::Idle {
                continue;
            }
            out.missed[t] |= task.tick;
            if let Some(period) = self.system.tasks[TaskId::from(t)].period {
                out.overdue[t] |= task.status == Status::Waiting && task.age >= period;
            }
            out.response[t] = out.response[t].max(Some(task.age));
            reach(&mut out.response_at[t], task.age);
        }
        for (i, obligation) in s.obligations.iter().enumerate() {
            for &(_, age) in obligation {
                out.within[i] = out.within[i].max(Some(age));
                reach(&mut out.within_at[i], age);
            }
        }
    }

    fn reach(&self, before: Option<&State>, now: &State, at: u64, out: &mut Results) {
        for (predicate, reached) in self.reach.iter().zip(&mut out.reached) {
            *reached |= self.predicate(before, now, predicate);
        }
        // An obligation that is met at once takes no time, which is a measured time.
        for (i, bound) in self.within.iter().enumerate() {
            let was =
                before.is_some_and(|it_was| self.predicate(Some(it_was), it_was, &bound.trigger));
            if !was && self.predicate(before, now, &bound.trigger) {
                out.within[i] = out.within[i].max(Some(0));
                if out.within_at[i].is_empty() {
                    out.within_at[i].push(at);
                }
            }
        }
    }

    fn blank(&self) -> Results {
        let n = self.system.tasks.len();
        Results {
            missed: vec![false; n],
            overdue: vec![false; n],
            response: vec![None; n],
            within: vec![None; self.within.len()],
            reached: vec![false; self.reach.len()],
            response_at: vec![Vec::new(); n],
            within_at: vec![Vec::new(); self.within.len()],
            deadlock: false,
            refused: vec![false; self.system.services.len()],
            states: 0,
        }
    }

    /// Returns all results, or `None` above `limit` states.
    pub(crate) fn explore(&self, limit: usize) -> Option<Results> {
        let mut out = self.blank();
        let initial = self.initial();
        self.reach(None, &initial, 0, &mut out);
        // Moment by moment, so that a state is seen at the earliest possible moment.
        let mut seen: HashSet<State> = HashSet::new();
        let mut later = vec![initial];
        let mut now = 0;
        while !later.is_empty() {
            let mut todo = std::mem::take(&mut later);
            todo.retain(|state| seen.insert(state.clone()));
            while let Some(s) = todo.pop() {
                if seen.len() > limit {
                    return None;
                }
                self.inspect(&s, now, &mut out);
                let (actions, urgent) = self.actions(&s);
                for action in actions {
                    let next = self.perform(&s, action, &mut out);
                    self.reach(Some(&s), &next, now, &mut out);
                    if seen.insert(next.clone()) {
                        todo.push(next);
                    }
                }
                if !urgent {
                    out.deadlock |= self.dead(&s);
                    later.push(self.pass(&s));
                }
            }
            now += 1;
        }
        out.states = seen.len();
        Some(out)
    }

    /// Plays a run, and returns the observations in its last state. Fails at an action that is not possible.
    pub(crate) fn replay(&self, steps: &[(u64, Action)], end: u64) -> Result<Results, String> {
        let mut out = self.blank();
        let mut last = (None, self.initial());
        self.play(steps, end, &mut out, &mut |before, now, _| {
            // Time that passes enters no state.
            let before = before.cloned().or(last.0.take());
            last = (before, now.clone());
        })?;
        let (before, s) = last;
        let mut out = self.blank();
        self.inspect(&s, end, &mut out);
        self.reach(before.as_ref(), &s, end, &mut out);
        out.deadlock = self.dead(&s);
        Ok(out)
    }

    /// Plays a run, and returns the observations in any of its states. Fails at an action that is not
    /// possible.
    pub(crate) fn along(&self, steps: &[(u64, Action)], end: u64) -> Result<Results, String> {
        let mut out = self.blank();
        let mut refused = self.blank();
        let initial = self.initial();
        self.reach(None, &initial, 0, &mut out);
        self.inspect(&initial, 0, &mut out);
        self.play(steps, end, &mut refused, &mut |before, now, at| {
            if before.is_some() {
                self.reach(before, now, at, &mut out);
            }
            self.inspect(now, at, &mut out);
        })?;
        out.refused = refused.refused;
        Ok(out)
    }

    /// Visits every state of a run except the first: with the previous state if an action led to it, and with
    /// its time.
    fn play(
        &self,
        steps: &[(u64, Action)],
        end: u64,
        out: &mut Results,
        look: &mut dyn FnMut(Option<&State>, &State, u64),
    ) -> Result<(), String> {
        let mut s = self.initial();
        let mut now = 0;
        let steps = steps.iter().map(|&(time, action)| (time, Some(action)));
        for (time, action) in steps.chain([(end, None)]) {
            while now < time {
                if self.actions(&s).1 {
                    return Err(format!("time may not pass at {now}"));
                }
                s = self.pass(&s);
                now += 1;
                look(None, &s, now);
            }
            let Some(action) = action else { break };
            if !self.actions(&s).0.contains(&action) {
                return Err(format!("{action:?} is not possible at {now}"));
            }
            let next = self.perform(&s, action, out);
            look(Some(&s), &next, now);
            s = next;
        }
        Ok(())
    }
}
