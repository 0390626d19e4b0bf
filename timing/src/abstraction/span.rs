//! Intervals of times.

/// A time, in base units, that lies between two limits, both included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub(super) struct Span {
    pub(super) from: i64,
    pub(super) to: i64,
}

impl Span {
    pub(super) fn at(time: i64) -> Self {
        Span { from: time, to: time }
    }

    /// Returns the later of two times.
    pub(super) fn max(self, other: Span) -> Self {
        Span { from: self.from.max(other.from), to: self.to.max(other.to) }
    }

    /// Returns the sum of a time and a duration.
    pub(super) fn plus(self, other: Span) -> Self {
        Span { from: self.from + other.from, to: self.to + other.to }
    }

    /// Returns the smallest interval that contains both.
    pub(super) fn hull(self, other: Span) -> Self {
        Span { from: self.from.min(other.from), to: self.to.max(other.to) }
    }

    /// Widens the interval to contain another one. Returns true if it already did.
    pub(super) fn widen(&mut self, other: Span) -> bool {
        let before = *self;
        *self = self.hull(other);
        *self != before
    }

    pub(super) fn shift(&mut self, by: i64) {
        self.from -= by;
        self.to -= by;
    }
}
