//! Ending a verification from outside, and seeing from there how far it is.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

/// Looked at often by everything that can take long.
#[derive(Default)]
pub struct Cancel {
    abandoned: AtomicBool,
    interrupt: Interrupt,
    deadline: OnceLock<Deadline>,
    ask: Option<Box<dyn Fn() -> bool + Send + Sync>>,
    /// States of explorations that have ended.
    before: AtomicUsize,
    /// Those at work, each with the thread that tells of it.
    now: Mutex<Vec<(ThreadId, Effort)>>,
}

/// Ends verifications with what is known so far, those that begin later as well.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<OnceLock<Instant>>);

impl Interrupt {
    /// Whoever waits has waited long enough.
    pub fn raise(&self) {
        self.0.get_or_init(Instant::now);
    }

    /// Whether it was raised.
    pub fn is_raised(&self) -> bool {
        self.0.get().is_some()
    }
}

struct Deadline {
    after: Duration,
    /// `None`: beyond all times.
    at: Option<Instant>,
}

/// When the search is over, the runs that show what was found are looked for so long at most; and not longer
/// than a quarter of the time there was.
const GRACE: Duration = Duration::from_secs(2);

/// How far a verification is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effort {
    /// States so far, in all explorations.
    pub states: usize,
    /// Bytes that the states of those at work take.
    pub bytes: usize,
}

impl Cancel {
    /// One that is also abandoned as soon as `ask` says so. It is asked at every look.
    pub fn asking(ask: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Cancel {
            ask: Some(Box::new(ask)),
            ..Cancel::default()
        }
    }

    /// Nobody wants the answer any more.
    pub fn abandon(&self) {
        self.abandoned.store(true, Ordering::Release);
    }

    /// One that also ends when an interrupt is raised: what was found until then counts, with the runs that
    /// show it.
    pub fn interrupted_by(interrupt: &Interrupt) -> Self {
        Cancel {
            interrupt: interrupt.clone(),
            ..Cancel::default()
        }
    }

    /// Whether it was interrupted.
    pub fn is_interrupted(&self) -> bool {
        self.interrupt.is_raised()
    }

    /// Time is up so long from now on: what was found until then counts, with the runs that show it. Only the
    /// first limit counts.
    pub fn limit(&self, time: Duration) {
        self.deadline.get_or_init(|| Deadline {
            after: time,
            at: Instant::now().checked_add(time),
        });
    }

    /// The time that was given.
    pub fn time_limit(&self) -> Option<Duration> {
        self.deadline.get().map(|it| it.after)
    }

    /// Whether the search has to end.
    pub fn is_over(&self) -> bool {
        self.is_abandoned() || self.is_interrupted() || self.is_after(Duration::ZERO)
    }

    /// Whether even the runs that show what was found are not to be looked for any more.
    pub(crate) fn is_too_late(&self) -> bool {
        let interrupted = self.interrupt.0.get();
        let limit = self.time_limit().unwrap_or_default();
        self.is_abandoned()
            || interrupted.is_some_and(|it| it.elapsed() >= GRACE)
            || self.is_after(GRACE.min(limit / 4))
    }

    /// Whether time has been up for so long.
    fn is_after(&self, grace: Duration) -> bool {
        let at = self.deadline.get().and_then(|it| it.at);
        let at = at.and_then(|it| it.checked_add(grace));
        at.is_some_and(|it| Instant::now() >= it)
    }

    /// Whether nobody wants the answer any more.
    pub fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Acquire) || self.ask.as_ref().is_some_and(|it| it())
    }

    /// How far it is, for whoever waits.
    pub fn effort(&self) -> Effort {
        let so_far = Effort {
            states: self.before.load(Ordering::Relaxed),
            bytes: 0,
        };
        let now = self.now();
        now.iter().fold(so_far, |sum, (_, it)| Effort {
            states: sum.states + it.states,
            bytes: sum.bytes + it.bytes,
        })
    }

    /// Told by an exploration at work, always by the same thread.
    pub(crate) fn at_work(&self, states: usize, bytes: usize) {
        let (own, effort) = (std::thread::current().id(), Effort { states, bytes });
        let mut now = self.now();
        match now.iter_mut().find(|it| it.0 == own) {
            Some(it) => it.1 = effort,
            None => now.push((own, effort)),
        }
    }

    /// Told by an exploration that has ended.
    pub(crate) fn ended(&self, states: usize) {
        let own = std::thread::current().id();
        self.now().retain(|it| it.0 != own);
        self.before.fetch_add(states, Ordering::Relaxed);
    }

    fn now(&self) -> MutexGuard<'_, Vec<(ThreadId, Effort)>> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl std::fmt::Debug for Cancel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cancel")
            .field("abandoned", &self.abandoned)
            .field("limit", &self.time_limit())
            .finish_non_exhaustive()
    }
}
