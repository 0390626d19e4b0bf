//! What is watched while states are explored: when it has been seen, and how long it lasts.

use super::trace::Goal;
use super::{LOOKS, Longest, Search, Sight};
use crate::explore::findings::{Bound, Findings, Found, Measured};
use crate::explore::measure::{Diverging, Gauge, How, Timing};
use crate::explore::observe;
use crate::explore::reductions::{Reduced, Reductions};
use crate::explore::rules::Action;
use crate::explore::run::Run;
use crate::explore::state::{State, TaskStatus};
use crate::explore::watch::Stop;
use crate::system::Ticks;

/// Steps for which an exploration that has answered everything goes on, to see requests that are refused.
const LINGER: u64 = 20_000;

impl<R: Reduced> Search<'_, R> {
    /// Whether everything that is asked has been seen, or caught.
    pub(super) fn answered(&self) -> bool {
        let unbounded = |it: usize| matches!(self.gauges[it].how, How::Unbounded(_));
        (0..self.gauges.len()).all(|it| unbounded(it) || self.is_longest(it))
            && (!self.watch.deadlock || self.deadlock.is_some() || self.never_deadlocked())
            && self.all_caught()
    }

    /// Whether to go on for a while when everything is answered: what was only caught may be seen earlier,
    /// and requests may turn out to be refused.
    pub(super) fn goes_on(&mut self) -> bool {
        let refusals = self.rules.system().may_refuse() && !self.is_proved();
        let until = match self.until {
            Some(it) => it,
            None => {
                let mut further = if refusals { LINGER } else { 0 };
                if self.may_end_earlier() {
                    further = self.further();
                    self.chase_earlier(further);
                    self.tell_later();
                }
                *self.until.insert(self.steps + further)
            }
        };
        self.steps < until && (refusals || self.may_end_earlier())
    }

    /// Whether the longest time of a gauge has been seen, and nothing else is wanted of it.
    pub(super) fn is_longest(&self, gauge: usize) -> bool {
        let it = &self.gauges[gauge];
        it.most.is_some_and(|most| {
            it.active()
                && it.limit.is_none_or(|limit| most <= limit)
                && self.longest[gauge].is_some_and(|it| it.value >= most)
        })
    }

    /// Nothing will happen after a node: whatever is measured there has no bound.
    pub(super) fn waits_forever(&mut self, s: &State, at: Sight) {
        if self.diverging.is_some() {
            return;
        }
        let gauge = (0..self.gauges.len()).find(|&it| self.measures(it, s).is_some());
        if let Some(gauge) = gauge {
            self.limits_in_jump(s, at.parent, Ticks::MAX);
            self.diverging = Some(Diverging {
                gauge,
                proof: Some(self.trace(at, &Goal::Deadlock)),
                excess: None,
            });
        }
    }

    /// Looks at a state that was just entered.
    pub(super) fn check(&mut self, before: Option<&State>, s: &State, at: Sight) {
        for (i, &task) in self.watch.schedulable.iter().enumerate() {
            if self.missed[i].is_none() && self.rules.missed(s, task) {
                for it in self
                    .reductions
                    .orbits()
                    .alike(task, &self.watch.schedulable)
                {
                    self.missed[it] = Some(at);
                }
                if self.watch.stop_at_first {
                    self.stopped = Some(Stop::Answered);
                }
            }
        }
        for (i, it) in self.watch.reach.iter().enumerate() {
            if self.reached[i].is_none() && observe::predicate(&self.rules, before, s, it) {
                self.reached[i] = Some(at);
            }
        }
        for i in 0..self.gauges.len() {
            self.opened_late(i, s, at);
        }
        for (i, gauge) in self.gauges.iter().enumerate() {
            if self.longest[i].is_none()
                && (gauge.of.runs(&self.rules, s) || self.is_answered_at_once(before, s, gauge.of))
            {
                for it in self.alike(i) {
                    self.longest[it] = Some(Longest { value: 0, at });
                }
            }
        }
    }

    /// An age is seen when what has it becomes visible, which may be for no time at all; its clock has run
    /// before.
    fn opened_late(&mut self, gauge: usize, s: &State, at: Sight) {
        if !matches!(self.gauges[gauge].of, Timing::Within(_)) {
            return;
        }
        let Some(value) = self.measures(gauge, s).map(|clock| s.t[clock]) else {
            return;
        };
        if value > 0 && self.longest[gauge].is_none_or(|it| it.value < value) {
            self.longest[gauge] = Some(Longest { value, at });
        }
        let exceeds = self.gauges[gauge].limit.is_some_and(|limit| value > limit);
        if exceeds && self.excess[gauge].is_none_or(|it| at.time < it.time) {
            self.excess[gauge] = Some(at);
        }
    }

    /// Whether what a time is measured from has just happened, and what it is measured to holds: no time at
    /// all.
    pub(super) fn is_answered_at_once(
        &self,
        before: Option<&State>,
        s: &State,
        of: Timing,
    ) -> bool {
        let Timing::Within(observer) = of else {
            return false;
        };
        let trigger = &self.observers[observer].trigger;
        let was = before.is_some_and(|it| trigger.eval_still(&|a| self.rules.atom(it, a)));
        !was && observe::predicate(&self.rules, before, s, trigger)
    }

    /// Gauges of what is not told apart, itself included.
    pub(super) fn alike(&self, gauge: usize) -> Vec<usize> {
        let it = &self.gauges[gauge];
        let Timing::Response(task) = it.of else {
            return vec![gauge];
        };
        let orbit = self.reductions.orbits().of_task(task);
        let same = |other: &Gauge| {
            let alike = matches!(other.of, Timing::Response(task) if orbit.contains(&task));
            alike && (other.limit, other.most) == (it.limit, it.most)
        };
        (0..self.gauges.len())
            .filter(|&other| same(&self.gauges[other]))
            .collect()
    }

    /// What has been found of one gauge holds for all that are not told apart.
    pub(super) fn of_all_alike(&self, found: Diverging) -> Vec<(usize, Diverging)> {
        let Timing::Response(from) = self.gauges[found.gauge].of else {
            return vec![(found.gauge, found)];
        };
        let of = |gauge: usize| {
            let Timing::Response(to) = self.gauges[gauge].of else {
                return (gauge, found.clone());
            };
            let run = |it: &Option<Run>| it.as_ref().map(|it| self.exchanged(it, from, to));
            let renamed = Diverging {
                gauge,
                proof: run(&found.proof),
                excess: run(&found.excess),
            };
            (gauge, renamed)
        };
        self.alike(found.gauge).into_iter().map(of).collect()
    }

    /// A run with one task in the place of another that is not told apart from it.
    pub(super) fn exchanged(&self, run: &Run, from: usize, to: usize) -> Run {
        let renaming = self.reductions.orbits().exchange(from, to);
        let steps = run.steps.iter();
        Run {
            steps: steps
                .map(|&(time, it)| (time, renaming.action(it)))
                .collect(),
            ..run.clone()
        }
    }

    /// The clock of a gauge, if it measures now.
    pub(super) fn measures(&self, gauge: usize, s: &State) -> Option<usize> {
        let (l, of) = (self.rules.frame(), self.gauges[gauge].of);
        let other = matches!(of, Timing::Response(task) if self.waiting_only[task]);
        of.clock(l, s).filter(|_| !other && of.runs(&self.rules, s))
    }

    /// Notes the limits that are exceeded in a jump from a node, and when. The first moment counts, and jumps
    /// overlap.
    pub(super) fn limits_in_jump(&mut self, s: &State, parent: u32, jump: Ticks) {
        for i in 0..self.gauges.len() {
            let (Some(limit), Some(clock)) = (self.gauges[i].limit, self.measures(i, s)) else {
                continue;
            };
            // Clocks beyond the limit were seen when they passed it.
            let Some(left) = limit.checked_sub(s.t[clock]).filter(|&it| it < jump) else {
                continue;
            };
            let time = self.nodes[parent as usize].time + u64::from(left) + 1;
            if self.excess[i].is_none_or(|it| time < it.time) {
                for it in self.alike(i) {
                    self.excess[it] = Some(Sight { parent, time });
                }
            }
        }
    }

    /// The same for the jumps that have begun when the exploration ends.
    pub(super) fn limits_under_way(&mut self) {
        if self.gauges.iter().all(|it| it.limit.is_none()) {
            return;
        }
        for (time, parents) in std::mem::take(&mut self.queue) {
            for (i, parent) in parents.into_iter().enumerate() {
                if i % LOOKS == 0 && self.cancel.is_abandoned() {
                    return;
                }
                let s = self.node_state(parent);
                let jump = (time - self.nodes[parent as usize].time) as Ticks;
                self.limits_in_jump(&s, parent, jump);
            }
        }
    }

    pub(super) fn excess_run(&self, gauge: usize) -> Option<Run> {
        let Gauge { of, limit, .. } = self.gauges[gauge];
        Some(self.trace(self.excess[gauge]?, &Goal::Lasts(of, limit? + 1)))
    }

    /// Looks at tasks that an action makes wait for a core: where a job counts from a tick that was kept, it
    /// may be overdue from the first moment on.
    pub(super) fn overdue_at_once(&mut self, s: &State, action: Action, at: Sight) {
        for (i, &task) in self.watch.overdue.iter().enumerate() {
            let begins = self.rules.may_begin_to_wait(action, task);
            if begins && self.overdue[i].is_none() && self.rules.overdue(s, task) {
                for it in self.reductions.orbits().alike(task, &self.watch.overdue) {
                    self.overdue[it] = Some(at);
                }
            }
        }
    }

    /// Looks at clocks after time has passed.
    pub(super) fn clocks_after_jump(&mut self, s: &mut State, at: Sight) -> Option<Diverging> {
        for (i, &task) in self.watch.overdue.iter().enumerate() {
            if self.overdue[i].is_none() && self.rules.overdue(s, task) {
                for it in self.reductions.orbits().alike(task, &self.watch.overdue) {
                    self.overdue[it] = Some(at);
                }
            }
            if self.waiting_only[task]
                && let Some(clock) = self.rules.frame().response[task]
            {
                let running = self.rules.job(s, task) == TaskStatus::Running;
                let most = self.rules.system().tasks[task].period.unwrap_or(0);
                s.t[clock] = if running { 0 } else { s.t[clock].min(most) };
            }
        }
        for i in 0..self.gauges.len() {
            let Some(clock) = self.measures(i, s) else {
                continue;
            };
            let value = s.t[clock];
            if self.longest[i].is_some_and(|it| it.value >= value) {
                continue;
            }
            for it in self.alike(i) {
                self.longest[it] = Some(Longest { value, at });
            }
            if value <= self.patience || self.out_of_bounds() {
                continue;
            }
            self.patience = self.patience.saturating_mul(2);
            let run = self.trace(at, &Goal::Lasts(self.gauges[i].of, value));
            let mut out = Diverging {
                gauge: i,
                proof: None,
                excess: None,
            };
            let recent = (&self.observers[..], value);
            let of = self.gauges[i].of;
            let age = |s: &State| of.age(self.rules.frame(), s);
            if let Some(cycle) = run.repetition(&self.rules, recent, &age, self.cancel) {
                let limit = self.gauges[i].limit;
                let left = limit.and_then(|it| it.checked_sub(value));
                out.excess = left.and_then(|it| run.prolonged(cycle, it + 1));
                out.proof = Some(run.repeating(cycle));
                return Some(out);
            }
            if !self.patient && !self.cancel.is_abandoned() {
                return Some(out);
            }
        }
        None
    }

    /// What is known of each gauge.
    pub(super) fn measured(&self) -> Vec<Option<Measured>> {
        let found = |run| Found { run };
        (0..self.gauges.len())
            .map(|i| {
                let gauge = &self.gauges[i];
                let excess = gauge
                    .excess
                    .clone()
                    .or_else(|| self.excess_run(i))
                    .map(found);
                if let How::Unbounded(run) = &gauge.how {
                    return Some(Measured {
                        bound: Bound::Unbounded,
                        longest: found(run.clone()),
                        excess,
                    });
                }
                let (reached, limit) = (self.longest[i].map(|it| it.value), gauge.limit);
                if let (Some(run), Some(limit)) =
                    (&gauge.excess, limit.filter(|it| reached <= Some(*it)))
                {
                    // Known from an exploration before, which this one has not come up with.
                    return Some(Measured {
                        bound: Bound::Finite(limit + 1),
                        longest: found(run.clone()),
                        excess,
                    });
                }
                self.longest[i].map(|it| Measured {
                    bound: Bound::Finite(it.value),
                    longest: found(self.trace(it.at, &Goal::Lasts(gauge.of, it.value))),
                    excess,
                })
            })
            .collect()
    }

    /// Services of which a request was refused.
    pub(super) fn refused(&self) -> Vec<usize> {
        let beside = |it: usize| {
            self.hunt
                .as_ref()
                .is_some_and(|hunt| hunt.refused.contains(&it))
        };
        (0..self.rules.system().services.len())
            .filter(|&service| {
                let mut orbit = self.reductions.orbits().of_service(service).iter();
                orbit.any(|&it| self.rules.has_refused(it) || beside(it))
                    || self.refused_in_zones(service)
            })
            .collect()
    }

    /// What was seen of what a single state shows: the lists of a watch of ticks that come too early, tasks
    /// that wait too long, and predicates, numbered in this order.
    pub(super) fn sights(&self) -> [&[Option<Sight>]; 3] {
        [&self.missed, &self.overdue, &self.reached]
    }

    /// Something for each place of these lists.
    pub(super) fn for_each<T>(&self, it: impl Fn(usize, usize) -> T) -> [Vec<T>; 3] {
        let sights = self.sights();
        [0, 1, 2].map(|list| (0..sights[list].len()).map(|i| it(list, i)).collect())
    }

    /// The run to one of them, if it was seen.
    pub(super) fn seen_run(&self, list: usize, i: usize) -> Option<Run> {
        let goal = match list {
            0 => Goal::Missed(self.watch.schedulable[i]),
            1 => Goal::Overdue(self.watch.overdue[i]),
            _ => Goal::Reach(&self.watch.reach[i]),
        };
        self.sights()[list][i].map(|at| self.trace(at, &goal))
    }

    pub(super) fn findings(self) -> Findings {
        let hunt = self.hunt.as_ref();
        let [missed, overdue, reached] = self.for_each(|list, i| {
            let caught = || Some(hunt?.caught(list, i)?.run.clone());
            let run = self.seen_run(list, i).or_else(caught)?;
            Some(Found { run })
        });
        let mut response = self.measured();
        let within = response.split_off(self.watch.response.len());
        Findings {
            missed,
            overdue,
            response,
            reached,
            within,
            never: (0..self.watch.reach.len())
                .map(|it| self.never_reached(it))
                .collect(),
            no_deadlock: self.never_deadlocked(),
            deadlock: self
                .deadlock
                .filter(|_| self.watch.deadlock)
                .map(|at| Found {
                    run: self.trace(at, &Goal::Deadlock),
                }),
            refused: self.refused(),
            restarts: (0..self.rules.system().services.len())
                .filter(|&it| self.rules.has_ended_restarts(it))
                .collect(),
            reductions: vec![self.activities()],
            states: self.states(),
            steps: self.effort(),
            bytes: (hunt.map_or(0, |it| it.bytes))
                .max(self.proof.as_ref().map_or(0, |it| it.bytes))
                .max(self.memory()),
            // Nothing is left to be looked at, even if it was looked at in zones.
            stopped: self
                .stopped
                .filter(|&it| it != Stop::Answered || !self.is_proved()),
        }
    }
}
