//! Times that are measured by clocks: response times, and times from one event to another.

use super::rules::Rules;
use super::run::Run;
use super::state::{Frame, State, TaskStatus};
use super::watch::Watch;
use crate::system::Ticks;

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Timing {
    /// The response time of a task.
    Response(usize),
    /// The time until an observer is answered.
    Within(usize),
}

impl Timing {
    /// The clock that measures it in a state, if there is one.
    pub(in crate::explore) fn clock(self, l: &Frame, s: &State) -> Option<usize> {
        match self {
            Timing::Response(task) => l.response[task],
            Timing::Within(observer) => l.observer_clock(s, observer),
        }
    }

    /// The task whose response time it is.
    pub(super) fn task(self) -> Option<usize> {
        match self {
            Timing::Response(task) => Some(task),
            Timing::Within(_) => None,
        }
    }

    /// How many obligations are as old as the one that is measured, itself included. When they become fewer,
    /// another may have taken its place; they never become more.
    fn as_old(self, l: &Frame, s: &State) -> usize {
        let Timing::Within(observer) = self else {
            return 0;
        };
        let oldest = l.observer_clock(s, observer).map(|clock| s.t[clock]);
        let open = l.stages(observer).filter(|&it| l.is_open_at(s, it));
        let ages = open.map(|it| l.stage_clock(it).map(|clock| s.t[clock]));
        ages.filter(|&it| it == oldest).count()
    }

    /// How long it has lasted in a state, and how many obligations are as old.
    pub(super) fn age(self, l: &Frame, s: &State) -> (Ticks, usize) {
        let clock = self.clock(l, s);
        (clock.map_or(0, |clock| s.t[clock]), self.as_old(l, s))
    }

    /// Whether it is being measured in a state.
    pub(super) fn runs<R: Rules>(self, rules: &R, s: &State) -> bool {
        match self {
            Timing::Response(task) => rules.job(s, task) != TaskStatus::Idle,
            Timing::Within(observer) => rules.frame().is_open(s, observer),
        }
    }
}

/// A time that is asked for.
#[derive(Debug, Clone)]
pub(super) struct Gauge {
    pub(super) of: Timing,
    /// What it must not exceed.
    pub(super) limit: Option<Ticks>,
    /// What it never exceeds, where that is known.
    pub(super) most: Option<Ticks>,
    pub(super) how: How,
    /// A run that exceeds the limit, from an exploration that has ended.
    pub(super) excess: Option<Run>,
}

/// How a time is measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum How {
    /// Together with others.
    Shared,
    /// Not now, as it grew suspiciously; later on its own.
    Alone,
    /// On its own, until it repeats itself.
    Patient,
    /// No more, as this run proves that there is no bound.
    Unbounded(Run),
}

impl Gauge {
    /// What a [`Watch`] asks for: responses, then the others.
    pub(super) fn of(watch: &Watch, how: &How) -> Vec<Gauge> {
        let responses = watch.response.iter();
        let responses = responses.map(|it| (Timing::Response(it.task), it.limit, it.most));
        let withins = watch.within.iter().enumerate();
        let withins = withins.map(|(i, it)| (Timing::Within(i), it.limit, None));
        responses
            .chain(withins)
            .map(|(of, limit, most)| Gauge {
                of,
                limit,
                most,
                how: how.clone(),
                excess: None,
            })
            .collect()
    }

    /// Whether it is measured in the next exploration.
    pub(super) fn active(&self) -> bool {
        matches!(self.how, How::Shared | How::Patient)
    }

    pub(super) fn note(&mut self, diverging: Diverging) {
        self.how = diverging.proof.map_or(How::Alone, How::Unbounded);
        self.excess = self.excess.take().or(diverging.excess);
    }
}

/// A time that grows, with a run that proves that it has no bound; without one it is only suspected.
#[derive(Debug, Clone)]
pub(super) struct Diverging {
    pub(super) gauge: usize,
    pub(super) proof: Option<Run>,
    /// A run that exceeds the limit.
    pub(super) excess: Option<Run>,
}
