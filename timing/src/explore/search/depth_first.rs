//! A depth-first search. Its rules and reductions are those of the breadth-first search; only the order
//! differs, and states of all moments are compared with each other.
//!
//! States are followed as they were reached, and never joined with others, so the steps to a state are a run.

use std::hash::BuildHasher;

use rustc_hash::FxBuildHasher;

use super::goals::{Goals, PerGoal};
use super::layers::covering;
use super::observations::{Longest, Observations, Sight};
use crate::cancel::Cancel;
use crate::explore::findings::Findings;
use crate::explore::reductions::SleepSet;
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::run::Run;
use crate::explore::state::State;
use crate::explore::store::{Encoded, Store, encode};
use crate::explore::watch::{Limits, Stop, Watch};
use crate::system::{FOREVER, ServiceId, Ticks, TimedSystem};

/// Steps between two polls of the limits.
const STEPS_PER_POLL: u64 = 16;

/// Number of plausible times after which a run without news is abandoned.
const MAX_PLAUSIBLE_TIMES: u64 = 4;

/// The order in which the actions of a state are followed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Order {
    /// Time passes before any action that can be postponed.
    patient: bool,
    /// Codels with an upper bound take their longest time, as most failures need that. Such a search is not
    /// complete.
    pub(super) late: bool,
    /// Generator of random choices; `None`: the last action first.
    dice: Option<u64>,
    /// Equal alternatives lead to equal choices, so that an endless behaviour continues.
    steady: bool,
}

impl Order {
    /// Number of orders that differ in more than the random choices.
    pub(super) const KINDS: u64 = 3;

    /// Returns the order with a number. Each number gives a different order.
    pub(super) fn numbered(number: u64) -> Self {
        Order {
            patient: number % Self::KINDS == 1,
            late: number % Self::KINDS == 2,
            dice: (number > 0).then(|| number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1),
            steady: false,
        }
    }

    /// Returns this order with steady choices, mostly with codels that take their longest time.
    pub(super) fn steady(self) -> Self {
        Order { late: self.late || self.patient, steady: true, ..self }
    }

    /// Sorts actions: the one to follow first comes last. Actions of a task that is `kept` from ending come
    /// first in the list.
    fn sort_actions(&mut self, list: &mut [(Action, SleepSet)], kept: impl Fn(Action) -> bool) {
        if self.steady {
            let dice = self.dice;
            list.sort_by_cached_key(|&(a, _)| (!kept(a), FxBuildHasher.hash_one((dice, a))));
            return;
        }
        let Some(dice) = &mut self.dice else { return };
        for i in (1..list.len()).rev() {
            // Xorshift.
            *dice ^= *dice << 13;
            *dice ^= *dice >> 7;
            *dice ^= *dice << 17;
            list.swap(i, (*dice % (i as u64 + 1)) as usize);
        }
    }
}

/// The index of a step in the trail.
type StepId = u32;

/// The position before the first step.
const START: StepId = u32::MAX;

/// The step from one state to the next.
#[derive(Debug, Clone, Copy)]
enum Step {
    Act(Action),
    Pass(Ticks),
}

/// A state from which the search continues.
struct Open {
    s: State,
    held: SleepSet,
    /// Last step to the state, and its time.
    at: Sight<StepId>,
}

pub(super) struct DepthFirstSearch<'a> {
    /// The rules, and the sights so far. A sight is identified by its step.
    observations: Observations<'a, StepId>,
    limits: Limits,
    cancel: &'a Cancel,
    passed: Store,
    /// Steps, each with the index of its predecessor.
    trail: Vec<(StepId, Step)>,
    open: Vec<Open>,
    pub(super) steps: u64,
    /// Search for a value of the only measured time that is greater than this, in base units.
    pub(super) lasts: Option<Ticks>,
}

impl<'a> DepthFirstSearch<'a> {
    pub(super) fn new(
        observations: Observations<'a, StepId>,
        limits: Limits,
        cancel: &'a Cancel,
    ) -> Self {
        DepthFirstSearch {
            passed: Store::new(observations.rules.frame().clocks(), covering(limits)),
            observations,
            limits,
            cancel,
            trail: Vec::new(),
            open: Vec::new(),
            steps: 0,
            lasts: None,
        }
    }

    /// Starts again from the initial state and takes up to `steps` steps, at most to the moment `end`.
    /// `beside` is the number of states and bytes already in use elsewhere. Returns false if a limit ended
    /// the search.
    pub(super) fn run(
        &mut self,
        mut order: Order,
        steps: u64,
        end: u64,
        beside: (usize, usize),
    ) -> bool {
        self.begin();
        let mut enabled = Enabled::default();
        let mut first = Vec::new();
        let mut followed = Vec::new();
        let mut encoding = Encoded::default();
        while !self.is_over() && self.steps < steps {
            let Some(Open { mut s, mut held, mut at }) = self.open.pop() else {
                break;
            };
            self.steps += 1;
            if self.steps % STEPS_PER_POLL == 1 && self.out_of_bounds(beside) {
                return false;
            }
            let trail = &mut self.trail;
            let observations = &mut self.observations;
            observations.settle(&mut s, &mut held, &mut enabled, |action| {
                at.parent = push(trail, at.parent, Step::Act(action));
                at
            });
            encode(observations.rules.frame(), &s, &mut encoding);
            if held != 0 {
                encoding.key.extend(held.to_le_bytes());
            }
            if self.passed.insert(&encoding, 0, |_, _| 0).is_none() {
                continue;
            }
            if self.is_unpromising(at) {
                break;
            }
            let observations = &self.observations;
            observations.followed((&s, held), &enabled, &mut first, &mut followed);
            if order.late {
                let l = observations.rules.frame();
                followed.retain(|&(action, _)| {
                    !matches!(action, Action::Finish { executor, .. }
                        if !matches!(l.window(&s, executor).1, 0 | FOREVER))
                });
            }
            order.sort_actions(&mut followed, |action| observations.is_measured(action));
            let calm = enabled.is_calm();
            let jump = calm.then(|| self.jump(&s, order)).flatten();
            let jump = jump.filter(|&jump| at.time + u64::from(jump) <= end);
            if !order.patient
                && let Some(jump) = jump
            {
                self.pass(&s, at, jump);
            }
            for &(action, held) in &followed {
                self.act(&s, held, at, action);
            }
            if order.patient
                && let Some(jump) = jump
            {
                self.pass(&s, at, jump);
            }
        }
        true
    }

    fn begin(&mut self) {
        self.observations.clear_observations();
        self.passed.clear();
        self.trail.clear();
        self.open.clear();
        self.steps = 0;
        let at = Sight { parent: START, time: 0 };
        let s = self.observations.initial();
        self.observations.check(None, &s, at);
        self.open.push(Open { s, held: 0, at });
    }

    /// Returns true if the search has seen everything, or enough.
    fn is_over(&self) -> bool {
        let Observations { seen, .. } = &self.observations;
        let answered =
            || self.observations.all_measured() && seen.goals.values().all(Option::is_some);
        seen.enough || answered() || self.longest().is_some()
    }

    /// Returns true if a run has continued for so long that it is unlikely to show news.
    fn is_unpromising(&self, at: Sight<StepId>) -> bool {
        self.lasts.is_some_and(|number| at.time > MAX_PLAUSIBLE_TIMES * u64::from(number))
    }

    /// Returns the longest time seen, if it is longer than the one searched for.
    fn longest(&self) -> Option<Longest<StepId>> {
        let longest = self.observations.seen.longest.first().copied().flatten()?;
        self.lasts.is_some_and(|number| longest.value > number).then_some(longest)
    }

    /// Returns a run whose last measurement is as long as the one searched for, and the length.
    pub(super) fn longest_run(&mut self) -> Option<(Run, Ticks)> {
        let Longest { value, at } = self.longest()?;
        Some((self.run_to(at), value))
    }

    /// Returns the repetition within the last measurement of a run.
    pub(super) fn repetition(&self, run: &Run, value: Ticks) -> Option<(u64, u64)> {
        let Observations { rules, observers, gauges, .. } = &self.observations;
        let of = gauges.first().map(|gauge| gauge.of);
        let age = |s: &State| of.map_or((0, 0, false), |gauge| gauge.age(rules, s));
        run.repetition(rules, (observers, value), &age, self.cancel)
    }

    /// Returns true if all states have been examined.
    pub(super) fn is_exhausted(&self) -> bool {
        self.open.is_empty() && !self.is_over()
    }

    /// Returns true if there is nothing left to find or to examine.
    pub(super) fn is_done(&self) -> bool {
        self.open.is_empty() || self.is_over()
    }

    fn out_of_bounds(&self, (states, bytes): (usize, usize)) -> bool {
        let (states, bytes) = (states + self.states(), bytes + self.memory());
        Stop::reason(states, bytes, self.limits, self.cancel).is_some()
    }

    /// Returns the time to let pass, in base units.
    fn jump(&self, s: &State, order: Order) -> Option<Ticks> {
        let Observations { rules, reductions, .. } = &self.observations;
        if !order.late {
            return reductions.next_moment(rules, s);
        }
        let waiters = reductions.waiters(rules, s);
        rules.next_moment(s, &|executor| {
            let waits = waiters.as_ref();
            rules.frame().window(s, executor).1 != FOREVER
                || waits.is_some_and(|wait| wait.can_be_deferred(rules.system(), executor))
        })
    }

    fn pass(&mut self, s: &State, at: Sight<StepId>, jump: Ticks) {
        let mut s = s.clone();
        let at = Sight {
            parent: push(&mut self.trail, at.parent, Step::Pass(jump)),
            time: at.time + u64::from(jump),
        };
        self.observations.rules.elapse(&mut s, jump);
        self.look_at_clocks(&mut s, at);
        self.open.push(Open { s, held: 0, at });
    }

    fn act(&mut self, s: &State, mut held: SleepSet, at: Sight<StepId>, action: Action) {
        let mut s = s.clone();
        let at = Sight { parent: push(&mut self.trail, at.parent, Step::Act(action)), ..at };
        self.observations.step(&mut s, action, &mut held, at);
        self.open.push(Open { s, held, at });
    }

    fn look_at_clocks(&mut self, s: &mut State, at: Sight<StepId>) {
        self.observations.waiting_after_jump(s, at);
        for gauge in 0..self.observations.gauges.len() {
            self.observations.longest_after_jump(gauge, s, at);
        }
    }

    /// Returns runs to the goals that were seen.
    pub(super) fn found_run(&mut self) -> PerGoal<Option<Run>> {
        let Observations { goals, seen, .. } = &self.observations;
        let sights = goals.each(|id| seen.goals[id]);
        sights.map(|found| found.map(|at| self.run_to(at)))
    }

    /// Returns the run that ends with a step. Its steps are performed again, and observed.
    fn run_to(&mut self, at: Sight<StepId>) -> Run {
        let mut steps = Vec::new();
        let mut last = at.parent;
        while let Some(&(before, step)) = self.trail.get(last as usize) {
            steps.push(step);
            last = before;
        }
        let mut s = self.observations.initial();
        let mut run = Run::default();
        for step in steps.into_iter().rev() {
            match step {
                Step::Act(action) => {
                    run.steps.push((run.end, action));
                    let now = Sight { time: run.end, ..at };
                    self.observations.step(&mut s, action, &mut 0, now);
                }
                Step::Pass(time) => {
                    run.end += u64::from(time);
                    let now = Sight { time: run.end, ..at };
                    self.observations.rules.elapse(&mut s, time);
                    self.look_at_clocks(&mut s, now);
                }
            }
        }
        run
    }

    /// Returns the services with a refused request.
    pub(super) fn refused(&self) -> Vec<ServiceId> {
        (self.observations.rules.system().services.keys())
            .filter(|&service| self.observations.rules.has_refused(service))
            .collect()
    }

    /// Returns the number of examined states.
    pub(super) fn states(&self) -> usize {
        self.passed.len()
    }

    /// Returns the approximate number of bytes in use.
    pub(super) fn memory(&self) -> usize {
        let open = size_of::<Open>() + self.observations.rules.frame().state_bytes();
        self.passed.memory()
            + self.trail.capacity() * size_of::<(StepId, Step)>()
            + self.open.capacity() * open
    }
}

/// Runs a single search, with the order of this number, for tests: returns findings of single states only.
pub fn search_once(
    system: &TimedSystem,
    watch: &Watch,
    (number, steps): (u64, u64),
    limits: Limits,
    cancel: &Cancel,
) -> Findings {
    let rules = Rules::new(system);
    let observations = Observations::new(&rules, watch, &[], limits.without);
    let mut search = DepthFirstSearch::new(observations, limits, cancel);
    let room = search.run(Order::numbered(number), steps, u64::MAX, (0, 0));
    let goals = Goals::of(watch);
    let mut found_run = search.found_run().into_values();
    let [missed, overdue, reached] = goals.split(goals.each(|_| found_run.next().flatten()));
    Findings {
        missed,
        overdue,
        reached,
        refused: search.refused(),
        states: search.states(),
        steps: search.steps,
        bytes: search.memory(),
        stopped: (!room || !search.is_done()).then_some(Stop::States),
        ..Findings::default()
    }
}

/// Adds a step after another one.
fn push(trail: &mut Vec<(StepId, Step)>, before: StepId, step: Step) -> StepId {
    trail.push((before, step));
    trail.len() as u32 - 1
}
