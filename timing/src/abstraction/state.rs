//! A state: what has been done, and when.

use super::model::Model;

/// A moment that is only known to lie between two others, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Span {
    pub(super) from: i64,
    pub(super) to: i64,
}

impl Span {
    pub(super) fn at(time: i64) -> Self {
        Span {
            from: time,
            to: time,
        }
    }

    /// The later of two moments.
    pub(super) fn max(self, other: Span) -> Self {
        Span {
            from: self.from.max(other.from),
            to: self.to.max(other.to),
        }
    }

    /// Widens it so that it contains another one; whether it did not.
    fn widen(&mut self, other: Span) -> bool {
        let before = *self;
        self.from = self.from.min(other.from);
        self.to = self.to.max(other.to);
        *self != before
    }

    fn shift(&mut self, by: i64) {
        self.from -= by;
        self.to -= by;
    }
}

/// Where a task is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Stage {
    /// Servers: not started yet.
    Off,
    /// Its next tick comes, and may find nothing to do.
    Idle,
    /// Its next job has been released, or will be, and has no core yet.
    Waiting,
    /// In a job: its next codel takes a ticket (or waits for its locks) when the last one has ended.
    Active,
    /// It has nothing to execute any more.
    Gone,
}

impl Stage {
    /// Whether something is still to be executed, as far as is known, by who has been started.
    pub(super) fn is_live(self) -> bool {
        matches!(self, Stage::Idle | Stage::Waiting | Stage::Active)
    }
}

/// Which cycle of a task it is, under the semantics of the servers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Cycle {
    /// The first one; the next task is started when its first pass ends.
    FirstPass,
    /// The first one, later on.
    First,
    /// One that is measured.
    Measured,
}

/// What a task has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Done {
    pub(super) stage: Stage,
    pub(super) cycle: Cycle,
    /// Active: the place that comes next. Before: the rest.
    pub(super) at: u16,
    /// Number of the tick that comes after the release of its job.
    pub(super) next: i32,
    /// The codel it executed last, counted from 1, if somebody may still have to wait for its end.
    pub(super) held: u32,
}

/// When.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct When {
    /// Waiting: when the job is released. Active: when its next codel is ready.
    pub(super) ready: Span,
    /// From when on the response time counts, at the earliest.
    pub(super) since: i64,
    /// When the codel executed last ends.
    pub(super) held: Span,
}

/// Where steps lead.
pub(super) struct Out<'o> {
    pub(super) states: &'o mut Vec<State>,
    /// By thread, the longest response time so far.
    pub(super) worst: &'o mut [i64],
}

/// A state of the graph.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct State {
    /// By thread.
    pub(super) done: Vec<Done>,
    pub(super) when: Vec<When>,
    /// Cores whose last job is done up to its last codel. The first of them is free at the first moment, and
    /// so on: no earlier …
    pub(super) free_from: Vec<i64>,
    /// … and no later.
    pub(super) free_to: Vec<i64>,
    /// By group, when the last codel began.
    pub(super) begun: Vec<Span>,
    /// No core is given any more before this moment.
    pub(super) given: i64,
    /// Steps from the first state to here; not part of what has been done.
    pub(super) steps: usize,
}

impl State {
    /// What it has in common with all states that are the same.
    pub(super) fn key(&self) -> Box<[Done]> {
        self.done.clone().into_boxed_slice()
    }

    pub(super) fn is(&self, thread: usize, stage: Stage) -> bool {
        self.done[thread].stage == stage
    }

    pub(super) fn all(&self, stage: Stage) -> impl Iterator<Item = usize> + '_ {
        (0..self.done.len()).filter(move |&it| self.is(it, stage))
    }

    /// Threads that still have something to execute, and have been started.
    fn live(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.done.len()).filter(|&it| self.done[it].stage.is_live())
    }

    /// Widens the intervals so that they contain those of another state in which the same has been done;
    /// whether they did not.
    pub(super) fn widen(&mut self, other: &State) -> bool {
        let mut wider = false;
        for (one, other) in self.when.iter_mut().zip(&other.when) {
            wider |= one.ready.widen(other.ready);
            wider |= one.held.widen(other.held);
            wider |= lower(&mut one.since, other.since);
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

    /// Forgets what no longer matters, and counts from the hyperperiod in which the oldest job was released.
    pub(super) fn tidy(&mut self, model: &Model) {
        let Some(now) = self.live().map(|it| self.when[it].ready.from).min() else {
            return;
        };
        // Nobody gets a core before somebody is ready.
        self.free_from.iter_mut().for_each(|it| *it = now.max(*it));
        self.free_to.iter_mut().for_each(|it| *it = now.max(*it));
        self.given = self.given.max(now);
        let mut earliest = vec![i64::MAX; model.groups];
        for it in self.live() {
            let group = &mut earliest[model.threads[it].group];
            *group = (*group).min(self.when[it].ready.from);
        }
        for (group, &earliest) in earliest.iter().enumerate() {
            let begun = &mut self.begun[group];
            *begun = match earliest {
                i64::MAX => Span::at(now),
                _ => begun.max(Span::at(earliest)),
            };
        }
        for (it, thread) in model.threads.iter().enumerate() {
            let over = self.when[it].held.to <= earliest[thread.group];
            if over || !thread.contends {
                self.done[it].held = 0;
            }
            if self.done[it].held == 0 {
                self.when[it].held = Span::default();
            }
            if !self.done[it].stage.is_live() {
                self.when[it].ready = Span::default();
                self.when[it].since = 0;
            }
        }
        self.shift(model);
    }

    fn shift(&mut self, model: &Model) {
        if self.done.iter().any(|it| it.stage == Stage::Off) {
            return;
        }
        let release = |it: usize| model.threads[it].tick(i64::from(self.done[it].next) - 1);
        let Some(oldest) = self.live().map(release).min() else {
            return;
        };
        let rounds = oldest.div_euclid(model.hyperperiod).max(0);
        let by = rounds * model.hyperperiod;
        if by == 0 {
            return;
        }
        for (it, thread) in model.threads.iter().enumerate() {
            let live = self.done[it].stage.is_live();
            if live {
                self.done[it].next -= (by / thread.period) as i32;
                self.when[it].ready.shift(by);
                self.when[it].since -= by;
            }
            if self.done[it].held != 0 {
                self.when[it].held.shift(by);
            }
        }
        let all = self.free_from.iter_mut().chain(&mut self.free_to);
        all.for_each(|it| *it -= by);
        self.begun.iter_mut().for_each(|it| it.shift(by));
        self.given -= by;
    }
}

fn lower(one: &mut i64, other: i64) -> bool {
    let lower = other < *one;
    *one = other.min(*one);
    lower
}
