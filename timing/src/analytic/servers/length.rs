//! The lengths of cycles, with their waits in the lock queue.

use super::{Cycle, Knowns, Rival, Window};
use crate::analytic::instances::Party;
use crate::system::{AutomatonId, CodelId, FOREVER, ServiceId, TaskId, Ticks};

/// A way to count the codels of a thread that keep a cycle waiting.
enum Way {
    /// Before each codel of the cycle, the longest one.
    Each,
    /// So, but those that the thread executes a limited number of times count with this time in all.
    Unlimited(u64),
    /// With this time in all.
    Together(u64),
}

impl Window<'_> {
    /// Returns the longest time of a cycle, including its waits in the lock queue, in base units.
    pub(in crate::analytic) fn cycle(&self, task: TaskId) -> Option<Ticks> {
        let length = |cycle| self.length(task, cycle, None, &|_| true);
        Some(length(Cycle::First)?.max(length(Cycle::Other)?))
    }

    /// Returns the longest time of a cycle, with its waits for certain threads in the lock queue. `known`:
    /// what is known of all tasks.
    pub(super) fn length(
        &self,
        task: TaskId,
        cycle: Cycle,
        known: Option<&Knowns>,
        counts: &dyn Fn(usize) -> bool,
    ) -> Option<Ticks> {
        let length = self.lengths((task, cycle, 1), known, counts)?;
        Ticks::try_from(length).ok().filter(|length| *length < FOREVER / 4)
    }

    /// Returns the longest time of some cycles in the window, together.
    pub(super) fn lengths(
        &self,
        (task, cycle, number): (TaskId, Cycle, u64),
        known: Option<&Knowns>,
        counts: &dyn Fn(usize) -> bool,
    ) -> Option<u64> {
        // Later tasks, and the control task, begin after the first pass.
        let permanent = self.system.tasks[task].permanent.filter(|_| cycle != Cycle::Other);
        let start = permanent.map(|automaton| {
            let machine = self.system.machine_of(automaton);
            machine.states[machine.start].codel
        });
        let threads = self.threads_beside(task).filter(|&thread| counts(thread));
        let threads: Vec<usize> = threads.collect();
        // The longest time of codels of a thread before a codel.
        let before = |codel: CodelId, thread: usize, counts: &dyn Fn(&Rival) -> bool| {
            let begun = start != Some(codel) || thread < usize::from(task);
            let ahead = self.ahead(task, codel, thread).filter(|rival| begun && counts(rival));
            self.most(ahead)
        };
        let unlimited = |rival: &Rival| rival.often.is_none();
        let each = |codel: CodelId| {
            let mut all = threads.iter().map(|&thread| before(codel, thread, &|_| true));
            all.try_fold(self.upper(codel)?, Ticks::checked_add)
        };
        let works = |time: &dyn Fn(CodelId) -> Option<Ticks>| self.works(task, cycle, number, time);
        let each = works(&each);
        // Each thread counts in the way in which its codels take least.
        let ways = threads.iter().map(|&thread| {
            let work = |counts: &dyn Fn(&Rival) -> bool| {
                works(&|codel| Some(before(codel, thread, counts)))
            };
            let limited = self.time_of_limited(task, thread).map(u64::from);
            let cycles = known.and_then(|known| self.time_in_cycles(task, cycle, thread, known));
            let cycles = cycles.and_then(|time| number.checked_mul(u64::from(time)));
            let ways = [
                (work(&|_| true), Way::Each),
                (
                    work(&unlimited).zip(limited).and_then(|(one, other)| one.checked_add(other)),
                    Way::Unlimited(limited.unwrap_or(0)),
                ),
                (cycles, Way::Together(cycles.unwrap_or(0))),
            ];
            ways.into_iter().filter_map(|(time, way)| Some((time?, way))).min_by_key(|way| way.0)
        });
        let ways: Option<Vec<(u64, Way)>> = ways.collect();
        let together = ways.and_then(|ways| {
            let time = |codel: CodelId| {
                let mut all = threads.iter().zip(&ways).map(|(&thread, (_, way))| match way {
                    Way::Each => before(codel, thread, &|_| true),
                    Way::Unlimited(_) => before(codel, thread, &unlimited),
                    Way::Together(_) => 0,
                });
                all.try_fold(self.upper(codel)?, Ticks::checked_add)
            };
            let once = ways.iter().map(|(_, way)| match *way {
                Way::Each => 0,
                Way::Unlimited(time) | Way::Together(time) => time,
            });
            once.into_iter().try_fold(works(&time)?, u64::checked_add)
        });
        each.into_iter().chain(together).min()
    }

    /// Returns the greatest time of a thread in those codels for which a task can wait, and that it executes
    /// a limited number of times.
    fn time_of_limited(&self, task: TaskId, thread: usize) -> Option<Ticks> {
        let rivals = self.rivals[thread].iter().filter(|rival| rival.plays_part(thread, task));
        let mut limited = rivals.filter_map(|rival| Some((rival.codel, rival.often?)));
        limited.try_fold(0, |sum: Ticks, (codel, often)| {
            sum.checked_add(self.upper(codel)?.checked_mul(often)?)
        })
    }

    /// Returns the greatest time of a periodic task, during a cycle of another task, in those codels for
    /// which that task can wait.
    fn time_in_cycles(
        &self,
        task: TaskId,
        cycle: Cycle,
        thread: usize,
        known: &Knowns,
    ) -> Option<Ticks> {
        let other = self.system.tasks.get(TaskId::from(thread)).map(|_| TaskId::from(thread))?;
        let (own, period) = (self.system.tasks[task].period?, self.system.tasks[other].period?);
        // A cycle of a task that meets its deadlines lies between its tick and the next one.
        known[task].after_tick?;
        if cycle != Cycle::Other || !self.is_started(other, task, cycle, known) {
            return None;
        }
        let cycles = match known[other].after_tick {
            Some(_) if self.has_same_ticks(task, cycle, other, known) => 1,
            Some(response) => (u64::from(own) + response).div_ceil(u64::from(period)),
            None => u64::from(own / period + 3),
        };
        let rivals = &self.rivals[thread];
        let time = |codel: CodelId| match rivals.iter().find(|rival| rival.codel == codel) {
            Some(rival) if rival.plays_part(thread, task) => self.upper(codel),
            _ => Some(0),
        };
        Ticks::try_from(self.works(other, Cycle::Other, cycles, &time)?).ok()
    }

    pub(super) fn upper(&self, codel: CodelId) -> Option<Ticks> {
        Some(self.system.codels[codel].upper).filter(|&upper| upper != FOREVER)
    }

    /// Returns the longest time of the codels of some cycles in the window, with this time for each.
    pub(super) fn works(
        &self,
        task: TaskId,
        cycle: Cycle,
        number: u64,
        time: &dyn Fn(CodelId) -> Option<Ticks>,
    ) -> Option<u64> {
        let each = u64::from(self.work(task, cycle, time)?).checked_mul(number);
        if number < 2 || cycle != Cycle::Other {
            return each;
        }
        // Each instance of an activity begins in one cycle, and has later turns, if any, in the others.
        let often = |slot: AutomatonId| {
            let service = self.system.automata[slot].service?;
            Some((self.client.requests[service]?, self.turns.later(slot, time)?))
        };
        let begins = self.system.tasks[task].slots.iter().try_fold(0u64, |sum, &slot| {
            let Some((often, later)) = often(slot) else {
                return Some(sum);
            };
            let more = self.turns.longest(slot, cycle, time)?.checked_sub(later)?;
            sum.checked_add(u64::from(more).checked_mul(u64::from(often))?)
        });
        let later = self.work_of(task, cycle, &|automaton| match often(automaton) {
            Some((_, later)) => Some(later),
            None => self.turns.longest(automaton, cycle, time),
        })?;
        let apart =
            begins.and_then(|begins| u64::from(later).checked_mul(number)?.checked_add(begins));
        each.into_iter().chain(apart).min()
    }

    /// Returns the longest time of the codels of a cycle, with this time for each.
    pub(super) fn work(
        &self,
        task: TaskId,
        cycle: Cycle,
        time: &dyn Fn(CodelId) -> Option<Ticks>,
    ) -> Option<Ticks> {
        self.work_of(task, cycle, &|automaton| self.turns.longest(automaton, cycle, time))
    }

    /// Returns the longest time of a cycle, with this time for the turns of each automaton.
    fn work_of(
        &self,
        task: TaskId,
        cycle: Cycle,
        turns: &dyn Fn(AutomatonId) -> Option<Ticks>,
    ) -> Option<Ticks> {
        let definition = &self.system.tasks[task];
        let mut length = 0;
        if let Some(permanent) = definition.permanent {
            length = turns(permanent)?;
        }
        if cycle != Cycle::Other {
            // Requests are taken after the first passes of all tasks of the component, and a cycle begins
            // activities in its first pass.
            return Some(length);
        }
        // By service: the greatest number of instances, and the time of each.
        let mut instances: Vec<(ServiceId, u32, Ticks)> = Vec::new();
        for &automaton in &definition.slots {
            let Some(service) = self.system.automata[automaton].service else {
                continue;
            };
            let most = self.client.requests[service].unwrap_or(definition.places);
            if most > 0 {
                instances.push((service, most, turns(automaton)?));
            }
        }
        instances.sort_unstable_by_key(|instance| std::cmp::Reverse(instance.2));
        // At most as many instances as places.
        let all = |count: &dyn Fn(ServiceId) -> u32| {
            let mut left = definition.places;
            instances.iter().try_fold(0, |sum: Ticks, &(service, most, time)| {
                let count = most.min(left).min(count(service));
                left -= count;
                sum.checked_add(time.checked_mul(count)?)
            })
        };
        let most = match &self.turns.parties[task] {
            None => all(&|_| u32::MAX)?,
            Some(parties) => {
                let of_party = |party: &Party| {
                    let count = |service| party.iter().filter(|other| **other == service).count();
                    all(&|service| count(service) as u32)
                };
                parties.iter().map(of_party).try_fold(0, |most, time| Some(time?.max(most)))?
            }
        };
        length.checked_add(most)
    }
}
