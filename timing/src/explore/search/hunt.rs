//! Hunts: what a single state shows is also looked for depth first.
//!
//! In order of time the runs found are short, but whatever can happen earlier is looked at before: what goes
//! wrong late, or at a moment at which very much can happen, is found late. So beside a search in order of
//! time, and with a small part of its effort, others go straight on (see [`chase`]): many short ones, in
//! different orders, as one that has begun wrongly hardly ever recovers. They prove nothing; what they catch
//! is a run like any other.
//!
//! Such runs are longer than they have to be. So before they are told, the search in order of time goes on,
//! and ones that end earlier are chased: both for as long as everything has taken so far, if that is not very
//! long. What was told is final. In a search that takes long it is told on the way.

mod chase;
mod endless;

use rustc_hash::FxHashSet;

use self::chase::{Chase, Order};
use super::{Search, Sight};
use crate::cancel::Cancel;
use crate::explore::findings::{Findings, Found};
use crate::explore::reductions::{Kind, Reason, Reduced};
use crate::explore::rules::with_rules;
use crate::explore::run::Run;
use crate::explore::watch::{Limits, Stop, Watch};
use crate::system::TimedSystem;

/// Steps after which a search is not small any more.
const SMALL: u64 = 1000;

/// Steps of a short chase.
const SHORT: u64 = 1500;

/// Steps for each of the two ways to an earlier end, at most.
const FURTHER: u64 = 200_000;

/// What was caught so far, and what it has cost.
#[derive(Debug, Default)]
pub(super) struct Hunt {
    caught: Lists<Option<Catch>>,
    /// Chases so far.
    chases: u64,
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
    bounded: FxHashSet<usize>,
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

/// What was seen where, what was caught if there is a hunt, and what never happens.
struct List<'s> {
    seen: &'s [Option<Sight>],
    caught: Option<&'s Vec<Option<Catch>>>,
    never: Vec<bool>,
}

impl List<'_> {
    /// Whether something may still be seen, and is `wanted` with what was caught of it.
    fn is_open(&self, it: usize, wanted: &dyn Fn(Option<&Run>) -> bool) -> bool {
        let caught = self.caught.and_then(|caught| caught[it].as_ref());
        let settled = self.never[it] || caught.is_some_and(|it| it.is_final);
        self.seen[it].is_none() && !settled && wanted(caught.map(|it| &it.run))
    }
}

/// One for each of what is watched and shown by a single state.
#[derive(Debug, Default)]
struct Lists<T> {
    missed: Vec<T>,
    overdue: Vec<T>,
    reached: Vec<T>,
}

impl<T> Lists<T> {
    fn all(&self) -> impl Iterator<Item = &T> {
        self.missed.iter().chain(&self.overdue).chain(&self.reached)
    }

    fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }
}

impl Hunt {
    pub(super) fn new(watch: &Watch) -> Self {
        let none = |n: usize| (0..n).map(|_| None).collect();
        Hunt {
            caught: Lists {
                missed: none(watch.schedulable.len()),
                overdue: none(watch.overdue.len()),
                reached: none(watch.reach.len()),
            },
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

    /// Notes what a chase for some of the watched things has caught, if it is new or ends earlier. Whether
    /// any of it does.
    fn note(&mut self, goals: &Lists<usize>, caught: Lists<Option<Run>>) -> bool {
        let lists = [
            (&mut self.caught.missed, &goals.missed, caught.missed),
            (&mut self.caught.overdue, &goals.overdue, caught.overdue),
            (&mut self.caught.reached, &goals.reached, caught.reached),
        ];
        let mut any = false;
        for (known, goals, caught) in lists {
            for (&goal, run) in goals.iter().zip(caught) {
                let place = &mut known[goal];
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
        }
        any
    }

    /// The end of the run to some of them that ends last.
    fn last_end(&self, goals: &Lists<usize>) -> Option<u64> {
        let lists = [
            (&self.caught.missed, &goals.missed),
            (&self.caught.overdue, &goals.overdue),
            (&self.caught.reached, &goals.reached),
        ];
        let runs = lists.into_iter();
        let runs = runs.flat_map(|(caught, goals)| goals.iter().map(|&it| caught[it].as_ref()));
        runs.flatten().map(|it| it.run.end).max()
    }

    fn lists_mut(&mut self) -> [&mut Vec<Option<Catch>>; 3] {
        let Lists {
            missed,
            overdue,
            reached,
        } = &mut self.caught;
        [missed, overdue, reached]
    }

    /// What was caught, by list and place, see [`Search::for_each`].
    pub(super) fn caught(&self, list: usize, i: usize) -> Option<&Catch> {
        let Lists {
            missed,
            overdue,
            reached,
        } = &self.caught;
        [missed, overdue, reached][list][i].as_ref()
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

impl<R: Reduced> Search<'_, R> {
    /// What is watched, shown by a single state, and not seen yet: by number, as far as it is `wanted`, given
    /// what was caught of it.
    fn unseen(&self, wanted: &dyn Fn(Option<&Run>) -> bool) -> Lists<usize> {
        let [missed, overdue, reached] = self.lists().map(|list| {
            let all = 0..list.seen.len();
            all.filter(|&it| list.is_open(it, wanted)).collect()
        });
        Lists {
            missed,
            overdue,
            reached,
        }
    }

    /// Whether there is any of it.
    fn any_unseen(&self, wanted: &dyn Fn(Option<&Run>) -> bool) -> bool {
        let mut lists = self.lists().into_iter();
        lists.any(|list| (0..list.seen.len()).any(|it| list.is_open(it, wanted)))
    }

    /// What was seen, and what was caught if there is a hunt.
    fn lists(&self) -> [List<'_>; 3] {
        let caught = self.hunt.as_ref().map(|it| &it.caught);
        // What is proved in zones has no periodic tasks, so that nothing is late.
        let never = |list: &[Option<Sight>]| vec![self.is_proved(); list.len()];
        let never_reached = (0..self.reached.len()).map(|it| self.never_reached(it));
        [
            (
                &self.missed,
                caught.map(|it| &it.missed),
                never(&self.missed),
            ),
            (
                &self.overdue,
                caught.map(|it| &it.overdue),
                never(&self.overdue),
            ),
            (
                &self.reached,
                caught.map(|it| &it.reached),
                never_reached.collect(),
            ),
        ]
        .map(|(seen, caught, never)| List {
            seen,
            caught,
            never,
        })
    }

    /// Whether everything that a single state shows was seen or caught.
    pub(super) fn all_caught(&self) -> bool {
        !self.any_unseen(&|caught| caught.is_none())
    }

    /// Whether something was only caught, and may still be seen earlier.
    pub(super) fn may_end_earlier(&self) -> bool {
        self.any_unseen(&|caught| caught.is_some_and(|it| it.end > self.now))
    }

    /// Steps so far, with those of the hunt and those in zones.
    pub(super) fn effort(&self) -> u64 {
        self.steps + self.in_zones().1 + self.hunt.as_ref().map_or(0, |it| it.steps)
    }

    /// States looked at in the hunt.
    pub(super) fn hunted(&self) -> usize {
        self.hunt.as_ref().map_or(0, |it| it.states)
    }

    fn is_hunt_due(&self) -> bool {
        let hunt = self.hunt.as_ref();
        hunt.is_some_and(|it| it.is_due(self.steps, self.is_crowded()))
    }

    /// Steps for each of the two ways to an earlier end of what was caught.
    pub(super) fn further(&self) -> u64 {
        self.effort().min(FURTHER)
    }

    /// The hunt, for another search of the same system: what was seen by this one is known already.
    pub(super) fn hand_on_hunt(&mut self) -> Option<Hunt> {
        let seen = self.for_each(|list, i| self.seen_run(list, i));
        let mut hunt = self.hunt.take()?;
        hunt.steps = 0;
        hunt.tell_at = None;
        for (caught, seen) in hunt.lists_mut().into_iter().zip(seen) {
            for (caught, run) in caught.iter_mut().zip(seen) {
                let first = |run| Catch {
                    run,
                    is_final: true,
                };
                *caught = run.map(first).or(caught.take());
            }
        }
        Some(hunt)
    }

    /// Leaves telling to the end, which is near.
    pub(super) fn tell_later(&mut self) {
        if let Some(hunt) = &mut self.hunt {
            hunt.tell_at = None;
        }
    }

    /// Settles what was caught, if the search has gone on for long enough without seeing it.
    fn settle_if_due(&mut self) {
        let due = self.hunt.as_ref().and_then(|it| it.tell_at);
        if due.is_none_or(|it| self.steps < it) {
            return;
        }
        self.chase_earlier(self.further());
        if let Some(hunt) = &mut self.hunt {
            hunt.tell_at = None;
            for list in hunt.lists_mut() {
                list.iter_mut().flatten().for_each(|it| it.is_final = true);
            }
        }
    }

    /// Hunts for what has not been seen, if it is time to.
    pub(super) fn hunt_if_due(&mut self) {
        self.settle_if_due();
        while self.diverging.is_none() && self.is_hunt_due() {
            let goals = self.unseen(&|caught| caught.is_none());
            let endless = self.next_endless();
            if goals.is_empty() && endless.is_none() {
                return;
            }
            if let Some(gauge) = endless {
                self.hunt_endless(gauge);
            }
            if goals.is_empty() {
                continue;
            }
            let watch = self.watch_for(&goals);
            let mut chase = Chase::new(self.beside(&watch));
            for _ in 0..Order::KINDS {
                if !self.is_hunt_due() || self.chase(&mut chase, &goals, None) {
                    break;
                }
            }
            let any = self.any_unseen(&|caught| caught.is_some());
            let tell_at = self.steps + FURTHER;
            if let Some(hunt) = self.hunt.as_mut().filter(|_| any) {
                hunt.tell_at.get_or_insert(tell_at);
            }
            let caught = self.hunt.as_ref().map(|it| &it.caught.missed);
            if self.watch.stop_at_first && caught.is_some_and(|it| it.iter().any(Option::is_some)) {
                self.stopped = Some(Stop::Answered);
                return;
            }
        }
    }

    /// For so many steps, looks for runs that end earlier than those that were caught: soon after the moment
    /// up to which everything is known, then up to moments that are further and further away.
    pub(super) fn chase_earlier(&mut self, further: u64) {
        let goals = self.unseen(&|caught| caught.is_some());
        let watch = self.watch_for(&goals);
        let mut chase = Chase::new(self.beside(&watch));
        let until = self.effort() + further;
        let length = (further / 5).max(1);
        let (mut low, mut width) = (self.now, 1);
        while let Some(hunt) = &self.hunt
            && !hunt.full
            && self.effort() + length <= until
        {
            let Some(high) = hunt.last_end(&goals).filter(|&it| it > low + 1) else {
                return;
            };
            if low + width >= high {
                width = 1;
            }
            if self.chase(&mut chase, &goals, Some((length, low + width))) {
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
        chase: &mut Chase<'_, R>,
        goals: &Lists<usize>,
        bounds: Option<(u64, u64)>,
    ) -> bool {
        let Some(mut order) = self.next_order() else {
            return false;
        };
        // Late ones are no use for what others have caught.
        order.late &= bounds.is_none() || self.hunt.as_ref().is_some_and(|it| it.late);
        self.run_chase(chase, order, bounds);
        let caught = chase.caught();
        let Some(hunt) = &mut self.hunt else {
            return false;
        };
        let any = hunt.note(goals, caught);
        hunt.late |= any && order.late;
        let everything = bounds.is_none() && chase.is_exhausted();
        hunt.over |= everything && !order.late;
        hunt.not_late |= everything && order.late;
        any
    }

    /// In which order the next chase looks at things.
    fn next_order(&mut self) -> Option<Order> {
        let hunt = self.hunt.as_mut()?;
        hunt.chases += 1;
        let mut order = Order::numbered(hunt.chases - 1);
        order.late &= !hunt.not_late;
        Some(order)
    }

    /// One chase.
    fn run_chase(&mut self, chase: &mut Chase<R>, order: Order, bounds: Option<(u64, u64)>) {
        // After the end of a search for want of room only few more are looked at.
        let states = match self.stopped {
            Some(_) => 0,
            None => self.nodes.len() + self.layer.len() + self.states_beside(),
        };
        let bytes = self.memory();
        let Some(hunt) = &mut self.hunt else {
            return;
        };
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

    /// A search for something else in the same system, within the same limits.
    fn beside<'w>(&self, watch: &'w Watch) -> Search<'w, R>
    where
        Self: 'w,
    {
        Search::new(&self.rules, watch, &[], self.limits, self.cancel)
    }

    fn watch_for(&self, goals: &Lists<usize>) -> Watch {
        let pick = |list: &[usize], goals: &[usize]| goals.iter().map(|&it| list[it]).collect();
        Watch {
            schedulable: pick(&self.watch.schedulable, &goals.missed),
            overdue: pick(&self.watch.overdue, &goals.overdue),
            reach: (goals.reached.iter())
                .map(|&it| self.watch.reach[it].clone())
                .collect(),
            stop_at_first: self.watch.stop_at_first,
            ..Watch::default()
        }
    }
}

/// Only chases a system: what the states of one chase of this number show, of those a [`Watch`] can be
/// answered by.
pub fn chase(
    system: &TimedSystem,
    watch: &Watch,
    (number, steps): (u64, u64),
    limits: Limits,
    cancel: &Cancel,
) -> Findings {
    with_rules!(system, chase_by(watch, (number, steps), limits, cancel))
}

fn chase_by<R: Reduced>(
    rules: &R,
    watch: &Watch,
    (number, steps): (u64, u64),
    limits: Limits,
    cancel: &Cancel,
) -> Findings {
    let mut chase = Chase::new(Search::new(rules, watch, &[], limits, cancel));
    let room = chase.run(Order::numbered(number), steps, u64::MAX, (0, 0));
    let caught = chase.caught();
    let found = |runs: Vec<Option<Run>>| {
        let found = |run| Found { run };
        runs.into_iter().map(|it| it.map(found)).collect()
    };
    Findings {
        missed: found(caught.missed),
        overdue: found(caught.overdue),
        reached: found(caught.reached),
        refused: chase.refused(),
        states: chase.states(),
        steps: chase.steps,
        bytes: chase.memory(),
        stopped: (!room || !chase.is_done()).then_some(Stop::States),
        ..Findings::default()
    }
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
