//! Cancellation of a verification from outside, and its progress.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::ThreadId;
use std::time::{Duration, Instant};

/// A cancellation token. Everything that can take long polls it often.
#[derive(Default)]
pub struct Cancel {
    abandoned: Arc<AtomicBool>,
    interrupt: Interrupt,
    deadline: OnceLock<Deadline>,
    ask: Option<Arc<dyn Fn() -> bool + Send + Sync>>,
    /// Number of states of explorations that have ended.
    before: AtomicUsize,
    /// Explorations under way, each with the thread that reports its progress.
    now: Mutex<Vec<(ThreadId, Effort)>>,
}

/// Ends verifications with the results found so far, including verifications that begin later. Ends a run in
/// order.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<Requests>);

#[derive(Debug, Default)]
struct Requests {
    raised: OnceLock<Instant>,
    forced: AtomicBool,
}

impl Interrupt {
    /// Ends the verifications, as the user has waited long enough; requests the orderly end of a run.
    pub fn raise(&self) {
        self.0.raised.get_or_init(Instant::now);
    }

    /// Also ends what is still under way for an orderly end.
    pub fn force(&self) {
        self.raise();
        self.0.forced.store(true, Ordering::Release);
    }

    /// Returns true after [`raise`](Self::raise).
    pub fn is_raised(&self) -> bool {
        self.0.raised.get().is_some()
    }

    /// Returns true after [`force`](Self::force), or when an orderly end has had this time.
    pub fn is_over(&self, within: Duration) -> bool {
        let late = self.0.raised.get().is_some_and(|at| at.elapsed() >= within);
        late || self.0.forced.load(Ordering::Acquire)
    }
}

struct Deadline {
    after: Duration,
    /// Time of the deadline. `None`: too far in the future to be represented.
    at: Option<Instant>,
}

/// The longest time that the reconstruction of runs may take after the end of the search. It is also limited
/// to a quarter of the time limit.
const MAX_RECONSTRUCTION_TIME: Duration = Duration::from_secs(2);

/// The progress of a verification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effort {
    /// Number of states so far, in all explorations.
    pub states: usize,
    /// Bytes taken by the states of explorations under way.
    pub bytes: usize,
}

impl Cancel {
    /// Returns a token that is also abandoned as soon as `ask` returns true. Every poll of the token calls
    /// `ask`.
    pub fn asking(ask: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Cancel { ask: Some(Arc::new(ask)), ..Cancel::default() }
    }

    /// Abandons the verification: its result is no longer needed.
    pub fn abandon(&self) {
        self.abandoned.store(true, Ordering::Release);
    }

    /// Returns a token that also ends when an interrupt is raised. The results found until then count, with
    /// the runs that show them.
    pub fn interrupted_by(interrupt: &Interrupt) -> Self {
        Cancel { interrupt: interrupt.clone(), ..Cancel::default() }
    }

    /// Returns a token for a part of the work: it is over after a time, counted from now, and whenever this
    /// token is over. The progress of the part is not that of the whole.
    pub fn part(&self, time: Duration) -> Self {
        let part = Cancel {
            abandoned: self.abandoned.clone(),
            interrupt: self.interrupt.clone(),
            ask: self.ask.clone(),
            ..Cancel::default()
        };
        let end = self.deadline.get().and_then(|deadline| deadline.at);
        let left = end.map(|end| end.saturating_duration_since(Instant::now()));
        part.limit(left.map_or(time, |left| left.min(time)));
        part
    }

    /// Returns true if the verification was interrupted.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.interrupt.is_raised()
    }

    /// Sets the time limit, counted from now. The results found until then count, with the runs that show
    /// them. Only the first call has an effect.
    pub fn limit(&self, time: Duration) {
        self.deadline
            .get_or_init(|| Deadline { after: time, at: Instant::now().checked_add(time) });
    }

    pub fn time_limit(&self) -> Option<Duration> {
        self.deadline.get().map(|deadline| deadline.after)
    }

    /// Returns true if the search has to end.
    pub fn is_over(&self) -> bool {
        self.is_abandoned() || self.is_interrupted() || self.is_after(Duration::ZERO)
    }

    /// Returns true if even the reconstruction of runs has to end.
    pub(crate) fn is_too_late(&self) -> bool {
        let interrupted = self.interrupt.0.raised.get();
        let limit = self.time_limit().unwrap_or_default();
        self.is_abandoned()
            || interrupted.is_some_and(|instant| instant.elapsed() >= MAX_RECONSTRUCTION_TIME)
            || self.is_after(MAX_RECONSTRUCTION_TIME.min(limit / 4))
    }

    /// Returns true if the time limit was reached at least `grace` ago.
    fn is_after(&self, grace: Duration) -> bool {
        let at = self.deadline.get().and_then(|deadline| deadline.at);
        let at = at.and_then(|deadline| deadline.checked_add(grace));
        at.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Returns true if the result is no longer needed.
    pub fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Acquire) || self.ask.as_ref().is_some_and(|ask| ask())
    }

    /// Returns the progress of the verification.
    pub fn effort(&self) -> Effort {
        let so_far = Effort { states: self.before.load(Ordering::Relaxed), bytes: 0 };
        let now = self.now();
        now.iter().fold(so_far, |sum, (_, effort)| Effort {
            states: sum.states + effort.states,
            bytes: sum.bytes + effort.bytes,
        })
    }

    /// Records the progress of an exploration under way. Each exploration calls it from a thread of its own.
    pub(crate) fn at_work(&self, states: usize, bytes: usize) {
        let (own, effort) = (std::thread::current().id(), Effort { states, bytes });
        let mut now = self.now();
        match now.iter_mut().find(|entry| entry.0 == own) {
            Some(pair) => pair.1 = effort,
            None => now.push((own, effort)),
        }
    }

    /// Records the states of an exploration that has ended.
    pub(crate) fn ended(&self, states: usize) {
        let own = std::thread::current().id();
        self.now().retain(|entry| entry.0 != own);
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
