//! The ticks of a periodic task, inferred from the beginnings of its turns.
//!
//! Tick number *i* comes at *a* + *iP*. Its turn begins at a time *sᵢ*, at most *L* later: the greatest
//! response time, or the period. So *a* lies in [*sᵢ* - *iP* - *L*, *sᵢ* - *iP*] for every *i*. If these
//! intervals have no common moment, the ticks are not *P* apart.

use super::CLOCK_TOLERANCE_NANOS;
use super::DeviationKind;

/// Number of irregular turns allowed at the start: the timer counts while the server starts.
const MAX_IRREGULAR_TURNS: u64 = 2;

/// The known ticks of a task.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TickPhase {
    turns: u64,
    /// Phase of the ticks, counted from turn 0.
    known: Option<Phase>,
}

#[derive(Debug, Clone, Copy)]
struct Phase {
    /// Number of the last turn.
    number: i64,
    /// Lower limit of the time of tick 0, in nanoseconds.
    earliest: i64,
    /// Upper limit of the time of tick 0, in nanoseconds.
    latest: i64,
}

impl TickPhase {
    /// Records the beginning of a turn, with times in nanoseconds. Returns the deviation, if there is one.
    pub(super) fn begins(&mut self, at: i64, period: i64, latest: i64) -> Option<DeviationKind> {
        self.turns += 1;
        if self.turns <= MAX_IRREGULAR_TURNS {
            return None;
        }
        let fresh = Phase { number: 0, earliest: at.saturating_sub(latest), latest: at };
        let Some(known) = &mut self.known else {
            self.known = Some(fresh);
            return None;
        };
        known.number += 1;
        let ticks = known.number.saturating_mul(period);
        let (earliest, last) =
            (at.saturating_sub(ticks).saturating_sub(latest), at.saturating_sub(ticks));
        known.earliest = known.earliest.max(earliest);
        known.latest = known.latest.min(last);
        let off = known.earliest - known.latest;
        if off <= CLOCK_TOLERANCE_NANOS {
            return None;
        }
        let what = if known.latest == last {
            DeviationKind::Early { by: off, period }
        } else {
            DeviationKind::Late { by: off, period }
        };
        self.known = Some(fresh);
        Some(what)
    }

    /// Returns a time in nanoseconds at which the tick of the last turn has certainly come.
    pub(super) fn tick(&self, period: i64) -> Option<i64> {
        let known = self.known?;
        Some(known.latest.saturating_add(known.number.saturating_mul(period)))
    }
}
