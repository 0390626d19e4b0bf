//! The demand function: the most work that other tasks can do in a window of time. Times are in base units.

use std::cmp::Reverse;

use crate::system::Ticks;

/// Length of a window above which the analysis gives up.
const HORIZON: u64 = 1 << 31;

/// Rounds after which the analysis gives up: a quick bound must be quick.
const ROUNDS: usize = 10_000;

/// The jobs of a periodic task, as a demand on others.
#[derive(Debug, Clone)]
pub(super) struct Jobs {
    pub(super) period: Ticks,
    /// Greatest work of a job.
    pub(super) work: u64,
    /// Greatest work that belongs to some of the jobs only, in all.
    pub(super) once: u64,
    pub(super) kind: Kind,
    /// Only jobs released at most this long after the beginning of the window count; `None`: none of these.
    pub(super) released: Option<u64>,
}

/// The greatest work of the jobs of a task, split into that of every job and that of single jobs.
#[derive(Debug, Clone, Copy)]
pub(super) struct SplitWork {
    /// In each job, without activities that begin in it.
    pub(super) each: u64,
    /// Of all activities together, in the jobs in which they begin.
    pub(super) begins: u64,
}

/// The pattern of the jobs of a task.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// Jobs end at most this long after their release, before the next release.
    Punctual(u64),
    /// Punctual jobs, in a window that begins some time after a release: `first`, or some multiple of `every`
    /// later, and at most `width` later than that.
    InPhase { response: u64, first: u64, every: u64, width: u64 },
    /// At the beginning of the window, up to this many released jobs are unfinished.
    Late(u64),
    /// The window begins at the start of the system, and the first release is this much later.
    First(u64),
}

impl Jobs {
    /// Work that is done once, by one task.
    pub(super) fn once(work: u64) -> Jobs {
        Jobs { period: Ticks::MAX, work, once: 0, kind: Kind::Late(1), released: None }
    }

    /// Returns the same jobs, with their work split if that is known.
    pub(super) fn with(self, split: Option<SplitWork>) -> Jobs {
        match split {
            Some(SplitWork { each, begins }) => Jobs { work: each, once: begins, ..self },
            None => self,
        }
    }

    /// Returns the number of releases in a window of this length, including its end, the first of them after
    /// `offset`.
    fn releases(&self, window: u64, offset: u64) -> u64 {
        match window.checked_sub(offset) {
            Some(rest) => rest / u64::from(self.period) + 1,
            None => 0,
        }
    }

    /// Returns the greatest work in a window, and how much of it is done at the end of the window: 0 or 1.
    ///
    /// The worst window begins when all the work of a job is still to do, and the job ends as late as
    /// possible: so the next job is released as early as possible. (An earlier window has less of the first
    /// job and at most as much more of the last one.)
    fn demand(&self, window: u64) -> (u64, u64) {
        let (demand, at_end) = self.demand_of_each(window);
        (demand.saturating_add(self.once), at_end)
    }

    /// The same, without the work that belongs to some jobs only.
    fn demand_of_each(&self, window: u64) -> (u64, u64) {
        match self.kind {
            Kind::First(tick) => (self.releases(window, tick).saturating_mul(self.work), 0),
            Kind::Late(carried) => {
                let released = self.released.map_or(0, |number| self.releases(number, 0));
                let count = carried + released.min(self.releases(window, 0));
                (count.saturating_mul(self.work), 0)
            }
            Kind::InPhase { response, width, .. } => {
                let count = |since: u64| {
                    let carried = self.work.min(response.saturating_sub(since));
                    let released = self.released(window, since + width);
                    released.saturating_mul(self.work).saturating_add(carried)
                };
                (self.since_release().map(count).max().unwrap_or(0), 0)
            }
            Kind::Punctual(response) => {
                let least = u64::from(self.period) - response;
                let most = self.released.map_or(0, |number| self.releases(number, least));
                let offset = least + self.work;
                let count = most.min(self.releases(window, offset));
                let Some(before) = count.checked_sub(1) else {
                    return (self.work, 0);
                };
                let last = window - offset - before * u64::from(self.period);
                let demand = (1 + before).saturating_mul(self.work);
                (demand.saturating_add(last.min(self.work)), u64::from(last < self.work))
            }
        }
    }

    /// Returns the times that can have elapsed since the last release when the window begins.
    fn since_release(&self) -> impl Iterator<Item = u64> {
        let (first, every) = match self.kind {
            Kind::InPhase { first, every, .. } => (first, every),
            _ => (0, 1),
        };
        (first..u64::from(self.period)).step_by(every as usize)
    }

    /// Returns the greatest part of some work of a job that is left when the window begins.
    pub(super) fn carried(&self, work: u64) -> u64 {
        let Kind::InPhase { response, first, every, width } = self.kind else {
            return work;
        };
        if first + width >= every {
            // A job may have been released just before.
            return work;
        }
        let since = self.since_release().next();
        since.map_or(0, |since| work.min(response.saturating_sub(since)))
    }

    /// Returns the number of releases that count in a window that begins this long after a release.
    fn released(&self, window: u64, since: u64) -> u64 {
        let elapsed = |window: u64| since.saturating_add(window) / u64::from(self.period);
        self.released.map_or(0, elapsed).min(elapsed(window))
    }

    /// Returns the next window length at which the work at the end of the window changes.
    fn change(&self, window: u64) -> u64 {
        let period = u64::from(self.period);
        let next = |offset: u64| match window.checked_sub(offset) {
            Some(rest) => offset + (rest / period + 1) * period,
            None => offset,
        };
        match self.kind {
            Kind::First(tick) => next(tick),
            Kind::Late(_) => next(0),
            Kind::InPhase { width, .. } => {
                let changes = self.since_release().map(|since| {
                    let elapsed = (since + width) % period;
                    next(period - elapsed)
                });
                changes.min().unwrap_or(window + 1)
            }
            Kind::Punctual(response) => {
                let offset = period - response + self.work;
                next(offset).min(next(offset + self.work))
            }
        }
    }
}

/// A task that works for ever, but with breaks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretches {
    /// Longest work without a break.
    pub(super) work: u64,
    /// Shortest break; `None` if there is only one stretch.
    pub(super) gap: Option<u64>,
}

/// All work that can delay a job or a codel.
#[derive(Debug, Clone, Default)]
pub(super) struct Demand {
    pub(super) jobs: Vec<Jobs>,
    pub(super) stretches: Vec<Stretches>,
    /// Work that is done once.
    pub(super) once: u64,
}

impl Demand {
    /// Returns the greatest work in a window, and how much of it is done at its end. If there are several
    /// servers, the jobs of a task have at most one of them.
    fn within(&self, window: u64, servers: u64) -> Option<(u64, u64)> {
        let mut jobs = self.once;
        let mut slope = 0;
        for job in &self.jobs {
            let (demand, at_end) = match job.demand(window) {
                (demand, _) if servers > 1 && demand > window => (window, 1),
                other => other,
            };
            jobs = jobs.checked_add(demand)?;
            slope += at_end;
        }
        // During every break another task must be at work.
        let mut done = vec![0u64; self.stretches.len()];
        for _ in 0..ROUNDS {
            let all = done.iter().try_fold(jobs, |sum, &number| sum.checked_add(number))?;
            if all > HORIZON {
                return None;
            }
            let stretch = |i: usize| {
                let stretch = self.stretches[i];
                let breaks = stretch.gap.map_or(0, |gap| (all - done[i]) / gap);
                stretch.work.checked_mul(1 + breaks)
            };
            let next: Vec<u64> = (0..done.len()).map(stretch).collect::<Option<_>>()?;
            if next == done {
                return Some((all, slope));
            }
            done = next;
        }
        None
    }

    /// Returns the longest time for which this many servers can be busy without a break; `None` if it is not
    /// known.
    pub(super) fn longest_busy(&self, servers: u64) -> Option<u64> {
        let mut window = 0;
        for _ in 0..ROUNDS {
            let (demand, slope) = self.within(window, servers)?;
            let next = demand / servers;
            window = if next > window {
                next
            } else if demand + slope < servers.checked_mul(window + 1)? {
                return Some(window);
            } else if slope >= servers {
                let change = |job: &Jobs| match job.demand(window) {
                    (demand, _) if servers > 1 && demand > window => demand,
                    _ => job.change(window),
                };
                self.jobs.iter().map(change).min().unwrap_or(window + 1)
            } else {
                window + 1
            };
            if window > HORIZON {
                return None;
            }
        }
        None
    }
}

/// Returns the longest wait for a core: the greatest *x* for which cores · *x* ≤ Σ min(work, *x*), rounded
/// up. Returns `None` without cores.
pub(super) fn longest_wait(cores: u64, mut works: Vec<u64>) -> Option<u64> {
    works.sort_unstable_by_key(|&work| Reverse(work));
    let mut rest = works.iter().try_fold(0u64, |sum, &work| sum.checked_add(work))?;
    for (left, work) in (1..=cores).rev().zip(works) {
        // The works before this one last longer than the wait, so that each of them occupies a core.
        if work.checked_mul(left)? <= rest {
            return Some(rest.div_ceil(left));
        }
        rest -= work;
    }
    (cores > 0).then_some(0)
}
