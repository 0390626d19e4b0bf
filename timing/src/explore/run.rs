//! Runs: sequences of actions with their times.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::observe::{self, Observers};
use super::rules::Moment;
use super::rules::{Action, Enabled, Rules};
use super::state::State;
use crate::cancel::Cancel;
use crate::system::{FOREVER, Ticks, TimedSystem};

/// Upper limit on the steps of a prolonged run.
const MAX_STEPS_OF_REPETITION: usize = 10_000;

/// A run from time 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Run {
    /// Actions, with their times in base units, in order.
    pub steps: Vec<(u64, Action)>,
    /// End of the run in base units; later than the last action if the passage of time is the point.
    pub end: u64,
    /// Step from which the run repeats itself for ever.
    pub cycle: Option<usize>,
    /// The run exists, but there was no time to find its steps.
    pub left_out: bool,
}

/// A run, and the system that it is a run of: the components that were explored together.
#[derive(Debug, Clone)]
pub struct SystemRun {
    pub(crate) system: Arc<TimedSystem>,
    pub(crate) run: Run,
}

impl Run {
    pub(crate) fn extend(&mut self, time: u64, actions: Vec<Action>) {
        self.steps.extend(actions.into_iter().map(|action| (time, action)));
        self.end = time;
    }

    /// Returns two moments within the last `recent` units of the run with the same state just before time
    /// passes, except for observation clocks: the part between them can be repeated for ever. `age` returns
    /// the age of the measured obligation in a state, the number of obligations of that age, and if a
    /// measured job has its core. An obligation of the same age may take its place, but not for ever.
    pub(in crate::explore) fn repetition(
        &self,
        rules: &Rules,
        (observers, recent): (&Observers, Ticks),
        age: &dyn Fn(&State) -> (Ticks, usize, bool),
        cancel: &Cancel,
    ) -> Option<(u64, u64)> {
        let from = self.end.checked_sub(u64::from(recent))?;
        let mut seen = FxHashMap::default();
        let mut found = None;
        let (mut measured, mut executed) = (0, false);
        self.replay(rules, observers, |time, s, began| {
            if time < from {
                return !(time.is_multiple_of(64) && cancel.is_abandoned());
            }
            // The measurement may begin before the measured job, with a tick that is kept until the previous
            // job has ended. A repetition across that end does not last.
            let (now, as_old, has_core) = age(s);
            let ended = executed && !has_core;
            if now < std::mem::replace(&mut measured, now) || ended {
                seen.clear();
            }
            executed = has_core;
            // Elapsed instead of remaining times.
            let elapsed: Vec<u64> = (0..rules.frame().executors())
                .map(|e| {
                    if !rules.frame().is_executing(s, e) {
                        return 0;
                    }
                    let (lower, upper) = rules.duration(s, e);
                    let elapsed = time - began[e];
                    // Without an upper bound, the codel can end at any time after its lower bound. Longer
                    // times make no difference.
                    if upper == FOREVER { elapsed.min(u64::from(lower)) } else { elapsed }
                })
                .collect();
            let times = rules.frame().key_times(s).to_vec();
            let key = (s.d.clone(), times, elapsed, as_old);
            found = seen.insert(key, time).map(|before| (before, time));
            found.is_none() && !(time.is_multiple_of(64) && cancel.is_abandoned())
        });
        found
    }

    /// Returns the run up to the second of two moments, repeating for ever from the first moment on.
    pub(crate) fn repeating(&self, (from, to): (u64, u64)) -> Run {
        let steps = self.steps.iter().copied();
        let steps: Vec<_> = steps.take_while(|step| step.0 <= to).collect();
        Run { cycle: steps.iter().position(|step| step.0 > from), steps, end: to, left_out: false }
    }

    /// Returns the run with the part between two moments repeated until the run is longer by `more`; `None`
    /// if that takes too many steps to be readable.
    pub(crate) fn prolonged(&self, (from, to): (u64, u64), more: Ticks) -> Option<Run> {
        let end = self.end + u64::from(more);
        let within = |a: u64, b: u64| {
            let steps = self.steps.iter().copied();
            steps.filter(move |step| a < step.0 && step.0 <= b)
        };
        let mut run = Run {
            steps: self.steps.iter().copied().filter(|step| step.0 <= to).collect(),
            end,
            cycle: None,
            left_out: false,
        };
        let rounds = (end - to).div_ceil(to - from);
        for round in 1..=rounds {
            let shift = round * (to - from);
            let again = within(from, to).map(|(time, action)| (time + shift, action));
            run.steps.extend(again.filter(|(time, _)| *time < end));
            if run.steps.len() > MAX_STEPS_OF_REPETITION {
                return None;
            }
        }
        Some(run)
    }

    /// Calls `calm` before every unit of time that passes, with the state, the time, and the start times of
    /// executors. Ends when `calm` returns false.
    fn replay(
        &self,
        rules: &Rules,
        observers: &Observers,
        mut calm: impl FnMut(u64, &State, &[u64]) -> bool,
    ) {
        let mut s = rules.initial();
        observe::observe(rules, observers, None, &mut s);
        let mut now = 0;
        let mut began = vec![0; rules.frame().executors()];
        for &(time, action) in &self.steps {
            while now < time {
                if !calm(now, &s, &began) {
                    return;
                }
                advance(rules, &mut s, 1);
                now += 1;
            }
            let before = s.clone();
            rules.apply(&mut s, action);
            observe::observe(rules, observers, Some(&before), &mut s);
            for (e, began) in began.iter_mut().enumerate() {
                if began_in_step(rules, &before, &s, action, e) {
                    *began = now;
                }
            }
        }
        while now < self.end {
            if !calm(now, &s, &began) {
                return;
            }
            advance(rules, &mut s, 1);
            now += 1;
        }
    }

    /// Returns the first step whose action is not possible at its time; `None` if the run is one of the
    /// system.
    pub fn impossible_step(&self, system: &TimedSystem) -> Option<usize> {
        impossible_step(&Rules::new(system), self)
    }

    /// Returns the run in words.
    pub fn moments(&self, system: &TimedSystem) -> Vec<Moment> {
        self.moments_by_step(system).0
    }

    /// Returns the run in words, and the number of moments before the first step and after each step.
    pub(crate) fn moments_by_step(&self, system: &TimedSystem) -> (Vec<Moment>, Vec<usize>) {
        told(&Rules::new(system), self)
    }
}

fn impossible_step(rules: &Rules, run: &Run) -> Option<usize> {
    let mut s = rules.initial();
    let mut enabled = Enabled::default();
    let mut now = 0;
    for (step, &(time, action)) in run.steps.iter().enumerate() {
        if time > now {
            advance(rules, &mut s, (time - now) as Ticks);
            now = time;
        }
        rules.enabled(&s, &mut enabled);
        // A mark of a chain is no step of the system.
        if !matches!(action, Action::Mark { .. }) && !enabled.actions.contains(&action) {
            return Some(step);
        }
        rules.apply(&mut s, action);
    }
    None
}

fn told(rules: &Rules, run: &Run) -> (Vec<Moment>, Vec<usize>) {
    let mut s = rules.initial();
    let mut out = Vec::new();
    rules.tell((&rules.frame().blank(), &s), None, 0, &mut out);
    let mut ends = vec![out.len()];
    let mut now = 0;
    for &(time, action) in &run.steps {
        if time > now {
            advance(rules, &mut s, (time - now) as Ticks);
            now = time;
        }
        let before = s.clone();
        rules.apply(&mut s, action);
        let told = out.len();
        rules.tell((&before, &s), Some(action), now, &mut out);
        for moment in &mut out[told..] {
            moment.action = Some(action);
        }
        ends.push(out.len());
    }
    (out, ends)
}

/// Lets time pass although windows may end early: only the outcome of executions matters here.
pub(super) fn advance(rules: &Rules, s: &mut State, time: Ticks) {
    let l = rules.frame();
    for e in 0..l.executors() {
        let (a, b) = l.window(s, e);
        if b < time {
            l.set_window(s, e, (a, time));
        }
    }
    rules.elapse(s, time);
}

fn began_in_step(
    rules: &Rules,
    before: &State,
    after: &State,
    action: Action,
    executor: usize,
) -> bool {
    let l = rules.frame();
    l.is_executing(after, executor)
        && (!l.is_executing(before, executor)
            || matches!(action, Action::Finish { executor: finished, .. } if finished == executor))
}
