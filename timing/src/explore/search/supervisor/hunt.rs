//! Hunts: what a single state shows is also looked for depth first.
//!
//! In order of time the runs found are short, but whatever can happen earlier is looked at before: what goes
//! wrong late, or at a moment at which very much can happen, is found late. So beside a search in order of
//! time, and with a small part of its effort, others go straight on (see [`Chase`]): many short ones, in
//! different orders, as one that has begun wrongly hardly ever recovers. They prove nothing; what they catch
//! is a run like any other.
//!
//! Such runs are longer than they have to be. So before they are told, the search in order of time goes on,
//! and ones that end earlier are chased: both for as long as everything has taken so far, if that is not very
//! long. What was told is final. In a search that takes long it is told on the way.

use rustc_hash::FxHashSet;

use super::Supervisor;
use crate::explore::reductions::{Kind, Reason, Reduced};
use crate::explore::run::Run;
use crate::explore::search::chase::{Chase, Order};
use crate::explore::search::goals::{GoalId, Goals, PerGoal};
use crate::explore::search::layers::Layers;
use crate::explore::search::watching::Watching;
use crate::explore::watch::{Limits, Stop, Watch};

/// Steps after which a search is not small any more.
const SMALL: u64 = 1000;

/// Steps of a short chase.
const SHORT: u64 = 1500;

/// Steps for each of the two ways to an earlier end, at most.
const FURTHER: u64 = 200_000;

/// What was caught so far, and what it has cost.
#[derive(Debug, Default)]
pub(super) struct Hunt {
    caught: PerGoal<Option<Catch>>,
    /// Chases so far.
    pub(super) chases: u64,
    /// Steps of all chases.
    pub(super) steps: u64,
    /// States that were looked at in them.
    pub(super) states: usize,
    /// Bytes used, together with the search, in the largest.
    pub(super) bytes: usize,
    /// Services of which a request was refused.
    pub(super) refused: Vec<usize>,
    /// Everything that there is was looked at.
    over: bool,
    /// There is no room for more.
    full: bool,
    /// Nothing is left to be caught late.
    not_late: bool,
    /// Something was caught late.
    late: bool,
    /// Gauges of which everything was looked at.
    pub(super) bounded: FxHashSet<usize>,
    /// Steps of the search at which to tell what was caught.
    tell_at: Option<u64>,
}

/// What was caught.
#[derive(Debug)]
pub(super) struct Catch {
    pub(super) run: Run,
    /// It is told, and stays: none that ends earlier is looked for any more.
    pub(super) is_final: bool,
}

impl Hunt {
    pub(super) fn new(watch: &Watch) -> Self {
        Hunt {
            caught: Goals::of(watch).each(|_| None),
            ..Hunt::default()
        }
    }

    /// Steps of the next chase: mostly few, as those that are lucky need few.
    fn length(&self) -> u64 {
        SHORT * luby(self.chases / Order::KINDS + 1)
    }

    /// Whether there should be one more beside a search that has taken so many steps, at `crowded` moments or
    /// not.
    fn is_due(&self, steps: u64, crowded: bool) -> bool {
        let more = if crowded { steps / 4 } else { steps / 128 };
        let share = SHORT + (steps / 4).min(SHORT) + more;
        steps >= SMALL && !self.over && !self.full && self.steps + self.length() <= share
    }

    /// In which order the next chase looks at things.
    pub(super) fn next_order(&mut self) -> Order {
        self.chases += 1;
        let mut order = Order::numbered(self.chases - 1);
        order.late &= !self.not_late;
        order
    }

    /// Notes what a chase for some goals has caught, if it is new or ends earlier. Whether any of it does.
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

    /// The end of the run to some of them that ends last.
    fn last_end(&self, goals: &[GoalId]) -> Option<u64> {
        let runs = goals.iter().filter_map(|&it| self.caught[it].as_ref());
        runs.map(|it| it.run.end).max()
    }

    /// What was caught.
    pub(super) fn caught(&self, goal: GoalId) -> Option<&Catch> {
        self.caught[goal].as_ref()
    }

    /// The hunt beside another exploration of the same system: what was seen by this one is known already.
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

/// Whether a randomised search depth first may find something that is asked.
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
    /// Goals that are not seen yet, nor settled otherwise, as far as they are `wanted`, given what was caught
    /// of them.
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

    /// Whether everything that a single state shows was seen or caught.
    pub(super) fn all_caught(&self, layers: &Layers<'a, R>) -> bool {
        let mut left = self.unseen(layers, |caught| caught.is_none());
        left.next().is_none()
    }

    /// Whether something was only caught, and may still be seen earlier.
    pub(super) fn may_end_earlier(&self, layers: &Layers<'a, R>) -> bool {
        let now = layers.now;
        let mut left = self.unseen(layers, |caught| caught.is_some_and(|it| it.end > now));
        left.next().is_some()
    }

    pub(super) fn is_hunt_due(&self, layers: &Layers<'a, R>) -> bool {
        let hunt = self.hunt.as_ref();
        hunt.is_ok_and(|it| it.is_due(layers.steps, layers.is_crowded()))
    }

    /// Steps for each of the two ways to an earlier end of what was caught.
    pub(super) fn further(&self, layers: &Layers<'a, R>) -> u64 {
        self.effort(layers).min(FURTHER)
    }

    /// Leaves telling to the end, which is near.
    pub(super) fn tell_later(&mut self) {
        if let Ok(hunt) = &mut self.hunt {
            hunt.tell_at = None;
        }
    }

    /// Settles what was caught, if the search has gone on for long enough without seeing it.
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

    /// Hunts for what has not been seen, if it is time to.
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

    /// For so many steps, looks for runs that end earlier than those that were caught: soon after the moment
    /// up to which everything is known, then up to moments that are further and further away.
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

    /// One chase, of a length and up to a moment. Whether it has caught anything new.
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
        // Late ones are no use for what others have caught.
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

    /// One chase.
    pub(super) fn run_chase(
        &mut self,
        layers: &Layers<'a, R>,
        chase: &mut Chase<R>,
        order: Order,
        bounds: Option<(u64, u64)>,
    ) {
        // After the end of a search for want of room only few more are looked at.
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

/// A chase for something in the same system as that of layers, within the same limits.
fn beside<'w, R: Reduced>(layers: &Layers<'w, R>, watch: &'w Watch) -> Chase<'w, R> {
    let rules = &layers.watching.rules;
    let watching = Watching::new(rules, watch, &[], layers.limits.without);
    Chase::new(watching, layers.limits, layers.cancel)
}

/// 1 1 2 1 1 2 4 1 1 2 1 1 2 4 8 …: how often to begin anew where luck decides how long something takes (M.
/// Luby, A. Sinclair and D. Zuckerman, *Optimal speedup of Las Vegas algorithms*, 1993).
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
