//! Hunts: randomised depth-first search for properties of single states.
//!
//! Breadth-first search finds short runs, but it examines all earlier events first. A failure that comes
//! late, or at a crowded moment, is found late. So a small part of the effort goes to depth-first searches
//! (see [`Chase`]): many short ones, in different orders, because a search that has begun badly hardly ever
//! recovers. They prove nothing; their runs are as valid as any others.
//!
//! Such runs are longer than necessary. So before they are reported, breadth-first search continues, and
//! chases look for runs that end earlier. Both take as long as all steps so far, up to a limit. A reported
//! run is final. In a long search, runs are reported before its end.

use rustc_hash::FxHashSet;

use super::Supervisor;
use crate::explore::reductions::{Kind, Reason, Reduced};
use crate::explore::run::Run;
use crate::explore::search::chase::{Chase, Order};
use crate::explore::search::goals::{GoalId, Goals, PerGoal};
use crate::explore::search::layers::Layers;
use crate::explore::search::watching::Watching;
use crate::explore::watch::{Limits, Stop, Watch};

/// Steps after which a search counts as large.
const SMALL: u64 = 1000;

/// Steps of a short chase.
const SHORT: u64 = 1500;

/// Upper limit on the steps for each of the two searches for an earlier end.
const FURTHER: u64 = 200_000;

/// The catches so far, and the effort.
#[derive(Debug, Default)]
pub(super) struct Hunt {
    caught: PerGoal<Option<Catch>>,
    /// Number of chases.
    pub(super) chases: u64,
    /// Steps of all chases.
    pub(super) steps: u64,
    /// States examined by all chases.
    pub(super) states: usize,
    /// Greatest number of bytes used by a chase, including the breadth-first search.
    pub(super) bytes: usize,
    /// Services with a refused request.
    pub(super) refused: Vec<usize>,
    /// All states have been examined.
    over: bool,
    /// The memory limit is reached.
    full: bool,
    /// Chases with longest times can catch nothing more.
    not_late: bool,
    /// A chase with longest times has caught something.
    late: bool,
    /// Gauges of which all states have been examined.
    pub(super) bounded: FxHashSet<usize>,
    /// Number of steps of the search at which catches are reported.
    tell_at: Option<u64>,
}

/// A run of randomised search.
#[derive(Debug)]
pub(super) struct Catch {
    pub(super) run: Run,
    /// The run was reported: it is not replaced by a shorter one.
    pub(super) is_final: bool,
}

impl Hunt {
    pub(super) fn new(watch: &Watch) -> Self {
        Hunt {
            caught: Goals::of(watch).each(|_| None),
            ..Hunt::default()
        }
    }

    /// Returns the number of steps of the next chase: mostly few, because a lucky chase needs few.
    fn length(&self) -> u64 {
        SHORT * luby(self.chases / Order::KINDS + 1)
    }

    /// Returns true if another chase is due, after this many steps of the breadth-first search, at `crowded`
    /// moments or not.
    fn is_due(&self, steps: u64, crowded: bool) -> bool {
        let more = if crowded { steps / 4 } else { steps / 128 };
        let share = SHORT + (steps / 4).min(SHORT) + more;
        steps >= SMALL && !self.over && !self.full && self.steps + self.length() <= share
    }

    /// Returns the order of the next chase.
    pub(super) fn next_order(&mut self) -> Order {
        self.chases += 1;
        let mut order = Order::numbered(self.chases - 1);
        order.late &= !self.not_late;
        order
    }

    /// Records the runs of a chase for some goals that are new or end earlier. Returns true if there are any.
    fn note(&mut self, goals: &[GoalId], caught: impl Iterator<Item = Option<Run>>) -> bool {
        let mut any = false;
        for (&goal, run) in goals.iter().zip(caught) {
            let place = &mut self.caught[goal];
            if let Some(run) = run
                && place.as_ref().is_none_or(|it| run.end < it.run.end)
            {
                *place = Some(Catch {
                    run,
                    is_final: false,
                });
                any = true;
            }
        }
        any
    }

    /// Returns the latest end of the runs to some goals.
    fn last_end(&self, goals: &[GoalId]) -> Option<u64> {
        let runs = goals.iter().filter_map(|&it| self.caught[it].as_ref());
        runs.map(|it| it.run.end).max()
    }

    /// Returns the catch for a goal.
    pub(super) fn caught(&self, goal: GoalId) -> Option<&Catch> {
        self.caught[goal].as_ref()
    }

    /// Returns the hunt for the next exploration of the same system, including the runs seen by this one.
    pub(super) fn handed_on<R: Reduced>(mut self, layers: &Layers<'_, R>) -> Hunt {
        self.steps = 0;
        self.tell_at = None;
        for goal in layers.watching.goals.ids() {
            if let Some(run) = layers.run_to(goal) {
                self.caught[goal] = Some(Catch {
                    run,
                    is_final: true,
                });
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
pub(super) fn suits(watch: &Watch, limits: Limits) -> Result<(), Reason> {
    if limits.without.contains(Kind::RandomSearch) {
        Err(Reason::SwitchedOff)
    } else if watch.in_order {
        Err(Reason::InOrder)
    } else {
        Ok(())
    }
}

impl<'a, R: Reduced> Supervisor<'a, R> {
    /// Returns the `wanted` goals that are neither seen nor settled otherwise, depending on their catch.
    fn unseen(
        &self,
        layers: &Layers<'a, R>,
        wanted: impl Fn(Option<&Run>) -> bool,
    ) -> impl Iterator<Item = GoalId> {
        layers.watching.goals.ids().filter(move |&goal| {
            let caught = self.hunt.as_ref().ok().and_then(|it| it.caught(goal));
            let settled = self.is_never(layers, goal) || caught.is_some_and(|it| it.is_final);
            layers.watching.seen.goals[goal].is_none()
                && !settled
                && wanted(caught.map(|it| &it.run))
        })
    }

    /// Returns true if all properties of single states were seen or caught.
    pub(super) fn all_caught(&self, layers: &Layers<'a, R>) -> bool {
        let mut left = self.unseen(layers, |caught| caught.is_none());
        left.next().is_none()
    }

    /// Returns true if some goal was only caught, and may still be reached earlier.
    pub(super) fn may_end_earlier(&self, layers: &Layers<'a, R>) -> bool {
        let now = layers.now;
        let mut left = self.unseen(layers, |caught| caught.is_some_and(|it| it.end > now));
        left.next().is_some()
    }

    pub(super) fn is_hunt_due(&self, layers: &Layers<'a, R>) -> bool {
        let hunt = self.hunt.as_ref();
        hunt.is_ok_and(|it| it.is_due(layers.steps, layers.is_crowded()))
    }

    /// Returns the number of steps for each of the two searches for an earlier end.
    pub(super) fn further(&self, layers: &Layers<'a, R>) -> u64 {
        self.effort(layers).min(FURTHER)
    }

    /// Postpones reports to the end, which is near.
    pub(super) fn tell_later(&mut self) {
        if let Ok(hunt) = &mut self.hunt {
            hunt.tell_at = None;
        }
    }

    /// Makes catches final, if the search has continued for long enough without seeing the goals.
    fn settle_if_due(&mut self, layers: &Layers<'a, R>) {
        let due = self.hunt.as_ref().ok().and_then(|it| it.tell_at);
        if due.is_none_or(|it| layers.steps < it) {
            return;
        }
        self.chase_earlier(layers, self.further(layers));
        if let Ok(hunt) = &mut self.hunt {
            hunt.tell_at = None;
            let caught = hunt.caught.values_mut().flatten();
            caught.for_each(|it| it.is_final = true);
        }
    }

    /// Hunts for goals that have not been seen, if a hunt is due.
    pub(super) fn hunt_if_due(&mut self, layers: &mut Layers<'a, R>) {
        self.settle_if_due(layers);
        while layers.diverging.is_none() && self.is_hunt_due(layers) {
            let goals: Vec<GoalId> = self.unseen(layers, |it| it.is_none()).collect();
            let endless = self.next_endless(layers);
            if goals.is_empty() && endless.is_none() {
                return;
            }
            if let Some(gauge) = endless {
                layers.diverging = self.hunt_endless(layers, gauge);
            }
            if goals.is_empty() {
                continue;
            }
            let watch = layers.watching.goals.only(&goals);
            let mut chase = beside(layers, &watch);
            for _ in 0..Order::KINDS {
                if !self.is_hunt_due(layers) || self.chase(layers, &mut chase, &goals, None) {
                    break;
                }
            }
            let any = self.unseen(layers, |it| it.is_some()).next().is_some();
            let Ok(hunt) = &mut self.hunt else { return };
            if any {
                hunt.tell_at.get_or_insert(layers.steps + FURTHER);
            }
            let mut missed = layers.watching.goals.missed();
            if watch.stop_at_first && missed.any(|it| hunt.caught[it.0].is_some()) {
                layers.stopped = Some(Stop::Answered);
                return;
            }
        }
    }

    /// Searches, for this many steps, for runs that end earlier than the catches: first up to moments soon
    /// after the present one, then up to later and later moments.
    pub(super) fn chase_earlier(&mut self, layers: &Layers<'a, R>, further: u64) {
        let goals: Vec<GoalId> = self.unseen(layers, |it| it.is_some()).collect();
        let watch = layers.watching.goals.only(&goals);
        let mut chase = beside(layers, &watch);
        let until = self.effort(layers) + further;
        let length = (further / 5).max(1);
        let (mut low, mut width) = (layers.now, 1);
        while let Ok(hunt) = &self.hunt
            && !hunt.full
            && self.effort(layers) + length <= until
        {
            let Some(high) = hunt.last_end(&goals).filter(|&it| it > low + 1) else {
                return;
            };
            if low + width >= high {
                width = 1;
            }
            if self.chase(layers, &mut chase, &goals, Some((length, low + width))) {
                (low, width) = (low + width / 2, 1);
            } else if chase.is_exhausted() {
                low += width;
            } else {
                width *= 2;
            }
        }
    }

    /// Runs one chase of a given length, up to a moment. Returns true if it has caught anything new.
    fn chase(
        &mut self,
        layers: &Layers<'a, R>,
        chase: &mut Chase<'_, R>,
        goals: &[GoalId],
        bounds: Option<(u64, u64)>,
    ) -> bool {
        let Ok(hunt) = &mut self.hunt else {
            return false;
        };
        let mut order = hunt.next_order();
        // A chase with longest times cannot improve the catches of others.
        order.late &= bounds.is_none() || hunt.late;
        self.run_chase(layers, chase, order, bounds);
        let caught = chase.caught();
        let Ok(hunt) = &mut self.hunt else {
            return false;
        };
        let any = hunt.note(goals, caught.into_values());
        hunt.late |= any && order.late;
        let everything = bounds.is_none() && chase.is_exhausted();
        hunt.over |= everything && !order.late;
        hunt.not_late |= everything && order.late;
        any
    }

    /// Runs one chase.
    pub(super) fn run_chase(
        &mut self,
        layers: &Layers<'a, R>,
        chase: &mut Chase<R>,
        order: Order,
        bounds: Option<(u64, u64)>,
    ) {
        // If the memory limit has ended the search, only few more states are examined.
        let states = match layers.stopped {
            Some(_) => 0,
            None => layers.states_now() + self.states_beside(),
        };
        let bytes = layers.memory() + self.proving.bytes();
        let Ok(hunt) = &mut self.hunt else { return };
        let (length, end) = bounds.unwrap_or((hunt.length(), u64::MAX));
        let room = chase.run(order, length, end, (states, bytes));
        hunt.full |= !room;
        hunt.steps += chase.steps;
        hunt.states += chase.states();
        hunt.bytes = hunt.bytes.max(bytes + chase.memory());
        for service in chase.refused() {
            if !hunt.refused.contains(&service) {
                hunt.refused.push(service);
            }
        }
    }
}

/// Returns a chase for the system of some layers, within the same limits.
fn beside<'w, R: Reduced>(layers: &Layers<'w, R>, watch: &'w Watch) -> Chase<'w, R> {
    let rules = &layers.watching.rules;
    let watching = Watching::new(rules, watch, &[], layers.limits.without);
    Chase::new(watching, layers.limits, layers.cancel)
}

/// Returns element `i` of the sequence 1 1 2 1 1 2 4 1 1 2 1 1 2 4 8 …: the lengths of restarts for
/// randomised searches (M. Luby, A. Sinclair and D. Zuckerman, *Optimal speedup of Las Vegas algorithms*,
/// 1993).
fn luby(i: u64) -> u64 {
    let power = (i + 1).next_power_of_two();
    match power == i + 1 {
        true => power / 2,
        false => luby(i + 1 - power / 2),
    }
}

#[cfg(test)]
mod tests {
    use super::luby;

    #[test]
    fn lengths_of_chases() {
        let first: Vec<u64> = (1..=15).map(luby).collect();
        assert_eq!(first, [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
    }
}
