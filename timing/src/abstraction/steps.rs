//! The two kinds of steps: a task gets a core, and a codel begins.
//!
//! Cores are granted in order of time, and the codels of a group take their tickets (or their locks) in order
//! of time. Other steps can be taken in any order, because the knowledge about each of them remains true.

use super::model::Model;
use super::refusal::Refusal;
use super::span::Span;
use super::starting::End;
use super::state::{Cycle, Out, Stage, State, not_before};
use crate::system::{CodelId, CodelSet, Policy};

impl Model<'_> {
    /// Writes the successors of a state. Each run that reaches the state continues in one of them.
    pub(super) fn follow(&self, s: &State, out: &mut Out) -> Result<(), Refusal> {
        if let Some((group, until)) = self.next_independent_group(s) {
            let own = |&thread: &usize| self.threads[thread].group == group;
            for thread in s.all(Stage::Active).filter(own) {
                if self.earliest(s, thread) <= until {
                    self.begin_codel(s, thread, until, out)?;
                }
            }
            return Ok(());
        }
        // Next step of all, in the order of time: no other step comes earlier.
        let active = s.all(Stage::Active).map(|thread| self.latest(s, thread));
        let ticks = s.all(Stage::Idle).map(|thread| s.when[thread].ready.to);
        let until = active.chain(ticks).min().unwrap_or(i64::MAX);
        let given = self.next_core_grant(s).unwrap_or(i64::MAX).min(until);
        // A tick that comes at a known time is decided first, because the decision changes nothing before it.
        let decided = s.all(Stage::Idle).find(|&thread| {
            let ready = s.when[thread].ready;
            ready.from == ready.to && ready.to <= given && s.done[thread].cycle == Cycle::Measured
        });
        if let Some(thread) = decided {
            self.tick(s, thread, s.when[thread].ready, out);
            return Ok(());
        }
        for thread in s.all(Stage::Active) {
            let earliest = self.earliest(s, thread);
            if earliest <= given {
                self.begin_codel(&not_before(s, earliest), thread, given, out)?;
            }
        }
        for thread in s.all(Stage::Idle) {
            let mut when = s.when[thread].ready;
            if when.from <= given {
                when.to = when.to.min(given);
                self.tick(&not_before(s, when.from), thread, when, out);
            }
        }
        for thread in s.all(Stage::Waiting) {
            if let Some(mut when) = self.gets_core(s, thread)
                && when.from <= given
            {
                when.to = when.to.min(given);
                self.give_core(&not_before(s, when.from), thread, when, out)?;
            }
        }
        Ok(())
    }

    /// Returns a group whose next codel begins before any of its tasks without a core can get one, and the
    /// latest time of that. Other groups make no difference.
    fn next_independent_group(&self, s: &State) -> Option<(usize, i64)> {
        let mut until = vec![i64::MAX; self.groups];
        let mut holder = i64::MAX;
        for thread in s.all(Stage::Active) {
            let group = &mut until[self.threads[thread].group];
            *group = (*group).min(self.latest(s, thread));
            holder = holder.min(s.when[thread].ready.from);
        }
        let core = s.free_from.first().map_or(holder, |number| holder.min(*number));
        let core = core.max(s.given);
        for thread in s.all(Stage::Waiting) {
            let group = &mut until[self.threads[thread].group];
            if s.when[thread].ready.from.max(core) <= *group {
                *group = i64::MAX;
            }
        }
        for thread in s.all(Stage::Idle) {
            let group = &mut until[self.threads[thread].group];
            if s.when[thread].ready.from <= *group {
                *group = i64::MAX;
            }
        }
        let (group, &until) = until.iter().enumerate().min_by_key(|(_, until)| *until)?;
        (until != i64::MAX).then_some((group, until))
    }

    /// Returns the next codel of an active task.
    fn codel(&self, s: &State, thread: usize) -> Option<CodelId> {
        let place = self.cycle_automaton(thread)?.places.get(s.done[thread].at as usize)?;
        Some(place.codel)
    }

    /// Returns the time at which all begun codels have ended that the next codel of a task waits for.
    fn holders(&self, s: &State, thread: usize) -> Option<Span> {
        let codel = self.codel(s, thread)?;
        self.ends_of(s, thread, &self.system.codels[codel].conflicts)
    }

    /// Returns the time at which all of these codels have ended, as far as they have begun. Codels of the
    /// task itself have ended.
    fn ends_of(&self, s: &State, thread: usize, codels: &CodelSet) -> Option<Span> {
        let entry = &self.threads[thread];
        if !entry.contends {
            return None;
        }
        let others = (0..self.threads.len()).filter(|&other| {
            other != thread && self.threads[other].group == entry.group && s.done[other].held != 0
        });
        let holders =
            others.filter(|&other| codels.contains(CodelId::from(s.done[other].held as usize - 1)));
        holders.map(|other| s.when[other].held).reduce(Span::max)
    }

    /// Returns the earliest time of the next step of an active task: taking a ticket, or beginning.
    fn earliest(&self, s: &State, thread: usize) -> i64 {
        let ready = s.when[thread].ready.from;
        match self.holders(s, thread).filter(|_| !self.queue) {
            Some(holder) => holder.from.max(ready),
            None => ready,
        }
    }

    /// Returns the latest time of the next step of an active task, unless another one of the group comes
    /// first.
    fn latest(&self, s: &State, thread: usize) -> i64 {
        let ready = s.when[thread].ready.to;
        match self.holders(s, thread).filter(|_| !self.queue) {
            Some(holder) => holder.to.max(ready),
            None => ready,
        }
    }

    /// Lets a codel take its ticket (or begin, without a queue), by `until` and before all other waiting
    /// codels of its group.
    fn begin_codel(
        &self,
        s: &State,
        thread: usize,
        until: i64,
        out: &mut Out,
    ) -> Result<(), Refusal> {
        let entry = &self.threads[thread];
        let Some(place) = self
            .cycle_automaton(thread)
            .and_then(|automaton| automaton.places.get(s.done[thread].at as usize))
        else {
            return Ok(());
        };
        let mut s = s.clone();
        s.steps += 1;
        let mut begin =
            Span { from: self.earliest(&s, thread), to: self.latest(&s, thread).min(until) };
        let contends = entry.contends && place.waits;
        if contends {
            let ticket = begin;
            if self.queue {
                // After the previous codel of the queue, and not while a conflicting codel executes.
                begin = begin.max(s.begun[entry.group]);
                if let Some(holders) = self.holders(&s, thread) {
                    begin = begin.max(holders);
                }
                // First passes come before requests, and before the start of tasks that are declared later.
                let others = match s.done[thread].cycle {
                    Cycle::FirstPass => &entry.early,
                    _ => &self.interference[entry.group],
                };
                if let Some(others) = others {
                    let awaited = self.ends_of(&s, thread, &others.waits_for);
                    begin.to = begin.to.max(awaited.map_or(begin.to, |span| span.to));
                    let longest = others.longest[place.codel];
                    begin.to += longest.ok_or(Refusal::Endless { task: entry.task })?;
                }
            }
            // This codel comes first, so all others of the group take their tickets (or, without a queue,
            // begin) no earlier.
            let others =
                |&other: &usize| other != thread && self.threads[other].group == entry.group;
            let others: Vec<usize> = s.all(Stage::Active).filter(others).collect();
            for other in others {
                let ready = &mut s.when[other].ready;
                if self.queue {
                    ready.from = ready.from.max(ticket.from);
                } else {
                    *ready = ready.max(begin);
                }
            }
            s.begun[entry.group] = begin;
        }
        let end = begin.plus(place.time);
        (s.done[thread].held, s.when[thread].held) = (0, Span::default());
        if contends && self.waited_for[place.codel] {
            s.done[thread].held = usize::from(place.codel) as u32 + 1;
            s.when[thread].held = end;
        }
        // A failure in the first pass means that the component never starts.
        let fails = !place.thrown.is_empty() && s.done[thread].cycle == Cycle::FirstPass;
        let thrown = place.thrown.iter().filter(|_| !fails);
        for &exception in place.then.iter().chain(thrown) {
            self.end_codel(s.clone(), thread, end, End::from(exception), out)?;
        }
        if fails {
            self.end_codel(s, thread, end, End::Fails, out)?;
        }
        Ok(())
    }

    /// Returns the latest time of the next grant of a core, if a task waits for one and a core is known to be
    /// free by then.
    fn next_core_grant(&self, s: &State) -> Option<i64> {
        let released = s.all(Stage::Waiting).map(|thread| s.when[thread].ready.to).min()?;
        // Other threads may hold the cores that are free first.
        Some(released.max(*s.free_to.get(self.lent)?))
    }

    /// Returns the times at which a task can be the next to get a core.
    fn gets_core(&self, s: &State, thread: usize) -> Option<Span> {
        let ready = s.when[thread].ready;
        let from = ready.from.max(*s.free_from.first()?).max(s.given);
        let mut to = self.next_core_grant(s).unwrap_or(i64::MAX);
        for other in s.all(Stage::Waiting).filter(|&other| other != thread) {
            let released = s.when[other].ready.to;
            match self.policy {
                Policy::Fifo if released < ready.from => return None,
                Policy::Edf => {
                    let (Some(own), Some(deadline)) =
                        (self.deadline(s, thread), self.deadline(s, other))
                    else {
                        continue;
                    };
                    // With equal deadlines, the task that has waited for longer goes first.
                    let equal = own.from == deadline.to && released < ready.from;
                    if deadline.to < own.from || equal {
                        to = to.min(released);
                    }
                }
                _ => {}
            }
        }
        (from <= to).then_some(Span { from, to })
    }

    /// Returns the deadline of the job of a waiting task, unless the job is that of a tick kept from its
    /// start-up.
    fn deadline(&self, s: &State, thread: usize) -> Option<Span> {
        let entry = &self.threads[thread];
        let times = &s.when[thread];
        let tick = entry.tick(i64::from(s.done[thread].next) - 1);
        (!times.kept_from_start_up)
            .then(|| Span { from: times.since.min(tick) + entry.period, to: tick + entry.period })
    }

    fn give_core(
        &self,
        s: &State,
        thread: usize,
        when: Span,
        out: &mut Out,
    ) -> Result<(), Refusal> {
        let mut s = s.clone();
        s.steps += 1;
        s.given = when.from;
        s.free_from.remove(0);
        s.free_to.remove(0);
        s.when[thread].ready = when;
        for how in self.begins(&s, thread) {
            match how {
                End::GoesOn(_) => {
                    for mut s in self.begin_job(s.clone(), thread, when, how) {
                        s.normalise(self);
                        out.states.push(s);
                    }
                }
                _ => self.end_codel(s.clone(), thread, when, how, out)?,
            }
        }
        Ok(())
    }
}
