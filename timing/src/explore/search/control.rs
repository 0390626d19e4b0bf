//! The search control: the division of effort between strategies, the end of an exploration, and intermediate
//! findings.
//!
//! Layers get most of the effort, and poll the search control every few steps ([`PollControl::look`]). It
//! runs randomised search ([`random_search`]) in between.

mod interim;
mod random_search;
mod unbounded;

pub(super) use self::interim::FindingsReceiver;

use self::interim::InterimFindings;
use self::random_search::RandomSearch;
use super::layers::trace::Target;
use super::layers::{Layers, PollControl};
use crate::explore::ChainSpans;
use crate::explore::findings::{Bound, Findings, Measured};
use crate::explore::measure::MeasurementMode;
use crate::explore::reductions::{Activity, Kind, Reason};
use crate::explore::run::Run;
use crate::explore::watch::{Limits, Stop, Watch};
use crate::system::ServiceId;

/// Number of further steps after all checks are answered, to see requests that are refused.
const STEPS_AFTER_ANSWERS: u64 = 20_000;

/// The strategies of one exploration, and the receiver of findings.
pub(super) struct SearchControl<'a> {
    /// Randomised search, or the reason against it.
    random_search: Result<RandomSearch, Reason>,
    news: Option<InterimFindings<'a>>,
    /// Number of steps at which an answered exploration ends.
    until: Option<u64>,
}

/// The results of one exploration for the next one of the same system.
pub(super) struct CarryOver {
    random_search: Result<RandomSearch, Reason>,
}

impl CarryOver {
    /// Returns the input of the first exploration.
    pub(super) fn none(watch: &Watch, limits: Limits) -> CarryOver {
        CarryOver {
            random_search: random_search::check_suitable(watch, limits)
                .map(|()| RandomSearch::new(watch)),
        }
    }
}

impl<'a> PollControl<'a> for SearchControl<'a> {
    fn look(&mut self, layers: &mut Layers<'a>) -> bool {
        let states = layers.states_now() + self.states_outside_layers();
        let reason = Stop::reason(states, layers.memory(), layers.limits, layers.cancel);
        let too_many = (layers.steps > layers.limits.steps).then_some(Stop::States);
        if let Some(reason) = reason.or(too_many) {
            layers.stopped = Some(reason);
            return true;
        }
        self.search_if_due(layers);
        if self.answered(layers) && !self.continues(layers) {
            layers.stopped = Some(Stop::Answered);
        } else {
            self.report_interim(layers);
        }
        layers.stopped.is_some() || layers.diverging.is_some()
    }

    fn end(&mut self, layers: &mut Layers<'a>) {
        if layers.stopped == Some(Stop::States) && self.may_find_earlier_end(layers) {
            self.search_earlier_ends(layers, self.further(layers));
        }
    }
}

impl<'a> SearchControl<'a> {
    /// Controls an exploration, with the results of the previous one.
    pub(super) fn new(carry_over: CarryOver, receiver: FindingsReceiver<'a>) -> Self {
        SearchControl {
            random_search: carry_over.random_search,
            news: Some(InterimFindings::new(receiver)),
            until: None,
        }
    }

    /// Returns the results for the next exploration of the same system, including the runs seen by this one.
    pub(super) fn into_carry_over(self, layers: &Layers<'a>) -> CarryOver {
        CarryOver { random_search: self.random_search.map(|search| search.carried_over(layers)) }
    }

    // ---- Division of effort ----------------------------------------------------------------

    /// Returns true if all questions are answered, by layers or by randomised search.
    fn answered(&self, layers: &Layers<'a>) -> bool {
        let deadlock = layers.observations.watch.deadlock;
        layers.observations.all_measured()
            && (!deadlock || layers.deadlock.is_some())
            && self.all_found(layers)
    }

    /// Returns true if an answered exploration continues for a while: a run of randomised search may be found
    /// earlier, and requests may turn out to be refused.
    fn continues(&mut self, layers: &mut Layers<'a>) -> bool {
        let refusals = layers.observations.rules.system().may_refuse();
        let until = if let Some(number) = self.until {
            number
        } else {
            let mut further = if refusals { STEPS_AFTER_ANSWERS } else { 0 };
            if self.may_find_earlier_end(layers) {
                further = self.further(layers);
                self.search_earlier_ends(layers, further);
                self.postpone_reports();
            }
            *self.until.insert(layers.steps + further)
        };
        layers.steps < until && (refusals || self.may_find_earlier_end(layers))
    }

    /// Returns the number of states examined outside the layers.
    pub(super) fn states_outside_layers(&self) -> usize {
        self.random_search.as_ref().map_or(0, |search| search.states)
    }

    /// Returns the number of steps so far, including those of randomised search.
    pub(super) fn effort(&self, layers: &Layers<'a>) -> u64 {
        let random_steps = self.random_search.as_ref().map_or(0, |search| search.steps);
        layers.steps + random_steps
    }

    /// Returns the number of states kept, or examined outside the layers.
    pub(super) fn states(&self, layers: &Layers<'a>) -> usize {
        layers.states() + self.states_outside_layers()
    }

    // ---- Findings --------------------------------------------------------------------------

    /// Returns the services with a refused request.
    fn refused(&self, layers: &Layers<'a>) -> Vec<ServiceId> {
        let beside = |service: &ServiceId| {
            self.random_search.as_ref().is_ok_and(|search| search.refused.contains(service))
        };
        let rules = &layers.observations.rules;
        let services = rules.system().services.keys();
        services.filter(|service| rules.has_refused(*service) || beside(service)).collect()
    }

    /// Returns the finding for each gauge.
    fn measured(layers: &Layers<'a>) -> Vec<Option<Measured>> {
        let of = |i: usize| {
            let gauge = &layers.observations.gauges[i];
            let excess = gauge.excess.clone().or_else(|| layers.excess_run(i));
            if let MeasurementMode::Unbounded(run) = &gauge.how {
                return Some(Measured { bound: Bound::Unbounded, longest: run.clone(), excess });
            }
            let longest = layers.observations.seen.longest[i];
            let (reached, limit) = (longest.map(|longest| longest.value), gauge.limit);
            if let (Some(run), Some(limit)) =
                (&gauge.excess, limit.filter(|limit| reached <= Some(*limit)))
            {
                // Found by an earlier exploration, but not by this one.
                return Some(Measured {
                    bound: Bound::Finite(limit + 1),
                    longest: run.clone(),
                    excess,
                });
            }
            longest.map(|longest| Measured {
                bound: Bound::Finite(longest.value),
                longest: layers.trace(longest.at, &Target::Lasts(gauge.of, longest.value)),
                excess,
            })
        };
        (0..layers.observations.gauges.len()).map(of).collect()
    }

    /// Returns the reductions and further strategies used.
    fn activities(&self, layers: &Layers<'a>) -> Vec<Activity> {
        let random_search =
            Activity { kind: Kind::RandomSearch, off: self.random_search.as_ref().err().copied() };
        layers.activities().chain([random_search]).collect()
    }

    /// Returns the findings of the exploration.
    pub(super) fn findings(self, layers: &Layers<'a>) -> Findings {
        let watch = layers.observations.watch;
        let goals = &layers.observations.goals;
        let random_search = self.random_search.as_ref().ok();
        let [missed, overdue, reached] = goals.split(goals.each(|goal| {
            let found_run = || Some(random_search?.found_run(goal)?.run.clone());
            let run: Run = layers.run_to(goal).or_else(found_run)?;
            Some(run)
        }));
        let mut response = Self::measured(layers);
        let within = response.split_off(watch.response.len());
        let services = layers.observations.rules.system().services.keys();
        let restarts =
            services.filter(|&service| layers.observations.rules.has_ended_restarts(service));
        let deadlock = layers.deadlock.filter(|_| watch.deadlock);
        Findings {
            missed,
            overdue,
            response,
            reached,
            within,
            absent: layers.observations.seen.absent.clone(),
            chain: ChainSpans::default(),
            deadlock: deadlock.map(|at| layers.trace(at, &Target::Deadlock)),
            refused: self.refused(layers),
            restarts: restarts.collect(),
            hold_cores: layers.observations.seen.hold_cores.clone(),
            reductions: vec![self.activities(layers)],
            states: self.states(layers),
            steps: self.effort(layers),
            bytes: random_search.map_or(0, |search| search.bytes).max(layers.memory()),
            stopped: layers.stopped,
        }
    }
}
