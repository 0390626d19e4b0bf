//! Abstract states: the work done, and intervals of times.

use super::model::Model;
use super::span::Span;

/// The stage of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Stage {
    /// Servers: not started yet.
    Off,
    /// Its next tick comes, and may find no work. In its first pass: it may be started between the tick
    /// before and the next one.
    Idle,
    /// Its next job has been released, or will be, and has no core yet.
    Waiting,
    /// In a job: its next codel takes a ticket (or waits for its locks) when the previous one has ended.
    Active,
    /// It has nothing left to execute.
    Gone,
}

impl Stage {
    /// Returns true if a task has been started and may have work left.
    pub(super) fn is_live(self) -> bool {
        matches!(self, Stage::Idle | Stage::Waiting | Stage::Active)
    }
}

/// The cycle of a task, under the semantics of the servers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Cycle {
    /// The first cycle, in its first pass; the next task is started at the end of this pass.
    FirstPass,
    /// The first cycle, after its first pass.
    First,
    /// A measured cycle.
    Measured,
}

/// The work that a task has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct TaskProgress {
    pub(super) stage: Stage,
    pub(super) cycle: Cycle,
    /// Active: number of the next place. Otherwise: number of the rest.
    pub(super) at: u16,
    /// Number of the tick after the release of its job. Off: number of the first tick that may count.
    pub(super) next: i32,
    /// Last executed codel, counted from 1, if another codel may still wait for its end.
    pub(super) held: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct TaskTimes {
    /// Waiting: release of the job. Active: time at which its next codel is ready.
    pub(super) ready: Span,
    /// Earliest time from which the response time counts: the first tick that the job was kept for.
    pub(super) since: i64,
    /// The tick of the job may have been kept from the start-up. Its time is not known.
    pub(super) kept_from_start_up: bool,
    /// End of the last executed codel.
    pub(super) held: Span,
}

/// The results of a step.
pub(super) struct Out<'o> {
    pub(super) states: &'o mut Vec<State>,
    /// Longest response time so far, by thread, in base units.
    pub(super) worst: &'o mut [i64],
}

/// A state of the graph.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct State {
    /// Work done, by thread.
    pub(super) done: Vec<TaskProgress>,
    pub(super) when: Vec<TaskTimes>,
    /// Times at which cores become free after the last codel of their job, in ascending order: no earlier …
    pub(super) free_from: Vec<i64>,
    /// … and no later.
    pub(super) free_to: Vec<i64>,
    /// Beginning of the last codel, by group.
    pub(super) begun: Vec<Span>,
    /// No core is granted before this time.
    pub(super) given: i64,
    /// Number of steps from the first state; not part of the key.
    pub(super) steps: usize,
}

impl State {
    /// Returns the key: states with equal keys are merged.
    pub(super) fn key(&self) -> Box<[TaskProgress]> {
        self.done.clone().into_boxed_slice()
    }

    pub(super) fn is(&self, thread: usize, stage: Stage) -> bool {
        self.done[thread].stage == stage
    }

    pub(super) fn all(&self, stage: Stage) -> impl Iterator<Item = usize> + '_ {
        (0..self.done.len()).filter(move |&thread| self.is(thread, stage))
    }

    /// Returns the threads that have been started and have work left.
    fn live(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.done.len()).filter(|&thread| self.done[thread].stage.is_live())
    }

    /// Widens the intervals to contain those of another state with the same key. Returns true if they already
    /// did.
    pub(super) fn widen(&mut self, other: &State) -> bool {
        let mut wider = false;
        for (one, other) in self.when.iter_mut().zip(&other.when) {
            wider |= one.ready.widen(other.ready);
            wider |= one.held.widen(other.held);
            wider |= lower(&mut one.since, other.since);
            wider |= other.kept_from_start_up && !one.kept_from_start_up;
            one.kept_from_start_up |= other.kept_from_start_up;
        }
        for (one, other) in self.begun.iter_mut().zip(&other.begun) {
            wider |= one.widen(*other);
        }
        for (one, &other) in self.free_from.iter_mut().zip(&other.free_from) {
            wider |= lower(one, other);
        }
        for (one, &other) in self.free_to.iter_mut().zip(&other.free_to) {
            wider |= *one < other;
            *one = other.max(*one);
        }
        wider | lower(&mut self.given, other.given)
    }

    /// Clears irrelevant data, and counts times from the hyperperiod in which the oldest job was released.
    pub(super) fn normalise(&mut self, model: &Model) {
        let Some(now) = self.live().map(|thread| self.when[thread].ready.from).min() else {
            return;
        };
        // No core is granted before some task is ready.
        self.free_from.iter_mut().for_each(|number| *number = now.max(*number));
        self.free_to.iter_mut().for_each(|number| *number = now.max(*number));
        self.given = self.given.max(now);
        let mut earliest = vec![i64::MAX; model.groups];
        for thread in self.live() {
            let group = &mut earliest[model.threads[thread].group];
            *group = (*group).min(self.when[thread].ready.from);
        }
        for (group, &earliest) in earliest.iter().enumerate() {
            let begun = &mut self.begun[group];
            *begun = match earliest {
                i64::MAX => Span::at(now),
                _ => begun.max(Span::at(earliest)),
            };
        }
        for (index, thread) in model.threads.iter().enumerate() {
            let over = self.when[index].held.to <= earliest[thread.group];
            if over || !thread.contends {
                self.done[index].held = 0;
            }
            if self.done[index].held == 0 {
                self.when[index].held = Span::default();
            }
            if !self.done[index].stage.is_live() {
                self.when[index].ready = Span::default();
                self.when[index].since = 0;
                self.when[index].kept_from_start_up = false;
            }
        }
        self.shift(model);
    }

    fn shift(&mut self, model: &Model) {
        let release =
            |thread: usize| model.threads[thread].tick(i64::from(self.done[thread].next) - 1);
        let Some(oldest) = self.live().map(release).min() else {
            return;
        };
        let rounds = oldest.div_euclid(model.hyperperiod).max(0);
        let by = rounds * model.hyperperiod;
        if by == 0 {
            return;
        }
        for (index, thread) in model.threads.iter().enumerate() {
            let live = self.done[index].stage.is_live();
            if self.done[index].stage == Stage::Off {
                let next = i64::from(self.done[index].next) - by / thread.period;
                // All times are at least 0, so that an earlier tick makes no difference.
                self.done[index].next = next.max(thread.last_before_zero()) as i32;
            }
            if live {
                self.done[index].next -= (by / thread.period) as i32;
                self.when[index].ready.shift(by);
                self.when[index].since -= by;
            }
            if self.done[index].held != 0 {
                self.when[index].held.shift(by);
            }
        }
        let all = self.free_from.iter_mut().chain(&mut self.free_to);
        all.for_each(|number| *number -= by);
        self.begun.iter_mut().for_each(|span| span.shift(by));
        self.given -= by;
    }
}

fn lower(one: &mut i64, other: i64) -> bool {
    let lower = other < *one;
    *one = other.min(*one);
    lower
}

/// Returns a state in which no further step begins before a time.
pub(super) fn not_before(s: &State, time: i64) -> State {
    let mut s = s.clone();
    let active: Vec<usize> = s.all(Stage::Active).collect();
    for index in active {
        let ready = &mut s.when[index].ready;
        // The codel may have been ready before, and waited for its locks until now.
        *ready = ready.max(Span::at(time));
    }
    s
}
