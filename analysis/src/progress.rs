//! The progress of a long query.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts parts of the work. The worker adds, the client reads; neither blocks the other.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicUsize,
    known: AtomicUsize,
}

impl Progress {
    /// Adds this many parts to the total.
    pub fn expect(&self, parts: usize) {
        self.known.fetch_add(parts, Ordering::Relaxed);
    }

    /// Marks one part as done.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// The number of done parts, and the known total. The total may still grow.
    pub fn parts(&self) -> (usize, usize) {
        let known = self.known.load(Ordering::Relaxed);
        (self.done.load(Ordering::Relaxed).min(known), known)
    }
}
