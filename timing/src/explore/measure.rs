//! Times measured by clocks: response times, and times between two events.

use super::rules::Rules;
use super::run::Run;
use super::state::{Frame, State, TaskStatus};
use super::watch::Watch;
use crate::system::Ticks;

/// The subject of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Timing {
    /// The response time of a task.
    Response(usize),
    /// The time until the obligation of an observer is met.
    Within(usize),
}

impl Timing {
    /// Returns the clock of the measurement in a state, if there is one.
    pub(in crate::explore) fn clock(self, l: &Frame, s: &State) -> Option<usize> {
        match self {
            Timing::Response(task) => l.response[task],
            Timing::Within(observer) => l.observer_clock(s, observer),
        }
    }

    /// Returns the number of obligations as old as the measured one, including that one. If the number
    /// decreases, another obligation may have replaced the measured one. It never increases.
    fn as_old(self, l: &Frame, s: &State) -> usize {
        let Timing::Within(observer) = self else {
            return 0;
        };
        let oldest = l.observer_clock(s, observer).map(|clock| s.t[clock]);
        let open = l.stages(observer).filter(|&stage| l.is_open_at(s, stage));
        let ages = open.map(|stage| l.stage_clock(stage).map(|clock| s.t[clock]));
        ages.filter(|&age| age == oldest).count()
    }

    /// Returns the present age of the measured obligation in base units, the number of obligations of that
    /// age, and if a measured job has its core.
    pub(super) fn age(self, rules: &Rules, s: &State) -> (Ticks, usize, bool) {
        let l = rules.frame();
        let clock = self.clock(l, s);
        let has_core = match self {
            Timing::Response(task) => rules.job(s, task) == TaskStatus::Running,
            Timing::Within(_) => false,
        };
        (clock.map_or(0, |clock| s.t[clock]), self.as_old(l, s), has_core)
    }

    /// Returns true if the measurement runs in a state.
    pub(super) fn runs(self, rules: &Rules, s: &State) -> bool {
        match self {
            Timing::Response(task) => rules.job(s, task) != TaskStatus::Idle,
            Timing::Within(observer) => rules.frame().is_open(s, observer),
        }
    }
}

/// A measured time, with its limits in base units.
#[derive(Debug, Clone)]
pub(super) struct Gauge {
    pub(super) of: Timing,
    /// Limit of the check.
    pub(super) limit: Option<Ticks>,
    /// Upper bound, if analysis knows one.
    pub(super) most: Option<Ticks>,
    pub(super) how: MeasurementMode,
    /// Run that exceeds the limit, from an earlier exploration.
    pub(super) excess: Option<Run>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum MeasurementMode {
    /// In the same exploration as others.
    Shared,
    /// In an exploration of its own, later, because the time grew suspiciously.
    Alone,
    /// In an exploration of its own, until the run repeats itself.
    UntilRepetition,
    /// Finished: this run proves that there is no bound.
    Unbounded(Run),
}

impl Gauge {
    /// Returns the gauges of a [`Watch`]: first responses, then pairs of predicates.
    pub(super) fn of(watch: &Watch, how: &MeasurementMode) -> Vec<Gauge> {
        let responses = watch.response.iter();
        let responses = responses.map(|response| {
            (Timing::Response(usize::from(response.task)), response.limit, response.most)
        });
        let withins = watch.within.iter().enumerate();
        let withins = withins.map(|(i, bound)| (Timing::Within(i), bound.limit, None));
        responses
            .chain(withins)
            .map(|(of, limit, most)| Gauge { of, limit, most, how: how.clone(), excess: None })
            .collect()
    }

    /// Returns true if the gauge is measured in the next exploration.
    pub(super) fn active(&self) -> bool {
        matches!(self.how, MeasurementMode::Shared | MeasurementMode::UntilRepetition)
    }

    pub(super) fn note(&mut self, diverging: Divergence) {
        self.how = diverging.proof.map_or(MeasurementMode::Alone, MeasurementMode::Unbounded);
        self.excess = self.excess.take().or(diverging.excess);
    }
}

/// A time that grows, with a run that proves that the time has no bound. Without a run, this is only
/// suspected.
#[derive(Debug, Clone)]
pub(super) struct Divergence {
    pub(super) gauge: usize,
    pub(super) proof: Option<Run>,
    /// Run that exceeds the limit.
    pub(super) excess: Option<Run>,
}
