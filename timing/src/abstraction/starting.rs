//! The consequences of the end of a codel: the end of a job, the ticks that came meanwhile, and the start of
//! the next task.

use super::cycle_automaton::Successor;
use super::model::Model;
use super::refusal::Refusal;
use super::span::Span;
use super::state::{Cycle, Out, Stage, State, TaskProgress, TaskTimes, not_before};

/// Number of periods by which a job may be late before its task is no longer followed.
const LATE: i64 = 64;

/// The outcome of a codel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// Another place follows in the same job.
    GoesOn(usize),
    /// The job is done; this rest comes before the next one.
    Pauses(usize),
    /// No further codel follows.
    Ends,
    /// The codel has thrown an exception.
    Fails,
}

impl From<Successor> for End {
    fn from(successor: Successor) -> Self {
        match successor {
            Successor::Goes(place) => End::GoesOn(place),
            Successor::Rests(rest) => End::Pauses(rest),
            Successor::Ends => End::Ends,
        }
    }
}

impl Model<'_> {
    /// Returns the initial states, in which no task has done anything.
    pub(super) fn initial(&self) -> Vec<State> {
        let threads = self.threads.len();
        let off =
            TaskProgress { stage: Stage::Off, cycle: Cycle::FirstPass, at: 0, next: 0, held: 0 };
        let blank = State {
            done: vec![off; threads],
            when: vec![TaskTimes::default(); threads],
            free_from: vec![0; self.cores.unwrap_or(0)],
            free_to: vec![0; self.cores.unwrap_or(0)],
            begun: vec![Span::default(); self.groups],
            given: 0,
            steps: 0,
        };
        let mut all = vec![blank];
        for (thread, entry) in self.threads.iter().enumerate() {
            if entry.started {
                continue;
            }
            let before = std::mem::take(&mut all);
            for mut s in before {
                let tick = (Span::at(entry.tick(0)), 1);
                if entry.start.after.is_none() {
                    self.may_start(&mut s, thread, 0);
                    all.push(s);
                } else if entry.paused.is_empty() {
                    all.extend(self.start(s, thread, Span::at(0), End::Ends));
                } else {
                    all.extend(entry.paused.iter().map(|&at| {
                        let mut s = s.clone();
                        self.release(&mut s, thread, tick, Cycle::Measured, at);
                        s
                    }));
                }
            }
        }
        let settled = all.into_iter().flat_map(|s| self.settle(s));
        let mut out: Vec<State> = settled.collect();
        for state in &mut out {
            state.normalise(self);
        }
        out
    }

    /// Releases the next job of a task.
    fn release(
        &self,
        s: &mut State,
        thread: usize,
        (ready, next): (Span, i64),
        cycle: Cycle,
        at: usize,
    ) {
        // In its first pass a task asks for a core whether it has work or not.
        let skips = cycle == Cycle::Measured
            && self.cycle_automaton(thread).is_some_and(|automaton| automaton.rests[at].skips);
        let progress = &mut s.done[thread];
        progress.stage = if skips { Stage::Idle } else { Stage::Waiting };
        progress.cycle = cycle;
        progress.at = at as u16;
        progress.next = next as i32;
        s.when[thread].ready = ready;
        s.when[thread].since = ready.from;
        let tick = self.threads[thread].tick(next - 1);
        s.when[thread].kept_from_start_up = ready != Span::at(tick);
    }

    /// Lets a task be started at any time between a tick and the next one, or later.
    fn may_start(&self, s: &mut State, thread: usize, tick: i64) {
        let entry = &self.threads[thread];
        let between = Span { from: entry.tick(tick), to: entry.tick(tick + 1) };
        self.release(s, thread, (between, tick + 1), Cycle::FirstPass, 0);
        s.done[thread].stage = Stage::Idle;
    }

    /// Returns the possible releases of the next job, each with the number of the tick after it. The task is
    /// idle, or started, from `from` on. `next` is the number of the next tick, not counting ticks before
    /// that moment. Several such ticks count as one.
    fn releases(&self, thread: usize, from: Span, next: i64) -> Vec<(Span, i64)> {
        let thread = &self.threads[thread];
        let mut out = Vec::new();
        if from.from <= thread.tick(next) {
            out.push((Span::at(thread.tick(next)), next + 1));
        }
        let mut tick = next;
        while thread.tick(tick) <= from.to {
            // This tick was the last one before.
            let kept = Span {
                from: from.from.max(thread.tick(tick)),
                to: from.to.min(thread.tick(tick + 1)),
            };
            tick += 1;
            if kept.from <= kept.to && !out.contains(&(kept, tick)) {
                out.push((kept, tick));
            }
        }
        out
    }

    /// Ends a codel of a task.
    pub(super) fn end_codel(
        &self,
        mut s: State,
        thread: usize,
        end: Span,
        how: End,
        out: &mut Out,
    ) -> Result<(), Refusal> {
        let cycle = s.done[thread].cycle;
        let next = i64::from(s.done[thread].next);
        let mut all = Vec::new();
        if let End::GoesOn(at) = how {
            s.done[thread].at = at as u16;
            s.when[thread].ready = end;
            if cycle == Cycle::FirstPass {
                s.done[thread].cycle = Cycle::First;
            }
            all.push(s);
        } else {
            if self.cores.is_some() {
                s.free_from.push(end.from);
                s.free_from.sort_unstable();
                s.free_to.push(end.to);
                s.free_to.sort_unstable();
            }
            if cycle == Cycle::Measured {
                let entry = &self.threads[thread];
                let late = end.to - entry.tick(next);
                if late / entry.period > LATE {
                    return Err(Refusal::MayMiss { task: entry.task });
                }
                let response = end.to - s.when[thread].since;
                // A job on a tick kept from the start-up may be late after less than a period.
                let least = if late < 0 { 0 } else { entry.period };
                out.worst[thread] = response.max(least).max(out.worst[thread]);
            }
            if let End::Pauses(at) = how {
                all.extend(self.rest(&s, thread, end, at));
            } else {
                self.leave(&mut s, thread);
                all.push(s);
            }
        }
        if cycle == Cycle::FirstPass
            && let Some(successor) = self.threads[thread].successor
        {
            all = all.into_iter().flat_map(|s| self.start(s, successor, end, how)).collect();
        }
        for s in all {
            for mut s in self.settle(s) {
                s.normalise(self);
                out.states.push(s);
            }
        }
        Ok(())
    }

    /// Releases the next job of a task after a rest.
    fn rest(&self, s: &State, thread: usize, end: Span, at: usize) -> Vec<State> {
        let next = i64::from(s.done[thread].next);
        let first_kept = self.threads[thread].tick(next);
        let measured = s.done[thread].cycle == Cycle::Measured;
        let releases = self.releases(thread, end, next).into_iter();
        let released = |release: (Span, i64)| {
            let mut s = s.clone();
            self.release(&mut s, thread, release, Cycle::Measured, at);
            // A tick kept from the start-up counts from its end.
            let when = &mut s.when[thread];
            if measured {
                when.since = release.0.from.min(first_kept);
            }
            when.kept_from_start_up = !measured && release.0 != Span::at(first_kept);
            s
        };
        releases.map(released).collect()
    }

    /// Handles a tick of an idle task: there is no work, or the task asks for a core. Or handles its start:
    /// it asks for a core for its first pass, or is started after the next tick.
    pub(super) fn tick(&self, s: &State, thread: usize, when: Span, out: &mut Out) {
        let mut asks = s.clone();
        asks.steps += 1;
        let at = s.done[thread].at as usize;
        let mut all = match s.done[thread].cycle {
            Cycle::FirstPass if when.to < s.when[thread].ready.to => Vec::new(),
            Cycle::FirstPass => {
                let mut later = not_before(&asks, when.to);
                self.may_start(&mut later, thread, i64::from(s.done[thread].next));
                vec![later]
            }
            _ => self.rest(&asks, thread, when, at),
        };
        asks.when[thread].ready = when;
        asks.done[thread].stage = Stage::Waiting;
        all.push(asks);
        for s in all {
            for mut s in self.settle(s) {
                s.normalise(self);
                out.states.push(s);
            }
        }
    }

    /// Removes a task that has nothing left to execute.
    fn leave(&self, s: &mut State, thread: usize) {
        let progress = &mut s.done[thread];
        (progress.stage, progress.cycle, progress.at, progress.next) =
            (Stage::Gone, Cycle::Measured, 0, 0);
    }

    /// Starts the next task after the first pass of a task. After a failure, no further task is started.
    fn start(&self, s: State, thread: usize, end: Span, how: End) -> Vec<State> {
        let start = self.threads[thread].start;
        let mut out = Vec::new();
        if how == End::Fails || start.fails {
            let mut s = s.clone();
            let mut next = Some(thread);
            while let Some(thread) = next {
                self.leave(&mut s, thread);
                next = self.threads[thread].successor;
            }
            out.push(s);
        }
        if let Some(after) = start.after.filter(|_| how != End::Fails) {
            let first = i64::from(s.done[thread].next);
            for release in self.releases(thread, end.plus(after), first) {
                let mut s = s.clone();
                self.release(&mut s, thread, release, Cycle::FirstPass, 0);
                out.push(s);
            }
        }
        out
    }

    /// Grants cores at once if there are enough cores for all tasks.
    fn settle(&self, s: State) -> Vec<State> {
        if self.cores.is_some() {
            return vec![s];
        }
        let mut todo = vec![s];
        let mut out = Vec::new();
        while let Some(s) = todo.pop() {
            let waiting = s.all(Stage::Waiting).next();
            let Some(thread) = waiting else {
                out.push(s);
                continue;
            };
            let begin = s.when[thread].ready;
            for how in self.begins(&s, thread) {
                todo.extend(self.begin_job(s.clone(), thread, begin, how));
            }
        }
        out
    }

    /// Returns the possible beginnings of a job after a rest.
    pub(super) fn begins(&self, s: &State, thread: usize) -> Vec<End> {
        match self.cycle_automaton(thread) {
            Some(automaton) => {
                let begins = automaton.rests[s.done[thread].at as usize].begins.iter();
                begins.map(|successor| End::from(*successor)).collect()
            }
            None => vec![End::Ends],
        }
    }

    /// Begins a job: with a codel, or with its end.
    pub(super) fn begin_job(
        &self,
        mut s: State,
        thread: usize,
        when: Span,
        how: End,
    ) -> Vec<State> {
        if let End::GoesOn(place) = how {
            s.done[thread].stage = Stage::Active;
            s.done[thread].at = place as u16;
            return vec![s];
        }
        let first = s.done[thread].cycle == Cycle::FirstPass;
        let all = if let End::Pauses(rest) = how {
            self.rest(&s, thread, when, rest)
        } else {
            self.leave(&mut s, thread);
            vec![s]
        };
        match self.threads[thread].successor.filter(|_| first) {
            Some(next) => all.into_iter().flat_map(|s| self.start(s, next, when, how)).collect(),
            None => all,
        }
    }
}
