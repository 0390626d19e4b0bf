//! How long others can keep somebody waiting: what they do at most in a window of time.

use crate::system::Ticks;

/// Windows above this are given up.
const HORIZON: u64 = 1 << 31;

/// Windows that are not found in so many rounds are given up: a quick bound must be quick.
const ROUNDS: usize = 10_000;

/// Jobs of a periodic task, as others see them.
#[derive(Debug, Clone)]
pub(super) struct Jobs {
    pub(super) period: Ticks,
    /// What each can take of them.
    pub(super) work: u64,
    pub(super) kind: Kind,
    /// Only those count that are released at most so long after the window has begun; `None`: none of these.
    pub(super) released: Option<u64>,
}

/// How the jobs of a task follow each other.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// They end at most so long after their release, before the next one.
    Punctual(u64),
    /// The window can begin with so many that were released before.
    Late(u64),
    /// The window begins at the start of the system, and the first is released so long after that.
    First(u64),
}

impl Jobs {
    /// Releases in a window of this length, its end included, the first of them after `offset`.
    fn releases(&self, window: u64, offset: u64) -> u64 {
        match window.checked_sub(offset) {
            Some(rest) => rest / u64::from(self.period) + 1,
            None => 0,
        }
    }

    /// What they do at most in a window, and how much of it they do at its end: 0 or 1.
    ///
    /// It begins when all the work of a job is still to do, which ends as late as it can: so the next is
    /// released as early as possible. (An earlier window has less of the first job and as much more of the
    /// last one at most.)
    fn demand(&self, window: u64) -> (u64, u64) {
        match self.kind {
            Kind::First(tick) => (self.releases(window, tick).saturating_mul(self.work), 0),
            Kind::Late(carried) => {
                let released = self.released.map_or(0, |it| self.releases(it, 0));
                let count = carried + released.min(self.releases(window, 0));
                (count.saturating_mul(self.work), 0)
            }
            Kind::Punctual(response) => {
                let least = u64::from(self.period) - response;
                let most = self.released.map_or(0, |it| self.releases(it, least));
                let offset = least + self.work;
                let count = most.min(self.releases(window, offset));
                let Some(before) = count.checked_sub(1) else {
                    return (self.work, 0);
                };
                let last = window - offset - before * u64::from(self.period);
                let demand = (1 + before).saturating_mul(self.work);
                (
                    demand.saturating_add(last.min(self.work)),
                    u64::from(last < self.work),
                )
            }
        }
    }

    /// When what they do at the end of a window changes next.
    fn change(&self, window: u64) -> u64 {
        let period = u64::from(self.period);
        let next = |offset: u64| match window.checked_sub(offset) {
            Some(rest) => offset + (rest / period + 1) * period,
            None => offset,
        };
        match self.kind {
            Kind::First(tick) => next(tick),
            Kind::Late(_) => next(0),
            Kind::Punctual(response) => {
                let offset = period - response + self.work;
                next(offset).min(next(offset + self.work))
            }
        }
    }
}

/// Somebody who works for ever, but not without breaks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretches {
    /// The longest work without a break.
    pub(super) work: u64,
    /// The shortest break; `None`: there is only one stretch.
    pub(super) gap: Option<u64>,
}

/// Everything that can keep somebody waiting.
#[derive(Debug, Clone, Default)]
pub(super) struct Demand {
    pub(super) jobs: Vec<Jobs>,
    pub(super) stretches: Vec<Stretches>,
    /// What is done once.
    pub(super) once: u64,
}

impl Demand {
    /// What is done at most in a window, and how much of it at its end.
    fn within(&self, window: u64) -> Option<(u64, u64)> {
        let mut jobs = self.once;
        let mut slope = 0;
        for it in &self.jobs {
            let (demand, at_end) = it.demand(window);
            jobs = jobs.checked_add(demand)?;
            slope += at_end;
        }
        // Somebody has to be at work during every break.
        let mut done = vec![0u64; self.stretches.len()];
        for _ in 0..ROUNDS {
            let all = done.iter().try_fold(jobs, |sum, &it| sum.checked_add(it))?;
            if all > HORIZON {
                return None;
            }
            let stretch = |i: usize| {
                let it = self.stretches[i];
                let breaks = it.gap.map_or(0, |gap| (all - done[i]) / gap);
                it.work.checked_mul(1 + breaks)
            };
            let next: Vec<u64> = (0..done.len()).map(stretch).collect::<Option<_>>()?;
            if next == done {
                return Some((all, slope));
            }
            done = next;
        }
        None
    }

    /// How long so many servers can be busy without a break; `None` where that is not known.
    pub(super) fn longest_busy(&self, servers: u64) -> Option<u64> {
        let mut window = 0;
        for _ in 0..ROUNDS {
            let (demand, slope) = self.within(window)?;
            let next = demand / servers;
            window = if next > window {
                next
            } else if demand + slope < servers.checked_mul(window + 1)? {
                return Some(window);
            } else if slope >= servers {
                let changes = self.jobs.iter().map(|it| it.change(window));
                changes.min().unwrap_or(window + 1)
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
