//! Random search: randomised depth-first search for properties of single states.
//!
//! Breadth-first search finds short runs, but it examines all earlier events first. A failure that comes
//! late, or at a dense instant, is found late. So a small part of the effort goes to depth-first searches
//! (see [`DepthFirstSearch`]): many short ones, in different orders, because a search that has begun badly
//! hardly ever recovers. They prove nothing; their runs are as valid as any others.
//!
//! Such runs are longer than necessary. So before they are reported, breadth-first search continues, and
//! searches look for runs that end earlier. Both take as long as all steps so far, up to a limit. A reported
//! run is final. In a long search, runs are reported before its end.

use rustc_hash::FxHashSet;

use super::SearchControl;
use crate::explore::reductions::{Kind, Reason};
use crate::explore::run::Run;
use crate::explore::search::depth_first::{DepthFirstSearch, Order};
use crate::explore::search::goals::{GoalId, Goals, PerGoal};
use crate::explore::search::layers::Layers;
use crate::explore::search::observations::Observations;
use crate::explore::watch::{Limits, Stop, Watch};
use crate::system::ServiceId;

/// Steps after which a search counts as large.
const STEPS_OF_LARGE_SEARCH: u64 = 1000;

const STEPS_OF_SHORT_SEARCH: u64 = 1500;

/// Upper limit on the steps for each of the two searches for an earlier end.
const MAX_STEPS_FOR_EARLIER_END: u64 = 200_000;

/// The runs found so far, and the effort.
#[derive(Debug, Default)]
pub(super) struct RandomSearch {
    found_run: PerGoal<Option<FoundRun>>,
    /// Number of searches.
    pub(super) searches: u64,
    /// Steps of all searches.
    pub(super) steps: u64,
    /// States examined by all searches.
    pub(super) states: usize,
    /// Greatest number of bytes used by a search, including the breadth-first search.
    pub(super) bytes: usize,
    /// Services with a refused request.
    pub(super) refused: Vec<ServiceId>,
    /// All states have been examined.
    over: bool,
    /// The memory limit is reached.
    full: bool,
    /// Searches with longest times can find nothing more.
    not_late: bool,
    /// A search with longest times has found something.
    late: bool,
    /// Gauges of which all states have been examined.
    pub(super) bounded: FxHashSet<usize>,
    /// Number of steps of the search at which found runs are reported.
    report_at: Option<u64>,
}

/// A run of randomised search.
#[derive(Debug)]
pub(super) struct FoundRun {
    pub(super) run: Run,
    /// The run was reported: it is not replaced by a shorter one.
    pub(super) is_final: bool,
}

impl RandomSearch {
    pub(super) fn new(watch: &Watch) -> Self {
        RandomSearch { found_run: Goals::of(watch).each(|_| None), ..RandomSearch::default() }
    }

    /// Returns the number of steps of the next search: mostly few, because a lucky search needs few.
    fn length(&self) -> u64 {
        STEPS_OF_SHORT_SEARCH * luby(self.searches / Order::KINDS + 1)
    }

    /// Returns true if another search is due, after this many steps of the breadth-first search, at `dense`
    /// moments or not.
    fn is_due(&self, steps: u64, dense: bool) -> bool {
        let more = if dense { steps / 4 } else { steps / 128 };
        let share = STEPS_OF_SHORT_SEARCH + (steps / 4).min(STEPS_OF_SHORT_SEARCH) + more;
        steps >= STEPS_OF_LARGE_SEARCH
            && !self.over
            && !self.full
            && self.steps + self.length() <= share
    }

    /// Returns the order of the next search.
    pub(super) fn next_order(&mut self) -> Order {
        self.searches += 1;
        let mut order = Order::numbered(self.searches - 1);
        order.late &= !self.not_late;
        order
    }

    /// Records the runs of a search for some goals that are new or end earlier. Returns true if there are
    /// any.
    fn note(&mut self, goals: &[GoalId], found_run: impl Iterator<Item = Option<Run>>) -> bool {
        let mut any = false;
        for (&goal, run) in goals.iter().zip(found_run) {
            let place = &mut self.found_run[goal];
            if let Some(run) = run
                && place.as_ref().is_none_or(|place| run.end < place.run.end)
            {
                *place = Some(FoundRun { run, is_final: false });
                any = true;
            }
        }
        any
    }

    /// Returns the latest end of the runs to some goals.
    fn last_end(&self, goals: &[GoalId]) -> Option<u64> {
        let runs = goals.iter().filter_map(|&goal| self.found_run[goal].as_ref());
        runs.map(|run| run.run.end).max()
    }

    pub(super) fn found_run(&self, goal: GoalId) -> Option<&FoundRun> {
        self.found_run[goal].as_ref()
    }

    /// Returns the random search for the next exploration of the same system, including the runs seen by this
    /// one.
    pub(super) fn carried_over(mut self, layers: &Layers<'_>) -> RandomSearch {
        self.steps = 0;
        self.report_at = None;
        for goal in layers.observations.goals.ids() {
            if let Some(run) = layers.run_to(goal) {
                self.found_run[goal] = Some(FoundRun { run, is_final: true });
            }
        }
        self
    }
}

/// Checks that randomised depth-first search may find something.
///
/// # Errors
///
/// Returns the reason why it cannot.
pub(super) fn check_suitable(watch: &Watch, limits: Limits) -> Result<(), Reason> {
    if limits.without.contains(Kind::RandomSearch) {
        Err(Reason::SwitchedOff)
    } else if watch.in_order {
        Err(Reason::InOrder)
    } else {
        Ok(())
    }
}

impl<'a> SearchControl<'a> {
    /// Returns the `wanted` goals that are neither seen nor settled otherwise, depending on their found run.
    fn open_goals(
        &self,
        layers: &Layers<'a>,
        wanted: impl Fn(Option<&Run>) -> bool,
    ) -> impl Iterator<Item = GoalId> {
        layers.observations.goals.ids().filter(move |&goal| {
            let found_run =
                self.random_search.as_ref().ok().and_then(|search| search.found_run(goal));
            let settled = found_run.is_some_and(|found_run| found_run.is_final);
            layers.observations.seen.goals[goal].is_none()
                && !settled
                && wanted(found_run.map(|found_run| &found_run.run))
        })
    }

    /// Returns true if all properties of single states were seen or found.
    pub(super) fn all_found(&self, layers: &Layers<'a>) -> bool {
        let mut left = self.open_goals(layers, |found_run| found_run.is_none());
        left.next().is_none()
    }

    /// Returns true if some goal was only found by random search, and may still be reached earlier.
    pub(super) fn may_find_earlier_end(&self, layers: &Layers<'a>) -> bool {
        let now = layers.now;
        let mut left = self
            .open_goals(layers, |found_run| found_run.is_some_and(|found_run| found_run.end > now));
        left.next().is_some()
    }

    pub(super) fn is_random_search_due(&self, layers: &Layers<'a>) -> bool {
        let random_search = self.random_search.as_ref();
        random_search.is_ok_and(|search| search.is_due(layers.steps, layers.is_dense()))
    }

    /// Returns the number of steps for each of the two searches for an earlier end.
    pub(super) fn further(&self, layers: &Layers<'a>) -> u64 {
        self.effort(layers).min(MAX_STEPS_FOR_EARLIER_END)
    }

    /// Postpones reports to the end, which is near.
    pub(super) fn postpone_reports(&mut self) {
        if let Ok(random_search) = &mut self.random_search {
            random_search.report_at = None;
        }
    }

    /// Makes found runs final, if the search has continued for long enough without seeing the goals.
    fn settle_if_due(&mut self, layers: &Layers<'a>) {
        let due = self.random_search.as_ref().ok().and_then(|search| search.report_at);
        if due.is_none_or(|report| layers.steps < report) {
            return;
        }
        self.search_earlier_ends(layers, self.further(layers));
        if let Ok(random_search) = &mut self.random_search {
            random_search.report_at = None;
            let found_run = random_search.found_run.values_mut().flatten();
            found_run.for_each(|found_run| found_run.is_final = true);
        }
    }

    /// Searches at random for goals that have not been seen, if a search is due.
    pub(super) fn search_if_due(&mut self, layers: &mut Layers<'a>) {
        self.settle_if_due(layers);
        while layers.diverging.is_none() && self.is_random_search_due(layers) {
            let goals: Vec<GoalId> = self.open_goals(layers, |run| run.is_none()).collect();
            let endless = self.next_unbounded(layers);
            if goals.is_empty() && endless.is_none() {
                return;
            }
            if let Some(gauge) = endless {
                layers.diverging = self.search_unbounded(layers, gauge);
            }
            if goals.is_empty() {
                continue;
            }
            let watch = layers.observations.goals.only(&goals);
            let mut search = beside(layers, &watch);
            for _ in 0..Order::KINDS {
                if !self.is_random_search_due(layers)
                    || self.search(layers, &mut search, &goals, None)
                {
                    break;
                }
            }
            let any = self.open_goals(layers, |run| run.is_some()).next().is_some();
            let Ok(random_search) = &mut self.random_search else {
                return;
            };
            if any {
                random_search.report_at.get_or_insert(layers.steps + MAX_STEPS_FOR_EARLIER_END);
            }
            let mut missed = layers.observations.goals.missed().map(|(goal, _)| goal);
            if watch.stop_at_first && missed.any(|goal| random_search.found_run[goal].is_some()) {
                layers.stopped = Some(Stop::Answered);
                return;
            }
        }
    }

    /// Searches, for this many steps, for runs that end earlier than the found runs: first up to moments soon
    /// after the present one, then up to later and later moments.
    pub(super) fn search_earlier_ends(&mut self, layers: &Layers<'a>, further: u64) {
        let goals: Vec<GoalId> = self.open_goals(layers, |run| run.is_some()).collect();
        let watch = layers.observations.goals.only(&goals);
        let mut search = beside(layers, &watch);
        let until = self.effort(layers) + further;
        let length = (further / 5).max(1);
        let (mut low, mut width) = (layers.now, 1);
        while let Ok(random_search) = &self.random_search
            && !random_search.full
            && self.effort(layers) + length <= until
        {
            let Some(high) = random_search.last_end(&goals).filter(|&end| end > low + 1) else {
                return;
            };
            if low + width >= high {
                width = 1;
            }
            if self.search(layers, &mut search, &goals, Some((length, low + width))) {
                (low, width) = (low + width / 2, 1);
            } else if search.is_exhausted() {
                low += width;
            } else {
                width *= 2;
            }
        }
    }

    /// Runs one search of a given length, up to a moment. Returns true if it has found anything new.
    fn search(
        &mut self,
        layers: &Layers<'a>,
        search: &mut DepthFirstSearch<'_>,
        goals: &[GoalId],
        bounds: Option<(u64, u64)>,
    ) -> bool {
        let Ok(random_search) = &mut self.random_search else {
            return false;
        };
        let mut order = random_search.next_order();
        // A search with longest times cannot improve the runs found by others.
        order.late &= bounds.is_none() || random_search.late;
        self.run_search(layers, search, order, bounds);
        let found_run = search.found_run();
        let Ok(random_search) = &mut self.random_search else {
            return false;
        };
        let any = random_search.note(goals, found_run.into_values());
        random_search.late |= any && order.late;
        let everything = bounds.is_none() && search.is_exhausted();
        random_search.over |= everything && !order.late;
        random_search.not_late |= everything && order.late;
        any
    }

    pub(super) fn run_search(
        &mut self,
        layers: &Layers<'a>,
        search: &mut DepthFirstSearch,
        order: Order,
        bounds: Option<(u64, u64)>,
    ) {
        // If the memory limit has ended the search, only few more states are examined.
        let states = match layers.stopped {
            Some(_) => 0,
            None => layers.states_now() + self.states_outside_layers(),
        };
        let bytes = layers.memory();
        let Ok(random_search) = &mut self.random_search else {
            return;
        };
        let (length, end) = bounds.unwrap_or((random_search.length(), u64::MAX));
        let room = search.run(order, length, end, (states, bytes));
        random_search.full |= !room;
        random_search.steps += search.steps;
        random_search.states += search.states();
        random_search.bytes = random_search.bytes.max(bytes + search.memory());
        for service in search.refused() {
            if !random_search.refused.contains(&service) {
                random_search.refused.push(service);
            }
        }
    }
}

/// Returns a search for the system of some layers, within the same limits.
fn beside<'w>(layers: &Layers<'w>, watch: &'w Watch) -> DepthFirstSearch<'w> {
    let rules = &layers.observations.rules;
    let observations = Observations::new(rules, watch, &[], layers.limits.without);
    DepthFirstSearch::new(observations, layers.limits, layers.cancel)
}

/// Returns element `i` of the sequence 1 1 2 1 1 2 4 1 1 2 1 1 2 4 8 …: the lengths of restarts for
/// randomised searches (M. Luby, A. Sinclair and D. Zuckerman, *Optimal speedup of Las Vegas algorithms*,
/// 1993).
fn luby(i: u64) -> u64 {
    let power = (i + 1).next_power_of_two();
    if power == i + 1 { power / 2 } else { luby(i + 1 - power / 2) }
}

#[cfg(test)]
mod tests {
    use super::luby;

    #[test]
    fn lengths_of_searches() {
        let first: Vec<u64> = (1..=15).map(luby).collect();
        assert_eq!(first, [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
    }
}
