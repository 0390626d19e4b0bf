//! Random walks that look for long response times, and for missed deadlines.
//!
//! Breadth-first search examines everything that happens early, and seldom comes as far as a long response
//! time. A walk follows one run, and keeps no states. Most long response times have the same causes, so a
//! walk prefers them: codels that take their longest or shortest time, or end at a tick; yields that lead to
//! the longest rest of a job; and hardly any exceptions, which end activities. Each walk has preferences of
//! its own. The end of a walk with the longest response time so far is varied, from shortly before it on. A
//! walk proves nothing, but its run exists. Of several runs to a missed deadline the one that ends first is
//! kept.

use std::collections::VecDeque;
use std::hash::BuildHasher;

use rustc_hash::FxBuildHasher;
use typed_index_collections::{TiVec, ti_vec};

use super::observations::{Observations, Sight};
use crate::cancel::Cancel;
use crate::explore::findings::{Bound, Measured};
use crate::explore::measure::{Gauge, MeasurementMode};
use crate::explore::reductions::{Kind, Kinds};
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::run::Run;
use crate::explore::state::State;
use crate::explore::watch::{ResponseTime, Watch};
use crate::system::{CodelId, FOREVER, Machine, Ticks, TimedSystem, Yield};

/// Upper limit on the actions of a short walk; others have twice and four times as many.
const ACTIONS_OF_WALK: u64 = 2_000;

/// Upper limit on the actions for one response time.
const ACTIONS_OF_RESPONSE: u64 = 150_000;

/// Upper limit on the actions for one deadline.
const ACTIONS_OF_DEADLINE: u64 = 800_000;

/// Number of actions after which a deadline that is missed is not looked at any longer.
const ACTIONS_IF_MISSED: u64 = 25_000;

/// Numbers of jobs before the end of a walk after which its end is varied.
const VARIED_JOBS: [usize; 3] = [2, 3, 5];

/// Number of variants of a walk without a longer response time after which another walk is tried.
const VARIANTS: u64 = 60;

/// Actions between two polls of the limits.
const ACTIONS_PER_POLL: u64 = 32;

/// Number of actions at one moment before which victims do not go on.
const PATIENCE: u64 = 20;

/// Rounds after which the longest rest of a job in a state machine with loops counts as known.
const ROUNDS: usize = 12;

/// Returns the greatest number of bytes of the runs of walks for a number of questions.
pub fn bytes_of_walks(questions: usize) -> usize {
    // The present walk, and the best one of each question.
    (questions + 1) * (ACTIONS_OF_WALK << 2) as usize * size_of::<(u64, Action)>()
}

/// The runs that walks have found.
pub struct Walked {
    /// The longest response times, in the order of the watch.
    pub response: Vec<Option<Measured>>,
    /// Runs to missed deadlines, in the order of the watch.
    pub missed: Vec<Option<Run>>,
    /// Number of actions, each of which leads to a state.
    pub actions: u64,
}

/// Looks for the response times and the missed deadlines of a watch, with a limit on the number of actions.
pub fn walk(system: &TimedSystem, watch: &Watch, actions: u64, cancel: &Cancel) -> Walked {
    let rules = Rules::new(system);
    // A job with a long response time misses its deadline.
    let of_deadlines = watch.schedulable.iter();
    let of_deadlines = of_deadlines.map(|&task| ResponseTime { task, limit: None, most: None });
    let watch = Watch {
        response: watch.response.iter().copied().chain(of_deadlines).collect(),
        schedulable: watch.schedulable.clone(),
        ..Watch::default()
    };
    let gauges = Gauge::of(&watch, &MeasurementMode::Shared);
    let without = Kind::ALL.into_iter().fold(Kinds::NONE, Kinds::with);
    let (count, deadlines) = (watch.response.len(), watch.schedulable.len());
    let mut walks = Walks {
        observations: Observations::new(&rules, &watch, &gauges, without),
        rest: longest_rests(system),
        best: vec![None; count],
        missed: vec![None; deadlines],
        trail: Vec::new(),
        actions: 0,
        cancel,
    };
    for (number, response) in watch.response.iter().enumerate() {
        let deadline = (number + deadlines).checked_sub(count);
        let aim = Aim { gauge: number, deadline, task: response.task.into(), most: response.most };
        let most = deadline.map_or(ACTIONS_OF_RESPONSE, |_| ACTIONS_OF_DEADLINE);
        let left = actions.saturating_sub(walks.actions) / (count - number) as u64;
        walks.look_for(aim, left.min(most));
    }
    let actions = walks.actions;
    let response = walks.best.into_iter().take(count - deadlines);
    Walked {
        response: response.map(|best| best.map(measured)).collect(),
        missed: walks.missed,
        actions,
    }
}

fn measured((value, run): (Ticks, Run)) -> Measured {
    Measured { bound: Bound::Finite(value), longest: run, excess: None }
}

/// The aim of a walk.
#[derive(Clone, Copy)]
struct Aim {
    /// The gauge of the response time.
    gauge: usize,
    /// The deadline, if it should be missed.
    deadline: Option<usize>,
    task: usize,
    /// The response time that ends the search.
    most: Option<Ticks>,
}

/// The numbers of actions, of all walks, at which a search ends.
#[derive(Clone, Copy)]
struct ActionLimits {
    until: u64,
    /// If the deadline is missed in a run.
    if_missed: u64,
}

/// The preferences of a walk.
#[derive(Debug, Clone, Copy)]
struct Preferences {
    /// Generator of random choices.
    dice: u64,
    /// Seed of the choices that depend on the work under way.
    seed: u64,
    /// The task whose response time should be long.
    task: usize,
    /// Number, of eight, of codels that take their longest time.
    late: u64,
    /// Number, of eight, of yields that lead to the longest rest of a job.
    long: u64,
    /// Tasks that are released after others, and leave their locks to others.
    victims: [Option<usize>; 2],
    /// Number of actions at this moment for which they still do.
    patience: u64,
}

/// The end of a codel, as a walk prefers it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    Early,
    AtTick,
    Late,
}

impl Preferences {
    fn numbered(task: usize, number: u64, tasks: usize) -> Self {
        Preferences {
            dice: (number + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1,
            seed: number,
            task,
            late: [8, 7, 6, 4, 2][(number % 5) as usize],
            long: [8, 5, 0][(number % 3) as usize],
            victims: [
                (!number.is_multiple_of(3)).then_some(task),
                (!number.is_multiple_of(2)).then_some((number / 2) as usize % tasks),
            ],
            patience: PATIENCE,
        }
    }

    /// Returns true if others go before a task.
    fn is_victim(&self, task: usize) -> bool {
        self.victims.contains(&Some(task))
    }

    /// Returns a random number below a limit.
    fn below(&mut self, limit: u64) -> u64 {
        // Xorshift.
        self.dice ^= self.dice << 13;
        self.dice ^= self.dice >> 7;
        self.dice ^= self.dice << 17;
        (self.dice >> 8) % limit
    }

    /// Returns the end of the work of an executor that takes until `until` at the longest.
    fn end(&self, executor: usize, until: u64) -> End {
        let number = FxBuildHasher.hash_one((self.seed, executor, until)) >> 16;
        match (number % 8 < self.late, number & 8) {
            (true, _) => End::Late,
            (false, 0) => End::Early,
            (false, _) => End::AtTick,
        }
    }
}

/// Releases before the longest response time of a walk that are remembered.
const REMEMBERED: usize = VARIED_JOBS[VARIED_JOBS.len() - 1] + 1;

/// A position in a run.
#[derive(Clone)]
struct Position {
    s: State,
    now: u64,
    /// Number of actions before it.
    steps: usize,
}

struct Walks<'a> {
    /// A sight is identified by the number of actions before it.
    observations: Observations<'a, usize>,
    /// Longest rest of a job from the beginning of a codel, by codel.
    rest: TiVec<CodelId, u64>,
    /// Longest time and the run to it, by response time.
    best: Vec<Option<(Ticks, Run)>>,
    /// The run that ends first, by deadline.
    missed: Vec<Option<Run>>,
    /// Actions of the present walk, with their times.
    trail: Vec<(u64, Action)>,
    /// Number of actions of all walks.
    actions: u64,
    cancel: &'a Cancel,
}

impl Walks<'_> {
    fn look_for(&mut self, aim: Aim, actions: u64) {
        let limits = ActionLimits {
            until: self.actions + actions,
            if_missed: self.actions + actions.min(ACTIONS_IF_MISSED),
        };
        let mut number = 0;
        let start = Position { s: self.observations.initial(), now: 0, steps: 0 };
        while !self.is_over(aim, limits) {
            let before = self.longest(aim);
            let actions = ACTIONS_OF_WALK << (number / 5 % 3);
            let releases = self.walk(&start, aim, number, actions.min(limits.until - self.actions));
            number += 1;
            if self.longest(aim) > before {
                self.vary(&releases, aim, limits);
            }
        }
    }

    /// Returns the longest response time so far.
    fn longest(&self, aim: Aim) -> Option<Ticks> {
        self.best[aim.gauge].as_ref().map(|best| best.0)
    }

    fn is_over(&self, aim: Aim, limits: ActionLimits) -> bool {
        let reached = aim.most.is_some_and(|most| self.longest(aim) >= Some(most));
        let is_missed = aim.deadline.is_some_and(|deadline| self.missed[deadline].is_some());
        let until = if is_missed { limits.if_missed } else { limits.until };
        reached || self.actions >= until || self.cancel.is_over()
    }

    /// Varies the end of the last walk, from the job before the one with the longest response time on.
    fn vary(&mut self, releases: &[Position], aim: Aim, limits: ActionLimits) {
        let Some(longest) = self.observations.seen.longest[aim.gauge] else {
            return;
        };
        let before = releases
            .iter()
            .filter(|position| position.now + u64::from(longest.value) <= longest.at.time);
        let count = before.count();
        let mut best = longest.value;
        for back in VARIED_JOBS {
            let Some(position) = count.checked_sub(back).map(|place| &releases[place]) else {
                return;
            };
            let length = (longest.at.parent - position.steps) as u64 * 3 + 10;
            let mut fruitless = 0;
            let mut variant = 1_000;
            while fruitless < VARIANTS && !self.is_over(aim, limits) {
                self.walk(position, aim, variant, length.min(limits.until - self.actions));
                variant += 1;
                fruitless += 1;
                let found =
                    self.observations.seen.longest[aim.gauge].map_or(0, |longest| longest.value);
                if found > best {
                    (best, fruitless) = (found, 0);
                }
            }
        }
    }

    /// Continues a run. Returns the last positions at which a job of the task was released before the longest
    /// response time.
    fn walk(&mut self, start: &Position, aim: Aim, number: u64, actions: u64) -> Vec<Position> {
        let mut preferences =
            Preferences::numbered(aim.task, number, self.observations.rules.system().tasks.len());
        self.observations.clear_observations();
        let Position { mut s, mut now, steps } = start.clone();
        self.trail.truncate(steps);
        let (mut releases, mut longest) = (VecDeque::new(), Vec::new());
        let mut enabled = Enabled::default();
        let of = self.observations.gauges[aim.gauge].of;
        let mut runs = of.runs(&self.observations.rules, &s);
        let end = self.actions + actions;
        let missed = aim.deadline.and_then(|deadline| self.missed[deadline].as_ref());
        let latest = missed.map_or(u64::MAX, |run| run.end);
        let goal = aim.deadline.and_then(|deadline| self.observations.goals.missed().nth(deadline));
        while self.actions < end && now < latest {
            if goal.is_some_and(|(goal, _)| self.observations.seen.goals[goal].is_some()) {
                break;
            }
            self.actions += 1;
            if self.actions.is_multiple_of(ACTIONS_PER_POLL) && self.cancel.is_over() {
                break;
            }
            let rules = &self.observations.rules;
            if of.runs(rules, &s) != runs {
                runs = !runs;
                if runs {
                    releases.truncate(REMEMBERED - 1);
                    releases.push_front(Position { s: s.clone(), now, steps: self.trail.len() });
                }
            }
            rules.enabled(&s, &mut enabled);
            if let Some(action) = self.choose(&s, now, &enabled, &mut preferences) {
                self.trail.push((now, action));
                let at = Sight { parent: self.trail.len(), time: now };
                self.observations.step(&mut s, action, &mut 0, at);
                continue;
            }
            let jump = rules.next_moment(&s, &|executor| {
                let latest = rules.frame().window(&s, executor).1;
                latest != FOREVER
                    && preferences.end(executor, now + u64::from(latest)) != End::Early
            });
            let Some(jump) = jump else { break };
            rules.elapse(&mut s, jump);
            now += u64::from(jump);
            preferences.patience = PATIENCE;
            let at = Sight { parent: self.trail.len(), time: now };
            for gauge in 0..self.observations.gauges.len() {
                let found = self.observations.longest_after_jump(gauge, &s, at);
                if found.is_some() && gauge == aim.gauge {
                    longest = releases.iter().rev().cloned().collect();
                }
            }
        }
        self.keep();
        longest
    }

    /// Keeps the longest times of a walk.
    fn keep(&mut self) {
        let run = |at: Sight<usize>| Run {
            steps: self.trail[..at.parent].to_vec(),
            end: at.time,
            ..Run::default()
        };
        let Observations { goals, seen, .. } = &self.observations;
        for (longest, best) in seen.longest.iter().zip(&mut self.best) {
            let Some(longest) = longest else { continue };
            if best.as_ref().is_none_or(|best| best.0 < longest.value) {
                *best = Some((longest.value, run(longest.at)));
            }
        }
        for ((goal, _), first) in goals.missed().zip(&mut self.missed) {
            let Some(at) = seen.goals[goal] else { continue };
            if first.as_ref().is_none_or(|first| at.time < first.end) {
                *first = Some(run(at));
            }
        }
    }

    /// Returns the next action; `None`: time passes.
    fn choose(
        &self,
        s: &State,
        now: u64,
        enabled: &Enabled,
        preferences: &mut Preferences,
    ) -> Option<Action> {
        if let Some(action) = self.overtake(s, enabled, preferences) {
            return Some(action);
        }
        let rules = &self.observations.rules;
        let ticks = || enabled.actions.iter().any(|action| matches!(action, Action::Tick { .. }));
        let wanted = |action: &Action| {
            let Action::Finish { executor, .. } = *action else {
                return true;
            };
            let latest = rules.frame().window(s, executor).1;
            latest == 0
                || latest == FOREVER
                || match preferences.end(executor, now + u64::from(latest)) {
                    End::Early => true,
                    End::AtTick => ticks(),
                    End::Late => false,
                }
        };
        let mut list: Vec<Action> = enabled.actions.iter().copied().filter(wanted).collect();
        if list.is_empty() {
            // Something must happen now.
            if enabled.is_calm() {
                return None;
            }
            list.clone_from(&enabled.actions);
        }
        // An exception seldom makes more work.
        let throws = |action: &Action| match *action {
            Action::Finish { executor, outcome } => rules
                .codel(s, executor)
                .is_some_and(|codel| self.yield_after(codel, outcome).is_none()),
            _ => false,
        };
        if preferences.below(64) > 0 && !list.iter().all(throws) {
            list.retain(|action| !throws(action));
        }
        let mut action = list[preferences.below(list.len() as u64) as usize];
        // Others often go first.
        if rules.task_of(action) == Some(preferences.task) && preferences.below(4) > 0 {
            action = list[preferences.below(list.len() as u64) as usize];
        }
        let Action::Finish { executor, .. } = action else {
            return Some(action);
        };
        if preferences.below(8) >= preferences.long {
            return Some(action);
        }
        // Among the yields of a codel, the one to the longest rest of the job, and rather not to the end.
        let outcomes = list.iter().copied().filter(
            |other| matches!(other, Action::Finish { executor: other, .. } if *other == executor),
        );
        let rest = |action: &Action| match *action {
            Action::Finish { executor, outcome } => {
                rules.codel(s, executor).map(|codel| self.rest_after(codel, outcome))
            }
            _ => None,
        };
        outcomes.max_by_key(rest)
    }

    /// Returns an action of others that comes before the release of a victim, or keeps it from the locks that
    /// it can take: a codel takes them, or one ends that may request them next.
    fn overtake(
        &self,
        s: &State,
        enabled: &Enabled,
        preferences: &mut Preferences,
    ) -> Option<Action> {
        let rules = &self.observations.rules;
        let task =
            |action: Action| rules.task_of(action).filter(|&task| preferences.is_victim(task));
        let (victim, waiting) = enabled.actions.iter().find_map(|&action| match action {
            Action::Acquire { executor } => Some((task(action)?, rules.codel(s, executor))),
            Action::Release { .. } => Some((task(action)?, None)),
            _ => None,
        })?;
        let conflicts = waiting.map(|waiting| &rules.system().codels[waiting].conflicts);
        let excludes = |codel: Option<CodelId>| {
            conflicts.zip(codel).is_some_and(|(all, codel)| all.contains(codel))
        };
        let (mut first, mut others) = (Vec::new(), Vec::new());
        for &action in enabled.actions.iter().filter(|&&action| task(action) != Some(victim)) {
            match action {
                Action::Acquire { executor } if excludes(rules.codel(s, executor)) => {
                    first.push(action);
                }
                Action::Finish { executor, outcome } => {
                    let codel = rules.codel(s, executor);
                    let next = codel.and_then(|codel| self.codel_after(codel, outcome));
                    if excludes(next) && !excludes(codel) {
                        others.push(action);
                    }
                }
                _ => others.push(action),
            }
        }
        let list = if first.is_empty() { others } else { first };
        preferences.patience = preferences.patience.checked_sub(1)?;
        let count = list.len() as u64;
        (count > 0).then(|| list[preferences.below(count) as usize])
    }

    /// Returns the longest rest of a job after a codel with an outcome, and whether there are later jobs.
    fn rest_after(&self, codel: CodelId, outcome: usize) -> (u64, bool) {
        let ends = self.yield_after(codel, outcome).is_none_or(|(_, after)| *after == Yield::End);
        (self.codel_after(codel, outcome).map_or(0, |next| self.rest[next]), !ends)
    }

    /// Returns the next codel of the same turn after a codel with an outcome.
    fn codel_after(&self, codel: CodelId, outcome: usize) -> Option<CodelId> {
        match self.yield_after(codel, outcome)? {
            (machine, &Yield::Next(next)) => Some(machine.states[next].codel),
            _ => None,
        }
    }

    /// Returns the machine with a codel, and the yield that is an outcome of it.
    fn yield_after(&self, codel: CodelId, outcome: usize) -> Option<(&Machine, &Yield)> {
        let system = self.observations.rules.system();
        system.machines.iter().find_map(|machine| {
            let state = machine.states.iter().find(|state| state.codel == codel)?;
            Some((machine, state.yields.get(outcome)?))
        })
    }
}

/// Returns, by codel, the longest rest of a job from its beginning, with loops counted a few times.
fn longest_rests(system: &TimedSystem) -> TiVec<CodelId, u64> {
    let mut rest: TiVec<CodelId, u64> = ti_vec![0; system.codels.len()];
    for _ in 0..ROUNDS {
        for machine in &system.machines {
            for state in &machine.states {
                let next = state.yields.iter().map(|transition| match *transition {
                    Yield::Next(next) => rest[machine.states[next].codel],
                    _ => 0,
                });
                let next = next.max().unwrap_or(0);
                let upper = system.codels[state.codel].upper;
                let own = if upper == FOREVER { 0 } else { u64::from(upper) };
                rest[state.codel] = rest[state.codel].max(own + next);
            }
        }
    }
    rest
}
