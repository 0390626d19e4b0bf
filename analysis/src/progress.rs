//! How far a long question is, for whoever waits for its answer.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts parts of the work. Whoever works adds, whoever waits looks; neither waits for the other.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicUsize,
    known: AtomicUsize,
}

impl Progress {
    /// Some more parts are to be done.
    pub fn expect(&self, parts: usize) {
        self.known.fetch_add(parts, Ordering::Relaxed);
    }

    /// One more is done.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// How many parts are done, and how many are known of. The second may still grow.
    pub fn parts(&self) -> (usize, usize) {
        let known = self.known.load(Ordering::Relaxed);
        (self.done.load(Ordering::Relaxed).min(known), known)
    }
}
