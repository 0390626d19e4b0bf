//! Busy windows: jobs that share only cores, taken in one step.
//!
//! If many jobs are released at the same moment, nearly every set of them can be done first, and there are
//! too many of these sets. (The partial-order reduction for schedule-abstraction graphs of S. Ranjha, G.
//! Nelissen, M. Nasri, RTSS 2021 and after, treats the same problem.) So a bound on the end of each job is
//! computed without a distinction of orders. If each job keeps its deadline by its bound, and all jobs are
//! done before the next release, the subsequent behaviour does not depend on the order either.
//!
//! The bound of a job counts, from its release on, the work that can be done before the job gets a core: jobs
//! that go before it, as far as they may not be done yet. Under earliest deadline first it also counts, for
//! each core, at most one job under way that would not go before it. While the job waits all cores work. The
//! bounds are the least fixed point of these equations. Until the first job exceeds its own bound, all others
//! have kept theirs; so no job is the first.

use super::cycle_automaton::Successor;
use super::model::Model;
use super::span::Span;
use super::state::{Cycle, Out, Stage, State};
use crate::system::Policy;

/// Upper limit on the jobs of a window.
const JOBS: usize = 2_000;

/// Upper limit on the rounds until bounds no longer change.
const ROUNDS: usize = 200;

/// A system whose tasks share only cores.
#[derive(Debug)]
pub(super) struct Batches<'m> {
    model: &'m Model<'m>,
    cores: i64,
    /// Jobs that follow each rest of a thread, if all of them end in the same rest, by thread and rest.
    turns: Vec<Vec<Option<Turn>>>,
}

/// Jobs of a task that begin after the same rest.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// Longest work of these jobs.
    work: i64,
    /// Rest after the job.
    then: usize,
}

struct Job {
    thread: usize,
    release: i64,
    deadline: i64,
    work: i64,
    /// The job is measured. Under the semantics of the servers the first job is not.
    measured: bool,
    /// Bound on the end of the job.
    end: i64,
}

impl<'m> Batches<'m> {
    /// Returns `None` if some tasks share more than cores, or never pause at a known place.
    pub(super) fn new(model: &'m Model<'m>) -> Option<Self> {
        let cores = i64::try_from(model.cores?).ok()?;
        if model.lent > 0 {
            return None;
        }
        let mut all = Vec::new();
        for (thread, entry) in model.threads.iter().enumerate() {
            let rests = 0..model.cycle_automaton(thread)?.rests.len();
            let turns: Vec<Option<Turn>> = rests.map(|at| turn(model, thread, at)).collect();
            if entry.contends || turns.iter().all(Option::is_none) {
                return None;
            }
            all.push(turns);
        }
        Some(Batches { model, cores, turns: all })
    }

    /// Takes the busy window at the beginning of a state, if the window proves all its deadlines.
    pub(super) fn follow(&self, s: &State, out: &mut Out) -> bool {
        let rests = |thread: usize| {
            let ready = s.when[thread].ready;
            // The end of a first pass starts another task, whose ticks count from then on.
            let starts = self.model.threads[thread].successor.is_some();
            s.is(thread, Stage::Waiting)
                && (s.done[thread].cycle == Cycle::Measured || !starts)
                && ready.from == ready.to
                && s.when[thread].since == ready.from
                && ready.from == self.model.threads[thread].tick(i64::from(s.done[thread].next) - 1)
        };
        if !(0..self.model.threads.len()).all(rests) {
            return false;
        }
        let Some(jobs) = self.window(s) else {
            return false;
        };
        let mut s = s.clone();
        s.steps += jobs.len();
        for job in &jobs {
            if job.measured {
                let worst = &mut out.worst[job.thread];
                *worst = (*worst).max(job.end - job.release);
            }
            let done = &mut s.done[job.thread];
            done.next += 1;
            done.cycle = Cycle::Measured;
            if let Some(turn) = self.turns[job.thread][done.at as usize] {
                done.at = turn.then as u16;
            }
        }
        let over = jobs.iter().map(|job| job.end).max().unwrap_or(0);
        for (index, thread) in self.model.threads.iter().enumerate() {
            let tick = thread.tick(i64::from(s.done[index].next) - 1);
            s.when[index].ready = Span::at(tick);
            s.when[index].since = tick;
        }
        s.free_to.iter_mut().for_each(|number| *number = over.max(*number));
        s.normalise(self.model);
        out.states.push(s);
        true
    }

    /// Returns the jobs that are done before the next release, with bounds on their ends by which all jobs
    /// keep their deadlines.
    fn window(&self, s: &State) -> Option<Vec<Job>> {
        let ready = |index: usize| s.when[index].ready.from;
        let mut at: Vec<usize> = s.done.iter().map(|progress| progress.at as usize).collect();
        let begin = (0..s.done.len()).map(ready).min()?;
        // Work that is still under way at the beginning of the window.
        let rest: i64 = s.free_to.iter().map(|number| (number - begin).max(0)).sum();
        let mut until = begin;
        let mut jobs: Vec<Job> = Vec::new();
        let mut taken = vec![0i64; s.done.len()];
        loop {
            for (thread, taken) in taken.iter_mut().enumerate() {
                let entry = &self.model.threads[thread];
                loop {
                    let release = ready(thread) + *taken * entry.period;
                    if release > until {
                        break;
                    }
                    let turn = self.turns[thread][at[thread]]?;
                    at[thread] = turn.then;
                    jobs.push(Job {
                        thread,
                        release,
                        deadline: release + entry.period,
                        work: turn.work,
                        measured: *taken > 0 || s.done[thread].cycle == Cycle::Measured,
                        end: release + turn.work,
                    });
                    *taken += 1;
                }
            }
            if jobs.len() > JOBS || until - begin > self.model.hyperperiod {
                return None;
            }
            jobs.sort_by_key(|job| job.release);
            self.bound(&mut jobs, begin, rest)?;
            let over = jobs.iter().map(|job| job.end).max()?;
            // The window ends when all jobs released so far are done.
            if over <= until {
                return Some(jobs);
            }
            until = over;
        }
    }

    /// Computes bounds on the ends of jobs, in the order of their releases; `None` if a deadline may be
    /// missed.
    fn bound(&self, jobs: &mut [Job], begin: i64, rest: i64) -> Option<()> {
        let backlog = backlog(jobs, begin, rest);
        // Fixed-point iteration from below, which finds the least bounds.
        for _ in 0..ROUNDS {
            let ends: Vec<i64> = (0..jobs.len())
                .map(|job| self.end(jobs, job, (begin, rest), backlog[job]))
                .collect::<Option<_>>()?;
            let mut changed = false;
            for (job, end) in jobs.iter_mut().zip(ends) {
                changed |= end > job.end;
                job.end = job.end.max(end);
            }
            if !changed {
                return Some(());
            }
        }
        None
    }

    /// Returns the latest end of a job, given bounds on those of all others; `None` if the end is not before
    /// the deadline.
    fn end(
        &self,
        jobs: &[Job],
        number: usize,
        (begin, rest): (i64, i64),
        backlog: i64,
    ) -> Option<i64> {
        let job = &jobs[number];
        let first = |other: &Job| match self.model.policy {
            Policy::Fifo => other.release <= job.release,
            Policy::Edf => other.deadline <= job.deadline,
            _ => true,
        };
        let others = || {
            let all = jobs.iter().enumerate();
            all.filter(|&(index, _)| index != number).map(|(_, job)| job)
        };
        let under_way = |other: &&Job| other.release <= job.release && other.end > job.release;
        // While the job waits, all cores work: on earlier work …
        let left = (begin + rest - job.release).max(0).min(rest);
        let mut last: Vec<i64> =
            others().filter(under_way).filter(|job| !first(job)).map(|job| job.work).collect();
        last.sort_unstable_by_key(|work| -work);
        if self.model.policy == Policy::Fifo {
            last.clear();
        }
        let last: i64 = last.iter().take(self.cores as usize).sum();
        let before: i64 =
            others().filter(under_way).filter(|job| first(job)).map(|job| job.work).sum();
        let mut present = left + last + before;
        if self.cores == 1 {
            present = present.min(backlog);
        }
        // … and on work that arrives while the job waits, and goes before it.
        let mut begins = job.release + present / self.cores;
        loop {
            if begins + job.work >= job.deadline {
                return None;
            }
            let later =
                others().filter(|other| other.release > job.release && other.release <= begins);
            let more: i64 = later.filter(|job| first(job)).map(|job| job.work).sum();
            let next = job.release + (present + more) / self.cores;
            if next <= begins {
                return Some(begins + job.work);
            }
            begins = next;
        }
    }
}

/// Returns, by job, an upper bound on the remaining work of all other jobs at its release, on one core. Jobs
/// released at the same moment count.
fn backlog(jobs: &[Job], begin: i64, rest: i64) -> Vec<i64> {
    let mut out = Vec::with_capacity(jobs.len());
    for job in jobs {
        let (mut left, mut now) = (rest, begin);
        for other in jobs.iter().filter(|other| other.release <= job.release) {
            left = (left - (other.release - now)).max(0) + other.work;
            now = other.release;
        }
        out.push(left - job.work);
    }
    out
}

/// Returns the jobs of a task that follow a rest; `None` if they may not come, or can end in several rests,
/// or can be the last.
fn turn(model: &Model, thread: usize, from: usize) -> Option<Turn> {
    let cycle_automaton = model.cycle_automaton(thread)?;
    let rest = &cycle_automaton.rests[from];
    let (false, &[Successor::Goes(first)]) = (rest.skips, &rest.begins[..]) else {
        return None;
    };
    // Without cycles, a place is visited once for each path to it; there are few.
    let mut todo = vec![(first, 0i64)];
    let (mut work, mut then, mut looked_at) = (0, None, 0);
    while let Some((at, before)) = todo.pop() {
        looked_at += 1;
        let place = &cycle_automaton.places[at];
        let codel = &model.system.codels[place.codel];
        if looked_at > 1_000 || codel.throws {
            return None;
        }
        let until = before + place.time.to;
        for successor in &place.then {
            match *successor {
                Successor::Goes(next) => todo.push((next, until)),
                Successor::Rests(next) if then.is_none_or(|then| then == next) => {
                    then = Some(next);
                    work = until.max(work);
                }
                _ => return None,
            }
        }
    }
    then.map(|then| Turn { work, then })
}
