//! Observation along runs, whatever the order of exploration: single steps, and what each step shows.

use super::goals::{Goals, PerGoal};
use crate::explore::held_cores::HeldCores;
use crate::explore::measure::{Gauge, MeasurementMode, Timing};
use crate::explore::never_observed::NeverObserved;
use crate::explore::observe::{self, Observers};
use crate::explore::reductions::{Kinds, Reductions, SleepSet, Watched};
use crate::explore::rules::{Action, Enabled, Rules};
use crate::explore::state::{Clocks, Stages, State, TaskStatus};
use crate::explore::watch::Watch;
use crate::property::Predicate;
use crate::system::{TaskId, Ticks};

/// The place and time of an observation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sight<P> {
    /// Position from which it was reached.
    pub(super) parent: P,
    pub(super) time: u64,
}

/// The longest time so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Longest<P> {
    pub(super) value: Ticks,
    pub(super) at: Sight<P>,
}

/// The observations so far.
pub(super) struct Seen<P> {
    pub(super) goals: PerGoal<Option<Sight<P>>>,
    /// Longest time, by gauge.
    pub(super) longest: Vec<Option<Longest<P>>>,
    /// First place at which the limit is exceeded, by gauge.
    pub(super) excess: Vec<Option<Sight<P>>>,
    /// Jobs and atoms that no state has had so far.
    pub(super) absent: NeverObserved,
    /// No further observations are needed.
    pub(super) enough: bool,
    /// Tasks that hold all cores for ever in states that were not followed.
    pub(super) hold_cores: Vec<TaskId>,
}

/// The rules of a system, with its watch and the observations so far.
pub(super) struct Observations<'a, P> {
    pub(super) rules: Rules<'a>,
    pub(super) reductions: Reductions,
    pub(super) watch: &'a Watch,
    pub(super) goals: Goals<'a>,
    pub(super) observers: Observers,
    pub(super) gauges: &'a [Gauge],
    /// Tasks whose clock is only for the overdue check.
    pub(super) waiting_only: Vec<bool>,
    held_cores: Option<HeldCores>,
    pub(super) seen: Seen<P>,
}

impl<'a, P: Copy> Observations<'a, P> {
    /// Creates the observation of a watch, with the reductions that respect it.
    pub(super) fn new(
        rules: &Rules<'a>,
        watch: &'a Watch,
        gauges: &'a [Gauge],
        without: Kinds,
    ) -> Self {
        let system = rules.system();
        let measured = |of: Timing| gauges.iter().any(|gauge| gauge.of == of && gauge.active());
        let measured_task = |task: usize| measured(Timing::Response(task));
        let waiting_only: Vec<bool> = (0..system.tasks.len())
            .map(|t| {
                !measured_task(t)
                    && watch.overdue.contains(&TaskId::from(t))
                    && system.tasks[TaskId::from(t)].period.is_some()
            })
            .collect();
        let observed: Vec<bool> =
            (0..system.tasks.len()).map(|t| measured_task(t) || waiting_only[t]).collect();
        let clocked: Vec<Stages> = (watch.within.iter().enumerate())
            .map(|(i, bound)| Stages {
                count: bound.responses.len(),
                measured: measured(Timing::Within(i)),
            })
            .collect();
        let monitors = watch.monitors.iter().map(|monitor| monitor.time > 0).collect();
        let clocks = Clocks { response: observed, within: clocked, monitors, ..Clocks::default() };
        let own = rules.with_clocks(&clocks);
        let predicates: Vec<&Predicate> = (watch.within.iter())
            .flat_map(|bound| bound.responses.iter().chain([&bound.trigger]))
            .chain(&watch.reach)
            .chain(watch.monitors.iter().flat_map(|monitor| &monitor.predicates))
            .collect();
        let asked = Watched { predicates, measured: clocks.response };
        let goals = Goals::of(watch);
        let reductions = Reductions::new(&own, &asked, without);
        Observations {
            watch,
            observers: Observers::of(watch.predicates_within(), &watch.monitors),
            gauges,
            waiting_only,
            seen: Seen {
                goals: goals.each(|_| None),
                longest: vec![None; gauges.len()],
                excess: vec![None; gauges.len()],
                absent: NeverObserved::of(watch),
                enough: false,
                hold_cores: Vec::new(),
            },
            held_cores: HeldCores::of(&own, watch),
            goals,
            reductions,
            rules: own,
        }
    }

    /// Returns the state at time 0, with the obligations and the monitors that begin there.
    pub(super) fn initial(&self) -> State {
        let mut s = self.rules.initial();
        observe::observe(&self.rules, &self.observers, None, &mut s);
        s
    }

    /// Removes all observations.
    pub(super) fn clear_observations(&mut self) {
        self.seen.goals.values_mut().for_each(|goal| *goal = None);
        self.seen.longest.fill(None);
        self.seen.enough = false;
    }

    /// Returns true if no state that follows answers a question.
    pub(super) fn is_past_all(&mut self, s: &State) -> bool {
        let Some(held) = &self.held_cores else { return false };
        let holders = held.holders(&self.rules, s);
        for task in &holders {
            if !self.seen.hold_cores.contains(task) {
                self.seen.hold_cores.push(*task);
            }
        }
        !holders.is_empty()
    }

    // ---- Steps -----------------------------------------------------------------------------

    /// Performs committed steps without a choice, whose states need not be kept. `at` is the sight after a
    /// step.
    pub(super) fn settle(
        &mut self,
        s: &mut State,
        held: &mut SleepSet,
        enabled: &mut Enabled,
        mut at: impl FnMut(Action) -> Sight<P>,
    ) {
        self.rules.enabled(s, enabled);
        // The limit is needed because a client may loop without time passing.
        for _ in 0..16 {
            if !enabled.committed || enabled.actions.len() != 1 {
                break;
            }
            let action = enabled.actions[0];
            self.step(s, action, held, at(action));
            self.rules.enabled(s, enabled);
        }
    }

    /// Writes the actions to follow in a state, each with the actions that it holds back.
    pub(super) fn followed(
        &self,
        (s, held): (&State, SleepSet),
        enabled: &Enabled,
        first: &mut Vec<Action>,
        out: &mut Vec<(Action, SleepSet)>,
    ) {
        let at = (s, held);
        self.reductions.follow(&self.rules, at, enabled, first, out);
    }

    /// Performs an action, and checks the new state.
    pub(super) fn step(
        &mut self,
        s: &mut State,
        action: Action,
        held: &mut SleepSet,
        at: Sight<P>,
    ) {
        let needs_before = !self.observers.is_empty() || !self.watch.reach.is_empty() || *held != 0;
        let before = needs_before.then(|| s.clone());
        self.rules.apply(s, action);
        if let Some(before) = &before {
            observe::observe(&self.rules, &self.observers, Some(before), s);
            *held = (self.reductions).sleep_set_after(&self.rules, before, action, s, *held);
        }
        self.begin_waiting(s, action);
        self.overdue_at_once(s, action, at);
        self.check(before.as_ref(), s, at);
    }

    /// Stops the clocks of tasks that only serve the overdue check, when the task has got a core.
    pub(super) fn begin_waiting(&self, s: &mut State, action: Action) {
        if let Action::Grant { task } = action
            && self.waiting_only[task]
            && let Some(clock) = self.rules.frame().response[task]
        {
            s.t[clock] = 0;
        }
    }

    /// Resets the clocks that only serve the overdue check, after time has passed.
    pub(super) fn clamp_waiting(&self, s: &mut State) {
        let l = self.rules.frame();
        for (task, only) in self.waiting_only.iter().enumerate() {
            if *only && let Some(clock) = l.response[task] {
                let running = self.rules.job(s, task) == TaskStatus::Running;
                let most = self.rules.system().tasks[TaskId::from(task)].period.unwrap_or(0);
                s.t[clock] = if running { 0 } else { s.t[clock].min(most) };
            }
        }
    }

    // ---- Observations ----------------------------------------------------------------------

    /// Checks a state that was just entered.
    pub(super) fn check(&mut self, before: Option<&State>, s: &State, at: Sight<P>) {
        self.seen.absent.look(&self.rules, s);
        for (goal, task) in self.goals.missed() {
            if self.seen.goals[goal].is_none() && self.rules.missed(s, task) {
                self.seen.goals[goal] = Some(at);
                self.seen.enough |= self.watch.stop_at_first;
            }
        }
        for (goal, predicate) in self.goals.reached() {
            if self.seen.goals[goal].is_none()
                && observe::predicate(&self.rules, before, s, predicate)
            {
                self.seen.goals[goal] = Some(at);
            }
        }
        for i in 0..self.gauges.len() {
            self.opened_late(i, s, at);
        }
        for (i, gauge) in self.gauges.iter().enumerate() {
            if self.seen.longest[i].is_none()
                && (gauge.of.runs(&self.rules, s) || self.is_answered_at_once(before, s, gauge.of))
            {
                self.seen.longest[i] = Some(Longest { value: 0, at });
            }
        }
    }

    /// Records an age when its data becomes visible, possibly for no time at all; its clock has run before.
    fn opened_late(&mut self, gauge: usize, s: &State, at: Sight<P>) {
        if !matches!(self.gauges[gauge].of, Timing::Within(_)) {
            return;
        }
        let Some(value) = self.measures(gauge, s).map(|clock| s.t[clock]) else {
            return;
        };
        if value > 0 && self.seen.longest[gauge].is_none_or(|longest| longest.value < value) {
            self.seen.longest[gauge] = Some(Longest { value, at });
        }
        let exceeds = self.gauges[gauge].limit.is_some_and(|limit| value > limit);
        if exceeds && self.seen.excess[gauge].is_none_or(|excess| at.time < excess.time) {
            self.seen.excess[gauge] = Some(at);
        }
    }

    /// Returns true if the start and the end of a measurement have both just happened: no time at all.
    pub(super) fn is_answered_at_once(
        &self,
        before: Option<&State>,
        s: &State,
        of: Timing,
    ) -> bool {
        let Timing::Within(observer) = of else {
            return false;
        };
        let trigger = &self.observers.responses[observer].trigger;
        let was = before.is_some_and(|state| trigger.eval_still(&|a| self.rules.atom(state, a)));
        !was && observe::predicate(&self.rules, before, s, trigger)
    }

    /// Checks tasks that begin to wait for a core with an action: a job that counts from a kept tick may be
    /// overdue at once.
    fn overdue_at_once(&mut self, s: &State, action: Action, at: Sight<P>) {
        for (goal, task) in self.goals.overdue() {
            let begins = self.rules.may_begin_to_wait(action, task);
            if begins && self.seen.goals[goal].is_none() && self.rules.overdue(s, task) {
                self.seen.goals[goal] = Some(at);
            }
        }
    }

    /// Checks waiting tasks after time has passed.
    pub(super) fn waiting_after_jump(&mut self, s: &mut State, at: Sight<P>) {
        for (goal, task) in self.goals.overdue() {
            if self.seen.goals[goal].is_none() && self.rules.overdue(s, task) {
                self.seen.goals[goal] = Some(at);
            }
        }
        self.clamp_waiting(s);
    }

    /// Checks one clock after time has passed. Returns the time if it is the longest so far.
    pub(super) fn longest_after_jump(
        &mut self,
        gauge: usize,
        s: &State,
        at: Sight<P>,
    ) -> Option<Ticks> {
        let value = self.measures(gauge, s).map(|clock| s.t[clock])?;
        if self.seen.longest[gauge].is_some_and(|longest| longest.value >= value) {
            return None;
        }
        self.seen.longest[gauge] = Some(Longest { value, at });
        Some(value)
    }

    // ---- Measurements ----------------------------------------------------------------------

    /// Returns the clock of a gauge, if it runs.
    pub(super) fn measures(&self, gauge: usize, s: &State) -> Option<usize> {
        let (l, of) = (self.rules.frame(), self.gauges[gauge].of);
        let other = matches!(of, Timing::Response(task) if self.waiting_only[task]);
        of.clock(l, s).filter(|_| !other && of.runs(&self.rules, s))
    }

    /// Returns true if an action belongs to a task whose response time is measured.
    pub(super) fn is_measured(&self, action: Action) -> bool {
        let Some(task) = self.rules.task_of(action) else {
            return false;
        };
        self.gauges.iter().any(|gauge| gauge.of == Timing::Response(task))
    }

    /// Returns true if a gauge has reached its known maximum, and its limit needs no further search.
    fn is_longest(&self, gauge: usize) -> bool {
        let entry = &self.gauges[gauge];
        entry.most.is_some_and(|most| {
            entry.active()
                && entry.limit.is_none_or(|limit| most <= limit)
                && self.seen.longest[gauge].is_some_and(|longest| longest.value >= most)
        })
    }

    /// Returns true if no gauge needs further measurements.
    pub(super) fn all_measured(&self) -> bool {
        let unbounded =
            |gauge: usize| matches!(self.gauges[gauge].how, MeasurementMode::Unbounded(_));
        (0..self.gauges.len()).all(|gauge| unbounded(gauge) || self.is_longest(gauge))
    }
}
