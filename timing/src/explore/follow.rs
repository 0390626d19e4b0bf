//! A run of one system, followed in another one with other times.
//!
//! A run that was found with rounded times need not exist with the exact ones. [`follow`] looks for a run of
//! the exact system with the same decisions: each thread takes the same outcomes in the same order, and each
//! work takes as long as in the guide, or as long as possible. Simultaneous actions come in the order of the
//! guide. If that run does not fail, a few runs with other times and orders are tried.

use std::collections::VecDeque;
use std::hash::{Hash, Hasher};

use dotgen_analysis::model::Seconds;
use num_rational::Ratio;
use rustc_hash::FxHasher;

use super::rules::Action;
use super::run::{Run, SystemRun};
use super::stepper::{Possible, RunState as _, Seen, Stepper, Watched};
use super::watch::Watch;
use super::{Bound, Findings, Measured, Stop};
use crate::cancel::Cancel;
use crate::system::{FOREVER, Ticks, TimedSystem};

/// Number of runs that are tried.
const ATTEMPTS: u64 = 24;

/// Number of actions of all attempts together.
const ACTIONS: usize = 400_000;

/// Number of open decisions of the guide among which the next action is looked for.
const AHEAD: usize = 64;

/// Looks for a run of `system` that answers the only question of `watch` as the guide does, with the times of
/// `system`. It is the only finding of the result; bounds are lower bounds. `None`: no run was found.
pub(crate) fn follow(
    system: &TimedSystem,
    watch: &Watch,
    guide: &SystemRun,
    cancel: &Cancel,
) -> Option<Findings> {
    // A run that repeats itself for ever has no end to be reached.
    if guide.run.cycle.is_some() || guide.run.left_out {
        return None;
    }
    let guide = Guide::new(guide);
    let mut budget = ACTIONS;
    let run = (0..ATTEMPTS).find_map(|attempt| {
        let mut follower = Follower::new(system, watch, &guide, attempt);
        follower.run(&mut budget, cancel)
    })?;
    let found = || Some(run.clone());
    let measured = |limit: Option<Ticks>| {
        let bound = Bound::Finite(limit?.saturating_add(1));
        Some(Measured { bound, longest: found()?, excess: found() })
    };
    Some(Findings {
        missed: watch.schedulable.iter().map(|_| found()).collect(),
        overdue: watch.overdue.iter().map(|_| found()).collect(),
        reached: watch.reach.iter().map(|_| found()).collect(),
        response: watch.response.iter().map(|response| measured(response.limit)).collect(),
        within: watch.within.iter().map(|within| measured(within.limit)).collect(),
        deadlock: watch.deadlock.then(found).flatten(),
        stopped: Some(Stop::Answered),
        ..Findings::default()
    })
}

/// The decisions of a run.
struct Guide {
    /// Actions, with their times in seconds.
    actions: Vec<(Seconds, Action)>,
    /// Durations of the works of each executor, in seconds, in order.
    durations: Vec<Vec<Seconds>>,
    /// End of the run in seconds.
    end: Seconds,
}

impl Guide {
    fn new(guide: &SystemRun) -> Guide {
        let system = &guide.system;
        let seconds = |ticks: u64| system.seconds(ticks);
        let mut stepper = Stepper::new(system, &Watched::default());
        let mut seen = Vec::new();
        stepper.begin(&mut seen);
        let mut began = vec![0; stepper.executors()];
        let mut durations = vec![Vec::new(); stepper.executors()];
        let mut note = |seen: &mut Vec<Seen>, now: u64| {
            for event in seen.drain(..) {
                match event {
                    Seen::Begun { executor, .. } => began[executor] = now,
                    Seen::Ended { executor, .. } => {
                        durations[executor].push(seconds(now - began[executor]));
                    }
                    _ => {}
                }
            }
        };
        note(&mut seen, 0);
        for &(time, action) in &guide.run.steps {
            if time > stepper.now() {
                let wait = Ticks::try_from(time - stepper.now()).unwrap_or(Ticks::MAX);
                // The run is one of the system: only the outcomes matter here, not when works may end.
                for executor in 0..stepper.executors() {
                    if let Some((least, greatest)) = stepper.window(executor) {
                        stepper.set_window(executor, (least, greatest.max(wait)));
                    }
                }
                stepper.pass(wait, &mut seen);
            }
            stepper.perform(action, &mut seen);
            note(&mut seen, time);
        }
        let actions = guide.run.steps.iter().map(|&(time, action)| (seconds(time), action));
        Guide { actions: actions.collect(), durations, end: seconds(guide.run.end) }
    }
}

/// One attempt to follow a guide.
struct Follower<'f> {
    stepper: Stepper<'f>,
    system: &'f TimedSystem,
    watch: &'f Watch,
    guide: &'f Guide,
    attempt: u64,
    /// Indices of the actions of the guide that have not been taken, in order.
    open: VecDeque<usize>,
    /// Number of works that each executor has begun.
    begun: Vec<usize>,
    run: Run,
}

impl<'f> Follower<'f> {
    fn new(system: &'f TimedSystem, watch: &'f Watch, guide: &'f Guide, attempt: u64) -> Self {
        let within = watch.within.iter();
        let watched = Watched {
            reach: watch.reach.clone(),
            within: within.map(|of| (of.trigger.clone(), of.responses.clone())).collect(),
            monitors: watch.monitors.clone(),
            facts: 0,
        };
        let stepper = Stepper::new(system, &watched);
        Follower {
            begun: vec![0; stepper.executors()],
            stepper,
            system,
            watch,
            guide,
            attempt,
            open: (0..guide.actions.len()).collect(),
            run: Run::default(),
        }
    }

    /// Returns the run that shows what is looked for.
    fn run(&mut self, budget: &mut usize, cancel: &Cancel) -> Option<Run> {
        // With shorter times, the run may end somewhat later.
        let end = self.ticks(self.guide.end + self.guide.end / Ratio::from_integer(4)) + 1;
        let mut seen = Vec::new();
        self.stepper.begin(&mut seen);
        let mut possible = Possible::default();
        while *budget > 0 && self.stepper.now() <= end && !cancel.is_over() {
            if self.shows(&seen) {
                self.run.end = self.stepper.now();
                return Some(std::mem::take(&mut self.run));
            }
            self.decide(&seen);
            seen.clear();
            self.stepper.possible(&mut possible);
            if let Some(action) = self.choose(&possible) {
                *budget -= 1;
                self.run.steps.push((self.stepper.now(), action));
                self.stepper.perform(action, &mut seen);
                continue;
            }
            match self.stepper.next_moment() {
                Some(time) => {
                    let time = time.min(self.until_excess().unwrap_or(time)).max(1);
                    self.stepper.pass(time, &mut seen);
                }
                None if self.watch.deadlock && possible.actions().is_empty() => {
                    self.run.end = self.stepper.now();
                    return Some(std::mem::take(&mut self.run));
                }
                None => return None,
            }
        }
        None
    }

    fn ticks(&self, time: Seconds) -> u64 {
        let ticks = (time / self.system.unit).to_integer();
        u64::try_from(ticks).unwrap_or(u64::MAX / 2)
    }

    /// The elapsed time and the limit of each time that is looked for.
    fn times(&self) -> impl Iterator<Item = (Ticks, Ticks)> {
        let response = self.watch.response.iter();
        let response = response.filter_map(|response| {
            Some((self.stepper.job(response.task.into())?, response.limit?))
        });
        let within = self.watch.within.iter().enumerate();
        let within =
            within.filter_map(|(i, within)| Some((self.stepper.awaited(i)?, within.limit?)));
        response.chain(within)
    }

    fn until_excess(&self) -> Option<Ticks> {
        self.times().map(|(elapsed, limit)| (limit + 1).saturating_sub(elapsed)).min()
    }

    /// Returns true if an event, or the time that has passed, is what is looked for.
    fn shows(&self, seen: &[Seen]) -> bool {
        let event = |event: &Seen| match *event {
            Seen::Missed { task } => self.watch.schedulable.contains(&task.into()),
            Seen::Overdue { task } => self.watch.overdue.contains(&task.into()),
            Seen::Reached { .. } => true,
            _ => false,
        };
        seen.iter().any(event) || self.times().any(|(elapsed, limit)| elapsed > limit)
    }

    /// Gives each work that has just begun its duration.
    fn decide(&mut self, seen: &[Seen]) {
        for event in seen {
            let &Seen::Begun { executor, time: (least, greatest), .. } = event else { continue };
            let number = self.begun[executor];
            self.begun[executor] += 1;
            let guided = self.guide.durations.get(executor).and_then(|of| of.get(number));
            let guided = guided.map(|&time| self.ticks(time).min(u64::from(FOREVER - 1)) as Ticks);
            let longest = if greatest == FOREVER { guided.unwrap_or(least) } else { greatest };
            let time = match self.attempt {
                0 => guided.unwrap_or(longest),
                1 => longest,
                _ => match self.random(executor, 3) {
                    0 => least,
                    1 => longest,
                    _ => guided.unwrap_or(longest),
                },
            };
            self.stepper.decide(executor, time);
        }
    }

    /// A number below `of`, other ones in each attempt.
    fn random(&self, what: usize, of: u64) -> u64 {
        let mut hasher = FxHasher::default();
        (self.attempt, self.run.steps.len(), what).hash(&mut hasher);
        (hasher.finish() >> 32) % of
    }

    /// Chooses the next action; `None`: time passes.
    fn choose(&mut self, possible: &Possible) -> Option<Action> {
        let actions = possible.actions();
        let ahead = self.open.iter().take(AHEAD).enumerate();
        let next = { ahead }.find(|(_, at)| actions.contains(&self.guide.actions[**at].1));
        let next = next.map(|(place, &at)| (place, self.guide.actions[at]));
        if possible.may_wait() {
            // What may happen, and need not: when the guide does it, or work that has come to its end.
            let (place, (time, action)) = next?;
            let due = self.ticks(time) <= self.stepper.now();
            let is_work = matches!(action, Action::Finish { .. });
            let take = due && !is_work;
            take.then(|| self.open.remove(place));
            return take.then_some(action);
        }
        let shuffled = self.attempt > 1 && self.random(usize::MAX, 4) == 0;
        let chosen = match next {
            Some((_, (_, action))) if !shuffled => action,
            _ => actions[self.random(actions.len(), actions.len() as u64) as usize],
        };
        let open = self.open.iter().take(AHEAD);
        let place = { open }.position(|&at| self.guide.actions[at].1 == chosen);
        place.map(|place| self.open.remove(place));
        Some(chosen)
    }
}
