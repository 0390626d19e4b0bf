//! The supervisor: the division of effort between strategies, the end of an exploration, and intermediate
//! findings.
//!
//! Layers get most of the effort, and poll the supervisor every few steps ([`Overseer::look`]). It runs
//! randomised search ([`hunt`]) and zones ([`zones`](super::zones)) in between.

mod endless;
mod hunt;
mod news;

pub(super) use self::news::Teller;

use self::hunt::Hunt;
use self::news::News;
use super::goals::GoalId;
use super::layers::trace::Target;
use super::layers::{Layers, Overseer};
use super::zones::{self, Proof, Proving};
use crate::explore::findings::{Bound, Findings, Found, Measured};
use crate::explore::measure::How;
use crate::explore::reductions::{Activity, Kind, Reason, Reduced};
use crate::explore::rules::Rules;
use crate::explore::run::Run;
use crate::explore::watch::{Limits, Stop, Watch};

/// Number of further steps after all checks are answered, to see requests that are refused.
const LINGER: u64 = 20_000;

/// The strategies of one exploration, and the receiver of findings.
pub(super) struct Supervisor<'a, R: Reduced> {
    /// Randomised search, or the reason against it.
    hunt: Result<Hunt, Reason>,
    /// Search in zones, or the reason against it.
    proving: Proving<'a, R>,
    news: Option<News<'a>>,
    /// Number of steps at which an answered exploration ends.
    until: Option<u64>,
}

/// The results of one exploration for the next one of the same system.
pub(super) struct Legacy {
    hunt: Result<Hunt, Reason>,
    zones: Result<Option<Proof>, Reason>,
}

impl Legacy {
    /// Returns the input of the first exploration.
    pub(super) fn none<R: Rules>(rules: &R, watch: &Watch, limits: Limits) -> Legacy {
        Legacy {
            hunt: hunt::suits(watch, limits).map(|()| Hunt::new(watch)),
            zones: zones::suit(rules.system(), watch, limits).map(|()| None),
        }
    }
}

impl<'a, R: Reduced> Overseer<'a, R> for Supervisor<'a, R> {
    fn look(&mut self, layers: &mut Layers<'a, R>) -> bool {
        let states = layers.states_now() + self.states_beside();
        let memory = layers.memory() + self.proving.bytes();
        let reason = Stop::reason(states, memory, layers.limits, layers.cancel);
        let too_many = (layers.steps > layers.limits.steps).then_some(Stop::States);
        if let Some(reason) = reason.or(too_many) {
            layers.stopped = Some(reason);
            return true;
        }
        self.hunt_if_due(layers);
        self.proving.work_if_due(layers);
        if self.answered(layers) && !self.goes_on(layers) {
            layers.stopped = Some(Stop::Answered);
        } else {
            self.tell_news(layers);
        }
        layers.stopped.is_some() || layers.diverging.is_some()
    }

    fn end(&mut self, layers: &mut Layers<'a, R>) {
        if layers.stopped == Some(Stop::States) && self.may_end_earlier(layers) {
            self.chase_earlier(layers, self.further(layers));
        }
    }
}

impl<'a, R: Reduced> Supervisor<'a, R> {
    /// Supervises an exploration, with the results of the previous one.
    pub(super) fn new(legacy: Legacy, teller: Teller<'a>) -> Self {
        Supervisor {
            hunt: legacy.hunt,
            proving: Proving::new(legacy.zones),
            news: Some(News::new(teller)),
            until: None,
        }
    }

    /// Returns the results for the next exploration of the same system, including the runs seen by this one.
    pub(super) fn hand_on(self, layers: &Layers<'a, R>) -> Legacy {
        let Supervisor { hunt, proving, .. } = self;
        Legacy {
            hunt: hunt.map(|it| it.handed_on(layers)),
            zones: proving.into_proof(),
        }
    }

    // ---- Division of effort ----------------------------------------------------------------

    /// Returns true if all questions are answered, by layers or by randomised search.
    fn answered(&self, layers: &Layers<'a, R>) -> bool {
        let deadlock = layers.watching.watch.deadlock;
        layers.watching.all_measured()
            && (!deadlock || layers.deadlock.is_some() || self.proving.never_deadlocked())
            && self.all_caught(layers)
    }

    /// Returns true if an answered exploration continues for a while: a run of randomised search may be found
    /// earlier, and requests may turn out to be refused.
    fn goes_on(&mut self, layers: &mut Layers<'a, R>) -> bool {
        let may_refuse = layers.watching.rules.system().may_refuse();
        let refusals = may_refuse && !self.proving.is_done();
        let until = match self.until {
            Some(it) => it,
            None => {
                let mut further = if refusals { LINGER } else { 0 };
                if self.may_end_earlier(layers) {
                    further = self.further(layers);
                    self.chase_earlier(layers, further);
                    self.tell_later();
                }
                *self.until.insert(layers.steps + further)
            }
        };
        layers.steps < until && (refusals || self.may_end_earlier(layers))
    }

    /// Returns the number of states examined outside the layers.
    pub(super) fn states_beside(&self) -> usize {
        self.hunt.as_ref().map_or(0, |it| it.states) + self.proving.states()
    }

    /// Returns the number of steps so far, including those of randomised search and of zones.
    pub(super) fn effort(&self, layers: &Layers<'a, R>) -> u64 {
        let hunted = self.hunt.as_ref().map_or(0, |it| it.steps);
        layers.steps + self.proving.steps() + hunted
    }

    /// Returns the number of states kept, or examined outside the layers.
    pub(super) fn states(&self, layers: &Layers<'a, R>) -> usize {
        layers.states() + self.states_beside()
    }

    // ---- Findings --------------------------------------------------------------------------

    /// Returns true if a goal is certainly never reached.
    pub(super) fn is_never(&self, layers: &Layers<'a, R>, goal: GoalId) -> bool {
        match layers.watching.goals.predicate(goal) {
            Some(predicate) => self.proving.never_reached(predicate),
            // Systems treated by zones have no periodic tasks, so that no deadline is missed.
            None => self.proving.is_done(),
        }
    }

    /// Returns, by predicate of the watch, whether the predicate is certainly never reached.
    fn never(&self, watch: &Watch) -> Vec<bool> {
        let all = 0..watch.reach.len();
        all.map(|it| self.proving.never_reached(it)).collect()
    }

    /// Returns the services with a refused request.
    fn refused(&self, layers: &Layers<'a, R>) -> Vec<usize> {
        let beside = |it: usize| {
            self.hunt
                .as_ref()
                .is_ok_and(|hunt| hunt.refused.contains(&it))
        };
        let orbits = |it: usize| {
            use crate::explore::reductions::Reductions;
            layers.watching.reductions.orbits().of_service(it)
        };
        (0..layers.watching.rules.system().services.len())
            .filter(|&service| {
                layers.watching.has_refused(service)
                    || orbits(service).iter().any(|&it| beside(it))
                    || self.proving.refused(service)
            })
            .collect()
    }

    /// Returns the finding for each gauge.
    fn measured(layers: &Layers<'a, R>) -> Vec<Option<Measured>> {
        let found = |run| Found { run };
        let of = |i: usize| {
            let gauge = &layers.watching.gauges[i];
            let excess = gauge.excess.clone().or_else(|| layers.excess_run(i));
            let excess = excess.map(found);
            if let How::Unbounded(run) = &gauge.how {
                return Some(Measured {
                    bound: Bound::Unbounded,
                    longest: found(run.clone()),
                    excess,
                });
            }
            let longest = layers.watching.seen.longest[i];
            let (reached, limit) = (longest.map(|it| it.value), gauge.limit);
            if let (Some(run), Some(limit)) =
                (&gauge.excess, limit.filter(|it| reached <= Some(*it)))
            {
                // Found by an earlier exploration, but not by this one.
                return Some(Measured {
                    bound: Bound::Finite(limit + 1),
                    longest: found(run.clone()),
                    excess,
                });
            }
            longest.map(|it| Measured {
                bound: Bound::Finite(it.value),
                longest: found(layers.trace(it.at, &Target::Lasts(gauge.of, it.value))),
                excess,
            })
        };
        (0..layers.watching.gauges.len()).map(of).collect()
    }

    /// Returns the reductions and further strategies used.
    fn activities(&self, layers: &Layers<'a, R>) -> Vec<Activity> {
        let beside = [
            (Kind::Zones, self.proving.unsuited()),
            (Kind::RandomSearch, self.hunt.as_ref().err().copied()),
        ];
        let beside = beside.map(|(kind, off)| Activity { kind, off });
        layers.activities().chain(beside).collect()
    }

    /// Returns the findings of the exploration.
    pub(super) fn findings(self, layers: &Layers<'a, R>) -> Findings {
        let watch = layers.watching.watch;
        let goals = &layers.watching.goals;
        let hunt = self.hunt.as_ref().ok();
        let [missed, overdue, reached] = goals.split(goals.each(|goal| {
            let caught = || Some(hunt?.caught(goal)?.run.clone());
            let run: Run = layers.run_to(goal).or_else(caught)?;
            Some(Found { run })
        }));
        let mut response = Self::measured(layers);
        let within = response.split_off(watch.response.len());
        let services = 0..layers.watching.rules.system().services.len();
        let restarts = services.filter(|&it| layers.watching.rules.has_ended_restarts(it));
        let deadlock = layers.deadlock.filter(|_| watch.deadlock);
        Findings {
            missed,
            overdue,
            response,
            reached,
            within,
            never: self.never(watch),
            absent: (self.proving.absent())
                .map_or_else(|| layers.watching.seen.absent.clone(), Clone::clone),
            no_deadlock: self.proving.never_deadlocked(),
            deadlock: deadlock.map(|at| Found {
                run: layers.trace(at, &Target::Deadlock),
            }),
            refused: self.refused(layers),
            restarts: restarts.collect(),
            reductions: vec![self.activities(layers)],
            states: self.states(layers),
            steps: self.effort(layers),
            bytes: (hunt.map_or(0, |it| it.bytes))
                .max(self.proving.bytes_in_the_end())
                .max(layers.memory() + self.proving.bytes()),
            // All states have been examined, possibly with zones.
            stopped: layers
                .stopped
                .filter(|&it| it != Stop::Answered || !self.proving.is_done()),
        }
    }
}
