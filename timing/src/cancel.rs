//! Ending a verification from outside.

use std::sync::atomic::{AtomicBool, Ordering};

/// Looked at often by everything that can take long.
#[derive(Default)]
pub struct Cancel {
    over: AtomicBool,
    abandoned: AtomicBool,
    ask: Option<Box<dyn Fn() -> bool + Send + Sync>>,
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
        self.over.store(true, Ordering::Release);
    }

    /// Time is up: what was found counts, with the runs that show it.
    pub fn time_out(&self) {
        self.over.store(true, Ordering::Release);
    }

    /// Whether the search has to end.
    pub fn is_over(&self) -> bool {
        self.over.load(Ordering::Acquire) || self.asked()
    }

    /// Whether nobody wants the answer any more.
    pub fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Acquire) || self.asked()
    }

    fn asked(&self) -> bool {
        self.ask.as_ref().is_some_and(|it| it())
    }
}

impl std::fmt::Debug for Cancel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cancel")
            .field("over", &self.over)
            .field("abandoned", &self.abandoned)
            .finish_non_exhaustive()
    }
}
